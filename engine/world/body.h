#ifndef PM_WORLD_BODY_H
#define PM_WORLD_BODY_H

#include "files/mesh.h"
#include "world/shape.h"
#include "world/world.h"

/* Surfaces that lie together, in coordinates of their own: the main scene is one body, each
 * prototype that instances place is another. A body's cube is mapped to [-1, 1]^3 as the
 * world's is, so that precision does not depend on how large a prototype was drawn.
 *
 * A body numbers its surfaces: first its own shapes (in digest order) or a mesh's triangles,
 * then those of its first instance, of the second, and so on. The main scene's numbers are the
 * world's. */

/* Instances may lie in instances so deep. */
enum { PM_INSTANCE_DEPTH = 32 };

struct pm_ray_tree; /* ray_tree.h */

/* Where a body is in another one. */
struct pm_instance {
    pm_vec3 axis[3]; /* its axes, unit, mirrored or not */
    pm_vec3 origin;  /* the middle of its cube */
    double unit;     /* its unit of length */
    const struct pm_body *body;
    uint32_t material;  /* of all that it holds; PM_NO_PRIMITIVE: their own */
    uint32_t modifier;  /* likewise (selection.h); says nothing where `material` does not */
    uint32_t primitive; /* of the scene that it was made from: for messages and names alone */
    uint32_t first;     /* number of its first surface */
};

/* A mesh's triangles have no pm_shape each. */
struct pm_mesh_body {
    const pm_mesh *mesh;       /* in the world's assets */
    const pm_vec3 *positions;  /* [mesh->vertex_count], in the body's coordinates */
    const uint32_t *materials; /* [mesh->slot_count]; PM_NO_PRIMITIVE: invisible */
    const uint32_t *modifiers; /* [mesh->slot_count]; as a shape's */
    const uint32_t *group;     /* [mesh->triangle_count]: least number of those with the same
                                  corners; NULL if there are no two */
};

/* How many surfaces are of a kind, for pm_world_info. */
struct pm_tally {
    uint32_t specular, diffuse, mist;
};

struct pm_body {
    pm_vec3 center;    /* of the cube [its scene units] */
    double scale;      /* half its edge [its scene units] */
    double tolerance;  /* rounding of its numbers, seen from here: closer is coincident */
    pm_vec3 low, high; /* bounds of its contents [its scene units] */

    uint32_t shape_count;
    struct pm_shape *shapes;
    uint32_t instance_count;
    struct pm_instance *instances; /* in digest order */
    const pm_digest *instance_digests;
    struct pm_mesh_body mesh; /* mesh.mesh is NULL in others */

    uint32_t own_count; /* shapes or triangles */
    uint32_t count;     /* of surfaces, instances' included */
    bool empty;
    struct pm_tally tally; /* of all, where nothing replaces their materials */
    struct pm_ray_tree *tree;
};

/* Where a surface of the world is. */
struct pm_place {
    const struct pm_instance *chain[PM_INSTANCE_DEPTH]; /* outermost first */
    int depth;
    const struct pm_body *body; /* that it belongs to */
    uint32_t base;              /* number of that body's first surface */
    uint32_t local;             /* number in it, less than body->own_count */
    uint32_t material;          /* that replaces its own, or PM_NO_PRIMITIVE */
    uint32_t modifier;          /* likewise */
};

void pm_place_find(const struct pm_body *main, uint32_t surface, struct pm_place *out);

/* Between the coordinates of an instance's body and those of the body that it lies in.
 * Directions keep their length. */
pm_vec3 pm_instance_point_in(const struct pm_instance *instance, pm_vec3 point);
pm_vec3 pm_instance_point_out(const struct pm_instance *instance, pm_vec3 point);
pm_vec3 pm_instance_direction_in(const struct pm_instance *instance, pm_vec3 direction);
pm_vec3 pm_instance_direction_out(const struct pm_instance *instance, pm_vec3 direction);

/* A box about the instance's contents, in the coordinates of the body that it lies in. */
void pm_instance_bounds(const struct pm_instance *instance, pm_vec3 *low, pm_vec3 *high);

#endif
