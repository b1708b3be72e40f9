#include "world/octree_write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "files/octree_file.h"
#include "scene/freeze.h"
#include "world/shape.h"

/* Around the scene, as Radiance has it (oconv.c). */
#define MARGIN 1e-5

/* What can be met: a surface, or the box of an instance or a mesh. */
struct object {
    uint32_t number; /* in the file: Radiance counts every primitive and alias */
    bool is_box;
    uint32_t index; /* of the shape or the box */
};

/* A parallelepiped with right angles: centre and three half edges. */
struct box {
    pm_vec3 center, half[3];
};

struct writer {
    const pm_scene *scene;
    const pm_octree_options *options;
    pm_bytes *out;
    pm_error *err;
    pm_arena arena;
    double origin[3], size; /* of the cube [scene units], as they are printed */
    struct object *objects;
    struct pm_shape *shapes;
    struct box *boxes;
    size_t object_count, shape_count, box_count;
    uint32_t *sets; /* objects of the cubes at work, one set behind the other */
    double *reals;  /* of the primitive in hand */
    size_t set_capacity, real_capacity;
    double smallest, slack; /* half edges, in the frame of the shapes: the cube is [-1, 1]^3 */
};

static pm_status memory_error(const struct writer *w)
{
    return pm_error_set(w->err, PM_E_MEMORY, "not enough memory to write the octree");
}

static bool is_placed(const pm_primitive *p)
{
    return p->type == PM_INSTANCE || p->type == PM_MESH;
}

/* The primitive with the numbers that a reader of a frozen octree finds; they last until the
 * next. */
static pm_status as_read(struct writer *w, size_t index, pm_primitive *out)
{
    *out = w->scene->primitives[index];
    if (!w->options->frozen)
        return PM_OK;
    if (out->real_count > w->real_capacity) {
        double *more = realloc(w->reals, out->real_count * sizeof *more);
        if (!more)
            return memory_error(w);
        w->reals = more;
        w->real_capacity = out->real_count;
    }
    for (uint32_t i = 0; i < out->real_count; i++)
        w->reals[i] = pm_portable_rounded(out->reals[i]);
    out->reals = w->reals;
    return PM_OK;
}

/* ---- the cube ---- */

struct bounds {
    pm_vec3 low, high;
};

static void extend(struct bounds *b, pm_vec3 low, pm_vec3 high)
{
    b->low = pm_vec3_make(fmin(b->low.x, low.x), fmin(b->low.y, low.y), fmin(b->low.z, low.z));
    b->high =
        pm_vec3_make(fmax(b->high.x, high.x), fmax(b->high.y, high.y), fmax(b->high.z, high.z));
}

/* The prototype's box where the primitive places it. */
static struct box placed_box(const struct writer *w, const pm_primitive *p)
{
    const pm_prototype *prototype = &w->scene->prototypes[p->assets[0]];
    pm_vec3 half = pm_vec3_scale(pm_vec3_sub(prototype->high, prototype->low), .5);
    struct box box = {.center = pm_vec3_add(prototype->low, half),
                      .half = {{half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z}}};
    if (!p->transform)
        return box;
    box.center = pm_transform_point(p->transform, box.center);
    for (int i = 0; i < 3; i++)
        box.half[i] = pm_transform_vector(p->transform, box.half[i]);
    return box;
}

static pm_vec3 reach_of(const struct box *b)
{
    const pm_vec3 *h = b->half;
    return pm_vec3_make(fabs(h[0].x) + fabs(h[1].x) + fabs(h[2].x),
                        fabs(h[0].y) + fabs(h[1].y) + fabs(h[2].y),
                        fabs(h[0].z) + fabs(h[1].z) + fabs(h[2].z));
}

static pm_status find_bounds(struct writer *w, struct bounds *out)
{
    pm_status st = PM_OK;
    out->low = pm_vec3_make(INFINITY, INFINITY, INFINITY);
    out->high = pm_vec3_negate(out->low);
    for (size_t i = 0; !st && i < w->scene->main_count; i++) {
        pm_primitive p = w->scene->primitives[i];
        pm_vec3 low, high;
        if (!pm_primitive_is_surface(p.type) || p.type == PM_SOURCE)
            continue;
        if (is_placed(&p)) {
            const struct box box = placed_box(w, &p);
            low = pm_vec3_sub(box.center, reach_of(&box));
            high = pm_vec3_add(box.center, reach_of(&box));
        } else {
            st = as_read(w, i, &p);
            if (!st)
                st = pm_shape_scene_bounds(w->scene, &p, &low, &high, w->err);
        }
        if (!st)
            extend(out, low, high);
    }
    return st;
}

