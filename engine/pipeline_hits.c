#include "pipeline_internal.h"

#include <stdlib.h>
#include <string.h>

#include "world/selection.h"

/* The first hits of a job's sensors, while the scene and its names are there. */

static const char *keep(pm_answer *answer, const char *text)
{
    return pm_arena_text(&answer->names, text, strlen(text));
}

static bool name_hit(pm_run *run, const pm_scene *scene, uint32_t surface, pm_hit_names *out)
{
    *out = (pm_hit_names){"*", "*", "*"};
    if (surface == PM_NO_PRIMITIVE)
        return true;
    pm_surface_names names = pm_world_surface_names(run->world, surface);
    *out = (pm_hit_names){keep(run->answer, scene->primitives[names.primitive].name),
                          keep(run->answer, names.modifier), keep(run->answer, names.material)};
    return out->surface && out->modifier && out->material;
}

pm_status pm_run_first_hits(pm_run *run, const pm_scene *scene)
{
    const pm_job *job = run->job;
    pm_answer *answer = run->answer;
    answer->hits = calloc(job->sensor_count + 1, sizeof *answer->hits);
    answer->hit_names = calloc(job->sensor_count + 1, sizeof *answer->hit_names);
    bool complete = answer->hits && answer->hit_names;
    for (size_t i = 0; complete && i < job->sensor_count; i++) {
        answer->hits[i] = pm_sensor_first_hit(run->world, &job->sensors[i], job->quantity);
        complete = name_hit(run, scene, answer->hits[i].surface, &answer->hit_names[i]);
    }
    return complete ? PM_OK
                    : pm_error_set(run->err, PM_E_MEMORY, "no memory for what sensors meet");
}
