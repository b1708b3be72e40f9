#ifndef PM_SCENE_XFORM_H
#define PM_SCENE_XFORM_H

#include "base/arena.h"
#include "scene/command.h"
#include "scene/scene.h"
#include "scene/transform.h"

/* What Radiance's xform(1) does to a scene, run inside the process. */

enum { PM_XFORM_GROUPS = 64 };

/* Transforms to apply `count` times; an array makes a copy of the scene for 0 .. count - 1
 * times. */
typedef struct pm_xform_group {
    pm_transform transform;
    uint64_t count;
    bool array;
} pm_xform_group;

/* An `!xform` command, parsed. Lives in the arena. */
typedef struct pm_xform {
    const pm_word *modifier; /* -m: the modifier of all surfaces; NULL without */
    const char *prefix;      /* -n: "" without */
    bool invert;             /* -I: surfaces face the other way */
    const pm_xform_group *groups;
    size_t group_count;
    uint64_t instances; /* product over the arrays; UINT64_MAX if larger */
    const pm_word *files;
    size_t file_count;
    /* -f: the file whose lines say where the copies go (xform_list.h), and where -f stands in
     * the command. NULL without; with it nothing of the above but files is final. */
    const pm_word *list;
    size_t list_at;
} pm_xform;

/* Parses the words of an xform; it may name no file. PM_E_UNSUPPORTED for a second
 * -f; PM_E_SYNTAX, PM_E_RANGE for arguments that are wrong; each with the place of the
 * argument. */
PM_MUST_USE pm_status pm_xform_parse(const pm_command *command, pm_arena *arena, pm_xform *out,
                                     pm_error *err);

/* The transform that a primitive's string arguments end in: words of -t -rx -ry -rz -s -mx -my
 * -mz -i, as xf() of Radiance's src/common/xf.c reads them. Errors as pm_xform_parse. */
PM_MUST_USE pm_status pm_xform_parse_transform(const pm_word *words, size_t count,
                                               const char *file, pm_transform *out,
                                               pm_error *err);

/* The transform of instance 0 .. instances - 1; the first array varies slowest. */
pm_transform pm_xform_instance(const pm_xform *xform, uint64_t index);

/* The prefix of names in that instance as Radiance writes it: "box", or in arrays "box.1.0",
 * "a1.0". `out` has room for pm_xform_prefix_size bytes. */
size_t pm_xform_prefix_size(const pm_xform *xform);
void pm_xform_instance_prefix(const pm_xform *xform, uint64_t index, char *out);

/* Transforms a primitive's arguments (in scene units, already checked) in place.
 *   inverted  the surface faces the other way: sphere and bubble, cone and cup, cylinder and
 * tube change places, a ring's normal turns, a polygon's vertices go backwards Lengths scale:
 * radii, a glow's maxrad, a spotlight's focal length (its direction's length). Quantities for a
 * unit of length follow, so that the optical depth stays: a mist's extinction is divided by the
 * scale, a dielectric's transmission per unit length raised to its inverse. Directions of
 * sources and rings turn and keep their length. Radiance and reflectances stay. PM_E_RANGE with
 * the reason for a result that a double cannot hold. Source: Radiance, src/gen/xform.c. Test:
 * test_xform.c. */
PM_MUST_USE pm_status pm_transform_primitive(const pm_transform *transform, bool inverted,
                                             pm_primitive_type *type, double *reals,
                                             size_t count, const char **reason);

#endif
