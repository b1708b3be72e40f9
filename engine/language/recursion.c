/* What can be known of a program before it runs: whether it surely asks for something that is
 * not there, and whether it surely never ends. */
#include "language/language_internal.h"

#include <stdlib.h>

enum { DEPTH_MAX = 4096, PROBES = 3 };

/* Follows what every evaluation must evaluate. */
struct walk {
    const pm_language *language;
    const struct pm_code *code;
    const struct pm_node *root;
    uint32_t real_count;
    uint8_t *seen;    /* routines, then variables: 1 while inside, 2 after */
    uint64_t *strict; /* the arguments that a routine must evaluate */
    unsigned depth;
    pm_error *err;
};

static pm_status must(struct walk *w, uint32_t at, uint64_t *args);

/* The place of a definition, or of what uses it if no user wrote it. */
struct place {
    uint32_t source;
    int line, column;
};

static struct place place_of(const struct pm_definition *definition, const struct pm_node *root)
{
    if (definition->source < PM_SOURCES_OWN)
        return (struct place){root->source, root->line, root->column};
    return (struct place){definition->source, definition->line, definition->column};
}

static pm_status endless(const struct walk *w, const struct pm_definition *definition)
{
    struct place place = place_of(definition, w->root);
    return pm_language_error(w->language, w->err, PM_E_RANGE, place.source, place.line,
                             place.column,
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

/* The first `count` operands. */
static pm_status operands(struct walk *w, const struct pm_op *op, uint32_t count,
                          uint64_t *args)
{
    pm_status st = PM_OK;
    for (uint32_t i = 0; !st && i < count; i++)
        st = must(w, pm_op_operand(w->code, op, i), args);
    return st;
}

static pm_status lacks(const struct walk *w, const struct pm_node *node)
{
    const char *name = node->kind == PM_NODE_NAME ? node->name->text : NULL;
    int length = name ? pm_name_length(name) : 0, count = (int)w->real_count;
    const struct pm_node *which = name ? node : node->first->next;
    if (name && node->name->definition && !node->name->definition->parameter_count)
        return pm_language_error(
            w->language, w->err, PM_E_MISSING, node->source, node->line, node->column,
            "%.*s needs a real argument that is not there; there are %d", length, name, count);
    if (name)
        return pm_language_error(w->language, w->err, PM_E_MISSING, node->source, node->line,
                                 node->column,
                                 "%.*s is a function: it needs its arguments, as in %.*s(x)",
                                 length, name, length, name);
    if (which->kind == PM_NODE_NUMBER && which->number < 1e6)
        return pm_language_error(w->language, w->err, PM_E_MISSING, node->source, node->line,
                                 node->column, "this needs real argument %d, and there are %d",
                                 (int)(which->number + .5), count);
    return pm_language_error(w->language, w->err, PM_E_MISSING, node->source, node->line,
                             node->column, "this needs more real arguments than there are, %d",
                             count);
}

static pm_status must_op(struct walk *w, const struct pm_op *op, uint64_t *args)
{
    const struct pm_code *code = w->code;
    switch ((enum pm_op_code)op->code) {
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
    case PM_OP_IF:
    case PM_OP_SELECT:
        return operands(w, op, 1, args);
    default:
        return operands(w, op, pm_op_operand_count(op), args);
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
    struct walk w = {.language = language, .code = code, .root = program->node, .err = err};
    pm_status st = PM_OK;
    uint64_t args = 0;
    w.real_count = program->real_count;
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
    static const double scale[PROBES] = {0, 1, -12.5};
    for (int i = 0; i < PM_RAY_VALUES; i++)
        ray->value[i] = scale[number] * (1 + i % 3 * .25);
    for (int i = 0; i < PM_LANGUAGE_PARAMETERS; i++)
        args[i] = scale[number] * (1 + i * .125);
}

/* Which definition to name: depth may have run out inside another that the recursion uses. */
static const struct pm_definition *culprit(const struct pm_code *code,
                                           const struct pm_definition *met)
{
    const struct pm_definition *first = NULL;
    for (uint32_t i = code->routine_count; i > 0; i--)
        if (code->routines[i - 1].recursive) {
            first = code->routines[i - 1].definition;
            if (first == met)
                return met;
        }
    for (uint32_t i = code->variable_count; i > 0; i--)
        if (code->variables[i - 1].recursive) {
            first = code->variables[i - 1].definition;
            if (first == met)
                return met;
        }
    return first;
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
    const struct pm_definition *recursive = culprit(&program->code, result.recursion);
    const struct pm_definition *definition = recursive ? recursive : result.recursion;
    struct place place = place_of(definition, program->node);
    if (result.faults & PM_FAULT_DEPTH && !recursive)
        return pm_language_error(
            language, err, PM_E_LIMIT, place.source, place.line, place.column,
            "definitions use each other more than %d levels deep", PM_LANGUAGE_DEPTH);
    if (result.faults & PM_FAULT_DEPTH)
        return pm_language_error(
            language, err, PM_E_RANGE, place.source, place.line, place.column,
            "the recursion of %s has no end: it was followed %d levels deep", definition->text,
            PM_LANGUAGE_DEPTH);
    return pm_language_error(language, err, PM_E_RANGE, place.source, place.line, place.column,
                             "%s takes too long: it was followed through %d steps",
                             definition->text, PM_LANGUAGE_WORK);
}

pm_status pm_program_check(pm_language *language, const struct pm_program *program,
                           pm_error *err)
{
    pm_status st = check_sure(language, program, err);
    if (!st)
        st = check_recursion(language, program, err);
    return st;
}
