#include "world/identity.h"

#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/radix.h"
#include "scene/assets.h"
#include "scene/types.h"

struct maker {
    const pm_scene *scene;
    struct pm_identity *out;
    bool *needed;     /* [scene->count]: by a surface, or by a needed modifier */
    bool *listed;     /* [scene->count]: needed, and a material of the world */
    pm_digest *bare;  /* [scene->count]: of needed materials, before antimatters count */
    pm_digest *full;  /* [scene->count] */
    pm_bytes scratch; /* what is being digested */
    uint8_t *heights; /* [scene->prototype_count]: how deep instances nest, itself included */
    pm_error *err;
};

static pm_status no_memory(const struct maker *m)
{
    return pm_error_set(m->err, PM_E_MEMORY, "no memory for the digests of %zu primitives",
                        m->scene->count);
}

static bool is_instance(const pm_primitive *p)
{
    return p->type == PM_INSTANCE || p->type == PM_MESH;
}

/* A surface without a material, or without an area, is not there. */
static bool is_seen(const pm_primitive *p)
{
    return pm_primitive_is_surface(p->type) && p->material != PM_VOID && !p->empty;
}

static void mark(struct maker *m, int32_t primitive, bool material)
{
    if (primitive == PM_VOID)
        return;
    m->needed[primitive] = true;
    if (material && m->scene->primitives[primitive].material != PM_VOID)
        m->listed[primitive] = true;
}

/* Modifiers and references come before what names them, so one pass from the end does. What a
 * surface, a material or a mixture of materials names becomes a material of the world, chain
 * and all; the modifiers along a chain count for its digest alone. */
static void mark_needed(struct maker *m)
{
    for (size_t i = 0; i < m->scene->prototype_count; i++) {
        const pm_prototype *prototype = &m->scene->prototypes[i];
        for (uint32_t k = 0; prototype->mesh && k < prototype->mesh->slot_count; k++)
            mark(m, prototype->slots[k], true);
    }
    for (size_t i = m->scene->count; i-- > 0;) {
        const pm_primitive *p = &m->scene->primitives[i];
        if (!is_seen(p) && !m->needed[i])
            continue;
        mark(m, p->modifier, is_seen(p));
        for (uint32_t k = 0; p->references && k < p->string_count; k++)
            mark(m, p->references[k], p->material != PM_VOID);
    }
}

/* ---- digests ---- */

static void append_digest(struct maker *m, const pm_digest *digest)
{
    pm_bytes_append(&m->scratch, digest->bytes, sizeof digest->bytes);
}

/* A file counts by its content, a modifier by its digest, a function by its text. */
static void append_string(struct maker *m, const pm_primitive *p, uint32_t k)
{
    static const pm_digest none = {{0}};
    char role = pm_type_string_role(pm_type_get(p->type), k, SIZE_MAX);
    if (role == 'm')
        append_digest(m, p->references[k] == PM_VOID ? &none : &m->bare[p->references[k]]);
    else if (role == 'o' || role == 'g')
        append_digest(m, &m->out->prototypes[p->assets[k]].digest);
    else if (p->assets && p->assets[k] != PM_NO_ASSET)
        append_digest(m, &pm_assets_at(m->scene->assets, p->assets[k])->digest);
    else if (role == 'e' || role == 'f')
        pm_bytes_append(&m->scratch, p->strings[k], strlen(p->strings[k]) + 1);
}

static void append_transform(struct maker *m, const pm_transform *t)
{
    for (int i = 0; i < 9; i++)
        pm_bytes_f64(&m->scratch, t->turn[i / 3][i % 3] + 0.0);
    for (int i = 0; i < 3; i++)
        pm_bytes_f64(&m->scratch, t->shift[i] + 0.0);
}

static void start(struct maker *m, const pm_primitive *p, const pm_digest *of_materials)
{
    static const pm_digest none = {{0}};
    m->scratch.size = 0;
    pm_bytes_text(&m->scratch, pm_primitive_type_name(p->type));
    pm_bytes_u8(&m->scratch, 0);
    const pm_digest *d = p->modifier == PM_VOID ? &none : &of_materials[p->modifier];
    pm_bytes_append(&m->scratch, d->bytes, sizeof d->bytes);
    pm_bytes_u32(&m->scratch, p->real_count);
    for (uint32_t i = 0; i < p->real_count; i++)
        pm_bytes_f64(&m->scratch, p->reals[i] + 0.0); /* -0 + 0 = 0 */
    for (uint32_t k = 0; k < p->string_count; k++)
        append_string(m, p, k);
    if (p->transform)
        append_transform(m, p->transform);
}

