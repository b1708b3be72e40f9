#ifndef PM_SCENE_SCENE_H
#define PM_SCENE_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/digest.h"
#include "base/error.h"
#include "base/vec3.h"
#include "language/language.h"
#include "scene/bundle.h"
#include "scene/transform.h"

/* A parsed scene: the primitives as they were written, checked, transformed by their `!xform`
 * lines, modifiers resolved, the files that they name read.
 *
 * In: a bundle of files. Out: pm_scene. Next: world/world.h compiles it. */

typedef enum pm_primitive_type {
    /* materials */
    PM_LIGHT,
    PM_GLOW,
    PM_SPOTLIGHT,
    PM_ILLUM,
    PM_PLASTIC,
    PM_METAL,
    PM_TRANS,
    PM_PLASTIC2,
    PM_METAL2,
    PM_TRANS2,
    PM_ASHIK2,
    PM_GLASS,
    PM_DIELECTRIC,
    PM_INTERFACE,
    PM_MIRROR,
    PM_PRISM1,
    PM_PRISM2,
    PM_PLASFUNC,
    PM_METFUNC,
    PM_TRANSFUNC,
    PM_BRTDFUNC,
    PM_PLASDATA,
    PM_METDATA,
    PM_TRANSDATA,
    PM_BSDF,
    PM_ABSDF,
    PM_MIST,
    PM_ANTIMATTER,
    /* textures */
    PM_TEXFUNC,
    PM_TEXDATA,
    /* patterns */
    PM_COLORFUNC,
    PM_BRIGHTFUNC,
    PM_COLORDATA,
    PM_BRIGHTDATA,
    PM_COLORPICT,
    PM_COLORTEXT,
    PM_BRIGHTTEXT,
    PM_SPECTRUM,
    PM_SPECFILE,
    PM_SPECFUNC,
    PM_SPECDATA,
    PM_SPECPICT,
    /* mixtures */
    PM_MIXFUNC,
    PM_MIXDATA,
    PM_MIXPICT,
    PM_MIXTEXT,
    /* surfaces */
    PM_POLYGON,
    PM_SPHERE,
    PM_BUBBLE,
    PM_CONE,
    PM_CUP,
    PM_CYLINDER,
    PM_TUBE,
    PM_RING,
    PM_SOURCE,
    PM_INSTANCE,
    PM_MESH,
    PM_PRIMITIVE_TYPES,
} pm_primitive_type;

/* Modifier indices that are not primitives; an asset that a string does not name. */
enum { PM_VOID = -1, PM_NO_ASSET = -1 };

#define PM_NO_FUNCTION UINT32_MAX

/* Modifiers may follow each other so deep, mixtures' components included, and a point of a
 * surface may ask so many of them. */
enum { PM_MODIFIERS_MAX = 32, PM_MODIFIERS_ASKED_MAX = 1024 };

typedef struct pm_primitive {
    pm_primitive_type type;
    int32_t modifier; /* index of the modifying primitive, always smaller than its own */
    const char *modifier_name; /* as the file says it: that of an alias, too; or "void" */
    /* The material, or mixture of materials, that a chain of modifiers comes to which starts
     * with this primitive (a surface's: with its modifier). PM_VOID: none. A surface without
     * one cannot be seen. */
    int32_t material;
    uint8_t depth;   /* of that chain, mixtures' components included */
    bool empty;      /* a polygon without area, which is not there (Radiance warns of it) */
    uint16_t weight; /* modifiers that looking at it asks, those of components as often */
    const char *name;
    const char *const *strings; /* string arguments, without the transform at their end */
    /* What they name, one for each; NULL for types none of whose strings name such. */
    const int32_t *references; /* a modifier, or PM_VOID for "void" and for no modifier */
    const int32_t *assets;     /* a file: its number in pm_scene.assets; PM_NO_ASSET */
    /* The strings that are functions, compiled, with a result for each string in their order;
     * PM_NO_FUNCTION if there are none. The reals are folded in. */
    pm_function expressions; /* without arguments: orientations, coordinates of data, ... */
    pm_function functions;   /* of data, or of a direction: see pm_type.arguments */
    pm_function coordinates; /* of a direction: plasdata's and its like's */
    /* Bit i: the i-th of `functions` of a colordata or colorpict has fewer than three
     * parameters and gets its own value alone (Radiance's src/rt/p_data.c). */
    uint8_t lone_functions;
    /* From the primitive's own coordinates to the scene's: the transform that its string
     * arguments end in, then the `xform` lines. NULL for the identity and for types whose reals
     * say where they are. */
    const pm_transform *transform;
    const double *reals; /* all finite */
    uint32_t string_count, real_count;
    uint32_t file;    /* index into pm_scene.files */
    int line, column; /* of its type word, from 1 */
} pm_primitive;

