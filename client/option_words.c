#include "option_words.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- numbers with suffixes ---- */

static bool read_number(const char *text, double *out, const char **end)
{
    char *stop;
    if (!strchr("0123456789+-.", *text) || !*text)
        return false;
    double value = strtod(text, &stop);
    if (stop == text || !isfinite(value))
        return false;
    *out = value;
    *end = stop;
    return true;
}

pm_status pm_count_parse(const char *text, uint64_t *out)
{
    static const char suffixes[] = "kmg";
    double value, factor = 1;
    const char *end;
    if (!read_number(text, &value, &end) || value < 0)
        return PM_E_RANGE;
    const char *suffix = *end ? strchr(suffixes, *end | 0x20) : NULL;
    if (*end && (!suffix || end[1]))
        return PM_E_RANGE;
    for (const char *s = suffixes; suffix && s <= suffix; s++)
        factor *= 1000;
    value *= factor;
    if (value != floor(value) || value > 0x1p53)
        return PM_E_RANGE;
    *out = (uint64_t)value;
    return PM_OK;
}

pm_status pm_seconds_parse(const char *text, double *out)
{
    double value;
    const char *end;
    if (!read_number(text, &value, &end) || !(value > 0) || (*end && end[1]))
        return PM_E_RANGE;
    if (*end && !strchr("smh", *end))
        return PM_E_RANGE;
    *out = value * (*end == 'm' ? 60 : *end == 'h' ? 3600 : 1);
    return PM_OK;
}

pm_status pm_share_parse(const char *text, double *out)
{
    double value;
    const char *end;
    if (!read_number(text, &value, &end))
        return PM_E_RANGE;
    if (!strcmp(end, "%"))
        value /= 100;
    else if (*end)
        return PM_E_RANGE;
    if (!(value > 0) || value > 1)
        return PM_E_RANGE;
    *out = value;
    return PM_OK;
}

/* ---- arguments ---- */

pm_status pm_word_bad(const struct pm_words *words, const char *got, const char *right)
{
    return pm_error_set(words->err, PM_E_RANGE, "%s %s: must be %s", words->option, got, right);
}

/* Without a tail it becomes the other. */
void pm_word_toggle(const struct pm_words *words, bool *out)
{
    const char *tail = words->option + strlen(words->entry->name);
    *out = *tail ? strchr(PM_SWITCH_TAILS, *tail) < strchr(PM_SWITCH_TAILS, '-') : !*out;
}

pm_status pm_word_text(struct pm_words *words, const char *what, const char **out)
{
    if (!words->value && words->at >= words->argc)
        return pm_error_set(words->err, PM_E_MISSING, "%s: %s is missing behind it",
                            words->option, what);
    *out = words->value ? words->value : words->argv[words->at++];
    words->value = NULL;
    return PM_OK;
}

pm_status pm_word_count(struct pm_words *words, const char *what, uint64_t low, uint64_t high,
                        uint64_t *out)
{
    const char *text = NULL;
    pm_status st = pm_word_text(words, what, &text);
    if (st)
        return st;
    if (!pm_count_parse(text, out) && *out >= low && *out <= high)
        return PM_OK;
    char right[160];
    snprintf(right, sizeof right,
             "%s, a whole number from %llu to %llu (10k, 1m are understood)", what,
             (unsigned long long)low, (unsigned long long)high);
    return pm_word_bad(words, text, right);
}

pm_status pm_word_u32(struct pm_words *words, const char *what, uint32_t low, uint32_t high,
                      uint32_t *out)
{
    uint64_t value = 0;
    pm_status st = pm_word_count(words, what, low, high, &value);
    if (!st)
        *out = (uint32_t)value;
    return st;
}

pm_status pm_word_number(struct pm_words *words, const char *what, double *out)
{
    const char *text = NULL, *end;
    pm_status st = pm_word_text(words, what, &text);
    if (st)
        return st;
    return read_number(text, out, &end) && !*end ? PM_OK : pm_word_bad(words, text, what);
}

pm_status pm_word_numbers(struct pm_words *words, const char *what, size_t count, double *out)
{
    pm_status st = PM_OK;
    for (size_t i = 0; i < count && !st; i++)
        st = pm_word_number(words, what, &out[i]);
    return st;
}

bool pm_word_is_count(const struct pm_words *words)
{
    uint64_t count;
    return words->at < words->argc && !pm_count_parse(words->argv[words->at], &count);
}
