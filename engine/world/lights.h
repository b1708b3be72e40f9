#ifndef PM_WORLD_LIGHTS_H
#define PM_WORLD_LIGHTS_H

#include "world/material.h"
#include "world/sky.h"

/* The table of lights, shared by light.c, light_emit.c and light_sample.c. */

#define PM_NO_LIGHT 0xFFFFFFFFU

struct pm_light {
    uint32_t surface; /* PM_NO_PRIMITIVE: a distant source */
    uint32_t distant;
    uint32_t material;
    double chance; /* of being picked by power */
};

struct pm_lights {
    size_t count;
    struct pm_light *lights; /* surfaces in the world's order, then distant sources in theirs */
    double *cumulative;      /* [count] chances of lights 0..i; the last is 1 */
    uint32_t *of_surface;    /* [shape_count]: the light of a surface, or PM_NO_LIGHT */
    uint32_t *of_distant;    /* [distant_count] likewise */
    pm_rgb power;            /* of all */
    pm_vec3 center;          /* of the scene's bounding sphere */
    double radius;
    struct pm_sky_index *sky;
};

uint32_t pm_lights_pick(const struct pm_lights *lights, double u);

/* Of a lamp's front towards `direction`, into a point at that distance. */
pm_rgb pm_lights_radiance(const struct pm_material *lamp, pm_vec3 direction, double distance);

double pm_lights_focus_share(double focus, double distance);
bool pm_lights_is_weak(const struct pm_material *lamp);

/* What the distant sources show in a direction, illums apart. */
struct pm_sky {
    pm_rgb lights, glows, seen_glows; /* seen: of negative radius */
    bool lit;                         /* a light is there, and hides the glows */
    double pdf;                       /* of pm_light_sample_at */
};

struct pm_sky pm_lights_sky(const pm_world *world, pm_vec3 direction);

/* Density with which a distant source is picked and its direction drawn, for next events. */
double pm_lights_distant_pdf(const pm_world *world, uint32_t light);

/* Chance with which a light is picked for next events. */
double pm_lights_chance(const struct pm_lights *lights, uint32_t light);

#endif
