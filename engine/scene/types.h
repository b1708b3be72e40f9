#ifndef PM_SCENE_TYPES_H
#define PM_SCENE_TYPES_H

#include <stdbool.h>

#include "scene/lexer.h"
#include "scene/scene.h"

/* What each primitive type takes, after the Radiance reference manual (refer/ray.html) and the
 * argument checks of src/rt.
 *
 * `strings` has a letter for each string argument:
 *   m modifier           e expression                 d data file        b BSDF file
 *   s source's name      f function, called with      p picture          o octree
 *                          data, a direction or a     t font             g mesh
 *                          wavelength                 x text, or "." and its words
 *                                                     c function file, or "."
 * and at its end perhaps
 *   ?  the letter before may be missing     *  the letter before any number of times, also 0
 *   +  an expression for each dimension of the data file
 *   &  a function for each dimension of the data file
 * After a function file, an octree and a mesh a transform may follow. */
typedef struct pm_type {
    const char *name;
    const char *strings;
    unsigned arguments;        /* with which its functions are called, those of `&` apart: 4 */
    const char *strings_takes; /* completes "takes ...", e.g. "no string arguments" */
    /* Bit n is set if n reals are right; `least` or more are right too if it is not 0. A
     * polygon takes any 3n, n >= 3. */
    uint32_t counts, least;
    const char *reals_takes; /* completes "takes ...", e.g. "5 reals: red green ..." */
    const char *real_names;  /* separated by blanks; those after the last are A1, A2, ... */
} pm_type;

const pm_type *pm_type_get(pm_primitive_type type);

/* The type that the word names; PM_E_SYNTAX with the closest name for any other word. */
PM_MUST_USE pm_status pm_type_find(const pm_word *word, const char *file,
                                   pm_primitive_type *type, pm_error *err);

/* The name of real argument `index`, e.g. "roughness" or "z of vertex 2". */
void pm_type_real_name(pm_primitive_type type, size_t index, char *out, size_t size);

/* What string argument `index` is: a letter of pm_type.strings, 'e' or 'f' for those of '+' and
 * '&'; 0 if the type takes no such argument (a transform may start there). `dimensions` of its
 * data file, 0 before that is read. */
char pm_type_string_role(const pm_type *type, size_t index, size_t dimensions);

/* How many string arguments there must be, without those for dimensions. */
size_t pm_type_strings_least(const pm_type *type);

bool pm_type_takes_transform(const pm_type *type);

#endif
