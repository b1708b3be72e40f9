#ifndef PM_FILES_BSDF_INTERNAL_H
#define PM_FILES_BSDF_INTERNAL_H

#include <stddef.h>
#include <stdint.h>

#include "files/bsdf.h"
#include "files/bsdf_klems.h"
#include "files/bsdf_tree.h"

/* As in Radiance: less is not worth a part of its own [1/sr], [1]. */
#define PM_BSDF_LEAST_DIFFUSE (.01 / 3.14159265358979323846)
#define PM_BSDF_LEAST_REST    .001

/* The four combinations: which side a walk comes from, and whether it goes through. */
enum pm_bsdf_way {
    PM_BSDF_REFLECT_BACK,
    PM_BSDF_REFLECT_FRONT,
    PM_BSDF_TRANSMIT_BACK, /* comes from the back */
    PM_BSDF_TRANSMIT_FRONT,
    PM_BSDF_WAYS,
};

/* Peaks of walks one way through, a row for each direction that the data distinguish. */
struct pm_bsdf_peaks {
    struct pm_bsdf_peak_row {
        pm_rgb transmittance;
        double share;
        uint32_t first; /* of its cells */
        uint16_t count;
        bool found;
    } * rows; /* NULL if directions within a row differ: then each is searched */
    struct pm_bsdf_cell *cells;
};

struct pm_bsdf {
    struct pm_klems *matrix[PM_BSDF_WAYS]; /* at most one of these two is set */
    struct pm_tree *tree[PM_BSDF_WAYS];
    pm_rgb diffuse[PM_BSDF_WAYS];  /* Lambertian albedos */
    struct pm_bsdf_peaks peaks[2]; /* of walks from the back, from the front */
    pm_bsdf_info info;
};

/* Linear RGB of Radiance's primaries from CIE XYZ; negative channels become 0. */
pm_rgb pm_bsdf_rgb(double x, double y, double z);

/* The same from the luminance and CIE 1976 u', v'. */
pm_rgb pm_bsdf_rgb_from_yuv(double y, double u, double v);

/* ---- the file's text (bsdf_xml.c) ---- */

enum pm_bsdf_band { PM_BSDF_Y, PM_BSDF_FIRST, PM_BSDF_SECOND, PM_BSDF_BANDS };

/* What one WavelengthDataBlock holds, as it stands there. */
struct pm_bsdf_block {
    struct pm_klems_basis in, out; /* of matrices */
    float *values;                 /* of matrices: in the file's order */
    size_t count;
    struct pm_tree_nodes nodes; /* of trees */
    bool given;
    int line;
};

/* What the file holds. */
struct pm_bsdf_text {
    unsigned rank;    /* of the tree: 3 or 4; 0: a matrix */
    bool rows_are_in; /* of matrices: consecutive values share the direction of incidence */
    struct pm_bsdf_block block[PM_BSDF_WAYS][PM_BSDF_BANDS];
    double size[3]; /* width, height, thickness [m] */
    bool has_geometry;
};

PM_MUST_USE pm_status pm_bsdf_text_read(const void *bytes, size_t size, const char *name,
                                        struct pm_bsdf_text *out, pm_error *err);
void pm_bsdf_text_clear(struct pm_bsdf_text *text);

/* ---- the rest's queries one way, before the scaling of albedos over 1 (bsdf.c) ---- */

/* The data that a walk from `in` uses. */
struct pm_bsdf_part {
    const struct pm_klems *matrix;
    const struct pm_tree *tree;
    bool reversed;
};

bool pm_bsdf_part_of(const pm_bsdf *bsdf, pm_vec3 in, bool transmitted,
                     struct pm_bsdf_part *out);
/* Centre of the i-th row of directions with z > 0 that a walk may come from; false beyond the
 * last. */
bool pm_bsdf_part_direction(const struct pm_bsdf_part *part, size_t i, pm_vec3 *in);
pm_rgb pm_bsdf_part_value(const struct pm_bsdf_part *part, pm_vec3 in, pm_vec3 out);
bool pm_bsdf_cell(const struct pm_bsdf_part *part, pm_vec3 in, pm_vec3 out,
                  struct pm_bsdf_place *place);

/* bsdf_peak.c: the last step of reading. */
PM_MUST_USE pm_status pm_bsdf_peaks_find(pm_bsdf *bsdf);
void pm_bsdf_peaks_clear(pm_bsdf *bsdf);

/* What an albedo over 1 is scaled by; 1 for others. */
double pm_bsdf_gain(const pm_bsdf *bsdf, pm_vec3 in);

#endif
