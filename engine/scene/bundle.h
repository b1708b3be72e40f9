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
    const char *name; /* in normal form (path.h) */
    const uint8_t *data;
    size_t size;
} pm_file;

pm_bundle *pm_bundle_new(void); /* NULL if memory is short */
void pm_bundle_free(pm_bundle *bundle);

/* Copies a file in. PM_E_RANGE for an absolute, empty or climbing name, one longer than 255
 * bytes, or a name given twice; PM_E_LIMIT beyond 16384 files. */
PM_MUST_USE pm_status pm_bundle_add(pm_bundle *bundle, const char *name, const void *data,
                                    size_t size, pm_error *err);

/* A bundle of another's files and one more. It borrows the others, so it must go first; the new
 * one is copied in. Errors as pm_bundle_add. */
PM_MUST_USE pm_status pm_bundle_extend(const pm_bundle *base, const char *name,
                                       const void *data, size_t size, pm_bundle **out,
                                       pm_error *err);

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

/* Where a scene's files may come from, beside the main file's folder. */
typedef struct pm_collect_options {
    const char *search_path; /* folders joined by ':', as RAYPATH; NULL: Radiance's default */
    const char *const *allowed; /* more folders, whatever they hold may be sent */
    size_t allowed_count;
} pm_collect_options;

/* Fills a bundle from the file system with `path` and every file that it names, directly or
 * indirectly (named_files.h). A name is looked up beside the file that names it, in the main
 * file's folder, in the current folder, then in the search path. The main file's name in the
 * bundle is its base name; "-" reads standard input as a scene named `stdin.rad` of the current
 * folder. `*main_name` lives in the bundle; `options` may be NULL.
 *
 * A scene may be hostile, and the bundle travels: taken are only files that lie, links
 * resolved, in the main file's folder, in the search path or in an allowed folder.
 *
 * Errors: PM_E_MISSING lists all files that are not there and all that must not be taken;
 * PM_E_LIMIT beyond 1 GiB in all, PM_E_IO. What is wrong with the text is left to
 * pm_scene_parse. Used by the client alone. Test: test_collect.c. */
PM_MUST_USE pm_status pm_bundle_collect(const char *path, const pm_collect_options *options,
                                        pm_bundle **out, const char **main_name, pm_error *err);

/* The same for several main files. If there is more than one, the current folder takes the
 * place of the main file's.
 *   names  out: [count] their names in the bundle */
PM_MUST_USE pm_status pm_bundle_collect_files(const char *const *paths, size_t count,
                                              const pm_collect_options *options,
                                              pm_bundle **out, const char **names,
                                              pm_error *err);

#endif
