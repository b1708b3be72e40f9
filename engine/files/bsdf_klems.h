#ifndef PM_FILES_BSDF_KLEMS_H
#define PM_FILES_BSDF_KLEMS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/error.h"
#include "base/rgb.h"
#include "base/vec3.h"
#include "files/bsdf_cell.h"

/* Matrices over Klems's angle bases: rings of polar angle, each cut into patches of azimuth.
 * Tests: test_bsdf_klems.c. */

enum { PM_KLEMS_RINGS = 46, PM_KLEMS_NAME = 64, PM_KLEMS_PATCHES = 2048 };

struct pm_klems_basis {
    char name[PM_KLEMS_NAME];
    uint32_t rings, patches;
    double upper[PM_KLEMS_RINGS + 1]; /* cosines of the rings' bounds, falling from 1 */
    uint32_t count[PM_KLEMS_RINGS];   /* patches of each ring */
    uint32_t first[PM_KLEMS_RINGS];   /* index of the first of them */
};

/* One of the three bases that files name without defining them; NULL for another name. */
bool pm_klems_basis_known(const char *name, struct pm_klems_basis *out);

/* Adds a ring up to `theta_deg` (0, 90]. False if the angle does not rise, the count is not in
 * range, or a ring other than the first has a single patch. */
bool pm_klems_basis_add(struct pm_klems_basis *basis, double theta_deg, uint32_t count);

/* Patch of a direction (x, y, |z|), -1 beyond the last ring. */
int32_t pm_klems_patch(const struct pm_klems_basis *basis, double x, double y, double z);

double pm_klems_projected(const struct pm_klems_basis *basis, uint32_t patch); /* [sr] */

/* A matrix, without its Lambertian part. */
struct pm_klems {
    struct pm_klems_basis in, out;
    unsigned channels; /* 1 or 3 */
    float *value;      /* [in][out][channels], 1/sr */
    /* Running sums of value x projected solid angle, [in][out + 1] and [out][in + 1]: doubles
     * would be no better, for what counts is that density and sampling use the same ones. */
    float *cumulative[2];
    pm_rgb *albedo[2]; /* [in], and [out] of the reversed walk */
    double least;      /* smallest projected solid angle of a patch [sr] */
};

/* Takes `value` (malloc'd, 1/sr, [in][out][channels]) whatever comes. Moves the Lambertian part
 * to *diffuse. */
PM_MUST_USE pm_status pm_klems_new(const struct pm_klems_basis *in,
                                   const struct pm_klems_basis *out, unsigned channels,
                                   float *value, struct pm_klems **matrix, pm_rgb *diffuse);
void pm_klems_free(struct pm_klems *matrix);

/* The queries of bsdf.h; `reversed` walks come from the side where the file's light goes. */
pm_rgb pm_klems_value(const struct pm_klems *matrix, bool reversed, pm_vec3 in, pm_vec3 out);
pm_rgb pm_klems_albedo(const struct pm_klems *matrix, bool reversed, pm_vec3 in);
bool pm_klems_cell(const struct pm_klems *matrix, bool reversed, pm_vec3 in, pm_vec3 out,
                   struct pm_bsdf_place *place);
/* out.z > 0 always: the caller knows the side. */
bool pm_klems_sample(const struct pm_klems *matrix, bool reversed, pm_vec3 in, double u,
                     double v, pm_vec3 *out);

/* Centre of the i-th direction that a walk may come from; false beyond the last. */
bool pm_klems_direction(const struct pm_klems *matrix, bool reversed, uint32_t i, pm_vec3 *in);

/* Row of the walk's direction among pm_klems_direction's; -1 if it is in none. */
int32_t pm_klems_row(const struct pm_klems *matrix, bool reversed, pm_vec3 in);

#endif
