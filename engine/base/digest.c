#include "base/digest.h"

#include <stdlib.h>
#include <string.h>

/* The calls below are old ones, which libcrypto keeps. The new ones look the algorithm up by
 * its name each time: a microsecond, and an octree has millions of small nodes. */
#define OPENSSL_API_COMPAT 10100
#include <openssl/sha.h>

struct pm_hasher {
    SHA256_CTX context;
};

/* With room for its state on the stack none of SHA-256's calls can fail. */
pm_digest pm_digest_of(const void *data, size_t size)
{
    SHA256_CTX context;
    pm_digest digest;
    SHA256_Init(&context);
    SHA256_Update(&context, data, size);
    SHA256_Final(digest.bytes, &context);
    return digest;
}

int pm_digest_compare(const pm_digest *a, const pm_digest *b)
{
    return memcmp(a->bytes, b->bytes, sizeof a->bytes);
}

bool pm_digest_equal(const pm_digest *a, const pm_digest *b)
{
    return pm_digest_compare(a, b) == 0;
}

void pm_digest_hex(const pm_digest *digest, char out[PM_DIGEST_HEX])
{
    static const char digits[] = "0123456789abcdef";
    for (size_t i = 0; i < sizeof digest->bytes; i++) {
        out[2 * i] = digits[digest->bytes[i] >> 4];
        out[2 * i + 1] = digits[digest->bytes[i] & 15];
    }
    out[PM_DIGEST_HEX - 1] = '\0';
}

static int digit_value(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

bool pm_digest_parse(const char *hex, pm_digest *out)
{
    pm_digest digest;
    if (strlen(hex) != PM_DIGEST_HEX - 1)
        return false;
    for (size_t i = 0; i < sizeof digest.bytes; i++) {
        int high = digit_value(hex[2 * i]), low = digit_value(hex[2 * i + 1]);
        if (high < 0 || low < 0)
            return false;
        digest.bytes[i] = (uint8_t)(high << 4 | low);
    }
    *out = digest;
    return true;
}

pm_hasher *pm_hasher_new(void)
{
    pm_hasher *hasher = malloc(sizeof *hasher);
    if (hasher)
        SHA256_Init(&hasher->context);
    return hasher;
}

void pm_hasher_add(pm_hasher *hasher, const void *data, size_t size)
{
    SHA256_Update(&hasher->context, data, size);
}

pm_digest pm_hasher_finish(pm_hasher *hasher)
{
    pm_digest digest;
    SHA256_Final(digest.bytes, &hasher->context);
    SHA256_Init(&hasher->context);
    return digest;
}

void pm_hasher_free(pm_hasher *hasher)
{
    free(hasher);
}
