/* Turns trees into programs. Names are resolved, functions that are handed on by name become
 * instances, short functions are put in place, and what is constant is evaluated here. */
#include "language/language_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NONE = UINT32_MAX, DEPTH_MAX = 4096, INLINE_MAX = 64 };

/* A function as called with certain functions for its arguments. */
struct pm_instance {
    struct pm_instance *next;
    uint32_t routine;
    const struct pm_name *bound[]; /* for each parameter, NULL if it is no function */
};

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

static uint32_t compile(struct compiler *c, const struct pm_node *node,
                        const struct scope *scope);

static uint32_t fail(const struct compiler *c, pm_status status, uint32_t source, int line,
                     int column, const char *format, ...) __attribute__((format(printf, 6, 7)));

static uint32_t fail(const struct compiler *c, pm_status status, uint32_t source, int line,
                     int column, const char *format, ...)
{
    char text[sizeof c->err->text];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (source < PM_SOURCES_OWN && c->user)
        pm_language_error(c->language, c->err, status, c->user->source, c->user->line,
                          c->user->column, "%s", text);
    else
        pm_language_error(c->language, c->err, status, source, line, column, "%s", text);
    return NONE;
}

#define FAIL(c, node, status, ...)                                                             \
    fail(c, status, (node)->source, (node)->line, (node)->column, __VA_ARGS__)

static uint32_t no_memory(const struct compiler *c)
{
    pm_error_set(c->err, PM_E_MEMORY, "not enough memory for a function");
    return NONE;
}

static void clear(struct compiler *c)
{
    free(c->ops);
    free(c->lists.data);
    free(c->stack.data);
    free(c->routines);
    free(c->variables);
    pm_arena_clear(&c->arena);
}

/* ---- Operations ---- */

static uint32_t add(struct compiler *c, struct pm_op op)
{
    if (c->op_count >= PM_LANGUAGE_CODE_MAX - c->language->code_ops) {
        pm_error_set(c->err, PM_E_LIMIT, "the functions come to more than %d nodes",
                     PM_LANGUAGE_CODE_MAX);
        return NONE;
    }
    if (!pm_language_grow((void **)&c->ops, c->op_count, &c->op_size, sizeof op))
        return no_memory(c);
    c->ops[c->op_count] = op;
    return c->op_count++;
}

static uint32_t add_number(struct compiler *c, double value)
{
    return add(c, (struct pm_op){.code = PM_OP_NUMBER, .height = 1, .number = value});
}

static bool is_number(const struct compiler *c, uint32_t at)
{
    return c->ops[at].code == PM_OP_NUMBER;
}

static bool push(struct compiler *c, struct words *words, uint32_t word)
{
    if (!pm_language_grow((void **)&words->data, words->count, &words->size, sizeof word)) {
        no_memory(c);
        return false;
    }
    words->data[words->count++] = word;
    return true;
}

static struct pm_code code_of(const struct compiler *c)
{
    return (struct pm_code){.ops = c->ops,
                            .lists = c->lists.data,
                            .routines = c->routines,
                            .variables = c->variables,
                            .op_count = c->op_count,
                            .list_count = c->lists.count,
                            .routine_count = c->routine_count,
                            .variable_count = c->variable_count};
}

/* The value of an operation that depends on nothing; stays as it is if it has none, so that the
 * fault is met at evaluation. */
static uint32_t folded(struct compiler *c, uint32_t at)
{
    struct pm_run result;
    double value = 0;
    if (at == NONE || c->language->fold_work > PM_LANGUAGE_FOLD_MAX)
        return at;
    struct pm_code code = code_of(c);
    pm_code_run(&code, &at, 1, NULL, NULL, &value, &result);
    c->language->fold_work += result.work;
    return result.faults ? at : add_number(c, value);
}

static uint16_t higher(uint16_t height, const struct compiler *c, uint32_t at)
{
    unsigned other = c->ops[at].height + 1u;
    return (uint16_t)(other > height ? other : height);
}

