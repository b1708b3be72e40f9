/* Reads the input as a photon map and as a batch; what was read must be written as it was. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "photons/photon_map.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_same(pm_bytes *written, const uint8_t *data, size_t size)
{
    check(written->size == size && memcmp(written->data, data, size) == 0);
    pm_bytes_clear(written);
}

static void check_map(const uint8_t *data, size_t size)
{
    pm_error err = PM_ERROR_INIT;
    pm_photon_map *map = NULL;
    char *command = NULL;
    pm_bytes written = {0};
    if (pm_photon_map_read(data, size, "fuzz", &map, &command, &err)) {
        check(err.status && err.text[0] && !map && !command);
        return;
    }
    const pm_vec3 up = {0, 0, 1};
    pm_estimate e = pm_photon_map_nearest(map, up, up, 3, INFINITY, PM_PHOTONS_ALL, NULL);
    check(e.count <= 3);
    check(!pm_photon_map_write(map, command, &written, NULL));
    check(written.size <= size); /* less if the command line holds a zero byte */
    if (written.size < size)
        pm_bytes_clear(&written);
    else
        check_same(&written, data, size);
    pm_photon_map_free(map);
    free(command);
}

static void check_batch(const uint8_t *data, size_t size)
{
    pm_error err = PM_ERROR_INIT;
    pm_batch batch = {0};
    pm_bytes written = {0};
    if (pm_batch_read(data, size, &batch, &err)) {
        check(err.status && err.text[0] && !batch.photons && !batch.ends);
        return;
    }
    check(!pm_batch_write(&batch, &written, NULL));
    check_same(&written, data, size);
    pm_batch_clear(&batch);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check_map(data, size);
    check_batch(data, size);
    return 0;
}
