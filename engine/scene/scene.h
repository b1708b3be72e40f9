#ifndef PM_SCENE_SCENE_H
#define PM_SCENE_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "scene/bundle.h"

/* A parsed scene: the primitives as they were written, checked, transformed by their `!xform`
 * lines, modifiers resolved.
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
    PM_GLASS,
    PM_DIELECTRIC,
    PM_MIRROR,
    PM_MIST,
    PM_ANTIMATTER,
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
    PM_PRIMITIVE_TYPES,
} pm_primitive_type;

/* Modifier indices that are not primitives. */
enum { PM_VOID = -1 };

typedef struct pm_primitive {
    pm_primitive_type type;
    /* Index of the modifying primitive, always smaller than its own. PM_VOID for materials. */
    int32_t modifier;
    const char *name;
    const char *const *strings; /* string arguments */
    /* The string arguments that name modifiers (illum's and mirror's alternate material,
     * antimatter's list), resolved: index, or PM_VOID for "void". PM_VOID for each of a mist's,
     * which name sources: every light scatters in it. */
    const int32_t *references;
    const double *reals; /* all finite */
    uint32_t string_count, real_count;
    uint32_t file;    /* index into pm_scene.files */
    int line, column; /* of its type word, from 1 */
} pm_primitive;

typedef struct pm_scene {
    const pm_primitive *primitives; /* in file order */
    size_t count;
    const char *const *files; /* names, for messages */
    size_t file_count;
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
 * comments; `void`; `modifier alias new old`; `!xform ...` on a line of its own, run inside the
 * process. Any other command is refused.
 *
 * What the result promises: aliases are resolved away, surfaces that use one have the index of
 * what it means. A surface's modifier is a material (`void`, which makes it invisible in
 * Radiance, is refused), a material's is PM_VOID. A source's material is light, glow, spotlight
 * or illum. Radii are positive, a cone's differ, a ring's ascend: a negative radius, a cone
 * with equal radii and a ring's radii in descending order are rewritten as Radiance reads them.
 *
 * Errors: PM_E_SYNTAX, PM_E_RANGE, PM_E_UNSUPPORTED (a Radiance type not offered), PM_E_MISSING
 * (modifier or file), PM_E_LIMIT, PM_E_MEMORY, each but the last with file, line and column.
 * Source: Radiance reference manual (doc/ray.html); xform(1). Tests: tests/engine/scene,
 * tests/bad. */
PM_MUST_USE pm_status pm_scene_parse(const pm_bundle *bundle, const char *main_name,
                                     const pm_scene_limits *limits, pm_scene **out,
                                     pm_error *err);
void pm_scene_free(pm_scene *scene);

/* Radiance's word for a type, e.g. "plastic". */
const char *pm_primitive_type_name(pm_primitive_type type);

static inline int pm_primitive_is_surface(pm_primitive_type type)
{
    return type >= PM_POLYGON;
}

#endif
