#include "bench.h"

#include <string.h>

#include "language/language_internal.h"

/* Nanoseconds a node of function programs: operands and operations alike, library functions
 * included. Target: 40 at most. All but one program have no branch that is not taken, so that
 * each evaluation meets every node of the program once. */

enum { RAYS = 512, ROUNDS = 400, TRIES = 5 };

struct program {
    const char *name, *file, *text;
    double reals[12];
    uint32_t real_count;
};

static const struct program programs[] = {
    {"arithmetic",
     NULL,
     "(Px + Dx*Ny)*(Py - .3*Nx) + (Pz*Dy - Nz/(2 + Dx*Dx))*(1 + Dz*(Nx - Py*(Nz + Px)))",
     {0},
     0},
    {"rayinit: mod, bound, linterp",
     NULL,
     "linterp(bound(0, mod(Px, .7), 1), sq(Py + Dx), noneg(Pz)) + tri(Px, .4)*clip(Ny)",
     {0},
     0},
    {"clear sky", "skybright.cal", "skybr", {1, 50, 10, 7.3, .3, .4, .866}, 7},
    {"Perez's sky",
     "perezlum.cal",
     "skybright",
     {12, 8, -1, -.3, 10, -3, .45, .3, .4, .866},
     10},
    {"luminaire angles", "source.cal", "src_theta + src_phi4", {2.5}, 1},
    {"noise and its gradient", NULL, "noise3(Px, Py, Pz) + noise3x(Px, Py, Pz)", {0}, 0},
    {"marble: recursion, six octaves", "marble.cal", "marble", {.7}, 1},
};

static pm_function compile(pm_language *language, const struct program *p)
{
    pm_error err = PM_ERROR_INIT;
    uint32_t context = PM_CONTEXT_GLOBAL;
    size_t size;
    pm_function function;
    const struct pm_language_text text = {p->text, "bench", 1, 1};
    if (p->file) {
        const char *file = bench_need((void *)(uintptr_t)pm_language_standard(p->file, &size));
        bench_check(pm_language_read(language, p->file, file, size, &context, &err), &err);
    }
    const struct pm_function_request request = {.context = context,
                                                .texts = &text,
                                                .text_count = 1,
                                                .reals = p->reals,
                                                .real_count = p->real_count};
    bench_check(pm_language_compile(language, &request, &function, &err), &err);
    return function;
}

static void make_rays(struct pm_ray_values *rays)
{
    for (int i = 0; i < RAYS; i++)
        for (int k = 0; k < PM_RAY_VALUES; k++)
            rays[i].value[k] = (double)((i * 7919 + k * 104729) % 2003) / 2003 * .9 + .01;
}

static double time_one(const pm_language *language, pm_function function,
                       const struct pm_ray_values *rays, double *sum)
{
    double best = 1e9;
    for (int t = 0; t < TRIES; t++) {
        bench_time start = bench_now();
        for (int round = 0; round < ROUNDS; round++)
            for (int i = 0; i < RAYS; i++)
                *sum += pm_function_value(language, function, &rays[i], NULL, 0);
        double taken = bench_since(start).cpu * 1e9 / (ROUNDS * RAYS);
        best = taken < best ? taken : best;
    }
    return best;
}

int main(void)
{
    static struct pm_ray_values rays[RAYS];
    pm_language *language = bench_need(pm_language_new(PM_LANGUAGE_SCENE));
    double sum = 0;
    make_rays(rays);
    printf("%-32s %8s %10s %10s\n", "program", "nodes", "ns", "ns a node");
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++) {
        pm_function function = compile(language, &programs[i]);
        uint32_t nodes = language->programs[function]->code.op_count;
        double ns = time_one(language, function, rays, &sum);
        printf("%-32s %8u %10.1f %10.2f\n", programs[i].name, nodes, ns, ns / nodes);
    }
    pm_language_free(language);
    return sum == 0;
}
