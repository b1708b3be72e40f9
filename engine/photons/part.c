#include "photons/part.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include <zstd.h>

/* The bytes of a part of n photons. A plane is the same byte of each photon: 4 bytes say how
 * many follow, either all of its bytes or, if fewer, a zstd frame of them.
 *
 *   for x, y, z:  k, a byte; k dictionary entries of 4 bytes; if k, a plane of n codes:
 *                 0: the coordinate is among the m literals, c: it is entry c - 1
 *   for x, y, z:  the literals, 4 planes of m bytes, the highest first
 *   planes of n:  normal (2), direction (low bytes of both codes, then high ones), exponent,
 *                 flags, flux (4, the lowest first)
 *
 * The dictionary holds coordinates that many photons share: those of walls that stand upright.
 * In order, a literal is the difference to the literal before, 2 |d| or 2 |d| - 1 by its sign,
 * which is small. Low bytes of coordinates and directions are random: they are not worth a try,
 * and, never being packed, they bound what a damaged or wicked file can blow up to. */

enum {
    LEVEL = 1,
    PLANES = 4,    /* at work at a time */
    SAMPLES = 512, /* of a part's coordinates, that the dictionary is made from */
    SHARED = 6,    /* times that a sample must be there to enter it */
    ENTRIES = SAMPLES / SHARED,
    SLOTS = 1024, /* where entries are looked for */
};

struct dictionary {
    uint32_t entry[ENTRIES];
    unsigned count;
    uint8_t slot[SLOTS]; /* code of the entry that is found there, or 0 */
};

struct pm_part_coder {
    ZSTD_CCtx *packer;
    ZSTD_DCtx *unpacker;
    uint8_t plane[PLANES][PM_PART_PHOTONS];
    uint8_t code[3][PM_PART_PHOTONS];
    uint32_t literal[PM_PART_PHOTONS];
    uint8_t packed[PM_PART_PHOTONS];
};

pm_part_coder *pm_part_coder_new(void)
{
    pm_part_coder *coder = calloc(1, sizeof *coder);
    if (!coder)
        return NULL;
    coder->packer = ZSTD_createCCtx();
    coder->unpacker = ZSTD_createDCtx();
    if (coder->packer && coder->unpacker)
        return coder;
    pm_part_coder_free(coder);
    return NULL;
}

void pm_part_coder_free(pm_part_coder *coder)
{
    if (!coder)
        return;
    ZSTD_freeCCtx(coder->packer);
    ZSTD_freeDCtx(coder->unpacker);
    free(coder);
}

/* ---- planes ---- */

enum worth { RANDOM, WORTH_A_TRY };

static void put_plane(pm_part_coder *coder, const uint8_t *plane, size_t size, enum worth worth,
                      pm_bytes *out)
{
    size_t packed = 0;
    if (worth == WORTH_A_TRY && size > 1)
        packed = ZSTD_compressCCtx(coder->packer, coder->packed, size - 1, plane, size, LEVEL);
    if (!packed || ZSTD_isError(packed)) { /* it does not fit: it would not be shorter */
        pm_bytes_u32(out, (uint32_t)size);
        pm_bytes_append(out, plane, size);
    } else {
        pm_bytes_u32(out, (uint32_t)packed);
        pm_bytes_append(out, coder->packed, packed);
    }
}

static bool take_plane(pm_part_coder *coder, pm_reader *reader, size_t size, enum worth worth,
                       uint8_t *plane)
{
    uint32_t packed = pm_reader_u32(reader);
    if (packed > size || (worth == RANDOM && packed != size))
        return false;
    const uint8_t *bytes = pm_reader_take(reader, packed);
    if (!bytes)
        return false;
    if (packed < size)
        return ZSTD_decompressDCtx(coder->unpacker, plane, size, bytes, packed) == size;
    memcpy(plane, bytes, size);
    return true;
}

/* ---- coordinates that many photons share ---- */

static unsigned slot_of(uint32_t value)
{
    return value * 2654435761U >> 22;
}

