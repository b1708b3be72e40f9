#ifndef PM_BASE_CRC_H
#define PM_BASE_CRC_H

#include <stddef.h>
#include <stdint.h>

/* CRC-32C (Castagnoli polynomial, RFC 3720 B.4), by the instruction that every x86-64-v3 has.
 * Test: test_crc.c. */
uint32_t pm_crc32c(const void *data, size_t size);

#endif
