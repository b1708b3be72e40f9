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
    pm_prototype_origin *origins =
        realloc(parser->prototype_origins, capacity * sizeof *origins);
    if (origins)
        parser->prototype_origins = origins;
    if (more && origins)
        parser->prototype_capacity = capacity;
    return more && origins;
}

static pm_status reserve_slots(pm_parser *parser, size_t count)
{
    if (count <= parser->slot_capacity)
        return PM_OK;
    int32_t *more = realloc(parser->slots, count * sizeof *more);
    if (!more)
        return pm_parser_memory_error(parser);
    parser->slots = more;
    parser->slot_capacity = count;
    return PM_OK;
}

/* A mesh of Wavefront names its materials; they are those of the scene where the mesh stands,
 * unless its primitive has a modifier, which replaces them all. A compiled mesh has its own,
 * which read_materials finds. Into the parser's buffer. */
static pm_status find_slots(const pm_reading *r, const pm_mesh *mesh, const pm_word *file_word)
{
    pm_status st = reserve_slots(r->parser, mesh->slot_count);
    bool named = r->result.modifier == PM_VOID && !mesh->is_compiled;
    for (uint32_t i = 0; !st && i < mesh->slot_count; i++) {
        pm_word name = *file_word; /* its place */
        name.text = mesh->slots[i];
        name.length = strlen(name.text);
        r->parser->slots[i] = PM_VOID;
        if (named)
            st = pm_parser_reference(r, &name, r->frame->file->name, &r->parser->slots[i]);
    }
    return st;
}

static bool is_same(const pm_prototype *prototype, const pm_mesh *mesh, const int32_t *slots)
{
    if (prototype->mesh != mesh)
        return false;
    return !mesh || !mesh->slot_count ||
           !memcmp(prototype->slots, slots, mesh->slot_count * sizeof *slots);
}

/* The prototype that the file is with the slots in the parser's buffer, or -1. Those made of it
 * last are searched: one more of the same costs memory, nothing else. */
static int32_t find(const pm_parser *parser, uint32_t file, const pm_mesh *mesh)
{
    enum { SEARCHED = 64 };
    int32_t at = parser->newest_prototype[file] - 1;
    for (int i = 0; at >= 0 && i < SEARCHED; i++) {
        if (is_same(&parser->prototypes[at], mesh, parser->slots))
            return at;
        at = parser->prototype_origins[at].older;
    }
    return -1;
}

static pm_status add(pm_parser *parser, uint32_t file_index, const pm_mesh *mesh, int32_t *out)
{
    const pm_file *file = pm_bundle_at(parser->bundle, file_index);
    size_t slot_count = mesh ? mesh->slot_count : 0;
    int32_t *slots = pm_arena_array(parser->arena, slot_count, sizeof *slots);
    if (!slots || !grow(parser))
        return pm_parser_memory_error(parser);
    if (slot_count)
        memcpy(slots, parser->slots, slot_count * sizeof *slots);
    int32_t index = (int32_t)parser->prototype_count++;
    parser->prototypes[index] = (pm_prototype){
        .mesh = mesh, .slots = slots, .digest = pm_digest_of(file->data, file->size)};
    if (mesh) {
        parser->prototypes[index].low = mesh->low;
        parser->prototypes[index].high = mesh->high;
    }
    parser->prototype_origins[index] =
        (pm_prototype_origin){file, parser->newest_prototype[file_index] - 1};
    parser->newest_prototype[file_index] = index + 1;
    *out = index;
    return PM_OK;
}

pm_status pm_parser_prototype(const pm_reading *r, const pm_file *file, const pm_word *word,
                              int32_t *out)
{
    pm_parser *parser = r->parser;
    const pm_mesh *mesh = NULL;
    pm_status st = PM_OK;
    if (r->result.type == PM_MESH) {
        int32_t asset;
        st = pm_assets_load(parser->assets, PM_ASSET_MESH, file, &asset, parser->err);
        if (!st) {
            mesh = pm_assets_at(parser->assets, asset)->mesh;
            st = find_slots(r, mesh, word);
        }
    }
    if (st)
        return st;
    uint32_t file_index = (uint32_t)(file - pm_bundle_at(parser->bundle, 0));
    *out = find(parser, file_index, mesh);
    return *out < 0 ? add(parser, file_index, mesh, out) : PM_OK;
}

/* ---- their primitives ---- */

/* The materials of a compiled mesh, in the order of its slots. */
static pm_status read_materials(pm_parser *parser, const pm_frame *frame, size_t index)
{
    const pm_file *file = frame->file;
    pm_arena arena = {0};
    pm_records records = {0};
    pm_status st =
        pm_mesh_materials(file->data, file->size, file->name, &arena, &records, parser->err);
    int32_t *slots = NULL;
    if (!st && records.count) {
        slots = pm_arena_array(parser->arena, records.count, sizeof *slots);
        st = slots ? pm_parser_records(parser, frame, &records, slots)
                   : pm_parser_memory_error(parser);
    }
    pm_arena_clear(&arena);
    if (!st && slots)
        parser->prototypes[index].slots = slots;
    return st;
}

