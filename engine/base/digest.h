#ifndef PM_BASE_DIGEST_H
#define PM_BASE_DIGEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* SHA-256 (FIPS 180-4, by libcrypto). `sha256sum` gives the same. */
typedef struct pm_digest {
    uint8_t bytes[32];
} pm_digest;

enum { PM_DIGEST_HEX = 65 }; /* 64 hexadecimal digits and the terminator */

pm_digest pm_digest_of(const void *data, size_t size);
int pm_digest_compare(const pm_digest *a, const pm_digest *b); /* as memcmp; for qsort */
bool pm_digest_equal(const pm_digest *a, const pm_digest *b);
void pm_digest_hex(const pm_digest *digest, char out[PM_DIGEST_HEX]);
/* True and *out if `hex` starts with 64 lower-case hexadecimal digits followed by its end. */
bool pm_digest_parse(const char *hex, pm_digest *out);

/* A digest over data that comes in pieces. Free with pm_hasher_free in any case. */
typedef struct pm_hasher pm_hasher;
pm_hasher *pm_hasher_new(void); /* NULL if memory is short */
void pm_hasher_add(pm_hasher *hasher, const void *data, size_t size);
pm_digest pm_hasher_finish(pm_hasher *hasher); /* resets it for the next */
void pm_hasher_free(pm_hasher *hasher);

#endif
