#include "base/crc.h"

#include <immintrin.h>
#include <string.h>

uint32_t pm_crc32c(const void *data, size_t size)
{
    const unsigned char *at = data;
    uint64_t crc = 0xffffffff;
    for (; size >= 8; at += 8, size -= 8) {
        uint64_t word;
        memcpy(&word, at, 8);
        crc = _mm_crc32_u64(crc, word);
    }
    for (; size; at++, size--)
        crc = _mm_crc32_u8((uint32_t)crc, *at);
    return (uint32_t)crc ^ 0xffffffff;
}
