#include "scene/statement.h"

#include <string.h>

pm_status pm_statement_word(pm_lexer *lexer, const char *what, pm_word *out, pm_error *err)
{
    pm_status st = pm_lexer_word(lexer, out, err);
    if (st || out->text)
        return st;
    return pm_word_error(out, PM_E_SYNTAX, lexer->file, err,
                         "the file ends inside a primitive; %s should come here", what);
}

/* Radiance refuses tabs in names (src/common/readobj.c). */
static pm_status read_name(pm_lexer *lexer, const char *what, pm_word *out, pm_error *err)
{
    pm_status st = pm_statement_word(lexer, what, out, err);
    if (!st && memchr(out->text, '\t', out->length))
        return pm_word_error(out, PM_E_SYNTAX, lexer->file, err,
                             "%s must not contain a tab; use a blank", what);
    return st;
}

pm_status pm_statement_next(pm_lexer *lexer, pm_statement *out, pm_error *err)
{
    int c;
    while ((c = pm_lexer_peek(lexer)) == '#')
        pm_lexer_skip_line(lexer);
    out->kind = c < 0 ? PM_STATEMENT_END : PM_STATEMENT_COMMAND;
    if (c < 0)
        return PM_OK;
    if (c == '!') {
        lexer->at++;
        return PM_OK;
    }
    pm_status st = read_name(lexer, "a modifier", &out->modifier, err);
    if (!st)
        st = pm_statement_word(lexer, "a primitive type", &out->type, err);
    if (!st)
        st = read_name(lexer, "a name", &out->name, err);
    if (st)
        return st;
    bool alias = pm_word_is(&out->type, "alias");
    out->kind = alias ? PM_STATEMENT_ALIAS : PM_STATEMENT_PRIMITIVE;
    return alias ? read_name(lexer, "the old name", &out->target, err) : PM_OK;
}

pm_status pm_statement_count(pm_lexer *lexer, const char *what, pm_word *word, size_t *out,
                             pm_error *err)
{
    int64_t count;
    pm_status st = pm_lexer_word(lexer, word, err);
    if (!st && !word->text)
        st = pm_word_error(
            word, PM_E_SYNTAX, lexer->file, err,
            "the file ends inside a primitive; the number of %s should come here", what);
    if (st)
        return st;
    pm_number number = pm_word_integer(word, &count);
    if (number == PM_NUMBER_MALFORMED || (number == PM_NUMBER_OK && count < 0))
        return pm_word_error(
            word, PM_E_SYNTAX, lexer->file, err,
            "'%.*s' is no count; the number of %s should come here, 0 if there "
            "are none",
            PM_WORD_SHOW(*word), what);
    if (number == PM_NUMBER_HUGE)
        return pm_word_error(word, PM_E_LIMIT, lexer->file, err,
                             "'%.*s' is too large for the number of %s", PM_WORD_SHOW(*word),
                             what);
    *out = (size_t)count;
    return PM_OK;
}

static bool skip_group(pm_lexer *lexer, size_t *count)
{
    pm_word word;
    if (pm_statement_count(lexer, "arguments", &word, count, NULL))
        return false;
    for (size_t i = 0; i < *count; i++)
        if (pm_lexer_word(lexer, &word, NULL) || !word.text)
            return false;
    return true;
}

bool pm_statement_skip_arguments(pm_lexer *lexer, size_t *reals)
{
    size_t others;
    return skip_group(lexer, &others) && skip_group(lexer, &others) && skip_group(lexer, reals);
}