static pm_status read_octree(pm_parser *parser, const pm_frame *frame, size_t index)
{
    const pm_file *file = frame->file;
    double corner[3], size;
    if (!pm_octree_file_is(file->data, file->size))
        return pm_error_set_at(parser->err, PM_E_CORRUPT, file->name, 0, 0,
                               "this is no octree; make one of it (oconv)");
    pm_status st = pm_parser_octree(parser, frame);
    if (st || !pm_octree_file_cube(file->data, file->size, corner, &size))
        return st;
    pm_prototype *prototype = &parser->prototypes[index];
    prototype->low = pm_vec3_make(corner[0], corner[1], corner[2]);
    prototype->high = pm_vec3_add(prototype->low, pm_vec3_make(size, size, size));
    return PM_OK;
}

/* A file of its own names: what the main scene defines is unknown in it. */
static pm_status read_prototype(pm_parser *parser, size_t index)
{
    const pm_frame frame = {.file = parser->prototype_origins[index].file,
                            .transform = pm_transform_identity(),
                            .prefix = "",
                            .depth = 1};
    const pm_names outer = parser->names;
    parser->names = (pm_names){.arena = parser->arena}; /* surfaces keep texts of names */
    parser->prototypes[index].first = parser->count;
    pm_status st = parser->prototypes[index].mesh ? read_materials(parser, &frame, index)
                                                  : read_octree(parser, &frame, index);
    parser->prototypes[index].count = parser->count - parser->prototypes[index].first;
    parser->names = outer;
    return st;
}

/* ---- prototypes in prototypes ---- */

struct visit {
    enum { UNSEEN, OPEN, DONE } state;
    unsigned depth; /* of prototypes in it, itself included */
};

static int32_t prototype_of(const pm_primitive *p)
{
    return p->type == PM_INSTANCE || p->type == PM_MESH ? p->assets[0] : PM_NO_ASSET;
}

static pm_status visit(pm_parser *parser, struct visit *visits, size_t index, unsigned level);

static pm_status visit_inner(pm_parser *parser, struct visit *visits, const pm_primitive *p,
                             unsigned level)
{
    size_t inner = (size_t)prototype_of(p);
    const char *file = pm_bundle_at(parser->bundle, p->file)->name;
    if (visits[inner].state == OPEN)
        return pm_error_set_at(parser->err, PM_E_LIMIT, file, p->line, p->column,
                               "instance '%.60s' would contain itself: '%.200s' is placed in "
                               "itself; take it out",
                               p->name, parser->prototype_origins[inner].file->name);
    bool deep = level >= parser->limits.nesting;
    pm_status st = deep ? PM_OK : visit(parser, visits, inner, level + 1);
    deep = deep || level + visits[inner].depth > parser->limits.nesting;
    if (!st && deep)
        return pm_error_set_at(parser->err, PM_E_LIMIT, file, p->line, p->column,
                               "octrees are nested more than %u deep here; join some of them",
                               parser->limits.nesting);
    return st;
}

/* Recurses limits.nesting deep at most. */
static pm_status visit(pm_parser *parser, struct visit *visits, size_t index, unsigned level)
{
    struct visit *v = &visits[index];
    const pm_prototype *prototype = &parser->prototypes[index];
    if (v->state == DONE)
        return PM_OK;
    pm_status st = PM_OK;
    *v = (struct visit){.state = OPEN, .depth = 1};
    for (size_t i = prototype->first; !st && i < prototype->first + prototype->count; i++) {
        int32_t inner = prototype_of(&parser->primitives[i]);
        if (inner == PM_NO_ASSET)
            continue;
        st = visit_inner(parser, visits, &parser->primitives[i], level);
        v->depth = visits[inner].depth >= v->depth ? visits[inner].depth + 1 : v->depth;
    }
    v->state = DONE;
    return st;
}

pm_status pm_parser_prototypes(pm_parser *parser)
{
    pm_status st = PM_OK;
    for (size_t i = 0; !st && i < parser->prototype_count; i++)
        st = read_prototype(parser, i);
    struct visit *visits =
        st ? NULL : pm_arena_array(&parser->scratch, parser->prototype_count, sizeof *visits);
    if (!st && !visits)
        st = pm_parser_memory_error(parser);
    for (size_t i = 0; !st && i < parser->prototype_count; i++)
        st = visit(parser, visits, i, 1);
    return st;
}
