#include "files/records.h"

#include <stdlib.h>
#include <string.h>

enum {
    MOST_TYPES = 127,       /* the byte of a type is signed, and -1 ends the list */
    MOST_ARGUMENTS = 32767, /* a signed count of 2 bytes */
    LONGEST_TEXT = 511,
    REAL_SIZE = 5
};

/* ---- reading ---- */

struct records_reader {
    pm_reader *bytes;
    unsigned index_size;
    const char *file;
    pm_arena *arena;
    pm_error *err;
    const char *types[MOST_TYPES];
    int type_count;
    pm_record *items;
    size_t count, capacity, limit;
};

static pm_status fail(const struct records_reader *r, const char *what)
{
    return pm_portable_error(r->bytes, r->file, what, r->err);
}

static pm_status memory_error(const struct records_reader *r)
{
    return pm_error_set_at(r->err, PM_E_MEMORY, r->file, 0, 0,
                           "not enough memory for its primitives");
}

static pm_status read_types(struct records_reader *r)
{
    for (;;) {
        const char *name = pm_portable_text(r->bytes);
        if (!name || (*name && r->type_count == MOST_TYPES))
            return fail(r, "the list of types");
        if (!*name)
            return PM_OK;
        r->types[r->type_count++] = name;
    }
}

static pm_status read_strings(struct records_reader *r, pm_record *out)
{
    int64_t count = pm_portable_integer(r->bytes, 2);
    if (count < 0)
        return fail(r, "the count of a primitive's strings");
    if (r->bytes->failed || (size_t)count > r->bytes->size - r->bytes->at) {
        r->bytes->failed = true;
        return fail(r, "a primitive's strings");
    }
    const char **strings = pm_arena_array(r->arena, (size_t)count, sizeof *strings);
    if (!strings)
        return memory_error(r);
    for (int64_t i = 0; i < count; i++)
        if (!(strings[i] = pm_portable_text(r->bytes)))
            return fail(r, "a primitive's strings");
    out->strings = strings;
    out->string_count = (uint32_t)count;
    return PM_OK;
}

static pm_status read_reals(struct records_reader *r, pm_record *out)
{
    int64_t count = pm_portable_integer(r->bytes, 2);
    if (count < 0)
        return fail(r, "the count of a primitive's reals");
    if (r->bytes->failed || (size_t)count > (r->bytes->size - r->bytes->at) / REAL_SIZE) {
        r->bytes->failed = true;
        return fail(r, "a primitive's reals");
    }
    double *reals = pm_arena_array(r->arena, (size_t)count, sizeof *reals);
    if (!reals)
        return memory_error(r);
    for (int64_t i = 0; i < count; i++)
        reals[i] = pm_portable_real(r->bytes);
    out->reals = reals;
    out->real_count = (uint32_t)count;
    return PM_OK;
}

static pm_status read_record(struct records_reader *r, int64_t type, pm_record *out)
{
    if (type < 0 || type >= r->type_count)
        return fail(r, "the type of a primitive");
    out->type = r->types[type];
    int64_t modifier = pm_portable_integer(r->bytes, r->index_size);
    if (r->bytes->failed || modifier < -1 || modifier >= (int64_t)r->count)
        return fail(r, "the modifier of a primitive");
    out->modifier = (int32_t)modifier;
    out->name = pm_portable_text(r->bytes);
    if (!out->name)
        return fail(r, "the name of a primitive");
    pm_status st = read_strings(r, out);
    return st ? st : read_reals(r, out);
}

static pm_status append(struct records_reader *r, const pm_record *record)
{
    if (r->count >= r->limit)
        return pm_error_set_at(r->err, PM_E_LIMIT, r->file, 0, 0,
                               "it holds more than %zu primitives; split it", r->limit);
    if (r->count == r->capacity) {
        size_t capacity = r->capacity ? 2 * r->capacity : 64;
        pm_record *more = realloc(r->items, capacity * sizeof *more);
        if (!more)
            return memory_error(r);
        r->items = more;
        r->capacity = capacity;
    }
    r->items[r->count++] = *record;
    return PM_OK;
}

static pm_status read_all(struct records_reader *r)
{
    pm_status st = read_types(r);
    while (!st) {
        pm_record record;
        int64_t type = pm_portable_integer(r->bytes, 1);
        if (r->bytes->failed)
            return fail(r, "the list of primitives");
        if (type == -1)
            return PM_OK;
        st = read_record(r, type, &record);
        if (!st)
            st = append(r, &record);
    }
    return st;
}

