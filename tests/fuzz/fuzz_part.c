/* Unpacks the input as a part of a file of photons and as numbers, without the checksums that
 * stand before them in files. The first two bytes say how many there are, the third how they
 * are packed. What was unpacked must come back from what is packed of it. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "photons/part.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_photons(pm_part_coder *coder, pm_reader reader, size_t count, bool in_order)
{
    uint8_t *marks = calloc(count + 1, 1); /* paths of two photons */
    for (size_t i = 0; i < count; i += 2)
        marks[i] = 1;
    const uint8_t *first = in_order ? NULL : marks;
    pm_photon *photons = malloc(count * sizeof *photons + 1);
    pm_photon *again = malloc(count * sizeof *again + 1);
    pm_bytes packed = {0};
    if (pm_part_unpack(coder, &reader, count, first, photons)) {
        pm_part_pack(coder, photons, count, first, &packed);
        check(packed.size >= PM_PART_LEAST * count);
        pm_reader second = {.data = packed.data, .size = packed.size};
        check(pm_part_unpack(coder, &second, count, first, again));
        check(!memcmp(photons, again, count * sizeof *photons));
    }
    pm_bytes_clear(&packed);
    free(photons);
    free(again);
    free(marks);
}

static void check_numbers(pm_part_coder *coder, pm_reader reader, size_t count)
{
    uint32_t *numbers = malloc(count * sizeof *numbers + 1);
    (void)pm_part_unpack_numbers(coder, &reader, count, numbers);
    free(numbers);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 3)
        return 0;
    size_t count = data[0] | (size_t)data[1] << 8;
    pm_part_coder *coder = pm_part_coder_new();
    check(coder);
    const pm_reader reader = {.data = data + 3, .size = size - 3};
    if (data[2] & 2)
        check_numbers(coder, reader, count);
    else
        check_photons(coder, reader, count, data[2] & 1);
    pm_part_coder_free(coder);
    return 0;
}
