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

/* What of a piece a primitive is: one of its triangles, or both if they make a parallelogram.
 */
enum { FIRST, SECOND, BOTH };

static pm_vec3 piece_corner(const struct pm_piece *p, int i)
{
    return pm_vec3_make(p->corner[0][i], p->corner[1][i], p->corner[2][i]);
}

/* Corners of one of the two triangles of a piece. */
static void piece_corners(const struct pm_piece *p, bool second, pm_vec3 out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = piece_corner(p, second && i ? i + 1 : i); /* 0 1 2, 0 2 3 */
}

/* Whether four corners, or three and the first again, go round a parallelogram: so well that in
 * float it is one. */
static bool is_parallelogram(const struct pm_piece *p)
{
    double off = 0;
    for (int i = 0; i < 3; i++)
        off += fabs(p->corner[i][0] + p->corner[i][2] - p->corner[i][1] - p->corner[i][3]);
    return off <= 0x1p-24;
}

static bool is_single(const struct pm_piece *p)
{
    return p->corner[0][0] == p->corner[0][3] && p->corner[1][0] == p->corner[1][3] &&
           p->corner[2][0] == p->corner[2][3];
}

static void triangle_corners(const struct pm_ray_tree *tree, uint32_t item, bool second,
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

void pm_ray_tree_corners(const struct pm_ray_tree *tree, uint32_t item, pm_vec3 out[4])
{
    triangle_corners(tree, item, false, out);
    out[3] = tree->body->mesh.mesh ? out[0] : piece_corner(&tree->pieces.piece[item], 3);
}

static void item_bounds(const struct pm_ray_tree *tree, uint32_t item, unsigned part,
                        pm_vec3 *low, pm_vec3 *high)
{
    if (item < tree->flat_count) {
        pm_vec3 p[4];
        triangle_corners(tree, item, part == SECOND, p);
        p[3] = part == BOTH ? piece_corner(&tree->pieces.piece[item], 3) : p[0];
        *low = pm_vec3_min(pm_vec3_min(p[0], p[1]), pm_vec3_min(p[2], p[3]));
        *high = pm_vec3_max(pm_vec3_max(p[0], p[1]), pm_vec3_max(p[2], p[3]));
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
                                             unsigned part)
{
    pm_vec3 low, high;
    item_bounds(tree, item, part, &low, &high);
    return (struct RTCBuildPrimitive){.lower_x = (float)(low.x - PM_TREE_MARGIN),
                                      .lower_y = (float)(low.y - PM_TREE_MARGIN),
                                      .lower_z = (float)(low.z - PM_TREE_MARGIN),
                                      .geomID = part,
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

/* From corner p[0] along p[1] and p[2]. A triangle without area has NaN, and is always tested.
 */
static void set_plane(struct pm_tree_leaf *leaf, unsigned lane, const pm_vec3 p[3])
{
    pm_vec3 a = pm_vec3_sub(p[1], p[0]), b = pm_vec3_sub(p[2], p[0]);
    pm_vec3 across = pm_vec3_cross(a, b);
    double square = pm_vec3_dot(across, across), length = sqrt(square);
    const pm_vec3 row[3] = {pm_vec3_scale(across, 1 / length),
                            pm_vec3_scale(pm_vec3_cross(b, across), 1 / square),
                            pm_vec3_scale(pm_vec3_cross(across, a), 1 / square)};
    for (int i = 0; i < 3; i++) {
        float(*out)[PM_TREE_WIDTH] = i ? leaf->along[i - 1] : leaf->plane;
        double offset = pm_vec3_dot(row[i], p[0]);
        out[0][lane] = (float)row[i].x;
        out[1][lane] = (float)row[i].y;
        out[2][lane] = (float)row[i].z;
        out[3][lane] = (float)(i ? -offset : offset);
    }
    leaf->steep[lane] = (float)fmax(pm_vec3_length(row[1]), pm_vec3_length(row[2]));
}

static void set_lane(const struct pm_ray_tree *tree, struct pm_tree_leaf *leaf, unsigned lane,
                     const struct RTCBuildPrimitive *primitive)
{
    pm_vec3 p[3] = {{NAN, NAN, NAN}, {NAN, NAN, NAN}, {NAN, NAN, NAN}};
    if (primitive->primID < tree->flat_count) {
        triangle_corners(tree, primitive->primID, primitive->geomID == SECOND, p);
        leaf->flat |= 1U << lane;
    }
    if (primitive->geomID == BOTH)
        p[2] = piece_corner(&tree->pieces.piece[primitive->primID], 3);
    set_plane(leaf, lane, p);
    leaf->most[lane] = primitive->geomID == BOTH ? 2 : 1;
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
        const struct pm_piece *piece = i < tree->pieces.count ? &tree->pieces.piece[i] : NULL;
        bool two = piece && !is_single(piece), both = two && is_parallelogram(piece);
        out[count++] = primitive_of(tree, i, both ? BOTH : FIRST);
        if (two && !both)
            out[count++] = primitive_of(tree, i, SECOND);
    }
    return count;
}

/* How many of the first primitives make a leaf: as many as it holds that have a plane, or have
 * none. */
static size_t leaf_size(const struct pm_ray_tree *tree,
                        const struct RTCBuildPrimitive *primitives, size_t count)
{
    size_t i = 0;
    bool flat = primitives[0].primID < tree->flat_count;
    while (i < count && i < PM_TREE_WIDTH && (primitives[i].primID < tree->flat_count) == flat)
        i++;
    return i;
}

/* Leaves one after the other, without a tree. */
static pm_status list(struct pm_ray_tree *tree, const struct RTCBuildPrimitive *primitives,
                      size_t count, pm_error *err)
{
    struct pm_tree_leaf *leaf =
        aligned_alloc(alignof(struct pm_tree_leaf), PM_TREE_FEW * sizeof *leaf);
    struct pm_tree_node *boxes =
        aligned_alloc(alignof(struct pm_tree_node), PM_TREE_FEW * sizeof *boxes);
    tree->few = leaf;
    tree->few_boxes = boxes;
    if (!leaf || !boxes)
        return no_memory(err);
    for (size_t done = 0; done < count; leaf++, boxes++) {
        size_t size = leaf_size(tree, primitives + done, count - done);
        clear_node(boxes);
        fill_leaf(tree, leaf, has_round(tree, primitives + done, size) ? boxes : NULL,
                  primitives + done, size);
        tree->few_count++;
        done += size;
    }
    return PM_OK;
}

static bool is_few(const struct pm_ray_tree *tree, const struct RTCBuildPrimitive *primitives,
                   size_t count)
{
    size_t done = 0;
    for (int leaves = 0; done < count && leaves < PM_TREE_FEW; leaves++)
        done += leaf_size(tree, primitives + done, count - done);
    return done == count;
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
    pm_status status = is_few(tree, primitives, count)
                           ? list(tree, primitives, count, err)
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
