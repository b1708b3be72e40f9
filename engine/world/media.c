#include "world/media.h"

#include "base/maths.h"
#include "base/warp.h"
#include "world/material.h"
#include "world/rays.h"

/* ---- the list of volumes ---- */

/* The material whose volume a surface bounds: an illum may stand for a dielectric. */
static uint32_t volume_of(const pm_world *world, uint32_t material)
{
    const struct pm_material *m = &world->materials[material];
    bool replaced = m->type == PM_ILLUM || m->type == PM_MIRROR;
    return replaced && m->alternate != PM_NO_PRIMITIVE ? m->alternate : material;
}

static void enter(pm_media *media, uint32_t material)
{
    if (media->count < PM_MEDIA_MAX)
        media->material[media->count++] = material;
}

/* The last entry of a material, or -1. */
static int find(const pm_media *media, uint32_t material)
{
    int i = media->count - 1;
    while (i >= 0 && media->material[i] != material)
        i--;
    return i;
}

static void leave(pm_media *media, uint32_t material)
{
    int i = find(media, material);
    if (i < 0)
        return;
    for (media->count--; i < media->count; i++)
        media->material[i] = media->material[i + 1];
}

/* ---- dense media ----
 *
 * A dielectric's outside is empty space, an interface's another dense medium. Whoever goes
 * through an interface changes one for the other; in between, boundaries of either may come
 * (water in a glass: interface below, dielectrics above and around). So the innermost dense
 * entry is what counts, whichever boundary it is of. */

static bool is_dense(const pm_world *world, uint32_t material)
{
    pm_primitive_type type = world->materials[material].type;
    return type == PM_DIELECTRIC || type == PM_INTERFACE;
}

/* Entered through an interface, from either side. */
static bool is_relative(const pm_world *world, uint32_t material)
{
    const struct pm_material *m = &world->materials[material];
    return m->type == PM_INTERFACE || m->stands_outside;
}

/* The last dense entry, or -1. */
static int find_dense(const pm_media *media, const pm_world *world)
{
    int i = media->count - 1;
    while (i >= 0 && !is_dense(world, media->material[i]))
        i--;
    return i;
}

static void enter_instead(pm_media *media, int i, uint32_t material)
{
    if (i < 0)
        enter(media, material);
    else
        media->material[i] = material;
}

/* From the front of an interface to its back, or the other way. */
static void cross_interface(pm_media *media, const pm_world *world, uint32_t material,
                            bool inwards)
{
    uint32_t outside = world->materials[material].outside;
    int dense = find_dense(media, world), own = find(media, material);
    if (inwards && outside == PM_NO_PRIMITIVE)
        enter(media, material);
    else if (inwards)
        enter_instead(media, dense, material);
    else if (outside != PM_NO_PRIMITIVE)
        enter_instead(media, own >= 0 ? own : dense, outside);
    else
        leave(media, own >= 0 || dense < 0 ? material : media->material[dense]);
}

/* Out of a dielectric, into empty space or what is around it. */
static void leave_dielectric(pm_media *media, const pm_world *world, uint32_t material)
{
    int dense = find_dense(media, world);
    if (find(media, material) < 0 && dense >= 0 && is_relative(world, media->material[dense]))
        material = media->material[dense];
    leave(media, material);
}

void pm_media_meet(pm_media *media, const pm_world *world, const pm_hit *hit, pm_vec3 direction)
{
    if (!world->has_media)
        return;
    uint32_t material = volume_of(world, hit->material);
    const struct pm_material *m = &world->materials[material];
    bool behind = pm_vec3_dot(direction, hit->normal) >= 0;
    if (!behind && m->type == PM_INTERFACE && m->outside != PM_NO_PRIMITIVE &&
        find_dense(media, world) < 0)
        enter(media, m->outside);
    if (!behind || find(media, material) >= 0)
        return;
    int dense = find_dense(media, world);
    bool changes =
        m->type == PM_INTERFACE || (dense >= 0 && is_relative(world, media->material[dense]));
    if (is_dense(world, material) && changes)
        enter_instead(media, dense, material);
    else if (is_dense(world, material) || m->type == PM_MIST)
        enter(media, material);
}

