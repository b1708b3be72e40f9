#include "generate/generate.h"

#include <string.h>

#include "generate/generation.h"

typedef pm_status generator(pm_generation *g);

static const struct program {
    const char *name;
    generator *run;
} programs[] = {
    {"genbox", pm_genbox}, {"genprism", pm_genprism},   {"genblinds", pm_genblinds},
    {"gensky", pm_gensky}, {"gendaylit", pm_gendaylit},
};

static const struct program *find(const char *name)
{
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++)
        if (strcmp(programs[i].name, name) == 0)
            return &programs[i];
    return NULL;
}

bool pm_generate_knows(const char *program)
{
    return find(program) != NULL;
}

const char *pm_generate_programs(void)
{
    return "genbox, genprism, genblinds, gensky and gendaylit";
}

static pm_status run(pm_generation *g)
{
    const struct program *program = find(g->request->words[0]);
    g->at = 1;
    if (!program)
        return pm_generation_fail(g, 0, PM_E_UNSUPPORTED, "is not run here, only %s are",
                                  pm_generate_programs());
    return program->run(g);
}

pm_status pm_generate_measure(const pm_generate_request *request, pm_generate_size *out,
                              size_t *wrong, pm_error *err)
{
    pm_generate_size size = {0};
    pm_generation g = {.request = request, .size = &size, .wrong = wrong, .err = err};
    *wrong = 0;
    pm_status st = run(&g);
    if (!st)
        *out = size;
    return st;
}

pm_status pm_generate_run(const pm_generate_request *request, pm_generate_sink *sink,
                          void *sink_context, size_t *wrong, pm_error *err)
{
    pm_generation g = {.request = request,
                       .sink = sink,
                       .sink_context = sink_context,
                       .wrong = wrong,
                       .err = err};
    *wrong = 0;
    pm_status st = run(&g);
    pm_bytes_clear(&g.text);
    return st;
}
