#ifndef PM_PHOTONS_PHOTON_MAP_H
#define PM_PHOTONS_PHOTON_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"
#include "base/digest.h"
#include "base/error.h"
#include "base/pool.h"
#include "forward/photon.h"

/* The photon map: photons sorted along the Morton curve, searched through a tree of boxes.
 *
 * In: batches. Out: pm_photon_map, answers about photon density. Next: backward/backward.h.
 *
 * Stored order is Morton code, then the photon's own bytes: independent of count, radius and
 * chunking. At most 25 bytes a photon. Read-only after building; safe to share between threads.
 * Test: photon_takes_at_most_25_bytes. */
typedef struct pm_photon_map pm_photon_map;

#define PM_MAP_PHOTONS_MAX 2147483648U
enum {
    PM_GATHER_MAX = 16384, /* greatest gather_count */
    PM_PASSES_MAX = 4096,  /* of a sequence */
};

/* What a map is about; also the header of its file. */
typedef struct pm_map_header {
    pm_map_kind kind;
    pm_digest scene; /* octree hash */
    pm_digest family;
    uint64_t first_path, paths; /* emitted; fluxes of the photons are divided by their number */
    uint32_t pass;              /* of a sequence; 0 otherwise */
    double flux_scale;          /* of the packed fluxes [W / scale^2] */
    double world_scale;         /* scene units a world unit */
    pm_vec3 world_center;       /* [scene units] */
    uint64_t seed;
    double storage_probability;
    pm_rgb emitted; /* power of all lights [W / scale^2] */
    char note[160]; /* why the map is empty, or what else a user should know; may be "" */
} pm_map_header;

/* Photons that come piece by piece, in one array that becomes the map's own: no photon is held
 * twice. Zero-initialised storage is empty. */
typedef struct pm_photon_list {
    pm_photon *photons;
    size_t count, capacity;
} pm_photon_list;

/* Room for `count` photons in all: address space, taken up as photons come. PM_E_LIMIT above
 * PM_MAP_PHOTONS_MAX; PM_E_MEMORY, with how much is missing, and the list is as it was. */
PM_MUST_USE pm_status pm_photon_list_reserve(pm_photon_list *list, uint64_t count,
                                             pm_error *err);
/* Copies. Makes room if there is none; then, for a moment, there are two copies. */
PM_MUST_USE pm_status pm_photon_list_append(pm_photon_list *list, const pm_photon *photons,
                                            size_t count, pm_error *err);
void pm_photon_list_clear(pm_photon_list *list); /* frees */

/* Makes a map of a list's photons, in the list's own memory; the list is empty afterwards, on
 * errors too. Any order of photons and any number of threads give the same bytes. Memory while
 * building: 25 bytes a photon at most, those of the list included. `pool` may be NULL. Errors:
 * PM_E_MEMORY. Tests: building_takes_at_most_25_bytes_a_photon,
 * map_bytes_do_not_depend_on_batches_or_threads. */
PM_MUST_USE pm_status pm_photon_map_take(const pm_map_header *header, pm_photon_list *list,
                                         pm_pool *pool, pm_photon_map **out, pm_error *err);

/* The same from copies of `count` batches of one kind. */
PM_MUST_USE pm_status pm_photon_map_build(const pm_map_header *header, const pm_batch *batches,
                                          size_t count, pm_pool *pool, pm_photon_map **out,
                                          pm_error *err);
void pm_photon_map_free(pm_photon_map *map);

const pm_map_header *pm_photon_map_header(const pm_photon_map *map);
size_t pm_photon_map_count(const pm_photon_map *map);
/* Photon i < count of the stored order. */
void pm_photon_map_photon(const pm_photon_map *map, size_t i, pm_photon *out);
/* A photon [W, scene units]; of a precomputed map its irradiance [W/m^2], to ten bits. */
pm_rgb pm_photon_map_mean_flux(const pm_photon_map *map);
size_t pm_photon_map_bytes(const pm_photon_map *map); /* of memory */

/* ---- density estimation; flux densities in W / scale^2 per world area = W/m^2 ----
 *
 * Points and radii are in world coordinates, normals and directions unit. Points may lie
 * anywhere but must be finite; they are rounded to the step of stored positions, 2^-31, and
 * distances to floats. Sums begin in floats, 64 blocks of 16 photons at most, and go on in
 * doubles. The same call gives the same bytes by AVX-512, AVX2 or SSE2 (the rest needs AVX2),
 * and alone or in a batch. Tests: batches_have_the_bytes_of_single_calls,
 * instruction_sets_give_the_same_bytes. */