/* What an instance or a mesh places: an octree's surfaces, or a mesh's triangles. */
typedef struct pm_prototype {
    size_t first, count;        /* its primitives, among those of the scene */
    const struct pm_mesh *mesh; /* NULL: an octree; lives in the assets */
    /* [mesh->slot_count]: the modifiers of a mesh's materials, PM_VOID for none */
    const int32_t *slots;
    pm_digest digest;  /* of the file's bytes; an octree's primitives count by themselves */
    pm_vec3 low, high; /* an octree's cube, as its file has it; a mesh's bounds */
} pm_prototype;

typedef struct pm_scene {
    /* In file order: the main scene's `main_count`, then those of the prototypes. */
    const pm_primitive *primitives;
    size_t count, main_count;
    const pm_prototype *prototypes; /* an instance's or mesh's asset is its number here */
    size_t prototype_count;
    /* How many primitives of the main scene stand before each alias that is none itself:
     * Radiance numbers those, too. */
    const uint32_t *aliases;
    size_t alias_count;
    const char *const *files; /* names, for messages */
    size_t file_count;
    struct pm_assets *assets; /* shared with whoever asked (assets.h) */
    struct pm_scene_memory *memory;
} pm_scene;

/* Limits that keep a hostile scene from exhausting the machine. Zero means the default. */
typedef struct pm_scene_limits {
    size_t primitives; /* default 20 million, after xform arrays */
    size_t reals;      /* in the whole scene; default 400 million */
    size_t bytes;      /* of text, each file as often as it is read; default 16 GiB */
    unsigned nesting;  /* of xform files; default 32 */
} pm_scene_limits;

/* Parses `main_name` of the bundle.
 *
 * Radiance's grammar: `modifier type name` then counted string, integer and real arguments; `#`
 * comments; `void`; `modifier alias new old`; `!xform ...` and the generators (command.h) on a
 * line of their own, run inside the process. Any other command is refused.
 *
 * What the result promises: an alias is what it means, or a copy of it with the alias's own
 * modifier. Below a material, and below a mixture of materials, come textures and patterns
 * alone. A source's material is light, glow, spotlight or illum. Functions are compiled, and
 * the files that strings name are read. Radii are positive, a cone's differ, a ring's ascend: a
 * negative radius, a cone with equal radii and a ring's radii in descending order are rewritten
 * as Radiance reads them.
 *
 * Errors: PM_E_SYNTAX, PM_E_RANGE, PM_E_UNSUPPORTED (a Radiance type not offered), PM_E_MISSING
 * (modifier or file), PM_E_LIMIT, PM_E_MEMORY, each but the last with file, line and column.
 * Source: Radiance reference manual (doc/ray.html); xform(1). Tests: tests/engine/scene,
 * tests/bad. */
PM_MUST_USE pm_status pm_scene_parse(const pm_bundle *bundle, const char *main_name,
                                     const pm_scene_limits *limits, pm_scene **out,
                                     pm_error *err);

/* The same for several files, one after the other, as one scene: a name that one defines holds
 * in those behind it. */
PM_MUST_USE pm_status pm_scene_parse_files(const pm_bundle *bundle, const char *const *names,
                                           size_t count, const pm_scene_limits *limits,
                                           pm_scene **out, pm_error *err);
void pm_scene_free(pm_scene *scene);

/* Radiance's word for a type, e.g. "plastic". */
const char *pm_primitive_type_name(pm_primitive_type type);

static inline bool pm_primitive_is_surface(pm_primitive_type type)
{
    return type >= PM_POLYGON;
}

static inline bool pm_primitive_is_material(pm_primitive_type type)
{
    return type <= PM_ANTIMATTER;
}

static inline bool pm_primitive_is_mixture(pm_primitive_type type)
{
    return type >= PM_MIXFUNC && type <= PM_MIXTEXT;
}

#endif
