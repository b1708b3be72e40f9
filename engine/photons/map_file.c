#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "photons/file.h"

/* The bytes of a map:
 *   8           "pmphoton"
 *   4           version
 *   4 4         kind, pass of a sequence
 *   32 32       scene, family
 *   8 8         first path, paths
 *   8 8 24      flux scale, world scale, world center
 *   8 8         seed, storage probability
 *   24          emitted
 *   160         note, filled up with zeros
 *   8           photons
 *   4           CRC-32C of all above
 *   sections    photons in stored order, a part each (part.c)
 *   end         8: "pm-end\0\0"; section: command line as typed: of no digest
 *
 * A file is one map, or the maps of a sequence's passes, whose ends hold no command line, and
 * then an end that does. So a longer sequence starts with the bytes of a shorter one, up to the
 * last end, and each pass is a map by itself. */

enum { COMMAND_MAX = 1 << 20, NOTE_BYTES = 160 };

static const char map_magic[8] = "pmphoton", end_magic[8] = "pm-end";

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are written as they lie");
_Static_assert(sizeof((pm_map_header){0}.note) == NOTE_BYTES, "the note has its place");

/* ---- writing ---- */

static void put_header(pm_bytes *out, const pm_map_header *h, size_t count)
{
    size_t start = out->size;
    char note[NOTE_BYTES] = "";
    memcpy(note, h->note, strnlen(h->note, NOTE_BYTES - 1));
    pm_bytes_append(out, map_magic, sizeof map_magic);
    pm_bytes_u32(out, PM_PHOTON_FILE_VERSION);
    pm_bytes_u32(out, (uint32_t)h->kind);
    pm_bytes_u32(out, h->pass);
    pm_bytes_append(out, h->scene.bytes, sizeof h->scene.bytes);
    pm_bytes_append(out, h->family.bytes, sizeof h->family.bytes);
    pm_bytes_u64(out, h->first_path);
    pm_bytes_u64(out, h->paths);
    pm_bytes_f64(out, h->flux_scale);
    pm_bytes_f64(out, h->world_scale);
    pm_bytes_f64(out, h->world_center.x);
    pm_bytes_f64(out, h->world_center.y);
    pm_bytes_f64(out, h->world_center.z);
    pm_bytes_u64(out, h->seed);
    pm_bytes_f64(out, h->storage_probability);
    pm_put_rgb(out, h->emitted);
    pm_bytes_append(out, note, NOTE_BYTES);
    pm_bytes_u64(out, count);
    pm_put_checksum(out, start);
}

static void put_end(pm_bytes *out, const char *command)
{
    size_t length = command ? strlen(command) : 0;
    pm_bytes_append(out, end_magic, sizeof end_magic);
    size_t start = pm_section_open(out);
    pm_bytes_append(out, command, length < COMMAND_MAX ? length : COMMAND_MAX);
    pm_section_close(out, start);
}

/* Sends what `bytes` holds and empties it. */
static pm_status send(const pm_sink *sink, pm_bytes *bytes, pm_error *err)
{
    pm_status st = pm_bytes_status(bytes);
    if (st)
        return pm_error_set(err, st, "no memory for a file of photons");
    st = sink->put(sink->context, bytes->data, bytes->size, err);
    bytes->size = 0;
    return st;
}

/* Parts at work at a time, each with scratch memory of its own. */
enum { PARTS = 8 };

struct packing {
    const pm_photon_map *map;   /* either photons of a map */
    const pm_photon_list *list; /* or of a list */
    size_t count;
    size_t first; /* photon of this round */
    pm_part_coder *coder[PARTS];
    pm_photon *photons[PARTS]; /* copies, of a map */
    pm_bytes out[PARTS];
};

/* The photons of a part, as they lie or copied. */
static const pm_photon *part_of(const struct packing *p, size_t i, size_t first, size_t count)
{
    if (p->list)
        return p->list->photons + first;
    for (size_t k = 0; k < count; k++)
        pm_photon_map_photon(p->map, first + k, &p->photons[i][k]);
    return p->photons[i];
}

static void pack_part(void *context, size_t i, unsigned thread)
{
    (void)thread;
    struct packing *p = context;
    size_t first = p->first + i * PM_PART_PHOTONS;
    size_t count = pm_part_size(first, p->count);
    pm_put_part(&p->out[i], p->coder[i], part_of(p, i, first, count), count, NULL);
}

