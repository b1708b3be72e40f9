/* Turns trees into programs. Names are resolved, short functions are put in place, and what is
 * constant is evaluated here. */
#include "language/compile_internal.h"

#include <assert.h>

enum { DEPTH_MAX = 4096 };

static uint32_t add_ray(struct compiler *c, const struct pm_node *node)
{
    /* Only the prelude may ask for those that have no number in Radiance. */
    uint32_t most = node->source == PM_SOURCE_RAY ? PM_RAY_VALUES : PM_RAY_LV + 1;
    if (node->index < 1 || node->index > most)
        return FAIL(c, node, PM_E_RANGE,
                    "there is no channel of this number; a ray has $1 to $%d", PM_RAY_LV + 1);
    if (c->constant)
        return pm_emit_missing(c, node);
    c->uses |= 1ull << (node->index - 1);
    return pm_emit(c, (struct pm_op){.code = PM_OP_RAY, .height = 1, .a = node->index - 1});
}

static uint32_t two_terms(struct compiler *c, bool product, uint32_t first, uint32_t second,
                          bool inverse)
{
    static const uint8_t codes[2][2] = {{PM_OP_ADD, PM_OP_SUBTRACT},
                                        {PM_OP_MULTIPLY, PM_OP_DIVIDE}};
    const uint32_t operands[2] = {first, second};
    return pm_emit_fixed(c, codes[product][inverse], operands, 2);
}

/* Terms are taken from left to right; the numbers in front become one number. */
static uint32_t chain(struct compiler *c, const struct pm_node *node, const struct scope *scope)
{
    bool product = node->kind == PM_NODE_PRODUCT;
    uint32_t first = c->stack.count;
    for (const struct pm_node *term = node->first; term; term = term->next) {
        uint32_t at = pm_compile_node(c, term, scope);
        uint32_t inverse = term->op == '-' || term->op == '/';
        if (at == NONE)
            return NONE;
        bool second = c->stack.count == first + 1;
        if (second && pm_emitted_number(c, at) &&
            pm_emitted_number(c, c->stack.data[first] >> 1)) {
            at = two_terms(c, product, c->stack.data[first] >> 1, at, inverse);
            if (at == NONE)
                return NONE;
            c->stack.count = first;
            inverse = 0;
        }
        if (!pm_words_push(c, &c->stack, at << 1 | inverse))
            return NONE;
    }
    uint32_t *terms = c->stack.data + first, count = c->stack.count - first;
    if (count > 2)
        return pm_emit_listed(c, product ? PM_OP_PRODUCT : PM_OP_SUM, 0, first, 1);
    c->stack.count = first;
    if (count == 1)
        return terms[0] >> 1;
    return two_terms(c, product, terms[0] >> 1, terms[1] >> 1, terms[1] & 1);
}

/* x^2, x^3, x^4 and x^.5 without a logarithm; their values differ from pow's in the last bit at
 * most. */
static uint32_t power(struct compiler *c, const struct pm_node *node, const struct scope *scope)
{
    uint32_t operands[2] = {pm_compile_node(c, node->first, scope), NONE};
    if (operands[0] != NONE)
        operands[1] = pm_compile_node(c, node->first->next, scope);
    if (operands[1] == NONE)
        return NONE;
    if (pm_emitted_number(c, operands[1]) && !pm_emitted_number(c, operands[0])) {
        double exponent = c->ops[operands[1]].number;
        if (exponent == .5)
            return pm_emit_fixed(c, PM_OP_SQRT, operands, 1);
        if (exponent == 1)
            return operands[0];
        if (exponent == 2 || exponent == 4) {
            uint32_t square = pm_emit_fixed(c, PM_OP_SQUARE, operands, 1);
            if (exponent == 2 || square == NONE)
                return square;
            return pm_emit_fixed(c, PM_OP_SQUARE, &square, 1);
        }
    }
    return pm_emit_fixed(c, PM_OP_POWER, operands, 2);
}

static uint32_t negative(struct compiler *c, const struct pm_node *node,
                         const struct scope *scope)
{
    uint32_t at = pm_compile_node(c, node->first, scope);
    return at == NONE ? NONE : pm_emit_fixed(c, PM_OP_NEGATE, &at, 1);
}

static uint32_t undefined(struct compiler *c, const struct pm_node *node)
{
    const char *text = node->name->text;
    int length = pm_name_length(text);
    if (c->constant)
        return pm_emit_missing(c, node);
    if (pm_name_is_callable(node->name))
        return FAIL(c, node, PM_E_MISSING,
                    "%.*s is a function: it needs its arguments, as in %.*s(x)", length, text,
                    length, text);
    return FAIL(c, node, PM_E_MISSING,
                "%.*s is not defined; define it in this file or in one that is read before",
                length, text);
}

