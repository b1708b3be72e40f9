#include "scene/bundle.h"

#include <archive.h>
#include <archive_entry.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "scene/path.h"

/* So that a hostile archive of empty files stays cheap. */
enum { FILES_MOST = 16384 };

struct pm_bundle {
    pm_file *files; /* sorted by name */
    size_t count, capacity;
    pm_arena arena; /* names and data */
};

static pm_status memory_error(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "not enough memory for the files of a scene");
}

pm_bundle *pm_bundle_new(void)
{
    return calloc(1, sizeof(pm_bundle));
}

void pm_bundle_free(pm_bundle *bundle)
{
    if (!bundle)
        return;
    pm_arena_clear(&bundle->arena);
    free(bundle->files);
    free(bundle);
}

/* The place of the first file whose name is not before `name`. */
static size_t lower_bound(const pm_bundle *bundle, const char *name)
{
    size_t low = 0, high = bundle->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (strcmp(bundle->files[middle].name, name) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static const pm_file *find_exact(const pm_bundle *bundle, const char *name)
{
    size_t at = lower_bound(bundle, name);
    bool found = at < bundle->count && strcmp(bundle->files[at].name, name) == 0;
    return found ? &bundle->files[at] : NULL;
}

static pm_status make_room(pm_bundle *bundle, pm_error *err)
{
    if (bundle->count == FILES_MOST)
        return pm_error_set(err, PM_E_LIMIT, "a scene may have at most %d files", FILES_MOST);
    if (bundle->count < bundle->capacity)
        return PM_OK;
    size_t capacity = bundle->capacity ? 2 * bundle->capacity : 8;
    pm_file *files = realloc(bundle->files, capacity * sizeof *files);
    if (!files)
        return memory_error(err);
    bundle->files = files;
    bundle->capacity = capacity;
    return PM_OK;
}

/* `*data` (size bytes and one more) is in the arena on return, to be filled by the caller. */
static pm_status insert(pm_bundle *bundle, const char *name, size_t size, uint8_t **data,
                        pm_error *err)
{
    char clean[PM_PATH_SIZE];
    if (!pm_path_join(NULL, name, clean) || pm_path_is_inside(clean) != pm_path_is_inside(name))
        return pm_error_set(
            err, PM_E_RANGE,
            "'%.80s' cannot name a file of a scene; write a relative name of at "
            "most %d bytes that stays inside the folder",
            name, PM_PATH_SIZE - 1);
    if (find_exact(bundle, clean))
        return pm_error_set(err, PM_E_RANGE, "the scene has two files named '%.200s'", clean);
    pm_status st = make_room(bundle, err);
    if (st)
        return st;
    char *own_name = pm_arena_text(&bundle->arena, clean, strlen(clean));
    uint8_t *own_data = size < SIZE_MAX ? pm_arena_alloc(&bundle->arena, size + 1) : NULL;
    if (!own_name || !own_data)
        return memory_error(err);
    size_t at = lower_bound(bundle, clean);
    memmove(&bundle->files[at + 1], &bundle->files[at],
            (bundle->count - at) * sizeof *bundle->files);
    bundle->files[at] = (pm_file){.name = own_name, .data = own_data, .size = size};
    bundle->count++;
    *data = own_data;
    return PM_OK;
}

pm_status pm_bundle_add(pm_bundle *bundle, const char *name, const void *data, size_t size,
                        pm_error *err)
{
    uint8_t *own;
    pm_status st = insert(bundle, name, size, &own, err);
    if (!st && size)
        memcpy(own, data, size);
    return st;
}

pm_status pm_bundle_extend(const pm_bundle *base, const char *name, const void *data,
                           size_t size, pm_bundle **out, pm_error *err)
{
    pm_bundle *both = pm_bundle_new();
    pm_file *files = calloc(base->count + 1, sizeof *files);
    if (!both || !files) {
        free(both);
        free(files);
        return memory_error(err);
    }
    if (base->count)
        memcpy(files, base->files, base->count * sizeof *files);
    *both = (pm_bundle){.files = files, .count = base->count, .capacity = base->count + 1};
    pm_status st = pm_bundle_add(both, name, data, size, err);
    if (st)
        pm_bundle_free(both);
    else
        *out = both;
    return st;
}

const pm_file *pm_bundle_find(const pm_bundle *bundle, const char *name, const char *from)
{
    char clean[PM_PATH_SIZE];
    const pm_file *file = NULL;
    if (from && pm_path_join(from, name, clean))
        file = find_exact(bundle, clean);
    if (!file && pm_path_join(NULL, name, clean))
        file = find_exact(bundle, clean);
    return file;
}

size_t pm_bundle_count(const pm_bundle *bundle)
{
    return bundle->count;
}

const pm_file *pm_bundle_at(const pm_bundle *bundle, size_t index)
{
    return &bundle->files[index];
}

/* ---- tar ---- */

static pm_status archive_error(struct archive *archive, pm_error *err)
{
    if (archive_errno(archive) == ENOMEM)
        return memory_error(err);
    const char *text = archive_error_string(archive);
    return pm_error_set(err, PM_E_CORRUPT, "the scene's tar cannot be read: %s",
                        text ? text : "it is damaged");
}

struct tar {
    struct archive *archive;
    pm_bundle *bundle;
    size_t size;  /* of the tar */
    size_t limit; /* what is left of it */
    pm_error *err;
};

static pm_status read_data(struct tar *tar, const char *name, size_t size)
{
    uint8_t *data;
    pm_status st = insert(tar->bundle, name, size, &data, tar->err);
    size_t done = 0;
    while (!st && done < size) {
        la_ssize_t got = archive_read_data(tar->archive, data + done, size - done);
        if (got < 0)
            st = archive_error(tar->archive, tar->err);
        else if (got == 0)
            st = pm_error_set(tar->err, PM_E_CORRUPT, "the scene's tar ends inside '%.200s'",
                              name);
        else
            done += (size_t)got;
    }
    return st;
}

static pm_status read_entry(struct tar *tar, struct archive_entry *entry)
{
    const char *name = archive_entry_pathname(entry);
    if (!name)
        name = archive_entry_pathname_utf8(entry);
    if (!name)
        return pm_error_set(tar->err, PM_E_CORRUPT,
                            "the scene's tar has a file without a name");
    if (archive_entry_filetype(entry) == AE_IFDIR && !archive_entry_hardlink(entry))
        return PM_OK; /* folders exist through their files */
    if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_hardlink(entry) ||
        archive_entry_sparse_count(entry) > 0)
        return pm_error_set(tar->err, PM_E_UNSUPPORTED,
                            "'%.200s' in the scene's tar is no plain file; links, devices and "
                            "sparse files are refused",
                            name);
    la_int64_t size = archive_entry_size_is_set(entry) ? archive_entry_size(entry) : -1;
    if (size < 0 || (uint64_t)size > tar->size)
        return pm_error_set(tar->err, PM_E_CORRUPT, "the scene's tar ends inside '%.200s'",
                            name);
    if ((uint64_t)size > tar->limit)
        return pm_error_set(tar->err, PM_E_LIMIT, "the scene's files are too large together");
    tar->limit -= (size_t)size;
    return read_data(tar, name, (size_t)size);
}

static pm_status read_entries(struct tar *tar, const void *data)
{
    struct archive *archive = tar->archive;
    /* No filters: a bundle is not compressed, so nothing can grow while it is read. */
    if (archive_read_support_format_tar(archive) != ARCHIVE_OK ||
        archive_read_open_memory(archive, data, tar->size) != ARCHIVE_OK)
        return archive_error(archive, tar->err);
    for (;;) {
        struct archive_entry *entry;
        int result = archive_read_next_header(archive, &entry);
        if (result == ARCHIVE_EOF)
            break;
        /* A warning tells of a name that does not fit the locale; the name is taken as bytes.
         */
        if (result != ARCHIVE_OK && result != ARCHIVE_WARN)
            return archive_error(archive, tar->err);
        pm_status st = read_entry(tar, entry);
        if (st)
            return st;
    }
    if (!tar->bundle->count)
        return pm_error_set(tar->err, PM_E_CORRUPT, "the scene's tar holds no file");
    return PM_OK;
}

pm_status pm_bundle_read_tar(const void *data, size_t size, size_t limit_bytes, pm_bundle **out,
                             pm_error *err)
{
    struct tar tar = {.archive = archive_read_new(),
                      .bundle = pm_bundle_new(),
                      .size = size,
                      .limit = limit_bytes,
                      .err = err};
    pm_status st = tar.archive && tar.bundle ? read_entries(&tar, data) : memory_error(err);
    archive_read_free(tar.archive);
    if (st)
        pm_bundle_free(tar.bundle);
    else
        *out = tar.bundle;
    return st;
}

/* Always succeeds: pm_bytes remembers a failure, and libarchive 3.6 leaks after one. */
static la_ssize_t write_bytes(struct archive *archive, void *context, const void *data,
                              size_t size)
{
    (void)archive;
    pm_bytes_append(context, data, size);
    return (la_ssize_t)size;
}

static pm_status write_entry(struct archive *archive, struct archive_entry *entry,
                             const pm_file *file, pm_error *err)
{
    archive_entry_clear(entry);
    archive_entry_set_pathname(entry, file->name);
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0644);
    archive_entry_set_mtime(entry, 0, 0);
    archive_entry_set_size(entry, (la_int64_t)file->size);
    if (archive_write_header(archive, entry) != ARCHIVE_OK ||
        archive_write_data(archive, file->data, file->size) != (la_ssize_t)file->size) {
        if (archive_errno(archive) == ENOMEM)
            return memory_error(err);
        return pm_error_set(err, PM_E_RANGE, "'%.200s' does not fit into a tar: %s", file->name,
                            archive_error_string(archive));
    }
    return PM_OK;
}

