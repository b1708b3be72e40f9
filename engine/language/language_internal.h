#ifndef PM_LANGUAGE_INTERNAL_H
#define PM_LANGUAGE_INTERNAL_H

#include "base/arena.h"
#include "language/language.h"

/* ---- Trees: what was read ---- */

enum pm_node_kind {
    PM_NODE_NUMBER,
    PM_NODE_NAME,      /* a variable's value, or a function handed on by name */
    PM_NODE_PARAMETER, /* of the function that is being defined */
    PM_NODE_CHANNEL,   /* a value of the ray */
    PM_NODE_CALL,      /* first child: NAME or PARAMETER; then the arguments */
    PM_NODE_NEGATE,
    PM_NODE_SUM, /* two or more terms, left to right */
    PM_NODE_PRODUCT,
    PM_NODE_POWER,
};

struct pm_node {
    uint8_t kind;
    char op; /* how it enters the sum or product that it is a term of: + - * / */
    uint32_t source;
    int32_t line, column;
    struct pm_node *first, *next;
    union {
        double number;
        uint32_t index; /* parameter from 0, channel from 1 */
        struct pm_name *name;
    };
};

struct pm_definition {
    const char *text; /* its name as written */
    bool constant;    /* ':' */
    uint32_t source;
    int32_t line, column;
    uint32_t parameter_count; /* 0: a variable */
    uint32_t needed;          /* arguments that the body asks for */
    const char **parameters;
    uint32_t *occurrences; /* of each parameter in the body */
    struct pm_node *body;
    /* Scratch of the compiler, valid if `stamp` is its. */
    uint32_t stamp;
    uint32_t expanded; /* nodes that the body becomes when it is put in place */
    bool expanding;
    struct pm_instance *instances;
    uint32_t instance_count;
};

/* A qualified name: `x`, or `x` with a mark and its context. */
struct pm_name {
    struct pm_name *next;
    uint32_t hash;
    struct pm_definition *definition; /* the latest, or NULL */
    const struct pm_builtin *builtin; /* of the same name, or NULL */
    uint32_t stamp, op;               /* scratch of the compiler */
    char text[];
};

struct pm_builtin {
    const char *name;
    uint8_t code;     /* an enum pm_op_code */
    uint8_t least;    /* arguments that it needs */
    bool constant;    /* constant if its arguments are */
    bool scenes_only; /* not offered to generators */
};

const struct pm_builtin *pm_builtin_find(enum pm_language_kind kind, const char *name);

/* ---- Programs: what is run ---- */

enum pm_op_code {
    PM_OP_NUMBER,
    PM_OP_RAY,      /* a: enum pm_ray_value */
    PM_OP_ARG,      /* a: argument of the frame */
    PM_OP_VARIABLE, /* a: number of the variable */
    PM_OP_CALL,     /* a: routine; b, c: list of arguments and how many */
    PM_OP_REAL,     /* a: index of the real argument */
    PM_OP_REAL_COUNT,
    PM_OP_REAL_AT, /* a: expression that gives its number from 1, or 0 for the count */
    PM_OP_MISSING, /* node: what is not there; 0 and a fault */
    PM_OP_NEGATE,  /* a, b, c from here on: operands */
    PM_OP_ADD,
    PM_OP_SUBTRACT,
    PM_OP_MULTIPLY,
    PM_OP_DIVIDE,
    PM_OP_POWER,
    PM_OP_SUM,     /* b, c: list of terms << 1 | subtracted */
    PM_OP_PRODUCT, /* b, c: list of factors << 1 | divided by */
    PM_OP_IF,
    PM_OP_SELECT, /* b, c: list and how many */
    PM_OP_MIN,    /* b, c */
    PM_OP_MAX,    /* b, c */
    PM_OP_SQUARE,
    PM_OP_SQRT, /* library functions of one argument, up to PM_OP_ERFC */
    PM_OP_SIN,
    PM_OP_COS,
    PM_OP_TAN,
    PM_OP_ASIN,
    PM_OP_ACOS,
    PM_OP_ATAN,
    PM_OP_EXP,
    PM_OP_LOG,
    PM_OP_LOG10,
    PM_OP_FLOOR,
    PM_OP_CEIL,
    PM_OP_RAND,
    PM_OP_ERF,
    PM_OP_ERFC,
    PM_OP_ATAN2,
    PM_OP_NOISE3,
    PM_OP_NOISE3X,
    PM_OP_NOISE3Y,
    PM_OP_NOISE3Z,
    PM_OP_FNOISE3,
};

struct pm_op {
    uint8_t code;
    uint16_t height; /* nested nodes below and with it, not counting bodies */
    uint32_t a;
    union {
        struct {
            uint32_t b, c;
        };
        double number;
        const struct pm_node *node;
    };
};

/* Where an operation has its operands. */
enum pm_op_shape {
    PM_SHAPE_LEAF,
    PM_SHAPE_ONE, /* a */
    PM_SHAPE_TWO, /* a, b */
    PM_SHAPE_THREE,
    PM_SHAPE_LIST,    /* c entries of the lists from b on */
    PM_SHAPE_FLAGGED, /* the same, shifted by one bit */
};
enum pm_op_shape pm_op_shape(uint8_t code);

/* How many, and the i-th of them. */
struct pm_code;
uint32_t pm_op_operand_count(const struct pm_op *op);
uint32_t pm_op_operand(const struct pm_code *code, const struct pm_op *op, uint32_t i);

