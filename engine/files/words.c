#include "files/words.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"

enum { SHOWN = 40 }; /* bytes of a word in a message */

static bool is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

pm_status pm_words_init(pm_words *words, const void *bytes, size_t size, const char *name,
                        pm_error *err)
{
    if (size >= INT_MAX)
        return pm_error_set_at(err, PM_E_LIMIT, name, 0, 0,
                               "the file has %zu bytes; a text file may have 2 GiB", size);
    const char *text = bytes;
    *words = (pm_words){text, text + size, text, 1, name};
    return PM_OK;
}

static void pass_line(pm_words *words)
{
    while (words->at < words->end && *words->at != '\n')
        words->at++;
}

bool pm_words_more(pm_words *words)
{
    while (words->at < words->end) {
        if (*words->at == '#') {
            pass_line(words);
            continue;
        }
        if (!is_space(*words->at))
            return true;
        if (*words->at++ == '\n') {
            words->line++;
            words->line_start = words->at;
        }
    }
    return false;
}

pm_status pm_words_error(const pm_words *words, pm_status status, pm_error *err,
                         const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return pm_error_set_at(err, status, words->file, words->line,
                           (int)(words->at - words->line_start) + 1, "%s", text);
}

static size_t word_length(const pm_words *words)
{
    const char *at = words->at;
    while (at < words->end && !is_space(*at) && *at != '#')
        at++;
    return (size_t)(at - words->at);
}

static int shown(size_t length)
{
    return length < SHOWN ? (int)length : SHOWN;
}

bool pm_words_take(pm_words *words, const char *word)
{
    if (!pm_words_more(words) || word_length(words) != strlen(word) ||
        memcmp(words->at, word, strlen(word)) != 0)
        return false;
    words->at += strlen(word);
    return true;
}

pm_status pm_words_real(pm_words *words, const char *what, double *out, pm_error *err)
{
    if (!pm_words_more(words))
        return pm_words_error(words, PM_E_SYNTAX, err, "the file ends before %s", what);
    size_t length = word_length(words);
    switch (pm_number_real(words->at, length, out)) {
    case PM_NUMBER_MALFORMED:
        return pm_words_error(words, PM_E_SYNTAX, err, "%s must be a number, not '%.*s'", what,
                              shown(length), words->at);
    case PM_NUMBER_HUGE:
        return pm_words_error(words, PM_E_RANGE, err, "%s is larger than a number can be",
                              what);
    default:
        words->at += length;
        return PM_OK;
    }
}

pm_status pm_words_integer(pm_words *words, const char *what, int64_t least, int64_t most,
                           int64_t *out, pm_error *err)
{
    if (!pm_words_more(words))
        return pm_words_error(words, PM_E_SYNTAX, err, "the file ends before %s", what);
    int64_t value = 0;
    size_t length = word_length(words);
    if (pm_number_integer(words->at, length, &value) || value < least || value > most)
        return pm_words_error(words, PM_E_RANGE, err,
                              "%s must be a whole number from %lld to %lld, not '%.*s'", what,
                              (long long)least, (long long)most, shown(length), words->at);
    words->at += length;
    *out = value;
    return PM_OK;
}

size_t pm_words_left(const pm_words *words)
{
    return (size_t)(words->end - words->at);
}
