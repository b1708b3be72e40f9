#ifndef PM_PHOTONS_PART_H
#define PM_PHOTONS_PART_H

#include "base/bytes.h"
#include "forward/photon.h"

/* A part of a file of photons: up to PM_PART_PHOTONS of them, packed without loss. part.c alone
 * includes zstd.h; see there for the bytes. */

enum {
    PM_PART_PHOTONS = 65536,
    PM_PART_LEAST = 2, /* bytes that a packed photon takes at least */
};

/* Scratch memory, some 3 MB, for one thread. */
typedef struct pm_part_coder pm_part_coder;
pm_part_coder *pm_part_coder_new(void); /* NULL if memory is short */
void pm_part_coder_free(pm_part_coder *coder);

/* Appends `count` <= PM_PART_PHOTONS photons. `first` is NULL if they are in stored order, so
 * that each lies near the one before; else they are in path order, and first[i] tells whether
 * photon i is the first of its path. The same bytes for the same version of zstd. */
void pm_part_pack(pm_part_coder *coder, const pm_photon *photons, size_t count,
                  const uint8_t *first, pm_bytes *out);

/* Takes what pm_part_pack wrote of `count` photons, with the same `first`; nothing may be left
 * in the reader. False if it is damaged. Never writes beyond out[count]. Test: fuzz_part.c. */
bool pm_part_unpack(pm_part_coder *coder, pm_reader *reader, size_t count, const uint8_t *first,
                    pm_photon *out);

/* The same of `count` <= PM_PART_PHOTONS numbers, least bytes first. */
void pm_part_pack_numbers(pm_part_coder *coder, const uint32_t *numbers, size_t count,
                          pm_bytes *out);
bool pm_part_unpack_numbers(pm_part_coder *coder, pm_reader *reader, size_t count,
                            uint32_t *out);

#endif
