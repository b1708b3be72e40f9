/* What can be known of a program before it runs: whether it surely asks for something that is
 * not there, and whether it surely never ends. */
#include "language/language_internal.h"

#include <stdlib.h>

enum { DEPTH_MAX = 4096, PROBES = 5 };

/* Follows what every evaluation must evaluate. */
struct walk {
    const pm_language *language;
    const struct pm_code *code;
    uint32_t real_count;
    uint8_t *seen;    /* routines, then variables: 1 while inside, 2 after */
    uint64_t *strict; /* the arguments that a routine must evaluate */
    unsigned depth;
    pm_error *err;
};

static pm_status must(struct walk *w, uint32_t at, uint64_t *args);

static pm_status endless(const struct walk *w, const struct pm_definition *definition)
{
    return pm_language_error(w->language, w->err, PM_E_RANGE, definition->source,
                             definition->line, definition->column,
                             "%s always needs itself, so its recursion has no end; put the "
                             "recursion into a branch of an if",
                             definition->text);
}

static pm_status body(struct walk *w, uint8_t *seen, uint32_t at, uint64_t *args,
                      const struct pm_definition *definition)
{
    if (*seen == 2)
        return PM_OK;
    if (*seen == 1)
        return endless(w, definition);
    *seen = 1;
    pm_status st = must(w, at, args);
    *seen = 2;
    return st;
}

static pm_status called(struct walk *w, const struct pm_op *op, uint64_t *args)
{
    const struct pm_routine *routine = w->code->routines + op->a;
    pm_status st =
        body(w, w->seen + op->a, routine->body, w->strict + op->a, routine->definition);
    for (uint32_t i = 0; !st && i < op->c; i++)
        if (w->strict[op->a] & 1ull << i)
            st = must(w, w->code->lists[op->b + i], args);
    return st;
}

static pm_status listed(struct walk *w, const struct pm_op *op, unsigned shift, uint32_t count,
                        uint64_t *args)
{
    pm_status st = PM_OK;
    for (uint32_t i = 0; !st && i < count; i++)
        st = must(w, w->code->lists[op->b + i] >> shift, args);
    return st;
}

static pm_status operands(struct walk *w, const struct pm_op *op, unsigned count,
                          uint64_t *args)
{
    const uint32_t all[3] = {op->a, op->b, op->c};
    pm_status st = PM_OK;
    for (unsigned i = 0; !st && i < count; i++)
        st = must(w, all[i], args);
    return st;
}

static pm_status lacks(const struct walk *w, const struct pm_node *node)
{
    bool name = node->kind == PM_NODE_NAME;
    int length = name ? pm_name_length(node->name->text) : 0;
    if (name)
        return pm_language_error(w->language, w->err, PM_E_MISSING, node->source, node->line,
                                 node->column,
                                 "%.*s is a function: it needs its arguments, as in %.*s(x)",
                                 length, node->name->text, length, node->name->text);
    return pm_language_error(
        w->language, w->err, PM_E_MISSING, node->source, node->line, node->column,
        "this asks for a real argument that is not there; there are %d", (int)w->real_count);
}

