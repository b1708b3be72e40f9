#include "language/noise.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Perlin's permutation of 0 .. 255 (Improving noise, reference implementation, 2002). */
static const uint8_t permutation[256] = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,
    103, 30,  69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,
    0,   26,  197, 62,  94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149,
    56,  87,  174, 20,  125, 136, 171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166,
    77,  146, 158, 231, 83,  111, 229, 122, 60,  211, 133, 230, 220, 105, 92,  41,  55,  46,
    245, 40,  244, 102, 143, 54,  65,  25,  63,  161, 1,   216, 80,  73,  209, 76,  132, 187,
    208, 89,  18,  169, 200, 196, 135, 130, 116, 188, 159, 86,  164, 100, 109, 198, 173, 186,
    3,   64,  52,  217, 226, 250, 124, 123, 5,   202, 38,  147, 118, 126, 255, 82,  85,  212,
    207, 206, 59,  227, 47,  16,  58,  17,  182, 189, 28,  42,  223, 183, 170, 213, 119, 248,
    152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,   129, 22,  39,  253,
    19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,
    242, 193, 238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107,
    49,  192, 214, 31,  181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,
    150, 254, 138, 236, 205, 93,  222, 114, 67,  29,  24,  72,  243, 141, 128, 195, 78,  66,
    215, 61,  156, 180};

static double fade(double t)
{
    return t * t * t * (t * (t * 6 - 15) + 10);
}

static double mix(double t, double a, double b)
{
    return a + t * (b - a);
}

/* The corner's gradient, one of twelve towards the edges of a cube (four of them twice), times
 * the vector from the corner. */
static double slope(unsigned hash, double x, double y, double z)
{
    unsigned h = hash & 15;
    double u = h < 8 ? x : y;
    double v = h < 4 ? y : h == 12 || h == 14 ? x : z;
    return (h & 1 ? -u : u) + (h & 2 ? -v : v);
}

static unsigned shuffle(unsigned i)
{
    return permutation[i & 255];
}

static bool within(double x)
{
    return x > -0x1p31 && x < 0x1p31;
}

/* The lattice cell of a coordinate. A negative integer counts to the cell below, as in
 * Radiance; noise is continuous there. */
static int64_t cell(double x)
{
    return (int64_t)x - (x < 0);
}

double pm_noise(double x, double y, double z)
{
    if (!within(x) || !within(y) || !within(z))
        return 0;
    int64_t i = cell(x), j = cell(y), k = cell(z);
    x -= (double)i, y -= (double)j, z -= (double)k;
    unsigned ui = i & 255, uj = j & 255, uk = k & 255;
    double u = fade(x), v = fade(y), w = fade(z);
    unsigned a = shuffle(ui) + uj, b = shuffle(ui + 1) + uj;
    unsigned aa = shuffle(a) + uk, ab = shuffle(a + 1) + uk;
    unsigned ba = shuffle(b) + uk, bb = shuffle(b + 1) + uk;
    double front =
        mix(v, mix(u, slope(shuffle(aa), x, y, z), slope(shuffle(ba), x - 1, y, z)),
            mix(u, slope(shuffle(ab), x, y - 1, z), slope(shuffle(bb), x - 1, y - 1, z)));
    double back = mix(
        v, mix(u, slope(shuffle(aa + 1), x, y, z - 1), slope(shuffle(ba + 1), x - 1, y, z - 1)),
        mix(u, slope(shuffle(ab + 1), x, y - 1, z - 1),
            slope(shuffle(bb + 1), x - 1, y - 1, z - 1)));
    return mix(w, front, back);
}

/* -1 .. 1 from the lattice point: the low 31 bits of an integer polynomial, which wraps. */
static double lattice(const int64_t at[3])
{
    uint64_t s = 17u * (uint64_t)at[0] + 23u * (uint64_t)at[1] + 29u * (uint64_t)at[2];
    s = (s << 13) ^ s;
    uint64_t bits = (s * (s * s * 15731u + 789221u) + 1376312589u) & 0x7fffffffu;
    return 1 - (double)bits / 1073741824.0;
}

/* A cube during the halving. Corner j lies at the far side along axis i if bit i of j is set.
 */
struct cube {
    int64_t origin[3];
    int64_t half;
    double corner[8];
    unsigned octant; /* that holds the point */
};

static double displaced(const struct cube *cube, double mean, const int64_t at[3])
{
    return mean + (double)cube->half * PM_NOISE_STEP * lattice(at);
}

static double corner_mean(const struct cube *cube)
{
    double sum = 0;
    for (unsigned j = 0; j < 8; j++)
        sum += cube->corner[j];
    return sum * .125;
}

/* The middle, moved along one axis to the side where the point is. */
static int64_t towards(const struct cube *cube, int axis)
{
    int64_t middle = cube->origin[axis] + cube->half;
    return cube->octant & 1u << axis ? middle + cube->half : middle - cube->half;
}

static void face(struct cube *cube, int axis)
{
    int64_t at[3];
    double sum = 0;
    for (int i = 0; i < 3; i++)
        at[i] = i == axis ? towards(cube, i) : cube->origin[i] + cube->half;
    for (unsigned j = 0; j < 8; j++)
        if (~(j ^ cube->octant) & 1u << axis)
            sum += cube->corner[j];
    cube->corner[~(cube->octant ^ 1u << axis) & 7] = displaced(cube, .25 * sum, at);
}

static void edge(struct cube *cube, int axis)
{
    int64_t at[3];
    for (int i = 0; i < 3; i++)
        at[i] = i == axis ? cube->origin[i] + cube->half : towards(cube, i);
    double sum = cube->corner[cube->octant & ~(1u << axis)];
    sum += cube->corner[cube->octant | 1u << axis];
    cube->corner[cube->octant ^ 1u << axis] = displaced(cube, .5 * sum, at);
}

/* Corners are replaced one by one and later means see the new ones: that order is part of the
 * values. */
static void halve(struct cube *cube, const int64_t point[3])
{
    double mean = corner_mean(cube);
    int64_t middle[3];
    cube->half >>= 1;
    cube->octant = 0;
    for (int i = 0; i < 3; i++) {
        middle[i] = cube->origin[i] + cube->half;
        if (point[i] > middle[i])
            cube->octant |= 1u << i;
    }
    cube->corner[~cube->octant & 7] = displaced(cube, mean, middle);
    for (int axis = 0; axis < 3; axis++)
        face(cube, axis);
    for (int axis = 0; axis < 3; axis++)
        edge(cube, axis);
    for (int i = 0; i < 3; i++)
        if (cube->octant & 1u << i)
            cube->origin[i] += cube->half;
}

double pm_noise_fractal(double x, double y, double z)
{
    const double p[3] = {x, y, z};
    const int64_t unit = 2000; /* 1 / PM_NOISE_STEP */
    struct cube cube = {.half = unit};
    int64_t point[3];
    if (!within(x) || !within(y) || !within(z))
        return 0;
    for (int i = 0; i < 3; i++) {
        point[i] = (int64_t)((double)unit * p[i]);
        cube.origin[i] = unit * (int64_t)floor(p[i]);
    }
    for (unsigned j = 0; j < 8; j++) {
        int64_t at[3];
        for (int i = 0; i < 3; i++)
            at[i] = cube.origin[i] + (j & 1u << i ? unit : 0);
        cube.corner[j] = lattice(at);
    }
    while (cube.half > 1)
        halve(&cube, point);
    return corner_mean(&cube);
}
