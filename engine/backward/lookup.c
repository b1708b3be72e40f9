#include "backward/backward_internal.h"
#include "base/warp.h"
#include "photons/precompute.h"

/* ---- which maps count where ---- */

/* [world units] for a progressive pass that has seen too few photons to know better. */
#define UNKNOWN_RADIUS 0x1p-4

static bool is_valid(const pm_backward_maps *maps, pm_map_kind kind)
{
    double radius = maps->radius[kind];
    uint32_t count = maps->gather_count[kind];
    if (!maps->map[kind] || !pm_photon_map_count(maps->map[kind]))
        return true;
    uint32_t most = maps->gather_max[kind];
    if (radius == 0)
        return maps->progressive || (count > 0 && count <= PM_GATHER_MAX &&
                                     (!most || (most > count && most <= PM_GATHER_MAX)));
    return radius > 0 && isfinite(radius);
}

static double radius_of(const pm_backward_maps *maps, pm_map_kind kind)
{
    pm_map_kind other = kind == PM_MAP_GLOBAL ? PM_MAP_CAUSTIC : PM_MAP_GLOBAL;
    if (!maps->progressive || maps->radius[kind] > 0)
        return maps->radius[kind];
    return kind != PM_MAP_VOLUME && maps->radius[other] > 0 ? maps->radius[other]
                                                            : UNKNOWN_RADIUS;
}

static bool is_precomputed(const pm_backward_maps *maps, pm_map_kind kind)
{
    return maps->map[kind] && pm_photon_map_header(maps->map[kind])->kind == PM_MAP_PRECOMPUTED;
}

static struct pm_lookup make_lookup(const pm_backward_maps *maps, pm_map_kind held,
                                    pm_map_kind kind, pm_photon_filter filter)
{
    return (struct pm_lookup){
        .map = maps->map[held],
        .precomputed = is_precomputed(maps, held),
        .radius = radius_of(maps, kind),
        .gather_count = maps->gather_count[kind],
        .range = {maps->gather_count[kind], maps->gather_max[kind], maps->bandwidth[kind]},
        .filter = filter};
}

static bool is_asked(const struct pm_lookup *lookup)
{
    return lookup->map && pm_photon_map_count(lookup->map);
}

static void add_lookup(struct pm_vertex_rule *rule, struct pm_lookup lookup)
{
    if (is_asked(&lookup))
        rule->lookups[rule->lookup_count++] = lookup;
}

/* Paths whose last event was specular: the caustic map, or in a progressive pass their share of
 * the global map. */
static void add_caustics(struct pm_vertex_rule *rule, const pm_backward_maps *maps)
{
    if (maps->map[PM_MAP_CAUSTIC])
        add_lookup(rule, make_lookup(maps, PM_MAP_CAUSTIC, PM_MAP_CAUSTIC, PM_PHOTONS_ALL));
    else if (maps->progressive)
        add_lookup(rule, make_lookup(maps, PM_MAP_GLOBAL, PM_MAP_CAUSTIC, PM_PHOTONS_SPECULAR));
}

/* All indirect light, the caustics from their own map if there is one. */
static void add_indirect(struct pm_vertex_rule *rule, const pm_backward_maps *maps)
{
    bool apart = (maps->map[PM_MAP_CAUSTIC] && !is_precomputed(maps, PM_MAP_GLOBAL)) ||
                 maps->progressive;
    add_lookup(rule, make_lookup(maps, PM_MAP_GLOBAL, PM_MAP_GLOBAL,
                                 apart ? PM_PHOTONS_NOT_SPECULAR : PM_PHOTONS_ALL));
    if (apart)
        add_caustics(rule, maps);
}

pm_status pm_pass_init(struct pm_pass *pass, const pm_world *world,
                       const pm_backward_maps *maps, pm_error *err)
{
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        if (!is_valid(maps, (pm_map_kind)kind))
            return pm_error_set(err, PM_E_RANGE,
                                "the %s map has neither a radius nor a number of "
                                "photons, 1 to %d, to look for",
                                pm_map_kind_name((pm_map_kind)kind), PM_GATHER_MAX);
    *pass = (struct pm_pass){.world = world, .shared = !maps->progressive};
    struct pm_vertex_rule *eye = &pass->rules[PM_VERTEX_EYE];
    struct pm_vertex_rule *gather = &pass->rules[PM_VERTEX_GATHER];
    struct pm_vertex_rule *sensor = &pass->rules[PM_VERTEX_SENSOR];
    eye->gather = maps->ambient_bounces > 0 && !maps->progressive;
    eye->through_specular = true;
    if (maps->ambient_bounces == 0 || eye->gather)
        add_caustics(eye, maps);
    else
        add_indirect(eye, maps);
    add_lookup(gather, make_lookup(maps, PM_MAP_GLOBAL, PM_MAP_GLOBAL, PM_PHOTONS_ALL));
    gather->through_specular = !maps->map[PM_MAP_CAUSTIC];
    add_indirect(sensor, maps);
    sensor->through_specular = true;
    sensor->after_specular = maps->ambient_bounces == 0;
    struct pm_lookup volume = make_lookup(maps, PM_MAP_VOLUME, PM_MAP_VOLUME, PM_PHOTONS_ALL);
    if (is_asked(&volume))
        pass->volume = volume;
    return PM_OK;
}

