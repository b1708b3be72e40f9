#include "language_test.h"

#define DEG (acos(-1) / 180)

static struct bench standard_bench(const char *file)
{
    struct bench b = bench_of("");
    size_t size = 0;
    const char *text = pm_language_standard(file, &size);
    assert_non_null(text);
    assert_int_equal(strlen(text), size);
    bench_read(&b, file, text);
    assert_string_equal(b.message, "");
    return b;
}

static void set(struct bench *b, enum pm_ray_value first, double x, double y, double z)
{
    b->ray.value[first] = x;
    b->ray.value[first + 1] = y;
    b->ray.value[first + 2] = z;
}

/* Values of Radiance's own files, by its own evaluator, for one ray: numbers, not formulas. The
 * ray's values are those of `ray` below; P is a point of the unit sphere or cylinder for the
 * mappings onto those. */
struct row {
    const char *file, *text;
    double value;
    double reals[22];
    uint32_t real_count;
};

static const struct row of_radiance[] = {
    {"skybright.cal", "skybr", 18.807044452910997, {1, 50, 10, 7.3, 0.3, 0.4, 0.866}, 7},
    {"skybright.cal", "sunnysky", 18.807106291374627, {1, 50, 10, 7.3, 0.3, 0.4, 0.866}, 7},
    {"skybright.cal", "cloudysky", 43.333333333333329, {1, 50, 10, 7.3, 0.3, 0.4, 0.866}, 7},
    {"skybright.cal", "intersky", 14.631653073189486, {1, 50, 10, 7.3, 0.3, 0.4, 0.866}, 7},
    {"skybright.cal", "skybr", 43.333099285729865, {2, 50, 10, 1, 0, 0, 0}, 7},
    {"skybright.cal", "sunnysky", 16.481243390525613, {2, 50, 10, 1, 0, 0, 0}, 7},
    {"skybright.cal", "cloudysky", 43.333333333333329, {2, 50, 10, 1, 0, 0, 0}, 7},
    {"skybright.cal", "intersky", 70.374132869954778, {2, 50, 10, 1, 0, 0, 0}, 7},
    {"skybright.cal", "skybr", 6.9999719142875838, {3, 7, 3, 0, 0, 0, 0}, 7},
    {"skybright.cal", "cloudysky", 6.0666666666666664, {3, 7, 3, 0, 0, 0, 0}, 7},
    {"skybright.cal", "skybr", 9.8192544334349954, {4, 50, 10, 3, 0.3, -0.4, 0.866}, 7},
    {"skybright.cal", "sunnysky", 9.4336079202612702, {4, 50, 10, 3, 0.3, -0.4, 0.866}, 7},
    {"skybright.cal", "cloudysky", 43.333333333333329, {4, 50, 10, 3, 0.3, -0.4, 0.866}, 7},
    {"skybright.cal", "intersky", 9.8192531643340839, {4, 50, 10, 3, 0.3, -0.4, 0.866}, 7},
    {"perezlum.cal",
     "skybright",
     31.591612548949428,
     {12, 8, -1, -0.3, 10, -3, 0.45, 0.3, 0.4, 0.866},
     10},
    {"perezlum.cal",
     "intersky",
     31.591778196923883,
     {12, 8, -1, -0.3, 10, -3, 0.45, 0.3, 0.4, 0.866},
     10},
    {"perezlum_c.cal",
     "skybright_r",
     18.388827263956006,
     {12,      8,      -1,      -0.3,        10,      -3,    0.45,     0.3,
      0.4,     0.866,  1.5,     -4607000000, 2967800, 99.11, 0.244063, -2006400000,
      1901800, 247.48, 0.23704, -3,          2.87,    -0.275},
     22},
    {"perezlum_c.cal",
     "skybright_g",
     33.539046588007324,
     {12,      8,      -1,      -0.3,        10,      -3,    0.45,     0.3,
      0.4,     0.866,  1.5,     -4607000000, 2967800, 99.11, 0.244063, -2006400000,
      1901800, 247.48, 0.23704, -3,          2.87,    -0.275},
     22},
    {"perezlum_c.cal",
     "skybright_b",
     61.370894714416821,
     {12,      8,      -1,      -0.3,        10,      -3,    0.45,     0.3,
      0.4,     0.866,  1.5,     -4607000000, 2967800, 99.11, 0.244063, -2006400000,
      1901800, 247.48, 0.23704, -3,          2.87,    -0.275},
     22},
    {"perezlum_c.cal",
     "skybright_r",
     27.272395108451214,
     {12,      8,      -1,      -0.3,        10,      -3,    0.45,     0.3,
      0.4,     0.866,  1.02,    -4607000000, 2967800, 99.11, 0.244063, -2006400000,
      1901800, 247.48, 0.23704, -3,          2.87,    -0.275},
     22},
    {"perezlum_c.cal",
     "skybright_g",
     33.218689406326511,
     {12,      8,      -1,      -0.3,        10,      -3,    0.45,     0.3,
      0.4,     0.866,  1.02,    -4607000000, 2967800, 99.11, 0.244063, -2006400000,
      1901800, 247.48, 0.23704, -3,          2.87,    -0.275},
     22},
    {"perezlum_c.cal",
     "skybright_b",
     28.451366568569956,
     {12,      8,      -1,      -0.3,        10,      -3,    0.45,     0.3,
      0.4,     0.866,  1.02,    -4607000000, 2967800, 99.11, 0.244063, -2006400000,
      1901800, 247.48, 0.23704, -3,          2.87,    -0.275},
     22},
    {"source.cal", "src_theta", 36.869897645844013, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "src_phi", 233.13010235415598, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "src_phi2", 126.86989764584402, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "src_phi4", 53.13010235415598, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "srcB_vert", -24.22774531795417, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "srcB_horiz", 30.963756532073521, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "srcB_vert2", 24.22774531795417, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "srcB_horiz2", 30.963756532073521, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "corr(Px)", 3.25, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "flatcorr(Px)", 4.220779220779221, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "boxcorr(Px)", 10.920698924731184, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "lboxcorr(Px)", 11.099726775956285, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "cylcorr(Px)", 25.282253457118912, {2.5, 0.3, 0.4, 0.7}, 4},
    {"source.cal", "src_phi2+90", 216.86989764584402, {2.5, 0.3, 0.4, 0.7}, 4},
    {"tilt.cal", "tilt_ang", 53.130102354155987, {0}, 0},
    {"tilt.cal", "tilt_xang", 24.227745317954167, {0}, 0},
    {"tilt.cal", "tilt_ang2", 53.13010235415598, {0}, 0},
    {"tilt.cal", "tilt_xang2", 24.227745317954174, {0}, 0},
    {"illum.cal", "il_alt", 0.80000000000000004, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 9},
    {"illum.cal", "il_azi", 0.92729521800161219, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 9},
    {"illum.cal", "il_alth", 0.64000000000000012, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 9},
    {"illum.cal", "il_azih", 4.0688878715914054, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 9},
    {"illum.cal", "il_alt", 0.80000000000000004, {0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1}, 9},
    {"illum.cal", "il_azi", 0.92729521800161219, {0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1}, 9},
    {"illum.cal", "il_alth", 0.64000000000000012, {0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1}, 9},
    {"illum.cal", "il_azih", 3.1415926535897931, {0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1}, 9},
    {"rev.cal", "rev_dx", 0.58051325941630105, {0.1, 0.2, 0.3, 0.4}, 4},
    {"rev.cal", "rev_dy", -1.0717167866147097, {0.1, 0.2, 0.3, 0.4}, 4},
    {"rev.cal", "rev_dz", 0.27000000000000002, {0.1, 0.2, 0.3, 0.4}, 4},
    {"surf.cal",
     "surf_dx",
     0.60000000000000009,
     {0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"surf.cal",
     "surf_dy",
     0.3620000000000001,
     {0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"surf.cal",
     "surf_dz",
     0.124,
     {0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"surf.cal",
     "surf_dx",
     1.8900000000000001,
     {1, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"surf.cal",
     "surf_dy",
     2.2809999999999997,
     {1, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"surf.cal",
     "surf_dz",
     2.6720000000000002,
     {1, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"surf.cal",
     "surf_dx",
     -0.1499999999999998,
     {2, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"surf.cal",
     "surf_dy",
     -0.47199999999999998,
     {2, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"surf.cal",
     "surf_dz",
     -0.79400000000000004,
     {2, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1},
     13},
    {"tmesh.cal",
     "u",
     0.52900000000000003,
     {0, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "v",
     0.31900000000000001,
     {0, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "dx",
     0.74332055343060321,
     {0, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "dy",
     0.80854301804227302,
     {0, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "dz",
     -0.77491781539657101,
     {0, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "u",
     0.21999999999999986,
     {1, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal", "v", 0.12, {1, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43}, 10},
    {"tmesh.cal",
     "dx",
     -0.70481473675900608,
     {1, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "dy",
     0.39304842103984705,
     {1, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "dz",
     -0.15777171921181354,
     {1, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "u",
     0.997,
     {2, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "v",
     0.96699999999999997,
     {2, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "dx",
     -0.14214497519610861,
     {2, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "dy",
     -0.16359472715719853,
     {2, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"tmesh.cal",
     "dz",
     -1.8337277771688019,
     {2, -0.37, -0.27, -0.17, -0.07, 0.03, 0.13, 0.23, 0.33, 0.43},
     10},
    {"window.cal",
     "tR_clear",
     0.48654744000000011,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "tR_bronze",
     0.47209657500000002,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "tG_clear",
     0.58385692800000011,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "tG_bronze",
     0.56651589000000002,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "tB_clear",
     0.68116641600000016,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "tB_bronze",
     0.66093520500000003,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "rR_clear",
     0.066591293999999995,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "rR_bronze",
     0.063521682499999815,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "rG_clear",
     0.13536877759999999,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "rG_bronze",
     0.13252534799999982,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "rB_clear",
     0.22379697079999997,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"window.cal",
     "rB_bronze",
     0.22124434649999986,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
     15},
    {"glazing.cal",
     "rrho",
     0.047921324999999994,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.95},
     18},
    {"glazing.cal",
     "grho",
     0.11501117999999998,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.95},
     18},
    {"glazing.cal",
     "brho",
     0.20801747400000004,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.95},
     18},
    {"glazing.cal",
     "rtau",
     0.28325794500000001,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.95},
     18},
    {"glazing.cal",
     "gtau",
     0.39656112300000002,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.95},
     18},
    {"glazing.cal",
     "btau",
     0.64710809520000012,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.95},
     18},
    {"glaze1.cal",
     "sr_frit_r",
     0.083557598546153355,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_frit_g",
     0.083557598546153355,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_frit_b",
     0.083557598546153355,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_clear_r",
     0.1073612972852143,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_clear_g",
     0.20654337536463496,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_clear_b",
     0.30572545344405555,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_frit_r",
     0.78819997449715573,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_frit_g",
     0.78819997449715573,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_frit_b",
     0.78819997449715573,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_clear_r",
     0.59509246847652375,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_clear_g",
     0.69427454655594434,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_clear_b",
     0.79345662463536515,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_frit_r",
     0.075201838691538028,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_frit_g",
     0.075201838691538028,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_frit_b",
     0.075201838691538028,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_clear_r",
     0.40490753152347625,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_clear_g",
     0.50408960960289684,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "sr_clear_b",
     0.60327168768231743,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_frit_r",
     0.78819997449715573,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_frit_g",
     0.78819997449715573,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_frit_b",
     0.78819997449715573,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_clear_r",
     0.59509246847652375,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_clear_g",
     0.69427454655594434,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze1.cal",
     "st_clear_b",
     0.79345662463536515,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.7, 0.8},
     19},
    {"glaze2.cal", "fr(.3)", 0.30572545344405555, {0}, 0},
    {"glaze2.cal", "ft(.4)", 0.39672831231768257, {0}, 0},
    {"glaze2.cal", "rclr", 0.083557598546153355, {0}, 0},
    {"glaze2.cal", "tclr", 0.87577774944128417, {0}, 0},
    {"glaze2.cal", "cr(.1,.2,.3)", 0.112, {0}, 0},
    {"winxmit.cal", "winxmit", 0.98746580534786477, {0}, 0},
    {"picture.cal", "pic_u", 1.3, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "pic_v", -2.3999999999999999, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "tile_u", 0.30000000000000004, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "tile_v", 0.60000000000000009, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "match_u", 0.69999999999999996, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "match_v", 0.60000000000000009, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "stag_u", 0.80000000000000004, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "stag_v", 0.60000000000000009, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "inpic", 0, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "infore(.3,.4,.5)", 0, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "infore(.2,.3,.4)", 0, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "infore(0,0,0)", 0, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "fadered(1,2,3)", 0.51219512195121952, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "fadegreen(1,2,3)", 0.96341463414634143, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "fadeblue(1,2,3)", 1.4146341463414633, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "fadegrey(1,2,3)", 0.82428765541463411, {1.5, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "pic_u", 1.3, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "pic_v", -2.3999999999999999, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "tile_u", 1.3, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "tile_v", 0.60000000000000009, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "match_u", 1.3, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "match_v", 0.39999999999999991, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "stag_u", 1.3, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "stag_v", 0.60000000000000009, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "inpic", 0, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "infore(.3,.4,.5)", 0, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "infore(.2,.3,.4)", 0, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "infore(0,0,0)", 0, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "fadered(1,2,3)", 0.51219512195121952, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "fadegreen(1,2,3)", 0.96341463414634143, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "fadeblue(1,2,3)", 1.4146341463414633, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "fadegrey(1,2,3)", 0.82428765541463411, {0.7, 0.2, 0.3, 0.4}, 4},
    {"picture.cal", "pic_u", 1.3, {1, 0, 0, 0}, 4},
    {"picture.cal", "pic_v", -2.3999999999999999, {1, 0, 0, 0}, 4},
    {"picture.cal", "tile_u", 0.30000000000000004, {1, 0, 0, 0}, 4},
    {"picture.cal", "tile_v", 0.60000000000000009, {1, 0, 0, 0}, 4},
    {"picture.cal", "match_u", 0.69999999999999996, {1, 0, 0, 0}, 4},
    {"picture.cal", "match_v", 0.39999999999999991, {1, 0, 0, 0}, 4},
    {"picture.cal", "stag_u", 0.30000000000000004, {1, 0, 0, 0}, 4},
    {"picture.cal", "stag_v", 0.60000000000000009, {1, 0, 0, 0}, 4},
    {"picture.cal", "inpic", 0, {1, 0, 0, 0}, 4},
    {"picture.cal", "infore(.3,.4,.5)", 0, {1, 0, 0, 0}, 4},
    {"picture.cal", "infore(.2,.3,.4)", 0, {1, 0, 0, 0}, 4},
    {"picture.cal", "infore(0,0,0)", 0, {1, 0, 0, 0}, 4},
    {"picture.cal", "fadered(1,2,3)", 0.3902439024390244, {1, 0, 0, 0}, 4},
    {"picture.cal", "fadegreen(1,2,3)", 0.78048780487804881, {1, 0, 0, 0}, 4},
    {"picture.cal", "fadeblue(1,2,3)", 1.1707317073170731, {1, 0, 0, 0}, 4},
    {"picture.cal", "fadegrey(1,2,3)", 0.70233643590243899, {1, 0, 0, 0}, 4},
    {"cyl.cal", "cyl_u", 20.344439357957025, {1.5, 0.2}, 2},
    {"cyl.cal", "cyl_v", 3.4999999999999996, {1.5, 0.2}, 2},
    {"cyl.cal", "cyl_tile_u", 0.34443935795702529, {1.5, 0.2}, 2},
    {"cyl.cal", "cyl_tile_v", 0.49999999999999956, {1.5, 0.2}, 2},
    {"cyl.cal", "cyl_match_u", 0.34443935795702529, {1.5, 0.2}, 2},
    {"cyl.cal", "cyl_match_v", 0.49999999999999956, {1.5, 0.2}, 2},
    {"cyl.cal", "cyl_u", 13.562959571971351, {0.6, 0.3}, 2},
    {"cyl.cal", "cyl_v", 2.3333333333333335, {0.6, 0.3}, 2},
    {"cyl.cal", "cyl_tile_u", 0.22962623863801745, {0.6, 0.3}, 2},
    {"cyl.cal", "cyl_tile_v", 0.33333333333333348, {0.6, 0.3}, 2},
    {"cyl.cal", "cyl_match_u", 0.22962623863801856, {0.6, 0.3}, 2},
    {"cyl.cal", "cyl_match_v", 0.33333333333333348, {0.6, 0.3}, 2},
    {"ball.cal", "ball_u", 2.7818856540048356, {1.5, 0.2}, 2},
    {"ball.cal", "ball_v", 3.2175055439664213, {1.5, 0.2}, 2},
    {"ball.cal", "ball_tile_u", 0.78188565400483556, {1.5, 0.2}, 2},
    {"ball.cal", "ball_tile_v", 0.2175055439664213, {1.5, 0.2}, 2},
    {"ball.cal", "ball_match_u", 0.78188565400483556, {1.5, 0.2}, 2},
    {"ball.cal", "ball_match_v", 0.2175055439664213, {1.5, 0.2}, 2},
    {"ball.cal", "ball_u", 1.8545904360032239, {0.6, 0.3}, 2},
    {"ball.cal", "ball_v", 2.1450036959776142, {0.6, 0.3}, 2},
    {"ball.cal", "ball_tile_u", 0.18792376933655719, {0.6, 0.3}, 2},
    {"ball.cal", "ball_tile_v", 0.1450036959776142, {0.6, 0.3}, 2},
    {"ball.cal", "ball_match_u", 1.4787428973301096, {0.6, 0.3}, 2},
    {"ball.cal", "ball_match_v", 0.1450036959776142, {0.6, 0.3}, 2},
    {"globe.cal", "globe_u", 1.2951672353008665, {0.5}, 1},
    {"globe.cal", "globe_v", 0.79516723530086653, {0.5}, 1},
    {"globe.cal", "globe_u", 0.64758361765043326, {1.5}, 1},
    {"globe.cal", "globe_v", 1.1927508529512998, {1.5}, 1},
    {"fisheye.cal", "fish_u", 0.63978525121122809, {0}, 0},
    {"fisheye.cal", "fish_v", 0.81063389158050669, {0}, 0},
    {"woodpat.cal", "xgrain", 0.7281641279580694, {0.5}, 1},
    {"woodpat.cal", "ygrain", 0.79907907747618401, {0.5}, 1},
    {"woodpat.cal", "zgrain", 0.80019065305056225, {0.5}, 1},
    {"woodtex.cal", "xgrain_dx", 0, {0.5}, 1},
    {"woodtex.cal", "xgrain_dy", 0.27141542363449928, {0.5}, 1},
    {"woodtex.cal", "xgrain_dz", 0.27305433124802347, {0.5}, 1},
    {"woodtex.cal", "ygrain_dx", 0.27305433124802347, {0.5}, 1},
    {"woodtex.cal", "ygrain_dy", 0, {0.5}, 1},
    {"woodtex.cal", "ygrain_dz", 0.27141542363449928, {0.5}, 1},
    {"woodtex.cal", "zgrain_dx", 0.27305433124802347, {0.5}, 1},
    {"woodtex.cal", "zgrain_dy", 0.27141542363449928, {0.5}, 1},
    {"woodtex.cal", "zgrain_dz", 0, {0.5}, 1},
    {"marble.cal", "marble", 0.63770927622914386, {0.7}, 1},
    {"dirt.cal", "dirt", 0.71557227252411049, {0.7}, 1},
    {"wrinkle.cal", "xwrink", 0, {0.1, 0.5, 0.3}, 3},
    {"wrinkle.cal", "ywrink", 0.013912532221837491, {0.1, 0.5, 0.3}, 3},
    {"wrinkle.cal", "zwrink", 0.040095046714878402, {0.1, 0.5, 0.3}, 3},
    {"brick.cal", "brick_x", 0.29999999999999999, {0.05, 0.2, 0.5, 0.25, 0.8, 0.3}, 6},
    {"brick.cal", "brick_y", 0.80000000000000004, {0.05, 0.2, 0.5, 0.25, 0.8, 0.3}, 6},
    {"brick.cal", "brick_xy", 0.80000000000000004, {0.05, 0.2, 0.5, 0.25, 0.8, 0.3}, 6},
    {"brick.cal", "f_brick_xy", 0.10000000000000035, {0.05, 0.2, 0.5, 0.25, 0.8, 0.3}, 6},
    {"brick.cal", "brick_swx", 1, {0.05, 0.2, 0.5, 0.25, 0.8, 0.3}, 6},
    {"corrug.cal", "xcor", 0.032084778529404258, {0.7}, 1},
    {"corrug.cal", "ycor", 0, {0.7}, 1},
    {"corrug.cal", "zcor", 0.081256932358208633, {0.7}, 1},
    {"carpet.cal", "carpr", 0.10967288332606347, {0.7, 0.5, 0.3, 0.8}, 4},
    {"carpet.cal", "carpg", 0.041299600686175442, {0.7, 0.5, 0.3, 0.8}, 4},
    {"carpet.cal", "carpb", 0.0093757144951826625, {0.7, 0.5, 0.3, 0.8}, 4},
    {"slate.cal", "slate_dx", -0.022560738807509358, {0}, 0},
    {"slate.cal", "slate_dy", 0.020168173085831926, {0}, 0},
    {"slate.cal", "slate_dz", -0.0013004068744125665, {0}, 0},
    {"gloss.cal", "gloss_dx", -0.10605576470782126, {0.1, 0.2, 0.3}, 3},
    {"gloss.cal", "gloss_dy", -0.066715301793907195, {0.1, 0.2, 0.3}, 3},
    {"gloss.cal", "gloss_dz", 0.0052674958558746928, {0.1, 0.2, 0.3}, 3},
    {"adobe.cal", "dx", -0.485298830400821, {0.3}, 1},
    {"adobe.cal", "dy", 0.10883475288610556, {0.3}, 1},
    {"adobe.cal", "dz", -0.15089726691689953, {0.3}, 1},
    {"prism.cal", "coef1", 0.62765655357760453, {1.5, 0.3, 0.5, 0.2}, 4},
    {"prism.cal", "dx1", 0.35999999999999999, {1.5, 0.3, 0.5, 0.2}, 4},
    {"prism.cal", "dy1", 0.75546971573542143, {1.5, 0.3, 0.5, 0.2}, 4},
    {"prism.cal", "dz1", 0.54741712487521033, {1.5, 0.3, 0.5, 0.2}, 4},
    {"prism.cal", "coef2", 0, {1.5, 0.3, 0.5, 0.2}, 4},
    {"prism.cal", "dx2", 0.35999999999999999, {1.5, 0.3, 0.5, 0.2}, 4},
    {"prism.cal", "dy2", 1.1867160558914294, {1.5, 0.3, 0.5, 0.2}, 4},
    {"prism.cal", "dz2", 0.73809965170597036, {1.5, 0.3, 0.5, 0.2}, 4},
    {"prism.cal", "coef1", 0.21290052710371682, {1.6, 0.1, 0.2, 0.6}, 4},
    {"prism.cal", "dx1", 0.35999999999999999, {1.6, 0.1, 0.2, 0.6}, 4},
    {"prism.cal", "dy1", 0.76471405430019768, {1.6, 0.1, 0.2, 0.6}, 4},
    {"prism.cal", "dz1", 0.53442718414743318, {1.6, 0.1, 0.2, 0.6}, 4},
    {"prism.cal", "coef2", 0, {1.6, 0.1, 0.2, 0.6}, 4},
    {"prism.cal", "dx2", 0.35999999999999999, {1.6, 0.1, 0.2, 0.6}, 4},
    {"prism.cal", "dy2", 0.17747101074899072, {1.6, 0.1, 0.2, 0.6}, 4},
    {"prism.cal", "dz2", 0.9934319293506606, {1.6, 0.1, 0.2, 0.6}, 4},
    {"retrorefl.cal",
     "retro_paint(.6,.64,.48)",
     0.15243178391151252,
     {0.7, 0.8, 0.9, 0.3, 10},
     5},
    {"retrorefl.cal",
     "retro_sheet(-Dx,-Dy,-Dz)",
     530.86801900055764,
     {0.7, 0.8, 0.9, 0.3, 10},
     5},
    {"retrorefl.cal", "obs_mult1(.3)", 2.7633557568774192, {0.7, 0.8, 0.9, 0.3, 10}, 5},
    {"retrorefl.cal", "obs_mult1(5)", 0.1336988471837921, {0.7, 0.8, 0.9, 0.3, 10}, 5},
    {"retrorefl.cal", "obs_mult1(25)", 0.026166666666666668, {0.7, 0.8, 0.9, 0.3, 10}, 5},
    {"disk2square.cal", "out_square_x", 0.62523112865261876, {0}, 0},
    {"disk2square.cal", "out_square_y", 0.24151208925754386, {0}, 0},
    {"disk2square.cal", "out_disk_x", 0.2999999999999996, {0}, 0},
    {"disk2square.cal", "out_disk_y", -0.51961524227066336, {0}, 0},
    {"disk2square.cal", "scbin", -1, {0}, 0},
    {"tregenza.cal", "tbin", 111, {0}, 0},
    {"reinhart.cal", "rbin", 111, {0}, 0},
    {"klems_full.cal", "kbinN", 109, {0}, 0},
    {"klems_full.cal", "kbinE", 130, {0}, 0},
    {"klems_full.cal", "kbinS", -1, {0}, 0},
    {"klems_full.cal", "kbinW", -1, {0}, 0},
    {"klems_full.cal", "kbinD", 65, {0}, 0},
    {"klems_full.cal", "kbin(.6,0,.8,0,1,0)", -1, {0}, 0},
    {"klems_full.cal", "Nkbins", 145, {0}, 0},
    {"klems_half.cal", "khbin(.6,0,.8,0,1,0)", -1, {0}, 0},
    {"klems_half.cal", "Nkhbins", 73, {0}, 0},
    {"klems_quarter.cal", "kqbin(.6,0,.8,0,1,0)", -1, {0}, 0},
    {"klems_quarter.cal", "Nkqbins", 41, {0}, 0},
    {"weave.cal", "weave", 0.10000000000000001, {0.7}, 1},
    {"weave.cal", "weave", 1, {0.2}, 1},
    {"jigglepic.cal", "jigglepic_u", 1.3747936000000012, {0.7}, 1},
    {"jigglepic.cal", "jigglepic_v", -2.348195962383874, {0.7}, 1},
    {"jigglepic.cal", "jiggletile_u", 0.37479360000000117, {0.7}, 1},
    {"jigglepic.cal", "jiggletile_v", 0.65180403761612604, {0.7}, 1},
    {"jigglepic.cal", "jigglematch_u", 0.62520639999999883, {0.7}, 1},
    {"jigglepic.cal", "jigglematch_v", 0.34819596238387396, {0.7}, 1},
    {"jigglepic.cal", "fjigglepic_u", 1.1237394652838431, {0.7}, 1},
    {"jigglepic.cal", "fjigglepic_v", -1.9097772422953549, {0.7}, 1},
    {"jigglepic.cal", "fjiggletile_u", 0.12373946528384305, {0.7}, 1},
    {"jigglepic.cal", "fjiggletile_v", 0.090222757704645051, {0.7}, 1},
    {"jigglepic.cal", "fjigglematch_u", 0.87626053471615695, {0.7}, 1},
    {"jigglepic.cal", "fjigglematch_v", 0.090222757704645051, {0.7}, 1},
    {"jigglepic.cal", "jigglepic_u", 1.3213696000000004, {0.2, 1.5}, 2},
    {"jigglepic.cal", "jigglepic_v", -2.3851988463953924, {0.2, 1.5}, 2},
    {"jigglepic.cal", "jiggletile_u", 0.32136960000000037, {0.2, 1.5}, 2},
    {"jigglepic.cal", "jiggletile_v", 0.61480115360460763, {0.2, 1.5}, 2},
    {"jigglepic.cal", "jigglematch_u", 0.67863039999999963, {0.2, 1.5}, 2},
    {"jigglepic.cal", "jigglematch_v", 0.61480115360460763, {0.2, 1.5}, 2},
    {"jigglepic.cal", "fjigglepic_u", 1.2496398472239552, {0.2, 1.5}, 2},
    {"jigglepic.cal", "fjigglepic_v", -2.2599363549415301, {0.2, 1.5}, 2},
    {"jigglepic.cal", "fjiggletile_u", 0.24963984722395516, {0.2, 1.5}, 2},
    {"jigglepic.cal", "fjiggletile_v", 0.74006364505846989, {0.2, 1.5}, 2},
    {"jigglepic.cal", "fjigglematch_u", 0.75036015277604484, {0.2, 1.5}, 2},
    {"jigglepic.cal", "fjigglematch_v", 0.74006364505846989, {0.2, 1.5}, 2},
    {"jigglepic.cal", "jigglepic_u", 1.3213696000000004, {0.2, 0.6}, 2},
    {"jigglepic.cal", "jigglepic_v", -2.3851988463953924, {0.2, 0.6}, 2},
    {"jigglepic.cal", "jiggletile_u", 1.3213696000000004, {0.2, 0.6}, 2},
    {"jigglepic.cal", "jiggletile_v", 0.61480115360460763, {0.2, 0.6}, 2},
    {"jigglepic.cal", "jigglematch_u", 1.3213696000000004, {0.2, 0.6}, 2},
    {"jigglepic.cal", "jigglematch_v", 0.38519884639539237, {0.2, 0.6}, 2},
    {"jigglepic.cal", "fjigglepic_u", 1.2496398472239552, {0.2, 0.6}, 2},
    {"jigglepic.cal", "fjigglepic_v", -2.2599363549415301, {0.2, 0.6}, 2},
    {"jigglepic.cal", "fjiggletile_u", 1.2496398472239552, {0.2, 0.6}, 2},
    {"jigglepic.cal", "fjiggletile_v", 0.74006364505846989, {0.2, 0.6}, 2},
    {"jigglepic.cal", "fjigglematch_u", 1.2496398472239554, {0.2, 0.6}, 2},
    {"jigglepic.cal", "fjigglematch_v", 0.25993635494153011, {0.2, 0.6}, 2},
    {"tim1.cal", "stran", 0.70923035395555745, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.2, 0.6, 0.3}, 12},
    {"tim1.cal",
     "brtdf(.1,.2,.3)",
     0.018510970587621522,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.2, 0.6, 0.3},
     12},
    {"tim1.cal",
     "brtdf(-.1,.2,-.9)",
     0.069416139703580695,
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0.2, 0.6, 0.3},
     12},
    {"orange.cal", "otex_dx", -0.05339887774769659, {0.1}, 1},
    {"orange.cal", "otex_dy", 0.040049158310772437, {0.1}, 1},
    {"orange.cal", "otex_dz", -0.14390597783246287, {0.1}, 1},
    {"covelight.cal", "cove_mult", 0.00012280303439776561, {1, 2, 30, 4, 5, 31}, 6},
    {"covelight.cal",
     "cove_mult",
     0.0019914056777953497,
     {1, 2, 30, 4, 5, 31, -3, -4, 8, -2, 5, 12},
     12},
    {"reinhartb.cal", "rbin", 110, {0}, 0},
    {"reinhartb.cal", "Nrbins", 145, {0}, 0},
    {"hermite.cal", "hermite(1,2,3,4,Px)", 4.0550000000000006, {0}, 0},
    {"trans.cal", "tn", 0.95841543512621041, {0}, 0},
    {"trans.cal", "rn", 0.042579994960947345, {0}, 0},
    {"trans.cal", "Rn", 0.078492200431335465, {0}, 0},
};

static const double ray[PM_RAY_VALUES] = {.36,  .48,  .8,  .1,   -.3,  .948683298050513799,
                                          1.3,  -2.4, .7,  12.5, .77,  2,
                                          1,    2,    3,   .6,   .8,   0,
                                          -.48, .36,  .8,  .64,  -.48, .6,
                                          3.5,  .25,  .75, .2,   -.25, .947,
                                          .7,   .5,   .6,  .7,   0,    0,
                                          0};

static struct bench row_bench(const struct row *row)
{
    static const char globals[] = "rNx=.6;rNy=0;rNz=.8;Ux=0;Uy=1;Uz=0;SCdim=16;"
                                  "in_square_x=.7;in_square_y=.2;";
    const struct pm_language_text text = {globals, "globals", 1, 1};
    struct bench b = bench_of("");
    size_t size;
    assert_int_equal(
        pm_language_define(b.language, PM_CONTEXT_GLOBAL, &text, sizeof globals - 1, NULL),
        PM_OK);
    bench_read(&b, row->file, pm_language_standard(row->file, &size));
    assert_string_equal(b.message, "");
    memcpy(b.ray.value, ray, sizeof ray);
    bench_reals(&b, row->real_count, row->reals);
    if (strcmp(row->file, "ball.cal") == 0 || strcmp(row->file, "globe.cal") == 0 ||
        strcmp(row->file, "orange.cal") == 0)
        set(&b, PM_RAY_PX, .36, .48, .8);
    if (strcmp(row->file, "cyl.cal") == 0)
        set(&b, PM_RAY_PX, .6, .8, .7);
    return b;
}

/* Noise is rounded where it jumps, so nothing needs more than the rounding of formulas that are
 * ordered otherwise. */
static void files_agree_with_radiance(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof of_radiance / sizeof *of_radiance; i++) {
        struct bench b = row_bench(&of_radiance[i]);
        bench_near(&b, of_radiance[i].text, of_radiance[i].value, 1e-12);
        pm_language_free(b.language);
    }
}

static void unknown_files_are_not_there(void **state)
{
    (void)state;
    size_t size = 7;
    assert_null(pm_language_standard("nothing.cal", &size));
    assert_null(pm_language_standard("", &size));
    assert_int_equal(size, 7);
}

/* CIE overcast: a third of the zenith's luminance at the horizon, (1 + 2 sin h) / 3 between.
 * The ground takes over within a degree. */
static void overcast_sky_is_moon_and_spencers(void **state)
{
    (void)state;
    struct bench b = standard_bench("skybright.cal");
    bench_reals(&b, 7, (const double[]){2, 90, 11, 1, 0, 0, 0});
    for (int h = 3; h <= 90; h += 3) {
        set(&b, PM_RAY_DX, 0, cos(h * DEG), sin(h * DEG));
        double up = pow(1.01 + sin(h * DEG), 10), sky = 30 * (1 + 2 * sin(h * DEG));
        bench_near(&b, "cloudysky", sky, ROUNDING);
        bench_near(&b, "skybr", (up * sky + 11 / up) / (up + 1 / up), 1e-13);
        set(&b, PM_RAY_DX, 0, cos(h * DEG), -sin(h * DEG));
        if (h > 30)
            bench_near(&b, "skybr", 11, 1e-2);
    }
    pm_language_free(b.language);
}

/* Perez et al. 1993, eq. 1: f = (1 + a exp(b / cos z)) (1 + c exp(d g) + e cos^2 g). */
static void all_weather_sky_is_perezs(void **state)
{
    (void)state;
    struct bench b = standard_bench("perezlum.cal");
    const double c[5] = {-.9, -.25, 8, -2.5, .3};
    const double sun[3] = {0, -cos(40 * DEG), sin(40 * DEG)};
    bench_reals(&b, 10,
                (const double[]){7, 3, c[0], c[1], c[2], c[3], c[4], sun[0], sun[1], sun[2]});
    for (int h = 1; h <= 90; h += 4)
        for (int a = 0; a < 360; a += 30) {
            double d[3] = {cos(h * DEG) * sin(a * DEG), cos(h * DEG) * cos(a * DEG),
                           sin(h * DEG)};
            double g = acos(d[1] * sun[1] + d[2] * sun[2]);
            double f = (1 + c[0] * exp(c[1] / fmax(d[2], .01))) *
                       (1 + c[2] * exp(c[3] * g) + c[4] * cos(g) * cos(g));
            set(&b, PM_RAY_DX, d[0], d[1], d[2]);
            bench_near(&b, "intersky", 7 * f, 1e-12);
        }
    pm_language_free(b.language);
}

/* Light that leaves along a direction is seen by rays against it. */
static void luminaire_angles_are_those_of_type_c(void **state)
{
    (void)state;
    struct bench b = standard_bench("source.cal");
    bench_reals(&b, 4, (const double[]){2, .3, .4, .5});
    for (int theta = 5; theta < 180; theta += 25)
        for (int phi = 5; phi < 360; phi += 20) {
            double s = sin(theta * DEG);
            set(&b, PM_RAY_DX, -s * cos(phi * DEG), -s * sin(phi * DEG), cos(theta * DEG));
            bench_near(&b, "src_theta", theta, 1e-12);
            bench_near(&b, "src_phi", phi, 1e-12);
            bench_near(&b, "src_phi2", phi < 180 ? phi : 360 - phi, 1e-12);
            bench_near(&b, "src_phi4", 90 - fabs(90 - fmod(phi, 180)), 1e-12);
        }
    set(&b, PM_RAY_DX, 0, 0, 1);
    b.ray.value[PM_RAY_RDOT] = .5;
    bench_near(&b, "boxcorr(12)", 2 * 12 / (.3 * .4), 1e-13);
    bench_near(&b, "cylcorr(12)", 2 * 12 / (acos(-1) / 4 * .09), 1e-13);
    bench_near(&b, "flatcorr(12)", 48, 1e-13);
    set(&b, PM_RAY_DX, 1, 0, 0);
    bench_near(&b, "boxcorr(12)", 2 * 12 / (.4 * .5), 1e-13);
    bench_near(&b, "cylcorr(12)", 2 * 12 / (.3 * .4), 1e-13);
    pm_language_free(b.language);
}

/* The centre of each of Tregenza's patches lies in that patch; so it does in Reinhart's with
 * one patch each. */
static void sky_patches_hold_their_centres(void **state)
{
    (void)state;
    static const int counts[8] = {30, 30, 24, 24, 18, 12, 6, 1};
    struct bench tregenza = standard_bench("tregenza.cal");
    struct bench reinhart = standard_bench("reinhart.cal");
    int bin = 1;
    for (int row = 0; row < 8; row++)
        for (int i = 0; i < counts[row]; i++, bin++) {
            double h = (row < 7 ? 6 + 12 * row : 90) * DEG, a = 360. * i / counts[row] * DEG;
            set(&tregenza, PM_RAY_DX, sin(a) * cos(h), cos(a) * cos(h), sin(h));
            set(&reinhart, PM_RAY_DX, sin(a) * cos(h), cos(a) * cos(h), sin(h));
            bench_near(&tregenza, "tbin", bin, 0);
            bench_near(&reinhart, "rbin", bin, 0);
        }
    set(&tregenza, PM_RAY_DX, 0, .6, -.8);
    bench_near(&tregenza, "tbin", 0, 0);
    bench_near(&tregenza, "Ntbins", bin, 0);
    bench_near(&reinhart, "Nrbins", bin, 0);
    pm_language_free(tregenza.language);
    pm_language_free(reinhart.language);
}

static void klems_centres(const char *file, const char *bin, const char *count,
                          const double *tops, const int *counts, int rows)
{
    struct bench b = standard_bench(file);
    int number = 0;
    for (int row = 0; row < rows; row++)
        for (int i = 0; i < counts[row]; i++, number++) {
            double polar = row ? (tops[row - 1] + tops[row]) / 2 * DEG : 0;
            double azimuth = 360. * i / counts[row] * DEG, s = sin(polar);
            /* Normal +z, up +y: azimuth 0 is where the file's x axis, -(up x normal), points.
             */
            set(&b, PM_RAY_DX, -s * cos(azimuth), -s * sin(azimuth), -cos(polar));
            bench_near(&b, bin, number, 0);
        }
    bench_near(&b, count, number, 0);
    set(&b, PM_RAY_DX, 0, 0, 1);
    bench_near(&b, bin, -1, 0);
    pm_language_free(b.language);
}

static void klems_bins_hold_their_centres(void **state)
{
    (void)state;
    klems_centres("klems_full.cal", "kbin(0,0,1, 0,1,0)", "Nkbins",
                  (const double[]){5, 15, 25, 35, 45, 55, 65, 75, 90},
                  (const int[]){1, 8, 16, 20, 24, 24, 24, 16, 12}, 9);
    klems_centres("klems_half.cal", "khbin(0,0,1, 0,1,0)", "Nkhbins",
                  (const double[]){6.5, 19.5, 32.5, 46.5, 61.5, 76.5, 90},
                  (const int[]){1, 8, 12, 16, 20, 12, 4}, 7);
    klems_centres("klems_quarter.cal", "kqbin(0,0,1, 0,1,0)", "Nkqbins",
                  (const double[]){9, 27, 46, 66, 90}, (const int[]){1, 8, 12, 12, 8}, 5);
}

/* The two maps of disk2square.cal undo each other. */
static void disk_and_square_map_onto_each_other(void **state)
{
    (void)state;
    size_t size;
    for (int i = 0; i < 400; i++) {
        struct bench b = bench_of("");
        char text[200];
        double x = i % 20 / 20. + .013, y = i / 20 / 20. + .027;
        snprintf(text, sizeof text,
                 "in_square_x=%.17g;in_square_y=%.17g;rNx=0;rNy=0;rNz=-1;"
                 "Ux=0;Uy=1;Uz=0;SCdim=8;",
                 x, y);
        const struct pm_language_text globals = {text, "g", 1, 1};
        assert_int_equal(
            pm_language_define(b.language, PM_CONTEXT_GLOBAL, &globals, strlen(text), NULL),
            PM_OK);
        bench_read(&b, "disk2square.cal", pm_language_standard("disk2square.cal", &size));
        double u = bench_value(&b, "out_disk_x"), v = bench_value(&b, "out_disk_y");
        assert_true(u * u + v * v < 1 + 1e-12);
        /* Normal -z, up +y, right-handed: in_disk is (-Dx', -Dy) of the direction. */
        set(&b, PM_RAY_DX, -u, -v, sqrt(fmax(0, 1 - u * u - v * v)));
        double right = bench_value(&b, "in_disk_x") / u, up = bench_value(&b, "in_disk_y") / v;
        assert_true(fabs(fabs(right) - 1) < 1e-9 && fabs(fabs(up) - 1) < 1e-9);
        bench_near(&b, "out_square_x", right > 0 ? x : 1 - x, 1e-9);
        bench_near(&b, "out_square_y", up > 0 ? y : 1 - y, 1e-9);
        pm_language_free(b.language);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_agree_with_radiance),
        cmocka_unit_test(unknown_files_are_not_there),
        cmocka_unit_test(overcast_sky_is_moon_and_spencers),
        cmocka_unit_test(all_weather_sky_is_perezs),
        cmocka_unit_test(luminaire_angles_are_those_of_type_c),
        cmocka_unit_test(sky_patches_hold_their_centres),
        cmocka_unit_test(klems_bins_hold_their_centres),
        cmocka_unit_test(disk_and_square_map_onto_each_other),
    };
    return cmocka_run_group_tests_name("language.standard", tests, NULL, NULL);
}
