#include "scene/assets.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct entry {
    pm_asset asset;
    const uint8_t *data; /* of the file that it was read from, while the bundle lives */
};

struct pm_assets {
    unsigned shares;
    pm_language *language;
    struct entry *entries;
    size_t count, capacity;
    struct slot *slots; /* open addressing: entries by kind and data */
    size_t slot_count;
};

/* ---- finding what was read before ---- */

struct slot {
    uint32_t entry; /* + 1; 0 if empty */
};

static size_t hash_of(pm_asset_kind kind, const uint8_t *data)
{
    uint64_t key = (uint64_t)(uintptr_t)data ^ (uint64_t)kind;
    return (size_t)(key * 0x9E3779B97F4A7C15U >> 20);
}

/* The slot of the file, or the empty one where it belongs. */
static struct slot *slot_of(const pm_assets *a, pm_asset_kind kind, const uint8_t *data)
{
    for (size_t i = hash_of(kind, data) % a->slot_count;; i = (i + 1) % a->slot_count) {
        struct slot *slot = &a->slots[i];
        if (!slot->entry)
            return slot;
        const struct entry *e = &a->entries[slot->entry - 1];
        if (e->asset.kind == kind && e->data == data)
            return slot;
    }
}

static bool grow(pm_assets *a)
{
    if (a->count < a->capacity)
        return true;
    size_t capacity = a->capacity ? 2 * a->capacity : 16;
    struct entry *entries = realloc(a->entries, capacity * sizeof *entries);
    if (!entries)
        return false;
    a->entries = entries;
    struct slot *slots = calloc(2 * capacity, sizeof *slots);
    if (!slots)
        return false;
    free(a->slots);
    a->slots = slots;
    a->slot_count = 2 * capacity;
    a->capacity = capacity;
    for (uint32_t i = 0; i < a->count; i++)
        slot_of(a, entries[i].asset.kind, entries[i].data)->entry = i + 1;
    return true;
}

/* ---- reading ---- */

static pm_status memory_error(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "not enough memory for the files that a scene names");
}

static pm_status read_text(const pm_file *file, pm_asset *out, pm_error *err)
{
    out->text.bytes = malloc(file->size + 1);
    if (!out->text.bytes)
        return memory_error(err);
    memcpy(out->text.bytes, file->data, file->size);
    out->text.bytes[file->size] = '\0';
    out->text.size = file->size;
    return PM_OK;
}

static pm_status read_asset(pm_assets *a, const pm_file *f, pm_asset *out, pm_error *err)
{
    switch (out->kind) {
    case PM_ASSET_FUNCTIONS:
        return pm_language_read(a->language, f->name, (const char *)f->data, f->size,
                                &out->context, err);
    case PM_ASSET_DATA:
        return pm_data_read(f->data, f->size, f->name, &out->data, err);
    case PM_ASSET_PICTURE:
        return pm_picture_read(f->data, f->size, f->name, &out->picture, err);
    case PM_ASSET_FONT:
        return pm_font_read(f->data, f->size, f->name, &out->font, err);
    case PM_ASSET_BSDF:
        return pm_bsdf_read(f->data, f->size, f->name, &out->bsdf, err);
    case PM_ASSET_MESH:
        return pm_mesh_read(f->data, f->size, f->name, NULL, &out->mesh, err);
    default:
        return read_text(f, out, err);
    }
}

static void clear_asset(pm_asset *asset)
{
    switch (asset->kind) {
    case PM_ASSET_FUNCTIONS:
        break; /* the language owns its contexts */
    case PM_ASSET_DATA:
        pm_data_free(asset->data);
        break;
    case PM_ASSET_PICTURE:
        pm_picture_free(asset->picture);
        break;
    case PM_ASSET_FONT:
        pm_font_free(asset->font);
        break;
    case PM_ASSET_TEXT:
        free(asset->text.bytes);
        break;
    case PM_ASSET_BSDF:
        pm_bsdf_free(asset->bsdf);
        break;
    case PM_ASSET_MESH:
        pm_mesh_free(asset->mesh);
        break;
    }
}

pm_status pm_assets_load(pm_assets *a, pm_asset_kind kind, const pm_file *file, int32_t *out,
                         pm_error *err)
{
    if (!grow(a))
        return memory_error(err);
    struct slot *slot = slot_of(a, kind, file->data);
    if (!slot->entry) {
        struct entry *e = &a->entries[a->count];
        *e = (struct entry){.asset.kind = kind, .data = file->data};
        pm_status st = read_asset(a, file, &e->asset, err);
        if (st)
            return st;
        e->asset.digest = pm_digest_of(file->data, file->size);
        slot->entry = (uint32_t)++a->count;
    }
    *out = (int32_t)slot->entry - 1;
    return PM_OK;
}

pm_status pm_assets_add_text(pm_assets *a, const char *text, size_t size, int32_t *out,
                             pm_error *err)
{
    const pm_file file = {.name = "text", .data = (const uint8_t *)text, .size = size};
    return pm_assets_load(a, PM_ASSET_TEXT, &file, out, err);
}

/* ---- lifetime ---- */

pm_assets *pm_assets_new(void)
{
    pm_assets *a = calloc(1, sizeof *a);
    if (!a)
        return NULL;
    a->shares = 1;
    a->language = pm_language_new(PM_LANGUAGE_SCENE);
    if (!a->language) {
        free(a);
        return NULL;
    }
    return a;
}

pm_assets *pm_assets_share(pm_assets *assets)
{
    assets->shares++;
    return assets;
}

void pm_assets_free(pm_assets *a)
{
    if (!a || --a->shares)
        return;
    for (size_t i = 0; i < a->count; i++)
        clear_asset(&a->entries[i].asset);
    pm_language_free(a->language);
    free(a->entries);
    free(a->slots);
    free(a);
}

const pm_asset *pm_assets_at(const pm_assets *assets, int32_t asset)
{
    return &assets->entries[asset].asset;
}

pm_language *pm_assets_language(pm_assets *assets)
{
    return assets->language;
}
