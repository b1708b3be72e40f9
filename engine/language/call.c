/* Calls: of the library, of functions put in place, and of routines with a frame. Functions
 * that are handed on by name are known here, so that each such call has a body of its own. */
#include "language/compile_internal.h"

#include <math.h>
#include <string.h>

enum {
    INLINE_MAX = 64,    /* nodes of a body that is put in place of its calls */
    INSTANCE_MAX = 1000 /* of a function, for the functions that it is called with */
};

/* A function as called with certain functions for its arguments. */
struct pm_instance {
    struct pm_instance *next;
    uint32_t routine;
    const struct pm_name *bound[]; /* for each parameter, NULL if it is no function */
};

bool pm_name_is_callable(const struct pm_name *name)
{
    return name->builtin || (name->definition && name->definition->parameter_count > 0);
}

/* The function that an argument names, NULL if it names none. */
static const struct pm_name *bound_name(const struct pm_node *arg, const struct scope *scope)
{
    if (arg->kind == PM_NODE_NAME && pm_name_is_callable(arg->name))
        return arg->name;
    if (arg->kind == PM_NODE_PARAMETER && scope->bound)
        return scope->bound[arg->index];
    return NULL;
}

/* An argument as a value. One that only names a function has none. */
static uint32_t argument(struct compiler *c, const struct pm_node *arg,
                         const struct scope *scope)
{
    bool variable_too = arg->kind == PM_NODE_NAME && arg->name->definition &&
                        arg->name->definition->parameter_count == 0;
    if (arg->kind == PM_NODE_NAME && pm_name_is_callable(arg->name) && !variable_too)
        return pm_emit_missing(c, arg);
    return pm_compile_node(c, arg, scope);
}

static bool all_numbers(const struct compiler *c, const uint32_t *args, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (!pm_emitted_number(c, args[i]))
            return false;
    return true;
}

static uint32_t real_argument(struct compiler *c, const struct pm_node *node, uint32_t which)
{
    if (node->source < PM_SOURCES_OWN && c->user)
        node = c->user;
    if (c->constant)
        return pm_emit_missing(c, node);
    c->asked_reals = true;
    if (!pm_emitted_number(c, which)) {
        c->uses |= PM_USES_REALS;
        return pm_emit(c, (struct pm_op){.code = PM_OP_REAL_AT,
                                         .height = (uint16_t)(c->ops[which].height + 1),
                                         .a = which});
    }
    double number = c->ops[which].number;
    uint32_t index = number + .5 >= 1 ? (uint32_t)fmin(number + .5, 0x1p31) : 0;
    if (c->reals && index == 0)
        return pm_emit_number(c, c->real_count);
    if (c->reals)
        return index > c->real_count ? pm_emit_missing(c, node)
                                     : pm_emit_number(c, c->reals[index - 1]);
    c->uses |= PM_USES_REALS;
    enum pm_op_code code = index ? PM_OP_REAL : PM_OP_REAL_COUNT;
    return pm_emit(
        c, (struct pm_op){.code = (uint8_t)code, .height = 1, .a = index ? index - 1 : 0});
}

/* With its arguments on the stack from `first` on. */
static uint32_t library_call(struct compiler *c, const struct pm_node *node,
                             const struct pm_builtin *builtin, uint32_t first)
{
    const uint32_t *args = c->stack.data + first;
    uint32_t count = c->stack.count - first, fixed[3] = {0};
    if (count < builtin->least)
        return FAIL(c, node, PM_E_SYNTAX, "%s needs %d arguments and has %d", builtin->name,
                    builtin->least, (int)count);
    for (uint32_t i = 0; i < count && i < 3; i++)
        fixed[i] = args[i];
    if (builtin->code == PM_OP_MIN || builtin->code == PM_OP_MAX)
        return pm_emit_listed(c, builtin->code, 0, first, 0);
    if (builtin->code == PM_OP_SELECT) {
        double which = pm_emitted_number(c, args[0]) ? c->ops[args[0]].number + .5 : 0;
        if (!(which >= 1 && which < count))
            return pm_emit_listed(c, builtin->code, 0, first, 0);
        fixed[0] = args[(uint32_t)which];
        c->stack.count = first;
        return fixed[0];
    }
    c->stack.count = first;
    if (builtin->code == PM_OP_REAL_AT)
        return real_argument(c, node, fixed[0]);
    if (builtin->code == PM_OP_IF && pm_emitted_number(c, fixed[0]))
        return c->ops[fixed[0]].number > 0 ? fixed[1] : fixed[2];
    return pm_emit_fixed(c, builtin->code, fixed, builtin->least);
}

