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

static void see_pixel(const struct work *work, uint32_t pixel)
{
    pm_accumulation *a = work->accumulation;
    struct pm_sampler sampler;
    struct pm_value *value = &a->values[pixel];
    double u[3];
    *value = (struct pm_value){0};
    pm_sampler_init(&sampler, a->seed, work->number, pixel);
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

static void see_tile(const struct work *work, size_t tile)
{
    const struct pm_camera *camera = &work->accumulation->camera;
    size_t across = tiles_across(work->accumulation);
    uint32_t left = (uint32_t)(tile % across) * TILE, top = (uint32_t)(tile / across) * TILE;
    for (uint32_t y = top; y < top + TILE && y < camera->height; y++)
        for (uint32_t x = left; x < left + TILE && x < camera->width; x++)
            see_pixel(work, y * camera->width + x);
}

static void see_probe(const struct work *work, size_t i)
{
    pm_accumulation *a = work->accumulation;
    struct pm_sampler sampler;
    a->values[i] = (struct pm_value){0};
    pm_sampler_init(&sampler, a->seed, work->number, (uint32_t)i);
    (a->quantity == PM_IRRADIANCE ? pm_probe_irradiance : pm_probe_radiance)(
        &work->pass, &a->probes[i], &sampler, &a->values[i]);
}

static void run_piece(void *context, size_t i, unsigned thread)
{
    (void)thread;
    const struct work *work = context;
    const pm_accumulation *a = work->accumulation;
    size_t piece = work->first + i;
    if (!a->probes) {
        see_tile(work, piece);
        return;
    }
    for (size_t p = piece * ROW_PROBES; p < (piece + 1) * ROW_PROBES && p < a->count; p++)
        see_probe(work, p);
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
