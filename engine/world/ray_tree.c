#include "world/ray_tree.h"

#include <stdlib.h>
#include <string.h>

#include <embree3/rtcore.h>

#include "world/mesh_body.h"

void *pm_tree_builder_new(void)
{
    return rtcNewDevice("isa=avx2,threads=1,start_threads=0,set_affinity=0");
}

void pm_tree_builder_free(void *builder)
{
    if (builder)
        rtcReleaseDevice(builder);
}

/* ---- items ---- */

/* Corners of one of the two triangles of a piece. */
static void piece_corners(const struct pm_piece *p, int second, pm_vec3 out[3])
{
    for (int i = 0; i < 3; i++) {
        int k = second && i ? i + 1 : i; /* 0 1 2, 0 2 3 */
        out[i] = pm_vec3_make(p->corner[0][k], p->corner[1][k], p->corner[2][k]);
    }
}

static bool is_single(const struct pm_piece *p)
{
    return p->corner[0][0] == p->corner[0][3] && p->corner[1][0] == p->corner[1][3] &&
           p->corner[2][0] == p->corner[2][3];
}

static void triangle_corners(const struct pm_ray_tree *tree, uint32_t item, int second,
                             pm_vec3 out[3])
{
    const struct pm_mesh_body *m = &tree->body->mesh;
    if (!m->mesh) {
        piece_corners(&tree->pieces.piece[item], second, out);
        return;
    }
    for (int i = 0; i < 3; i++)
        out[i] = m->positions[m->mesh->triangles[item].corner[i]];
}

static void item_bounds(const struct pm_ray_tree *tree, uint32_t item, int second, pm_vec3 *low,
                        pm_vec3 *high)
{
    if (item < tree->flat_count) {
        pm_vec3 p[3];
        triangle_corners(tree, item, second, p);
        *low = pm_vec3_min(pm_vec3_min(p[0], p[1]), p[2]);
        *high = pm_vec3_max(pm_vec3_max(p[0], p[1]), p[2]);
        return;
    }
    item -= tree->flat_count;
    if (item < tree->round_count) {
        const struct pm_shape *s = &tree->body->shapes[tree->round[item]];
        *low = s->low;
        *high = s->high;
        return;
    }
    pm_instance_bounds(&tree->body->instances[item - tree->round_count], low, high);
}

static struct RTCBuildPrimitive primitive_of(const struct pm_ray_tree *tree, uint32_t item,
                                             int second)
{
    pm_vec3 low, high;
    item_bounds(tree, item, second, &low, &high);
    return (struct RTCBuildPrimitive){.lower_x = (float)(low.x - PM_TREE_MARGIN),
                                      .lower_y = (float)(low.y - PM_TREE_MARGIN),
                                      .lower_z = (float)(low.z - PM_TREE_MARGIN),
                                      .geomID = (unsigned)second,
                                      .upper_x = (float)(high.x + PM_TREE_MARGIN),
                                      .upper_y = (float)(high.y + PM_TREE_MARGIN),
                                      .upper_z = (float)(high.z + PM_TREE_MARGIN),
                                      .primID = item};
}

/* ---- nodes, as Embree asks for them ---- */

static void clear_node(struct pm_tree_node *node)
{
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < PM_TREE_WIDTH; i++) {
            node->bound[0][axis][i] = INFINITY;
            node->bound[1][axis][i] = -INFINITY;
        }
    memset(node->child, 0, sizeof node->child);
}

static void set_box(struct pm_tree_node *node, unsigned i, struct RTCBounds b)
{
    const float low[3] = {b.lower_x, b.lower_y, b.lower_z};
    const float high[3] = {b.upper_x, b.upper_y, b.upper_z};
    for (int axis = 0; axis < 3; axis++) {
        node->bound[0][axis][i] = low[axis];
        node->bound[1][axis][i] = high[axis];
    }
}

static void *make_node(RTCThreadLocalAllocator allocator, unsigned count, void *tree)
{
    (void)count, (void)tree;
    struct pm_tree_node *node =
        rtcThreadLocalAlloc(allocator, sizeof *node, alignof(struct pm_tree_node));
    clear_node(node);
    return node;
}

