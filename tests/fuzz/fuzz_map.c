/* Reads the input as a photon map and as a batch; what was read must come back from a file
 * written of it. Checksums keep most inputs out: see fuzz_part.c for what stands behind them.
 */
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

static void check_map(const uint8_t *data, size_t size)
{
    pm_error err = PM_ERROR_INIT;
    pm_photon_map *map = NULL, *again = NULL;
    char *command = NULL;
    pm_bytes written = {0}, second = {0};
    if (pm_photon_map_read(data, size, "fuzz", &map, &command, &err)) {
        check(err.status && err.text[0] && !map && !command);
        return;
    }
    const pm_vec3 up = {0, 0, 1};
    pm_estimate e = pm_photon_map_nearest(map, up, up, 3, INFINITY, PM_PHOTONS_ALL, NULL);
    check(e.count <= 3);
    check(!pm_photon_map_write(map, command, &written, NULL));
    check(!pm_photon_map_read(written.data, written.size, "again", &again, NULL, &err));
    check(!pm_photon_map_write(again, command, &second, NULL));
    check(written.size == second.size && !memcmp(written.data, second.data, second.size));
    pm_bytes_clear(&written);
    pm_bytes_clear(&second);
    pm_photon_map_free(map);
    pm_photon_map_free(again);
    free(command);
}

static void check_batch(const uint8_t *data, size_t size)
{
    pm_error err = PM_ERROR_INIT;
    pm_batch batch = {0}, again = {0};
    pm_bytes written = {0};
    if (pm_batch_read(data, size, &batch, &err)) {
        check(err.status && err.text[0] && !batch.photons && !batch.ends);
        return;
    }
    check(!pm_batch_write(&batch, &written, NULL));
    check(!pm_batch_read(written.data, written.size, &again, NULL));
    check(again.count == batch.count && again.paths == batch.paths);
    check(!memcmp(again.photons, batch.photons, batch.count * sizeof *batch.photons));
    check(!memcmp(again.ends, batch.ends, batch.paths * sizeof *batch.ends));
    pm_bytes_clear(&written);
    pm_batch_clear(&batch);
    pm_batch_clear(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check_map(data, size);
    check_batch(data, size);
    return 0;
}