static uint32_t open_variable(struct compiler *c, struct pm_name *name,
                              const struct pm_node *node)
{
    if (c->variable_count == PM_LANGUAGE_VARIABLES)
        return FAIL(c, node, PM_E_LIMIT, "a function asks for more than %d variables",
                    PM_LANGUAGE_VARIABLES);
    if (!pm_language_grow((void **)&c->variables, c->variable_count, &c->variable_size,
                          sizeof *c->variables))
        return pm_compile_no_memory(c);
    uint32_t number = c->variable_count++;
    c->variables[number] = (struct pm_variable){.open = true, .definition = name->definition};
    name->stamp = c->stamp;
    name->op = pm_emit(c, (struct pm_op){.code = PM_OP_VARIABLE, .height = 1, .a = number});
    return name->op == NONE ? NONE : number;
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
        return pm_emit_number(c, definition->body->number);
    if (name->stamp == c->stamp)
        return used_again(c, name);
    uint32_t number = open_variable(c, name, node);
    if (number == NONE)
        return NONE;
    uint64_t outer = c->uses;
    uint32_t before = c->op_count - c->elsewhere;
    c->uses = 0;
    uint32_t body = pm_compile_node(c, definition->body, NULL);
    if (body == NONE)
        return NONE;
    struct pm_variable *made = c->variables + number;
    made->body = body;
    made->height = c->ops[body].height;
    made->uses = c->uses;
    made->open = false;
    pm_compile_close(c, before, &made->cost);
    if (definition->constant && (c->uses & ~PM_USES_LOST))
        return FAIL(c, definition, PM_E_RANGE,
                    "%s is defined with : but is no constant; write %s = ...", definition->text,
                    definition->text);
    c->uses |= outer;
    if (pm_op_is_leaf(c->ops + body) && !(made->uses & PM_USES_OPEN))
        name->op = body;
    return name->op;
}

static uint32_t parameter(struct compiler *c, const struct pm_node *node,
                          const struct scope *scope)
{
    if (scope->given)
        return scope->given[node->index];
    return pm_emit(c, (struct pm_op){.code = PM_OP_ARG, .height = 1, .a = node->index});
}

uint32_t pm_compile_node(struct compiler *c, const struct pm_node *node,
                         const struct scope *scope)
{
    uint32_t at = NONE;
    if (++c->depth > DEPTH_MAX)
        return FAIL(c, node, PM_E_LIMIT, "definitions use each other more than %d levels deep",
                    DEPTH_MAX);
    switch ((enum pm_node_kind)node->kind) {
    case PM_NODE_NUMBER:
        at = pm_emit_number(c, node->number);
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
        at = pm_compile_call(c, node, scope);
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

/* One expression, or the name of a function with the arguments of the frame. */
static uint32_t compile_text(struct compiler *c, const struct pm_node *node, unsigned arg_count)
{
    static const struct scope outside = {0};
    /* 0 stands for a function that is always 0, as in Radiance's BRTDfunc */
    if (arg_count == 0 || (node->kind == PM_NODE_NUMBER && node->number == 0))
        return pm_compile_node(c, node, NULL);
    if (node->kind != PM_NODE_NAME)
        return FAIL(c, node, PM_E_SYNTAX,
                    "a function is wanted here by its name, not an expression");
    for (uint32_t i = 0; i < arg_count; i++) {
        uint32_t at = pm_emit(c, (struct pm_op){.code = PM_OP_ARG, .height = 1, .a = i});
        if (at == NONE || !pm_words_push(c, &c->stack, at))
            return NONE;
    }
    const struct pm_node by_name = {.kind = PM_NODE_CALL,
                                    .source = node->source,
                                    .line = node->line,
                                    .column = node->column};
    return pm_compile_call_of(c, &by_name, node->name, 0, &outside);
}

static pm_status compile_roots(struct compiler *c, struct pm_node *const *nodes,
                               const struct pm_function_request *request,
                               struct pm_program *program)
{
    for (unsigned i = 0; i < request->text_count; i++) {
        program->roots[i] = compile_text(c, nodes[i], request->arg_count);
        if (program->roots[i] == NONE)
            return c->err->status;
        assert(c->stack.count == 0);
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
    pm_status st = pm_compiler_begin(&c, language, err);
    if (st)
        return st;
    c.reals = request->reals;
    c.real_count = request->real_count;
    st = compile_roots(&c, nodes, request, &program);
    if (!st) {
        program.code = pm_compiler_code(&c);
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
    pm_compiler_clear(&c);
    return st ? st : pm_program_check(language, *out, err);
}
