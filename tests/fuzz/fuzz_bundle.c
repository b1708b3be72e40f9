/* Reads the input as a bundle's tar; what was read must survive writing and reading again. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "scene/bundle.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_again(const pm_bundle *bundle, const pm_bytes *tar)
{
    pm_bundle *again = NULL;
    check(!pm_bundle_read_tar(tar->data, tar->size, 1 << 24, &again, NULL));
    check(pm_bundle_count(again) == pm_bundle_count(bundle));
    for (size_t i = 0; i < pm_bundle_count(bundle); i++) {
        const pm_file *a = pm_bundle_at(bundle, i), *b = pm_bundle_at(again, i);
        check(strcmp(a->name, b->name) == 0 && a->size == b->size);
        check(memcmp(a->data, b->data, a->size) == 0);
        check(pm_bundle_find(bundle, a->name, NULL) == a);
    }
    pm_bundle_free(again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pm_error err = PM_ERROR_INIT;
    pm_bundle *bundle = NULL;
    pm_bytes tar = {0};
    if (pm_bundle_read_tar(data, size, 1 << 20, &bundle, &err))
        check(err.status && err.text[0]);
    else if (!pm_bundle_write_tar(bundle, &tar, NULL)) /* ustar has shorter names than pax */
        check_again(bundle, &tar);
    pm_bytes_clear(&tar);
    pm_bundle_free(bundle);
    return 0;
}
