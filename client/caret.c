#include "caret.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum {
    BEFORE = 60, /* bytes shown before the column of a long line */
    SHOWN = 100, /* bytes in all */
};

/* The line's text without its newline; NULL if the file has no such line. */
static const char *find_line(const pm_file *file, int line, size_t *length)
{
    const char *at = (const char *)file->data, *end = at + file->size;
    for (int i = 1; at && i < line; i++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        at = newline ? newline + 1 : NULL;
    }
    if (!at || at >= end)
        return NULL;
    const char *newline = memchr(at, '\n', (size_t)(end - at));
    *length = (size_t)((newline ? newline : end) - at);
    return at;
}

static bool continues_a_character(char c)
{
    return ((unsigned char)c & 0xC0) == 0x80;
}

/* A terminal must not be steered by somebody's file. */
static char harmless(char c)
{
    return (unsigned char)c < ' ' || c == 0x7F ? ' ' : c;
}

void pm_caret_append(pm_error *err, const pm_file *file, int line, int column)
{
    char shown[SHOWN + 1], caret[SHOWN + 2];
    size_t length, count = 0, width = 0;
    const char *text = file && line > 0 && column > 0 ? find_line(file, line, &length) : NULL;
    if (!text || (size_t)column > length + 1)
        return;
    size_t at = (size_t)column - 1, start = at > BEFORE ? at - BEFORE : 0;
    while (start > 0 && start < at && continues_a_character(text[start]))
        start++;
    for (size_t i = start; i < length && count < SHOWN; i++) {
        if (i < at && !continues_a_character(text[i]))
            caret[width++] = ' ';
        shown[count++] = harmless(text[i]);
    }
    shown[count] = caret[width] = '\0';
    size_t used = strlen(err->text);
    if (used + count + width + sizeof "\n    \n    ^" > sizeof err->text)
        return;
    snprintf(err->text + used, sizeof err->text - used, "\n    %s\n    %s^", shown, caret);
}
