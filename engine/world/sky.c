#include "world/sky.h"

#include <math.h>
#include <string.h>

#include "base/maths.h"

/* Rows of equal height in z, columns of equal azimuth. Each cell lists the narrow sources that
 * reach into it; broad ones, many of which overlap if there are many, are tried every time. */
enum { ROWS = 64, COLUMNS = 128, CELLS = ROWS * COLUMNS, FEW = 8, MOST = 1 << 28 };

#define BROAD  (PM_PI / 18) /* half angle */
#define MARGIN 1e-9         /* beyond the rounding of azimuths and of z */

struct pm_sky_index {
    uint32_t broad_count, narrow_count;
    uint32_t *broad;
    uint32_t *first; /* [CELLS + 1]: cell c lists narrow[first[c]] up to first[c + 1] */
    uint32_t *narrow;
};

/* ---- cells ---- */

struct window {
    int row, last_row;
    int column, columns; /* from column on, around the sphere */
};

static int row_of(double z)
{
    int row = (int)floor((z + 1) / 2 * ROWS);
    return row < 0 ? 0 : row < ROWS ? row : ROWS - 1;
}

static double column_of(double azimuth)
{
    return (azimuth / (2 * PM_PI) + .5) * COLUMNS;
}

/* The cells that a cap may touch. */
static struct window window_of(const struct pm_distant *source)
{
    pm_vec3 d = source->direction;
    double half = source->half_angle + MARGIN, tilt = pm_acos(fmax(-1, fmin(d.z, 1)));
    struct window w = {.columns = COLUMNS};
    w.row = row_of(tilt + half < PM_PI ? pm_cos(tilt + half) - MARGIN : -1);
    w.last_row = row_of(tilt - half > 0 ? pm_cos(tilt - half) + MARGIN : 1);
    double sine = pm_sin(half) / pm_sin(tilt);
    if (tilt - half <= 0 || tilt + half >= PM_PI || !(sine < 1))
        return w; /* a pole is in it */
    double reach = pm_atan2(sine, sqrt(1 - sine * sine)) + MARGIN;
    double azimuth = pm_atan2(d.y, d.x);
    w.column = (int)floor(column_of(azimuth - reach));
    w.columns = (int)floor(column_of(azimuth + reach)) - w.column + 1;
    w.columns = w.columns < COLUMNS ? w.columns : COLUMNS;
    return w;
}

static bool is_broad(const pm_world *world, uint32_t source)
{
    return world->distant_count <= FEW || world->distants[source].half_angle > BROAD;
}

/* Counts the cells' sources up in `at`, and puts them there if `list` is given. */
static void spread(const pm_world *world, uint32_t *at, uint32_t *list)
{
    for (uint32_t i = 0; i < world->distant_count; i++) {
        if (is_broad(world, i))
            continue;
        struct window w = window_of(&world->distants[i]);
        for (int row = w.row; row <= w.last_row; row++)
            for (int k = 0; k < w.columns; k++) {
                int column = (w.column + k + COLUMNS) % COLUMNS;
                uint32_t *next = &at[row * COLUMNS + column];
                if (list)
                    list[*next] = i;
                ++*next;
            }
    }
}

/* ---- the index ---- */

static pm_status no_memory(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "out of memory for the distant sources");
}

static pm_status fill_narrow(pm_world *world, struct pm_sky_index *index, pm_error *err)
{
    uint32_t *first = pm_arena_array(&world->arena, CELLS + 1, sizeof *first);
    if (!first)
        return no_memory(err);
    spread(world, first + 1, NULL);
    uint64_t total = 0;
    for (int c = 0; c < CELLS; c++) {
        total += first[c + 1];
        if (total > MOST)
            return pm_error_set(err, PM_E_LIMIT, "too many distant sources: %zu",
                                world->distant_count);
        first[c + 1] = (uint32_t)total;
    }
    index->narrow = pm_arena_array(&world->arena, (size_t)total, sizeof *index->narrow);
    if (!index->narrow)
        return no_memory(err);
    spread(world, first, index->narrow); /* moves each cell's start to the next one's */
    memmove(first + 1, first, CELLS * sizeof *first);
    first[0] = 0;
    index->first = first;
    return PM_OK;
}

pm_status pm_sky_index_build(pm_world *world, struct pm_sky_index **out, pm_error *err)
{
    struct pm_sky_index *index = pm_arena_alloc(&world->arena, sizeof *index);
    if (index)
        index->broad =
            pm_arena_array(&world->arena, world->distant_count, sizeof *index->broad);
    if (!index || !index->broad)
        return no_memory(err);
    for (uint32_t i = 0; i < world->distant_count; i++)
        if (is_broad(world, i))
            index->broad[index->broad_count++] = i;
    index->narrow_count = (uint32_t)world->distant_count - index->broad_count;
    pm_status status = index->narrow_count ? fill_narrow(world, index, err) : PM_OK;
    if (!status)
        *out = index;
    return status;
}

static bool covers(const struct pm_distant *source, pm_vec3 direction)
{
    pm_vec3 off = pm_vec3_sub(direction, source->direction); /* |off|^2 = 2 (1 - cos) */
    return pm_vec3_dot(off, off) <= 2 * source->versine;
}

static void visit_list(const pm_world *world, const uint32_t *list, uint32_t count,
                       pm_vec3 direction, void (*visit)(void *context, uint32_t source),
                       void *context)
{
    for (uint32_t i = 0; i < count; i++)
        if (covers(&world->distants[list[i]], direction))
            visit(context, list[i]);
}

void pm_sky_index_visit(const struct pm_sky_index *index, const pm_world *world,
                        pm_vec3 direction, void (*visit)(void *context, uint32_t source),
                        void *context)
{
    visit_list(world, index->broad, index->broad_count, direction, visit, context);
    if (!index->narrow_count)
        return;
    int column = (int)column_of(pm_atan2(direction.y, direction.x)) % COLUMNS;
    int cell = row_of(direction.z) * COLUMNS + column;
    uint32_t first = index->first[cell], end = index->first[cell + 1];
    visit_list(world, index->narrow + first, end - first, direction, visit, context);
}
