#include "scene/command.h"

#include <string.h>

/* Rules of the POSIX shell (2.2 Quoting), as far as they need no execution. */

struct splitter {
    pm_lexer *lexer;
    pm_error *err;
    char *text; /* where the next character of the current word goes */
};

static bool at_end(const pm_lexer *lexer)
{
    return lexer->at == lexer->end || *lexer->at == '\n';
}

/* Takes the escaped character, or passes an escaped newline. False if it was a newline. */
static bool take_newline(pm_lexer *lexer)
{
    const char *at = lexer->at;
    if (lexer->end - at >= 2 && at[0] == '\r' && at[1] == '\n')
        at++;
    if (at == lexer->end || *at != '\n')
        return false;
    lexer->at = at + 1;
    lexer->line++;
    lexer->line_start = lexer->at;
    return true;
}

static pm_word place(const pm_lexer *lexer)
{
    return (pm_word){.line = lexer->line, .column = (int)(lexer->at - lexer->line_start) + 1};
}

static pm_status refuse(const struct splitter *s, char c)
{
    pm_word here = place(s->lexer);
    return pm_word_error(
        &here, PM_E_UNSUPPORTED, s->lexer->file, s->err,
        "'%c' would need a shell, and commands are not run here; expand the line "
        "beforehand with Radiance's own programs, or quote the character",
        c);
}

static pm_status quoted(struct splitter *s)
{
    pm_lexer *lexer = s->lexer;
    pm_word start = place(lexer);
    char quote = *lexer->at++;
    while (!at_end(lexer) && *lexer->at != quote) {
        char c = *lexer->at;
        if (quote == '"' && (c == '$' || c == '`'))
            return refuse(s, c);
        if (quote == '"' && c == '\\' && lexer->end - lexer->at >= 2 &&
            strchr("$`\"\\", lexer->at[1]))
            c = *++lexer->at;
        *s->text++ = c;
        lexer->at++;
    }
    if (at_end(lexer))
        return pm_word_error(&start, PM_E_SYNTAX, lexer->file, s->err,
                             "the quote %c opened here is not closed on its line; "
                             "close it with another %c",
                             quote, quote);
    lexer->at++;
    return PM_OK;
}

/* Reads one word, which starts at the current character. */
static pm_status split_word(struct splitter *s)
{
    pm_lexer *lexer = s->lexer;
    pm_status st = PM_OK;
    if (*lexer->at == '~')
        return refuse(s, '~');
    while (!st && !at_end(lexer) && !strchr(" \t\r", *lexer->at)) {
        char c = *lexer->at;
        if (strchr(";|$`<>&*?[]()", c)) {
            st = refuse(s, c);
        } else if (c == '"' || c == '\'') {
            st = quoted(s);
        } else if (c == '\\') {
            lexer->at++;
            if (!take_newline(lexer) && !at_end(lexer))
                *s->text++ = *lexer->at++;
        } else {
            *s->text++ = c;
            lexer->at++;
        }
    }
    return st;
}

/* Passes blanks and continued newlines. False at the end of the command. */
static bool next_word(pm_lexer *lexer)
{
    for (;;) {
        while (!at_end(lexer) && strchr(" \t\r", *lexer->at))
            lexer->at++;
        if (at_end(lexer) || *lexer->at == '#') {
            pm_lexer_skip_line(lexer);
            return false;
        }
        if (*lexer->at != '\\')
            return true;
        lexer->at++;
        if (!take_newline(lexer)) {
            lexer->at--;
            return true;
        }
    }
}

/* An upper bound of the command's length, so that its words can be laid out before it is read.
 */
static size_t command_length(const pm_lexer *lexer)
{
    const char *at = lexer->at;
    while (at < lexer->end &&
           (*at != '\n' || at[-1] == '\\' || (at[-1] == '\r' && at[-2] == '\\')))
        at++;
    return (size_t)(at - lexer->at);
}

pm_status pm_command_read(pm_lexer *lexer, pm_arena *arena, pm_command *out, pm_error *err)
{
    pm_word start = place(lexer);
    size_t length = command_length(lexer);
    if (memchr(lexer->at, '\0', length))
        return pm_word_error(&start, PM_E_SYNTAX, lexer->file, err,
                             "the command holds a byte 0x00; a scene file is plain text");
    /* Words are apart by at least one character, which makes room for their terminators. */
    char *text = pm_arena_alloc(arena, length + 1);
    pm_word *words = pm_arena_array(arena, length / 2 + 1, sizeof *words);
    if (!text || !words)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a command of the scene");
    struct splitter s = {.lexer = lexer, .err = err, .text = text};
    size_t count = 0;
    while (next_word(lexer)) {
        pm_word *word = &words[count++];
        *word = place(lexer);
        word->text = s.text;
        pm_status st = split_word(&s);
        if (st)
            return st;
        word->length = (size_t)(s.text - word->text);
        *s.text++ = '\0';
    }
    if (!count)
        return pm_word_error(
            &start, PM_E_SYNTAX, lexer->file, err,
            "'!' starts a command, and none follows; write !xform ... or delete "
            "the line");
    *out = (pm_command){.file = lexer->file, .words = words, .count = count};
    return PM_OK;
}
