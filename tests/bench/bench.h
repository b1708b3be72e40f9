#ifndef PM_TESTS_BENCH_H
#define PM_TESTS_BENCH_H

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>

#include "base/error.h"
#include "scene/bundle.h"
#include "scene/scene.h"
#include "world/world.h"

/* What the benchmarks share: clocks, and a scene from `scenes/`. Cost is CPU seconds, user and
 * system, of all threads; wall seconds are shown beside it. Any failure ends the program with a
 * message. */

typedef struct bench_time {
    double cpu, wall; /* [s] */
} bench_time;

static inline double bench_clock(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static inline bench_time bench_now(void)
{
    return (bench_time){bench_clock(CLOCK_PROCESS_CPUTIME_ID), bench_clock(CLOCK_MONOTONIC)};
}

static inline bench_time bench_since(bench_time start)
{
    bench_time now = bench_now();
    return (bench_time){now.cpu - start.cpu, now.wall - start.wall};
}

static inline void bench_check(pm_status status, const pm_error *err)
{
    char text[1200];
    if (!status)
        return;
    pm_error_format(err, text, sizeof text);
    fprintf(stderr, "%s: %s\n", pm_status_name(status), text);
    exit(1);
}

static inline void *bench_need(void *made)
{
    if (made)
        return made;
    fprintf(stderr, "no memory\n");
    exit(1);
}

/* The world of a scene file's text. */
static inline pm_world *bench_world_of(const char *text, size_t size)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_world *world = NULL;
    pm_bundle *bundle = bench_need(pm_bundle_new());
    bench_check(pm_bundle_add(bundle, "scene.rad", text, size, &err), &err);
    bench_check(pm_scene_parse(bundle, "scene.rad", NULL, &scene, &err), &err);
    bench_check(pm_world_compile(scene, &world, &err), &err);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return world;
}

/* The world of a scene file that needs no others. */
static inline pm_world *bench_world(const char *path)
{
    struct stat info;
    FILE *file = fopen(path, "rb");
    if (!file || fstat(fileno(file), &info)) {
        perror(path);
        exit(1);
    }
    size_t size = (size_t)info.st_size;
    char *data = bench_need(malloc(size));
    if (fread(data, 1, size, file) != size) {
        perror(path);
        exit(1);
    }
    fclose(file);
    pm_world *world = bench_world_of(data, size);
    free(data);
    return world;
}

/* A heading with a rule below it. */
static inline void bench_title(const char *title)
{
    printf("\n%s\n", title);
    for (const char *c = title; *c; c++)
        putchar('-');
    putchar('\n');
}

#endif