void pm_media_cross(pm_media *media, const pm_world *world, const pm_hit *hit,
                    pm_vec3 direction)
{
    if (!world->has_media)
        return;
    uint32_t material = volume_of(world, hit->material);
    if (!world->materials[material].bounds_volume)
        return;
    bool inwards = pm_vec3_dot(direction, hit->normal) < 0;
    if (world->materials[material].type == PM_INTERFACE)
        cross_interface(media, world, material, inwards);
    else if (inwards)
        enter(media, material);
    else
        leave_dielectric(media, world, material);
}

/* ---- the volumes at a point ---- */

/* What a ray that comes to a boundary was in without having entered it; PM_NO_PRIMITIVE:
 * nothing new. */
static uint32_t unentered(const pm_media *entered, const pm_world *world, uint32_t material,
                          bool inwards)
{
    const struct pm_material *m = &world->materials[material];
    int dense = find_dense(entered, world);
    if (inwards)
        return m->type == PM_INTERFACE && dense < 0 ? m->outside : PM_NO_PRIMITIVE;
    bool known = find(entered, material) >= 0 ||
                 (dense >= 0 && is_dense(world, material) &&
                  (m->type == PM_INTERFACE || is_relative(world, entered->material[dense])));
    return known ? PM_NO_PRIMITIVE : material;
}

/* Volumes that a ray leaves without having entered them, the innermost first. */
static void left_along(const pm_world *world, pm_vec3 point, pm_vec3 direction, pm_media *left)
{
    pm_media entered = {0};
    left->count = 0;
    pm_ray ray = {point, direction, INFINITY, PM_NO_PRIMITIVE};
    struct pm_ray_walk walk = {0};
    pm_hit hit;
    while (pm_rays_next(world, &ray, &walk, &hit)) {
        uint32_t material = volume_of(world, hit.material);
        if (!world->materials[material].bounds_volume)
            continue;
        uint32_t was_in =
            unentered(&entered, world, material, pm_vec3_dot(direction, hit.normal) < 0);
        if (was_in != PM_NO_PRIMITIVE)
            enter(left, was_in);
        pm_media_cross(&entered, world, &hit, direction);
    }
}

static bool same_volumes(const pm_media *a, const pm_media *b)
{
    if (a->count != b->count)
        return false;
    for (int i = 0; i < a->count; i++)
        if (a->material[i] != b->material[i])
            return false;
    return true;
}

void pm_media_at(const pm_world *world, pm_vec3 point, pm_media *out)
{
    out->count = 0;
    if (!world->has_media)
        return;
    /* A ray through an edge may count a boundary twice or not at all: two of three odd
     * directions must agree. */
    static const pm_vec3 directions[3] = {{.5395104, .3026139, .7857297},
                                          {-.7317652, .5893411, .3425193},
                                          {.1948271, -.8615383, -.4688237}};
    pm_media left[3];
    int agreed = 0;
    for (int i = 0; i < 3; i++) {
        left_along(world, point, pm_vec3_normalize(directions[i]), &left[i]);
        if (i == 1 && same_volumes(&left[0], &left[1]))
            break;
        if (i == 2 && same_volumes(&left[1], &left[2]))
            agreed = 1;
    }
    for (int i = left[agreed].count; i-- > 0;)
        enter(out, left[agreed].material[i]);
}

/* ---- what they are together ---- */

/* The first of the volumes that count: the innermost visible dielectric, or all. */
static int innermost_dielectric(const pm_media *media, const pm_world *world)
{
    int i = media->count - 1;
    while (i > 0 && (!is_dense(world, media->material[i]) ||
                     pm_material_is_hidden(world, media, media->material[i])))
        i--;
    return i < 0 ? 0 : i;
}

static pm_rgb ratio(pm_rgb part, pm_rgb whole)
{
    return (pm_rgb){whole.r > 0 ? part.r / whole.r : 0, whole.g > 0 ? part.g / whole.g : 0,
                    whole.b > 0 ? part.b / whole.b : 0};
}

/* `share` holds scattering coefficients until the sum is known. */
static void add_phase(pm_medium *medium, double g, pm_rgb scattering)
{
    unsigned i = 0;
    if (pm_rgb_is_black(scattering))
        return;
    while (i < medium->phases && medium->phase[i].g != g)
        i++;
    if (i == medium->phases)
        medium->phase[medium->phases++] = (struct pm_phase_part){.g = g};
    medium->phase[i].share = pm_rgb_add(medium->phase[i].share, scattering);
}