/* The value that a reader finds in the file. */
static double as_printed(double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.12g", value);
    pm_number_real(text, strlen(text), &value);
    return value;
}

static pm_status set_cube(struct writer *w, const struct bounds *b)
{
    const pm_octree_options *o = w->options;
    const double low[3] = {b->low.x, b->low.y, b->low.z};
    const double high[3] = {b->high.x, b->high.y, b->high.z};
    bool empty = !(b->low.x <= b->high.x);
    w->size = o->bounded ? o->edge + 2 * MARGIN : 0;
    for (int i = 0; !empty && !o->bounded && i < 3; i++)
        w->size = fmax(w->size, high[i] - low[i] + 2 * MARGIN);
    if (!isfinite(w->size) || w->size > 0x1p500)
        return pm_error_set(w->err, PM_E_RANGE, "the scene is too large for an octree");
    w->size = as_printed(w->size);
    for (int i = 0; i < 3; i++) {
        double from = o->bounded ? o->corner[i] - MARGIN : (low[i] + high[i] - w->size) / 2;
        w->origin[i] = empty && !o->bounded ? 0 : as_printed(from);
        if (!empty && o->bounded && (low[i] < w->origin[i] || high[i] > w->origin[i] + w->size))
            return pm_error_set(
                w->err, PM_E_RANGE,
                "-b: the cube does not hold the scene, which goes from %g %g %g "
                "to %g %g %g",
                low[0], low[1], low[2], high[0], high[1], high[2]);
    }
    return PM_OK;
}

/* ---- objects ---- */

static pm_vec3 into_frame(const struct pm_shape_frame *frame, pm_vec3 p)
{
    return pm_vec3_scale(pm_vec3_sub(p, frame->center), 1 / frame->scale);
}

static pm_status add_object(struct writer *w, const struct pm_shape_frame *frame, size_t index,
                            uint32_t number)
{
    pm_primitive p = w->scene->primitives[index];
    struct object *object = &w->objects[w->object_count];
    *object = (struct object){.number = number, .is_box = is_placed(&p)};
    if (object->is_box) {
        struct box box = placed_box(w, &p);
        box.center = into_frame(frame, box.center);
        for (int i = 0; i < 3; i++)
            box.half[i] = pm_vec3_scale(box.half[i], 1 / frame->scale);
        object->index = (uint32_t)w->box_count;
        w->boxes[w->box_count++] = box;
    } else {
        object->index = (uint32_t)w->shape_count;
        pm_status st = as_read(w, index, &p);
        if (!st)
            st = pm_shape_make(w->scene, &p, frame, &w->arena, &w->shapes[w->shape_count],
                               w->err);
        if (st)
            return st;
        w->shape_count++;
    }
    w->object_count++;
    return PM_OK;
}

static bool allocate(struct writer *w)
{
    size_t shapes = 0, boxes = 0;
    for (size_t i = 0; i < w->scene->main_count; i++) {
        const pm_primitive *p = &w->scene->primitives[i];
        boxes += is_placed(p);
        shapes += pm_primitive_is_surface(p->type) && p->type != PM_SOURCE && !is_placed(p) &&
                  !p->empty;
    }
    w->objects = malloc((shapes + boxes + 1) * sizeof *w->objects);
    w->shapes = malloc((shapes + 1) * sizeof *w->shapes);
    w->boxes = malloc((boxes + 1) * sizeof *w->boxes);
    return w->objects && w->shapes && w->boxes;
}

static pm_status list_objects(struct writer *w)
{
    double half = w->size / 2;
    const struct pm_shape_frame frame = {
        .center = {w->origin[0] + half, w->origin[1] + half, w->origin[2] + half},
        .scale = half,
        .tolerance = 0x1p-46};
    const pm_scene *scene = w->scene;
    pm_status st = allocate(w) ? PM_OK : memory_error(w);
    size_t aliases = 0;
    for (size_t i = 0; !st && i < scene->main_count; i++) {
        const pm_primitive *p = &scene->primitives[i];
        while (!w->options->frozen && aliases < scene->alias_count &&
               scene->aliases[aliases] <= i)
            aliases++;
        if (pm_primitive_is_surface(p->type) && p->type != PM_SOURCE && !p->empty)
            st = add_object(w, &frame, i, (uint32_t)(i + aliases));
    }
    return st;
}

