#include "world/near.h"

#include "world/ray_tree.h"
#include "world/world_internal.h"

/* A ball, and which way is up, as boxes and triangles of a tree see them. */
struct ball {
    const struct pm_body *body;
    uint32_t base; /* number of the body's first surface */
    uint32_t from;
    pm_vec3 center, up; /* in the body's coordinates */
    double radius;
    float c[3], u[3], r; /* r errs to the far side */
};

static struct ball ball_in(const struct pm_body *body, uint32_t base, uint32_t from,
                           pm_vec3 center, pm_vec3 up, double radius)
{
    return (struct ball){.body = body,
                         .base = base,
                         .from = from,
                         .center = center,
                         .up = up,
                         .radius = radius,
                         .c = {(float)center.x, (float)center.y, (float)center.z},
                         .u = {(float)up.x, (float)up.y, (float)up.z},
                         .r = (float)(radius * (1 + 0x1p-20) + PM_TREE_MARGIN)};
}

/* ---- boxes and triangles, eight at a time ---- */

/* Farther along an axis than low .. high. */
static inline float beyond(float c, float low, float high)
{
    float below = low - c, above = c - high;
    float most = below > above ? below : above;
    return most > 0 ? most : 0;
}

static unsigned boxes_met(const struct ball *b, const struct pm_tree_node *node)
{
    unsigned bits = 0;
    for (int i = 0; i < PM_TREE_WIDTH; i++) {
        float d2 = 0;
        for (int axis = 0; axis < 3; axis++) {
            float d = beyond(b->c[axis], node->bound[0][axis][i], node->bound[1][axis][i]);
            d2 += d * d;
        }
        bits |= (unsigned)(d2 <= b->r * b->r) << i;
    }
    return bits;
}

/* Bits of the flat items that are steep and have their plane within the ball. */
static unsigned planes_met(const struct ball *b, const struct pm_tree_leaf *leaf)
{
    unsigned bits = 0;
    for (int i = 0; i < PM_TREE_WIDTH; i++) {
        float slope = 0, distance = -leaf->plane[3][i];
        for (int axis = 0; axis < 3; axis++) {
            slope += leaf->plane[axis][i] * b->u[axis];
            distance += leaf->plane[axis][i] * b->c[axis];
        }
        bool met = fabsf(slope) < (float)PM_STEEP_COSINE && fabsf(distance) <= b->r;
        bits |= (unsigned)met << i;
    }
    return bits & leaf->flat;
}

/* Whether an item reaches above the tangent plane and has its box within the ball. */
static bool rises_near(const struct ball *b, uint32_t item)
{
    pm_vec3 p[4];
    pm_ray_tree_corners(b->body->tree, item, p);
    pm_vec3 low = pm_vec3_min(pm_vec3_min(p[0], p[1]), pm_vec3_min(p[2], p[3]));
    pm_vec3 high = pm_vec3_max(pm_vec3_max(p[0], p[1]), pm_vec3_max(p[2], p[3]));
    pm_vec3 nearest = pm_vec3_max(low, pm_vec3_min(high, b->center));
    if (pm_vec3_distance(nearest, b->center) > (double)b->r)
        return false;
    for (int i = 0; i < 4; i++)
        if (pm_vec3_dot(pm_vec3_sub(p[i], b->center), b->up) > 0x1p-20)
            return true;
    return false;
}

/* ---- through a tree ---- */

static bool stands_in(const struct ball *ball);

static bool stands_in_instance(const struct ball *b, const struct pm_instance *instance)
{
    struct ball inner =
        ball_in(instance->body, b->base + instance->first, b->from,
                pm_instance_point_in(instance, b->center),
                pm_instance_direction_in(instance, b->up), b->radius / instance->unit);
    return stands_in(&inner);
}

/* A round shape or an instance whose box is met. */
static bool item_stands(const struct ball *b, uint32_t item)
{
    const struct pm_ray_tree *tree = b->body->tree;
    item -= tree->flat_count;
    if (item >= tree->round_count)
        return stands_in_instance(b, &b->body->instances[item - tree->round_count]);
    uint32_t index = tree->round[item];
    const struct pm_shape *s = &b->body->shapes[index];
    if (b->base + index == b->from)
        return false;
    return !pm_shape_is_planar(s) || fabs(pm_vec3_dot(s->axis, b->up)) < PM_STEEP_COSINE;
}

static bool leaf_stands(const struct ball *b, const struct pm_tree_leaf *leaf)
{
    for (unsigned flat = planes_met(b, leaf); flat; flat &= flat - 1) {
        int lane = __builtin_ctz(flat);
        uint32_t surface = leaf->surface[lane];
        bool itself = surface != PM_NO_PRIMITIVE && b->base + surface == b->from;
        if (!itself && rises_near(b, leaf->item[lane]))
            return true;
    }
    if (!leaf->boxes)
        return false;
    for (unsigned bits = boxes_met(b, leaf->boxes) & leaf->lanes; bits; bits &= bits - 1) {
        uint32_t item = leaf->item[__builtin_ctz(bits)];
        if (item >= b->body->tree->flat_count && item_stands(b, item))
            return true;
    }
    return false;
}

static bool stands_in(const struct ball *b)
{
    const struct pm_ray_tree *tree = b->body->tree;
    for (uint32_t i = 0; tree->few && i < tree->few_count; i++)
        if (leaf_stands(b, &tree->few[i]))
            return true;
    pm_tree_link stack[PM_TREE_STACK], *top = stack;
    if (tree->root)
        *top++ = tree->root;
    while (top > stack) {
        pm_tree_link at = *--top;
        if (at & 1) {
            if (leaf_stands(b, (const struct pm_tree_leaf *)(at - 1)))
                return true;
            continue;
        }
        const struct pm_tree_node *node = (const struct pm_tree_node *)at;
        for (unsigned bits = boxes_met(b, node); bits; bits &= bits - 1)
            *top++ = node->child[__builtin_ctz(bits)];
    }
    return false;
}

bool pm_world_stands_near(const pm_world *world, pm_vec3 point, pm_vec3 normal, double radius,
                          uint32_t from)
{
    if (world->main->count == 0)
        return false;
    struct ball ball = ball_in(world->main, 0, from, point, normal, radius);
    return stands_in(&ball);
}
