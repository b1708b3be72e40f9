#include "range.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Digits alone: strtoull would take signs and blanks. False if there are none. */
static bool read_number(const char **at, uint64_t *out)
{
    const char *start = *at;
    uint64_t value = 0;
    for (; isdigit((unsigned char)**at); (*at)++) {
        unsigned digit = (unsigned)(**at - '0');
        value = value > (UINT64_MAX - digit) / 10 ? UINT64_MAX : 10 * value + digit;
    }
    *out = value;
    return *at != start;
}

pm_range pm_range_parse(const char *header, uint64_t size, uint64_t *first, uint64_t *length)
{
    *first = 0;
    *length = size;
    if (!header || strncasecmp(header, "bytes=", 6) != 0)
        return PM_RANGE_ALL;
    const char *at = header + 6;
    uint64_t low = 0, high = UINT64_MAX;
    bool has_low = read_number(&at, &low);
    if (*at++ != '-')
        return PM_RANGE_ALL;
    bool has_high = read_number(&at, &high);
    if (!has_high)
        high = UINT64_MAX;
    if (*at || (!has_low && !has_high) || (has_low && high < low))
        return PM_RANGE_ALL;
    if (!has_low) { /* the last `high` bytes */
        low = high < size ? size - high : 0;
        high = high ? UINT64_MAX : 0;
        if (!high)
            return PM_RANGE_NOWHERE;
    }
    if (low >= size)
        return PM_RANGE_NOWHERE;
    *first = low;
    *length = (high < size ? high + 1 : size) - low;
    return PM_RANGE_PART;
}

bool pm_tag_listed(const char *header, const char *tag)
{
    if (!header)
        return false;
    if (!strcmp(header, "*"))
        return true;
    size_t length = strlen(tag);
    for (const char *at = header; (at = strstr(at, tag)); at++) {
        const char *before = at, *after = at + length;
        if (before - header >= 2 && !strncmp(before - 2, "W/", 2))
            before -= 2;
        while (before > header && (before[-1] == ' ' || before[-1] == '\t'))
            before--;
        while (*after == ' ' || *after == '\t')
            after++;
        if ((before == header || before[-1] == ',') && (!*after || *after == ','))
            return true;
    }
    return false;
}
