#ifndef PM_WORLD_IDENTITY_H
#define PM_WORLD_IDENTITY_H

#include "world/world_internal.h"

/* Who is who, by content.
 *   material  SHA-256(type, modifier's digest, numbers, digests of the materials that it names)
 *             and, if antimatters list it, SHA-256 of that and their sorted digests
 *   surface   SHA-256(type, material's digest, numbers)
 * A mist's light names do not count, since every light scatters in every mist.
 * Numbers are little-endian doubles in scene units, -0 as 0. Names, comments, order and unused
 * materials do not count. A polygon written from another first vertex is another surface. The
 * parser sees to it that every surface has a material. */
struct pm_identity {
    uint32_t *surfaces; /* scene primitives: local ones by digest, then `source`s by digest */
    pm_digest *digests; /* of them */
    size_t local_count, distant_count;
    struct pm_material_table materials;
    pm_arena arena; /* of all of that */
};

PM_MUST_USE pm_status pm_identity_make(const pm_scene *scene, struct pm_identity *out,
                                       pm_error *err);
void pm_identity_clear(struct pm_identity *identity);

#endif
