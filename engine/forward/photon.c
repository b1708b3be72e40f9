#include "forward/photon.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/sobol.h"

const char *pm_map_kind_name(pm_map_kind kind)
{
    static const char *const names[PM_MAP_KINDS] = {"global", "caustic", "volume", "direct"};
    assert(kind < PM_MAP_KINDS || kind == PM_MAP_PRECOMPUTED);
    return kind == PM_MAP_PRECOMPUTED ? "precomputed" : names[kind];
}

/* ---- directions: the sphere unfolded to an octahedron's square [-1, 1]^2 ----
 * Source: Meyer et al., "On floating-point normal vectors", EGSR 2010. Codes are 0 .. 2 half
 * with 0, half and 2 half exact, so that the axes survive unchanged. */

enum { HALF_8 = 127, HALF_16 = 32767 };

static double sign_of(double v)
{
    return v < 0 ? -1 : 1;
}

/* Rounded; v is at least -1 but for rounding. */
static unsigned code_of(double v, int half)
{
    return (unsigned)(int)((v + 1) * half + 0.5);
}

static void octahedral_encode(pm_vec3 d, int half, unsigned code[2])
{
    double sum = fabs(d.x) + fabs(d.y) + fabs(d.z);
    if (!(sum > 0)) {
        code[0] = code[1] = 0;
        return;
    }
    double inverse = 1 / sum, x = d.x * inverse, y = d.y * inverse;
    double folded_x = (1 - fabs(y)) * sign_of(x), folded_y = (1 - fabs(x)) * sign_of(y);
    bool below = d.z < 0; /* selected by: directions are on either side at random */
    code[0] = code_of(below ? folded_x : x, half);
    code[1] = code_of(below ? folded_y : y, half);
}

static pm_vec3 octahedral_decode(unsigned u, unsigned v, int half)
{
    double x = (double)((int)u - half) / half, y = (double)((int)v - half) / half;
    double z = 1 - fabs(x) - fabs(y);
    if (z < 0) {
        double folded = (1 - fabs(y)) * sign_of(x);
        y = (1 - fabs(x)) * sign_of(y);
        x = folded;
    }
    return pm_vec3_normalize(pm_vec3_make(x, y, z));
}

/* ---- flux: three mantissas of 10 bits, one exponent ----
 * Many photons carry the very same flux, so that rounding to nearest would shift a map as a
 * whole: a channel at a hundredth of the largest by up to 5 %. Rounding up or down by a number
 * drawn from the position, which has nothing to do with the flux, leaves the mean where it was.
 */

enum { EXPONENT_BIAS = 200, MANTISSA_BITS = 10, MANTISSA_MASK = 0x3FF, EXPONENT_MAX = 255 };

