#ifndef PM_BACKWARD_VIEW_H
#define PM_BACKWARD_VIEW_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/vec3.h"

/* A perspective view as rpict means it (-vtv). Angles in degrees, lengths in scene units. */
typedef struct pm_view {
    pm_vec3 point;     /* -vp, default 0 0 0 */
    pm_vec3 direction; /* -vd, default 0 1 0; need not be unit */
    pm_vec3 up;        /* -vu, default 0 0 1 */
    double horizontal; /* -vh, default 45, in (0, 180) */
    double vertical;   /* -vv, default 45 */
} pm_view;

pm_view pm_view_default(void);

/* Reads the options of a .vf file or of one line (`rvu -vtv -vp 0 1 -4 ...`; the last view line
 * of several counts, as in Radiance) over what `view` holds. Other view types, and options that
 * are not about views, are errors with line and column. */
PM_MUST_USE pm_status pm_view_parse(const char *text, const char *name, pm_view *view,
                                    pm_error *err);

/* PM_E_RANGE with the reason for a view that shows nothing (zero direction, up along it,
 * angles). */
PM_MUST_USE pm_status pm_view_check(const pm_view *view, pm_error *err);

/* The unit vector along v, whatever its length; zero for zero. */
pm_vec3 pm_view_unit(pm_vec3 v);

/* "-vtv -vp x y z -vd ... -vh h -vv v", for picture headers. */
void pm_view_format(const pm_view *view, char *out, size_t size);

/* Radiance's rule for square pixels: the greatest picture within x by y whose aspect is the
 * view's. */
void pm_view_fit(const pm_view *view, uint32_t *x, uint32_t *y);

#endif
