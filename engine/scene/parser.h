#ifndef PM_SCENE_PARSER_H
#define PM_SCENE_PARSER_H

#include "base/arena.h"
#include "files/octree_file.h"
#include "scene/assets.h"
#include "scene/names.h"
#include "scene/scene.h"
#include "scene/statement.h"
#include "scene/types.h"
#include "scene/xform.h"

/* What parse.c (statements), modifiers.c (what names mean), arguments.c (of one primitive),
 * octrees.c (files of records), prototypes.c (octrees and meshes that are placed), count.c and
 * expand.c (`!` lines) share. */

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

/* Where a prototype comes from. */
typedef struct pm_prototype_origin {
    const pm_file *file;
    int32_t older; /* another prototype of the file, with other materials; -1 without */
} pm_prototype_origin;

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
    uint64_t generate_work; /* left, for functions of generators (generate.h) */
    uint32_t *aliases; /* that are no primitives: how many of those stand before each */
    size_t alias_count, alias_capacity;
    pm_assets *assets;
    pm_prototype *prototypes;
    pm_prototype_origin *prototype_origins;
    size_t prototype_count, prototype_capacity;
    int32_t *newest_prototype; /* by file: its newest prototype + 1; 0 without */
    int32_t *slots;            /* of the mesh in hand */
    size_t slot_capacity;
    pm_word *words; /* string arguments of the primitive in hand */
    size_t word_capacity;
} pm_parser;

/* One reading of one file: where it stands and what its `!` line makes of it. */
typedef struct pm_frame {
    const pm_file *file;
    pm_transform transform;
    bool moved;              /* transform is not the identity, or inverted */
    bool inverted;           /* surfaces face the other way */
    const pm_word *modifier; /* -m, the outermost; NULL without */
    const char *modifier_file;
    const char *prefix; /* -n; "" without */
    unsigned depth;     /* 1 for the main file */
    /* For a generator's text, which is no file of the bundle: the file and the word that its
     * primitives come from. NULL for files. */
    const pm_file *origin;
    const pm_word *place;
} pm_frame;

/* One primitive while it is read, from text or from a record of a binary file. */
typedef struct pm_reading {
    pm_parser *parser;
    const pm_frame *frame;
    pm_lexer *lexer;         /* of text */
    const pm_record *record; /* NULL for text */
    int32_t record_modifier; /* what its modifier is in the scene */
    const pm_statement *statement;
    const pm_type *rules;
    pm_primitive result;
    pm_lexer arguments;  /* before the first, for messages */
    unsigned dimensions; /* of its data files; 0 without */
    uint32_t context;    /* of its function file; 0, the global one, without */
} pm_reading;

#define PM_READING_FAIL(r, word, status, ...)                                                  \
    pm_word_error(word, status, (r)->frame->file->name, (r)->parser->err, __VA_ARGS__)

/* arguments.c: reads the string, integer and real arguments, resolves what they name and moves
 * them by the frame's transform. */
PM_MUST_USE pm_status pm_parser_arguments(pm_reading *r);

/* modifiers.c: the primitive that the name means, PM_VOID for void. PM_E_MISSING with the
 * reason that fits. */
PM_MUST_USE pm_status pm_parser_reference(const pm_reading *r, const pm_word *name,
                                          const char *file, int32_t *out);

/* modifiers.c: sets the modifier; then what follows from it and from the references: material,
 * depth and weight. */
PM_MUST_USE pm_status pm_parser_modifier(pm_reading *r);
PM_MUST_USE pm_status pm_parser_chain(const pm_reading *r, pm_primitive *primitive);

/* prototypes.c: the number of the prototype that the octree or mesh file is to the primitive in
 * hand, named by `word`. An octree's primitives come after the main scene's, when
 * pm_parser_prototypes reads them. */
PM_MUST_USE pm_status pm_parser_prototype(const pm_reading *r, const pm_file *file,
                                          const pm_word *word, int32_t *out);
PM_MUST_USE pm_status pm_parser_prototypes(pm_parser *parser);

/* parse.c: reads the primitive, or the alias, that the statement starts. */
PM_MUST_USE pm_status pm_parser_primitive(pm_reading *r);
PM_MUST_USE pm_status pm_parser_alias(pm_reading *r);

/* octrees.c: reads an octree file's primitives, or the scene files that it names. */
PM_MUST_USE pm_status pm_parser_octree(pm_parser *parser, const pm_frame *frame);

/* octrees.c: makes primitives of records. `map` (NULL, or [records->count]) receives the
 * primitive that each stands for, PM_VOID for a surface. */
PM_MUST_USE pm_status pm_parser_records(pm_parser *parser, const pm_frame *frame,
                                        const pm_records *records, int32_t *map);

PM_MUST_USE pm_status pm_parser_file(pm_parser *parser, const pm_frame *frame);

/* The same for a file that no `!` line names: the main file, or one of an octree. */
PM_MUST_USE pm_status pm_parser_top_file(pm_parser *parser, const pm_frame *frame);

/* Reads the command after a '!' and parses what it names. */
PM_MUST_USE pm_status pm_parser_expand(pm_parser *parser, const pm_frame *frame,
                                       pm_lexer *lexer);

/* "prefix.name", in the scene's arena; NULL if memory is short. */
const char *pm_parser_name(pm_parser *parser, const char *prefix, const char *name,
                           size_t length);

pm_status pm_parser_memory_error(pm_parser *parser);

#endif
