#ifndef PM_SCENE_XFORM_LIST_H
#define PM_SCENE_XFORM_LIST_H

#include "scene/xform.h"

/* `xform ... -f FILE ...`: one copy for each line of the file, whose words stand where -f and
 * its file do. A copy's names begin with the first -n and the copy's number, "chair.3", or with
 * "i3". Lines that are empty or start with # do not count. Source: Radiance, src/gen/xform.c,
 * doargf. Test: a_list_makes_a_copy_for_each_line. */

enum { PM_XFORM_LIST_MOST = 1000000 }; /* copies */

/* Parses the copies of a command whose pm_xform has a list; they live in the arena. Errors of
 * pm_xform_parse, at the list's name. */
PM_MUST_USE pm_status pm_xform_list_parse(const pm_command *command, const pm_xform *xform,
                                          const void *text, size_t size, pm_arena *arena,
                                          const pm_xform **out, size_t *count, pm_error *err);

#endif
