#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <zlib.h>

#include "photons/map_internal.h"

/* Files of maps and of batches. All numbers are little-endian; every part ends in the CRC-32 of
 * its bytes, so that a flipped bit is found where it is.
 *
 * A map:                                  A batch:
 *   bytes     what                          bytes     what
 *   8         "pmphoton"                    8         "pmbatch\0"
 *   4         version                       4         version
 *   4         kind                          4         kind
 *   32 32     scene, family                 8         index
 *   8         paths                         4         paths
 *   8 8 24    flux scale, world scale,      8         photons
 *             world center                  72        emitted, absorbed, escaped
 *   8 8       seed, storage probability     4         CRC-32 of all above
 *   24        emitted                       4 * paths ends, then 4: their CRC-32
 *   160       note, filled up with zeros    ...       photons, as in a map
 *   8         photons
 *   4         CRC-32 of all above
 *   ...       photons: parts of at most PART_PHOTONS, 24 bytes each, then 4: their CRC-32
 *   8         "pm-end\0\0"
 *   4         length of the command line
 *   ...       command line as typed: of no digest, equal maps are equal up to here
 *   4         CRC-32 of length and command line */

enum {
    VERSION = 1,
    PART_PHOTONS = (1 << 20) / sizeof(pm_photon),
    COMMAND_MAX = 1 << 20,
    NOTE_BYTES = 160,
};

static const char map_magic[8] = "pmphoton", batch_magic[8] = "pmbatch",
                  end_magic[8] = "pm-end";

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "photons are written as they lie");
_Static_assert(sizeof((pm_map_header){0}.note) == NOTE_BYTES, "the note has its place");

/* ---- writing ---- */

/* The CRC-32 of everything since `start`. */
static void put_checksum(pm_bytes *out, size_t start)
{
    if (!out->failed)
        pm_bytes_u32(out, (uint32_t)crc32_z(0, out->data + start, out->size - start));
}

static void put_rgb(pm_bytes *out, pm_rgb c)
{
    pm_bytes_f64(out, c.r);
    pm_bytes_f64(out, c.g);
    pm_bytes_f64(out, c.b);
}

static void put_map_header(pm_bytes *out, const pm_map_header *h, size_t count)
{
    size_t start = out->size;
    pm_bytes_append(out, map_magic, sizeof map_magic);
    pm_bytes_u32(out, VERSION);
    pm_bytes_u32(out, (uint32_t)h->kind);
    pm_bytes_append(out, h->scene.bytes, sizeof h->scene.bytes);
    pm_bytes_append(out, h->family.bytes, sizeof h->family.bytes);
    pm_bytes_u64(out, h->paths);
    pm_bytes_f64(out, h->flux_scale);
    pm_bytes_f64(out, h->world_scale);
    pm_bytes_f64(out, h->world_center.x);
    pm_bytes_f64(out, h->world_center.y);
    pm_bytes_f64(out, h->world_center.z);
    pm_bytes_u64(out, h->seed);
    pm_bytes_f64(out, h->storage_probability);
    put_rgb(out, h->emitted);
    char note[NOTE_BYTES] = "";
    memcpy(note, h->note, strnlen(h->note, NOTE_BYTES - 1));
    pm_bytes_append(out, note, NOTE_BYTES);
    pm_bytes_u64(out, count);
    put_checksum(out, start);
}

/* How many photons the part at photon `first` holds. */
static size_t part_size(size_t first, size_t count)
{
    return count - first < PART_PHOTONS ? count - first : PART_PHOTONS;
}

static void put_map_photons(pm_bytes *out, const pm_photon_map *map, size_t count)
{
    for (size_t first = 0; first < count; first += PART_PHOTONS) {
        size_t start = out->size, size = part_size(first, count);
        for (size_t i = 0; i < size; i++) {
            pm_photon photon;
            pm_photon_map_photon(map, first + i, &photon);
            pm_bytes_append(out, &photon, sizeof photon);
        }
        put_checksum(out, start);
    }
}