static uint32_t add_fixed(struct compiler *c, enum pm_op_code code, const uint32_t *operands,
                          unsigned count)
{
    struct pm_op op = {.code = (uint8_t)code, .height = 2};
    bool constant = true;
    for (unsigned i = 0; i < count; i++) {
        op.height = higher(op.height, c, operands[i]);
        constant = constant && is_number(c, operands[i]);
    }
    op.a = operands[0];
    op.b = count > 1 ? operands[1] : 0;
    op.c = count > 2 ? operands[2] : 0;
    uint32_t at = add(c, op);
    return constant ? folded(c, at) : at;
}

/* The entries of the stack from `first` on, as a list; `shift` 1 if they carry a flag. */
static uint32_t add_listed(struct compiler *c, enum pm_op_code code, uint32_t a, uint32_t first,
                           unsigned shift)
{
    struct pm_op op = {.code = (uint8_t)code, .height = 2, .a = a};
    bool constant = true;
    op.b = c->lists.count;
    op.c = c->stack.count - first;
    for (uint32_t i = first; i < c->stack.count; i++) {
        uint32_t at = c->stack.data[i] >> shift;
        op.height = higher(op.height, c, at);
        constant = constant && is_number(c, at);
        if (!push(c, &c->lists, c->stack.data[i]))
            return NONE;
    }
    c->stack.count = first;
    uint32_t at = add(c, op);
    return constant && code != PM_OP_CALL ? folded(c, at) : at;
}

static uint32_t add_missing(struct compiler *c, const struct pm_node *node)
{
    c->uses |= PM_USES_LOST;
    return add(c, (struct pm_op){.code = PM_OP_MISSING, .height = 1, .node = node});
}

static uint32_t add_ray(struct compiler *c, const struct pm_node *node)
{
    if (c->constant)
        return add_missing(c, node);
    c->uses |= 1ull << node->index;
    return add(c, (struct pm_op){.code = PM_OP_RAY, .height = 1, .a = node->index});
}

/* ---- Sums and products ---- */

static uint32_t two_terms(struct compiler *c, bool product, uint32_t first, uint32_t second,
                          bool inverse)
{
    static const uint8_t codes[2][2] = {{PM_OP_ADD, PM_OP_SUBTRACT},
                                        {PM_OP_MULTIPLY, PM_OP_DIVIDE}};
    const uint32_t operands[2] = {first, second};
    return add_fixed(c, codes[product][inverse], operands, 2);
}

/* Terms are taken from left to right; the numbers in front become one number. */
static uint32_t chain(struct compiler *c, const struct pm_node *node, const struct scope *scope)
{
    bool product = node->kind == PM_NODE_PRODUCT;
    uint32_t first = c->stack.count;
    for (const struct pm_node *term = node->first; term; term = term->next) {
        uint32_t at = compile(c, term, scope);
        uint32_t inverse = term->op == '-' || term->op == '/';
        if (at == NONE)
            return NONE;
        bool second = c->stack.count == first + 1;
        if (second && is_number(c, at) && is_number(c, c->stack.data[first] >> 1)) {
            at = two_terms(c, product, c->stack.data[first] >> 1, at, inverse);
            if (at == NONE)
                return NONE;
            c->stack.count = first;
            inverse = 0;
        }
        if (!push(c, &c->stack, at << 1 | inverse))
            return NONE;
    }
    uint32_t *terms = c->stack.data + first, count = c->stack.count - first;
    if (count > 2)
        return add_listed(c, product ? PM_OP_PRODUCT : PM_OP_SUM, 0, first, 1);
    c->stack.count = first;
    if (count == 1)
        return terms[0] >> 1;
    return two_terms(c, product, terms[0] >> 1, terms[1] >> 1, terms[1] & 1);
}

/* x^2, x^3, x^4 and x^.5 without a logarithm; their values differ from pow's in the last bit at
 * most. */
