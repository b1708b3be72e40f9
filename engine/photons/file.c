#include "photons/file.h"

#include <string.h>

#include "base/crc.h"

/* ---- writing ---- */

void pm_put_checksum(pm_bytes *out, size_t start)
{
    if (!out->failed)
        pm_bytes_u32(out, pm_crc32c(out->data + start, out->size - start));
}

void pm_put_rgb(pm_bytes *out, pm_rgb c)
{
    pm_bytes_f64(out, c.r);
    pm_bytes_f64(out, c.g);
    pm_bytes_f64(out, c.b);
}

size_t pm_section_open(pm_bytes *out)
{
    size_t start = out->size;
    pm_bytes_u32(out, 0);
    return start;
}

void pm_section_close(pm_bytes *out, size_t start)
{
    if (out->failed)
        return;
    uint32_t length = (uint32_t)(out->size - start - sizeof length);
    memcpy(out->data + start, &length, sizeof length);
    pm_put_checksum(out, start);
}

void pm_put_part(pm_bytes *out, pm_part_coder *coder, const pm_photon *photons, size_t count,
                 const uint8_t *first)
{
    size_t start = pm_section_open(out);
    pm_part_pack(coder, photons, count, first, out);
    pm_section_close(out, start);
}

size_t pm_part_size(uint64_t first, uint64_t count)
{
    return count - first < PM_PART_PHOTONS ? (size_t)(count - first) : PM_PART_PHOTONS;
}

/* ---- reading ---- */

pm_status pm_source_damaged(const pm_source *source, const char *part)
{
    return pm_error_set_at(source->err, PM_E_CORRUPT, source->name, 0, 0,
                           "is damaged or cut short in its %s; make or fetch it again", part);
}

bool pm_source_checked(pm_source *source, size_t start)
{
    pm_reader *reader = &source->reader;
    if (reader->failed)
        return false;
    uint32_t wanted = pm_crc32c(reader->data + start, reader->at - start);
    uint32_t found = pm_reader_u32(reader);
    return !reader->failed && found == wanted;
}

pm_status pm_source_begin(pm_source *source, const char magic[8], const char *what)
{
    const uint8_t *start = pm_reader_take(&source->reader, 8);
    if (!start || memcmp(start, magic, 8))
        return pm_error_set_at(source->err, PM_E_SYNTAX, source->name, 0, 0, "is no %s", what);
    uint32_t version = pm_reader_u32(&source->reader);
    if (source->reader.failed || version == PM_PHOTON_FILE_VERSION)
        return PM_OK;
    return pm_error_set_at(source->err, PM_E_UNSUPPORTED, source->name, 0, 0,
                           version < PM_PHOTON_FILE_VERSION
                               ? "is an older file, of version %u (now %d): make the map again "
                                 "with mkpmap"
                               : "has version %u, this program reads version %d; use a newer "
                                 "program, or make the map again",
                           version, PM_PHOTON_FILE_VERSION);
}

pm_rgb pm_source_rgb(pm_source *source)
{
    pm_rgb c;
    c.r = pm_reader_f64(&source->reader);
    c.g = pm_reader_f64(&source->reader);
    c.b = pm_reader_f64(&source->reader);
    return c;
}

bool pm_source_section(pm_source *source, pm_reader *inner)
{
    pm_reader *reader = &source->reader;
    size_t start = reader->at;
    uint32_t length = pm_reader_u32(reader);
    const uint8_t *bytes = pm_reader_take(reader, length);
    if (!bytes || !pm_source_checked(source, start))
        return false;
    *inner = (pm_reader){.data = bytes, .size = length};
    return true;
}

pm_status pm_source_part(pm_source *source, pm_part_coder *coder, size_t count,
                         const uint8_t *first, pm_photon *out)
{
    pm_reader inner;
    if (pm_source_section(source, &inner) && pm_part_unpack(coder, &inner, count, first, out))
        return PM_OK;
    return pm_source_damaged(source, "photons");
}

bool pm_source_may_hold(const pm_source *source, uint64_t count)
{
    const pm_reader *reader = &source->reader;
    return count <= PM_MAP_PHOTONS_MAX && count * PM_PART_LEAST <= reader->size - reader->at;
}
