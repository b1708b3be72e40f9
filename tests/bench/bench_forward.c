#include "bench.h"

#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "base/pool.h"
#include "base/rng.h"
#include "base/warp.h"
#include "bench_embree.h"
#include "forward/forward.h"

/* Photon paths emitted and global photons stored a CPU second, with one
 * thread and with two: on the peers box, and on the same box with two bumpy balls of 50,000
 * triangles each instead of its spheres. Targets: 2.2 M paths a CPU second on the first, on the
 * second 60 % of the rays a second that Embree alone traces there; CPU seconds of two threads
 * at most 1.08 times those of one. The runs alternate, and of each the one with the least CPU
 * seconds counts: other work on the machine disturbed it least. */

enum { ROUNDS = 7, BATCHES = 6 };

/* What aiming is worth: the caustic's irradiance in cells of the floor, of batches of aimed
 * paths and of those photons of global batches that are flagged as caustic ones. The work for a
 * given error goes by variance times CPU seconds. */
enum { CELLS = 40, AIM_BATCHES = 48 };

struct floor_light {
    double cpu, photons;
    double sum[CELLS * CELLS], squares[CELLS * CELLS];
};

/* ---- paths ---- */

struct result {
    bench_time time;
    double paths, rays, photons[PM_MAP_KINDS];
};

static struct result run_batches(const pm_forward *forward, pm_pool *pool)
{
    pm_error err = PM_ERROR_INIT;
    struct result result = {.paths = BATCHES * (double)PM_BATCH_PATHS};
    uint64_t before = pm_forward_rays(forward);
    bench_time start = bench_now();
    for (uint64_t index = 0; index < BATCHES; index++) {
        pm_batch out[PM_MAP_KINDS] = {0};
        unsigned kinds = 1U << PM_MAP_GLOBAL;
        bench_check(pm_forward_batch(forward, index, kinds, pool, NULL, NULL, out, &err), &err);
        for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
            result.photons[kind] += (double)out[kind].count;
            pm_batch_clear(&out[kind]);
        }
    }
    result.time = bench_since(start);
    result.rays = (double)(pm_forward_rays(forward) - before);
    return result;
}

static void add_batch(const pm_world *world, const pm_batch *batch, double flux_scale,
                      struct floor_light *light)
{
    static double cells[CELLS * CELLS];
    for (int c = 0; c < CELLS * CELLS; c++)
        cells[c] = 0;
    for (size_t i = 0; i < batch->count; i++) {
        pm_photon_record r;
        pm_photon_unpack(&batch->photons[i], flux_scale, &r);
        if (!r.specular)
            continue;
        light->photons++;
        pm_vec3 p = pm_world_to_scene(world, r.position);
        int x = (int)((p.x + 1) / 2 * CELLS), z = (int)((p.z + 1) / 2 * CELLS);
        if (r.normal.y > .9 && p.y < .01 && x >= 0 && x < CELLS && z >= 0 && z < CELLS)
            cells[z * CELLS + x] += r.flux.g / batch->paths * CELLS * CELLS / 4;
    }
    for (int c = 0; c < CELLS * CELLS; c++) {
        light->sum[c] += cells[c];
        light->squares[c] += cells[c] * cells[c];
    }
}

/* Variance of a batch's irradiance, mean over the cells. */
static double variance(const struct floor_light *light, double *mean)
{
    double sum = 0, n = AIM_BATCHES;
    *mean = 0;
    for (int c = 0; c < CELLS * CELLS; c++) {
        double m = light->sum[c] / n;
        sum += (light->squares[c] / n - m * m) * n / (n - 1);
        *mean += m / (CELLS * CELLS);
    }
    return sum / (CELLS * CELLS);
}

static void bench_aim(const pm_world *world, const pm_forward *forward, pm_pool *pool)
{
    static struct floor_light lights[2];
    static const char *const names[] = {"unaimed", "aimed"};
    const pm_map_kind kinds[2] = {PM_MAP_GLOBAL, PM_MAP_CAUSTIC};
    pm_error err = PM_ERROR_INIT;
    memset(lights, 0, sizeof lights);
    for (uint64_t index = 0; index < AIM_BATCHES; index++)
        for (int i = 0; i < 2; i++) {
            pm_batch out[PM_MAP_KINDS] = {0};
            bench_time start = bench_now();
            bench_check(
                pm_forward_batch(forward, index, 1U << kinds[i], pool, NULL, NULL, out, &err),
                &err);
            lights[i].cpu += bench_since(start).cpu;
            add_batch(world, &out[kinds[i]], pm_forward_flux_scale(forward), &lights[i]);
            pm_batch_clear(&out[kinds[i]]);
        }
    printf("caustic photons:\n");
    printf("emission   M paths / CPU s  M caustic / CPU s  mean on floor  error of a CPU s\n");
    double cost[2];
    for (int i = 0; i < 2; i++) {
        double mean, of_batch = variance(&lights[i], &mean);
        cost[i] = of_batch * lights[i].cpu / AIM_BATCHES;
        printf("%-8s %17.3f %18.3f %14.5f %17.5f\n", names[i],
               1e-6 * AIM_BATCHES * PM_BATCH_PATHS / lights[i].cpu,
               1e-6 * lights[i].photons / lights[i].cpu, mean, sqrt(cost[i]));
    }
    printf("aimed light needs %.3f of the CPU seconds for the same error\n", cost[1] / cost[0]);
}