static pm_status packing_init(struct packing *p, size_t parts)
{
    for (size_t i = 0; i < parts && i < PARTS; i++) {
        p->coder[i] = pm_part_coder_new();
        if (p->map)
            p->photons[i] = malloc(PM_PART_PHOTONS * sizeof(pm_photon));
        if (!p->coder[i] || (p->map && !p->photons[i]))
            return PM_E_MEMORY;
    }
    return PM_OK;
}

static void packing_clear(struct packing *p)
{
    for (size_t i = 0; i < PARTS; i++) {
        pm_part_coder_free(p->coder[i]);
        free(p->photons[i]);
        pm_bytes_clear(&p->out[i]);
    }
}

static pm_status send_photons(struct packing *p, pm_pool *pool, const pm_sink *sink,
                              pm_error *err)
{
    size_t parts = (p->count + PM_PART_PHOTONS - 1) / PM_PART_PHOTONS;
    pm_status st = packing_init(p, parts);
    if (st)
        pm_error_set(err, st, "no memory for a file of photons");
    for (size_t part = 0; part < parts && !st; part += PARTS) {
        size_t count = parts - part < PARTS ? parts - part : PARTS;
        p->first = part * PM_PART_PHOTONS;
        pm_photons_run(pool, count, pack_part, p);
        for (size_t i = 0; i < count && !st; i++)
            st = send(sink, &p->out[i], err);
    }
    packing_clear(p);
    return st;
}

static pm_status send_map(const pm_map_header *header, struct packing *p, const char *command,
                          pm_pool *pool, const pm_sink *sink, pm_error *err)
{
    pm_bytes bytes = {0};
    put_header(&bytes, header, p->count);
    pm_status st = send(sink, &bytes, err);
    if (!st)
        st = send_photons(p, pool, sink, err);
    put_end(&bytes, command);
    if (!st)
        st = send(sink, &bytes, err);
    pm_bytes_clear(&bytes);
    return st;
}

pm_status pm_photon_map_stream(const pm_photon_map *map, const char *command, pm_pool *pool,
                               const pm_sink *sink, pm_error *err)
{
    struct packing p = {.map = map, .count = map->count};
    return send_map(&map->header, &p, command, pool, sink, err);
}

pm_status pm_photon_list_stream(const pm_map_header *header, pm_photon_list *list,
                                const char *command, pm_pool *pool, const pm_sink *sink,
                                pm_error *err)
{
    struct packing p = {.list = list, .count = list->count};
    pm_photons_sort(list->photons, list->count, pool);
    return send_map(header, &p, command, pool, sink, err);
}

pm_status pm_sequence_end(const char *command, const pm_sink *sink, pm_error *err)
{
    pm_bytes bytes = {0};
    put_end(&bytes, command);
    pm_status st = send(sink, &bytes, err);
    pm_bytes_clear(&bytes);
    return st;
}

static pm_status append(void *context, const void *data, size_t size, pm_error *err)
{
    (void)err;
    pm_bytes *bytes = context;
    pm_bytes_append(bytes, data, size);
    return pm_bytes_status(bytes);
}

pm_status pm_photon_map_write(const pm_photon_map *map, const char *command, pm_bytes *out,
                              pm_error *err)
{
    pm_bytes bytes = {0};
    const pm_sink sink = {&bytes, append};
    pm_status st = pm_photon_map_stream(map, command, NULL, &sink, err);
    if (!st)
        *out = bytes;
    else
        pm_bytes_clear(&bytes);
    return st == PM_E_MEMORY ? pm_error_set(err, st, "no memory for a file of photons") : st;
}

/* ---- reading ---- */

static void take_digest(pm_reader *reader, pm_digest *out)
{
    const uint8_t *bytes = pm_reader_take(reader, sizeof out->bytes);
    if (bytes)
        memcpy(out->bytes, bytes, sizeof out->bytes);
}

