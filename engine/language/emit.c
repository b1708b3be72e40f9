#include "language/compile_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

pm_status pm_compiler_begin(struct compiler *c, pm_language *language, pm_error *err)
{
    *c = (struct compiler){.language = language, .err = err};
    if (++language->stamp == UINT32_MAX)
        return pm_error_set(err, PM_E_LIMIT, "more than %u functions", UINT32_MAX - 1);
    c->stamp = language->stamp;
    return PM_OK;
}

void pm_compiler_clear(struct compiler *c)
{
    free(c->ops);
    free(c->lists.data);
    free(c->stack.data);
    free(c->routines);
    free(c->variables);
    pm_arena_clear(&c->arena);
}

uint32_t pm_compile_fail(const struct compiler *c, pm_status status, uint32_t source, int line,
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

uint32_t pm_compile_no_memory(const struct compiler *c)
{
    pm_error_set(c->err, PM_E_MEMORY, "not enough memory for a function");
    return NONE;
}

uint32_t pm_emit(struct compiler *c, struct pm_op op)
{
    if (c->op_count >= PM_LANGUAGE_CODE_MAX - c->language->code_ops) {
        pm_error_set(c->err, PM_E_LIMIT, "the functions come to more than %d nodes",
                     PM_LANGUAGE_CODE_MAX);
        return NONE;
    }
    if (!pm_language_grow((void **)&c->ops, c->op_count, &c->op_size, sizeof op))
        return pm_compile_no_memory(c);
    c->ops[c->op_count] = op;
    return c->op_count++;
}

uint32_t pm_emit_number(struct compiler *c, double value)
{
    return pm_emit(c, (struct pm_op){.code = PM_OP_NUMBER, .height = 1, .number = value});
}

bool pm_emitted_number(const struct compiler *c, uint32_t at)
{
    return c->ops[at].code == PM_OP_NUMBER;
}

bool pm_words_push(struct compiler *c, struct words *words, uint32_t word)
{
    if (!pm_language_grow((void **)&words->data, words->count, &words->size, sizeof word)) {
        pm_compile_no_memory(c);
        return false;
    }
    words->data[words->count++] = word;
    return true;
}

struct pm_code pm_compiler_code(const struct compiler *c)
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
uint32_t pm_emit_folded(struct compiler *c, uint32_t at)
{
    struct pm_run result;
    double value = 0;
    if (at == NONE || c->language->fold_work > PM_LANGUAGE_FOLD_MAX)
        return at;
    struct pm_code code = pm_compiler_code(c);
    pm_code_run(&code, &at, 1, NULL, NULL, &value, &result);
    c->language->fold_work += result.work;
    return result.faults ? at : pm_emit_number(c, value);
}

static uint16_t higher(uint16_t height, const struct compiler *c, uint32_t at)
{
    unsigned other = c->ops[at].height + 1u;
    return (uint16_t)(other > height ? other : height);
}

uint32_t pm_emit_fixed(struct compiler *c, enum pm_op_code code, const uint32_t *operands,
                       unsigned count)
{
    struct pm_op op = {.code = (uint8_t)code, .height = 2};
    bool constant = true;
    for (unsigned i = 0; i < count; i++) {
        op.height = higher(op.height, c, operands[i]);
        constant = constant && pm_emitted_number(c, operands[i]);
    }
    op.a = operands[0];
    op.b = count > 1 ? operands[1] : 0;
    op.c = count > 2 ? operands[2] : 0;
    uint32_t at = pm_emit(c, op);
    return constant ? pm_emit_folded(c, at) : at;
}

/* The entries of the stack from `first` on, as a list; `shift` 1 if they carry a flag. */
uint32_t pm_emit_listed(struct compiler *c, enum pm_op_code code, uint32_t a, uint32_t first,
                        unsigned shift)
{
    struct pm_op op = {.code = (uint8_t)code, .height = 2, .a = a};
    bool constant = true;
    op.b = c->lists.count;
    op.c = c->stack.count - first;
    for (uint32_t i = first; i < c->stack.count; i++) {
        uint32_t at = c->stack.data[i] >> shift;
        op.height = higher(op.height, c, at);
        constant = constant && pm_emitted_number(c, at);
        if (!pm_words_push(c, &c->lists, c->stack.data[i]))
            return NONE;
    }
    c->stack.count = first;
    uint32_t at = pm_emit(c, op);
    return constant && code != PM_OP_CALL ? pm_emit_folded(c, at) : at;
}

uint32_t pm_emit_missing(struct compiler *c, const struct pm_node *node)
{
    c->uses |= PM_USES_LOST;
    return pm_emit(c, (struct pm_op){.code = PM_OP_MISSING, .height = 1, .node = node});
}

bool pm_op_is_leaf(const struct pm_op *op)
{
    return op->code == PM_OP_NUMBER || op->code == PM_OP_RAY || op->code == PM_OP_REAL ||
           op->code == PM_OP_REAL_COUNT || op->code == PM_OP_VARIABLE;
}

void pm_compile_close(struct compiler *c, uint32_t before, uint32_t *cost)
{
    uint32_t size = c->op_count - c->elsewhere - before;
    *cost = 1 + size / 4;
    c->elsewhere += size;
}