static pm_status must_op(struct walk *w, const struct pm_op *op, uint64_t *args)
{
    const struct pm_code *code = w->code;
    switch ((enum pm_op_code)op->code) {
    case PM_OP_NUMBER:
    case PM_OP_RAY:
    case PM_OP_REAL:
    case PM_OP_REAL_COUNT:
        return PM_OK;
    case PM_OP_MISSING:
        return lacks(w, op->node);
    case PM_OP_ARG:
        *args |= 1ull << op->a;
        return PM_OK;
    case PM_OP_VARIABLE:
        return body(w, w->seen + code->routine_count + op->a, code->variables[op->a].body, args,
                    code->variables[op->a].definition);
    case PM_OP_CALL:
        return called(w, op, args);
    case PM_OP_SUM:
    case PM_OP_PRODUCT:
        return listed(w, op, 1, op->c, args);
    case PM_OP_MIN:
    case PM_OP_MAX:
        return listed(w, op, 0, op->c, args);
    case PM_OP_SELECT:
        return listed(w, op, 0, 1, args);
    case PM_OP_ADD:
    case PM_OP_SUBTRACT:
    case PM_OP_MULTIPLY:
    case PM_OP_DIVIDE:
    case PM_OP_POWER:
    case PM_OP_ATAN2:
        return operands(w, op, 2, args);
    case PM_OP_NOISE3:
    case PM_OP_NOISE3X:
    case PM_OP_NOISE3Y:
    case PM_OP_NOISE3Z:
    case PM_OP_FNOISE3:
        return operands(w, op, 3, args);
    default: /* if, and functions of one argument */
        return operands(w, op, 1, args);
    }
}

/* What lies deeper than the limit is left to the evaluation, which is bounded. */
static pm_status must(struct walk *w, uint32_t at, uint64_t *args)
{
    if (w->depth == DEPTH_MAX)
        return PM_OK;
    w->depth++;
    pm_status st = must_op(w, w->code->ops + at, args);
    w->depth--;
    return st;
}

static pm_status check_sure(const pm_language *language, const struct pm_program *program,
                            pm_error *err)
{
    const struct pm_code *code = &program->code;
    struct walk w = {.language = language, .code = code, .err = err};
    pm_status st = PM_OK;
    uint64_t args = 0;
    w.real_count = code->real_count;
    w.seen = calloc(code->routine_count + code->variable_count + 1, 1);
    w.strict = calloc(code->routine_count + 1, sizeof *w.strict);
    if (!w.seen || !w.strict)
        st = pm_error_set(err, PM_E_MEMORY, "not enough memory for a function");
    for (unsigned i = 0; !st && i < program->root_count; i++)
        st = must(&w, program->roots[i], &args);
    free(w.seen);
    free(w.strict);
    return st;
}

/* Rays unlike each other: recursion that outruns the bounds for all of them has no end. */
static void make_probe(int number, struct pm_ray_values *ray, double *args)
{
    static const double scale[PROBES] = {0, 1, -1, .37, -12.5};
    for (int i = 0; i < PM_RAY_VALUES; i++)
        ray->value[i] = scale[number] * (1 + i % 3 * .25);
    for (int i = 0; i < PM_LANGUAGE_PARAMETERS; i++)
        args[i] = scale[number] * (1 + i * .125);
}

static pm_status check_recursion(pm_language *language, const struct pm_program *program,
                                 pm_error *err)
{
    struct pm_run result = {0};
    for (int i = 0; i < PROBES; i++) {
        struct pm_ray_values ray = {0};
        double args[PM_LANGUAGE_PARAMETERS], values[PM_LANGUAGE_TEXTS];
        if (language->probe_work > PM_LANGUAGE_PROBE_MAX)
            return PM_OK;
        make_probe(i, &ray, args);
        pm_code_run(&program->code, program->roots, program->root_count, &ray, args, values,
                    &result);
        language->probe_work += result.work;
        if (!(result.faults & (PM_FAULT_DEPTH | PM_FAULT_WORK)) || !result.recursion)
            return PM_OK;
    }
    const struct pm_definition *definition = result.recursion;
    return pm_language_error(language, err, PM_E_RANGE, definition->source, definition->line,
                             definition->column,
                             "the recursion of %s has no end: it was followed %d levels deep "
                             "and through %d steps",
                             definition->text, PM_LANGUAGE_DEPTH, PM_LANGUAGE_WORK);
}

pm_status pm_program_check(pm_language *language, const struct pm_program *program,
                           pm_error *err)
{
    pm_status st = check_sure(language, program, err);
    if (!st && program->uses & PM_USES_OPEN)
        st = check_recursion(language, program, err);
    return st;
}
