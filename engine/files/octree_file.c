#include "files/octree_file.h"

#include <stdlib.h>
#include <string.h>

#define FORMAT "Radiance_octree"

bool pm_octree_file_is(const void *data, size_t size)
{
    pm_reader reader = {.data = data, .size = size};
    unsigned index_size;
    return pm_portable_header(&reader, FORMAT, PM_OCTREE_MAGIC, &index_size);
}

bool pm_octree_file_cube(const void *data, size_t size, double origin[3], double *edge)
{
    pm_reader reader = {.data = data, .size = size};
    unsigned index_size;
    return pm_portable_header(&reader, FORMAT, PM_OCTREE_MAGIC, &index_size) &&
           pm_portable_cube(&reader, origin, edge);
}

struct octree_reader {
    pm_reader bytes;
    unsigned index_size;
    const char *name;
    size_t limit;
    pm_arena *arena;
    pm_octree_file result;
    pm_error *err;
};

static pm_status fail(const struct octree_reader *r, const char *what)
{
    return pm_portable_error(&r->bytes, r->name, what, r->err);
}

static pm_status memory_error(const struct octree_reader *r)
{
    return pm_error_set_at(r->err, PM_E_MEMORY, r->name, 0, 0,
                           "not enough memory for the octree");
}

static pm_status read_head(struct octree_reader *r)
{
    const char **files = pm_arena_array(r->arena, PM_OCTREE_FILES, sizeof *files);
    if (!files)
        return memory_error(r);
    if (!pm_portable_header(&r->bytes, FORMAT, PM_OCTREE_MAGIC, &r->index_size))
        return fail(r, "the header");
    if (!pm_portable_cube(&r->bytes, r->result.origin, &r->result.size))
        return fail(r, "the bounding cube");
    for (;;) {
        const char *file = pm_portable_text(&r->bytes);
        if (!file || (*file && r->result.file_count == PM_OCTREE_FILES))
            return fail(r, "the list of scene files");
        if (!*file)
            break;
        files[r->result.file_count++] = file;
    }
    r->result.files = files;
    int64_t objects = pm_portable_integer(&r->bytes, r->index_size);
    if (r->bytes.failed || objects < 0)
        return fail(r, "the number of objects");
    if ((uint64_t)objects > r->limit)
        return pm_error_set_at(r->err, PM_E_LIMIT, r->name, 0, 0,
                               "it holds %lld primitives, more than %zu; split it",
                               (long long)objects, r->limit);
    r->result.objects = (uint64_t)objects;
    return PM_OK;
}

/* As Radiance has it, instances and meshes are volumes: those may be in a set, too. */
static bool is_surface_type(const char *type)
{
    static const char *const names[] = {"polygon",  "cone",     "sphere", "ring",
                                        "cylinder", "instance", "cup",    "bubble",
                                        "tube",     "mesh",     "source"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i], type) == 0)
            return true;
    return false;
}

/* The sets come before the primitives, so the tree is passed twice. */
static pm_status check_sets(struct octree_reader *r, size_t tree_at)
{
    const pm_records *records = &r->result.records;
    bool *is_surface = calloc(records->count + 1, sizeof *is_surface);
    if (!is_surface)
        return memory_error(r);
    for (size_t i = 0; i < records->count; i++)
        is_surface[i] = is_surface_type(records->items[i].type);
    pm_reader again = r->bytes;
    again.at = tree_at;
    pm_status st =
        pm_portable_tree(&again, r->index_size, r->result.objects, is_surface, r->name, r->err);
    free(is_surface);
    return st;
}

static pm_status read_records(struct octree_reader *r, size_t tree_at)
{
    pm_status st = pm_records_read(&r->bytes, r->index_size, r->limit, r->name, r->arena,
                                   &r->result.records, r->err);
    if (st)
        return st;
    if (r->result.records.count != r->result.objects)
        return pm_error_set_at(r->err, PM_E_CORRUPT, r->name, 0, 0,
                               "the file is damaged: it announces %llu primitives and holds "
                               "%zu",
                               (unsigned long long)r->result.objects, r->result.records.count);
    return check_sets(r, tree_at);
}

static pm_status read_all(struct octree_reader *r)
{
    pm_status st = read_head(r);
    size_t tree_at = r->bytes.at;
    if (!st)
        st = pm_portable_tree(&r->bytes, r->index_size, r->result.objects, NULL, r->name,
                              r->err);
    if (!st && r->result.file_count == 0)
        st = read_records(r, tree_at);
    if (!st && r->bytes.at < r->bytes.size)
        return pm_error_set_at(r->err, PM_E_CORRUPT, r->name, 0, 0,
                               "the file is damaged: %zu bytes follow its end",
                               r->bytes.size - r->bytes.at);
    return st;
}

pm_status pm_octree_file_read(const void *data, size_t size, const char *name, size_t limit,
                              pm_arena *arena, pm_octree_file *out, pm_error *err)
{
    struct octree_reader r = {.bytes = {.data = data, .size = size},
                              .name = name,
                              .limit = limit,
                              .arena = arena,
                              .err = err};
    pm_status st = read_all(&r);
    if (!st)
        *out = r.result;
    return st;
}

void pm_octree_file_start(const pm_octree_file *file, const char *command, pm_bytes *out)
{
    pm_bytes_format(out, "#?RADIANCE\n%s\nFORMAT=%s\n\n", command, FORMAT);
    pm_portable_put_integer(out, PM_OCTREE_MAGIC + 4, 2);
    for (int i = 0; i < 3; i++)
        pm_bytes_format(out, "%.12g%c", file->origin[i], '\0');
    pm_bytes_format(out, "%.12g%c", file->size, '\0');
    for (uint32_t i = 0; i < file->file_count; i++)
        pm_portable_put_text(out, file->files[i]);
    pm_portable_put_text(out, "");
    pm_portable_put_integer(out, (int64_t)file->objects, 4);
}
