#include "bench.h"

#include <math.h>
#include <string.h>
#include <sys/resource.h>

#include "base/bytes.h"
#include "base/rng.h"
#include "base/warp.h"
#include "files/octree_file.h"

/* CPU seconds and memory from scene text to a world with its hash. Target: a million primitives
 * in at most 4 CPU seconds and 1.5 GiB. Memory is the process's greatest so far, its own scene
 * text apart.
 *
 * Forest: as many instances of a tree of a thousand triangles. Target: a million in 1 GiB.
 *
 *   bench_world [PRIMITIVES [KIND]]   default 1000000 */

struct text {
    char *data;
    size_t size, capacity;
};

static void reserve(struct text *t)
{
    if (t->size + 512 <= t->capacity)
        return;
    t->capacity = 2 * t->capacity + 4096;
    t->data = bench_need(realloc(t->data, t->capacity));
}

#define ADD(t, ...)                                                                            \
    (reserve(t), (t)->size += (size_t)snprintf((t)->data + (t)->size, 512, __VA_ARGS__))

static const char materials[] = "void plastic grey 0 0 5 .5 .5 .5 0 0\n"
                                "void metal tin 0 0 5 .7 .7 .6 .8 .1\n"
                                "void light lamp 0 0 3 10 10 10\n";

/* Hills over the unit square. */
static double height(size_t i, size_t j, size_t across)
{
    double x = (double)i / (double)across, y = (double)j / (double)across;
    return .05 * sin(20 * x) * cos(17 * y) + .01 * sin(200 * x * y);
}

static void add_corner(struct text *t, size_t i, size_t j, size_t across)
{
    ADD(t, " %.9g %.9g %.9g", (double)i / (double)across, (double)j / (double)across,
        height(i, j, across));
}

static void add_triangle(struct text *t, size_t k, size_t across)
{
    size_t i = k / 2 % across, j = k / 2 / across, upper = k % 2;
    ADD(t, "grey polygon t%zu 0 0 9", k);
    add_corner(t, i, j, across);
    add_corner(t, i + 1, j + upper, across);
    add_corner(t, i + !upper, j + 1, across);
    ADD(t, "\n");
}

static void add_round(struct text *t, size_t k, size_t count)
{
    static const char *const words[] = {"sphere", "cylinder", "cone", "ring", "tube"};
    double step = 1 / sqrt((double)count + 1), r = .3 * step;
    double x = fmod((double)k * .61803398875, 1), y = (double)k / (double)count;
    double z = .2 + .3 * fmod((double)k * .7548776662, 1);
    size_t kind = k % 5;
    ADD(t, "%s %s r%zu 0 0 ", k % 7 ? "grey" : "tin", words[kind], k);
    if (kind == 0)
        ADD(t, "4 %.9g %.9g %.9g %.9g\n", x, y, z, r);
    else if (kind == 3)
        ADD(t, "8 %.9g %.9g %.9g .1 .2 1 %.9g %.9g\n", x, y, z, r / 2, r);
    else
        ADD(t, "%d %.9g %.9g %.9g %.9g %.9g %.9g %.9g", kind == 2 ? 8 : 7, x, y, z, x + r, y,
            z + r, r);
    if (kind == 2)
        ADD(t, " %.9g", r / 3);
    ADD(t, "\n");
}

static void add_box_side(struct text *t, size_t k, size_t count)
{
    double side = .2 / sqrt((double)count + 1);
    size_t box = k / 6, face = k % 6;
    double x = fmod((double)box * .5698402910, 1), y = fmod((double)box * .7548776662, 1);
    double low[3] = {x, y, .6}, p[4][3];
    size_t axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (size_t c = 0; c < 4; c++) {
        p[c][axis] = low[axis] + (face % 2 ? side : 0);
        p[c][u] = low[u] + ((c == 1 || c == 2) == (face % 2 == 1) ? side : 0);
        p[c][v] = low[v] + (c >= 2 ? side : 0);
    }
    ADD(t, "grey polygon b%zu 0 0 12", k);
    for (size_t c = 0; c < 4; c++)
        ADD(t, " %.9g %.9g %.9g", p[c][0], p[c][1], p[c][2]);
    ADD(t, "\n");
}

static void add_lamp(struct text *t)
{
    ADD(t, "lamp polygon lamp1 0 0 12 0 0 1 0 1 1 1 1 1 1 0 1\n");
}

static void triangles(struct text *t, size_t count)
{
    size_t across = (size_t)ceil(sqrt((double)count / 2));
    for (size_t k = 0; k + 1 < count; k++)
        add_triangle(t, k, across);
    add_lamp(t);
}

static void rounds(struct text *t, size_t count)
{
    for (size_t k = 0; k + 1 < count; k++)
        add_round(t, k, count);
    add_lamp(t);
}

static void boxes(struct text *t, size_t count)
{
    for (size_t k = 0; k + 1 < count; k++)
        add_box_side(t, k, count);
    add_lamp(t);
}

static void mixed(struct text *t, size_t count)
{
    size_t part = count / 3, across = (size_t)ceil(sqrt((double)part / 2));
    for (size_t k = 0; k < part; k++) {
        add_triangle(t, k, across);
        add_round(t, k, part);
    }
    for (size_t k = 0; k + 2 * part + 1 < count; k++)
        add_box_side(t, k, part);
    add_lamp(t);
}

/* ---- instances ---- */

