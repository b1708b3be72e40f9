#include "generate/generate.h"

#include <string.h>

#include "generate/generation.h"

typedef pm_status generator(pm_generation *g);

static const struct program {
    const char *name;
    generator *run;
} programs[] = {
    {"genbox", pm_genbox},   {"gensurf", pm_gensurf},     {"genrev", pm_genrev},
    {"genworm", pm_genworm}, {"genprism", pm_genprism},   {"genblinds", pm_genblinds},
    {"gensky", pm_gensky},   {"gendaylit", pm_gendaylit},
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
    return "genbox, gensurf, genrev, genworm, genprism, genblinds, gensky, gendaylit";
}

/* An option's value that follows a fixed number of words. */
static bool follows(const char *const *words, size_t first, size_t index, const char *option)
{
    return index > first && strcmp(words[index - 1], option) == 0;
}

pm_generate_word pm_generate_word_is(const char *const *words, size_t count, size_t index)
{
    const char *program = words[0];
    if (index >= count || index == 0)
        return PM_GENERATE_PLAIN;
    if (strcmp(program, "genprism") == 0)
        return index == 3 && words[3][0] != '-' && !(words[3][0] >= '0' && words[3][0] <= '9')
                   ? PM_GENERATE_FILE
                   : PM_GENERATE_PLAIN;
    bool surf = strcmp(program, "gensurf") == 0, rev = strcmp(program, "genrev") == 0;
    bool worm = strcmp(program, "genworm") == 0;
    if (surf && index == 5)
        return PM_GENERATE_PERHAPS_FILE;
    if ((surf || worm || rev) && follows(words, rev ? 6 : 8, index, "-f"))
        return PM_GENERATE_FUNCTION_FILE;
    return PM_GENERATE_PLAIN;
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
