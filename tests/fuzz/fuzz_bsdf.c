/* Reads the input as a BSDF file; whatever was read scatters no more light than comes, into
 * directions of finite density. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "files/bsdf.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_grey(pm_rgb c)
{
    check(pm_rgb_finite(c) && c.r >= 0 && c.g >= 0 && c.b >= 0);
}

static void check_pair(const pm_bsdf *bsdf, const pm_bsdf_peak *peak, pm_vec3 in, pm_vec3 out)
{
    check_grey(pm_bsdf_value(bsdf, in, out));
    check_grey(pm_bsdf_value_without(bsdf, peak, in, out));
    double pdf = pm_bsdf_pdf(bsdf, in, out);
    check(isfinite(pdf) && pdf >= 0);
    pdf = pm_bsdf_pdf_without(bsdf, peak, in, out);
    check(isfinite(pdf) && pdf >= 0);
}

static void check_sample(const pm_bsdf *bsdf, const pm_bsdf_peak *peak, pm_vec3 in, double u,
                         double v)
{
    pm_vec3 out;
    for (int through = 0; through < 2; through++)
        if (pm_bsdf_sample(bsdf, in, through, u, v, &out)) {
            check(((in.z > 0) != (out.z > 0)) == through);
            check(fabs(pm_vec3_length(out) - 1) < 1e-9);
            check_pair(bsdf, peak, in, out);
        }
    if (pm_bsdf_sample_without(bsdf, peak, in, u, v, &out))
        check((in.z > 0) != (out.z > 0));
}

static void check_direction(const pm_bsdf *bsdf, pm_vec3 in)
{
    pm_rgb total = pm_rgb_add(pm_bsdf_diffuse_reflectance(bsdf, in),
                              pm_bsdf_diffuse_transmittance(bsdf, in));
    total = pm_rgb_add(total, pm_bsdf_albedo(bsdf, in, false));
    total = pm_rgb_add(total, pm_bsdf_albedo(bsdf, in, true));
    check_grey(total);
    check(pm_rgb_max(total) <= 1 + 1e-6);
    pm_bsdf_peak peak;
    pm_bsdf_peak_at(bsdf, in, &peak);
    check_grey(peak.transmittance);
    check(peak.count <= PM_BSDF_PEAK_CELLS && peak.share >= 0 && peak.share <= 1 + 1e-6);
    check_pair(bsdf, &peak, in, pm_vec3_negate(in));
    check_pair(bsdf, &peak, in, in);
    for (int i = 0; i < 9; i++)
        check_sample(bsdf, &peak, in, (i / 3 + .01) / 3.01, i % 3 * .499);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const pm_vec3 directions[] = {{0, 0, 1},       {0, 0, -1},      {.6, 0, .8},
                                         {-.6, 0, -.8},   {0, 1, 1e-9},    {1, 0, -1e-12},
                                         {-.48, .6, .64}, {.48, -.36, -.8}};
    pm_error err = PM_ERROR_INIT;
    pm_bsdf *bsdf = NULL;
    if (pm_bsdf_read(data, size, "fuzz", &bsdf, &err)) {
        check(err.status && err.text[0] && !bsdf);
        return 0;
    }
    for (size_t i = 0; i < sizeof directions / sizeof *directions; i++)
        check_direction(bsdf, directions[i]);
    pm_bsdf_free(bsdf);
    return 0;
}