static int by_value(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* Of two entries with one slot the second is left out: it costs bytes alone. */
static void add_entry(struct dictionary *dictionary, uint32_t value)
{
    uint8_t *slot = &dictionary->slot[slot_of(value)];
    if (*slot)
        return;
    dictionary->entry[dictionary->count++] = value;
    *slot = (uint8_t)dictionary->count;
}

static void make_dictionary(const pm_photon *photons, size_t count, int axis,
                            struct dictionary *out)
{
    uint32_t sample[SAMPLES];
    size_t samples = count < SAMPLES ? count : SAMPLES;
    for (size_t i = 0; i < samples; i++)
        sample[i] = photons[i * count / samples].position[axis];
    qsort(sample, samples, sizeof *sample, by_value);
    *out = (struct dictionary){.count = 0};
    for (size_t i = 0, first = 0; i < samples; i++) {
        if (sample[i] != sample[first])
            first = i;
        if (i == first + SHARED - 1)
            add_entry(out, sample[i]);
    }
}

static unsigned code_of(const struct dictionary *dictionary, uint32_t value)
{
    unsigned code = dictionary->slot[slot_of(value)];
    return code && dictionary->entry[code - 1] == value ? code : 0;
}

/* ---- coordinates ---- */

static uint32_t fold(uint32_t difference)
{
    return difference << 1 ^ (0 - (difference >> 31));
}

static uint32_t unfold(uint32_t folded)
{
    return folded >> 1 ^ (0 - (folded & 1));
}

/* Returns the number of literals. */
static size_t split_axis(pm_part_coder *coder, const pm_photon *photons, size_t count, int axis,
                         bool in_order, const struct dictionary *dictionary)
{
    size_t literals = 0;
    uint32_t before = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t value = photons[i].position[axis];
        unsigned code = dictionary->count ? code_of(dictionary, value) : 0;
        coder->code[axis][i] = (uint8_t)code;
        if (code)
            continue;
        coder->literal[literals++] = in_order ? fold(value - before) : value;
        before = value;
    }
    return literals;
}

static void pack_axis(pm_part_coder *coder, const pm_photon *photons, size_t count, int axis,
                      bool in_order, pm_bytes *out)
{
    struct dictionary dictionary;
    make_dictionary(photons, count, axis, &dictionary);
    size_t literals = split_axis(coder, photons, count, axis, in_order, &dictionary);
    pm_bytes_u8(out, (uint8_t)dictionary.count);
    for (unsigned i = 0; i < dictionary.count; i++)
        pm_bytes_u32(out, dictionary.entry[i]);
    if (dictionary.count)
        put_plane(coder, coder->code[axis], count, WORTH_A_TRY, out);
    for (size_t i = 0; i < literals; i++)
        for (int b = 0; b < 4; b++)
            coder->plane[b][i] = (uint8_t)(coder->literal[i] >> 8 * b);
    put_plane(coder, coder->plane[3], literals, WORTH_A_TRY, out);
    put_plane(coder, coder->plane[2], literals, in_order ? WORTH_A_TRY : RANDOM, out);
    put_plane(coder, coder->plane[1], literals, RANDOM, out);
    put_plane(coder, coder->plane[0], literals, RANDOM, out);
}

static bool take_dictionary(pm_reader *reader, struct dictionary *out)
{
    out->count = pm_reader_u8(reader);
    if (out->count > ENTRIES)
        return false;
    for (unsigned i = 0; i < out->count; i++)
        out->entry[i] = pm_reader_u32(reader);
    return !reader->failed;
}

/* Counts the codes that stand for literals; false if one is no entry. */
static bool count_literals(const uint8_t *code, size_t count, const struct dictionary *d,
                           size_t *literals)
{
    bool known = true;
    *literals = 0;
    for (size_t i = 0; i < count; i++) {
        *literals += !code[i];
        known = known && code[i] <= d->count;
    }
    return known;
}

static bool unpack_axis(pm_part_coder *coder, pm_reader *reader, size_t count, int axis,
                        bool in_order, pm_photon *out)
{
    struct dictionary dictionary;
    uint8_t *code = coder->code[axis];
    size_t literals;
    memset(code, 0, count);
    if (!take_dictionary(reader, &dictionary) ||
        (dictionary.count && !take_plane(coder, reader, count, WORTH_A_TRY, code)) ||
        !count_literals(code, count, &dictionary, &literals) ||
        !take_plane(coder, reader, literals, WORTH_A_TRY, coder->plane[3]) ||
        !take_plane(coder, reader, literals, WORTH_A_TRY, coder->plane[2]) ||
        !take_plane(coder, reader, literals, RANDOM, coder->plane[1]) ||
        !take_plane(coder, reader, literals, RANDOM, coder->plane[0]))
        return false;
    uint32_t value = 0;
    for (size_t i = 0, k = 0; i < count; i++) {
        if (code[i]) {
            out[i].position[axis] = dictionary.entry[code[i] - 1];
            continue;
        }
        uint32_t literal = coder->plane[0][k] | (uint32_t)coder->plane[1][k] << 8 |
                           (uint32_t)coder->plane[2][k] << 16 |
                           (uint32_t)coder->plane[3][k] << 24;
        value = in_order ? value + unfold(literal) : literal;
        out[i].position[axis] = value;
        k++;
    }
    return true;
}

