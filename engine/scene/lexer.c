#include "scene/lexer.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static bool is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static bool is_control(char c)
{
    return (unsigned char)c < ' ' || c == 0x7F;
}

pm_status pm_lexer_init(pm_lexer *lexer, const pm_file *file, pm_error *err)
{
    if (file->size >= INT_MAX)
        return pm_error_set_at(
            err, PM_E_LIMIT, file->name, 0, 0,
            "the file has %zu bytes; a scene file must be smaller than 2 GiB: "
            "split it and join the parts with !xform lines",
            file->size);
    const char *text = (const char *)file->data;
    *lexer = (pm_lexer){.at = text, .end = text + file->size, .line_start = text, .line = 1};
    lexer->file = file->name;
    if (file->size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0) /* byte order mark */
        lexer->at = lexer->line_start = text + 3;
    return PM_OK;
}

int pm_lexer_peek(pm_lexer *lexer)
{
    const char *at = lexer->at;
    while (at < lexer->end && is_space(*at)) {
        if (*at++ == '\n') {
            lexer->line++;
            lexer->line_start = at;
        }
    }
    lexer->at = at;
    return at < lexer->end ? (unsigned char)*at : -1;
}

void pm_lexer_skip_line(pm_lexer *lexer)
{
    size_t left = (size_t)(lexer->end - lexer->at);
    const char *newline = left ? memchr(lexer->at, '\n', left) : NULL;
    lexer->at = newline ? newline : lexer->end;
}

static pm_status control_error(const pm_lexer *lexer, const char *at, pm_error *err)
{
    return pm_error_set_at(
        err, PM_E_SYNTAX, lexer->file, lexer->line, (int)(at - lexer->line_start) + 1,
        "byte 0x%02X is not text; a scene file is plain text", (unsigned)(unsigned char)*at);
}

static pm_status quoted_word(pm_lexer *lexer, pm_word *word, pm_error *err)
{
    char quote = *lexer->at;
    const char *start = lexer->at + 1;
    const char *at = start;
    while (at < lexer->end && *at != quote && *at != '\n') {
        if (is_control(*at) && !is_space(*at))
            return control_error(lexer, at, err);
        at++;
    }
    if (at == lexer->end || *at != quote)
        return pm_word_error(word, PM_E_SYNTAX, lexer->file, err,
                             "the quote %c opened here is not closed on its line; "
                             "close it with another %c",
                             quote, quote);
    word->text = start;
    word->length = (size_t)(at - start);
    lexer->at = at + 1;
    return PM_OK;
}

pm_status pm_lexer_word(pm_lexer *lexer, pm_word *word, pm_error *err)
{
    int first = pm_lexer_peek(lexer);
    const char *at = lexer->at;
    *word = (pm_word){.line = lexer->line, .column = (int)(at - lexer->line_start) + 1};
    if (first < 0)
        return PM_OK;
    if (first == '"' || first == '\'')
        return quoted_word(lexer, word, err);
    word->text = at;
    while (at < lexer->end && !is_space(*at)) {
        if (is_control(*at))
            return control_error(lexer, at, err);
        at++;
    }
    word->length = (size_t)(at - word->text);
    lexer->at = at;
    return PM_OK;
}

pm_status pm_word_error(const pm_word *word, pm_status status, const char *file, pm_error *err,
                        const char *format, ...)
{
    char text[sizeof err->text];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return pm_error_set_at(err, status, file, word->line, word->column, "%s", text);
}

bool pm_word_is(const pm_word *word, const char *text)
{
    if (!word->text)
        return false;
    for (size_t i = 0; i < word->length; i++)
        if (text[i] != word->text[i] || !text[i])
            return false;
    return !text[word->length];
}