static pm_digest finish(struct maker *m)
{
    return pm_digest_of(m->scratch.data, m->scratch.size);
}

static pm_digest bare_digest(struct maker *m, const pm_primitive *p)
{
    start(m, p, m->bare);
    return finish(m);
}

static int by_digest(const void *a, const void *b)
{
    return pm_digest_compare(a, b);
}

/* Pairs (listed material, antimatter's digest). */
struct listing {
    int32_t material;
    pm_digest antimatter;
};

static int by_material(const void *a, const void *b)
{
    const struct listing *x = a, *y = b;
    if (x->material != y->material)
        return x->material < y->material ? -1 : 1;
    return pm_digest_compare(&x->antimatter, &y->antimatter);
}

static size_t collect_listings(const struct maker *m, struct listing *out)
{
    size_t count = 0;
    for (size_t i = 0; i < m->scene->count; i++) {
        const pm_primitive *p = &m->scene->primitives[i];
        if (p->type != PM_ANTIMATTER || !m->needed[i])
            continue;
        for (uint32_t k = 0; k < p->string_count; k++, count++)
            if (out)
                out[count] = (struct listing){p->references[k], m->bare[i]};
    }
    return count;
}

/* Antimatter goes by modifier, not by content: of two equal plastics it may list only one. */
static bool add_antimatters(struct maker *m)
{
    size_t count = collect_listings(m, NULL);
    struct listing *all = pm_arena_array(&m->out->arena, count, sizeof *all);
    if (!all)
        return false;
    collect_listings(m, all);
    qsort(all, count, sizeof *all, by_material);
    for (size_t i = 0; i < count;) {
        int32_t material = all[i].material;
        m->scratch.size = 0;
        if (material != PM_VOID)
            pm_bytes_append(&m->scratch, m->bare[material].bytes, sizeof(pm_digest));
        for (; i < count && all[i].material == material; i++)
            pm_bytes_append(&m->scratch, all[i].antimatter.bytes, sizeof(pm_digest));
        if (material != PM_VOID)
            m->full[material] = finish(m);
    }
    return true;
}

static bool digest_materials(struct maker *m)
{
    for (size_t i = 0; i < m->scene->count; i++)
        if (m->needed[i])
            m->bare[i] = m->full[i] = bare_digest(m, &m->scene->primitives[i]);
    return add_antimatters(m);
}

/* ---- sorted lists ---- */

struct entry {
    pm_digest digest; /* first: by_digest compares entries too */
    uint32_t primitive;
};

static uint64_t key_of(const pm_digest *digest)
{
    uint64_t key = 0;
    for (int i = 0; i < 8; i++)
        key = key << 8 | digest->bytes[i];
    return key;
}

/* By the digests' first bytes, of which few are equal but where all are. */
static bool sort_entries(struct entry *entries, size_t count)
{
    struct entry *sorted = malloc((count + 1) * sizeof *sorted);
    pm_keyed *keys = malloc((count + 1) * sizeof *keys);
    bool ready = sorted && keys;
    for (size_t i = 0; ready && i < count; i++)
        keys[i] = (pm_keyed){key_of(&entries[i].digest), (uint32_t)i};
    ready = ready && !pm_radix_sort(keys, count);
    for (size_t i = 0; ready && i < count; i++)
        sorted[i] = entries[keys[i].value];
    for (size_t i = 0, end; ready && i < count; i = end) {
        for (end = i + 1; end < count && keys[end].key == keys[i].key;)
            end++;
        if (end - i > 1)
            qsort(sorted + i, end - i, sizeof *sorted, by_digest);
    }
    if (ready)
        memcpy(entries, sorted, count * sizeof *entries);
    free(sorted);
    free(keys);
    return ready;
}

