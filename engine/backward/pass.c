#include "backward/backward_internal.h"

enum {
    TILE = 16,       /* edge of a square of pixels; neighbours ask for neighbouring photons */
    ROW_PROBES = 64, /* sensors that are one piece of work */
    PIECES_ASKED = 256, /* pieces between two questions whether to stop */
};

/* The pieces of one pass: tiles in rows, or runs of sensors. */
struct work {
    pm_accumulation *accumulation;
    struct pm_pass pass;
    uint32_t number; /* of the pass */
    size_t first;    /* piece of this round */
};

static size_t tiles_across(const pm_accumulation *a)
{
    return (a->camera.width + TILE - 1) / TILE;
}

static size_t piece_count(const pm_accumulation *a)
{
    if (a->probes)
        return (a->count + ROW_PROBES - 1) / ROW_PROBES;
    return tiles_across(a) * ((a->camera.height + TILE - 1) / TILE);
}

static void see_pixel(const struct work *work, uint32_t pixel, struct pm_queue *queue,
                      uint32_t slot)
{
    pm_accumulation *a = work->accumulation;
    struct pm_sampler sampler;
    struct pm_value *value = &a->values[pixel];
    double u[3];
    *value = (struct pm_value){0};
    pm_sampler_init(&sampler, a->seed, work->number, pixel);
    sampler.queue = queue;
    sampler.slot = slot;
    pm_sampler_draw(&sampler, PM_SAMPLE_LENS, u);
    pm_ray ray;
    if (!pm_camera_ray(&a->camera, pixel, u, &ray))
        return;
    struct pm_walk walk = {.ray = ray,
                           .media = pm_camera_media(&a->camera, a->world, ray.origin),
                           .throughput = {1, 1, 1},
                           .vertex = PM_VERTEX_EYE,
                           .emission = PM_EMISSION_SEEN,
                           .seen = true};
    pm_walk_run(&work->pass, &walk, &sampler, value);
}

_Static_assert(TILE *TILE <= (int)PM_QUEUE_VALUES && ROW_PROBES <= (int)PM_QUEUE_VALUES,
               "a piece shares a queue");

/* What the look-ups that waited have found for a value. */
static void add_late(struct pm_value *value, const struct pm_value *late)
{
    value->radiance = pm_rgb_add(value->radiance, late->radiance);
    value->variance = pm_rgb_add(value->variance, late->variance);
}

/* Every other bit of a pixel's place along the Morton curve of its tile. */
static uint32_t every_other(uint32_t place)
{
    return (place & 1) | (place >> 1 & 2) | (place >> 2 & 4) | (place >> 3 & 8);
}

/* Pixels along the Morton curve, so that look-ups that follow each other are near. */
static void see_tile(const struct work *work, size_t tile)
{
    const pm_accumulation *a = work->accumulation;
    const struct pm_camera *camera = &a->camera;
    size_t across = tiles_across(a);
    uint32_t left = (uint32_t)(tile % across) * TILE, top = (uint32_t)(tile / across) * TILE;
    struct pm_queue queue;
    for (int adding = 0; adding < 2; adding++) {
        if (adding)
            pm_queue_finish(&work->pass, &queue);
        else
            pm_queue_start(&queue, TILE * TILE);
        for (uint32_t i = 0; i < TILE * TILE; i++) {
            uint32_t x = left + every_other(i), y = top + every_other(i >> 1);
            if (x >= camera->width || y >= camera->height)
                continue;
            if (adding)
                add_late(&a->values[y * camera->width + x], &queue.values[i]);
            else
                see_pixel(work, y * camera->width + x, &queue, i);
        }
    }
}

static void see_probe(const struct work *work, size_t i, struct pm_queue *queue, uint32_t slot)
{
    pm_accumulation *a = work->accumulation;
    struct pm_sampler sampler;
    a->values[i] = (struct pm_value){0};
    pm_sampler_init(&sampler, a->seed, work->number, (uint32_t)i);
    sampler.queue = queue;
    sampler.slot = slot;
    (a->quantity == PM_IRRADIANCE ? pm_probe_irradiance : pm_probe_radiance)(
        &work->pass, &a->probes[i], &sampler, &a->values[i]);
}

static void see_probes(const struct work *work, size_t row)
{
    const pm_accumulation *a = work->accumulation;
    size_t first = row * ROW_PROBES, left = a->count - first;
    size_t count = left < ROW_PROBES ? left : ROW_PROBES;
    struct pm_queue queue;
    pm_queue_start(&queue, count);
    for (size_t i = 0; i < count; i++)
        see_probe(work, first + i, &queue, (uint32_t)i);
    pm_queue_finish(&work->pass, &queue);
    for (size_t i = 0; i < count; i++)
        add_late(&a->values[first + i], &queue.values[i]);
}

static void run_piece(void *context, size_t i, unsigned thread)
{
    (void)thread;
    const struct work *work = context;
    size_t piece = work->first + i;
    (work->accumulation->probes ? see_probes : see_tile)(work, piece);
}

pm_status pm_backward_pass(pm_accumulation *accumulation, uint32_t pass,
                           const pm_backward_maps *maps, pm_pool *pool,
                           bool (*cancelled)(void *), void *context, pm_error *err)
{
    struct work work = {.accumulation = accumulation, .number = pass};
    if (pass < accumulation->next_pass || pass == UINT32_MAX)
        return pm_error_set(err, PM_E_RANGE, "pass %u comes after pass %u; passes ascend", pass,
                            accumulation->next_pass - 1);
    pm_status st = pm_pass_init(&work.pass, accumulation->world, maps, err);
    size_t pieces = piece_count(accumulation);
    for (; !st && work.first < pieces; work.first += PIECES_ASKED) {
        size_t left = pieces - work.first;
        if (cancelled && cancelled(context))
            return pm_error_set(err, PM_E_CANCELLED, "cancelled during pass %u", pass);
        pm_pool_run(pool, left < PIECES_ASKED ? left : PIECES_ASKED, run_piece, &work);
    }
    if (!st)
        pm_accumulation_add(accumulation, pass);
    return st;
}
