#include "backward/backward_internal.h"
#include "base/maths.h"
#include "base/warp.h"

enum {
    SUCCESSES = 4,    /* of the trials that follow a first failure */
    TRIALS_MAX = 256, /* a surface so small in its disc counts as this small a share */
    LAYERS_MAX = 4,   /* surfaces met on the way to one place */
};

/* Photons that count may lie off the tangent plane by a share of their distance (photon_map.h);
 * on a sphere, up to 60 degrees from the point, by .58 of it. */
static const double off_plane = .6;

/* Whether a photon could have been stored at a place of the disc: drawn evenly, looked for
 * along the normal. */
static bool lands(const struct pm_pass *pass, const struct pm_spot *spot, pm_vec3 normal,
                  double radius, const pm_between *walls, pm_rng *rng)
{
    double distance = radius * sqrt(pm_rng_uniform(rng)), sine, cosine;
    pm_sincos(2 * PM_PI * pm_rng_uniform(rng), &sine, &cosine);
    pm_frame frame = pm_frame_make(normal);
    pm_vec3 offset = {distance * cosine, distance * sine, off_plane * distance + 0x1p-26};
    pm_ray ray = {.origin = pm_vec3_add(spot->point, pm_frame_to_world(&frame, offset)),
                  .direction = pm_vec3_negate(normal),
                  .t_max = 2 * offset.z,
                  .from = PM_NO_PRIMITIVE};
    pm_hit hit;
    for (int i = 0; i < LAYERS_MAX && pm_world_intersect(pass->world, &ray, &hit); i++) {
        pm_vec3 facing =
            pm_vec3_dot(hit.normal, normal) < 0 ? pm_vec3_negate(hit.normal) : hit.normal;
        bool stores = hit.surface == spot->from || pm_surface_may_store(pass->world, &hit);
        if (stores && pm_photon_counts(spot->point, normal, hit.point, facing))
            return !walls || pm_sees(pass, spot, walls, normal, hit.point, facing);
        ray.origin = hit.point;
        ray.from = hit.surface;
        ray.t_max -= hit.t;
    }
    return false;
}

double pm_boundary_factor(const struct pm_pass *pass, const struct pm_spot *spot,
                          pm_vec3 normal, double radius, const pm_between *walls, pm_rng *rng)
{
    int trials = 0, successes = 0;
    if (lands(pass, spot, normal, radius, walls, rng))
        return 1;
    while (successes < SUCCESSES && trials < TRIALS_MAX) {
        successes += lands(pass, spot, normal, radius, walls, rng);
        trials++;
    }
    return 1 + trials / fmax(successes, 1);
}

double pm_boundary_mean(const struct pm_pass *pass, const struct pm_spot *spot, pm_vec3 normal,
                        double radius, const pm_between *walls, uint64_t i)
{
    enum { DRAWS = 16 };
    pm_rng rng;
    double sum = 0;
    pm_rng_init(&rng, 0, PM_RNG_PRECOMPUTE, i);
    for (int draw = 0; draw < DRAWS; draw++)
        sum += pm_boundary_factor(pass, spot, normal, radius, walls, &rng);
    return sum / DRAWS;
}
