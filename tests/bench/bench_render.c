#include "bench.h"

#include <math.h>

#include "pipeline.h"

/* Error against CPU time on the peers box, 256 x 256, progressive, one thread and two.
 *
 * bench_render [REF_A REF_B IDS]: two independent brute-force pictures (float32 RGB, rows from
 * the top) and a byte a pixel that says what it shows (1 floor, 2 to 5 the other walls). Then
 * the true error is shown too: mean of (I - A)(I - B), in which the noise of A and B cancels.
 */

enum { SIDE = 256, PIXELS = SIDE * SIDE, FLOOR = 1, LAST_WALL = 5 };

struct reference {
    float *a, *b;
    unsigned char *ids;
};

static void *read_file(const char *path, size_t size)
{
    FILE *file = fopen(path, "rb");
    void *data = bench_need(malloc(size));
    if (!file || fread(data, 1, size, file) != size) {
        perror(path);
        exit(1);
    }
    fclose(file);
    return data;
}

/* Over the pixels that show surfaces `first` to `last`. */
static double rmse(const struct reference *reference, const float *rgb, int first, int last)
{
    double sum = 0;
    size_t count = 0;
    for (size_t p = 0; p < PIXELS; p++) {
        if (reference->ids[p] < first || reference->ids[p] > last)
            continue;
        for (size_t i = 3 * p; i < 3 * p + 3; i++, count++)
            sum += ((double)rgb[i] - (double)reference->a[i]) *
                   ((double)rgb[i] - (double)reference->b[i]);
    }
    return sqrt(fmax(0, sum / (double)count));
}

static pm_bundle *load(pm_view *view)
{
    pm_error err = PM_ERROR_INIT;
    pm_bundle *bundle = NULL;
    const char *main_name;
    bench_check(pm_bundle_collect(PM_SOURCE_DIR "/scenes/peers_box/scene.rad", NULL, &bundle,
                                  &main_name, &err),
                &err);
    static const char text[] = "-vp 0 1 -4 -vd 0 0 1 -vu 0 1 0 -vh 40 -vv 40";
    *view = pm_view_default();
    bench_check(pm_view_parse(text, "view", view, &err), &err);
    return bundle;
}

static void run(const pm_bundle *bundle, const pm_view *view, uint32_t passes, unsigned threads,
                const struct reference *reference)
{
    pm_error err = PM_ERROR_INIT;
    const pm_job_hooks hooks = {NULL};
    pm_job job = {.kind = PM_JOB_RENDER,
                  .main_name = "scene.rad",
                  .wanted = {.estimator = PM_PROGRESSIVE, .ambient_bounces = 1},
                  .forward = pm_forward_defaults(),
                  .threads = threads,
                  .view = *view,
                  .width = SIDE,
                  .height = SIDE,
                  .passes = passes};
    pm_answer answer = {0};
    bench_time start = bench_now();
    bench_check(pm_job_run(&job, bundle, &hooks, &answer, &err), &err);
    bench_time spent = bench_since(start);
    double mean = 0;
    for (size_t i = 0; i < (size_t)3 * PIXELS; i++)
        mean += (double)answer.image.rgb[i] / (3.0 * PIXELS);
    printf("%7u %7u %8.2f %8.2f %10.4f %10.5f", passes, threads, spent.cpu, spent.wall,
           answer.error, mean);
    if (reference)
        printf(" %14.5f %12.5f", rmse(reference, answer.image.rgb, FLOOR, LAST_WALL),
               rmse(reference, answer.image.rgb, FLOOR, FLOOR));
    putchar('\n');
    pm_answer_clear(&answer);
}

int main(int argc, char **argv)
{
    struct reference reference;
    const struct reference *known = NULL;
    if (argc == 4) {
        size_t size = (size_t)3 * PIXELS * sizeof(float);
        reference.a = read_file(argv[1], size);
        reference.b = read_file(argv[2], size);
        reference.ids = read_file(argv[3], PIXELS);
        known = &reference;
    } else if (argc != 1) {
        fprintf(stderr, "usage: bench_render [REF_A REF_B IDS]\n");
        return 2;
    }
    pm_view view;
    pm_bundle *bundle = load(&view);
    bench_title("render: peers box, 256 x 256, progressive; the true mean is .09405");
    printf(" passes threads    CPU s   wall s  est.error       mean");
    printf(known ? "   RMSE diffuse   RMSE floor\n" : "\n");
    for (uint32_t passes = 4; passes <= 256; passes *= 4)
        run(bundle, &view, passes, 1, known);
    run(bundle, &view, 64, 2, known);
    pm_bundle_free(bundle);
    if (known) {
        free(reference.a);
        free(reference.b);
        free(reference.ids);
    }
    return 0;
}