static void keep_better(struct result *best, const struct result *other)
{
    if (!best->paths || other->time.cpu < best->time.cpu)
        *best = *other;
}

static void print_row(unsigned threads, const struct result *r)
{
    printf("%7u %8.3f %8.3f %16.3f %15.3f %18.3f\n", threads, r->time.cpu, r->time.wall,
           1e-6 * r->paths / r->time.cpu, 1e-6 * r->rays / r->time.cpu,
           1e-6 * r->photons[PM_MAP_GLOBAL] / r->time.cpu);
}

/* Prints the table; returns rays a CPU second with one thread. */
static double measure_paths(const pm_world *world, const char *title)
{
    pm_error err = PM_ERROR_INIT;
    pm_pool *pools[2] = {bench_need(pm_pool_new(1)), bench_need(pm_pool_new(2))};
    struct result results[2] = {0};
    pm_forward *forward = NULL;
    pm_forward_options options = pm_forward_defaults();
    bench_check(pm_forward_new(world, &options, pools[0], &forward, &err), &err);
    for (int round = 0; round < ROUNDS; round++)
        for (int i = 0; i < 2; i++) {
            struct result result = run_batches(forward, pools[i]);
            keep_better(&results[i], &result);
        }
    bench_title(title);
    printf("threads    CPU s   wall s  M paths / CPU s  M rays / CPU s  M global / CPU s\n");
    for (int i = 0; i < 2; i++)
        print_row(pm_pool_threads(pools[i]), &results[i]);
    printf("two threads to one: %.3f of the CPU seconds, %.3f of the wall seconds\n",
           results[1].time.cpu / results[0].time.cpu,
           results[1].time.wall / results[0].time.wall);
    bench_aim(world, forward, pools[0]);
    pm_forward_free(forward);
    for (int i = 0; i < 2; i++)
        pm_pool_free(pools[i]);
    return results[0].rays / results[0].time.cpu;
}

/* ---- a hundred thousand triangles ---- */

struct triangles {
    double (*corner)[9];
    size_t count;
    char *text;
    size_t size;
};

/* A triangle of the scene, and its line in the scene file. */
static void add_triangle(struct triangles *t, const char *material, const double corner[9])
{
    memcpy(t->corner[t->count++], corner, sizeof *t->corner);
    if (!material)
        return;
    t->size += (size_t)sprintf(t->text + t->size, "%s polygon t 0 0 9", material);
    for (int i = 0; i < 9; i++)
        t->size += (size_t)sprintf(t->text + t->size, " %.9g", corner[i]);
    t->text[t->size++] = '\n';
}

enum { ROWS = 158, COLUMNS = 159, MOST = 2 * 2 * ROWS * COLUMNS + 100 };

/* A point of the ball in that row and column. */
static pm_vec3 bumpy(pm_vec3 center, double radius, int row, int column)
{
    double st, ct, sp, cp;
    pm_sincos(PM_PI * row / ROWS, &st, &ct);
    pm_sincos(2 * PM_PI * (column % COLUMNS) / COLUMNS, &sp, &cp);
    pm_vec3 d = {st * cp, st * sp, ct};
    double bump = pm_sin(9 * d.x + 1) * pm_sin(11 * d.y) * pm_sin(10 * d.z + 2);
    return pm_vec3_madd(center, radius * (1 + .05 * bump), d);
}

static void add_ball(struct triangles *t, const char *material, pm_vec3 center, double radius)
{
    for (int row = 0; row < ROWS; row++)
        for (int column = 0; column < COLUMNS; column++) {
            pm_vec3 a = bumpy(center, radius, row, column);
            pm_vec3 b = bumpy(center, radius, row + 1, column);
            pm_vec3 c = bumpy(center, radius, row + 1, column + 1);
            pm_vec3 d = bumpy(center, radius, row, column + 1);
            const double first[9] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
            const double second[9] = {a.x, a.y, a.z, c.x, c.y, c.z, d.x, d.y, d.z};
            if (row < ROWS - 1) /* at a pole two corners are one */
                add_triangle(t, material, first);
            if (row > 0)
                add_triangle(t, material, second);
        }
}

/* The walls for Embree, which the scene file has already. */
static void add_walls(struct triangles *t)
{
    static const double quads[7][12] = {
        {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1},
        {-1, 2, -1, 1, 2, -1, 1, 2, 1, -1, 2, 1},
        {-1, 0, 1, -1, 2, 1, 1, 2, 1, 1, 0, 1},
        {1, 0, -1, 1, 0, 1, 1, 2, 1, 1, 2, -1},
        {-1, 0, -1, -1, 2, -1, -1, 2, 1, -1, 0, 1},
        {-.2, 1.98, -.2, .2, 1.98, -.2, .2, 1.98, .2, -.2, 1.98, .2},
        {-.2, 1.9801, -.2, -.2, 1.9801, .2, .2, 1.9801, .2, .2, 1.9801, -.2},
    };
    for (int i = 0; i < 7; i++) {
        const double *q = quads[i];
        const double second[9] = {q[0], q[1], q[2], q[6], q[7], q[8], q[9], q[10], q[11]};
        add_triangle(t, NULL, q);
        add_triangle(t, NULL, second);
    }
}