/* ---- asking them ---- */

/* What photons are weighed by. */
struct weighing {
    const struct pm_pass *pass;
    const struct pm_spot *spot;
    pm_vec3 normal;
    bool uniform;
    const pm_between *walls; /* NULL: none */
};

static pm_rgb photon_weight(const void *context, const pm_photon *photon)
{
    const struct weighing *w = context;
    if (w->walls && !pm_sees(w->pass, w->spot, w->walls, w->normal, pm_photon_position(photon),
                             pm_photon_normal(photon)))
        return pm_rgb_grey(0);
    if (w->uniform)
        return pm_rgb_grey(1);
    return pm_surface_photon_weight(w->spot->surface, pm_photon_direction(photon));
}

/* `weight` NULL: 1 */
static pm_estimate ask(const struct pm_lookup *lookup, pm_vec3 point, pm_vec3 normal,
                       const pm_photon_weight *weight)
{
    if (lookup->radius > 0)
        return pm_photon_map_within(lookup->map, point, normal, lookup->radius, lookup->filter,
                                    weight);
    if (lookup->range.most)
        return pm_photon_map_adapted(lookup->map, point, normal, &lookup->range, lookup->filter,
                                     weight);
    return pm_photon_map_nearest(lookup->map, point, normal, lookup->gather_count, INFINITY,
                                 lookup->filter, weight);
}

/* The closest photon in sight, as those that are asked come by. */
struct closest {
    double distance2;
    pm_photon photon;
};

struct seeking {
    const struct weighing *weighing;
    struct closest *closest;
};

static pm_rgb take_closest(const void *context, const pm_photon *photon)
{
    const struct seeking *seeking = context;
    const struct weighing *w = seeking->weighing;
    pm_vec3 place = pm_photon_position(photon);
    pm_vec3 way = pm_vec3_sub(place, w->spot->point);
    double distance2 = pm_vec3_dot(way, way);
    if (distance2 < seeking->closest->distance2 &&
        pm_sees(w->pass, w->spot, w->walls, w->normal, place, pm_photon_normal(photon)))
        *seeking->closest = (struct closest){distance2, *photon};
    return pm_rgb_grey(0);
}

pm_estimate pm_lookup_closest(const struct pm_pass *pass, const struct pm_waiting *waiting,
                              size_t index)
{
    enum { ASKED = 16 };
    const pm_photon_map *map = waiting->lookup->map;
    const struct pm_spot *spot = &waiting->spot;
    pm_between walls;
    const struct weighing weighing = {pass, spot, waiting->normal, true, &walls};
    struct closest closest = {.distance2 = INFINITY};
    const struct seeking seeking = {&weighing, &closest};
    if (index == SIZE_MAX)
        return (pm_estimate){.count = 0};
    pm_photon photon;
    pm_photon_map_photon(map, index, &photon);
    pm_vec3 place = pm_photon_position(&photon);
    double distance = pm_vec3_distance(place, spot->point);
    if (!(distance > 0) || !pm_walls_near(pass, spot, waiting->normal, distance, &walls) ||
        pm_sees(pass, spot, &walls, waiting->normal, place, pm_photon_normal(&photon)))
        return pm_precomputed_estimate(map, &photon);
    pm_photon_map_nearest(map, spot->point, waiting->normal, ASKED, INFINITY, PM_PHOTONS_ALL,
                          &(pm_photon_weight){take_closest, &seeking});
    return isfinite(closest.distance2) ? pm_precomputed_estimate(map, &closest.photon)
                                       : (pm_estimate){.count = 0};
}

static pm_estimate ask_precomputed(const struct pm_pass *pass, const struct pm_waiting *waiting)
{
    size_t index = SIZE_MAX;
    pm_photon_map_closest(waiting->lookup->map, waiting->spot.point, waiting->normal, INFINITY,
                          &index);
    return pm_lookup_closest(pass, waiting, index);
}

/* A precomputed irradiance does not tell where light came from: as if evenly from the
 * hemisphere, by one direction drawn from it. */
static pm_rgb weight_from_anywhere(const pm_surface *surface, pm_vec3 normal, pm_rng *rng)
{
    double u = pm_rng_uniform(rng);
    pm_frame frame = pm_frame_make(normal);
    pm_vec3 wi = pm_warp_cosine(u, pm_rng_uniform(rng));
    return pm_surface_photon_weight(surface, pm_frame_to_world(&frame, wi));
}

/* The share of an estimate's variance that all passes have in common. At the eye's vertex they
 * ask for the same photons. A gather ray asks elsewhere each time: the map holds about total /
 * count disjoint answers, and their mean is what all passes have in common; the rest shows as
 * scatter between passes. */
static double common_share(const struct pm_pass *pass, const struct pm_lookup *lookup,
                           const pm_estimate *estimate, enum pm_vertex vertex)
{
    if (!pass->shared)
        return 0;
    if (vertex == PM_VERTEX_EYE)
        return 1;
    return (double)estimate->count / (double)pm_photon_map_count(lookup->map);
}