static void set_children(void *at, void **children, unsigned count, void *tree)
{
    struct pm_tree_node *node = at;
    (void)tree;
    for (unsigned i = 0; i < count; i++)
        node->child[i] = (pm_tree_link)children[i];
}

static void set_bounds(void *node, const struct RTCBounds **bounds, unsigned count, void *tree)
{
    (void)tree;
    for (unsigned i = 0; i < count; i++)
        set_box(node, i, *bounds[i]);
}

/* ---- leaves ---- */

/* The surface that an item is all of, if it is flat. */
static uint32_t flat_surface(const struct pm_ray_tree *tree, uint32_t item)
{
    const struct pm_body *body = tree->body;
    if (body->mesh.mesh && item < tree->flat_count)
        return item;
    if (item < tree->flat_count) {
        const struct pm_piece_owner *owner = &tree->pieces.owner[item];
        return owner->planar ? owner->shape : PM_NO_PRIMITIVE;
    }
    item -= tree->flat_count;
    if (item < tree->round_count && body->shapes[tree->round[item]].type == PM_RING)
        return tree->round[item];
    return PM_NO_PRIMITIVE;
}

static struct RTCBounds bounds_of(const struct RTCBuildPrimitive *p)
{
    return (struct RTCBounds){.lower_x = p->lower_x,
                              .lower_y = p->lower_y,
                              .lower_z = p->lower_z,
                              .upper_x = p->upper_x,
                              .upper_y = p->upper_y,
                              .upper_z = p->upper_z};
}

static void set_lane(const struct pm_ray_tree *tree, struct pm_tree_leaf *leaf, unsigned lane,
                     const struct RTCBuildPrimitive *primitive)
{
    pm_vec3 p[3] = {{NAN, NAN, NAN}, {NAN, NAN, NAN}, {NAN, NAN, NAN}};
    if (primitive->primID < tree->flat_count)
        triangle_corners(tree, primitive->primID, (int)primitive->geomID, p);
    for (int i = 0; i < 3; i++) {
        leaf->corner[i][0][lane] = (float)p[i].x;
        leaf->corner[i][1][lane] = (float)p[i].y;
        leaf->corner[i][2][lane] = (float)p[i].z;
    }
    leaf->item[lane] = primitive->primID;
    leaf->surface[lane] = flat_surface(tree, primitive->primID);
    if (leaf->boxes)
        set_box(leaf->boxes, lane, bounds_of(primitive));
}

static bool has_round(const struct pm_ray_tree *tree,
                      const struct RTCBuildPrimitive *primitives, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (primitives[i].primID >= tree->flat_count)
            return true;
    return false;
}

/* `boxes`: zeroed but for bounds that are inverted; or NULL if all are triangles. */
static void fill_leaf(const struct pm_ray_tree *tree, struct pm_tree_leaf *leaf,
                      struct pm_tree_node *boxes, const struct RTCBuildPrimitive *primitives,
                      size_t count)
{
    memset(leaf, 0, sizeof *leaf);
    leaf->boxes = boxes;
    leaf->lanes = (1U << count) - 1;
    for (unsigned i = 0; i < count; i++)
        set_lane(tree, leaf, i, &primitives[i]);
}

static void *make_leaf(RTCThreadLocalAllocator allocator,
                       const struct RTCBuildPrimitive *primitives, size_t count, void *context)
{
    const struct pm_ray_tree *tree = context;
    struct pm_tree_leaf *leaf =
        rtcThreadLocalAlloc(allocator, sizeof *leaf, alignof(struct pm_tree_leaf));
    struct pm_tree_node *boxes = NULL;
    if (has_round(tree, primitives, count))
        boxes = make_node(allocator, 0, context);
    fill_leaf(tree, leaf, boxes, primitives, count);
    return (void *)((pm_tree_link)leaf | 1);
}

/* ---- building ---- */

static pm_status no_memory(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "no memory for the ray structure");
}

static bool list_round(struct pm_ray_tree *tree)
{
    const struct pm_body *body = tree->body;
    tree->round = malloc(((size_t)body->shape_count + 1) * sizeof *tree->round);
    for (uint32_t i = 0; tree->round && i < body->shape_count; i++)
        if (body->shapes[i].type != PM_POLYGON)
            tree->round[tree->round_count++] = i;
    return tree->round;
}

