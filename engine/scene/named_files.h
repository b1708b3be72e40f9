#ifndef PM_SCENE_NAMED_FILES_H
#define PM_SCENE_NAMED_FILES_H

#include "scene/bundle.h"
#include "scene/lexer.h"

/* Which files a scene file names, without parsing it as a scene: for whoever has to bring them.
 */

/* One name.
 *   word  terminated; its place, line 0 in a binary file
 *   role  what it is: a letter of pm_type.strings, 'r' for a scene file, 'v' for what a
 *         command reads, '?' for those if there is such a file
 * A status other than PM_OK ends the search. */
typedef pm_status (*pm_named_file)(void *context, const pm_file *from, const pm_word *word,
                                   char role);

/* Visits every name in a scene file: of its commands, of its primitives' string arguments, of
 * an octree (role 'o') its scene files or its primitives, of a compiled mesh ('g') its
 * materials. What is wrong with the file is left for the parser to tell. Test:
 * test_collect.c. */
PM_MUST_USE pm_status pm_named_files_visit(const pm_file *file, char role, pm_named_file visit,
                                           void *context);

#endif