bool pm_media_medium(const pm_media *media, const pm_world *world, pm_medium *out)
{
    pm_rgb extinction = {0, 0, 0}, scattering = {0, 0, 0};
    out->phases = 0;
    for (int i = innermost_dielectric(media, world); i < media->count; i++) {
        const struct pm_material *m = &world->materials[media->material[i]];
        if (pm_material_is_hidden(world, media, media->material[i]))
            continue;
        extinction = pm_rgb_add(extinction, m->extinction);
        scattering = pm_rgb_add(scattering, m->scattering);
        add_phase(out, m->g, m->scattering);
    }
    for (unsigned i = 0; i < out->phases; i++)
        out->phase[i].share = ratio(out->phase[i].share, scattering);
    out->extinction = extinction;
    out->albedo = ratio(scattering, extinction);
    return !pm_rgb_is_black(extinction);
}

static double attenuation(double extinction, double length)
{
    return extinction > 0 ? pm_exp(-extinction * length) : 1;
}

pm_rgb pm_medium_transmittance(const pm_medium *medium, double length)
{
    return (pm_rgb){attenuation(medium->extinction.r, length),
                    attenuation(medium->extinction.g, length),
                    attenuation(medium->extinction.b, length)};
}

/* ---- phase function: Henyey and Greenstein, Astrophys. J. 93, 1941, eq. 2 ---- */

double pm_phase(double g, double cosine)
{
    double square = (1 - g) * (1 - g) + 2 * g * (1 - cosine);
    return (1 - g) * (1 + g) / (4 * PM_PI * square * sqrt(square));
}

/* The inverse of the cumulative distribution, with s = 2 u - 1:
 * 1 - cos = (1 - g)^2 (1 - s) (2 + g (1 + s)) / (2 (1 + g s)^2). No term cancels, at g = 0 or
 * near 1. */
pm_vec3 pm_phase_sample(double g, pm_vec3 direction, double u, double v)
{
    double s = 2 * u - 1, spread = (1 - g) / (1 + g * s);
    double versine = spread * spread * (1 - u) * (2 + g * (1 + s));
    versine = fmin(versine, 2);
    double sine, cosine, radius = sqrt(versine * (2 - versine));
    pm_sincos(2 * PM_PI * v, &sine, &cosine);
    pm_frame frame = pm_frame_make(direction);
    pm_vec3 local = {radius * cosine, radius * sine, 1 - versine};
    return pm_vec3_normalize(pm_frame_to_world(&frame, local));
}

pm_rgb pm_medium_phase(const pm_medium *medium, double cosine)
{
    pm_rgb sum = {0, 0, 0};
    for (unsigned i = 0; i < medium->phases; i++)
        sum = pm_rgb_madd(sum, pm_phase(medium->phase[i].g, cosine), medium->phase[i].share);
    return sum;
}

/* Light of that flux that the part scatters. */
static double part_flux(const pm_medium *medium, unsigned i, pm_rgb flux)
{
    pm_rgb part = pm_rgb_mul(flux, medium->phase[i].share);
    return part.r + part.g + part.b;
}

/* A part drawn in proportion to the light that it scatters: the balance heuristic over parts
 * and channels at once (Veach 1997, 9.2.4). */
pm_vec3 pm_medium_scatter(const pm_medium *medium, pm_rgb flux, pm_vec3 direction,
                          const double u[3], pm_rgb *weight)
{
    unsigned chosen = 0;
    *weight = (pm_rgb){1, 1, 1};
    if (medium->phases < 2)
        return pm_phase_sample(medium->phases ? medium->phase[0].g : 0, direction, u[1], u[2]);
    double sum = 0, density = 0;
    for (unsigned i = 0; i < medium->phases; i++)
        sum += part_flux(medium, i, flux);
    double x = u[0] * sum;
    while (chosen + 1 < medium->phases && x >= part_flux(medium, chosen, flux))
        x -= part_flux(medium, chosen++, flux);
    pm_vec3 to = pm_phase_sample(medium->phase[chosen].g, direction, u[1], u[2]);
    double cosine = pm_vec3_dot(direction, to);
    for (unsigned i = 0; i < medium->phases; i++)
        density += part_flux(medium, i, flux) / sum * pm_phase(medium->phase[i].g, cosine);
    if (sum > 0 && density > 0)
        *weight = pm_rgb_scale(pm_medium_phase(medium, cosine), 1 / density);
    return to;
}