/* The bits of enum pm_ray_value, and these. */
#define PM_USES_REALS (1ull << 60)
#define PM_USES_OPEN  (1ull << 61) /* recursion: what is not known yet */
#define PM_USES_LOST  (1ull << 62) /* something missing */

struct pm_routine {
    uint32_t body;
    uint32_t cost; /* units of work: a quarter of the body's nodes, and one */
    uint16_t height;
    bool open;      /* while its body is being compiled */
    bool recursive; /* its body asks for itself */
    uint64_t uses;
    const struct pm_definition *definition;
};

struct pm_variable {
    uint32_t body;
    uint32_t cost;
    uint16_t height;
    bool open;
    bool recursive;
    uint64_t uses;
    const struct pm_definition *definition;
};

struct pm_code {
    const struct pm_op *ops;
    const uint32_t *lists;
    const struct pm_routine *routines;
    const struct pm_variable *variables;
    uint32_t op_count, list_count, routine_count, variable_count;
    const double *reals; /* its own copy, if it has one */
    uint32_t real_count;
    bool own_reals;
};

struct pm_program {
    struct pm_code code;
    uint32_t roots[PM_LANGUAGE_TEXTS];
    unsigned root_count, arg_count;
    uint64_t uses;
    const struct pm_node *node; /* of the first text, and the real arguments: for errors */
    uint32_t real_count;
};

enum { PM_LANGUAGE_VARIABLES = 8192 }; /* of one program */

/* What an evaluation came to. */
struct pm_run {
    unsigned faults;
    uint32_t work;                         /* steps that it took */
    const struct pm_node *missing;         /* the first that was asked for */
    const struct pm_definition *recursion; /* where depth or work ran out */
};

/* Evaluates ops `roots` of a code into `values`. */
void pm_code_run(const struct pm_code *code, const uint32_t *roots, unsigned root_count,
                 const struct pm_ray_values *ray, const double *args, double *values,
                 struct pm_run *run);

/* Refuses a program that surely asks for what is missing, or whose recursion cannot end. */
PM_MUST_USE pm_status pm_program_check(pm_language *language, const struct pm_program *program,
                                       pm_error *err);

/* ---- The language ---- */

struct pm_context {
    const char *file; /* as scenes name it; "" for the global context */
    const char *mark; /* what is appended to its names: a mark and the name, or "" */
};

struct pm_language {
    enum pm_language_kind kind;
    pm_arena arena;
    struct pm_name **names; /* hashed; name_size is a power of two */
    uint32_t name_count, name_size;
    struct pm_context *contexts;
    uint32_t context_count, context_size;
    const char **sources; /* labels of errors */
    uint32_t source_count, source_size;
    struct pm_program **programs;
    uint32_t program_count, program_size;
    struct pm_request **requests; /* hashed; request_size is a power of two */
    uint32_t request_count, request_size;
    size_t text_bytes, code_ops;
    uint64_t fold_work,
        probe_work; /* spent on constants and on looking for endless recursion */
    uint32_t stamp;
};

enum {
    PM_LANGUAGE_FOLD_MAX = 1 << 22,  /* steps spent on constants while reading */
    PM_LANGUAGE_PROBE_MAX = 1 << 25, /* steps spent on probing recursion */
    PM_LANGUAGE_OWN_REALS = 4 << 20  /* nodes beyond which real arguments stay in the ray */
};

/* An array with room for one more element; false if memory is short. */
bool pm_language_grow(void **array, uint32_t count, uint32_t *size, size_t element);

/* Labels that no user wrote: errors there are told where the user came from. */
enum { PM_SOURCE_RAY, PM_SOURCE_PRELUDE, PM_SOURCES_OWN };

/* The label's number. UINT32_MAX if memory is short. */
uint32_t pm_language_source(pm_language *language, const char *label);

pm_status pm_language_error(const pm_language *language, pm_error *err, pm_status status,
                            uint32_t source, int line, int column, const char *format, ...)
    __attribute__((format(printf, 7, 8)));

/* names.c: the meaning of a name as written in a context; NULL if there is none (find) or
 * memory is short (insert). */
struct pm_name *pm_name_find(const pm_language *language, const char *mark, const char *name);
struct pm_name *pm_name_insert(pm_language *language, const char *mark, const char *name);
/* The name that a definition defines: in the context itself, never outside. */
struct pm_name *pm_name_define(pm_language *language, const char *mark, const char *name);
/* Length of a name without its context, for messages. */
int pm_name_length(const char *text);

/* parse.c */
PM_MUST_USE pm_status pm_parse_definitions(pm_language *language, uint32_t context,
                                           uint32_t source, int line, int column,
                                           const char *text, size_t size, pm_error *err);
PM_MUST_USE pm_status pm_parse_expression(pm_language *language, uint32_t context,
                                          uint32_t source, int line, int column,
                                          const char *text, size_t size, struct pm_node **out,
                                          pm_error *err);

/* compile.c: the value of a constant expression. */
PM_MUST_USE pm_status pm_constant_value(pm_language *language, const struct pm_node *node,
                                        double *value, pm_error *err);

/* A copy of a program in the arena, without the operations that nothing asks for. NULL if
 * memory is short. */
struct pm_program *pm_program_keep(pm_arena *arena, const struct pm_program *program);

/* A program of the texts' trees. *asked_reals: it would be another with other real arguments.
 */
PM_MUST_USE pm_status pm_program_compile(pm_language *language, struct pm_node *const *nodes,
                                         const struct pm_function_request *request,
                                         struct pm_program **out, bool *asked_reals,
                                         pm_error *err);

#endif