static struct pm_instance *find_instance(struct compiler *c, struct pm_definition *definition,
                                         const struct pm_name *const *bound)
{
    if (definition->stamp != c->stamp) {
        definition->stamp = c->stamp;
        definition->instances = NULL;
        definition->instance_count = 0;
        definition->expanded = 0;
        definition->expanding = false;
    }
    struct pm_instance *instance = definition->instances;
    size_t size = definition->parameter_count * sizeof *bound;
    while (instance && memcmp(instance->bound, bound, size) != 0)
        instance = instance->next;
    return instance;
}

static struct pm_instance *add_instance(struct compiler *c, struct pm_definition *definition,
                                        const struct pm_name *const *bound)
{
    size_t size = definition->parameter_count * sizeof *bound;
    if (++definition->instance_count > INSTANCE_MAX) {
        FAIL(c, definition, PM_E_LIMIT, "%s is called with more than %d different functions",
             definition->text, INSTANCE_MAX);
        return NULL;
    }
    struct pm_instance *instance = pm_arena_alloc(&c->arena, sizeof *instance + size);
    if (!instance || !pm_language_grow((void **)&c->routines, c->routine_count,
                                       &c->routine_size, sizeof *c->routines)) {
        pm_compile_no_memory(c);
        return NULL;
    }
    memcpy(instance->bound, bound, size);
    instance->routine = c->routine_count++;
    instance->next = definition->instances;
    definition->instances = instance;
    c->routines[instance->routine] =
        (struct pm_routine){.open = true, .definition = definition};
    return instance;
}

static bool compile_routine(struct compiler *c, struct pm_definition *definition,
                            const struct pm_instance *instance)
{
    const struct scope inner = {definition, NULL, instance->bound};
    uint64_t outer = c->uses;
    uint32_t before = c->op_count - c->elsewhere;
    c->uses = 0;
    uint32_t body = pm_compile_node(c, definition->body, &inner);
    if (body == NONE)
        return false;
    struct pm_routine *routine = c->routines + instance->routine;
    routine->body = body;
    routine->height = c->ops[body].height;
    routine->uses = c->uses;
    routine->open = false;
    pm_compile_close(c, before, &routine->cost);
    c->uses = outer;
    return true;
}

/* May the body stand in place of the call? Only if no argument is evaluated twice by it. */
static bool fits(const struct compiler *c, const struct pm_definition *definition,
                 const uint32_t *args)
{
    if (definition->expanding || definition->expanded > INLINE_MAX)
        return false;
    for (uint32_t i = 0; i < definition->needed; i++)
        if (definition->occurrences[i] > 1 && !pm_op_is_leaf(c->ops + args[i]) &&
            c->ops[args[i]].code != PM_OP_ARG)
            return false;
    return true;
}

static uint32_t put_in_place(struct compiler *c, struct pm_definition *definition,
                             const uint32_t *args, const struct pm_name *const *bound)
{
    const struct scope inner = {definition, args, bound};
    uint32_t before = c->op_count - c->elsewhere;
    definition->expanding = true;
    uint32_t at = pm_compile_node(c, definition->body, &inner);
    definition->expanding = false;
    definition->expanded = c->op_count - c->elsewhere - before;
    return at;
}

static uint32_t routine_call(struct compiler *c, struct pm_definition *definition,
                             struct pm_instance *instance, const uint32_t *args)
{
    uint32_t first = c->stack.count, count = definition->needed;
    if (!instance)
        return NONE;
    struct pm_routine *routine = c->routines + instance->routine;
    routine->recursive = routine->recursive || routine->open;
    if (!routine->open) {
        const struct pm_op *body = c->ops + routine->body;
        if (body->code == PM_OP_NUMBER)
            return routine->body;
        if (body->code == PM_OP_ARG)
            return args[body->a];
    }
    uint64_t uses = routine->open ? PM_USES_OPEN : routine->uses;
    c->uses |= uses;
    for (uint32_t i = 0; i < count; i++)
        if (!pm_words_push(c, &c->stack, args[i]))
            return NONE;
    uint32_t at = pm_emit_listed(c, PM_OP_CALL, instance->routine, first, 0);
    return at != NONE && !uses && all_numbers(c, args, count) ? pm_emit_folded(c, at) : at;
}