static bool header_makes_sense(const pm_map_header *h)
{
    bool known = (unsigned)h->kind < PM_MAP_KINDS || h->kind == PM_MAP_PRECOMPUTED;
    return known && h->paths > 0 && isfinite(h->flux_scale) && h->flux_scale >= 0 &&
           isfinite(h->world_scale) && h->world_scale > 0 && pm_vec3_finite(h->world_center) &&
           h->storage_probability > 0 && h->storage_probability <= 1 &&
           pm_rgb_finite(h->emitted) && memchr(h->note, 0, NOTE_BYTES);
}

static pm_status read_header(pm_source *source, pm_map_header *out, uint64_t *count)
{
    pm_reader *reader = &source->reader;
    size_t start = reader->at;
    pm_map_header h = {0};
    pm_status st = pm_source_begin(source, map_magic, "photon map file");
    if (st)
        return st;
    h.kind = (pm_map_kind)pm_reader_u32(reader);
    h.pass = pm_reader_u32(reader);
    take_digest(reader, &h.scene);
    take_digest(reader, &h.family);
    h.first_path = pm_reader_u64(reader);
    h.paths = pm_reader_u64(reader);
    h.flux_scale = pm_reader_f64(reader);
    h.world_scale = pm_reader_f64(reader);
    h.world_center.x = pm_reader_f64(reader);
    h.world_center.y = pm_reader_f64(reader);
    h.world_center.z = pm_reader_f64(reader);
    h.seed = pm_reader_u64(reader);
    h.storage_probability = pm_reader_f64(reader);
    h.emitted = pm_source_rgb(source);
    const uint8_t *note = pm_reader_take(reader, NOTE_BYTES);
    if (note)
        memcpy(h.note, note, NOTE_BYTES);
    *count = pm_reader_u64(reader);
    if (!pm_source_checked(source, start) || !header_makes_sense(&h))
        return pm_source_damaged(source, "header");
    if (!pm_source_may_hold(source, *count))
        return pm_source_damaged(source, "photons");
    *out = h;
    return PM_OK;
}

pm_status pm_map_file_header(const void *data, size_t size, const char *name,
                             pm_map_header *out, pm_error *err)
{
    pm_source source = {{.data = data, .size = size}, name, err};
    uint64_t count;
    return read_header(&source, out, &count);
}

/* The command line is whole or NULL. */
static pm_status read_end(pm_source *source, char **command)
{
    pm_reader inner;
    const uint8_t *end = pm_reader_take(&source->reader, sizeof end_magic);
    if (!end || memcmp(end, end_magic, sizeof end_magic) ||
        !pm_source_section(source, &inner) || inner.size > COMMAND_MAX)
        return pm_source_damaged(source, "end");
    free(*command);
    *command = calloc(1, inner.size + 1);
    if (!*command)
        return pm_error_set(source->err, PM_E_MEMORY, "no memory");
    memcpy(*command, inner.data, inner.size);
    return PM_OK;
}

struct visit {
    pm_source source;
    const pm_map_visitor *visitor;
    pm_part_coder *coder;
    pm_photon *part; /* [1 + PM_PART_PHOTONS]; [0]: the last one of the part before */
    char *command;
};

static bool in_order(const pm_photon *photons, size_t count)
{
    for (size_t i = 1; i < count; i++)
        if (pm_photon_order(&photons[i - 1], &photons[i]) > 0)
            return false;
    return true;
}

static pm_status visit_part(struct visit *v, size_t count, bool first)
{
    pm_photon *photons = v->part + 1;
    pm_status st = pm_source_part(&v->source, v->coder, count, NULL, photons);
    if (st)
        return st;
    if (!(first ? in_order(photons, count) : in_order(v->part, count + 1)))
        return pm_source_damaged(&v->source, "order of photons");
    v->part[0] = photons[count - 1];
    return v->visitor->photons
               ? v->visitor->photons(v->visitor->context, photons, count, v->source.err)
               : PM_OK;
}

static pm_status visit_map(struct visit *v)
{
    pm_map_header header;
    uint64_t count;
    pm_status st = read_header(&v->source, &header, &count);
    if (!st && v->visitor->begin)
        st = v->visitor->begin(v->visitor->context, &header, count, v->source.err);
    for (uint64_t first = 0; first < count && !st; first += PM_PART_PHOTONS)
        st = visit_part(v, pm_part_size(first, count), first == 0);
    return st ? st : read_end(&v->source, &v->command);
}

