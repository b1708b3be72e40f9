#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "photons/file.h"

/* The bytes of a batch:
 *   8           "pmbatch\0"
 *   4           version
 *   4           kind
 *   8           index
 *   4           paths
 *   8           photons
 *   72          emitted, absorbed, escaped
 *   4           CRC-32C of all above
 *   section     how many photons each path left (part.c)
 *   sections    photons in path order, a part each (part.c) */

static const char magic[8] = "pmbatch";

static void put_header(pm_bytes *out, const pm_batch *batch)
{
    size_t start = out->size;
    pm_bytes_append(out, magic, sizeof magic);
    pm_bytes_u32(out, PM_PHOTON_FILE_VERSION);
    pm_bytes_u32(out, (uint32_t)batch->kind);
    pm_bytes_u64(out, batch->index);
    pm_bytes_u32(out, batch->paths);
    pm_bytes_u64(out, batch->count);
    pm_put_rgb(out, batch->emitted);
    pm_put_rgb(out, batch->absorbed);
    pm_put_rgb(out, batch->escaped);
    pm_put_checksum(out, start);
}

/* Ends become counts, and counts ends. */
static void put_ends(pm_bytes *out, pm_part_coder *coder, const pm_batch *batch)
{
    uint32_t counts[PM_BATCH_PATHS], before = 0;
    for (uint32_t i = 0; i < batch->paths; i++) {
        counts[i] = batch->ends[i] - before;
        before = batch->ends[i];
    }
    size_t start = pm_section_open(out);
    pm_part_pack_numbers(coder, counts, batch->paths, out);
    pm_section_close(out, start);
}

/* Marks the first photon of each path; NULL if memory is short. */
static uint8_t *mark_firsts(const pm_batch *batch)
{
    uint8_t *first = calloc(batch->count + 1, 1);
    for (uint32_t i = 0; first && i < batch->paths; i++)
        first[i ? batch->ends[i - 1] : 0] = 1; /* of no photon: the next one's, or the end */
    return first;
}

pm_status pm_batch_write(const pm_batch *batch, pm_bytes *out, pm_error *err)
{
    assert(batch->ends && batch->paths <= PM_BATCH_PATHS);
    pm_bytes bytes = {0};
    pm_part_coder *coder = pm_part_coder_new();
    uint8_t *first_of_path = mark_firsts(batch);
    bytes.failed = !coder || !first_of_path;
    if (!bytes.failed) {
        put_header(&bytes, batch);
        put_ends(&bytes, coder, batch);
        for (size_t first = 0; first < batch->count; first += PM_PART_PHOTONS)
            pm_put_part(&bytes, coder, batch->photons + first,
                        pm_part_size(first, batch->count), first_of_path + first);
    }
    free(first_of_path);
    pm_part_coder_free(coder);
    if (!pm_bytes_status(&bytes)) {
        *out = bytes;
        return PM_OK;
    }
    pm_bytes_clear(&bytes);
    return pm_error_set(err, PM_E_MEMORY, "no memory for a batch of photons");
}

/* ---- reading ---- */

static pm_status read_header(pm_source *source, pm_batch *batch)
{
    pm_reader *reader = &source->reader;
    pm_status st = pm_source_begin(source, magic, "batch of photons");
    if (st)
        return st;
    batch->kind = (pm_map_kind)pm_reader_u32(reader);
    batch->index = pm_reader_u64(reader);
    batch->paths = pm_reader_u32(reader);
    uint64_t count = pm_reader_u64(reader);
    batch->emitted = pm_source_rgb(source);
    batch->absorbed = pm_source_rgb(source);
    batch->escaped = pm_source_rgb(source);
    if (!pm_source_checked(source, 0) || (unsigned)batch->kind >= PM_MAP_KINDS ||
        batch->paths > PM_BATCH_PATHS || !pm_source_may_hold(source, count) ||
        !pm_rgb_finite(batch->emitted) || !pm_rgb_finite(batch->absorbed) ||
        !pm_rgb_finite(batch->escaped))
        return pm_source_damaged(source, "header");
    batch->count = (size_t)count;
    return PM_OK;
}

static bool counts_to_ends(pm_batch *batch)
{
    uint64_t end = 0;
    for (uint32_t i = 0; i < batch->paths; i++) {
        end += batch->ends[i];
        batch->ends[i] = (uint32_t)end;
        if (end > batch->count)
            return false;
    }
    return end == batch->count;
}

static pm_status read_ends(pm_source *source, pm_part_coder *coder, pm_batch *batch)
{
    pm_reader inner;
    if (!pm_source_section(source, &inner) ||
        !pm_part_unpack_numbers(coder, &inner, batch->paths, batch->ends) ||
        !counts_to_ends(batch))
        return pm_source_damaged(source, "path ends");
    return PM_OK;
}

static pm_status read_all(pm_source *source, pm_part_coder *coder, pm_batch *batch)
{
    pm_status st = read_ends(source, coder, batch);
    if (st)
        return st;
    uint8_t *first_of_path = mark_firsts(batch);
    if (!first_of_path)
        return pm_error_set(source->err, PM_E_MEMORY, "no memory for a batch of photons");
    for (size_t first = 0; first < batch->count && !st; first += PM_PART_PHOTONS)
        st = pm_source_part(source, coder, pm_part_size(first, batch->count),
                            first_of_path + first, batch->photons + first);
    free(first_of_path);
    if (!st && source->reader.at != source->reader.size)
        st = pm_source_damaged(source, "end");
    return st;
}

pm_status pm_batch_read(const void *data, size_t size, pm_batch *out, pm_error *err)
{
    pm_source source = {{.data = data, .size = size}, "batch", err};
    pm_batch batch = {0};
    pm_status st = read_header(&source, &batch);
    if (st)
        return st;
    pm_part_coder *coder = pm_part_coder_new();
    batch.ends = malloc(batch.paths * sizeof *batch.ends + 1);
    batch.photons = malloc(batch.count * sizeof *batch.photons + 1);
    if (coder && batch.ends && batch.photons)
        st = read_all(&source, coder, &batch);
    else
        st = pm_error_set(err, PM_E_MEMORY, "no memory for a batch of photons");
    pm_part_coder_free(coder);
    if (st)
        pm_batch_clear(&batch);
    else
        *out = batch;
    return st;
}
