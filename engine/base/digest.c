#include "base/digest.h"

#include <stdlib.h>
#include <string.h>

#include <openssl/evp.h>
#include <openssl/sha.h>

struct pm_hasher {
    EVP_MD_CTX *context;
};

pm_digest pm_digest_of(const void *data, size_t size)
{
    pm_digest digest;
    SHA256(data, size, digest.bytes);
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

static bool start(pm_hasher *hasher)
{
    return EVP_DigestInit_ex(hasher->context, EVP_sha256(), NULL) == 1;
}

pm_hasher *pm_hasher_new(void)
{
    pm_hasher *hasher = malloc(sizeof *hasher);
    if (!hasher)
        return NULL;
    hasher->context = EVP_MD_CTX_new();
    if (!hasher->context || !start(hasher)) {
        pm_hasher_free(hasher);
        return NULL;
    }
    return hasher;
}

/* With a started SHA-256 context the calls below cannot fail (they allocate nothing). */
void pm_hasher_add(pm_hasher *hasher, const void *data, size_t size)
{
    EVP_DigestUpdate(hasher->context, data, size);
}

pm_digest pm_hasher_finish(pm_hasher *hasher)
{
    pm_digest digest = {0};
    EVP_DigestFinal_ex(hasher->context, digest.bytes, NULL);
    start(hasher);
    return digest;
}

void pm_hasher_free(pm_hasher *hasher)
{
    if (!hasher)
        return;
    EVP_MD_CTX_free(hasher->context);
    free(hasher);
}