/* 2^k for -1022 <= k <= 1023. */
static double power_of_two(int k)
{
    uint64_t bits = (uint64_t)(k + 1023) << 52;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* floor(log2 v) of a normal v > 0. */
static int exponent_of(double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    return (int)(bits >> 52 & 0x7FF) - 1023;
}

/* Rounds v (in units of the last bit) down or up with the low 10 bits of `draw`; whole numbers
 * stay. */
static uint32_t round_by(double v, uint32_t draw)
{
    return (uint32_t)(int)(v + ((draw & 0x3FF) + 0.5) * 0x1p-10);
}

/* The unit 2^k is the least one for which the largest mantissa fits after rounding up. */
static void flux_encode(pm_rgb flux, pm_photon *out)
{
    double largest = pm_rgb_max(flux);
    out->flux = 0;
    out->exponent = 0;
    if (!(largest >= 0x1p-200)) /* nothing, or too little for the exponent's range */
        return;
    int k = exponent_of(largest) - (MANTISSA_BITS - 1);
    if (largest * power_of_two(-k) > MANTISSA_MASK)
        k++;
    if (k < -EXPONENT_BIAS)
        k = -EXPONENT_BIAS;
    assert(k <= EXPONENT_MAX - EXPONENT_BIAS);
    double inverse_unit = power_of_two(-k);
    const uint32_t *p = out->position;
    uint32_t draw = pm_hash_u32(pm_hash_u32(p[0], p[1]), p[2]);
    out->flux = round_by(flux.r * inverse_unit, draw) |
                round_by(flux.g * inverse_unit, draw >> 10) << MANTISSA_BITS |
                round_by(flux.b * inverse_unit, draw >> 20) << 2 * MANTISSA_BITS;
    out->exponent = (uint8_t)(k + EXPONENT_BIAS);
}

pm_rgb pm_photon_flux(const pm_photon *photon)
{
    double unit = power_of_two((int)photon->exponent - EXPONENT_BIAS);
    return (pm_rgb){(photon->flux & MANTISSA_MASK) * unit,
                    (photon->flux >> MANTISSA_BITS & MANTISSA_MASK) * unit,
                    (photon->flux >> 2 * MANTISSA_BITS & MANTISSA_MASK) * unit};
}

/* ---- positions: fixed point in the cube [-1, 1] ---- */

static uint32_t position_encode(double p)
{
    double q = (p + 1) * 0x1p31 + 0.5;
    q = q > 0 ? q : 0;
    return (uint32_t)(int64_t)(q < 0x1p32 - 1 ? q : 0x1p32 - 1);
}

static double position_decode(uint32_t q)
{
    return q * 0x1p-31 - 1;
}

pm_vec3 pm_photon_position(const pm_photon *photon)
{
    return (pm_vec3){position_decode(photon->position[0]), position_decode(photon->position[1]),
                     position_decode(photon->position[2])};
}

pm_vec3 pm_photon_normal(const pm_photon *photon)
{
    return octahedral_decode(photon->normal[0], photon->normal[1], HALF_8);
}

pm_vec3 pm_photon_direction(const pm_photon *photon)
{
    return octahedral_decode(photon->direction[0], photon->direction[1], HALF_16);
}

void pm_photon_direction_code(pm_vec3 direction, uint16_t code[2])
{
    unsigned wide[2];
    octahedral_encode(direction, HALF_16, wide);
    code[0] = (uint16_t)wide[0];
    code[1] = (uint16_t)wide[1];
}

/* ---- whole photons ---- */

void pm_photon_pack(const pm_photon_record *record, double flux_scale, pm_photon *out)
{
    unsigned normal[2], direction[2];
    octahedral_encode(record->normal, HALF_8, normal);
    octahedral_encode(record->direction, HALF_16, direction);
    out->position[0] = position_encode(record->position.x);
    out->position[1] = position_encode(record->position.y);
    out->position[2] = position_encode(record->position.z);
    out->normal[0] = (uint8_t)normal[0];
    out->normal[1] = (uint8_t)normal[1];
    out->direction[0] = (uint16_t)direction[0];
    out->direction[1] = (uint16_t)direction[1];
    out->flags = (uint8_t)((record->replicate & PM_PHOTON_REPLICATE) |
                           (record->specular ? PM_PHOTON_SPECULAR : 0));
    flux_encode(pm_rgb_scale(record->flux, 1 / flux_scale), out);
}

void pm_photon_unpack(const pm_photon *photon, double flux_scale, pm_photon_record *out)
{
    *out = (pm_photon_record){
        .position = pm_photon_position(photon),
        .normal = pm_photon_normal(photon),
        .direction = pm_photon_direction(photon),
        .flux = pm_rgb_scale(pm_photon_flux(photon), flux_scale),
        .specular = photon->flags & PM_PHOTON_SPECULAR,
        .replicate = photon->flags & PM_PHOTON_REPLICATE,
    };
}

void pm_batch_clear(pm_batch *batch)
{
    free(batch->ends);
    free(batch->photons);
    *batch = (pm_batch){.kind = batch->kind};
}
