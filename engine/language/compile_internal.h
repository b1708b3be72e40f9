#ifndef PM_LANGUAGE_COMPILE_INTERNAL_H
#define PM_LANGUAGE_COMPILE_INTERNAL_H

#include "language/language_internal.h"

/* What emit.c, call.c, constant.c and compile.c share: one program in the making. Functions
 * that give an operation give NONE after an error, which is then set. */

#define NONE UINT32_MAX

/* What the parameters of the body at hand stand for. */
struct scope {
    const struct pm_definition *function;
    const uint32_t *given; /* operations of the outer body; NULL: arguments of the frame */
    const struct pm_name *const *bound;
};

struct words {
    uint32_t *data;
    uint32_t count, size;
};

struct compiler {
    pm_language *language;
    pm_error *err;
    bool constant; /* what is missing is an error only if it is asked for */
    const double *reals;
    uint32_t real_count;
    bool asked_reals;
    struct pm_op *ops;
    uint32_t op_count, op_size;
    uint32_t elsewhere; /* nodes that belong to finished bodies */
    struct words lists, stack;
    struct pm_routine *routines;
    uint32_t routine_count, routine_size;
    struct pm_variable *variables;
    uint32_t variable_count, variable_size;
    pm_arena arena; /* instances */
    unsigned depth;
    uint32_t stamp;
    uint64_t uses;              /* of what is being compiled */
    const struct pm_node *user; /* the latest use that is not in rayinit: for errors */
};

pm_status pm_compiler_begin(struct compiler *c, pm_language *language, pm_error *err);
void pm_compiler_clear(struct compiler *c);
struct pm_code pm_compiler_code(const struct compiler *c);

/* Returns NONE. A place that no user wrote becomes that of the latest use. */
uint32_t pm_compile_fail(const struct compiler *c, pm_status status, uint32_t source, int line,
                         int column, const char *format, ...)
    __attribute__((format(printf, 6, 7)));
uint32_t pm_compile_no_memory(const struct compiler *c);

#define FAIL(c, node, status, ...)                                                             \
    pm_compile_fail(c, status, (node)->source, (node)->line, (node)->column, __VA_ARGS__)

/* emit.c: operations. What has numbers only for operands becomes a number. */
uint32_t pm_emit(struct compiler *c, struct pm_op op);
uint32_t pm_emit_number(struct compiler *c, double value);
bool pm_emitted_number(const struct compiler *c, uint32_t at);
uint32_t pm_emit_fixed(struct compiler *c, enum pm_op_code code, const uint32_t *operands,
                       unsigned count);
/* With the entries of the stack from `first` on, which are taken off; `shift` 1 if they carry a
 * flag. */
uint32_t pm_emit_listed(struct compiler *c, enum pm_op_code code, uint32_t a, uint32_t first,
                        unsigned shift);
/* Something that is not there: an error if it is asked for. */
uint32_t pm_emit_missing(struct compiler *c, const struct pm_node *node);
/* The value of an operation that depends on nothing; the operation itself if it has none. */
uint32_t pm_emit_folded(struct compiler *c, uint32_t at);
bool pm_words_push(struct compiler *c, struct words *words, uint32_t word);
/* Costs nothing to evaluate again. */
bool pm_op_is_leaf(const struct pm_op *op);
/* Sets the cost of a body whose first node was number `before`. */
void pm_compile_close(struct compiler *c, uint32_t before, uint32_t *cost);

/* compile.c */
uint32_t pm_compile_node(struct compiler *c, const struct pm_node *node,
                         const struct scope *scope);

/* call.c: a call, and one by name whose arguments lie on the stack from `first` on. */
uint32_t pm_compile_call(struct compiler *c, const struct pm_node *node,
                         const struct scope *scope);
uint32_t pm_compile_call_of(struct compiler *c, const struct pm_node *node,
                            const struct pm_name *name, uint32_t first,
                            const struct scope *scope);
bool pm_name_is_callable(const struct pm_name *name);

#endif