/* An octree file that names tree.rad: a thousand triangles. */
static void add_tree(pm_bundle *bundle)
{
    pm_error err = PM_ERROR_INIT;
    const char *file = "tree.rad";
    const pm_octree_file head = {.size = 1, .files = &file, .file_count = 1, .objects = 1003};
    struct text text = {0};
    pm_bytes octree = {0};
    ADD(&text, "%s", materials);
    for (size_t k = 0; k < 1000; k++)
        add_triangle(&text, k, 23);
    pm_octree_file_start(&head, "oconv", &octree);
    pm_bytes_u8(&octree, PM_NODE_EMPTY);
    bench_check(pm_bundle_add(bundle, file, text.data, text.size, &err), &err);
    bench_check(pm_bundle_add(bundle, "tree.oct", octree.data, octree.size, &err), &err);
    pm_bytes_clear(&octree);
    free(text.data);
}

static void add_files(pm_bundle *bundle, const char *name, const char *text)
{
    pm_error err = PM_ERROR_INIT;
    bench_check(pm_bundle_add(bundle, name, text, strlen(text), &err), &err);
}

/* Trees in rows, each turned its own way. */
static void forest(struct text *t, size_t count)
{
    size_t across = (size_t)sqrt((double)count);
    ADD(t, "%s!xform -a %zu -t 1.1 0 .001 -rz .7 -a %zu -t 0 1.2 .002 place.rad\n", materials,
        across, across);
    add_lamp(t);
}

/* One mesh of the hills, smooth, in Wavefront's format: the scene is a line. */
static void add_mesh(pm_bundle *bundle, size_t count)
{
    size_t across = (size_t)ceil(sqrt((double)count / 2));
    struct text t = {0};
    pm_error err = PM_ERROR_INIT;
    for (size_t j = 0; j <= across; j++)
        for (size_t i = 0; i <= across; i++) {
            ADD(&t, "v");
            add_corner(&t, i, j, across);
            ADD(&t, "\nvn 0 %.6g 1\nvt %.6g %.6g\n", .1 * sin((double)i),
                (double)i / (double)across, (double)j / (double)across);
        }
    ADD(&t, "usemtl grey\n");
    for (size_t k = 0; k < count; k++) {
        size_t i = k / 2 % across, j = k / 2 / across, upper = k % 2;
        size_t a = j * (across + 1) + i + 1, b = a + 1 + upper * (across + 1);
        size_t c = a + !upper + across + 1;
        ADD(&t, "f %zu/%zu/%zu %zu/%zu/%zu %zu/%zu/%zu\n", a, a, a, b, b, b, c, c, c);
    }
    bench_check(pm_bundle_add(bundle, "hills.obj", t.data, t.size, &err), &err);
    free(t.data);
}

static void mesh(struct text *t, size_t count)
{
    (void)count;
    ADD(t, "%svoid mesh hills 1 hills.obj 0 0\n", materials);
    add_lamp(t);
}

static const struct kind {
    const char *name;
    void (*make)(struct text *t, size_t count);
} kinds[] = {{"mixed", mixed},  {"triangles", triangles}, {"boxes", boxes},
             {"round", rounds}, {"forest", forest},       {"mesh", mesh}};

/* Random rays per CPU second. */
static double ray_rate(const pm_world *world)
{
    enum { RAYS = 200000 };
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    bench_time start = bench_now();
    size_t met = 0;
    for (int i = 0; i < RAYS; i++) {
        double u[5];
        for (int k = 0; k < 5; k++)
            u[k] = pm_rng_uniform(&rng);
        pm_vec3 from = {2 * u[0] - 1, 2 * u[1] - 1, 2 * u[2] - 1};
        pm_ray ray = {from, pm_warp_sphere(u[3], u[4]), INFINITY, PM_NO_PRIMITIVE};
        pm_hit hit;
        met += pm_world_intersect(world, &ray, &hit);
    }
    return met ? RAYS / bench_since(start).cpu : 0;
}

static double peak_mib(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

static void run(const struct kind *kind, size_t count)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_world *world = NULL;
    struct text text = {0};
    ADD(&text, "%s", materials);
    kind->make(&text, count);
    pm_bundle *bundle = bench_need(pm_bundle_new());
    bench_check(pm_bundle_add(bundle, "scene.rad", text.data, text.size, &err), &err);
    add_tree(bundle);
    add_files(bundle, "place.rad", "void instance tree 1 tree.oct 0 0\n");
    if (kind->make == mesh)
        add_mesh(bundle, count);
    double own = (double)text.size / 1048576;
    free(text.data);
    bench_time start = bench_now();
    bench_check(pm_scene_parse(bundle, "scene.rad", NULL, &scene, &err), &err);
    double parse = bench_since(start).cpu, parsed = peak_mib();
    bench_check(pm_world_compile(scene, &world, &err), &err);
    char hash[PM_DIGEST_HEX];
    pm_digest digest = pm_world_hash(world);
    pm_digest_hex(&digest, hash);
    pm_world_info info;
    pm_world_info_get(world, &info);
    double all = bench_since(start).cpu;
    printf("%-10s %9zu %8.3f %8.3f %8.3f %8.0f %8.0f %9zu %.8s %8.3f\n", kind->name, count,
           parse, all - parse, all, parsed, peak_mib() - own, info.octree_nodes, hash,
           1e-6 * ray_rate(world));
    pm_world_free(world);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
}

int main(int argc, char **argv)
{
    size_t count = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000000;
    bench_title("world: from text to a world with its hash");
    printf("kind      primitives  parse s  world s    sum s  MiB then    after     nodes hash  "
           "   M rays/s\n");
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (argc < 3 || !strcmp(argv[2], kinds[i].name))
            run(&kinds[i], count);
    return 0;
}
