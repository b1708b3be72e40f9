#ifndef PM_FILES_PORTABLE_H
#define PM_FILES_PORTABLE_H

#include "base/bytes.h"
#include "base/error.h"

/* What Radiance's binary files are made of: octrees (octree_file.h) and compiled meshes
 * (mesh.h). Reading past the end sets the reader's `failed` and gives zeros.
 * Source: Radiance, src/common/portio.c, header.c. Test: test_portable.c. */

/* The widest integer [bytes]; also the most that an object's index may take in a file. */
enum { PM_PORTABLE_WIDEST = 8 };

/* Two's complement, most significant byte first, in 1 .. 8 bytes. */
int64_t pm_portable_integer(pm_reader *reader, unsigned size);
void pm_portable_put_integer(pm_bytes *bytes, int64_t value, unsigned size);

/* A mantissa m of 32 bits and an exponent e of 8: (m + 1/2) / (2^31 - 1) * 2^e for m >= 0, the
 * same with - 1/2 below, and 0 for m = 0. Always finite; the relative error of a number that
 * was written is below 2^-30, and none for powers of two. Writing a number too large for the
 * exponent gives the largest, one too small 0. */
double pm_portable_real(pm_reader *reader);
void pm_portable_put_real(pm_bytes *bytes, double value);
double pm_portable_rounded(double value); /* as it is read when it was written */

/* A terminated text, in place; NULL if it does not end. */
const char *pm_portable_text(pm_reader *reader);
void pm_portable_put_text(pm_bytes *bytes, const char *text);

/* Passes an information header: lines of text up to an empty one.
 *   format  what its last FORMAT= line says must be this; a header without one is accepted
 *   magic   the number after the header less the size of an object's index
 *   size    out: size of an object's index [bytes], 1 .. PM_PORTABLE_WIDEST
 * False if the bytes are something else. */
bool pm_portable_header(pm_reader *reader, const char *format, int magic, unsigned *size);

/* The cube of an octree: four texts. False if one is no number, not finite, or the size is
 * negative. */
bool pm_portable_cube(pm_reader *reader, double origin[3], double *size);

/* "FILE: what, at byte N" as PM_E_CORRUPT; where the reader failed, that the file is cut off.
 */
pm_status pm_portable_error(const pm_reader *reader, const char *file, const char *what,
                            pm_error *err);

/* Passes an octree in pre-order. Sets hold 1 .. 511 objects.
 *   objects     every index in a set must be below this
 *   is_surface  NULL, or by object: only those may be in a set
 * PM_E_CORRUPT. */
PM_MUST_USE pm_status pm_portable_tree(pm_reader *reader, unsigned size, uint64_t objects,
                                       const bool *is_surface, const char *file, pm_error *err);

enum {
    PM_OCTREE_MAGIC = 283, /* 4 * 8 + 251 */
    PM_MESH_MAGIC = 319,   /* 8 + 311 */
    PM_OCTREE_SET = 511    /* most objects of a leaf */
};
enum { PM_NODE_EMPTY, PM_NODE_FULL, PM_NODE_TREE };

#endif
