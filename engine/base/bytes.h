#ifndef PM_BASE_BYTES_H
#define PM_BASE_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* A growable byte string, and little-endian numbers in it. Zero-initialised storage is empty.
 * The first failed growth sets `failed`; later appends do nothing, so a writer checks once at
 * the end with pm_bytes_status. */
typedef struct pm_bytes {
    uint8_t *data;
    size_t size, capacity;
    bool failed;
} pm_bytes;

void pm_bytes_clear(pm_bytes *bytes);
pm_status pm_bytes_status(const pm_bytes *bytes);
void pm_bytes_append(pm_bytes *bytes, const void *data, size_t size);
void pm_bytes_text(pm_bytes *bytes, const char *text);
void pm_bytes_format(pm_bytes *bytes, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void pm_bytes_u8(pm_bytes *bytes, uint8_t value);
void pm_bytes_u32(pm_bytes *bytes, uint32_t value);
void pm_bytes_u64(pm_bytes *bytes, uint64_t value);
void pm_bytes_f64(pm_bytes *bytes, double value);

/* Reads from a byte string of known size. Reading past the end sets `failed` and gives zeros,
 * so a reader checks once after each group of fields. */
typedef struct pm_reader {
    const uint8_t *data;
    size_t size, at;
    bool failed;
} pm_reader;

/* The next `size` bytes in place, or NULL past the end. */
const uint8_t *pm_reader_take(pm_reader *reader, size_t size);
uint8_t pm_reader_u8(pm_reader *reader);
uint32_t pm_reader_u32(pm_reader *reader);
uint64_t pm_reader_u64(pm_reader *reader);
double pm_reader_f64(pm_reader *reader);

#endif