/* ---- whole photons ---- */

/* The bytes behind the position, in the order of their planes, and when they are worth a try:
 * in order, neighbours have much in common. */
static const struct {
    uint8_t offset;
    enum { NEVER, IN_ORDER, ALWAYS } worth;
} others[] = {
    {offsetof(pm_photon, normal), ALWAYS},
    {offsetof(pm_photon, normal) + 1, ALWAYS},
    {offsetof(pm_photon, direction), NEVER},
    {offsetof(pm_photon, direction) + 2, NEVER},
    {offsetof(pm_photon, direction) + 1, IN_ORDER},
    {offsetof(pm_photon, direction) + 3, IN_ORDER},
    {offsetof(pm_photon, exponent), ALWAYS},
    {offsetof(pm_photon, flags), ALWAYS},
    {offsetof(pm_photon, flux), ALWAYS},
    {offsetof(pm_photon, flux) + 1, ALWAYS},
    {offsetof(pm_photon, flux) + 2, ALWAYS},
    {offsetof(pm_photon, flux) + 3, ALWAYS},
};

enum { OTHERS = sizeof others / sizeof *others };

_Static_assert(OTHERS + sizeof((pm_photon){0}.position) == sizeof(pm_photon),
               "each byte of a photon has its plane");

void pm_part_pack(pm_part_coder *coder, const pm_photon *photons, size_t count, bool in_order,
                  pm_bytes *out)
{
    assert(count <= PM_PART_PHOTONS);
    for (int axis = 0; axis < 3; axis++)
        pack_axis(coder, photons, count, axis, in_order, out);
    for (size_t k = 0; k < OTHERS; k++) {
        const uint8_t *from = (const uint8_t *)photons + others[k].offset;
        for (size_t i = 0; i < count; i++)
            coder->plane[0][i] = from[i * sizeof *photons];
        bool try = others[k].worth == ALWAYS || (others[k].worth == IN_ORDER && in_order);
        put_plane(coder, coder->plane[0], count, try ? WORTH_A_TRY : RANDOM, out);
    }
}

bool pm_part_unpack(pm_part_coder *coder, pm_reader *reader, size_t count, bool in_order,
                    pm_photon *out)
{
    if (count > PM_PART_PHOTONS)
        return false;
    for (int axis = 0; axis < 3; axis++)
        if (!unpack_axis(coder, reader, count, axis, in_order, out))
            return false;
    for (size_t k = 0; k < OTHERS; k++) {
        uint8_t *to = (uint8_t *)out + others[k].offset;
        enum worth worth = others[k].worth == NEVER ? RANDOM : WORTH_A_TRY;
        if (!take_plane(coder, reader, count, worth, coder->plane[0]))
            return false;
        for (size_t i = 0; i < count; i++)
            to[i * sizeof *out] = coder->plane[0][i];
    }
    return !reader->failed && reader->at == reader->size;
}

/* ---- numbers ---- */

void pm_part_pack_numbers(pm_part_coder *coder, const uint32_t *numbers, size_t count,
                          pm_bytes *out)
{
    assert(count <= PM_PART_PHOTONS);
    for (int b = 0; b < 4; b++) {
        for (size_t i = 0; i < count; i++)
            coder->plane[0][i] = (uint8_t)(numbers[i] >> 8 * b);
        put_plane(coder, coder->plane[0], count, WORTH_A_TRY, out);
    }
}

bool pm_part_unpack_numbers(pm_part_coder *coder, pm_reader *reader, size_t count,
                            uint32_t *out)
{
    if (count > PM_PART_PHOTONS)
        return false;
    for (int b = 0; b < 4; b++)
        if (!take_plane(coder, reader, count, WORTH_A_TRY, coder->plane[b]))
            return false;
    for (size_t i = 0; i < count; i++) {
        out[i] = 0;
        for (int b = 0; b < 4; b++)
            out[i] |= (uint32_t)coder->plane[b][i] << 8 * b;
    }
    return !reader->failed && reader->at == reader->size;
}