static bool list_materials(struct maker *m)
{
    pm_arena *arena = &m->out->arena;
    size_t needed = 0, count = 0;
    for (size_t i = 0; i < m->scene->count; i++)
        needed += m->listed[i];
    struct entry *entries = pm_arena_array(arena, needed, sizeof *entries);
    uint32_t *primitive = pm_arena_array(arena, needed, sizeof *primitive);
    pm_digest *digest = pm_arena_array(arena, needed, sizeof *digest);
    uint32_t *of_primitive = pm_arena_array(arena, m->scene->count, sizeof *of_primitive);
    if (!entries || !primitive || !digest || !of_primitive)
        return false;
    memset(of_primitive, 0xFF, m->scene->count * sizeof *of_primitive);
    for (uint32_t i = 0, k = 0; i < m->scene->count; i++)
        if (m->listed[i])
            entries[k++] = (struct entry){m->full[i], i};
    if (!sort_entries(entries, needed))
        return false;
    for (size_t i = 0; i < needed; i++) {
        if (count == 0 || !pm_digest_equal(&digest[count - 1], &entries[i].digest)) {
            primitive[count] = entries[i].primitive;
            digest[count++] = entries[i].digest;
        }
        of_primitive[entries[i].primitive] = (uint32_t)(count - 1);
    }
    m->out->materials = (struct pm_material_table){count, primitive, digest, of_primitive};
    return true;
}

/* ---- what lies together ---- */

static bool is_local(const pm_primitive *p)
{
    return pm_primitive_is_surface(p->type) && p->type != PM_SOURCE && !is_instance(p) &&
           !p->empty;
}

static bool is_surface_of_main(const pm_primitive *p)
{
    return is_local(p) && is_seen(p);
}

static bool is_source_of_main(const pm_primitive *p)
{
    return p->type == PM_SOURCE && is_seen(p);
}

/* One whose modifier comes to no material is not there. */
static bool is_placed(const pm_primitive *p)
{
    return is_instance(p) && (p->modifier == PM_VOID || is_seen(p));
}

/* The primitives from `first` on that a rule takes, by digest. */
static pm_status list(struct maker *m, size_t first, size_t end,
                      bool (*takes)(const pm_primitive *p), uint32_t **primitives,
                      pm_digest **digests, size_t *made)
{
    size_t count = 0, n = 0;
    for (size_t i = first; i < end; i++)
        count += takes(&m->scene->primitives[i]);
    struct entry *entries = malloc((count + 1) * sizeof *entries);
    *primitives = pm_arena_array(&m->out->arena, count, sizeof **primitives);
    *digests = pm_arena_array(&m->out->arena, count, sizeof **digests);
    bool ready = entries && *primitives && *digests;
    for (size_t i = first; ready && i < end; i++) {
        if (!takes(&m->scene->primitives[i]))
            continue;
        start(m, &m->scene->primitives[i], m->full);
        entries[n++] = (struct entry){finish(m), (uint32_t)i};
    }
    ready = ready && sort_entries(entries, count);
    for (size_t i = 0; ready && i < count; i++) {
        (*primitives)[i] = entries[i].primitive;
        (*digests)[i] = entries[i].digest;
    }
    free(entries);
    *made = count;
    return ready ? PM_OK : no_memory(m);
}

static pm_status list_content(struct maker *m, size_t first, size_t end,
                              bool (*takes)(const pm_primitive *p), struct pm_content *out)
{
    pm_status status =
        list(m, first, end, takes, &out->surfaces, &out->digests, &out->surface_count);
    return status ? status
                  : list(m, first, end, is_placed, &out->instances, &out->instance_digests,
                         &out->instance_count);
}

static void digest_octree(struct maker *m, struct pm_content *content)
{
    m->scratch.size = 0;
    pm_bytes_text(&m->scratch, "octree");
    for (size_t i = 0; i < content->surface_count; i++)
        append_digest(m, &content->digests[i]);
    pm_bytes_text(&m->scratch, "instances");
    for (size_t i = 0; i < content->instance_count; i++)
        append_digest(m, &content->instance_digests[i]);
    content->digest = finish(m);
}

static void digest_mesh(struct maker *m, const pm_prototype *prototype,
                        struct pm_content *content)
{
    static const pm_digest none = {{0}};
    m->scratch.size = 0;
    pm_bytes_text(&m->scratch, "mesh");
    append_digest(m, &prototype->digest);
    for (uint32_t k = 0; k < prototype->mesh->slot_count; k++) {
        int32_t slot = prototype->slots[k];
        append_digest(m, slot == PM_VOID ? &none : &m->full[slot]);
    }
    content->digest = finish(m);
}

/* ---- prototypes, those within others first ---- */

enum { OPEN = UINT8_MAX };

static pm_status refuse(const struct maker *m, const pm_primitive *p, pm_status status,
                        const char *what)
{
    return pm_error_set_at(m->err, status, m->scene->files[p->file], p->line, p->column,
                           "%s %s: %s", pm_primitive_type_name(p->type), p->name, what);
}