static bool at_map(const pm_source *source)
{
    const pm_reader *reader = &source->reader;
    return !reader->failed && reader->size - reader->at >= sizeof map_magic &&
           !memcmp(reader->data + reader->at, map_magic, sizeof map_magic);
}

static pm_status visit_all(struct visit *v)
{
    const pm_reader *reader = &v->source.reader;
    pm_status st = visit_map(v);
    if (st || reader->at == reader->size)
        return st;
    while (!st && at_map(&v->source))
        st = visit_map(v);
    if (!st)
        st = read_end(&v->source, &v->command);
    if (!st && reader->at != reader->size)
        st = pm_source_damaged(&v->source, "end");
    return st;
}

pm_status pm_map_file_visit(const void *data, size_t size, const char *name,
                            const pm_map_visitor *visitor, char **command, pm_error *err)
{
    struct visit v = {{{.data = data, .size = size}, name, err}, visitor, NULL, NULL, NULL};
    v.coder = pm_part_coder_new();
    v.part = malloc((1 + PM_PART_PHOTONS) * sizeof *v.part);
    pm_status st = v.coder && v.part
                       ? visit_all(&v)
                       : pm_error_set(err, PM_E_MEMORY, "no memory to read %s", name);
    if (!st && command)
        *command = v.command;
    else
        free(v.command);
    pm_part_coder_free(v.coder);
    free(v.part);
    return st;
}

/* ---- a map again ---- */

struct reading {
    const char *name;
    uint64_t total;       /* photons that the headers speak of */
    pm_map_header header; /* of the first pass, with the paths of all */
    pm_photon_list list;
    uint32_t maps;
};

/* The photons of all maps in the file, from the headers alone. A damaged file gives any number
 * that could be in it. */
static uint64_t count_photons(const void *data, size_t size)
{
    pm_source source = {{.data = data, .size = size}, "", NULL};
    uint64_t total = 0;
    while (at_map(&source)) {
        pm_map_header header;
        uint64_t count;
        if (read_header(&source, &header, &count))
            break;
        total += count;
        for (uint64_t first = 0; first < count; first += PM_PART_PHOTONS)
            pm_reader_take(&source.reader, pm_reader_u32(&source.reader) + sizeof(uint32_t));
        pm_reader_take(&source.reader, sizeof end_magic);
        pm_reader_take(&source.reader, pm_reader_u32(&source.reader) + sizeof(uint32_t));
    }
    return total;
}

static bool same_family(const pm_map_header *a, const pm_map_header *b)
{
    return a->kind == b->kind && pm_digest_equal(&a->family, &b->family) &&
           pm_digest_equal(&a->scene, &b->scene) && a->flux_scale == b->flux_scale &&
           a->world_scale == b->world_scale && a->storage_probability == b->storage_probability;
}

static pm_status begin_reading(void *context, const pm_map_header *header, uint64_t count,
                               pm_error *err)
{
    (void)count; /* is in the total */
    struct reading *r = context;
    if (!r->maps++) {
        r->header = *header;
    } else if (!same_family(&r->header, header)) {
        return pm_error_set_at(err, PM_E_MISMATCH, r->name, 0, 0,
                               "holds passes of several families; make it again");
    } else {
        r->header.paths += header->paths;
    }
    return r->maps == 1 ? pm_photon_list_reserve(&r->list, r->total, err) : PM_OK;
}

static pm_status read_photons(void *context, const pm_photon *photons, size_t count,
                              pm_error *err)
{
    struct reading *r = context;
    return pm_photon_list_append(&r->list, photons, count, err);
}

pm_status pm_photon_map_read(const void *data, size_t size, const char *name,
                             pm_photon_map **out, char **command, pm_error *err)
{
    struct reading r = {.name = name, .total = count_photons(data, size)};
    const pm_map_visitor visitor = {&r, begin_reading, read_photons};
    char *text = NULL;
    pm_status st = pm_map_file_visit(data, size, name, &visitor, &text, err);
    if (!st && r.maps > 1)
        st = pm_photon_map_take(&r.header, &r.list, NULL, out, err);
    else if (!st)
        st = pm_photon_map_wrap(&r.header, &r.list, NULL, out, err);
    if (!st && command)
        *command = text;
    else
        free(text);
    pm_photon_list_clear(&r.list);
    return st;
}
