#include "base/sobol.h"

/* Joe and Kuo: degree s, coefficients a, initial numbers m, of dimensions 2 to 8. */
static const struct {
    unsigned s, a, m[5];
} polynomials[PM_SOBOL_DIMENSIONS - 1] = {
    {1, 0, {1}},          {2, 1, {1, 3}},        {3, 1, {1, 3, 1}},        {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}}, {4, 4, {1, 3, 5, 13}}, {5, 2, {1, 1, 5, 5, 17}},
};

/* The 32 direction numbers of a dimension. */
static void make_directions(unsigned dimension, uint32_t v[32])
{
    if (dimension == 0) {
        for (unsigned i = 0; i < 32; i++)
            v[i] = 1U << (31 - i);
        return;
    }
    unsigned s = polynomials[dimension - 1].s, a = polynomials[dimension - 1].a;
    for (unsigned i = 0; i < 32; i++) {
        if (i < s) {
            v[i] = polynomials[dimension - 1].m[i] << (31 - i);
            continue;
        }
        v[i] = v[i - s] ^ (v[i - s] >> s);
        for (unsigned k = 1; k < s; k++)
            v[i] ^= ((a >> (s - 1 - k)) & 1) ? v[i - k] : 0;
    }
}

static uint32_t reverse_bits(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = ((x >> 4) & 0x0F0F0F0FU) | ((x & 0x0F0F0F0FU) << 4);
    x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
    return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

/* The sum of the directions that a byte of the index selects, bit-reversed so that scrambling
 * works upward: by place of the byte, byte, dimension. */
static uint32_t sums[4][256][PM_SOBOL_DIMENSIONS];

/* Filled before main, read-only ever after. */
__attribute__((constructor)) static void fill_sums(void)
{
    for (unsigned d = 0; d < PM_SOBOL_DIMENSIONS; d++) {
        uint32_t v[32];
        make_directions(d, v);
        for (unsigned place = 0; place < 4; place++)
            for (unsigned byte = 1; byte < 256; byte++)
                sums[place][byte][d] =
                    sums[place][byte & (byte - 1)][d] ^
                    reverse_bits(v[8 * place + (unsigned)__builtin_ctz(byte)]);
    }
}

/* Burley 2020, listing 1 with the constants of Vegdahl's improved Laine-Karras hash; `x` comes
 * bit-reversed. */
static uint32_t owen_scramble(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3D20ADEAU;
    x += seed;
    x *= (seed >> 16) | 1U;
    x ^= x * 0x05526C56U;
    x ^= x * 0x53A22864U;
    return reverse_bits(x);
}

/* The same for all dimensions at once. */
typedef uint32_t lanes __attribute__((vector_size(4 * PM_SOBOL_DIMENSIONS)));

static lanes reverse_lanes(lanes x)
{
    x = x >> 16 | x << 16;
    x = (x >> 8 & 0x00FF00FFU) | (x & 0x00FF00FFU) << 8;
    x = (x >> 4 & 0x0F0F0F0FU) | (x & 0x0F0F0F0FU) << 4;
    x = (x >> 2 & 0x33333333U) | (x & 0x33333333U) << 2;
    return (x >> 1 & 0x55555555U) | (x & 0x55555555U) << 1;
}

static lanes owen_scramble_lanes(lanes x, lanes seed)
{
    x ^= x * 0x3D20ADEAU;
    x += seed;
    x *= seed >> 16 | 1U;
    x ^= x * 0x05526C56U;
    x ^= x * 0x53A22864U;
    return reverse_lanes(x);
}

uint32_t pm_hash_u32(uint32_t a, uint32_t b)
{
    uint32_t x = a + b * 0x9E3779B9U + 0x7F4A7C15U;
    for (int round = 0; round < 2; round++) {
        x ^= x >> 16;
        x *= 0x7FEB352DU;
        x ^= x >> 15;
        x *= 0x846CA68BU;
        x ^= x >> 16;
        x += b;
    }
    return x;
}

double pm_sobol_hashed(uint32_t index, unsigned dimension, uint32_t hash)
{
    uint32_t x = sums[0][index & 255][dimension] ^ sums[1][index >> 8 & 255][dimension];
    if (index >> 16)
        x ^= sums[2][index >> 16 & 255][dimension] ^ sums[3][index >> 24][dimension];
    return owen_scramble(x, hash) * 0x1p-32;
}

void pm_sobol_point(uint32_t index, const uint32_t hash[PM_SOBOL_DIMENSIONS],
                    double out[PM_SOBOL_DIMENSIONS])
{
    const uint32_t *a = sums[0][index & 255], *b = sums[1][index >> 8 & 255];
    const uint32_t *c = sums[2][index >> 16 & 255], *d = sums[3][index >> 24];
    lanes x, seed;
    for (int i = 0; i < PM_SOBOL_DIMENSIONS; i++) {
        x[i] = a[i] ^ b[i] ^ c[i] ^ d[i];
        seed[i] = hash[i];
    }
    x = owen_scramble_lanes(x, seed);
    for (int i = 0; i < PM_SOBOL_DIMENSIONS; i++)
        out[i] = x[i] * 0x1p-32;
}

double pm_sobol(uint32_t index, unsigned dimension, uint32_t scramble)
{
    return pm_sobol_hashed(index, dimension, pm_hash_u32(scramble, dimension));
}
