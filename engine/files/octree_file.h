#ifndef PM_FILES_OCTREE_FILE_H
#define PM_FILES_OCTREE_FILE_H

#include "files/records.h"

/* Radiance's octree files, what its oconv writes: the names of scene files, or, frozen, their
 * primitives; and which of them lie in which part of a cube. The tree itself is only checked:
 * the world divides its own cube, so that equal scenes have equal hashes.
 *
 * In: the bytes of a file. Out: pm_octree_file. Next: scene/scene.h checks the primitives as
 * those of text. */

enum { PM_OCTREE_FILES = 255 }; /* most scene files that an octree may name */

typedef struct pm_octree_file {
    double origin[3], size;   /* of the cube; size 0 if only sources are in it */
    const char *const *files; /* scene files, as they were written; none: frozen */
    uint32_t file_count;
    uint64_t objects;   /* aliases included */
    pm_records records; /* of a frozen one: `objects` of them */
} pm_octree_file;

/* True for bytes that start as an octree file does. */
bool pm_octree_file_is(const void *data, size_t size);

/* Its cube alone; false if the bytes are damaged before its end. */
bool pm_octree_file_cube(const void *data, size_t size, double origin[3], double *edge);

/* Reads a whole file. Lists are put into the arena, texts lie in `data`.
 *   limit  most primitives
 * PM_E_CORRUPT for what is cut off or damaged: a set with an object that is not there or is a
 * modifier, a modifier that comes after what it modifies, bytes after the end. PM_E_LIMIT,
 * PM_E_MEMORY.
 * Source: Radiance, src/common/readoct.c, octree.h. Tests: test_octree_file.c, and
 * fuzz_octree.c. */
PM_MUST_USE pm_status pm_octree_file_read(const void *data, size_t size, const char *name,
                                          size_t limit, pm_arena *arena, pm_octree_file *out,
                                          pm_error *err);

/* Writes everything up to the tree: header with `command` as its line, cube, names of files,
 * number of objects. The tree follows in pre-order, of nodes and sets with indices of 4 bytes,
 * and, without files, the primitives. */
void pm_octree_file_start(const pm_octree_file *file, const char *command, pm_bytes *out);

#endif
