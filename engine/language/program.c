#include "language/language_internal.h"

#include <stdlib.h>
#include <string.h>

enum pm_op_shape pm_op_shape(uint8_t code)
{
    switch ((enum pm_op_code)code) {
    case PM_OP_NUMBER:
    case PM_OP_RAY:
    case PM_OP_ARG:
    case PM_OP_VARIABLE:
    case PM_OP_REAL:
    case PM_OP_REAL_COUNT:
    case PM_OP_MISSING:
        return PM_SHAPE_LEAF;
    case PM_OP_ADD:
    case PM_OP_SUBTRACT:
    case PM_OP_MULTIPLY:
    case PM_OP_DIVIDE:
    case PM_OP_POWER:
    case PM_OP_ATAN2:
        return PM_SHAPE_TWO;
    case PM_OP_IF:
    case PM_OP_NOISE3:
    case PM_OP_NOISE3X:
    case PM_OP_NOISE3Y:
    case PM_OP_NOISE3Z:
    case PM_OP_FNOISE3:
        return PM_SHAPE_THREE;
    case PM_OP_CALL:
    case PM_OP_SELECT:
    case PM_OP_MIN:
    case PM_OP_MAX:
        return PM_SHAPE_LIST;
    case PM_OP_SUM:
    case PM_OP_PRODUCT:
        return PM_SHAPE_FLAGGED;
    default:
        return PM_SHAPE_ONE;
    }
}

uint32_t pm_op_operand_count(const struct pm_op *op)
{
    enum pm_op_shape shape = pm_op_shape(op->code);
    return shape >= PM_SHAPE_LIST ? op->c : (uint32_t)shape;
}

uint32_t pm_op_operand(const struct pm_code *code, const struct pm_op *op, uint32_t i)
{
    enum pm_op_shape shape = pm_op_shape(op->code);
    if (shape >= PM_SHAPE_LIST)
        return code->lists[op->b + i] >> (shape == PM_SHAPE_FLAGGED);
    return i == 0 ? op->a : i == 1 ? op->b : op->c;
}

/* New numbers of the operations that are asked for, and how many those are. */
struct plan {
    const struct pm_code *code;
    uint32_t *number; /* from 1; 0: not asked for */
    uint32_t *waiting;
    uint32_t waiting_count, op_count, list_count;
};

static void ask(struct plan *plan, uint32_t at)
{
    if (plan->number[at])
        return;
    plan->number[at] = 1;
    plan->waiting[plan->waiting_count++] = at;
}

static void ask_below(struct plan *plan, const struct pm_op *op)
{
    uint32_t count = pm_op_operand_count(op);
    for (uint32_t i = 0; i < count; i++)
        ask(plan, pm_op_operand(plan->code, op, i));
    if (pm_op_shape(op->code) >= PM_SHAPE_LIST)
        plan->list_count += count;
    if (op->code == PM_OP_CALL)
        ask(plan, plan->code->routines[op->a].body);
    if (op->code == PM_OP_VARIABLE)
        ask(plan, plan->code->variables[op->a].body);
}

static bool make_plan(struct plan *plan, const struct pm_program *program)
{
    const struct pm_code *code = &program->code;
    *plan = (struct plan){.code = code};
    plan->number = calloc(code->op_count, sizeof *plan->number);
    plan->waiting = calloc(code->op_count, sizeof *plan->waiting);
    if (!plan->number || !plan->waiting)
        return false;
    for (unsigned i = 0; i < program->root_count; i++)
        ask(plan, program->roots[i]);
    while (plan->waiting_count)
        ask_below(plan, code->ops + plan->waiting[--plan->waiting_count]);
    for (uint32_t i = 0; i < code->op_count; i++)
        if (plan->number[i])
            plan->number[i] = ++plan->op_count;
    return true;
}

static void renumber(const struct plan *plan, struct pm_op *op, uint32_t *lists, uint32_t *used)
{
    enum pm_op_shape shape = pm_op_shape(op->code);
    if (shape >= PM_SHAPE_LIST) {
        const uint32_t *from = plan->code->lists + op->b;
        unsigned shift = shape == PM_SHAPE_FLAGGED;
        op->b = *used;
        for (uint32_t i = 0; i < op->c; i++)
            lists[(*used)++] =
                (plan->number[from[i] >> shift] - 1) << shift | (from[i] & shift);
        return;
    }
    if (shape >= PM_SHAPE_ONE)
        op->a = plan->number[op->a] - 1;
    if (shape >= PM_SHAPE_TWO)
        op->b = plan->number[op->b] - 1;
    if (shape >= PM_SHAPE_THREE)
        op->c = plan->number[op->c] - 1;
}

static void *copy(pm_arena *arena, const void *data, size_t count, size_t size)
{
    void *made = pm_arena_array(arena, count ? count : 1, size);
    if (made && count)
        memcpy(made, data, count * size);
    return made;
}

static uint32_t renumbered(const struct plan *plan, uint32_t body)
{
    return plan->number[body] ? plan->number[body] - 1 : 0;
}

static struct pm_program *keep_planned(pm_arena *arena, const struct pm_program *from,
                                       const struct plan *plan)
{
    const struct pm_code *code = &from->code;
    struct pm_program *program = copy(arena, from, 1, sizeof *from);
    struct pm_op *ops = pm_arena_array(arena, plan->op_count, sizeof *ops);
    uint32_t *lists = pm_arena_array(arena, plan->list_count, sizeof *lists);
    struct pm_routine *routines =
        copy(arena, code->routines, code->routine_count, sizeof *routines);
    struct pm_variable *variables =
        copy(arena, code->variables, code->variable_count, sizeof *variables);
    double *reals = copy(arena, code->reals, code->real_count, sizeof *reals);
    uint32_t used = 0;
    if (!program || !ops || !lists || !routines || !variables || !reals)
        return NULL;
    for (uint32_t i = 0; i < code->op_count; i++)
        if (plan->number[i]) {
            ops[plan->number[i] - 1] = code->ops[i];
            renumber(plan, ops + plan->number[i] - 1, lists, &used);
        }
    for (uint32_t i = 0; i < code->routine_count; i++)
        routines[i].body = renumbered(plan, routines[i].body);
    for (uint32_t i = 0; i < code->variable_count; i++)
        variables[i].body = renumbered(plan, variables[i].body);
    for (unsigned i = 0; i < from->root_count; i++)
        program->roots[i] = plan->number[from->roots[i]] - 1;
    program->code = (struct pm_code){.ops = ops,
                                     .lists = lists,
                                     .routines = routines,
                                     .variables = variables,
                                     .op_count = plan->op_count,
                                     .list_count = plan->list_count,
                                     .routine_count = code->routine_count,
                                     .variable_count = code->variable_count,
                                     .reals = reals,
                                     .real_count = code->real_count,
                                     .own_reals = code->own_reals};
    return program;
}

struct pm_program *pm_program_keep(pm_arena *arena, const struct pm_program *program)
{
    struct plan plan;
    struct pm_program *kept =
        make_plan(&plan, program) ? keep_planned(arena, program, &plan) : NULL;
    free(plan.number);
    free(plan.waiting);
    return kept;
}
