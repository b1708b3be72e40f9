#ifndef PM_WORLD_LIGHTS_H
#define PM_WORLD_LIGHTS_H

#include "world/light_pattern.h"
#include "world/material.h"
#include "world/sky.h"

/* The table of lights, shared by light.c, light_emit.c, light_sample.c and light_shine.c. */

#define PM_NO_LIGHT 0xFFFFFFFFU

struct pm_light {
    uint32_t surface; /* PM_NO_PRIMITIVE: a distant source */
    uint32_t distant;
    uint32_t material;
    double chance;                          /* of being picked by power */
    const struct pm_light_pattern *pattern; /* NULL: radiance is the same all over */
};

struct pm_lights {
    size_t count;
    struct pm_light *lights; /* surfaces in the world's order, then distant sources in theirs */
    double *cumulative;      /* [count] chances of lights 0..i; the last is 1 */
    uint32_t *of_surface;    /* [shape_count]: the light of a surface, or PM_NO_LIGHT */
    uint32_t *of_distant;    /* [distant_count] likewise */
    bool *shows;             /* [material_count]: is a lamp, or may show one: illum, mixture */
    size_t patterned;        /* lights with a pattern */
    pm_rgb power;            /* of all; of patterns by quadrature */
    pm_vec3 center;          /* of the scene's bounding sphere */
    double radius;
    struct pm_sky_index *sky;
};

/* Where light of distant sources starts, over the centre: beyond every surface. */
static inline double pm_lights_height(const struct pm_lights *lights)
{
    return lights->radius * (1 + 0x1p-10);
}

uint32_t pm_lights_pick(const struct pm_lights *lights, double u);

/* The first of the lights whose cumulative chance exceeds u. */
uint32_t pm_lights_search(const double *cumulative, size_t count, double u);

/* Chance with which a light is picked for next events. */
double pm_lights_chance(const struct pm_lights *lights, uint32_t light);

/* The light of a surface, also one of an instance; or PM_NO_LIGHT. */
uint32_t pm_lights_of_surface(const pm_world *world, uint32_t surface);

/* ---- what a light shows (light_shine.c) ---- */

/* Radiance that leaves a lamp's front along wo: colour times patterns, within a spotlight's
 * cone; where a pattern is negative, none. hit->t is the
 * distance that patterns see. Source: Radiance's m_light (source.c). */
pm_rgb pm_lights_shine(const pm_world *world, const pm_hit *hit, pm_vec3 wo);

/* The same for a distant source, seen in a direction. */
pm_rgb pm_lights_shine_far(const pm_world *world, uint32_t distant, pm_vec3 direction);

/* A direction of a lamp's light at a place with that normal: within a spotlight's cone, else by
 * the cosine. The mean of `weight` over u, v is the projected solid angle. */
pm_vec3 pm_lights_direction(const struct pm_material *lamp, pm_vec3 normal, double u, double v,
                            double *weight);

/* Whether a lamp's radiance is not the same all over. */
bool pm_lights_is_patterned(const struct pm_material *lamp);

double pm_lights_focus_share(double focus, double distance);
bool pm_lights_is_weak(const struct pm_material *lamp);

/* What the distant sources show in a direction, illums apart. */
struct pm_sky {
    pm_rgb lights, glows, seen_glows; /* seen: of negative radius, if asked for */
    bool lit;                         /* a light is there, and hides the glows */
    double pdf;                       /* of pm_light_sample_at */
};

struct pm_sky pm_lights_sky(const pm_world *world, pm_vec3 direction, bool seen);

/* Whether a light is there, and hides the glows. */
bool pm_lights_is_lit(const pm_world *world, pm_vec3 direction);

/* Density with which a distant source is picked and a direction that it covers drawn, for next
 * events. */
double pm_lights_distant_pdf(const pm_world *world, uint32_t light, pm_vec3 direction);

#endif
