#ifndef PM_FILES_BSDF_H
#define PM_FILES_BSDF_H

#include <stdbool.h>
#include <stddef.h>

#include "base/error.h"
#include "base/rgb.h"
#include "base/vec3.h"

/* Bidirectional scattering distributions as LBNL's WINDOW and Radiance's genBSDF write them in
 * XML: Klems matrices and tensor trees.
 *
 * In: a file's bytes. Out: pm_bsdf (immutable, shared without locks). Next: world/ makes lobes
 * of it.
 *
 * Directions are unit and point away from the surface. +z is the front, towards the interior;
 * +y is up; +x is to the right as seen from the front. Files say it the other way round: their
 * "Front" is the exterior, so "Transmission Front" holds light that comes from the back here,
 * as in Radiance. `in` is where a walk comes from, `out` where it goes on. Files need not be
 * reciprocal: as in Radiance `in` picks the column whichever way the walk goes, and where a
 * file gives transmission from one side only, the other side follows by reciprocity.
 *
 * A distribution is the sum of a Lambertian part (the least value, if at least 0.01 / pi) and
 * the rest, each for the four combinations of side and reflection or transmission. Where a
 * direction's albedo exceeds 1, everything that comes from there is scaled to 1; a file with
 * an albedo over PM_BSDF_ALBEDO_MAX is refused.
 *
 * Sources: Klems, "A new method for predicting the solar heat gain of complex fenestration
 * systems", ASHRAE Transactions 100(1), 1994 (angle bases); Ward, Kurt, Bonneel, "Reducing
 * anisotropic BSDF measurement to common practice", 2014 (tensor trees); Shirley and Chiu, "A
 * low distortion map between disk and square", JGT 2(3), 1997; McNeil et al., Radiance's
 * src/common/bsdf*.c (formats and conventions). Tests: tests/engine/files/test_bsdf_*.c. */

#define PM_BSDF_ALBEDO_MAX 2

typedef struct pm_bsdf pm_bsdf;

/* Reads `size` bytes; `name` is for messages. Understood are WindowElement/Optical/Layer (the
 * first layer, as in Radiance) with
 *   IncidentDataStructure  Columns, Rows, TensorTree3, TensorTree4; before any WavelengthData
 *   angle bases            LBNL/Klems Full, Half, Quarter, those of AngleBasis elements, and
 *                          LBNL/Shirley-Chiu
 *   wavelengths            Visible; with CIE-X and CIE-Z (matrices) or CIE-u and CIE-v (trees)
 *                          it has colour. Others (Solar, NIR) carry no light and are left out.
 * A Geometry in MGF is left out too: the scene holds the geometry itself, if it wants one.
 * Refused are a document type declaration (so: entities), other formats, missing or surplus
 * values, numbers that are not finite. Negative values are 0, as in Radiance. Memory is at most
 * four times the file's size plus 64 MiB.
 * Errors: PM_E_SYNTAX, PM_E_RANGE, PM_E_UNSUPPORTED, PM_E_MISSING, PM_E_LIMIT, PM_E_MEMORY. */
PM_MUST_USE pm_status pm_bsdf_read(const void *bytes, size_t size, const char *name,
                                   pm_bsdf **out, pm_error *err);
void pm_bsdf_free(pm_bsdf *bsdf);

typedef struct pm_bsdf_info {
    double width, height, thickness; /* of the element [m]; 0 if the file does not say */
    bool is_tree;
    bool has_geometry;        /* an MGF description, which was left out */
    bool reflects, transmits; /* from either side, Lambertian part or rest */
    bool rest_reflects[2];    /* there is more than the Lambertian part; [0] back, [1] front */
    bool rest_transmits[2];   /* likewise, by where the walk comes from */
    double albedo_max;        /* largest luminous albedo before scaling */
} pm_bsdf_info;

void pm_bsdf_info_get(const pm_bsdf *bsdf, pm_bsdf_info *out);

/* Lambertian albedos for a walk that comes from `in`. */
pm_rgb pm_bsdf_diffuse_reflectance(const pm_bsdf *bsdf, pm_vec3 in);
pm_rgb pm_bsdf_diffuse_transmittance(const pm_bsdf *bsdf, pm_vec3 in);

/* The rest [1/sr]; multiply by |out.z| for the scattered share. */
pm_rgb pm_bsdf_value(const pm_bsdf *bsdf, pm_vec3 in, pm_vec3 out);

/* Albedo of the rest: its integral over projected solid angle on one side of the surface. Its
 * luminance is exact but for trees finer than 128 cells, and for transmission through an
 * isotropic tree against the direction that the file gives: there it is a quadrature. For trees
 * with colour the three channels share the luminance. */
pm_rgb pm_bsdf_albedo(const pm_bsdf *bsdf, pm_vec3 in, bool transmitted);

/* Draws a direction of the rest on one side of the surface, by its luminance (of matrices: by
 * the mean of its channels). u, v in [0, 1). False if there is none. */
bool pm_bsdf_sample(const pm_bsdf *bsdf, pm_vec3 in, bool transmitted, double u, double v,
                    pm_vec3 *out);

/* Its density, given the side on which `out` lies [1/sr]. */
double pm_bsdf_pdf(const pm_bsdf *bsdf, pm_vec3 in, pm_vec3 out);

/* The peak about straight passage, which aBSDF treats as straight passage itself. */
enum { PM_BSDF_PEAK_CELLS = 32 };
typedef struct pm_bsdf_peak {
    pm_rgb transmittance; /* of straight passage; black if there is no peak */
    double share;         /* of the density that the cells hold */
    unsigned count;
    struct pm_bsdf_cell {
        double start, share;     /* of the unit interval that picks cells */
    } cells[PM_BSDF_PEAK_CELLS]; /* ascending */
} pm_bsdf_peak;

/* Finds the peak by Radiance's search (29 directions about -in; a peak is at least 8 times its
 * surroundings and carries at least 0.05 %; m_bsdf.c, compute_through), but takes whole cells:
 * they count for straight passage and nothing else, and it looks from the middle of the cell
 * that holds `in`. Both ways through, the transmittance is the same. */
void pm_bsdf_peak_at(const pm_bsdf *bsdf, pm_vec3 in, pm_bsdf_peak *out);

/* The same as above without the peak's cells. */
pm_rgb pm_bsdf_value_without(const pm_bsdf *bsdf, const pm_bsdf_peak *peak, pm_vec3 in,
                             pm_vec3 out);
bool pm_bsdf_sample_without(const pm_bsdf *bsdf, const pm_bsdf_peak *peak, pm_vec3 in, double u,
                            double v, pm_vec3 *out);
double pm_bsdf_pdf_without(const pm_bsdf *bsdf, const pm_bsdf_peak *peak, pm_vec3 in,
                           pm_vec3 out);

#endif
