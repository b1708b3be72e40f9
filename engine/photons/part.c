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
 *   path order without any dictionary: a plane of n: 1: the direction is told by the place of
 *                 the photon before; m that are not
 *   directions of the m, or of all: 4 planes: low and high byte of either code
 *   planes of n:  normal (2), exponent, flags, flux (4, the lowest first)
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

/* True if the axis has a dictionary. */
static bool pack_axis(pm_part_coder *coder, const pm_photon *photons, size_t count, int axis,
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
    return dictionary.count > 0;
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
                        bool in_order, bool *shared, pm_photon *out)
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
    *shared = *shared || dictionary.count > 0;
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

/* ---- directions ----
 *
 * Most photons of a path in mist come from where the one before lies: their direction is told
 * by the two places, to the last bit but for rounding. Looked for only where no coordinate is
 * shared: on walls it would cost more time than it saves bytes. */

static bool comes_from_before(const pm_photon *photon)
{
    uint16_t code[2];
    pm_photon_direction_code(
        pm_vec3_sub(pm_photon_position(photon - 1), pm_photon_position(photon)), code);
    return code[0] == photon->direction[0] && code[1] == photon->direction[1];
}

static void pack_directions(pm_part_coder *coder, const pm_photon *photons, size_t count,
                            const uint8_t *first, bool shared, pm_bytes *out)
{
    uint8_t *told = coder->code[0];
    bool looked_for = first && !shared;
    size_t literals = 0;
    for (size_t i = 0; i < count; i++) {
        told[i] = looked_for && i && !first[i] && comes_from_before(&photons[i]);
        if (told[i])
            continue;
        for (int b = 0; b < 4; b++)
            coder->plane[b][literals] = (uint8_t)(photons[i].direction[b / 2] >> 8 * (b % 2));
        literals++;
    }
    if (looked_for)
        put_plane(coder, told, count, WORTH_A_TRY, out);
    for (int b = 0; b < 4; b++)
        put_plane(coder, coder->plane[b], literals, b % 2 && !first ? WORTH_A_TRY : RANDOM,
                  out);
}

/* Takes which photons' directions are told by the places; false if one is that cannot be. */
static bool take_told(pm_part_coder *coder, pm_reader *reader, size_t count,
                      const uint8_t *first, size_t *literals)
{
    uint8_t *told = coder->code[0];
    bool sound = take_plane(coder, reader, count, WORTH_A_TRY, told);
    *literals = 0;
    for (size_t i = 0; i < count && sound; i++) {
        sound = !told[i] || (told[i] == 1 && i && !first[i]);
        *literals += !told[i];
    }
    return sound;
}

static bool unpack_directions(pm_part_coder *coder, pm_reader *reader, size_t count,
                              const uint8_t *first, bool shared, pm_photon *out)
{
    uint8_t *told = coder->code[0];
    size_t literals = count;
    memset(told, 0, count);
    if (first && !shared && !take_told(coder, reader, count, first, &literals))
        return false;
    for (int b = 0; b < 4; b++)
        if (!take_plane(coder, reader, literals, b % 2 ? WORTH_A_TRY : RANDOM, coder->plane[b]))
            return false;
    for (size_t i = 0, k = 0; i < count; i++) {
        if (told[i]) {
            pm_photon_direction_code(
                pm_vec3_sub(pm_photon_position(&out[i - 1]), pm_photon_position(&out[i])),
                out[i].direction);
            continue;
        }
        for (int d = 0; d < 2; d++)
            out[i].direction[d] =
                (uint16_t)(coder->plane[2 * d][k] | coder->plane[2 * d + 1][k] << 8);
        k++;
    }
    return true;
}

/* ---- whole photons ---- */

/* The other bytes, in the order of their planes. */
static const uint8_t others[] = {
    offsetof(pm_photon, normal),   offsetof(pm_photon, normal) + 1,
    offsetof(pm_photon, exponent), offsetof(pm_photon, flags),
    offsetof(pm_photon, flux),     offsetof(pm_photon, flux) + 1,
    offsetof(pm_photon, flux) + 2, offsetof(pm_photon, flux) + 3,
};

enum { OTHERS = sizeof others };

_Static_assert(OTHERS + sizeof((pm_photon){0}.position) + sizeof((pm_photon){0}.direction) ==
                   sizeof(pm_photon),
               "each byte of a photon has its place");

void pm_part_pack(pm_part_coder *coder, const pm_photon *photons, size_t count,
                  const uint8_t *first, pm_bytes *out)
{
    assert(count <= PM_PART_PHOTONS);
    bool shared = false;
    for (int axis = 0; axis < 3; axis++)
        shared |= pack_axis(coder, photons, count, axis, !first, out);
    pack_directions(coder, photons, count, first, shared, out);
    for (size_t k = 0; k < OTHERS; k++) {
        const uint8_t *from = (const uint8_t *)photons + others[k];
        for (size_t i = 0; i < count; i++)
            coder->plane[0][i] = from[i * sizeof *photons];
        put_plane(coder, coder->plane[0], count, WORTH_A_TRY, out);
    }
}

bool pm_part_unpack(pm_part_coder *coder, pm_reader *reader, size_t count, const uint8_t *first,
                    pm_photon *out)
{
    bool shared = false;
    if (count > PM_PART_PHOTONS)
        return false;
    for (int axis = 0; axis < 3; axis++)
        if (!unpack_axis(coder, reader, count, axis, !first, &shared, out))
            return false;
    if (!unpack_directions(coder, reader, count, first, shared, out))
        return false;
    for (size_t k = 0; k < OTHERS; k++) {
        uint8_t *to = (uint8_t *)out + others[k];
        if (!take_plane(coder, reader, count, WORTH_A_TRY, coder->plane[0]))
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