/* The peers box up to its balls. */
static void read_box(struct triangles *t)
{
    FILE *file = fopen(PM_SOURCE_DIR "/scenes/peers_box/scene.rad", "rb");
    t->size = file ? fread(t->text, 1, 10000, file) : 0;
    t->text[t->size] = 0;
    char *balls = strstr(t->text, "crystal sphere");
    if (!balls) {
        fprintf(stderr, "scenes/peers_box/scene.rad is not what it was\n");
        exit(1);
    }
    t->size = (size_t)(balls - t->text);
    fclose(file);
}

static struct triangles make_triangles(void)
{
    struct triangles t = {bench_need(malloc(MOST * sizeof *t.corner)), 0,
                          bench_need(malloc(MOST * 200 + 20000)), 0};
    read_box(&t);
    add_ball(&t, "crystal", pm_vec3_make(-.42, .4, -.3), .35);
    add_ball(&t, "silver", pm_vec3_make(.45, .4, .25), .35);
    add_walls(&t);
    return t;
}

/* ---- rays alone ---- */

/* Where a ray goes on: the distance, or less than 0; the normal. */
typedef double trace_function(void *context, pm_ray *ray, pm_vec3 *normal);

struct scene_rays {
    const pm_world *world;
    bench_embree *embree;
};

static double trace_ours(void *context, pm_ray *ray, pm_vec3 *normal)
{
    const struct scene_rays *s = context;
    pm_hit hit;
    if (!pm_world_intersect(s->world, ray, &hit))
        return -1;
    *normal = hit.normal;
    ray->origin = hit.point;
    ray->from = hit.surface;
    return hit.t;
}

static double trace_embree(void *context, pm_ray *ray, pm_vec3 *normal)
{
    const struct scene_rays *s = context;
    double t = bench_embree_trace(s->embree, ray->origin, ray->direction, normal);
    ray->origin = pm_vec3_madd(ray->origin, t, ray->direction);
    return t;
}

/* Diffuse bounces from the lamp on, up to eight a path. Returns rays a CPU second. */
static double measure_rays(trace_function *trace, struct scene_rays *s, pm_vec3 lamp)
{
    enum { PATHS = 30000, BOUNCES = 8 };
    double rays = 0;
    pm_rng rng;
    bench_time start = bench_now();
    for (uint64_t i = 0; i < PATHS; i++) {
        pm_ray ray = {lamp, {0, 0, 0}, INFINITY, PM_NO_PRIMITIVE};
        pm_vec3 normal = {0, -1, 0};
        pm_rng_init(&rng, 1, PM_RNG_PATH, i);
        for (int bounce = 0; bounce < BOUNCES; bounce++) {
            pm_frame frame = pm_frame_make(normal);
            double u = pm_rng_uniform(&rng), v = pm_rng_uniform(&rng);
            ray.direction = pm_frame_to_world(&frame, pm_warp_cosine(u, v));
            rays++;
            if (trace(s, &ray, &normal) < 0)
                break;
            if (pm_vec3_dot(normal, ray.direction) > 0)
                normal = pm_vec3_negate(normal);
        }
    }
    return rays / bench_since(start).cpu;
}

static void compare_rays(const struct triangles *t, const pm_world *world, double forward)
{
    struct scene_rays s = {world, bench_embree_new((const double(*)[9])t->corner, t->count)};
    double best[2] = {0, 0};
    for (int round = 0; round < ROUNDS; round++) {
        pm_vec3 lamp = {0, 1.97, 0};
        double rate = measure_rays(trace_embree, &s, lamp);
        best[0] = fmax(best[0], rate);
        rate = measure_rays(trace_ours, &s, pm_world_from_scene(world, lamp));
        best[1] = fmax(best[1], rate);
    }
    printf(
        "rays alone, diffuse bounces: Embree %.3f M/s, ours %.3f M/s: %.3f of it; the forward "
        "pass %.3f of it\n",
        1e-6 * best[0], 1e-6 * best[1], best[1] / best[0], forward / best[0]);
    bench_embree_free(s.embree);
}

int main(void)
{
    pm_world *world = bench_world(PM_SOURCE_DIR "/scenes/peers_box/scene.rad");
    measure_paths(world, "forward: photon paths on the peers box");
    pm_world_free(world);
    struct triangles t = make_triangles();
    world = bench_world_of(t.text, t.size);
    double rays = measure_paths(world, "forward: the same with 100,000 triangles");
    compare_rays(&t, world, rays);
    pm_world_free(world);
    free(t.corner);
    free(t.text);
    return 0;
}