static void put_photons(pm_bytes *out, const pm_photon *photons, size_t count)
{
    for (size_t first = 0; first < count; first += PART_PHOTONS) {
        size_t start = out->size;
        pm_bytes_append(out, photons + first, part_size(first, count) * sizeof *photons);
        put_checksum(out, start);
    }
}

static pm_status finish(pm_bytes *out, pm_bytes *text, pm_error *err)
{
    if (pm_bytes_status(text)) {
        pm_bytes_clear(text);
        return pm_error_set(err, PM_E_MEMORY, "no memory for a file of photons");
    }
    *out = *text;
    return PM_OK;
}

pm_status pm_photon_map_write(const pm_photon_map *map, const char *command, pm_bytes *out,
                              pm_error *err)
{
    pm_bytes text = {0};
    size_t count = pm_photon_map_count(map), length = command ? strlen(command) : 0;
    put_map_header(&text, pm_photon_map_header(map), count);
    put_map_photons(&text, map, count);
    pm_bytes_append(&text, end_magic, sizeof end_magic);
    size_t start = text.size;
    length = length < COMMAND_MAX ? length : COMMAND_MAX;
    pm_bytes_u32(&text, (uint32_t)length);
    pm_bytes_append(&text, command, length);
    put_checksum(&text, start);
    return finish(out, &text, err);
}

pm_status pm_batch_write(const pm_batch *batch, pm_bytes *out, pm_error *err)
{
    assert(batch->ends);
    pm_bytes text = {0};
    pm_bytes_append(&text, batch_magic, sizeof batch_magic);
    pm_bytes_u32(&text, VERSION);
    pm_bytes_u32(&text, (uint32_t)batch->kind);
    pm_bytes_u64(&text, batch->index);
    pm_bytes_u32(&text, batch->paths);
    pm_bytes_u64(&text, batch->count);
    put_rgb(&text, batch->emitted);
    put_rgb(&text, batch->absorbed);
    put_rgb(&text, batch->escaped);
    put_checksum(&text, 0);
    size_t start = text.size;
    pm_bytes_append(&text, batch->ends, batch->paths * sizeof *batch->ends);
    put_checksum(&text, start);
    put_photons(&text, batch->photons, batch->count);
    return finish(out, &text, err);
}

/* ---- reading ---- */

/* A file being read: what it is called, and where the first complaint goes. */
struct source {
    pm_reader reader;
    const char *name;
    pm_error *err;
};

static pm_status damaged(const struct source *source, const char *part)
{
    return pm_error_set_at(source->err, PM_E_CORRUPT, source->name, 0, 0,
                           "is damaged or cut short in its %s; make or fetch it again", part);
}

/* Checks the CRC-32 behind everything since `start`. */
static bool checksum_holds(struct source *source, size_t start)
{
    pm_reader *reader = &source->reader;
    if (reader->failed)
        return false;
    uint32_t wanted = (uint32_t)crc32_z(0, reader->data + start, reader->at - start);
    uint32_t found = pm_reader_u32(reader);
    return !reader->failed && found == wanted;
}

static pm_status check_magic(struct source *source, const char magic[8], const char *what)
{
    const uint8_t *start = pm_reader_take(&source->reader, 8);
    if (!start || memcmp(start, magic, 8))
        return pm_error_set_at(source->err, PM_E_SYNTAX, source->name, 0, 0, "is no %s", what);
    uint32_t version = pm_reader_u32(&source->reader);
    if (!source->reader.failed && version != VERSION)
        return pm_error_set_at(source->err, PM_E_UNSUPPORTED, source->name, 0, 0,
                               "has version %u, this program reads version %d; make it again",
                               version, VERSION);
    return PM_OK;
}

static pm_rgb take_rgb(pm_reader *reader)
{
    pm_rgb c;
    c.r = pm_reader_f64(reader);
    c.g = pm_reader_f64(reader);
    c.b = pm_reader_f64(reader);
    return c;
}