static size_t list_primitives(const struct pm_ray_tree *tree, size_t items,
                              struct RTCBuildPrimitive *out)
{
    size_t count = 0;
    for (uint32_t i = 0; i < items; i++) {
        out[count++] = primitive_of(tree, i, 0);
        if (i < tree->pieces.count && !is_single(&tree->pieces.piece[i]))
            out[count++] = primitive_of(tree, i, 1);
    }
    return count;
}

/* Leaves one after the other, without a tree. */
static pm_status list(struct pm_ray_tree *tree, const struct RTCBuildPrimitive *primitives,
                      size_t count, pm_error *err)
{
    enum { MOST = PM_TREE_FEW / PM_TREE_WIDTH };
    struct pm_tree_leaf *leaves =
        aligned_alloc(alignof(struct pm_tree_leaf), MOST * sizeof *leaves);
    struct pm_tree_node *boxes =
        aligned_alloc(alignof(struct pm_tree_node), MOST * sizeof *boxes);
    tree->few = leaves;
    tree->few_boxes = boxes;
    if (!leaves || !boxes)
        return no_memory(err);
    for (size_t i = 0; i < count; i += PM_TREE_WIDTH, leaves++, boxes++) {
        size_t some = count - i < PM_TREE_WIDTH ? count - i : PM_TREE_WIDTH;
        clear_node(boxes);
        fill_leaf(tree, leaves, has_round(tree, primitives + i, some) ? boxes : NULL,
                  primitives + i, some);
        tree->few_count++;
    }
    return PM_OK;
}

static pm_status build(struct pm_ray_tree *tree, RTCDevice device,
                       struct RTCBuildPrimitive *primitives, size_t count, pm_error *err)
{
    struct RTCBuildArguments arguments = rtcDefaultBuildArguments();
    tree->memory = rtcNewBVH(device);
    arguments.maxBranchingFactor = PM_TREE_WIDTH;
    arguments.maxDepth = PM_TREE_DEPTH - 8;
    arguments.sahBlockSize = PM_TREE_WIDTH;

    arguments.minLeafSize = PM_TREE_WIDTH;
    arguments.maxLeafSize = PM_TREE_WIDTH;
    arguments.bvh = tree->memory;
    arguments.primitives = primitives;
    arguments.primitiveCount = arguments.primitiveArrayCapacity = count;
    arguments.createNode = make_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = make_leaf;
    arguments.userPtr = tree;
    tree->root = (pm_tree_link)rtcBuildBVH(&arguments);
    enum RTCError failure = rtcGetDeviceError(device);
    if (failure == RTC_ERROR_NONE)
        return PM_OK;
    return pm_error_set(err, PM_E_MEMORY, "Embree cannot build its tree (error %d)",
                        (int)failure);
}

pm_status pm_ray_tree_build(struct pm_ray_tree *tree, void *builder, const struct pm_body *body,
                            pm_error *err)
{
    tree->body = body;
    if (pm_pieces_build(body, &tree->pieces) || !list_round(tree))
        return no_memory(err);
    size_t flat = body->mesh.mesh ? body->own_count : tree->pieces.count;
    size_t items = flat + tree->round_count + body->instance_count;
    if (items > UINT32_MAX)
        return no_memory(err);
    tree->flat_count = (uint32_t)flat;
    size_t most = items + tree->pieces.count;
    struct RTCBuildPrimitive *primitives =
        aligned_alloc(alignof(struct RTCBuildPrimitive), (most + 1) * sizeof *primitives);
    if (!primitives)
        return no_memory(err);
    size_t count = list_primitives(tree, items, primitives);
    pm_status status = count <= PM_TREE_FEW ? list(tree, primitives, count, err)
                                            : build(tree, builder, primitives, count, err);
    free(primitives);
    return status;
}

void pm_ray_tree_clear(struct pm_ray_tree *tree)
{
    if (tree->memory)
        rtcReleaseBVH(tree->memory);
    pm_pieces_clear(&tree->pieces);
    free(tree->round);
    free(tree->few);
    free(tree->few_boxes);
    *tree = (struct pm_ray_tree){0};
}
