#ifndef PM_WORLD_OCTREE_WRITE_H
#define PM_WORLD_OCTREE_WRITE_H

#include "base/bytes.h"
#include "scene/scene.h"

/* Octree files that Radiance reads, as its oconv writes them. */
typedef struct pm_octree_options {
    uint32_t set_size;        /* -n: a cube with more surfaces is divided; 0: 6 */
    uint32_t resolution;      /* -r: the whole cube is so many smallest ones wide; 0: 16384 */
    bool bounded;             /* -b: the cube is given */
    double corner[3], edge;   /* then: its lowest corner and width */
    bool frozen;              /* -f: the primitives are in the file, not their files' names */
    const char *const *files; /* not frozen: the names to write, as the scene was parsed */
    uint32_t file_count;
    const char *command; /* for the header */
} pm_octree_options;

/* Writes the main scene. The tree is Radiance's: a cube is divided into eight as long as more
 * than set_size surfaces meet it that do not contain it (instances and meshes may), and its
 * parts are not smaller than the resolution says. Which surfaces a cube holds is conservative:
 * one that only touches it may be listed. Numbers of a frozen octree are rounded to its 31 bits
 * before that.
 * Errors: as pm_shape_make and pm_scene_freeze; PM_E_RANGE for bounds that do not hold the
 * scene; PM_E_LIMIT for a cube of the smallest size that 512 surfaces meet, PM_E_MEMORY.
 * Source: Radiance, src/ot/oconv.c, writeoct.c, src/common/octree.h. Test:
 * test_octree_write.c. */
PM_MUST_USE pm_status pm_octree_write(const pm_scene *scene, const pm_bundle *bundle,
                                      const pm_octree_options *options, pm_bytes *out,
                                      pm_error *err);

#endif