static void take_digest(pm_reader *reader, pm_digest *out)
{
    const uint8_t *bytes = pm_reader_take(reader, sizeof out->bytes);
    if (bytes)
        memcpy(out->bytes, bytes, sizeof out->bytes);
}

static bool header_makes_sense(const pm_map_header *h, uint64_t count)
{
    return (unsigned)h->kind < PM_MAP_KINDS && h->paths > 0 && isfinite(h->flux_scale) &&
           h->flux_scale >= 0 && isfinite(h->world_scale) && h->world_scale > 0 &&
           pm_vec3_finite(h->world_center) && h->storage_probability > 0 &&
           h->storage_probability <= 1 && pm_rgb_finite(h->emitted) &&
           memchr(h->note, 0, NOTE_BYTES) && count <= PM_MAP_PHOTONS_MAX;
}

static pm_status read_map_header(struct source *source, pm_map_header *out, uint64_t *count)
{
    pm_reader *reader = &source->reader;
    pm_map_header h = {0};
    pm_status st = check_magic(source, map_magic, "photon map file");
    if (st)
        return st;
    h.kind = (pm_map_kind)pm_reader_u32(reader);
    take_digest(reader, &h.scene);
    take_digest(reader, &h.family);
    h.paths = pm_reader_u64(reader);
    h.flux_scale = pm_reader_f64(reader);
    h.world_scale = pm_reader_f64(reader);
    h.world_center.x = pm_reader_f64(reader);
    h.world_center.y = pm_reader_f64(reader);
    h.world_center.z = pm_reader_f64(reader);
    h.seed = pm_reader_u64(reader);
    h.storage_probability = pm_reader_f64(reader);
    h.emitted = take_rgb(reader);
    const uint8_t *note = pm_reader_take(reader, NOTE_BYTES);
    if (note)
        memcpy(h.note, note, NOTE_BYTES);
    *count = pm_reader_u64(reader);
    if (!checksum_holds(source, 0) || !header_makes_sense(&h, *count))
        return damaged(source, "header");
    *out = h;
    return PM_OK;
}

/* Bytes that `count` photons and their checksums take. */
static uint64_t photons_size(uint64_t count)
{
    uint64_t parts = count / PART_PHOTONS + (count % PART_PHOTONS != 0);
    return count * sizeof(pm_photon) + 4 * parts;
}

/* `count` is bounded by what the file can hold before anything is allocated. */
static pm_status read_photons(struct source *source, uint64_t count, pm_photon_list *out)
{
    pm_reader *reader = &source->reader;
    if (count > PM_MAP_PHOTONS_MAX || photons_size(count) > reader->size - reader->at)
        return damaged(source, "photons");
    pm_status st = pm_photon_list_reserve(out, count, source->err);
    for (size_t first = 0; first < count && !st; first += PART_PHOTONS) {
        size_t start = reader->at, part = part_size(first, (size_t)count);
        const uint8_t *bytes = pm_reader_take(reader, part * sizeof(pm_photon));
        if (!bytes || !checksum_holds(source, start))
            return damaged(source, "photons");
        memcpy(out->photons + first, bytes, part * sizeof(pm_photon));
        out->count += part;
    }
    return st;
}

static bool in_order(const pm_photon *photons, size_t count)
{
    for (size_t i = 1; i < count; i++)
        if (pm_photon_order(&photons[i - 1], &photons[i]) > 0)
            return false;
    return true;
}