/* Which photons a look-up takes. */
typedef enum pm_photon_filter {
    PM_PHOTONS_ALL,
    PM_PHOTONS_NOT_SPECULAR, /* without those whose last event was specular */
    PM_PHOTONS_SPECULAR,
} pm_photon_filter;

/* What each photon's flux is multiplied by. */
typedef struct pm_photon_weight {
    pm_rgb (*of)(const void *context, const pm_photon *photon);
    const void *context;
} pm_photon_weight;

typedef struct pm_estimate {
    pm_rgb irradiance; /* [W/m^2]; of volumes: sum of flux * phase / volume */
    pm_rgb variance;   /* of it: sum (flux K)^2 over the photons, see below */
    double radius;     /* [world units] of what was averaged over; 0 if no photon was used */
    uint32_t count;    /* photons used */
} pm_estimate;

/* Irradiance on the side of `normal` from the k = gather_count nearest photons:
 *
 *   E = sum_{i<=k} flux_i / (pi r_{k+1}^2),
 *
 * where r_{k+1} is the distance of the next one, which is not summed. So E is unbiased in a
 * uniform Poisson field, and so is sum flux_i^2 / (pi r_{k+1}^2)^2 for its variance, that of
 * the radius included (k > 1; the variance for k = 1 is infinite).
 *
 * gather_count is 1 .. PM_GATHER_MAX. weight bears on the sum, not on which photons are near;
 * NULL means 1. max_radius is > 0 and may be INFINITY: with at most k photons inside a finite
 * one, all are summed over its disc, which keeps E unbiased; with INFINITY the farthest then
 * sets the radius and is not summed, so 0 or 1 photon give zero.
 *
 * A photon counts, here and within a fixed radius, if its normal is within 60 degrees of
 * `normal` and if it lies in the tangent plane: with D from point to photon, the mean m of both
 * normals has |m . D| <= |D| / 4 + 2^-30. On planes, spheres and cylinders m . D is 0 whatever
 * the curvature, and a sphere's cap has exactly the disc's area. Other photons are passed over,
 * so nothing leaks through thin walls or around corners, nor from a parallel surface farther
 * than a quarter of the radius. No radius is taken as less than 2^-31, the step of stored
 * positions.
 *
 * Source: Jensen 2001, ch. 7; Mack and Rosenblatt 1979 for the k+1 rule.
 * Test: density_flat_floor_is_analytic, density_on_a_sphere_is_analytic. */
pm_estimate pm_photon_map_nearest(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                                  uint32_t gather_count, double max_radius,
                                  pm_photon_filter filter, const pm_photon_weight *weight);

/* Whether a photon there, on the side of its normal, counts at the point, as said above. */
bool pm_photon_counts(pm_vec3 point, pm_vec3 normal, pm_vec3 photon, pm_vec3 photon_normal);

/* The same with a fixed radius: E = sum flux / (pi r^2), finite r > 0. */
pm_estimate pm_photon_map_within(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                                 double radius, pm_photon_filter filter,
                                 const pm_photon_weight *weight);

/* A point for many look-ups at once. */
typedef struct pm_photon_query {
    pm_vec3 point, normal;
    double radius; /* > 0: the fixed one, or max_radius */
    const pm_photon_weight *weight;
} pm_photon_query;

/* The same at `count` points: the very bytes of one call each, and several times as fast where
 * points follow each other that are near to each other. */
void pm_photon_map_within_batch(const pm_photon_map *map, const pm_photon_query *queries,
                                size_t count, pm_photon_filter filter, pm_estimate *out);
void pm_photon_map_nearest_batch(const pm_photon_map *map, const pm_photon_query *queries,
                                 size_t count, uint32_t gather_count, pm_photon_filter filter,
                                 pm_estimate *out);

/* The nearest photon that counts at the point, as said above; of equally distant ones the first
 * in stored order. max_radius is > 0 and may be INFINITY. False, with *index untouched, if
 * there is none within it. Test: closest_equals_brute_force. */
