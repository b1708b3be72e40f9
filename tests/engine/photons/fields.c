#include "fields.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/warp.h"

double field_uniform(pm_rng *rng, double low, double high)
{
    return low + (high - low) * pm_rng_uniform(rng);
}

pm_vec3 field_direction(pm_rng *rng)
{
    double u = pm_rng_uniform(rng);
    return pm_warp_sphere(u, pm_rng_uniform(rng));
}

void field_floor(pm_rng *rng, size_t i, pm_photon_record *out)
{
    (void)i;
    out->position.x = field_uniform(rng, -.9, .9);
    out->position.y = field_uniform(rng, -.9, .9);
    out->position.z = -.5;
    out->normal = pm_vec3_make(0, 0, 1);
}

void field_room(pm_rng *rng, size_t i, pm_photon_record *out)
{
    double along = field_uniform(rng, -.9, .9), across = field_uniform(rng, -.9, .9);
    double side = i & 1 ? 1 : -1;
    switch (i % 3) {
    case 0:
        out->position = pm_vec3_make(.9 * side, along, across);
        out->normal = pm_vec3_make(-side, 0, 0);
        break;
    case 1:
        out->position = pm_vec3_make(along, .9 * side, across);
        out->normal = pm_vec3_make(0, -side, 0);
        break;
    default:
        out->position = pm_vec3_make(along, across, .9 * side);
        out->normal = pm_vec3_make(0, 0, -side);
    }
}

void field_sphere(pm_rng *rng, size_t i, pm_photon_record *out)
{
    (void)i;
    out->normal = field_direction(rng);
    out->position = pm_vec3_scale(out->normal, .5);
}

void field_ball(pm_rng *rng, size_t i, pm_photon_record *out)
{
    (void)i;
    do {
        out->position.x = field_uniform(rng, -.8, .8);
        out->position.y = field_uniform(rng, -.8, .8);
        out->position.z = field_uniform(rng, -.8, .8);
    } while (pm_vec3_length(out->position) > .8);
}

/* Distances from (.2, .1) spread over three decades, as many photons in each. */
void field_caustic(pm_rng *rng, size_t i, pm_photon_record *out)
{
    field_floor(rng, i, out);
    double far = 1;
    for (unsigned decade = pm_rng_u32(rng) % 4; decade; decade--)
        far /= 10;
    out->position.x = .2 + far * (out->position.x - .2);
    out->position.y = .1 + far * (out->position.y - .1);
}

void field_point(pm_rng *rng, size_t i, pm_photon_record *out)
{
    (void)rng;
    (void)i;
    out->position = pm_vec3_make(.25, -.125, .5);
    out->normal = pm_vec3_make(0, 0, 1);
}

pm_photon *field_photons(field_make *make, uint64_t seed, size_t count)
{
    pm_rng rng;
    pm_photon *photons = calloc(count + 1, sizeof *photons);
    assert_non_null(photons);
    pm_rng_init(&rng, seed, PM_RNG_PATH, 0);
    for (size_t i = 0; i < count; i++) {
        pm_photon_record record = {.replicate = i % PM_REPLICATES};
        make(&rng, i, &record);
        record.direction = field_direction(&rng);
        record.flux = pm_rgb_make(1 + pm_rng_u32(&rng) % 3, 1, i & 1 ? 2 : 0);
        record.specular = pm_rng_u32(&rng) % 3 == 0;
        pm_photon_pack(&record, 1, &photons[i]);
    }
    return photons;
}

pm_photon_map *field_map_of(const pm_photon *photons, size_t count)
{
    pm_map_header header = {.paths = 1, .flux_scale = 1, .world_scale = 1};
    pm_batch batch = {.paths = 1, .count = count};
    batch.photons = malloc((count + 1) * sizeof *photons);
    assert_non_null(batch.photons);
    for (size_t i = 0; i < count; i++)
        batch.photons[i] = photons[i];
    pm_photon_map *map = NULL;
    assert_int_equal(pm_photon_map_build(&header, &batch, 1, NULL, &map, NULL), PM_OK);
    free(batch.photons);
    return map;
}

pm_photon_map *field_map(field_make *make, uint64_t seed, size_t count)
{
    pm_photon *photons = field_photons(make, seed, count);
    pm_photon_map *map = field_map_of(photons, count);
    free(photons);
    return map;
}

void field_add(field_moments *m, double value)
{
    double before = value - m->mean;
    m->count++;
    m->mean += before / m->count;
    m->square += before * (value - m->mean);
}

double field_variance(const field_moments *m)
{
    return m->square / (m->count - 1);
}

void field_assert_mean(const field_moments *m, double truth)
{
    double sigma = sqrt(field_variance(m) / m->count);
    if (!(fabs(m->mean - truth) <= 4 * sigma))
        print_error("mean %.9g, truth %.9g, sigma %.3g\n", m->mean, truth, sigma);
    assert_true(fabs(m->mean - truth) <= 4 * sigma);
}
