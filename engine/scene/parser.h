#ifndef PM_SCENE_PARSER_H
#define PM_SCENE_PARSER_H

#include "base/arena.h"
#include "scene/names.h"
#include "scene/scene.h"
#include "scene/statement.h"
#include "scene/xform.h"

/* What parse.c (statements) and expand.c (`!xform` lines) share. */

/* What reading a file costs beside its text [bytes]: an array of empty files must end, too. */
enum { PM_FILE_COST = 1024 };

/* Of the names that xform puts before others: every surface of an array has its own copy. */
enum { PM_PREFIX_MOST = 1024 };

/* What parsing a file once will bring, known before it is expanded. Saturating. */
typedef struct pm_file_count {
    enum { PM_UNCOUNTED, PM_COUNTING, PM_COUNTED } state;
    uint64_t primitives, reals, bytes;
    unsigned depth; /* of files below it, itself included */
} pm_file_count;

typedef struct pm_parser {
    const pm_bundle *bundle;
    pm_scene_limits limits;
    pm_error *err;
    pm_arena *arena;  /* of the scene */
    pm_arena scratch; /* gone when parsing ends */
    pm_names names;
    pm_file_count *counts; /* by file */
    pm_primitive *primitives;
    size_t count, capacity;
    uint64_t reals, bytes;
} pm_parser;

/* One reading of one file: where it stands and what its `!xform` line makes of it. */
typedef struct pm_frame {
    const pm_file *file;
    pm_transform transform;
    bool moved;              /* transform is not the identity, or inverted */
    bool inverted;           /* surfaces face the other way */
    const pm_word *modifier; /* -m, the outermost; NULL without */
    const char *modifier_file;
    const char *prefix; /* -n; "" without */
    unsigned depth;     /* 1 for the main file */
} pm_frame;

PM_MUST_USE pm_status pm_parser_file(pm_parser *parser, const pm_frame *frame);

/* Reads the command after a '!' and parses what it names. */
PM_MUST_USE pm_status pm_parser_expand(pm_parser *parser, const pm_frame *frame,
                                       pm_lexer *lexer);

/* "prefix.name", in the scene's arena; NULL if memory is short. */
const char *pm_parser_name(pm_parser *parser, const char *prefix, const char *name,
                           size_t length);

pm_status pm_parser_memory_error(pm_parser *parser);

#endif