static uint32_t power(struct compiler *c, const struct pm_node *node, const struct scope *scope)
{
    uint32_t operands[2] = {compile(c, node->first, scope), NONE};
    if (operands[0] != NONE)
        operands[1] = compile(c, node->first->next, scope);
    if (operands[1] == NONE)
        return NONE;
    if (is_number(c, operands[1]) && !is_number(c, operands[0])) {
        double exponent = c->ops[operands[1]].number;
        if (exponent == .5)
            return add_fixed(c, PM_OP_SQRT, operands, 1);
        if (exponent == 1)
            return operands[0];
        if (exponent == 2 || exponent == 4) {
            uint32_t square = add_fixed(c, PM_OP_SQUARE, operands, 1);
            if (exponent == 2 || square == NONE)
                return square;
            return add_fixed(c, PM_OP_SQUARE, &square, 1);
        }
    }
    return add_fixed(c, PM_OP_POWER, operands, 2);
}

static uint32_t negative(struct compiler *c, const struct pm_node *node,
                         const struct scope *scope)
{
    uint32_t at = compile(c, node->first, scope);
    return at == NONE ? NONE : add_fixed(c, PM_OP_NEGATE, &at, 1);
}

/* ---- Variables ---- */

static bool is_callable(const struct pm_name *name)
{
    return name->builtin || (name->definition && name->definition->parameter_count > 0);
}

static uint32_t undefined(struct compiler *c, const struct pm_node *node)
{
    const char *text = node->name->text;
    int length = pm_name_length(text);
    if (c->constant)
        return add_missing(c, node);
    if (is_callable(node->name))
        return FAIL(c, node, PM_E_MISSING,
                    "%.*s is a function: it needs its arguments, as in %.*s(x)", length, text,
                    length, text);
    return FAIL(c, node, PM_E_MISSING,
                "%.*s is not defined; define it in this file or in one that is read before",
                length, text);
}

static void close_body(struct compiler *c, uint32_t before, uint32_t *cost)
{
    uint32_t size = c->op_count - c->elsewhere - before;
    *cost = 1 + size / 4;
    c->elsewhere += size;
}

static uint32_t open_variable(struct compiler *c, struct pm_name *name,
                              const struct pm_node *node)
{
    if (c->variable_count == PM_LANGUAGE_VARIABLES)
        return FAIL(c, node, PM_E_LIMIT, "a function asks for more than %d variables",
                    PM_LANGUAGE_VARIABLES);
    if (!pm_language_grow((void **)&c->variables, c->variable_count, &c->variable_size,
                          sizeof *c->variables))
        return no_memory(c);
    uint32_t number = c->variable_count++;
    c->variables[number] = (struct pm_variable){.open = true, .definition = name->definition};
    name->stamp = c->stamp;
    name->op = add(c, (struct pm_op){.code = PM_OP_VARIABLE, .height = 1, .a = number});
    return name->op == NONE ? NONE : number;
}

static bool is_leaf(const struct pm_op *op)
{
    return op->code == PM_OP_NUMBER || op->code == PM_OP_RAY || op->code == PM_OP_REAL ||
           op->code == PM_OP_REAL_COUNT || op->code == PM_OP_VARIABLE;
}

static uint32_t used_again(struct compiler *c, const struct pm_name *name)
{
    const struct pm_op *op = c->ops + name->op;
    if (op->code == PM_OP_VARIABLE) {
        struct pm_variable *used = c->variables + op->a;
        c->uses |= used->open ? PM_USES_OPEN : used->uses;
        used->recursive = used->recursive || used->open;
    } else if (op->code == PM_OP_RAY)
        c->uses |= 1ull << op->a;
    else if (op->code == PM_OP_REAL || op->code == PM_OP_REAL_COUNT)
        c->uses |= PM_USES_REALS;
    return name->op;
}

static uint32_t variable(struct compiler *c, const struct pm_node *node)
{
    struct pm_name *name = node->name;
    const struct pm_definition *definition = name->definition;
    if (!definition || definition->parameter_count > 0)
        return undefined(c, node);
    if (node->source >= PM_SOURCES_OWN)
        c->user = node;
    if (definition->body->kind == PM_NODE_NUMBER)
        return add_number(c, definition->body->number);
    if (name->stamp == c->stamp)
        return used_again(c, name);
    uint32_t number = open_variable(c, name, node);
    if (number == NONE)
        return NONE;
    uint64_t outer = c->uses;
    uint32_t before = c->op_count - c->elsewhere;
    c->uses = 0;
    uint32_t body = compile(c, definition->body, NULL);
    if (body == NONE)
        return NONE;
    struct pm_variable *made = c->variables + number;
    made->body = body;
    made->height = c->ops[body].height;
    made->uses = c->uses;
    made->open = false;
    close_body(c, before, &made->cost);
    if (definition->constant && (c->uses & ~PM_USES_LOST))
        return FAIL(c, definition, PM_E_RANGE,
                    "%s is defined with : but is no constant; write %s = ...", definition->text,
                    definition->text);
    c->uses |= outer;
    if (is_leaf(c->ops + body) && !(made->uses & PM_USES_OPEN))
        name->op = body;
    return name->op;
}

