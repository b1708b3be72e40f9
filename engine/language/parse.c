/* The grammar of calexpr.c and caldefn.c: statements `name = e;`, `name : e;`, `f(a, b) = e;`,
 * and expressions
 *   E1 -> E1 + E2 | E1 - E2 | E2        E2 -> E2 * E3 | E2 / E3 | E3
 *   E3 -> E4 ^ E3 | E4                  E4 -> - E5 | + E5 | E5
 *   E5 -> ( E1 ) | name | name(E1, ..) | number | $n
 * so that -2^2 is 4 and - -2 does not parse. What is constant is folded while reading, with
 * what is defined by then, and names are bound to what there is by then: both decide what a
 * program means when names are defined again later. */
#include "language/language_internal.h"

#include <math.h>
#include <string.h>

#include "base/number.h"

struct parser {
    pm_language *language;
    const char *mark; /* of the context */
    const char *text;
    size_t size, at, line_start;
    int line;
    int column; /* of the first character of the line */
    uint32_t source;
    unsigned depth;
    struct pm_definition *function; /* whose body is being read */
    pm_error *err;
};

struct place {
    int line, column;
};

static struct place here(const struct parser *p)
{
    return (struct place){p->line, p->column + (int)(p->at - p->line_start)};
}

#define FAIL(p, place, status, ...)                                                            \
    pm_language_error((p)->language, (p)->err, status, (p)->source, (place).line,              \
                      (place).column, __VA_ARGS__)

/* The current character, -1 at the end. */
static int peek(const struct parser *p)
{
    return p->at < p->size ? (unsigned char)p->text[p->at] : -1;
}

static bool is_digit(int c)
{
    return c >= '0' && c <= '9';
}

