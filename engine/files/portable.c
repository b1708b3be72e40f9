#include "files/portable.h"

#include <math.h>
#include <string.h>

#include "base/number.h"

int64_t pm_portable_integer(pm_reader *reader, unsigned size)
{
    const uint8_t *at = pm_reader_take(reader, size);
    if (!at)
        return 0;
    uint64_t value = at[0] & 0x80 ? UINT64_MAX : 0;
    for (unsigned i = 0; i < size; i++)
        value = value << 8 | at[i];
    return (int64_t)value;
}

void pm_portable_put_integer(pm_bytes *bytes, int64_t value, unsigned size)
{
    while (size-- > 0)
        pm_bytes_u8(bytes, (uint8_t)((uint64_t)value >> (8 * size)));
}

#define MANTISSA 2147483647.0 /* 2^31 - 1 */

struct real {
    int64_t mantissa;
    int exponent;
};

static double decode(struct real r)
{
    if (r.mantissa == 0)
        return 0;
    double half = r.mantissa < 0 ? -.5 : .5;
    return ldexp(((double)r.mantissa + half) * (1 / MANTISSA), r.exponent);
}

static struct real encode(double value)
{
    struct real r;
    r.mantissa = (int64_t)(frexp(value, &r.exponent) * MANTISSA);
    if (r.exponent > 127)
        r = (struct real){r.mantissa > 0 ? 0x7fffffff : -0x7fffffff, 127};
    else if (r.exponent < -128)
        r = (struct real){0, 0};
    return r;
}

double pm_portable_real(pm_reader *reader)
{
    int64_t mantissa = pm_portable_integer(reader, 4);
    int64_t exponent = pm_portable_integer(reader, 1);
    return decode((struct real){mantissa, (int)exponent});
}

void pm_portable_put_real(pm_bytes *bytes, double value)
{
    struct real r = encode(value);
    pm_portable_put_integer(bytes, r.mantissa, 4);
    pm_portable_put_integer(bytes, r.exponent, 1);
}

double pm_portable_rounded(double value)
{
    return decode(encode(value));
}

const char *pm_portable_text(pm_reader *reader)
{
    size_t left = reader->size - reader->at;
    const uint8_t *start = reader->data + reader->at;
    const uint8_t *end = left && !reader->failed ? memchr(start, '\0', left) : NULL;
    if (!end) {
        reader->failed = true;
        return NULL;
    }
    reader->at += (size_t)(end - start) + 1;
    return (const char *)start;
}

void pm_portable_put_text(pm_bytes *bytes, const char *text)
{
    pm_bytes_append(bytes, text, strlen(text) + 1);
}

pm_status pm_portable_error(const pm_reader *reader, const char *file, const char *what,
                            pm_error *err)
{
    if (reader->failed)
        return pm_error_set_at(err, PM_E_CORRUPT, file, 0, 0,
                               "the file is cut off; its %zu bytes end inside %s", reader->size,
                               what);
    return pm_error_set_at(err, PM_E_CORRUPT, file, 0, 0,
                           "the file is damaged: %s is wrong before byte %zu", what,
                           reader->at);
}

/* ---- the header ---- */

struct line {
    const char *text;
    size_t length;
};

/* The next line without its end; false at the end of the bytes. */
static bool next_line(pm_reader *reader, struct line *line)
{
    const uint8_t *start = reader->data + reader->at;
    size_t left = reader->size - reader->at;
    const uint8_t *end = left ? memchr(start, '\n', left) : NULL;
    if (!end)
        return false;
    *line = (struct line){(const char *)start, (size_t)(end - start)};
    reader->at += line->length + 1;
    if (line->length && start[line->length - 1] == '\r')
        line->length--;
    return true;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

/* False only for a FORMAT= line that says something else. */
static bool format_agrees(struct line line, const char *format)
{
    static const char key[] = "FORMAT=";
    if (line.length < sizeof key - 1 || memcmp(line.text, key, sizeof key - 1) != 0)
        return true;
    const char *at = line.text + sizeof key - 1, *end = line.text + line.length;
    while (at < end && is_blank(*at))
        at++;
    while (end > at && is_blank(end[-1]))
        end--;
    return (size_t)(end - at) == strlen(format) && memcmp(at, format, strlen(format)) == 0;
}

bool pm_portable_header(pm_reader *reader, const char *format, int magic, unsigned *size)
{
    struct line line = {.length = 1};
    bool agrees = reader->size > 0 && reader->data[0] >= ' ' && reader->data[0] < 0x7F;
    while (agrees && line.length > 0)
        agrees = next_line(reader, &line) && format_agrees(line, format);
    if (!agrees)
        return false;
    int64_t number = pm_portable_integer(reader, 2) - magic;
    if (reader->failed || number < 1 || number > PM_PORTABLE_WIDEST)
        return false;
    *size = (unsigned)number;
    return true;
}

static bool read_number(pm_reader *reader, double *value)
{
    const char *text = pm_portable_text(reader);
    return text && pm_number_real(text, strlen(text), value) == PM_NUMBER_OK;
}

bool pm_portable_cube(pm_reader *reader, double origin[3], double *size)
{
    for (int i = 0; i < 3; i++)
        if (!read_number(reader, &origin[i]))
            return false;
    return read_number(reader, size) && *size >= 0;
}

/* ---- the tree ---- */

static pm_status read_set(pm_reader *reader, unsigned size, uint64_t objects,
                          const bool *is_surface, const char *file, pm_error *err)
{
    int64_t count = pm_portable_integer(reader, size), before = -1;
    if (count < 1 || count > PM_OCTREE_SET)
        return pm_portable_error(reader, file, "the size of a leaf", err);
    for (int64_t i = 0; i < count; i++) {
        int64_t object = pm_portable_integer(reader, size);
        if (reader->failed || object < 0 || (uint64_t)object >= objects || object <= before)
            return pm_portable_error(reader, file, "an object of a leaf", err);
        if (is_surface && !is_surface[object])
            return pm_portable_error(reader, file, "an object of a leaf, which is no surface,",
                                     err);
        before = object;
    }
    return PM_OK;
}

pm_status pm_portable_tree(pm_reader *reader, unsigned size, uint64_t objects,
                           const bool *is_surface, const char *file, pm_error *err)
{
    pm_status st = PM_OK;
    /* Nodes that are announced and not read yet; each takes a byte at least. */
    for (uint64_t awaited = 1; !st && awaited > 0; awaited--) {
        const uint8_t *node = pm_reader_take(reader, 1);
        if (!node || *node > PM_NODE_TREE)
            return pm_portable_error(reader, file, "a node of the octree", err);
        if (*node == PM_NODE_TREE)
            awaited += 8;
        else if (*node == PM_NODE_FULL)
            st = read_set(reader, size, objects, is_surface, file, err);
    }
    return st;
}