static pm_status read_trailer(struct source *source, char **command)
{
    pm_reader *reader = &source->reader;
    const uint8_t *end = pm_reader_take(reader, sizeof end_magic);
    if (!end || memcmp(end, end_magic, sizeof end_magic))
        return damaged(source, "end");
    size_t start = reader->at;
    uint32_t length = pm_reader_u32(reader);
    const uint8_t *text = length <= COMMAND_MAX ? pm_reader_take(reader, length) : NULL;
    if (!text || !checksum_holds(source, start) || reader->at != reader->size)
        return damaged(source, "end");
    if (!command)
        return PM_OK;
    char *copy = calloc(1, (size_t)length + 1);
    if (!copy)
        return pm_error_set(source->err, PM_E_MEMORY, "no memory");
    memcpy(copy, text, length);
    *command = copy;
    return PM_OK;
}

pm_status pm_photon_map_read(const void *data, size_t size, const char *name,
                             pm_photon_map **out, char **command, pm_error *err)
{
    struct source source = {{.data = data, .size = size}, name, err};
    pm_map_header header;
    uint64_t count;
    pm_photon_list list = {0};
    char *text = NULL;
    pm_status st = read_map_header(&source, &header, &count);
    if (!st)
        st = read_photons(&source, count, &list);
    if (!st && !in_order(list.photons, list.count))
        st = damaged(&source, "order of photons");
    if (!st)
        st = read_trailer(&source, &text);
    if (!st)
        st = pm_photon_map_wrap(&header, &list, NULL, out, err);
    if (!st && command)
        *command = text;
    else
        free(text);
    pm_photon_list_clear(&list);
    return st;
}

/* Path ends never fall, and the last one is the number of photons. */
static bool ends_make_sense(const pm_batch *batch)
{
    uint32_t before = 0;
    for (uint32_t i = 0; i < batch->paths; i++) {
        if (batch->ends[i] < before)
            return false;
        before = batch->ends[i];
    }
    return before == batch->count;
}

static pm_status read_ends(struct source *source, pm_batch *batch)
{
    pm_reader *reader = &source->reader;
    size_t start = reader->at, size = batch->paths * sizeof *batch->ends;
    const uint8_t *bytes = pm_reader_take(reader, size);
    if (!bytes || !checksum_holds(source, start))
        return damaged(source, "path ends");
    batch->ends = malloc(size + 1);
    if (!batch->ends)
        return pm_error_set(source->err, PM_E_MEMORY, "no memory for a batch");
    memcpy(batch->ends, bytes, size);
    return ends_make_sense(batch) ? PM_OK : damaged(source, "path ends");
}

static pm_status read_batch_header(struct source *source, pm_batch *batch)
{
    pm_reader *reader = &source->reader;
    pm_status st = check_magic(source, batch_magic, "batch of photons");
    if (st)
        return st;
    batch->kind = (pm_map_kind)pm_reader_u32(reader);
    batch->index = pm_reader_u64(reader);
    batch->paths = pm_reader_u32(reader);
    uint64_t count = pm_reader_u64(reader);
    batch->emitted = take_rgb(reader);
    batch->absorbed = take_rgb(reader);
    batch->escaped = take_rgb(reader);
    if (!checksum_holds(source, 0) || (unsigned)batch->kind >= PM_MAP_KINDS ||
        batch->paths > PM_BATCH_PATHS || count > UINT32_MAX || !pm_rgb_finite(batch->emitted) ||
        !pm_rgb_finite(batch->absorbed) || !pm_rgb_finite(batch->escaped))
        return damaged(source, "header");
    batch->count = (size_t)count;
    return PM_OK;
}

pm_status pm_batch_read(const void *data, size_t size, pm_batch *out, pm_error *err)
{
    struct source source = {{.data = data, .size = size}, "batch", err};
    pm_batch batch = {0};
    pm_photon_list list = {0};
    pm_status st = read_batch_header(&source, &batch);
    if (!st)
        st = read_ends(&source, &batch);
    if (!st)
        st = read_photons(&source, batch.count, &list);
    batch.photons = list.photons;
    if (!st && source.reader.at != source.reader.size)
        st = damaged(&source, "end");
    if (st)
        pm_batch_clear(&batch);
    else
        *out = batch;
    return st;
}
