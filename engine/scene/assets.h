#ifndef PM_SCENE_ASSETS_H
#define PM_SCENE_ASSETS_H

#include "base/digest.h"
#include "base/error.h"
#include "files/bsdf.h"
#include "files/data.h"
#include "files/font.h"
#include "files/mesh.h"
#include "files/picture.h"
#include "language/language.h"
#include "scene/bundle.h"

/* The files that a scene's string arguments name, read, and its functions, compiled. One for a
 * whole scene and for the world that is made of it: whoever keeps it has a share of its own. */
typedef struct pm_assets pm_assets;

typedef enum pm_asset_kind {
    PM_ASSET_FUNCTIONS,
    PM_ASSET_DATA,
    PM_ASSET_PICTURE,
    PM_ASSET_FONT,
    PM_ASSET_TEXT,
    PM_ASSET_BSDF,
    PM_ASSET_MESH,
} pm_asset_kind;

typedef struct pm_asset {
    pm_asset_kind kind;
    pm_digest
        digest; /* of the file's bytes: what its name stands for in the scene's identity */
    union {
        uint32_t context; /* functions: of the language */
        pm_data *data;
        pm_picture *picture;
        pm_font *font;
        struct {
            char *bytes;
            size_t size;
        } text;
        pm_bsdf *bsdf;
        pm_mesh *mesh;
    };
} pm_asset;

pm_assets *pm_assets_new(void); /* NULL if memory is short */
/* Another share; an owner frees each. From one thread at a time. */
pm_assets *pm_assets_share(pm_assets *assets);
void pm_assets_free(pm_assets *assets);

/* Reads the file, once for each kind, and gives its number. Errors are those of the readers,
 * with the file's name. */
PM_MUST_USE pm_status pm_assets_load(pm_assets *assets, pm_asset_kind kind, const pm_file *file,
                                     int32_t *out, pm_error *err);

/* Text that stands in the scene itself. */
PM_MUST_USE pm_status pm_assets_add_text(pm_assets *assets, const char *text, size_t size,
                                         int32_t *out, pm_error *err);

const pm_asset *pm_assets_at(const pm_assets *assets, int32_t asset);

/* Functions are added while the scene is parsed. */
pm_language *pm_assets_language(pm_assets *assets);

#endif