static pm_status visit(struct maker *m, const pm_primitive *placed, int depth);

/* *height: how deep instances nest in what these place. */
static pm_status visit_all(struct maker *m, size_t first, size_t end, int depth,
                           uint8_t *height)
{
    *height = 0;
    for (size_t i = first; i < end; i++) {
        const pm_primitive *p = &m->scene->primitives[i];
        if (!is_placed(p))
            continue;
        pm_status status = visit(m, p, depth);
        if (status)
            return status;
        uint8_t here = m->heights[p->assets[0]];
        *height = here > *height ? here : *height;
        if (depth + *height > PM_INSTANCE_DEPTH + 1)
            return refuse(m, p, PM_E_LIMIT, "instances lie in instances more than 32 deep");
    }
    return PM_OK;
}

static pm_status visit_octree(struct maker *m, const pm_prototype *prototype,
                              struct pm_content *content, int depth, uint8_t *height)
{
    size_t end = prototype->first + prototype->count;
    pm_status status = visit_all(m, prototype->first, end, depth + 1, height);
    if (!status)
        status = list_content(m, prototype->first, end, is_local, content);
    if (!status)
        digest_octree(m, content);
    return status;
}

static pm_status visit(struct maker *m, const pm_primitive *placed, int depth)
{
    int32_t index = placed->assets[0];
    const pm_prototype *prototype = &m->scene->prototypes[index];
    struct pm_content *content = &m->out->prototypes[index];
    uint8_t *height = &m->heights[index], within = 0;
    if (*height == OPEN)
        return refuse(m, placed, PM_E_RANGE, "the octree holds itself");
    if (*height > 0)
        return PM_OK;
    if (depth > PM_INSTANCE_DEPTH)
        return refuse(m, placed, PM_E_LIMIT, "instances lie in instances more than 32 deep");
    *height = OPEN;
    pm_status status = PM_OK;
    if (prototype->mesh)
        digest_mesh(m, prototype, content);
    else
        status = visit_octree(m, prototype, content, depth, &within);
    *height = (uint8_t)(within + 1);
    m->out->order[m->out->order_count++] = (uint32_t)index;
    return status;
}

static pm_status list_all(struct maker *m)
{
    struct pm_identity *out = m->out;
    size_t end = m->scene->main_count;
    uint8_t height;
    pm_status status = visit_all(m, 0, end, 1, &height);
    if (!status)
        status = list_content(m, 0, end, is_surface_of_main, &out->main);
    if (!status)
        status = list(m, 0, end, is_source_of_main, &out->sources, &out->source_digests,
                      &out->source_count);
    return status;
}

static bool maker_init(struct maker *m)
{
    size_t count = m->scene->count, prototypes = m->scene->prototype_count;
    m->needed = calloc(count + 1, sizeof *m->needed);
    m->listed = calloc(count + 1, sizeof *m->listed);
    m->bare = calloc(count + 1, sizeof *m->bare);
    m->full = calloc(count + 1, sizeof *m->full);
    m->heights = calloc(prototypes + 1, sizeof *m->heights);
    m->out->prototypes = pm_arena_array(&m->out->arena, prototypes, sizeof *m->out->prototypes);
    m->out->order = pm_arena_array(&m->out->arena, prototypes, sizeof *m->out->order);
    return m->needed && m->listed && m->bare && m->full && m->heights && m->out->prototypes &&
           m->out->order;
}

static void maker_clear(struct maker *m)
{
    free(m->needed);
    free(m->listed);
    free(m->bare);
    free(m->full);
    free(m->heights);
    pm_bytes_clear(&m->scratch);
}

pm_status pm_identity_make(const pm_scene *scene, struct pm_identity *out, pm_error *err)
{
    struct pm_identity identity = {0};
    struct maker m = {.scene = scene, .out = &identity, .err = err};
    pm_status status = maker_init(&m) ? PM_OK : no_memory(&m);
    if (!status) {
        mark_needed(&m);
        status = digest_materials(&m) && list_materials(&m) ? PM_OK : no_memory(&m);
    }
    if (!status)
        status = list_all(&m);
    if (!status && pm_bytes_status(&m.scratch))
        status = no_memory(&m);
    maker_clear(&m);
    if (status)
        pm_identity_clear(&identity);
    else
        *out = identity;
    return status;
}

void pm_identity_clear(struct pm_identity *identity)
{
    pm_arena_clear(&identity->arena);
}