/* ---- Calls ---- */

static uint32_t parameter(struct compiler *c, const struct pm_node *node,
                          const struct scope *scope)
{
    if (scope->given)
        return scope->given[node->index];
    return add(c, (struct pm_op){.code = PM_OP_ARG, .height = 1, .a = node->index});
}

/* The function that an argument names, NULL if it names none. */
static const struct pm_name *bound_name(const struct pm_node *arg, const struct scope *scope)
{
    if (arg->kind == PM_NODE_NAME && is_callable(arg->name))
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
    if (arg->kind == PM_NODE_NAME && is_callable(arg->name) && !variable_too)
        return add_missing(c, arg);
    return compile(c, arg, scope);
}

static bool all_numbers(const struct compiler *c, const uint32_t *args, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (!is_number(c, args[i]))
            return false;
    return true;
}

static uint32_t real_argument(struct compiler *c, const struct pm_node *node, uint32_t which)
{
    if (node->source < PM_SOURCES_OWN && c->user)
        node = c->user;
    if (c->constant)
        return add_missing(c, node);
    c->asked_reals = true;
    if (!is_number(c, which)) {
        c->uses |= PM_USES_REALS;
        return add(c, (struct pm_op){.code = PM_OP_REAL_AT,
                                     .height = (uint16_t)(c->ops[which].height + 1),
                                     .a = which});
    }
    double number = c->ops[which].number;
    uint32_t index = number + .5 >= 1 ? (uint32_t)fmin(number + .5, 0x1p31) : 0;
    if (c->reals && index == 0)
        return add_number(c, c->real_count);
    if (c->reals)
        return index > c->real_count ? add_missing(c, node)
                                     : add_number(c, c->reals[index - 1]);
    c->uses |= PM_USES_REALS;
    enum pm_op_code code = index ? PM_OP_REAL : PM_OP_REAL_COUNT;
    return add(c,
               (struct pm_op){.code = (uint8_t)code, .height = 1, .a = index ? index - 1 : 0});
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
        return add_listed(c, builtin->code, 0, first, 0);
    if (builtin->code == PM_OP_SELECT) {
        double which = is_number(c, args[0]) ? c->ops[args[0]].number + .5 : 0;
        if (!(which >= 1 && which < count))
            return add_listed(c, builtin->code, 0, first, 0);
        fixed[0] = args[(uint32_t)which];
        c->stack.count = first;
        return fixed[0];
    }
    c->stack.count = first;
    if (builtin->code == PM_OP_REAL_AT)
        return real_argument(c, node, fixed[0]);
    if (builtin->code == PM_OP_IF && is_number(c, fixed[0]))
        return c->ops[fixed[0]].number > 0 ? fixed[1] : fixed[2];
    return add_fixed(c, builtin->code, fixed, builtin->least);
}

