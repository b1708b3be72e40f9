#ifndef PM_SCENE_EXPAND_H
#define PM_SCENE_EXPAND_H

#include "scene/parser.h"
#include "scene/pipeline.h"

/* What count.c (how much a `!` line brings) and expand.c (carrying it out) share. */

/* Where a generator's command looks for files: beside the file that it stands in. */
struct pm_generate_context {
    const pm_bundle *bundle;
    const char *from;
};

/* The pipeline's generator, ready to be measured or run; lives in the arena. */
PM_MUST_USE pm_status pm_parser_request(pm_parser *parser, const pm_pipeline *pipeline,
                                        pm_arena *arena, pm_generate_request *out);

/* Gives a generator's error the place of the word that it is about. */
pm_status pm_parser_generate_error(const pm_pipeline *pipeline, size_t wrong,
                                   const pm_error *why, pm_error *err);

/* Refuses what is too large before anything of it is made: PM_E_LIMIT. Finds files that are
 * missing, circles, and what is wrong with a generator's arguments.
 *   depth  of the frame in which the line stands */
PM_MUST_USE pm_status pm_parser_check_size(pm_parser *parser, unsigned depth,
                                           const pm_pipeline *pipeline, pm_arena *arena);

#endif