static bool is_letter(int c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static bool is_name(int c)
{
    return is_letter(c) || is_digit(c) || c == '_' || c == '.' || c == '`';
}

static void step(struct parser *p)
{
    if (p->text[p->at++] == '\n') {
        p->line++;
        p->line_start = p->at;
        p->column = 1;
    }
}

/* Past white space and comments, which nest. */
static pm_status skip(struct parser *p)
{
    for (;;) {
        while (peek(p) == ' ' || (peek(p) >= '\t' && peek(p) <= '\r'))
            step(p);
        if (peek(p) != '{')
            return PM_OK;
        struct place start = here(p);
        unsigned open = 0;
        do {
            if (peek(p) < 0)
                return FAIL(p, start, PM_E_SYNTAX, "this comment has no end; } is missing");
            open += peek(p) == '{';
            open -= peek(p) == '}';
            step(p);
        } while (open > 0);
    }
}

static pm_status next(struct parser *p)
{
    step(p);
    return skip(p);
}

static pm_status unexpected(const struct parser *p, const char *wanted)
{
    int c = peek(p);
    if (c < 0)
        return FAIL(p, here(p), PM_E_SYNTAX, "the text ends where %s should be", wanted);
    if (c <= ' ' || c > '~')
        return FAIL(p, here(p), PM_E_SYNTAX, "character %d where %s should be", c, wanted);
    return FAIL(p, here(p), PM_E_SYNTAX, "'%c' where %s should be", c, wanted);
}

static pm_status no_memory(const struct parser *p)
{
    return FAIL(p, here(p), PM_E_MEMORY, "not enough memory");
}

/* A name, with the white space after it. */
static pm_status get_name(struct parser *p, char out[PM_LANGUAGE_NAME + 1])
{
    struct place start = here(p);
    size_t length = 0;
    for (; is_name(peek(p)); step(p)) {
        if (length == PM_LANGUAGE_NAME)
            return FAIL(p, start, PM_E_LIMIT, "this name is longer than %d characters",
                        PM_LANGUAGE_NAME);
        out[length++] = p->text[p->at];
    }
    out[length] = '\0';
    return skip(p);
}

static void digits(struct parser *p)
{
    while (is_digit(peek(p)))
        step(p);
}

static pm_status get_number(struct parser *p, double *value)
{
    struct place start = here(p);
    size_t first = p->at;
    digits(p);
    if (peek(p) == '.') {
        step(p);
        if (p->at == first + 1 && !is_digit(peek(p)))
            return FAIL(p, start, PM_E_SYNTAX, "a lone point; a number has a digit beside it");
        digits(p);
    }
    if (peek(p) == 'e' || peek(p) == 'E') {
        step(p);
        if (peek(p) == '-' || peek(p) == '+')
            step(p);
        if (!is_digit(peek(p)))
            return unexpected(p, "the digits of an exponent");
        digits(p);
    }
    pm_number got = pm_number_real(p->text + first, p->at - first, value);
    if (got == PM_NUMBER_HUGE)
        return FAIL(p, start, PM_E_RANGE, "this number is too large");
    if (got != PM_NUMBER_OK)
        return FAIL(p, start, PM_E_SYNTAX, "this is not a number");
    return skip(p);
}

static struct pm_node *new_node(const struct parser *p, enum pm_node_kind kind,
                                struct place place)
{
    struct pm_node *node = pm_arena_alloc(&p->language->arena, sizeof *node);
    if (!node) {
        no_memory(p);
        return NULL;
    }
    node->kind = (uint8_t)kind;
    node->source = p->source;
    node->line = place.line;
    node->column = place.column;
    return node;
}

static struct pm_node *new_number(const struct parser *p, struct place place, double value)
{
    struct pm_node *node = new_node(p, PM_NODE_NUMBER, place);
    if (node)
        node->number = value;
    return node;
}

/* The number that a constant expression comes to; NULL if it has none. */
static struct pm_node *fold(const struct parser *p, const struct pm_node *node)
{
    double value;
    if (pm_constant_value(p->language, node, &value, p->err))
        return NULL;
    return new_number(p, (struct place){node->line, node->column}, value);
}

static bool is_number(const struct pm_node *node)
{
    return node->kind == PM_NODE_NUMBER;
}

static bool is_value(const struct pm_node *node, double value)
{
    return is_number(node) && node->number == value;
}

static struct pm_node *expression(struct parser *p);

/* One more term: `chain` is NULL or the sum or product that was begun with `left`. Returns what
 * both are together. */
static struct pm_node *append(struct parser *p, struct pm_node *left, struct pm_node **chain,
                              struct pm_node **last, struct pm_node *right, char op,
                              struct place place)
{
    if (!*chain) {
        *chain = new_node(p, op == '+' || op == '-' ? PM_NODE_SUM : PM_NODE_PRODUCT, place);
        if (!*chain)
            return NULL;
        left->op = op == '+' || op == '-' ? '+' : '*';
        (*chain)->first = left;
        *last = left;
    }
    right->op = op;
    (*last)->next = right;
    *last = right;
    return *chain;
}

static struct pm_node *fold_two(struct parser *p, struct pm_node *left, struct pm_node *right,
                                char op, struct place place)
{
    struct pm_node *chain = NULL, *last = NULL;
    struct pm_node *both = append(p, left, &chain, &last, right, op, place);
    return both ? fold(p, both) : NULL;
}

static struct pm_node *factor(struct parser *p);

/* E2 with what calexpr.c simplifies: division by a number is multiplication, 0 times anything
 * is 0 and is not evaluated. */
static struct pm_node *term(struct parser *p)
{
    struct pm_node *left = factor(p), *chain = NULL, *last = NULL;
    while (left && (peek(p) == '*' || peek(p) == '/')) {
        struct place place = here(p);
        char op = (char)peek(p);
        struct pm_node *right = next(p) ? NULL : factor(p);
        if (!right)
            return NULL;
        if (op == '/' && is_value(right, 0)) {
            FAIL(p, place, PM_E_RANGE, "division by zero");
            return NULL;
        }
        if (is_number(left) && is_number(right)) {
            left = fold_two(p, left, right, op, place);
            chain = NULL;
        } else if (is_value(right, 0) || is_value(left, 0)) {
            left = is_value(right, 0) ? right : left;
            chain = NULL;
        } else {
            if (op == '/' && is_number(right) && isfinite(1 / right->number)) {
                right->number = 1 / right->number;
                op = '*';
            }
            left = append(p, left, &chain, &last, right, op, place);
        }
    }
    return left;
}

static struct pm_node *expression(struct parser *p)
{
    struct pm_node *left = term(p), *chain = NULL, *last = NULL;
    while (left && (peek(p) == '+' || peek(p) == '-')) {
        struct place place = here(p);
        char op = (char)peek(p);
        struct pm_node *right = next(p) ? NULL : term(p);
        if (!right)
            return NULL;
        if (is_number(left) && is_number(right))
            left = fold_two(p, left, right, op, place);
        else
            left = append(p, left, &chain, &last, right, op, place);
    }
    return left;
}

static bool descend(struct parser *p)
{
    if (++p->depth <= PM_LANGUAGE_NESTING)
        return true;
    FAIL(p, here(p), PM_E_LIMIT, "nested deeper than %d levels", PM_LANGUAGE_NESTING);
    return false;
}

static struct pm_node *parenthesis(struct parser *p)
{
    struct pm_node *node = next(p) ? NULL : expression(p);
    if (!node)
        return NULL;
    if (peek(p) != ')') {
        unexpected(p, "an operator, or the ) of this parenthesis,");
        return NULL;
    }
    return next(p) ? NULL : node;
}

static struct pm_node *channel(struct parser *p)
{
    struct place place = here(p);
    unsigned long number = 0;
    if (p->language->kind != PM_LANGUAGE_SCENE) {
        FAIL(p, place, PM_E_UNSUPPORTED, "there are no input channels here");
        return NULL;
    }
    if (next(p))
        return NULL;
    for (; is_digit(peek(p)); step(p))
        number = number < 1000 ? 10 * number + (unsigned long)(peek(p) - '0') : number;
    struct pm_node *node = new_node(p, PM_NODE_CHANNEL, place);
    if (node)
        node->index = (uint32_t)number; /* from 1, and 0 is none */
    return skip(p) ? NULL : node;
}

/* False if there is no parameter of this name; *node is NULL if memory is short. */
static bool find_parameter(struct parser *p, const char *name, struct place place,
                           struct pm_node **node)
{
    struct pm_definition *function = p->function;
    uint32_t i = 0, count = function ? function->parameter_count : 0;
    while (i < count && strcmp(function->parameters[i], name) != 0)
        i++;
    if (i == count)
        return false;
    *node = new_node(p, PM_NODE_PARAMETER, place);
    if (*node)
        (*node)->index = i;
    function->occurrences[i]++;
    if (function->needed < i + 1)
        function->needed = i + 1;
    return true;
}

static struct pm_node *global_or_local(struct parser *p, const char *name, struct place place)
{
    struct pm_node *node = new_node(p, PM_NODE_NAME, place);
    if (!node)
        return NULL;
    node->name = pm_name_insert(p->language, p->mark, name);
    if (node->name)
        return node;
    no_memory(p);
    return NULL;
}

static bool names_constant_function(const struct pm_node *node)
{
    if (node->kind != PM_NODE_NAME)
        return false;
    const struct pm_definition *definition = node->name->definition;
    if (definition)
        return definition->parameter_count > 0 && definition->constant;
    return node->name->builtin && node->name->builtin->constant;
}

/* Whether calexpr.c would evaluate this while reading (isconstvar). */
static bool is_constant(const struct pm_node *node)
{
    if (node->kind == PM_NODE_NAME) {
        const struct pm_definition *definition = node->name->definition;
        return definition && definition->constant && definition->parameter_count == 0;
    }
    if (node->kind != PM_NODE_CALL || !names_constant_function(node->first))
        return false;
    for (const struct pm_node *arg = node->first->next; arg; arg = arg->next)
        if (!is_number(arg) && !names_constant_function(arg))
            return false;
    return true;
}

static struct pm_node *arguments(struct parser *p, struct pm_node *callee)
{
    struct pm_node *call =
        new_node(p, PM_NODE_CALL, (struct place){callee->line, callee->column});
    struct pm_node *last = callee;
    if (!call)
        return NULL;
    call->first = callee;
    do {
        struct pm_node *arg = next(p) ? NULL : expression(p);
        if (!arg)
            return NULL;
        last->next = arg;
        last = arg;
    } while (peek(p) == ',');
    if (peek(p) != ')') {
        unexpected(p, "an operator, a comma or the ) of the arguments");
        return NULL;
    }
    return next(p) ? NULL : call;
}

static struct pm_node *name_or_call(struct parser *p)
{
    char name[PM_LANGUAGE_NAME + 1];
    struct place place = here(p);
    if (get_name(p, name))
        return NULL;
    struct pm_node *node = NULL;
    if (!find_parameter(p, name, place, &node))
        node = global_or_local(p, name, place);
    if (!node)
        return NULL;
    if (peek(p) == '(')
        node = arguments(p, node);
    return node && is_constant(node) ? fold(p, node) : node;
}

static struct pm_node *primary(struct parser *p)
{
    double value;
    struct place place = here(p);
    int c = peek(p);
    if (c == '(')
        return parenthesis(p);
    if (c == '$')
        return channel(p);
    if (is_letter(c) || c == '`')
        return name_or_call(p);
    if (is_digit(c) || c == '.')
        return get_number(p, &value) ? NULL : new_number(p, place, value);
    unexpected(p, "a number, a name or (");
    return NULL;
}

static struct pm_node *signed_primary(struct parser *p)
{
    struct place place = here(p);
    bool minus = peek(p) == '-';
    if ((minus || peek(p) == '+') && next(p))
        return NULL;
    struct pm_node *node = primary(p);
    if (!node || !minus)
        return node;
    if (is_number(node))
        return new_number(p, place, -node->number);
    if (node->kind == PM_NODE_NEGATE)
        return node->first;
    struct pm_node *negative = new_node(p, PM_NODE_NEGATE, place);
    if (negative)
        negative->first = node;
    return negative;
}

static struct pm_node *power(struct parser *p, struct pm_node *base, struct pm_node *exponent,
                             struct place place)
{
    struct pm_node *node = new_node(p, PM_NODE_POWER, place);
    if (!node)
        return NULL;
    node->first = base;
    base->next = exponent;
    if (is_number(base) && is_number(exponent))
        return fold(p, node);
    base->next = NULL;
    if (is_value(base, 0))
        return base;
    if (is_value(exponent, 0) || is_value(base, 1))
        return new_number(p, place, 1);
    if (is_value(exponent, 1))
        return base;
    base->next = exponent;
    return node;
}

static struct pm_node *factor(struct parser *p)
{
    if (!descend(p))
        return NULL;
    struct pm_node *base = signed_primary(p);
    if (base && peek(p) == '^') {
        struct place place = here(p);
        struct pm_node *exponent = next(p) ? NULL : factor(p);
        base = exponent ? power(p, base, exponent, place) : NULL;
    }
    p->depth--;
    return base;
}

static pm_status parameters(struct parser *p, struct pm_definition *definition)
{
    char name[PM_LANGUAGE_NAME + 1];
    const char *names[PM_LANGUAGE_PARAMETERS];
    uint32_t count = 0;
    do {
        pm_status st = next(p);
        if (st)
            return st;
        if (count == PM_LANGUAGE_PARAMETERS)
            return FAIL(p, here(p), PM_E_LIMIT, "a function has at most %d arguments",
                        PM_LANGUAGE_PARAMETERS);
        struct place place = here(p);
        if (!is_letter(peek(p)))
            return unexpected(p, "the name of an argument");
        if ((st = get_name(p, name)))
            return st;
        if (strchr(name, '`'))
            return FAIL(p, place, PM_E_SYNTAX, "the name of an argument has no context");
        names[count] = pm_arena_text(&p->language->arena, name, strlen(name));
        if (!names[count++])
            return no_memory(p);
    } while (peek(p) == ',');
    if (peek(p) != ')')
        return unexpected(p, "a comma or the ) of the arguments");
    definition->parameters = pm_arena_array(&p->language->arena, count, sizeof *names);
    definition->occurrences = pm_arena_array(&p->language->arena, count, sizeof(uint32_t));
    if (!definition->parameters || !definition->occurrences)
        return no_memory(p);
    memcpy(definition->parameters, names, count * sizeof *names);
    definition->parameter_count = count;
    return next(p);
}

static pm_status definition(struct parser *p)
{
    char name[PM_LANGUAGE_NAME + 1];
    struct place place = here(p);
    if (peek(p) == '$')
        return FAIL(p, place, PM_E_UNSUPPORTED, "there are no output channels here");
    if (!is_letter(peek(p)) && peek(p) != '`')
        return unexpected(p, "the name of a variable or function");
    pm_status st = get_name(p, name);
    if (st)
        return st;
    struct pm_definition *made = pm_arena_alloc(&p->language->arena, sizeof *made);
    char *text = pm_arena_text(&p->language->arena, name, strlen(name));
    if (!made || !text)
        return no_memory(p);
    made->text = text;
    made->source = p->source;
    made->line = place.line;
    made->column = place.column;
    if (peek(p) == '(') {
        if ((st = parameters(p, made)))
            return st;
        p->function = made;
    }
    if (peek(p) != '=' && peek(p) != ':')
        return unexpected(p, made->parameter_count ? "= or :" : "=, : or (");
    made->constant = peek(p) == ':';
    if ((st = next(p)))
        return st;
    made->body = expression(p);
    p->function = NULL;
    if (!made->body)
        return p->err && p->err->status ? p->err->status : PM_E_SYNTAX;
    struct pm_name *defined = pm_name_define(p->language, p->mark, name);
    if (!defined)
        return no_memory(p);
    defined->definition = made;
    return PM_OK;
}

static pm_status start(struct parser *p, pm_language *language, uint32_t context,
                       uint32_t source, int line, int column, const char *text, size_t size,
                       pm_error *err)
{
    *p = (struct parser){.language = language,
                         .mark = language->contexts[context].mark,
                         .text = text,
                         .size = size,
                         .line = line > 0 ? line : 1,
                         .column = column > 0 ? column : 1,
                         .source = source,
                         .err = err};
    if (size > PM_LANGUAGE_TEXT_MAX - language->text_bytes)
        return FAIL(p, here(p), PM_E_LIMIT, "the function files have more than %d bytes",
                    PM_LANGUAGE_TEXT_MAX);
    language->text_bytes += size;
    return skip(p);
}

pm_status pm_parse_definitions(pm_language *language, uint32_t context, uint32_t source,
                               int line, int column, const char *text, size_t size,
                               pm_error *err)
{
    struct parser p;
    pm_error own = PM_ERROR_INIT;
    pm_status st =
        start(&p, language, context, source, line, column, text, size, err ? err : &own);
    while (!st && peek(&p) >= 0) {
        if (peek(&p) != ';')
            st = definition(&p);
        if (!st && peek(&p) >= 0)
            st = peek(&p) == ';' ? next(&p) : unexpected(&p, "an operator or ;");
    }
    return st;
}

pm_status pm_parse_expression(pm_language *language, uint32_t context, uint32_t source,
                              int line, int column, const char *text, size_t size,
                              struct pm_node **out, pm_error *err)
{
    struct parser p;
    pm_error own = PM_ERROR_INIT;
    pm_status st =
        start(&p, language, context, source, line, column, text, size, err ? err : &own);
    if (st)
        return st;
    struct pm_node *node = expression(&p);
    if (!node)
        return p.err->status;
    if (peek(&p) >= 0)
        return unexpected(&p, "an operator or the end of the expression");
    *out = node;
    return PM_OK;
}