bool pm_photon_map_closest(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                           double max_radius, size_t *index);
/* The same at many points, each within its query's radius; index[i] is SIZE_MAX where there is
 * none. Weights do not matter. */
void pm_photon_map_closest_batch(const pm_photon_map *map, const pm_photon_query *queries,
                                 size_t count, size_t *index);

/* In-scattering in a medium towards `direction` (unit; where the light is going, e.g. to the
 * eye): sum over the nearest photons of flux * phase(g) / (4/3 pi r^3), with radius, count
 * and variance as above. Dividing by the
 * extinction and multiplying with the scattering coefficient is the caller's: a volume photon
 * is stored at every collision with its flux before the albedo, so flux density / extinction =
 * fluence rate. */
pm_estimate pm_photon_map_volume(const pm_photon_map *map, pm_vec3 point, pm_vec3 direction,
                                 double g, uint32_t gather_count, double max_radius);
/* The same with a fixed radius. */
pm_estimate pm_photon_map_volume_within(const pm_photon_map *map, pm_vec3 point,
                                        pm_vec3 direction, double g, double radius);

/* ---- files: see map_file.c and batch_file.c for the bytes ---- */

/* Where the bytes of a file go, in order. */
typedef struct pm_sink {
    void *context;
    pm_status (*put)(void *context, const void *data, size_t size, pm_error *err);
} pm_sink;

/* Writes header and photons, packed and with a checksum each part, and an end with the command
 * line as typed (NULL: none), which no digest covers. Any number of threads gives the same
 * bytes; the same version of zstd, too. Test: map_file_round_trip. */
PM_MUST_USE pm_status pm_photon_map_stream(const pm_photon_map *map, const char *command,
                                           pm_pool *pool, const pm_sink *sink, pm_error *err);

/* The same bytes straight from a list, which is put in order for it: no search structure is
 * built. Test: list_and_map_give_the_same_file. */
PM_MUST_USE pm_status pm_photon_list_stream(const pm_map_header *header, pm_photon_list *list,
                                            const char *command, pm_pool *pool,
                                            const pm_sink *sink, pm_error *err);

/* A sequence of passes is a file of maps, each written with pm_photon_map_stream and no command
 * line, and then of this. */
PM_MUST_USE pm_status pm_sequence_end(const char *command, const pm_sink *sink, pm_error *err);

/* pm_photon_map_stream into memory. */
PM_MUST_USE pm_status pm_photon_map_write(const pm_photon_map *map, const char *command,
                                          pm_bytes *out, pm_error *err);

/* Reads and checks everything. `name` is for messages. `command` (may be NULL) receives the
 * trailer's text, to be freed by the caller. The passes of a sequence become one map: its paths
 * are those of all of them.
 * Errors: PM_E_CORRUPT (checksum, length), PM_E_UNSUPPORTED (another version), PM_E_SYNTAX (no
 * map file), PM_E_MISMATCH (passes of several families). */
PM_MUST_USE pm_status pm_photon_map_read(const void *data, size_t size, const char *name,
                                         pm_photon_map **out, char **command, pm_error *err);

/* Who looks through a file without making a map of it; both may be NULL. An error ends it. */
typedef struct pm_map_visitor {
    void *context;
    /* A map begins: the only one, or a pass of a sequence. */
    pm_status (*begin)(void *context, const pm_map_header *header, uint64_t count,
                       pm_error *err);
    /* The next photons of it. */
    pm_status (*photons)(void *context, const pm_photon *photons, size_t count, pm_error *err);
} pm_map_visitor;

/* Reads and checks as pm_photon_map_read does, a part at a time: some megabytes of memory. */
PM_MUST_USE pm_status pm_map_file_visit(const void *data, size_t size, const char *name,
                                        const pm_map_visitor *visitor, char **command,
                                        pm_error *err);

/* The first header alone; the photons are not looked at. */
PM_MUST_USE pm_status pm_map_file_header(const void *data, size_t size, const char *name,
                                         pm_map_header *out, pm_error *err);

/* Batches as stored and sent between worker and server: the same parts and checksums, with the
 * path ends. */
PM_MUST_USE pm_status pm_batch_write(const pm_batch *batch, pm_bytes *out, pm_error *err);
PM_MUST_USE pm_status pm_batch_read(const void *data, size_t size, pm_batch *out,
                                    pm_error *err);

#endif
