#ifndef PM_FILES_RECORDS_H
#define PM_FILES_RECORDS_H

#include "base/arena.h"
#include "files/portable.h"

/* Primitives in Radiance's portable binary form, inside frozen octrees and compiled meshes:
 * a list of type names, then records of type, modifier, name, strings and reals.
 * Source: Radiance, src/common/sceneio.c. Test: test_records.c. */

typedef struct pm_record {
    const char *type;
    const char *name;
    const char *const *strings;
    const double *reals; /* finite */
    uint32_t string_count, real_count;
    int32_t modifier; /* index of an earlier record; -1 for void */
} pm_record;

typedef struct pm_records {
    const pm_record *items;
    size_t count;
} pm_records;

/* Reads to the end of the list. Lists are put into the arena; texts lie in the reader's bytes.
 * `limit` bounds the number of records. PM_E_CORRUPT, PM_E_LIMIT, PM_E_MEMORY. */
PM_MUST_USE pm_status pm_records_read(pm_reader *reader, unsigned index_size, size_t limit,
                                      const char *file, pm_arena *arena, pm_records *out,
                                      pm_error *err);

/* Writes records with indices of 4 bytes. PM_E_LIMIT for what the format cannot hold: more than
 * 32767 strings or reals of one primitive, a text longer than 511 bytes; PM_E_UNSUPPORTED for
 * a type that Radiance does not know; PM_E_MEMORY. */
PM_MUST_USE pm_status pm_records_write(const pm_record *items, size_t count, pm_bytes *out,
                                       pm_error *err);

#endif