/* ---- boxes and cubes ---- */

/* Whether the shadows of box and cube on the axis are apart. */
static bool is_apart(const struct box *b, pm_vec3 to_box, double half, pm_vec3 axis)
{
    double reach = half * (fabs(axis.x) + fabs(axis.y) + fabs(axis.z));
    for (int i = 0; i < 3; i++)
        reach += fabs(pm_vec3_dot(b->half[i], axis));
    return fabs(pm_vec3_dot(to_box, axis)) > reach;
}

/* Separating axes: the cube's, the box's, and those at right angles to an edge of each
 * (Gottschalk, Lin, Manocha, "OBBTree", SIGGRAPH 1996). */
static bool box_meets_cube(const struct box *b, pm_vec3 center, double half)
{
    static const pm_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    pm_vec3 to_box = pm_vec3_sub(b->center, center);
    for (int i = 0; i < 3; i++) {
        if (is_apart(b, to_box, half, axes[i]) || is_apart(b, to_box, half, b->half[i]))
            return false;
        for (int k = 0; k < 3; k++)
            if (is_apart(b, to_box, half, pm_vec3_cross(axes[i], b->half[k])))
                return false;
    }
    return true;
}

/* The cube's corners lie between the box's faces. */
static bool box_holds_cube(const struct box *b, pm_vec3 center, double half)
{
    pm_vec3 to_cube = pm_vec3_sub(center, b->center);
    for (int i = 0; i < 3; i++) {
        pm_vec3 h = b->half[i];
        double reach = half * (fabs(h.x) + fabs(h.y) + fabs(h.z));
        if (!(fabs(pm_vec3_dot(to_cube, h)) + reach <= pm_vec3_dot(h, h)))
            return false;
    }
    return true;
}

static bool meets(const struct writer *w, uint32_t object, pm_vec3 center, double half)
{
    const struct object *o = &w->objects[object];
    return o->is_box ? box_meets_cube(&w->boxes[o->index], center, half)
                     : pm_shape_meets_cube(&w->shapes[o->index], center, half);
}

/* ---- the tree ---- */

/* A cube, and the objects that meet it: sets[first .. first + count). */
struct cell {
    pm_vec3 center;
    double half;
    size_t first, count;
    size_t free;    /* from here on there is room for its children's sets */
    double entries; /* that the sets below it may have in all: surfaces in one place end, too */
};

enum { MOST_ENTRIES = 1024, FREE_ENTRIES = 1 << 21 }; /* for each object, in any case */

static bool reserve(struct writer *w, size_t end)
{
    if (end <= w->set_capacity)
        return true;
    uint32_t *more = realloc(w->sets, 2 * end * sizeof *more);
    if (!more)
        return false;
    w->sets = more;
    w->set_capacity = 2 * end;
    return true;
}

static bool is_divided(const struct writer *w, const struct cell *cell)
{
    uint32_t limit = w->options->set_size ? w->options->set_size : 6;
    size_t crossing = 0;
    double smallest = cell->count <= PM_OCTREE_SET ? w->smallest : w->smallest / 256;
    if (cell->count <= limit || cell->half / 2 < smallest)
        return false;
    for (size_t i = cell->first; i < cell->first + cell->count; i++) {
        const struct object *o = &w->objects[w->sets[i]];
        crossing +=
            !o->is_box || !box_holds_cube(&w->boxes[o->index], cell->center, cell->half);
    }
    return crossing > limit;
}

static pm_status write_leaf(struct writer *w, const struct cell *cell)
{
    if (cell->count > PM_OCTREE_SET)
        return pm_error_set(
            w->err, PM_E_LIMIT,
            "%zu surfaces meet in a cube of %g, and an octree holds %d in one; "
            "take surfaces out that lie in the same place, or give a greater -r",
            cell->count, cell->half * w->size, PM_OCTREE_SET);
    pm_bytes_u8(w->out, cell->count ? PM_NODE_FULL : PM_NODE_EMPTY);
    if (!cell->count)
        return PM_OK;
    pm_portable_put_integer(w->out, (int64_t)cell->count, 4);
    for (size_t i = cell->first; i < cell->first + cell->count; i++)
        pm_portable_put_integer(w->out, w->objects[w->sets[i]].number, 4);
    return PM_OK;
}