static struct pm_instance *find_instance(struct compiler *c, struct pm_definition *definition,
                                         const struct pm_name *const *bound)
{
    if (definition->stamp != c->stamp) {
        definition->stamp = c->stamp;
        definition->instances = NULL;
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
    struct pm_instance *instance = pm_arena_alloc(&c->arena, sizeof *instance + size);
    if (!instance || !pm_language_grow((void **)&c->routines, c->routine_count,
                                       &c->routine_size, sizeof *c->routines)) {
        no_memory(c);
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
    uint32_t body = compile(c, definition->body, &inner);
    if (body == NONE)
        return false;
    struct pm_routine *routine = c->routines + instance->routine;
    routine->body = body;
    routine->height = c->ops[body].height;
    routine->uses = c->uses;
    routine->open = false;
    close_body(c, before, &routine->cost);
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
        if (definition->occurrences[i] > 1 && !is_leaf(c->ops + args[i]) &&
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
    uint32_t at = compile(c, definition->body, &inner);
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
        if (!push(c, &c->stack, args[i]))
            return NONE;
    uint32_t at = add_listed(c, PM_OP_CALL, instance->routine, first, 0);
    return at != NONE && !uses && all_numbers(c, args, count) ? folded(c, at) : at;
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
    if (condition == NONE || !is_number(c, condition) || !args->next || !args->next->next)
        return NULL;
    return c->ops[condition].number > 0 ? args->next : args->next->next;
}

static bool is_if(const struct pm_name *name)
{
    return name->builtin && name->builtin->code == PM_OP_IF &&
           !(name->definition && name->definition->parameter_count > 0);
}

/* With the arguments on the stack from `first` on. */
static uint32_t call_by_name(struct compiler *c, const struct pm_node *node,
                             const struct pm_name *name, uint32_t first,
                             const struct scope *scope)
{
    uint32_t args[PM_LANGUAGE_PARAMETERS];
    const struct pm_name *bound[PM_LANGUAGE_PARAMETERS] = {NULL};
    uint32_t count = c->stack.count - first;
    struct pm_definition *definition = name->definition;
    if (!definition || definition->parameter_count == 0) {
        if (!name->builtin)
            return c->constant ? add_missing(c, node)
                               : FAIL(c, node, PM_E_MISSING,
                                      "there is no function %.*s; define it in this file or in "
                                      "one that is read before",
                                      pm_name_length(name->text), name->text);
        return library_call(c, node, name->builtin, first);
    }
    uint32_t wanted = count < definition->parameter_count ? count : definition->parameter_count;
    memcpy(args, c->stack.data + first, wanted * sizeof *args);
    c->stack.count = first;
    const struct pm_node *arg = node->first ? node->first->next : NULL;
    for (uint32_t i = 0; i < wanted && arg; i++, arg = arg->next)
        bound[i] = bound_name(arg, scope);
    return function_call(c, node, definition, args, wanted, bound);
}

static uint32_t call(struct compiler *c, const struct pm_node *node, const struct scope *scope)
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
        if (at == NONE || !push(c, &c->stack, at))
            return NONE;
        const struct pm_node *branch =
            arg == node->first->next && is_if(name) ? sure_branch(c, arg, at) : NULL;
        if (branch) {
            c->stack.count = first;
            return compile(c, branch, scope);
        }
    }
    if (node->source >= PM_SOURCES_OWN)
        c->user = node;
    return call_by_name(c, node, name, first, scope);
}

static uint32_t compile(struct compiler *c, const struct pm_node *node,
                        const struct scope *scope)
{
    uint32_t at = NONE;
    if (++c->depth > DEPTH_MAX)
        return FAIL(c, node, PM_E_LIMIT, "definitions use each other more than %d levels deep",
                    DEPTH_MAX);
    switch ((enum pm_node_kind)node->kind) {
    case PM_NODE_NUMBER:
        at = add_number(c, node->number);
        break;
    case PM_NODE_NAME:
        at = variable(c, node);
        break;
    case PM_NODE_PARAMETER:
        at = parameter(c, node, scope);
        break;
    case PM_NODE_CHANNEL:
        at = add_ray(c, node);
        break;
    case PM_NODE_CALL:
        at = call(c, node, scope);
        break;
    case PM_NODE_NEGATE:
        at = negative(c, node, scope);
        break;
    case PM_NODE_SUM:
    case PM_NODE_PRODUCT:
        at = chain(c, node, scope);
        break;
    case PM_NODE_POWER:
        at = power(c, node, scope);
        break;
    }
    c->depth--;
    return at;
}

/* ---- Constants ---- */

static pm_status begin(struct compiler *c, pm_language *language, pm_error *err)
{
    *c = (struct compiler){.language = language, .err = err};
    if (++language->stamp == UINT32_MAX)
        return pm_error_set(err, PM_E_LIMIT, "more than %u functions", UINT32_MAX - 1);
    c->stamp = language->stamp;
    return PM_OK;
}

static const char *missing_text(const struct pm_node *node)
{
    if (node->kind == PM_NODE_CHANNEL)
        return "a constant (:) cannot depend on the ray; write =";
    const struct pm_name *name = node->kind == PM_NODE_NAME          ? node->name
                                 : node->first->kind == PM_NODE_NAME ? node->first->name
                                                                     : NULL;
    if (name && (name->definition || name->builtin))
        return "a constant (:) cannot depend on real arguments; write =";
    return "a constant needs this, which is not defined yet";
}

static void constant_lacks(const struct compiler *c, const struct pm_node *place,
                           const struct pm_node *missing)
{
    const char *name = missing->kind == PM_NODE_NAME ? missing->name->text : "";
    int length = pm_name_length(name);
    if (missing->kind == PM_NODE_NAME && is_callable(missing->name))
        FAIL(c, place, PM_E_MISSING,
             "%.*s is a function: it needs its arguments, as in %.*s(x)", length, name, length,
             name);
    else
        FAIL(c, place, PM_E_MISSING, "%s", missing_text(missing));
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
    pm_status st = begin(&c, language, err);
    if (st)
        return st;
    c.constant = true;
    uint32_t root = compile(&c, node, NULL);
    if (root == NONE)
        st = err->status;
    language->fold_work += c.op_count;
    if (!st) {
        struct pm_code code = code_of(&c);
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
    clear(&c);
    return st;
}

/* ---- Requests ---- */

/* One expression, or the name of a function with the arguments of the frame. */
static uint32_t compile_text(struct compiler *c, const struct pm_node *node, unsigned arg_count)
{
    static const struct scope outside = {0};
    /* 0 stands for a function that is always 0, as in Radiance's BRTDfunc */
    if (arg_count == 0 || (node->kind == PM_NODE_NUMBER && node->number == 0))
        return compile(c, node, NULL);
    if (node->kind != PM_NODE_NAME)
        return FAIL(c, node, PM_E_SYNTAX,
                    "a function is wanted here by its name, not an expression");
    for (uint32_t i = 0; i < arg_count; i++) {
        uint32_t at = add(c, (struct pm_op){.code = PM_OP_ARG, .height = 1, .a = i});
        if (at == NONE || !push(c, &c->stack, at))
            return NONE;
    }
    const struct pm_node by_name = {.kind = PM_NODE_CALL,
                                    .source = node->source,
                                    .line = node->line,
                                    .column = node->column};
    return call_by_name(c, &by_name, node->name, 0, &outside);
}

static pm_status compile_roots(struct compiler *c, struct pm_node *const *nodes,
                               const struct pm_function_request *request,
                               struct pm_program *program)
{
    for (unsigned i = 0; i < request->text_count; i++) {
        program->roots[i] = compile_text(c, nodes[i], request->arg_count);
        if (program->roots[i] == NONE)
            return c->err->status;
    }
    program->root_count = request->text_count;
    program->arg_count = request->arg_count;
    program->uses = c->uses;
    program->node = nodes[0];
    program->real_count = c->real_count;
    return PM_OK;
}

pm_status pm_program_compile(pm_language *language, struct pm_node *const *nodes,
                             const struct pm_function_request *request, struct pm_program **out,
                             bool *asked_reals, pm_error *err)
{
    struct compiler c;
    struct pm_program program = {0};
    pm_status st = begin(&c, language, err);
    if (st)
        return st;
    c.reals = request->reals;
    c.real_count = request->real_count;
    st = compile_roots(&c, nodes, request, &program);
    if (!st) {
        program.code = code_of(&c);
        if (c.reals && program.uses & PM_USES_REALS) {
            program.code.reals = c.reals;
            program.code.real_count = c.real_count;
            program.code.own_reals = true;
        }
        *out = pm_program_keep(&language->arena, &program);
        *asked_reals = c.asked_reals;
        st = *out ? PM_OK : pm_error_set(err, PM_E_MEMORY, "not enough memory for a function");
    }
    if (!st)
        language->code_ops += (*out)->code.op_count;
    clear(&c);
    return st ? st : pm_program_check(language, *out, err);
}
