#include "bench.h"

#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* What a user waits and pays for: pmclient mkpmap with an empty cache, its private server, the
 * worker, the store and the file included, one thread. The glass ball in a diffuse room of 2 m.
 * Targets: a million global photons within .7 CPU s, a million caustic ones within 1.5. Every
 * parent waits for its children, so theirs are all the CPU seconds. Of several rounds the
 * fastest counts. */

enum { ROUNDS = 3 };

static const char scene[] =
    "void plastic grey 0 0 5 .5 .5 .5 0 0\n"
    "void light lamp 0 0 3 10 10 10\n"
    "void dielectric glass 0 0 5 1 1 1 1.5 0\n"
    "grey polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n"
    "grey polygon ceiling 0 0 12 -1 -1 2 -1 1 2 1 1 2 1 -1 2\n"
    "grey polygon west 0 0 12 -1 -1 0 -1 1 0 -1 1 2 -1 -1 2\n"
    "grey polygon east 0 0 12 1 -1 0 1 -1 2 1 1 2 1 1 0\n"
    "grey polygon south 0 0 12 -1 -1 0 -1 -1 2 1 -1 2 1 -1 0\n"
    "grey polygon north 0 0 12 -1 1 0 1 1 0 1 1 2 -1 1 2\n"
    "lamp polygon panel 0 0 12 -.2 -.2 1.99 -.2 .2 1.99 .2 .2 1.99 .2 -.2 1.99\n"
    "glass sphere ball 0 0 4 0 0 .7 .3\n";

static char folder[] = "/tmp/pm_bench_XXXXXX";

static void need(int done, const char *what)
{
    if (done)
        return;
    perror(what);
    exit(1);
}

static double children_seconds(void)
{
    struct rusage used;
    getrusage(RUSAGE_CHILDREN, &used);
    return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

static void forget(void)
{
    static const char *const names[] = {"map",         "cache",           "cache-wal",
                                        "cache-shm",   "cache.pid",       "cache.lock",
                                        "cache.lease", "cache.lease.new", "cache.sock"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        unlink(names[i]);
}

/* Runs pmclient mkpmap; CPU and wall seconds of it all. */
static bench_time run(const char *option, const char *count, const char *passes)
{
    double before = children_seconds(), start = bench_clock(CLOCK_MONOTONIC);
    pid_t child = fork();
    need(child >= 0, "fork");
    if (!child) {
        execl(PM_BIN "/pmclient", "pmclient", "mkpmap", "-q", "-fo", "-n", "1", option, "map",
              count, "scene.rad", passes ? "--passes" : (char *)NULL, passes, (char *)NULL);
        perror(PM_BIN "/pmclient");
        _exit(1);
    }
    int status = 0;
    need(waitpid(child, &status, 0) == child, "waitpid");
    if (status)
        exit(1);
    return (bench_time){children_seconds() - before, bench_clock(CLOCK_MONOTONIC) - start};
}

static void measure(const char *name, const char *option, const char *count, const char *passes)
{
    bench_time best = {1e30, 1e30};
    struct stat file = {0};
    for (int round = 0; round < ROUNDS; round++) {
        forget();
        bench_time here = run(option, count, passes);
        best = here.cpu < best.cpu ? here : best;
        need(!stat("map", &file), "map");
    }
    printf("%-32s %8.3f %8.3f %12.1f\n", name, best.cpu, best.wall,
           1e-6 * (double)file.st_size);
}

int main(void)
{
    need(mkdtemp(folder) && !chdir(folder), folder);
    need(!setenv("PM_STORE", "cache", 1) && !unsetenv("PM_SERVER"), "environment");
    FILE *file = fopen("scene.rad", "w");
    need(file && fputs(scene, file) >= 0 && !fclose(file), "scene.rad");
    bench_title("mkpmap: all processes, empty cache, one thread; a glass ball in a room");
    printf("map                                 CPU s   wall s  megabytes\n");
    measure("a million global photons", "-apg", "1m", NULL);
    measure("a million caustic photons", "-apc", "1m", NULL);
    measure("64 passes of 64k global photons", "-apg", "64k", "64");
    measure("ten global photons", "-apg", "10", NULL);
    forget();
    unlink("scene.rad");
    need(!rmdir(folder), folder);
    return 0;
}