void pm_lookup_add(const struct pm_pass *pass, struct pm_waiting *waiting,
                   const pm_estimate *first, struct pm_value *value)
{
    const struct pm_spot *spot = &waiting->spot;
    pm_vec3 normal = waiting->normal;
    pm_estimate estimate = *first;
    if (!estimate.count)
        return;
    bool area = !waiting->lookup->precomputed; /* which holds what follows */
    pm_between near;
    const pm_between *walls =
        area && pm_walls_near(pass, spot, normal, estimate.radius, &near) ? &near : NULL;
    if (walls) { /* once more: what is in sight of all that */
        const struct weighing weighing = {pass, spot, normal, waiting->uniform, walls};
        const pm_photon_weight each = {photon_weight, &weighing};
        estimate = ask(waiting->lookup, spot->point, normal, &each);
    }
    double share = common_share(pass, waiting->lookup, &estimate, waiting->vertex);
    double edges =
        area ? pm_boundary_factor(pass, spot, normal, estimate.radius, walls, &waiting->rng)
             : 1;
    pm_rgb here = pm_rgb_scale(waiting->weight, edges);
    if (!area && !waiting->uniform)
        here = pm_rgb_mul(here, weight_from_anywhere(spot->surface, normal, &waiting->rng));
    pm_rgb variance = pm_rgb_mul(pm_rgb_mul(here, here), estimate.variance);
    value->radiance = pm_rgb_add(value->radiance, pm_rgb_mul(here, estimate.irradiance));
    value->variance = pm_rgb_madd(value->variance, share, variance);
}

static void ask_now(const struct pm_pass *pass, struct pm_waiting *waiting,
                    struct pm_value *value)
{
    const struct pm_spot *spot = &waiting->spot;
    const struct weighing weighing = {pass, spot, waiting->normal, waiting->uniform, NULL};
    const pm_photon_weight each = {photon_weight, &weighing};
    pm_estimate estimate = waiting->lookup->precomputed
                               ? ask_precomputed(pass, waiting)
                               : ask(waiting->lookup, spot->point, waiting->normal,
                                     waiting->uniform ? NULL : &each);
    pm_lookup_add(pass, waiting, &estimate, value);
}

/* The photons on one side. */
static void add_side(const struct pm_pass *pass, const struct pm_spot *spot, unsigned side,
                     pm_rgb throughput, enum pm_vertex vertex, struct pm_sampler *sampler,
                     struct pm_value *value)
{
    const struct pm_vertex_rule *rule = &pass->rules[vertex];
    pm_vec3 normal = spot->surface->normal;
    pm_rgb weight;
    bool uniform, far = side == PM_SIDE_FAR;
    if (!pm_surface_photons(spot->surface, side, &uniform, &weight))
        return;
    struct pm_waiting waiting = {
        .spot = *spot,
        .normal = far ? pm_vec3_negate(normal) : normal,
        .vertex = vertex,
        .far = far,
        .uniform = uniform,
        .weight = uniform ? pm_rgb_mul(throughput, weight) : throughput,
        .rng = sampler->rng,
    };
    for (int i = 0; i < rule->lookup_count; i++) {
        waiting.lookup = &rule->lookups[i];
        pm_rng_bounce(&waiting.rng, ++sampler->lookups);
        if (sampler->queue && uniform && !waiting.lookup->range.most)
            pm_queue_add(pass, sampler->queue, &waiting, sampler->slot);
        else
            ask_now(pass, &waiting, value);
    }
}

void pm_lookup_surface(const struct pm_pass *pass, const struct pm_spot *spot,
                       pm_rgb throughput, enum pm_vertex vertex, struct pm_sampler *sampler,
                       struct pm_value *value)
{
    add_side(pass, spot, PM_SIDE_NEAR, throughput, vertex, sampler, value);
    add_side(pass, spot, PM_SIDE_FAR, throughput, vertex, sampler, value);
}

pm_estimate pm_estimate_at_photon(const void *world, const pm_photon_map *map, pm_vec3 point,
                                  pm_vec3 normal, uint32_t gather_count, uint64_t i)
{
    const struct pm_pass pass = {.world = world};
    const struct pm_spot spot = {.point = point, .from = PM_NO_PRIMITIVE};
    const struct pm_lookup lookup = {.map = map, .gather_count = gather_count};
    pm_estimate e = ask(&lookup, point, normal, NULL);
    if (!e.count)
        return e;
    pm_between near;
    const pm_between *walls =
        pm_walls_near(&pass, &spot, normal, e.radius, &near) ? &near : NULL;
    if (walls) {
        const struct weighing weighing = {&pass, &spot, normal, true, walls};
        e = ask(&lookup, point, normal, &(pm_photon_weight){photon_weight, &weighing});
    }
    double edges = pm_boundary_mean(&pass, &spot, normal, e.radius, walls, i);
    e.irradiance = pm_rgb_scale(e.irradiance, edges);
    e.variance = pm_rgb_scale(e.variance, edges * edges);
    return e;
}
