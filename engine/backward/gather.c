#include "backward/backward_internal.h"

void pm_gather(const struct pm_pass *pass, const struct pm_spot *spot, pm_rgb throughput,
               enum pm_vertex end, struct pm_sampler *sampler, struct pm_value *value)
{
    double u[3];
    pm_scatter scatter;
    pm_sampler_draw(sampler, PM_SAMPLE_GATHER, u);
    pm_surface_sample_diffuse(spot->surface, u, &scatter);
    if (scatter.event == PM_EVENT_NONE)
        return;
    struct pm_walk walk = {.ray = {.origin = spot->point,
                                   .direction = scatter.wi,
                                   .t_max = INFINITY,
                                   .from = spot->from},
                           .throughput = pm_rgb_mul(throughput, scatter.weight),
                           .vertex = end,
                           .emission = PM_EMISSION_NONE};
    walk.media = pm_spot_media(pass, spot, scatter.wi);
    if (!pm_rgb_is_black(walk.throughput))
        pm_walk_run(pass, &walk, sampler, value);
}