static pm_status write_entries(const pm_bundle *bundle, struct archive *archive, pm_bytes *out,
                               pm_error *err)
{
    if (archive_write_set_format_ustar(archive) != ARCHIVE_OK ||
        archive_write_set_bytes_per_block(archive, 0) != ARCHIVE_OK ||
        archive_write_open(archive, out, NULL, write_bytes, NULL) != ARCHIVE_OK)
        return memory_error(err);
    struct archive_entry *entry = archive_entry_new();
    pm_status st = entry ? PM_OK : memory_error(err);
    for (size_t i = 0; !st && i < bundle->count; i++)
        st = write_entry(archive, entry, &bundle->files[i], err);
    archive_entry_free(entry);
    if (!st && archive_write_close(archive) != ARCHIVE_OK)
        st = memory_error(err);
    return st;
}

pm_status pm_bundle_write_tar(const pm_bundle *bundle, pm_bytes *out, pm_error *err)
{
    pm_bytes bytes = {0};
    struct archive *archive = archive_write_new();
    pm_status st = archive ? write_entries(bundle, archive, &bytes, err) : memory_error(err);
    archive_write_free(archive);
    if (!st && !bytes.failed)
        pm_bytes_append(out, bytes.data, bytes.size);
    if (!st && (bytes.failed || pm_bytes_status(out)))
        st = memory_error(err);
    pm_bytes_clear(&bytes);
    return st;
}