/* Objects stay in the order of their numbers, as a set must have them. */
static struct cell make_child(struct writer *w, const struct cell *parent, int octant,
                              size_t first)
{
    double half = parent->half / 2;
    pm_vec3 offset = {octant & 1 ? half : -half, octant & 2 ? half : -half,
                      octant & 4 ? half : -half};
    struct cell child = {
        .center = pm_vec3_add(parent->center, offset), .half = half, .first = first};
    for (size_t i = parent->first; i < parent->first + parent->count; i++)
        if (meets(w, w->sets[i], child.center, half + w->slack))
            w->sets[child.first + child.count++] = w->sets[i];
    return child;
}

/* Cuts a cell into eight. False if there is too little to gain. */
static bool divide(struct writer *w, const struct cell *cell, struct cell children[8])
{
    size_t entries = 0;
    for (int octant = 0; octant < 8; octant++) {
        children[octant] = make_child(w, cell, octant, cell->free + entries);
        entries += children[octant].count;
    }
    for (int octant = 0; octant < 8; octant++) {
        double share = entries ? (double)children[octant].count / (double)entries : 0;
        children[octant].free = cell->free + entries;
        children[octant].entries = (cell->entries - (double)entries) * share;
    }
    return (double)entries <= cell->entries;
}

/* Recurses as deep as cubes can be halved before they are the smallest: 28 times at most. */
static pm_status write_cell(struct writer *w, const struct cell *cell)
{
    struct cell children[8];
    if (!is_divided(w, cell))
        return write_leaf(w, cell);
    if (!reserve(w, cell->free + 8 * cell->count))
        return memory_error(w);
    if (!divide(w, cell, children))
        return write_leaf(w, cell);
    pm_bytes_u8(w->out, PM_NODE_TREE);
    pm_status st = PM_OK;
    for (int octant = 0; !st && octant < 8; octant++)
        st = write_cell(w, &children[octant]);
    return st;
}

static pm_status write_tree(struct writer *w)
{
    uint32_t resolution = w->options->resolution ? w->options->resolution : 16384;
    struct cell top = {.half = 1, .count = w->object_count, .free = w->object_count};
    top.entries = MOST_ENTRIES * (double)top.count + FREE_ENTRIES;
    w->smallest = 1.0 / resolution;
    w->slack = 2e-6 * fmin(1 / w->size, 1); /* Radiance's FTINY, or a share of a small scene */
    if (!reserve(w, top.count + 1))
        return memory_error(w);
    for (uint32_t i = 0; i < top.count; i++)
        w->sets[i] = i;
    return write_cell(w, &top);
}

/* ---- the file ---- */

static pm_status write_all(struct writer *w, const pm_bundle *bundle)
{
    struct bounds bounds;
    pm_record *records = NULL;
    bool frozen = w->options->frozen;
    pm_status st = find_bounds(w, &bounds);
    if (!st)
        st = set_cube(w, &bounds);
    if (!st && frozen)
        st = pm_scene_freeze(w->scene, bundle, &w->arena, &records, w->err);
    if (!st && w->size > 0)
        st = list_objects(w);
    if (st)
        return st;
    const pm_octree_file head = {.origin = {w->origin[0], w->origin[1], w->origin[2]},
                                 .size = w->size,
                                 .files = w->options->files,
                                 .file_count = frozen ? 0 : w->options->file_count,
                                 .objects = w->scene->main_count +
                                            (frozen ? 0 : w->scene->alias_count)};
    pm_octree_file_start(&head, w->options->command, w->out);
    if (w->object_count)
        st = write_tree(w);
    else
        pm_bytes_u8(w->out, PM_NODE_EMPTY);
    if (!st && frozen)
        st = pm_records_write(records, w->scene->main_count, w->out, w->err);
    return !st && pm_bytes_status(w->out) ? memory_error(w) : st;
}

pm_status pm_octree_write(const pm_scene *scene, const pm_bundle *bundle,
                          const pm_octree_options *options, pm_bytes *out, pm_error *err)
{
    struct writer w = {.scene = scene, .options = options, .out = out, .err = err};
    pm_status st = write_all(&w, bundle);
    free(w.objects);
    free(w.shapes);
    free(w.boxes);
    free(w.sets);
    free(w.reals);
    pm_arena_clear(&w.arena);
    return st;
}
