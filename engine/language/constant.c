/* Constants: expressions that are evaluated while they are read. */
#include "language/compile_internal.h"

#include <assert.h>

/* What a constant asked for and cannot have. */
static void constant_lacks(const struct compiler *c, const struct pm_node *place,
                           const struct pm_node *missing)
{
    const struct pm_node *callee = missing->kind == PM_NODE_CALL ? missing->first : missing;
    const struct pm_name *name = callee->kind == PM_NODE_NAME ? callee->name : NULL;
    int length = name ? pm_name_length(name->text) : 0;
    bool variable = name && name->definition && name->definition->parameter_count == 0;
    if (missing->kind == PM_NODE_CHANNEL)
        FAIL(c, place, PM_E_MISSING, "a constant (:) cannot depend on the ray; write =");
    else if (name && (missing == callee ? variable : name->builtin && !variable))
        FAIL(c, place, PM_E_MISSING, "a constant (:) cannot depend on real arguments; write =");
    else if (missing == callee && name && pm_name_is_callable(name))
        FAIL(c, place, PM_E_MISSING,
             "%.*s is a function: it needs its arguments, as in %.*s(x)", length, name->text,
             length, name->text);
    else
        FAIL(c, place, PM_E_MISSING, "a constant needs this, which is not defined yet");
}

static pm_status constant_fault(const struct compiler *c, const struct pm_node *node,
                                const struct pm_run *result)
{
    const struct pm_node *missing = result->missing;
    if (missing)
        constant_lacks(c, missing->source < PM_SOURCES_OWN ? node : missing, missing);
    else if (result->faults & (PM_FAULT_DEPTH | PM_FAULT_WORK))
        FAIL(c, node, PM_E_LIMIT, "this constant takes too long, or %s does not end",
             result->recursion ? result->recursion->text : "its recursion");
    else
        FAIL(c, node, PM_E_RANGE, "this constant has no value: %s",
             result->faults & PM_FAULT_DIVISION ? "division by zero"
             : result->faults & PM_FAULT_RANGE  ? "it is too large"
                                                : "a function is asked outside its domain");
    return c->err->status;
}

pm_status pm_constant_value(pm_language *language, const struct pm_node *node, double *value,
                            pm_error *err)
{
    struct compiler c;
    struct pm_run result;
    double got = 0;
    if (node->kind == PM_NODE_NAME && node->name->definition &&
        node->name->definition->body->kind == PM_NODE_NUMBER) {
        *value = node->name->definition->body->number;
        return PM_OK;
    }
    pm_status st = pm_compiler_begin(&c, language, err);
    if (st)
        return st;
    c.constant = true;
    uint32_t root = pm_compile_node(&c, node, NULL);
    if (root == NONE)
        st = err->status;
    language->fold_work += c.op_count;
    assert(st || c.stack.count == 0);
    if (!st) {
        struct pm_code code = pm_compiler_code(&c);
        pm_code_run(&code, &root, 1, NULL, NULL, &got, &result);
        language->fold_work += result.work;
        if (result.faults)
            st = constant_fault(&c, node, &result);
        else
            *value = got;
    }
    if (!st && language->fold_work > PM_LANGUAGE_FOLD_MAX)
        st =
            pm_language_error(language, err, PM_E_LIMIT, node->source, node->line, node->column,
                              "the constants of the function files take more "
                              "than %d steps to compute",
                              PM_LANGUAGE_FOLD_MAX);
    pm_compiler_clear(&c);
    return st;
}