pm_status pm_records_read(pm_reader *reader, unsigned index_size, size_t limit,
                          const char *file, pm_arena *arena, pm_records *out, pm_error *err)
{
    struct records_reader r = {.bytes = reader,
                               .index_size = index_size,
                               .file = file,
                               .arena = arena,
                               .err = err,
                               .limit = limit < INT32_MAX ? limit : INT32_MAX};
    pm_status st = read_all(&r);
    pm_record *items = NULL;
    if (!st) {
        items = pm_arena_array(arena, r.count, sizeof *items);
        if (!items)
            st = memory_error(&r);
    }
    if (!st) {
        if (r.count)
            memcpy(items, r.items, r.count * sizeof *items);
        *out = (pm_records){.items = items, .count = r.count};
    }
    free(r.items);
    return st;
}

/* ---- writing ---- */

/* Radiance's types. A reader maps them by name, so the order is ours to choose. */
static const char *const type_names[] = {
    "polygon",    "cone",       "sphere",    "texfunc",  "ring",       "cylinder",
    "instance",   "cup",        "bubble",    "tube",     "mesh",       "alias",
    "plastic",    "metal",      "glass",     "trans",    "dielectric", "plastic2",
    "metal2",     "trans2",     "interface", "plasfunc", "metfunc",    "brightfunc",
    "brightdata", "brighttext", "colorpict", "glow",     "source",     "light",
    "illum",      "spotlight",  "mist",      "mirror",   "transfunc",  "BRTDfunc",
    "BSDF",       "aBSDF",      "plasdata",  "metdata",  "transdata",  "colorfunc",
    "antimatter", "colordata",  "colortext", "texdata",  "mixfunc",    "mixdata",
    "mixtext",    "mixpict",    "prism1",    "prism2",   "ashik2",
};
enum { TYPE_NAMES = sizeof type_names / sizeof *type_names };

static int find_type(const char *name)
{
    for (int i = 0; i < TYPE_NAMES; i++)
        if (strcmp(type_names[i], name) == 0)
            return i;
    return -1;
}

static pm_status check_record(const pm_record *record, pm_error *err)
{
    if (find_type(record->type) < 0)
        return pm_error_set(err, PM_E_UNSUPPORTED,
                            "%s '%s' cannot be written: Radiance 5.4 has no such type",
                            record->type, record->name);
    if (record->string_count > MOST_ARGUMENTS || record->real_count > MOST_ARGUMENTS)
        return pm_error_set(err, PM_E_LIMIT,
                            "%s '%s' has %u arguments, and a frozen octree holds %d at most; "
                            "leave out -f, or divide it",
                            record->type, record->name,
                            record->real_count > record->string_count ? record->real_count
                                                                      : record->string_count,
                            MOST_ARGUMENTS);
    bool short_texts = strlen(record->name) <= LONGEST_TEXT;
    for (uint32_t i = 0; i < record->string_count; i++)
        short_texts = short_texts && strlen(record->strings[i]) <= LONGEST_TEXT;
    if (!short_texts)
        return pm_error_set(err, PM_E_LIMIT,
                            "a name or a string of %s '%.60s' is longer than %d bytes, and a "
                            "frozen octree holds no longer ones",
                            record->type, record->name, LONGEST_TEXT);
    return PM_OK;
}

static void write_record(const pm_record *record, pm_bytes *out)
{
    pm_portable_put_integer(out, find_type(record->type), 1);
    pm_portable_put_integer(out, record->modifier, 4);
    pm_portable_put_text(out, record->name);
    pm_portable_put_integer(out, record->string_count, 2);
    for (uint32_t i = 0; i < record->string_count; i++)
        pm_portable_put_text(out, record->strings[i]);
    pm_portable_put_integer(out, record->real_count, 2);
    for (uint32_t i = 0; i < record->real_count; i++)
        pm_portable_put_real(out, record->reals[i]);
}

pm_status pm_records_write(const pm_record *items, size_t count, pm_bytes *out, pm_error *err)
{
    for (int i = 0; i < TYPE_NAMES; i++)
        pm_portable_put_text(out, type_names[i]);
    pm_portable_put_text(out, "");
    for (size_t i = 0; i < count; i++) {
        pm_status st = check_record(&items[i], err);
        if (st)
            return st;
        write_record(&items[i], out);
    }
    pm_portable_put_integer(out, -1, 1);
    if (pm_bytes_status(out))
        return pm_error_set(err, PM_E_MEMORY, "not enough memory to write the primitives");
    return PM_OK;
}
