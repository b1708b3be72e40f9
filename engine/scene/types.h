#ifndef PM_SCENE_TYPES_H
#define PM_SCENE_TYPES_H

#include "scene/lexer.h"
#include "scene/scene.h"

/* What each primitive type takes, after the Radiance reference manual (refer/ray.html) and the
 * argument checks of src/rt. */
typedef struct pm_type {
    const char *name;
    uint32_t strings_least, strings_most;
    /* Bit n is set if n reals are right; a polygon (counts == 0) takes any 3n, n >= 3. */
    uint32_t counts;
    const char *reals_takes; /* completes "takes ...", e.g. "5 reals: red green ..." */
    const char *real_names;  /* separated by blanks */
} pm_type;

const pm_type *pm_type_get(pm_primitive_type type);

/* The type that the word names. PM_E_UNSUPPORTED for a type of Radiance that is not offered,
 * PM_E_SYNTAX with the closest name for any other word. */
PM_MUST_USE pm_status pm_type_find(const pm_word *word, const char *file,
                                   pm_primitive_type *type, pm_error *err);

/* The name of real argument `index`, e.g. "roughness" or "z of vertex 2". */
void pm_type_real_name(pm_primitive_type type, size_t index, char *out, size_t size);

#endif
