#ifndef PM_BACKWARD_VIEW_H
#define PM_BACKWARD_VIEW_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/vec3.h"

/* How directions come to lie in the picture, which reaches to the view angles. The angle is
 * that between a direction and the view's. */
typedef enum pm_view_type {
    PM_VIEW_PERSPECTIVE,   /* -vtv: tangent of the angle; angles below 180 degrees */
    PM_VIEW_PARALLEL,      /* -vtl: the place; -vh and -vv are lengths */
    PM_VIEW_HEMISPHERICAL, /* -vth: sine of the angle; up to 180 degrees */
    PM_VIEW_CYLINDRICAL, /* -vtc: angle about the up vector, up to 360 degrees; tangent upwards
                          */
    PM_VIEW_ANGULAR,     /* -vta: the angle; up to 360 degrees */
    PM_VIEW_STEREOGRAPHIC, /* -vts: tangent of half the angle; below 360 degrees */
    PM_VIEW_TYPES,
} pm_view_type;

extern const char pm_view_letters[]; /* of the types: "vlhcas" */

/* A view as rpict means it. Angles in degrees, lengths in scene units. */
typedef struct pm_view {
    pm_view_type type; /* -vt */
    pm_vec3 point;     /* -vp, default 0 0 0 */
    pm_vec3 direction; /* -vd, default 0 1 0; need not be unit */
    pm_vec3 up;        /* -vu, default 0 0 1 */
    double horizontal; /* -vh, default 45 */
    double vertical;   /* -vv, default 45 */
    double shift;      /* -vs: to the right, in widths of the picture */
    double lift;       /* -vl: up, in its heights */
    double fore, aft;  /* -vo -va: what is seen begins and ends there; 0: at once, never. Planes
                          in perspective and parallel views, cylinders, spheres */
} pm_view;

pm_view pm_view_default(void);

/* Reads the options of a .vf file or of one line (`rvu -vtv -vp 0 1 -4 ...`; of several lines
 * each changes what it names, as in Radiance) over what `view` holds. Options that are not
 * about views are errors with line and column. */
PM_MUST_USE pm_status pm_view_parse(const char *text, const char *name, pm_view *view,
                                    pm_error *err);

/* PM_E_RANGE with the reason for a view that shows nothing (zero direction, up along it,
 * angles
 * beyond the type's, clipping that leaves nothing). */
PM_MUST_USE pm_status pm_view_check(const pm_view *view, pm_error *err);

/* The unit vector along v, whatever its length; zero for zero. */
pm_vec3 pm_view_unit(pm_vec3 v);

enum { PM_VIEW_TEXT = 512 }; /* bytes of any view as text */

/* "-vtv -vp x y z -vd ... -vh h -vv v", then what is not 0 of -vo -va -vs -vl; for picture
 * headers. */
void pm_view_format(const pm_view *view, char out[PM_VIEW_TEXT]);

/* Half the picture's width and height on the surface that the type projects to. */
void pm_view_extent(const pm_view *view, double *x, double *y);

/* The greatest picture within x by y whose pixels are `pixel_aspect` times as high as wide
 * (Radiance's -pa). 0 keeps x by y. */
void pm_view_fit(const pm_view *view, double pixel_aspect, uint32_t *x, uint32_t *y);

#endif
