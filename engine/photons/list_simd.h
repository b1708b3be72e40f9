#ifndef PM_PHOTONS_LIST_SIMD_H
#define PM_PHOTONS_LIST_SIMD_H

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

/* Lists made from masks without a branch. */

/* Lists first + i for each bit i of the mask; writes 16 numbers, returns how many count. */
static inline size_t list_bits(uint32_t *out, uint32_t first, unsigned mask)
{
    const uint64_t nibbles = 0xFEDCBA9876543210, each = 0x1111111111111111;
    uint64_t set = _pext_u64(nibbles, _pdep_u64(mask, each) * 15);
    const __m256i base = _mm256_set1_epi32((int)first);
    for (int half = 0; half < 2; half++) {
        uint64_t bytes = _pdep_u64(set >> (32 * half), 0x0F0F0F0F0F0F0F0F);
        __m256i wide = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)bytes));
        _mm256_storeu_si256((__m256i *)(void *)(out + 8 * half), _mm256_add_epi32(wide, base));
    }
    return (size_t)__builtin_popcount(mask);
}

#endif
