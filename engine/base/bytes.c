#include "base/bytes.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void pm_bytes_clear(pm_bytes *bytes)
{
    free(bytes->data);
    *bytes = (pm_bytes){0};
}

pm_status pm_bytes_status(const pm_bytes *bytes)
{
    return bytes->failed ? PM_E_MEMORY : PM_OK;
}

static uint8_t *grow(pm_bytes *bytes, size_t size)
{
    if (bytes->failed || size > SIZE_MAX / 2 - bytes->size) {
        bytes->failed = true;
        return NULL;
    }
    if (bytes->size + size > bytes->capacity) {
        size_t capacity = bytes->capacity ? bytes->capacity : 256;
        while (capacity < bytes->size + size)
            capacity *= 2;
        uint8_t *data = realloc(bytes->data, capacity);
        if (!data) {
            bytes->failed = true;
            return NULL;
        }
        bytes->data = data;
        bytes->capacity = capacity;
    }
    uint8_t *at = bytes->data + bytes->size;
    bytes->size += size;
    return at;
}

void pm_bytes_append(pm_bytes *bytes, const void *data, size_t size)
{
    uint8_t *at = grow(bytes, size);
    if (at && size)
        memcpy(at, data, size);
}

void pm_bytes_text(pm_bytes *bytes, const char *text)
{
    pm_bytes_append(bytes, text, strlen(text));
}

void pm_bytes_format(pm_bytes *bytes, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    int length = vsnprintf(NULL, 0, format, args);
    va_end(args);
    uint8_t *at = length < 0 ? NULL : grow(bytes, (size_t)length + 1);
    if (at) {
        vsnprintf((char *)at, (size_t)length + 1, format, again);
        bytes->size--;
    }
    va_end(again);
}

static void append_little_endian(pm_bytes *bytes, uint64_t value, size_t size)
{
    uint8_t *at = grow(bytes, size);
    for (size_t i = 0; at && i < size; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

void pm_bytes_u8(pm_bytes *bytes, uint8_t value)
{
    append_little_endian(bytes, value, 1);
}

void pm_bytes_u32(pm_bytes *bytes, uint32_t value)
{
    append_little_endian(bytes, value, 4);
}

void pm_bytes_u64(pm_bytes *bytes, uint64_t value)
{
    append_little_endian(bytes, value, 8);
}

void pm_bytes_f64(pm_bytes *bytes, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    append_little_endian(bytes, bits, 8);
}

const uint8_t *pm_reader_take(pm_reader *reader, size_t size)
{
    if (reader->failed || size > reader->size - reader->at) {
        reader->failed = true;
        return NULL;
    }
    const uint8_t *at = reader->data + reader->at;
    reader->at += size;
    return at;
}

static uint64_t take_little_endian(pm_reader *reader, size_t size)
{
    const uint8_t *at = pm_reader_take(reader, size);
    uint64_t value = 0;
    for (size_t i = 0; at && i < size; i++)
        value |= (uint64_t)at[i] << (8 * i);
    return value;
}

uint8_t pm_reader_u8(pm_reader *reader)
{
    return (uint8_t)take_little_endian(reader, 1);
}

uint32_t pm_reader_u32(pm_reader *reader)
{
    return (uint32_t)take_little_endian(reader, 4);
}

uint64_t pm_reader_u64(pm_reader *reader)
{
    return take_little_endian(reader, 8);
}

double pm_reader_f64(pm_reader *reader)
{
    uint64_t bits = take_little_endian(reader, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
