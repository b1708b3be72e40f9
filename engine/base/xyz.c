#include "base/xyz.h"

/* CIE 1931 colour-matching functions every 5 nm from PM_NM_MIN to PM_NM_MAX. */
enum { STEP = 5, ENTRIES = 81 };

static const double observer[ENTRIES][3] = {
    {0.0014, 0.0000, 0.0065}, {0.0022, 0.0001, 0.0105}, {0.0042, 0.0001, 0.0201},
    {0.0076, 0.0002, 0.0362}, {0.0143, 0.0004, 0.0679}, {0.0232, 0.0006, 0.1102},
    {0.0435, 0.0012, 0.2074}, {0.0776, 0.0022, 0.3713}, {0.1344, 0.0040, 0.6456},
    {0.2148, 0.0073, 1.0391}, {0.2839, 0.0116, 1.3856}, {0.3285, 0.0168, 1.6230},
    {0.3483, 0.0230, 1.7471}, {0.3481, 0.0298, 1.7826}, {0.3362, 0.0380, 1.7721},
    {0.3187, 0.0480, 1.7441}, {0.2908, 0.0600, 1.6692}, {0.2511, 0.0739, 1.5281},
    {0.1954, 0.0910, 1.2876}, {0.1421, 0.1126, 1.0419}, {0.0956, 0.1390, 0.8130},
    {0.0580, 0.1693, 0.6162}, {0.0320, 0.2080, 0.4652}, {0.0147, 0.2586, 0.3533},
    {0.0049, 0.3230, 0.2720}, {0.0024, 0.4073, 0.2123}, {0.0093, 0.5030, 0.1582},
    {0.0291, 0.6082, 0.1117}, {0.0633, 0.7100, 0.0782}, {0.1096, 0.7932, 0.0573},
    {0.1655, 0.8620, 0.0422}, {0.2257, 0.9149, 0.0298}, {0.2904, 0.9540, 0.0203},
    {0.3597, 0.9803, 0.0134}, {0.4334, 0.9950, 0.0087}, {0.5121, 1.0000, 0.0057},
    {0.5945, 0.9950, 0.0039}, {0.6784, 0.9786, 0.0027}, {0.7621, 0.9520, 0.0021},
    {0.8425, 0.9154, 0.0018}, {0.9163, 0.8700, 0.0017}, {0.9786, 0.8163, 0.0014},
    {1.0263, 0.7570, 0.0011}, {1.0567, 0.6949, 0.0010}, {1.0622, 0.6310, 0.0008},
    {1.0456, 0.5668, 0.0006}, {1.0026, 0.5030, 0.0003}, {0.9384, 0.4412, 0.0002},
    {0.8544, 0.3810, 0.0002}, {0.7514, 0.3210, 0.0001}, {0.6424, 0.2650, 0.0000},
    {0.5419, 0.2170, 0.0000}, {0.4479, 0.1750, 0.0000}, {0.3608, 0.1382, 0.0000},
    {0.2835, 0.1070, 0.0000}, {0.2187, 0.0816, 0.0000}, {0.1649, 0.0610, 0.0000},
    {0.1212, 0.0446, 0.0000}, {0.0874, 0.0320, 0.0000}, {0.0636, 0.0232, 0.0000},
    {0.0468, 0.0170, 0.0000}, {0.0329, 0.0119, 0.0000}, {0.0227, 0.0082, 0.0000},
    {0.0158, 0.0057, 0.0000}, {0.0114, 0.0041, 0.0000}, {0.0081, 0.0029, 0.0000},
    {0.0058, 0.0021, 0.0000}, {0.0041, 0.0015, 0.0000}, {0.0029, 0.0010, 0.0000},
    {0.0020, 0.0007, 0.0000}, {0.0014, 0.0005, 0.0000}, {0.0010, 0.0004, 0.0000},
    {0.0007, 0.0002, 0.0000}, {0.0005, 0.0002, 0.0000}, {0.0003, 0.0001, 0.0000},
    {0.0002, 0.0001, 0.0000}, {0.0002, 0.0001, 0.0000}, {0.0001, 0.0000, 0.0000},
    {0.0001, 0.0000, 0.0000}, {0.0001, 0.0000, 0.0000}, {0.0000, 0.0000, 0.0000},
};

pm_rgb pm_rgb_of_xyz(double x, double y, double z)
{
    /* The inverse of the primaries' XYZ, each scaled so that they sum to white. Test:
     * xyz_of_the_primaries_are_the_unit_colours. */
    return (pm_rgb){2.565312843029638 * x - 1.166849615806806 * y - 0.3984632272228321 * z,
                    -1.022108172127911 * x + 1.978286616660087 * y + 0.04382155546782471 * z,
                    0.07472437729685585 * x - 0.2519395671702736 * y + 1.177215189873418 * z};
}

/* Adds the integrals of the three functions over [nm0, nm1], rising; linear between entries. */
static void integrate(double nm0, double nm1, double sum[3])
{
    double from = fmax((nm0 - PM_NM_MIN) / STEP, 0);
    double to = fmin((nm1 - PM_NM_MIN) / STEP, ENTRIES - 1);
    if (!(from < to))
        return;
    for (int i = (int)from; i < to; i++) {
        double t0 = from > i ? from - i : 0, t1 = to - i < 1 ? to - i : 1;
        for (int k = 0; k < 3; k++) {
            double slope = observer[i + 1][k] - observer[i][k];
            sum[k] += STEP * (t1 - t0) * (observer[i][k] + (t0 + t1) / 2 * slope);
        }
    }
}

/* Mixed with grey of the same luminance until no part is negative. */
static pm_rgb into_gamut(pm_rgb c, double luminance)
{
    double least = c.r < c.g ? c.r : c.g;
    least = c.b < least ? c.b : least;
    if (!(luminance > 0))
        return (pm_rgb){0, 0, 0};
    if (least >= 0)
        return c;
    double share = luminance / (luminance - least);
    pm_rgb grey = pm_rgb_grey((1 - share) * luminance);
    pm_rgb mixed = pm_rgb_madd(grey, share, c);
    return (pm_rgb){fmax(0, mixed.r), fmax(0, mixed.g), fmax(0, mixed.b)};
}

pm_rgb pm_rgb_of_spectrum(const double *samples, size_t count, double nm0, double nm1)
{
    double whole[3] = {0, 0, 0}, xyz[3] = {0, 0, 0};
    integrate(PM_NM_MIN, PM_NM_MAX, whole);
    for (size_t i = 0; i < count; i++) {
        double start = nm0 + (nm1 - nm0) * (double)i / (double)count;
        double end = nm0 + (nm1 - nm0) * (double)(i + 1) / (double)count;
        double part[3] = {0, 0, 0};
        integrate(fmin(start, end), fmax(start, end), part);
        for (int k = 0; k < 3; k++)
            xyz[k] += samples[i] * part[k] / whole[k];
    }
    return into_gamut(pm_rgb_of_xyz(xyz[0], xyz[1], xyz[2]), xyz[1]);
}
