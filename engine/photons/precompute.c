#include "photons/precompute.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/sobol.h"
#include "photons/map_internal.h"

pm_digest pm_precompute_family(const pm_digest *global, uint64_t count, uint32_t gather_count,
                               double fraction)
{
    static const char what[] = "precomputed 1"; /* raise it when stored bytes change */
    uint64_t numbers[3] = {count, gather_count, 0};
    uint8_t bytes[sizeof what + sizeof global->bytes + sizeof numbers];
    memcpy(&numbers[2], &fraction, sizeof fraction);
    memcpy(bytes, what, sizeof what);
    memcpy(bytes + sizeof what, global->bytes, sizeof global->bytes);
    memcpy(bytes + sizeof what + sizeof global->bytes, numbers, sizeof numbers);
    return pm_digest_of(bytes, sizeof bytes);
}

/* ---- irradiance in a photon ---- */

enum {
    EXPONENT_BIAS = 200,
    UPPER_BITS = 10,
    LOWER_BITS = 10,
    LOWER_MASK = 0x3FF,
    MANTISSA_MAX = 0xFFFFF,
    DEVIATION_MAX = 15, /* of PM_PHOTON_REPLICATE */
};

/* Of the flux scale: the least radius (photon_map.h) makes an irradiance of 2^61 of a flux. */
#define HEADROOM 0x1p20

/* A mantissa in units of 2^exponent. */
static uint32_t mantissa_of(double value, int exponent)
{
    return (uint32_t)(long)floor(ldexp(value, -exponent) + 0.5);
}

/* The least unit for which the largest mantissa fits. */
static int exponent_of(double largest)
{
    int exponent;
    frexp(largest, &exponent);
    exponent -= UPPER_BITS + LOWER_BITS;
    return mantissa_of(largest, exponent) > MANTISSA_MAX ? exponent + 1 : exponent;
}

static void put_irradiance(pm_rgb relative, pm_photon *out)
{
    double largest = pm_rgb_max(relative);
    uint32_t m[3] = {0};
    out->exponent = 0;
    if (largest >= 0x1p-180) {
        int exponent = exponent_of(largest);
        m[0] = mantissa_of(relative.r, exponent);
        m[1] = mantissa_of(relative.g, exponent);
        m[2] = mantissa_of(relative.b, exponent);
        assert(exponent + LOWER_BITS + EXPONENT_BIAS <= UINT8_MAX);
        out->exponent = (uint8_t)(exponent + LOWER_BITS + EXPONENT_BIAS);
    }
    out->flux = m[0] >> LOWER_BITS | m[1] >> LOWER_BITS << UPPER_BITS |
                m[2] >> LOWER_BITS << 2 * UPPER_BITS;
    uint32_t lower = (m[0] & LOWER_MASK) | (m[1] & LOWER_MASK) << LOWER_BITS |
                     (m[2] & LOWER_MASK) << 2 * LOWER_BITS;
    out->direction[0] = (uint16_t)lower;
    out->direction[1] = (uint16_t)(lower >> 16);
}

pm_rgb pm_precomputed_irradiance(const pm_photon_map *map, const pm_photon *photon)
{
    uint32_t lower = photon->direction[0] | (uint32_t)photon->direction[1] << 16;
    double unit = ldexp(map->header.flux_scale, photon->exponent - EXPONENT_BIAS - LOWER_BITS);
    double channel[3];
    for (int c = 0; c < 3; c++) {
        uint32_t mantissa = (photon->flux >> c * UPPER_BITS & LOWER_MASK) << LOWER_BITS |
                            (lower >> c * LOWER_BITS & LOWER_MASK);
        channel[c] = mantissa * unit;
    }
    return (pm_rgb){channel[0], channel[1], channel[2]};
}

/* The standard deviation relative to the irradiance as the nearest power of 2^-1/2. */
static uint8_t deviation_code(const pm_estimate *e)
{
    double irradiance = pm_rgb_max(e->irradiance);
    double relative2 = pm_rgb_max(e->variance) / (irradiance * irradiance);
    int code = 0;
    while (code < DEVIATION_MAX && relative2 < ldexp(0x1.6a09e667f3bcdp-1, -code)) /* 2^-1/2 */
        code++;
    return (uint8_t)code;
}

/* ---- making a map ---- */

enum { PIECE = 256, ROUND = 64 }; /* photons; pieces between two questions whether to stop */

struct making {
    const pm_photon_map *global;
    const pm_precompute *how;
    pm_photon *photons;
    size_t count, first; /* of this round */
};

/* Which photon of the global map is kept as number i. */
static size_t chosen(const struct making *m, size_t i)
{
    uint32_t draw = pm_hash_u32(pm_hash_u32((uint32_t)m->how->seed, (uint32_t)i),
                                (uint32_t)(m->how->seed >> 32) ^ (uint32_t)(i >> 32));
    double stretch = (double)m->global->count / (double)m->count;
    size_t index = (size_t)(((double)i + draw * 0x1p-32) * stretch);
    return index < m->global->count ? index : m->global->count - 1;
}

