#include <stdlib.h>
#include <string.h>

#include "scene/parser.h"

static bool grow(pm_parser *parser)
{
    if (parser->prototype_count < parser->prototype_capacity)
        return true;
    size_t capacity = parser->prototype_capacity ? 2 * parser->prototype_capacity : 8;
    pm_prototype *more = realloc(parser->prototypes, capacity * sizeof *more);
    if (more)
        parser->prototypes = more;
    const pm_file **files = realloc(parser->prototype_files, capacity * sizeof *files);
    if (files)
        parser->prototype_files = files;
    if (more && files)
        parser->prototype_capacity = capacity;
    return more && files;
}

/* A mesh of Wavefront names its materials; they are those of the scene where the mesh stands,
 * unless its primitive has a modifier, which replaces them all. */
static pm_status find_slots(const pm_reading *r, const pm_mesh *mesh, const pm_word *file_word,
                            const int32_t **out)
{
    int32_t *slots = pm_arena_array(r->parser->arena, mesh->slot_count, sizeof *slots);
    pm_status st = slots ? PM_OK : pm_parser_memory_error(r->parser);
    for (uint32_t i = 0; !st && i < mesh->slot_count; i++) {
        pm_word name = *file_word; /* its place */
        name.text = mesh->slots[i];
        name.length = strlen(name.text);
        slots[i] = PM_VOID;
        if (r->result.modifier == PM_VOID)
            st = pm_parser_reference(r, &name, r->frame->file->name, &slots[i]);
    }
    *out = slots;
    return st;
}

static bool is_same(const pm_prototype *a, const pm_prototype *b)
{
    if (a->mesh != b->mesh)
        return false;
    return !a->mesh || !a->mesh->slot_count ||
           !memcmp(a->slots, b->slots, a->mesh->slot_count * sizeof *a->slots);
}

static pm_status add(pm_parser *parser, const pm_file *file, const pm_prototype *prototype,
                     int32_t *out)
{
    for (size_t i = 0; i < parser->prototype_count; i++) {
        if (parser->prototype_files[i] == file && is_same(&parser->prototypes[i], prototype)) {
            *out = (int32_t)i;
            return PM_OK;
        }
    }
    if (!grow(parser))
        return pm_parser_memory_error(parser);
    parser->prototype_files[parser->prototype_count] = file;
    parser->prototypes[parser->prototype_count] = *prototype;
    *out = (int32_t)parser->prototype_count++;
    return PM_OK;
}

pm_status pm_parser_prototype(const pm_reading *r, const pm_file *file, const pm_word *word,
                              int32_t *out)
{
    pm_parser *parser = r->parser;
    pm_prototype prototype = {.digest = pm_digest_of(file->data, file->size)};
    if (r->result.type == PM_MESH) {
        int32_t asset;
        pm_status st = pm_assets_load(parser->assets, PM_ASSET_MESH, file, &asset, parser->err);
        if (st)
            return st;
        prototype.mesh = pm_assets_at(parser->assets, asset)->mesh;
        st = find_slots(r, prototype.mesh, word, &prototype.slots);
        if (st)
            return st;
    }
    return add(parser, file, &prototype, out);
}

pm_status pm_parser_prototypes(pm_parser *parser)
{
    for (size_t i = 0; i < parser->prototype_count; i++)
        if (!parser->prototypes[i].mesh)
            return pm_error_set_at(parser->err, PM_E_UNSUPPORTED,
                                   parser->prototype_files[i]->name, 0, 0,
                                   "octrees cannot be read");
    return PM_OK;
}
