#include "world/near.h"

#include "world/ray_tree.h"
#include "world/surface.h"
#include "world/world_internal.h"

struct ball;
struct around;

/* What is asked of a leaf; true ends the walk. */
typedef bool ask_leaf(const struct ball *ball, const struct pm_tree_leaf *leaf);

/* A ball, and which way is up, as boxes and triangles of a tree see them. */
struct ball {
    ask_leaf *ask;
    struct around *around; /* what `ask` fills, or NULL */
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

/* Bits of the flat items that have their plane within the ball and are less level than
 * `cosine`. */
static unsigned planes_met(const struct ball *b, const struct pm_tree_leaf *leaf, double cosine)
{
    unsigned bits = 0;
    for (int i = 0; i < PM_TREE_WIDTH; i++) {
        float slope = 0, distance = -leaf->plane[3][i];
        for (int axis = 0; axis < 3; axis++) {
            slope += leaf->plane[axis][i] * b->u[axis];
            distance += leaf->plane[axis][i] * b->c[axis];
        }
        bool met = fabsf(slope) < (float)cosine && fabsf(distance) <= b->r;
        bits |= (unsigned)met << i;
    }
    return bits & leaf->flat;
}

static bool box_meets(const struct ball *b, const pm_vec3 p[4])
{
    pm_vec3 low = pm_vec3_min(pm_vec3_min(p[0], p[1]), pm_vec3_min(p[2], p[3]));
    pm_vec3 high = pm_vec3_max(pm_vec3_max(p[0], p[1]), pm_vec3_max(p[2], p[3]));
    pm_vec3 nearest = pm_vec3_max(low, pm_vec3_min(high, b->center));
    return pm_vec3_distance(nearest, b->center) <= (double)b->r;
}

/* Whether an item reaches above the tangent plane and has its box within the ball. */
static bool rises_near(const struct ball *b, uint32_t item)
{
    pm_vec3 p[4];
    pm_ray_tree_corners(b->body->tree, item, p);
    if (!box_meets(b, p))
        return false;
    for (int i = 0; i < 4; i++)
        if (pm_vec3_dot(pm_vec3_sub(p[i], b->center), b->up) > 0x1p-20)
            return true;
    return false;
}

/* ---- through a tree ---- */

static bool walk(const struct ball *ball);

static bool stands_in_instance(const struct ball *b, const struct pm_instance *instance)
{
    struct ball inner =
        ball_in(instance->body, b->base + instance->first, b->from,
                pm_instance_point_in(instance, b->center),
                pm_instance_direction_in(instance, b->up), b->radius / instance->unit);
    inner.ask = b->ask;
    return walk(&inner);
}

/* Whether a shape whose box is met has its surface within the ball. */
static bool shape_meets(const struct ball *b, const struct pm_shape *s)
{
    double distance = pm_vec3_distance(b->center, s->center);
    return !pm_shape_is_ball(s) || fabs(distance - s->r0) <= (double)b->r;
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
    if (b->base + index == b->from || !shape_meets(b, s))
        return false;
    return !pm_shape_is_planar(s) || fabs(pm_vec3_dot(s->axis, b->up)) < PM_STEEP_COSINE;
}

static bool leaf_stands(const struct ball *b, const struct pm_tree_leaf *leaf)
{
    for (unsigned flat = planes_met(b, leaf, PM_STEEP_COSINE); flat; flat &= flat - 1) {
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

/* True if a leaf's answer was. */
static bool walk(const struct ball *b)
{
    const struct pm_ray_tree *tree = b->body->tree;
    for (uint32_t i = 0; tree->few && i < tree->few_count; i++)
        if (b->ask(b, &tree->few[i]))
            return true;
    pm_tree_link stack[PM_TREE_STACK], *top = stack;
    if (tree->root)
        *top++ = tree->root;
    while (top > stack) {
        pm_tree_link at = *--top;
        if (at & 1) {
            if (b->ask(b, (const struct pm_tree_leaf *)(at - 1)))
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
    ball.ask = leaf_stands;
    return walk(&ball);
}

/* ---- what stands between ---- */

enum { ITEMS_MAX = 32 };

/* Photons of a surface that leans more do not count (photon_map.h), but for rounding. */
#define LEVEL (.5 - 0x1p-10)
/* All normals are the same to this cosine: then only what is steep hides. */
#define EVEN  (1 - 0x1p-20)
#define STEEP (PM_STEEP_COSINE + 0x1p-10)
/* Photons of the same normal count up to that share of their distance above the tangent plane
 * (photon_map.h). */
#define BAND .26
/* The step of stored positions, and a little: who is so near to a plane is on both sides. */
#define STEP 0x1p-30
/* Places are raised that much for their view: less than this [world units]. */
#define RAISED 0x1p-22
/* Rounding, and more. */
#define MARGIN 0x1p-36

struct item {
    pm_vec3 corner[4];
    struct pm_between_plane plane;
    double slope, low, high; /* heights over the tangent plane */
    bool itself;
    bool bears; /* photons that count may lie on it */
};

struct around {
    const pm_world *world;
    bool unknown;
    bool round; /* photons may lie on something round */
    bool even;  /* all surfaces whose photons may count have the same normal */
    uint32_t count, balls;
    double low, high; /* of where such photons lie, along the normal */
    struct item item[ITEMS_MAX];
    struct pm_between_ball ball[PM_BETWEEN_BALLS];
};

static double height_over(const struct pm_between_plane *plane, pm_vec3 p)
{
    return pm_vec3_dot(plane->normal, p) - plane->offset;
}

static struct item item_of(const struct ball *b, const pm_vec3 corner[4], bool itself)
{
    struct item out = {.itself = itself};
    pm_vec3 across[2] = {pm_vec3_sub(corner[1], corner[0]), pm_vec3_sub(corner[2], corner[0])};
    pm_vec3 normal = pm_vec3_normalize(pm_vec3_cross(across[0], across[1]));
    out.plane = (struct pm_between_plane){normal, pm_vec3_dot(normal, corner[0]), 0};
    for (int i = 0; i < 4; i++) {
        out.corner[i] = corner[i];
        out.plane.slack = fmax(out.plane.slack, fabs(height_over(&out.plane, corner[i])));
    }
    out.slope = fabs(pm_vec3_dot(normal, b->up));
    return out;
}

/* A flat item whose box is within the ball. */
static void take_flat(const struct ball *b, uint32_t item, bool itself)
{
    struct around *around = b->around;
    pm_vec3 corner[4];
    pm_ray_tree_corners(b->body->tree, item, corner);
    if (!box_meets(b, corner))
        return;
    if (around->count == ITEMS_MAX) {
        around->unknown = true;
        return;
    }
    struct item *out = &around->item[around->count++];
    *out = item_of(b, corner, itself);
    around->unknown |= !(out->slope <= 2) || !(out->plane.slack < 0x1p-20); /* a sliver; bent */
}

/* A round shape within the ball. */
static void take_shape(struct around *around, const struct pm_shape *s, bool itself)
{
    const pm_hit hit = {.material = s->material};
    around->round |= itself || pm_surface_may_store(around->world, &hit);
    if (itself || !pm_surface_blocks(around->world, &hit))
        return;
    if (!pm_shape_is_ball(s) || around->balls == PM_BETWEEN_BALLS)
        around->unknown = true;
    else
        around->ball[around->balls++] = (struct pm_between_ball){s->center, s->r0};
}

/* Anything else whose box is within the ball. */
static void take_other(const struct ball *b, uint32_t item)
{
    const struct pm_ray_tree *tree = b->body->tree;
    item -= tree->flat_count;
    if (item >= tree->round_count) {
        b->around->unknown = true;
        return;
    }
    const struct pm_shape *s = &b->body->shapes[tree->round[item]];
    if (shape_meets(b, s))
        take_shape(b->around, s, tree->round[item] == b->from);
}

static bool leaf_around(const struct ball *b, const struct pm_tree_leaf *leaf)
{
    unsigned flat = planes_met(b, leaf, INFINITY);
    unsigned others = leaf->boxes ? boxes_met(b, leaf->boxes) & leaf->lanes & ~leaf->flat : 0;
    for (unsigned bits = flat | others; bits; bits &= bits - 1) {
        int lane = __builtin_ctz(bits);
        if (leaf->item[lane] < b->body->tree->flat_count)
            take_flat(b, leaf->item[lane],
                      leaf->surface[lane] != PM_NO_PRIMITIVE && leaf->surface[lane] == b->from);
        else
            take_other(b, leaf->item[lane]);
    }
    return b->around->unknown;
}

static void find_evenness(struct around *around)
{
    around->even = !around->round;
    for (uint32_t i = 0; i < around->count; i++) {
        double slope = around->item[i].slope;
        around->even &= slope < LEVEL || slope >= EVEN;
    }
}

/* Heights of an item's corners over a plane, added to a range. */
static void add_heights(const struct item *item, const struct pm_between_plane *plane,
                        double *low, double *high)
{
    for (int i = 0; i < 4; i++) {
        double height = height_over(plane, item->corner[i]);
        *low = fmin(*low, height);
        *high = fmax(*high, height);
    }
}

/* Sorts out what photons cannot count on, and says at what heights the others lie. */
static void find_bearers(struct around *around, const struct ball *b)
{
    const struct pm_between_plane tangent = {b->up, pm_vec3_dot(b->up, b->center), 0};
    const double most = BAND * b->radius + RAISED;
    around->low = around->high = 0;
    for (uint32_t i = 0; i < around->count; i++) {
        struct item *item = &around->item[i];
        double low = INFINITY, high = -INFINITY;
        add_heights(item, &tangent, &low, &high);
        item->low = low;
        item->high = high;
        item->bears = item->slope >= LEVEL && !(around->even && (low > most || high < -most));
        around->low = item->bears ? fmin(around->low, low) : around->low;
        around->high = item->bears ? fmax(around->high, high) : around->high;
    }
    if (around->round) {
        around->low = -INFINITY;
        around->high = INFINITY;
    }
}

/* Whether what reaches from low to high stands above or below all places of photons. */
static bool is_aside(const struct around *around, double low, double high)
{
    return low > around->high + RAISED || high < around->low - RAISED;
}

/* Whether places where photons count lie on both sides of a plane. */
static bool parts(const struct around *around, pm_vec3 point,
                  const struct pm_between_plane *plane)
{
    double low = height_over(plane, point), high = low;
    for (uint32_t i = 0; i < around->count; i++)
        if (around->item[i].bears)
            add_heights(&around->item[i], plane, &low, &high);
    return around->round || (low < -STEP && high > STEP);
}

/* The same plane as one that is kept already: tiles of a wall. */
static bool is_kept(const pm_between *between, const struct pm_between_plane *plane)
{
    for (uint32_t i = 0; i < between->planes; i++) {
        const struct pm_between_plane *kept = &between->plane[i];
        double sign = pm_vec3_dot(kept->normal, plane->normal) < 0 ? -1 : 1;
        pm_vec3 off = pm_vec3_madd(kept->normal, -sign, plane->normal);
        if (pm_vec3_length(off) + fabs(kept->offset - sign * plane->offset) < 0x1p-40)
            return true;
    }
    return false;
}

static void keep_planes(const struct around *around, pm_between *out)
{
    for (uint32_t i = 0; i < around->count; i++) {
        const struct item *item = &around->item[i];
        if (item->itself || (around->even && item->slope > STEEP) ||
            is_aside(around, item->low, item->high) ||
            !parts(around, out->center, &item->plane) || is_kept(out, &item->plane))
            continue;
        if (out->planes == PM_BETWEEN_PLANES) {
            out->unknown = true;
            return;
        }
        out->plane[out->planes++] = item->plane;
    }
}

static void keep_balls(const struct around *around, pm_vec3 up, pm_between *out)
{
    for (uint32_t i = 0; i < around->balls; i++) {
        const struct pm_between_ball *ball = &around->ball[i];
        double height = pm_vec3_dot(pm_vec3_sub(ball->center, out->center), up);
        if (!is_aside(around, height - ball->radius, height + ball->radius))
            out->ball[out->balls++] = *ball;
    }
}

void pm_world_between(const pm_world *world, pm_vec3 point, pm_vec3 normal, double radius,
                      uint32_t from, pm_between *out)
{
    struct around around;
    around.world = world;
    around.count = around.balls = 0;
    around.unknown = around.round = false;
    out->unknown = false;
    out->planes = out->balls = 0;
    out->center = point;
    out->radius = radius;
    if (world->main->count == 0)
        return;
    struct ball ball = ball_in(world->main, 0, from, point, normal, radius + RAISED);
    ball.ask = leaf_around;
    ball.around = &around;
    out->unknown = walk(&ball);
    if (out->unknown)
        return;
    find_evenness(&around);
    find_bearers(&around, &ball);
    keep_planes(&around, out);
    keep_balls(&around, normal, out);
}

static bool plane_is_clear(const struct pm_between_plane *plane, pm_vec3 a, pm_vec3 b)
{
    double margin = plane->slack + MARGIN;
    double height = height_over(plane, a), other = height_over(plane, b);
    return fmin(height, other) > margin || fmax(height, other) < -margin;
}

/* Whether both places are inside, or the line between them passes by. */
static bool ball_is_clear(const struct pm_between_ball *ball, pm_vec3 a, pm_vec3 b)
{
    pm_vec3 way = pm_vec3_sub(b, a), to = pm_vec3_sub(ball->center, a);
    double length2 = pm_vec3_dot(way, way);
    double share = length2 > 0 ? fmin(fmax(pm_vec3_dot(to, way) / length2, 0), 1) : 0;
    if (pm_vec3_length(pm_vec3_madd(to, -share, way)) > ball->radius + MARGIN)
        return true;
    return pm_vec3_length(to) < ball->radius - MARGIN &&
           pm_vec3_distance(ball->center, b) < ball->radius - MARGIN;
}

bool pm_between_clear(const pm_between *between, pm_vec3 a, pm_vec3 b)
{
    const double reach = between->radius + RAISED;
    pm_vec3 from_a = pm_vec3_sub(a, between->center), from_b = pm_vec3_sub(b, between->center);
    bool clear = !between->unknown && pm_vec3_dot(from_a, from_a) <= reach * reach &&
                 pm_vec3_dot(from_b, from_b) <= reach * reach;
    for (uint32_t i = 0; clear && i < between->planes; i++)
        clear = plane_is_clear(&between->plane[i], a, b);
    for (uint32_t i = 0; clear && i < between->balls; i++)
        clear = ball_is_clear(&between->ball[i], a, b);
    return clear;
}