static void precompute(const struct making *m, size_t i)
{
    const pm_precompute *how = m->how;
    pm_photon *out = &m->photons[i];
    pm_photon_map_photon(m->global, chosen(m, i), out);
    pm_vec3 point = pm_photon_position(out), normal = pm_photon_normal(out);
    pm_estimate e =
        how->estimate
            ? how->estimate(how->context, m->global, point, normal, how->gather_count, i)
            : pm_photon_map_nearest(m->global, point, normal, how->gather_count, INFINITY,
                                    PM_PHOTONS_ALL, NULL);
    put_irradiance(pm_rgb_scale(e.irradiance, 1 / (HEADROOM * m->global->header.flux_scale)),
                   out);
    out->flags = deviation_code(&e);
}

static void precompute_piece(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    const struct making *m = context;
    size_t first = m->first + piece * PIECE;
    for (size_t i = first; i < first + PIECE && i < m->count; i++)
        precompute(m, i);
}

static pm_status precompute_all(struct making *m, pm_pool *pool, bool (*cancelled)(void *),
                                void *waiting, pm_error *err)
{
    for (; m->first < m->count; m->first += PIECE * ROUND) {
        size_t pieces = (m->count - m->first + PIECE - 1) / PIECE;
        if (cancelled && cancelled(waiting))
            return pm_error_set(err, PM_E_CANCELLED, "cancelled while precomputing irradiance");
        pm_photons_run(pool, pieces < ROUND ? pieces : ROUND, precompute_piece, m);
    }
    return PM_OK;
}

static size_t kept_count(size_t count, double fraction)
{
    size_t kept = (size_t)floor((double)count * fraction);
    return kept || !count ? kept : 1;
}

void pm_precompute_header(pm_map_header *header, const pm_precompute *how)
{
    header->kind = PM_MAP_PRECOMPUTED;
    header->family = how->family;
    header->storage_probability = how->fraction;
    header->flux_scale *= HEADROOM;
}

pm_status pm_photon_map_precompute(const pm_photon_map *global, const pm_precompute *how,
                                   pm_pool *pool, bool (*cancelled)(void *), void *waiting,
                                   pm_photon_map **out, pm_error *err)
{
    assert(global->header.kind == PM_MAP_GLOBAL && how->fraction > 0 && how->fraction <= 1);
    pm_map_header header = global->header;
    pm_photon_list list = {0};
    struct making making = {
        .global = global, .how = how, .count = kept_count(global->count, how->fraction)};
    pm_status st = pm_photon_list_reserve(&list, making.count, err);
    if (st)
        return st;
    pm_precompute_header(&header, how);
    making.photons = list.photons;
    list.count = making.count;
    st = precompute_all(&making, pool, cancelled, waiting, err);
    if (!st)
        return pm_photon_map_take(&header, &list, pool, out, err);
    pm_photon_list_clear(&list);
    return st;
}

/* ---- asking it ---- */

pm_estimate pm_precomputed_estimate(const pm_photon_map *map, const pm_photon *photon)
{
    pm_rgb irradiance = pm_precomputed_irradiance(map, photon);
    double relative2 = ldexp(1, -(photon->flags & PM_PHOTON_REPLICATE));
    double gathered = map->header.storage_probability / relative2;
    return (pm_estimate){
        .irradiance = irradiance,
        .variance = pm_rgb_scale(pm_rgb_mul(irradiance, irradiance), relative2),
        .count = gathered > 1 ? (uint32_t)gathered : 1,
    };
}

void pm_photon_map_precomputed_batch(const pm_photon_map *map, const pm_photon_query *queries,
                                     size_t count, pm_estimate *out)
{
    enum { AT_ONCE = 256 };
    size_t index[AT_ONCE];
    for (size_t first = 0; first < count; first += AT_ONCE) {
        size_t some = count - first < AT_ONCE ? count - first : AT_ONCE;
        pm_photon_map_closest_batch(map, queries + first, some, index);
        for (size_t i = 0; i < some; i++) {
            pm_photon photon;
            out[first + i] = (pm_estimate){.count = 0};
            if (index[i] == SIZE_MAX)
                continue;
            pm_photon_map_photon(map, index[i], &photon);
            out[first + i] = pm_precomputed_estimate(map, &photon);
        }
    }
}

pm_estimate pm_photon_map_precomputed(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal)
{
    const pm_photon_query query = {.point = point, .normal = normal, .radius = INFINITY};
    pm_estimate out;
    pm_photon_map_precomputed_batch(map, &query, 1, &out);
    return out;
}
