#include "scene/xform_list.h"

#include <stdio.h>
#include <string.h>

struct list {
    const pm_command *command;
    const pm_xform *xform;
    pm_arena *arena;
    pm_error *err;
    const char *at, *end;
    int line; /* of the list, from 1 */
    pm_word *words;
    size_t count, most;
};

static pm_status memory_error(const struct list *l)
{
    return pm_error_set(l->err, PM_E_MEMORY, "not enough memory for a command of the scene");
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

/* The end of the line that starts here; a backslash before the newline continues it. */
static const char *line_end(const char *start, const char *end)
{
    const char *at = start;
    while (at < end && (*at != '\n' || (at > start && at[-1] == '\\')))
        at++;
    return at;
}

/* A word with the place of the list's name: it stands there. */
static pm_status set_word(struct list *l, size_t index, const char *text, size_t length)
{
    pm_word *word = &l->words[index];
    *word = *l->xform->list;
    word->text = pm_arena_text(l->arena, text, length);
    word->length = length;
    return word->text ? PM_OK : memory_error(l);
}

/* Takes the next word of a line, quoted or not. *found is false at its end. */
static pm_status next_word(struct list *l, const char **at, const char *end, bool *found)
{
    while (*at < end && (is_space(**at) || **at == '\n' ||
                         (**at == '\\' && *at + 1 < end && (*at)[1] == '\n')))
        ++*at;
    *found = *at < end;
    if (!*found)
        return PM_OK;
    char quote = **at == '"' || **at == '\'' ? *(*at)++ : '\0';
    const char *start = *at;
    while (*at < end && (quote ? **at != quote : !is_space(**at) && **at != '\n'))
        ++*at;
    size_t length = (size_t)(*at - start);
    *at += quote && *at < end;
    return set_word(l, l->count++, start, length);
}

static pm_status add_line(struct list *l, const char *at, const char *end)
{
    static const char program[] = "xform ";
    bool found = true;
    pm_status st = PM_OK;
    at += at < end && *at == '!';
    if ((size_t)(end - at) >= sizeof program - 1 && !memcmp(at, program, sizeof program - 1))
        at += sizeof program - 1;
    while (!st && found)
        st = next_word(l, &at, end, &found);
    return st;
}

/* Numbers the name of the first -n, or begins with one of its own. */
static pm_status name_copy(struct list *l, size_t copy)
{
    char number[32];
    for (size_t i = 1; i + 1 < l->count; i++) {
        pm_word *name = &l->words[i + 1];
        if (!pm_word_is(&l->words[i], "-n"))
            continue;
        char *text = pm_arena_alloc(l->arena, name->length + sizeof number);
        if (!text)
            return memory_error(l);
        name->length =
            (size_t)snprintf(text, name->length + sizeof number, "%s.%zu", name->text, copy);
        name->text = text;
        return PM_OK;
    }
    memmove(l->words + 3, l->words + 1, (l->count - 1) * sizeof *l->words);
    l->count += 2;
    snprintf(number, sizeof number, "i%zu", copy);
    pm_status st = set_word(l, 1, "-n", 2);
    return st ? st : set_word(l, 2, number, strlen(number));
}

static pm_status parse_copy(struct list *l, size_t copy, const char *at, const char *end,
                            pm_xform *out)
{
    const pm_command *c = l->command;
    size_t before = l->xform->list_at, after = before + 2;
    pm_error why = PM_ERROR_INIT;
    memcpy(l->words, c->words, before * sizeof *l->words);
    l->count = before;
    pm_status st = add_line(l, at, end);
    if (st)
        return st;
    memcpy(l->words + l->count, c->words + after, (c->count - after) * sizeof *l->words);
    l->count += c->count - after;
    st = name_copy(l, copy);
    if (st)
        return st;
    pm_word *words = pm_arena_array(l->arena, l->count, sizeof *words);
    if (!words)
        return memory_error(l);
    memcpy(words, l->words, l->count * sizeof *words);
    const pm_command command = {c->file, words, l->count};
    st = pm_xform_parse(&command, l->arena, out, &why);
    if (!st && out->list)
        st = pm_error_set(&why, PM_E_UNSUPPORTED, "-f cannot stand twice in one xform");
    return st ? pm_word_error(l->xform->list, st, c->file, l->err, "line %d of '%.*s': %s",
                              l->line, PM_WORD_SHOW(*l->xform->list), why.text)
              : PM_OK;
}

static bool counts(const char *at, const char *end)
{
    return at < end && *at != '#' && *at != '\n' && *at != '\r';
}

/* Copies, and room for the words of any. */
static size_t count_copies(struct list *l)
{
    size_t copies = 0, longest = 0;
    for (const char *at = l->at, *end; at < l->end; at = end + 1) {
        end = line_end(at, l->end);
        copies += counts(at, end);
        longest = (size_t)(end - at) > longest ? (size_t)(end - at) : longest;
    }
    l->most = l->command->count + longest / 2 + 4;
    return copies;
}

static pm_status parse_copies(struct list *l, pm_xform *copies)
{
    pm_status st = PM_OK;
    size_t copy = 0;
    l->line = 1;
    for (const char *at = l->at, *end; !st && at < l->end; at = end + 1) {
        end = line_end(at, l->end);
        if (counts(at, end)) {
            st = parse_copy(l, copy, at, end, &copies[copy]);
            copy++;
        }
        for (const char *c = at; c <= end && c < l->end; c++)
            l->line += *c == '\n';
    }
    return st;
}

pm_status pm_xform_list_parse(const pm_command *command, const pm_xform *xform,
                              const void *text, size_t size, pm_arena *arena,
                              const pm_xform **out, size_t *count, pm_error *err)
{
    struct list l = {.command = command, .xform = xform, .arena = arena, .err = err};
    l.at = text;
    l.end = l.at + size;
    size_t copies = count_copies(&l);
    size_t words = copies * (command->count + 2); /* copied for each */
    if (!copies || copies > PM_XFORM_LIST_MOST || words / 16 > PM_XFORM_LIST_MOST)
        return pm_word_error(xform->list, copies ? PM_E_LIMIT : PM_E_SYNTAX, command->file, err,
                             "'%.*s' holds %zu lists of arguments; xform's -f takes 1 to %d",
                             PM_WORD_SHOW(*xform->list), copies, PM_XFORM_LIST_MOST);
    l.words = pm_arena_array(arena, l.most, sizeof *l.words);
    pm_xform *list = pm_arena_array(arena, copies, sizeof *list);
    if (!l.words || !list)
        return memory_error(&l);
    pm_status st = parse_copies(&l, list);
    if (st)
        return st;
    *out = list;
    *count = copies;
    return PM_OK;
}
