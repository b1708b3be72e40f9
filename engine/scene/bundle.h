#ifndef PM_SCENE_BUNDLE_H
#define PM_SCENE_BUNDLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"
#include "base/digest.h"
#include "base/error.h"

/* The files of one scene, by name, in memory. Names resolve only in here: nothing that comes
 * from the network can reach the file system. A bundle travels as an uncompressed POSIX tar.
 *
 * Next: scene.h parses one of the files. */
typedef struct pm_bundle pm_bundle;

typedef struct pm_file {
    const char *name; /* normalised: relative, '/' between parts, no '.' or '..' parts */
    const uint8_t *data;
    size_t size;
} pm_file;

pm_bundle *pm_bundle_new(void); /* NULL if memory is short */
void pm_bundle_free(pm_bundle *bundle);

/* Copies a file in. PM_E_RANGE for an absolute, empty or climbing name, one longer than 255
 * bytes, or a name given twice; PM_E_LIMIT beyond 16384 files. */
PM_MUST_USE pm_status pm_bundle_add(pm_bundle *bundle, const char *name, const void *data,
                                    size_t size, pm_error *err);

/* The file of that name, or NULL. `from` (may be NULL) is the file that names it: the name is
 * looked up beside that file first, then at the top. */
const pm_file *pm_bundle_find(const pm_bundle *bundle, const char *name, const char *from);

size_t pm_bundle_count(const pm_bundle *bundle);
const pm_file *pm_bundle_at(const pm_bundle *bundle, size_t index); /* sorted by name */

/* Reads a tar of regular files of at most `limit_bytes` in all; folders are passed over.
 * PM_E_UNSUPPORTED for links, devices and sparse files, PM_E_LIMIT, PM_E_CORRUPT for what is
 * cut or no tar, and as pm_bundle_add. Test: test_bundle.c. */
PM_MUST_USE pm_status pm_bundle_read_tar(const void *data, size_t size, size_t limit_bytes,
                                         pm_bundle **out, pm_error *err);

/* Writes the tar: files sorted by name, no times, no owners, so that equal bundles give equal
 * bytes and one digest. */
PM_MUST_USE pm_status pm_bundle_write_tar(const pm_bundle *bundle, pm_bytes *out,
                                          pm_error *err);

/* Fills a bundle from the file system with `path` and every file its `!xform` lines name,
 * directly or indirectly. The main file's name in the bundle is its base name; the names of the
 * others are as the scene writes them, normalised, and must lie under the main file's folder,
 * links resolved. "-" reads standard input as a scene named `stdin.rad` of the current folder.
 * `*main_name` lives in the bundle.
 * Errors: PM_E_MISSING lists all files that are not there, PM_E_RANGE for one outside the
 * folder, PM_E_LIMIT beyond 1 GiB in all, PM_E_IO. What is wrong with the text is left to
 * pm_scene_parse. Used by the client alone. Test: test_collect.c. */
PM_MUST_USE pm_status pm_bundle_collect(const char *path, pm_bundle **out,
                                        const char **main_name, pm_error *err);

#endif
