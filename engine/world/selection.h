#ifndef PM_WORLD_SELECTION_H
#define PM_WORLD_SELECTION_H

#include "world/world.h"

/* Surfaces that an option names by their modifiers, e.g. mkpmap's ports.
 *
 * A name chooses the surfaces in whose chain of modifiers it stands, from the word that the
 * surface itself says (an alias included) to the material. (Radiance asks for the material's
 * name at ports and sensors, and for the surface's word at -ae and -ai: findmaterial and
 * ambincmp in its sources; both are in the chain.) */
typedef struct pm_selection {
    bool any;         /* whether it chooses anything */
    bool *is_chosen;  /* of each of the world's modifiers; NULL: none */
    pm_digest digest; /* of what is chosen, whatever it is called */
} pm_selection;

/* PM_E_MISSING for a name that no surface's modifier has, with those that there are; `option`
 * is for the message. No names choose nothing. Tests: test_selection.c. */
PM_MUST_USE pm_status pm_selection_make(const pm_world *world, const char *const *names,
                                        size_t count, const char *option, pm_selection *out,
                                        pm_error *err);
void pm_selection_clear(pm_selection *selection);

/* Numbers of the chosen surfaces, ascending, those of instances included: at most `most`, which
 * is what PM_E_LIMIT says else. To be freed. Test: chosen_surfaces_are_listed. */
PM_MUST_USE pm_status pm_selection_list(const pm_selection *selection, const pm_world *world,
                                        size_t most, uint32_t **surfaces, size_t *count,
                                        pm_error *err);

/* Whether it chooses the surface. */
bool pm_selection_has(const pm_selection *selection, const pm_world *world, uint32_t surface);

/* ---- what surfaces are called ---- */

typedef struct pm_surface_names {
    const char *modifier; /* as the surface, or the instance that replaces it, says it */
    const char *material; /* at the end of the chain; "void" if there is none */
    uint32_t primitive; /* of the scene that was compiled: the surface's own, a mesh's, or that
                           of the instance whose modifier replaces the surface's */
} pm_surface_names;

/* Texts live as long as the world. Test: surfaces_are_called_as_in_the_file. */
pm_surface_names pm_world_surface_names(const pm_world *world, uint32_t surface);

#endif
