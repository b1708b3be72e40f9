#ifndef PM_PHOTONS_FILE_H
#define PM_PHOTONS_FILE_H

#include "photons/map_internal.h"
#include "photons/part.h"

/* What files of maps and of batches share. All numbers are little-endian; every section ends in
 * the CRC-32C of its bytes, so that a flipped bit is found where it is. */

/* Of both files. 1: photons as they lie, 24 bytes each. 2: packed. */
enum { PM_PHOTON_FILE_VERSION = 2 };

/* A file being read: what it is called, and where the first complaint goes. */
typedef struct pm_source {
    pm_reader reader;
    const char *name;
    pm_error *err;
} pm_source;

pm_status pm_source_damaged(const pm_source *source, const char *part);

/* Checks the 8 bytes of `magic` and the version behind them. `what` completes "is no ...". */
PM_MUST_USE pm_status pm_source_begin(pm_source *source, const char magic[8], const char *what);

/* Checks the CRC-32C behind everything since `start`. */
bool pm_source_checked(pm_source *source, size_t start);
pm_rgb pm_source_rgb(pm_source *source);

/* A section: its length, its bytes, the CRC-32C of both. `inner` reads the bytes alone. */
bool pm_source_section(pm_source *source, pm_reader *inner);

void pm_put_checksum(pm_bytes *out, size_t start); /* of everything since `start` */
void pm_put_rgb(pm_bytes *out, pm_rgb c);
/* Opens a section and closes it; what pm_section_open returned is handed to pm_section_close.
 */
size_t pm_section_open(pm_bytes *out);
void pm_section_close(pm_bytes *out, size_t start);

/* The photons of a part in a section of its own, and back. `first` as of pm_part_pack. */
void pm_put_part(pm_bytes *out, pm_part_coder *coder, const pm_photon *photons, size_t count,
                 const uint8_t *first);
PM_MUST_USE pm_status pm_source_part(pm_source *source, pm_part_coder *coder, size_t count,
                                     const uint8_t *first, pm_photon *out);

/* Whether so many photons can be in what is left, before memory is asked for them. */
bool pm_source_may_hold(const pm_source *source, uint64_t count);

/* How many photons the part at photon `first` holds. */
size_t pm_part_size(uint64_t first, uint64_t count);

#endif
