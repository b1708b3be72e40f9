#include "scene/command.h"

#include <string.h>

#include "generate/generate.h"

/* Rules of the POSIX shell (2.2 Quoting), as far as they need no execution. */

struct splitter {
    pm_lexer *lexer;
    pm_error *err;
    char *text; /* where the next character of the current word goes */
    /* Patterns of file names are plain characters, as they are to a shell that finds no file of
     * such a name: in a generator's expressions. */
    bool plain_patterns;
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
        "'%c' would need a shell, and nothing is executed here; expand the scene "
        "beforehand with Radiance's \"xform scene.rad > expanded.rad\", or quote the "
        "character",
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
    while (!st && !at_end(lexer) && !strchr(" \t\r|", *lexer->at)) {
        char c = *lexer->at;
        if (strchr(";$`<>&()", c) || (strchr("*?[]", c) && !s->plain_patterns)) {
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

/* No more words than this. */
static size_t word_limit(const char *text, size_t length)
{
    size_t count = 1;
    for (size_t i = 0; i < length; i++)
        count += strchr(" \t\r\n|", text[i]) != NULL;
    return count;
}

/* Takes a '|'. */
static pm_status take_pipe(struct splitter *s, bool empty)
{
    pm_lexer *lexer = s->lexer;
    pm_word here = place(lexer);
    lexer->at++;
    if (!at_end(lexer) && (*lexer->at == '|' || *lexer->at == '&'))
        return refuse(s, *lexer->at);
    if (empty)
        return pm_word_error(&here, PM_E_SYNTAX, lexer->file, s->err,
                             "no command stands before this '|'; write one, or delete it");
    return PM_OK;
}

/* Reads the words of all stages. The last word of each stage but the last has a '|' behind it.
 */
static pm_status read_words(struct splitter *s, pm_word *words, bool *piped, size_t *count)
{
    bool empty = true;
    pm_word pipe = {0};
    const pm_word *program = NULL;
    while (next_word(s->lexer)) {
        pm_status st;
        if (*s->lexer->at == '|') {
            pipe = place(s->lexer);
            st = take_pipe(s, empty);
            if (!st)
                piped[*count - 1] = empty = true;
        } else {
            pm_word *word = &words[(*count)++];
            *word = place(s->lexer);
            word->text = s->text;
            program = empty ? word : program;
            s->plain_patterns = !empty && pm_generate_knows(program->text);
            st = split_word(s);
            word->length = (size_t)(s->text - word->text);
            *s->text++ = '\0';
            empty = false;
        }
        if (st)
            return st;
    }
    if (empty && *count)
        return pm_word_error(&pipe, PM_E_SYNTAX, s->lexer->file, s->err,
                             "no command stands behind this '|'; write one, or delete it");
    return PM_OK;
}

static pm_commands split_stages(const pm_lexer *lexer, const pm_word *words, const bool *piped,
                                size_t count, pm_command *stages)
{
    pm_commands result = {.stages = stages};
    size_t start = 0;
    for (size_t i = 0; i < count; i++) {
        if (!piped[i] && i + 1 < count)
            continue;
        stages[result.count++] = (pm_command){lexer->file, words + start, i + 1 - start};
        start = i + 1;
    }
    return result;
}

pm_status pm_commands_read(pm_lexer *lexer, pm_arena *arena, pm_commands *out, pm_error *err)
{
    pm_word start = place(lexer);
    size_t length = command_length(lexer), most = word_limit(lexer->at, length), count = 0;
    if (memchr(lexer->at, '\0', length))
        return pm_word_error(&start, PM_E_SYNTAX, lexer->file, err,
                             "the command holds a byte 0x00; a scene file is plain text");
    /* A '|' can part words without a blank, so their terminators need room of their own. */
    char *text = pm_arena_alloc(arena, length + most);
    pm_word *words = pm_arena_array(arena, most, sizeof *words);
    bool *piped = pm_arena_array(arena, most, sizeof *piped);
    if (!text || !words || !piped)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a command of the scene");
    struct splitter s = {.lexer = lexer, .err = err, .text = text};
    pm_status st = read_words(&s, words, piped, &count);
    if (st)
        return st;
    if (!count)
        return pm_word_error(
            &start, PM_E_SYNTAX, lexer->file, err,
            "'!' starts a command, and none follows; write !xform ... or delete "
            "the line");
    pm_command *stages = pm_arena_array(arena, count, sizeof *stages);
    if (!stages)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a command of the scene");
    *out = split_stages(lexer, words, piped, count, stages);
    return PM_OK;
}