static uint32_t function_call(struct compiler *c, const struct pm_node *node,
                              struct pm_definition *definition, const uint32_t *args,
                              uint32_t count, const struct pm_name *const *bound)
{
    if (count < definition->needed)
        return FAIL(c, node, PM_E_SYNTAX, "%s needs %d arguments and has %d", definition->text,
                    (int)definition->needed, (int)count);
    struct pm_instance *instance = find_instance(c, definition, bound);
    if (!instance && fits(c, definition, args))
        return put_in_place(c, definition, args, bound);
    if (!instance) {
        instance = add_instance(c, definition, bound);
        if (!instance || !compile_routine(c, definition, instance))
            return NONE;
    }
    return routine_call(c, definition, instance, args);
}

static const struct pm_name *callee_of(struct compiler *c, const struct pm_node *callee,
                                       const struct scope *scope)
{
    const struct pm_name *name = callee->kind == PM_NODE_NAME ? callee->name
                                 : scope->bound               ? scope->bound[callee->index]
                                                              : NULL;
    if (!name)
        FAIL(c, callee, PM_E_SYNTAX,
             "%s is called here, but what is handed over for it is not the name of a function",
             scope->function->parameters[callee->index]);
    return name;
}

/* Only the branch that a constant condition takes is looked at. */
static const struct pm_node *sure_branch(const struct compiler *c, const struct pm_node *args,
                                         uint32_t condition)
{
    if (condition == NONE || !pm_emitted_number(c, condition) || !args->next ||
        !args->next->next)
        return NULL;
    return c->ops[condition].number > 0 ? args->next : args->next->next;
}

static bool is_if(const struct pm_name *name)
{
    return name->builtin && name->builtin->code == PM_OP_IF &&
           !(name->definition && name->definition->parameter_count > 0);
}

/* With the arguments on the stack from `first` on. */
uint32_t pm_compile_call_of(struct compiler *c, const struct pm_node *node,
                            const struct pm_name *name, uint32_t first,
                            const struct scope *scope)
{
    uint32_t args[PM_LANGUAGE_PARAMETERS];
    const struct pm_name *bound[PM_LANGUAGE_PARAMETERS] = {NULL};
    uint32_t count = c->stack.count - first;
    struct pm_definition *definition = name->definition;
    if (!definition || definition->parameter_count == 0) {
        if (name->builtin)
            return library_call(c, node, name->builtin, first);
        c->stack.count = first;
        return c->constant ? pm_emit_missing(c, node)
                           : FAIL(c, node, PM_E_MISSING,
                                  "there is no function %.*s; define it in this file or in "
                                  "one that is read before",
                                  pm_name_length(name->text), name->text);
    }
    uint32_t wanted = count < definition->parameter_count ? count : definition->parameter_count;
    memcpy(args, c->stack.data + first, wanted * sizeof *args);
    c->stack.count = first;
    const struct pm_node *arg = node->first ? node->first->next : NULL;
    for (uint32_t i = 0; i < wanted && arg; i++, arg = arg->next)
        bound[i] = bound_name(arg, scope);
    return function_call(c, node, definition, args, wanted, bound);
}

uint32_t pm_compile_call(struct compiler *c, const struct pm_node *node,
                         const struct scope *scope)
{
    static const struct scope outside = {0};
    const struct pm_node *arg = node->first->next;
    scope = scope ? scope : &outside;
    const struct pm_name *name = callee_of(c, node->first, scope);
    if (!name)
        return NONE;
    uint32_t first = c->stack.count;
    for (; arg; arg = arg->next) {
        uint32_t at = argument(c, arg, scope);
        if (at == NONE || !pm_words_push(c, &c->stack, at))
            return NONE;
        const struct pm_node *branch =
            arg == node->first->next && is_if(name) ? sure_branch(c, arg, at) : NULL;
        if (branch) {
            c->stack.count = first;
            return pm_compile_node(c, branch, scope);
        }
    }
    if (node->source >= PM_SOURCES_OWN)
        c->user = node;
    return pm_compile_call_of(c, node, name, first, scope);
}
