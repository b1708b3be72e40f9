#include "world/surface.h"

#include "base/maths.h"
#include "world/lobe.h"

/* ---- sums over the lobes ---- */

pm_rgb pm_surface_value(const pm_surface *surface, pm_event event, pm_vec3 wi)
{
    pm_rgb sum = {0, 0, 0};
    if (!pm_surface_has(surface, event))
        return sum;
    for (unsigned i = 0; i < surface->count; i++)
        if (surface->lobes[i].event == event)
            sum = pm_rgb_add(sum, pm_lobe_value(surface, &surface->lobes[i], wi));
    return sum;
}

bool pm_surface_albedo(const pm_surface *surface, pm_rgb *out)
{
    pm_rgb sum = {0, 0, 0};
    for (unsigned i = 0; i < surface->count; i++) {
        const pm_lobe *lobe = &surface->lobes[i];
        if (!pm_lobe_is_delta(lobe) &&
            (lobe->kind != PM_LOBE_DIFFUSE || lobe->coat || lobe->tilted))
            return false;
        sum = pm_rgb_add(sum, lobe->albedo);
    }
    *out = sum;
    return true;
}

pm_rgb pm_surface_part(const pm_surface *surface, pm_event event, unsigned side)
{
    pm_rgb sum = {0, 0, 0};
    for (unsigned i = 0; i < surface->count; i++)
        if (surface->lobes[i].event == event && surface->lobes[i].sides & side)
            sum = pm_rgb_add(sum, surface->lobes[i].albedo);
    return sum;
}

/* ---- sampling ---- */

enum {
    DIFFUSE = 1 << PM_EVENT_DIFFUSE,
    SPECULAR = 1 << PM_EVENT_GLOSSY | 1 << PM_EVENT_SPECULAR | 1 << PM_EVENT_STRAIGHT,
};

/* Probability of each lobe, in proportion to its mean albedo weighted by the throughput. */
struct choice {
    double of[PM_LOBES_MAX];
};

static bool choose(const pm_surface *s, pm_rgb throughput, unsigned events, struct choice *out)
{
    double total = 0;
    if (s->count == 1) { /* the common case, without a division */
        out->of[0] = 1;
        return pm_rgb_mean(pm_rgb_mul(throughput, s->lobes[0].albedo)) > 0;
    }
    for (unsigned i = 0; i < s->count; i++) {
        const pm_lobe *lobe = &s->lobes[i];
        bool taken = events >> lobe->event & 1;
        out->of[i] = taken ? pm_rgb_mean(pm_rgb_mul(throughput, lobe->albedo)) : 0;
        total += out->of[i];
    }
    if (!(total > 0))
        return false;
    for (unsigned i = 0; i < s->count; i++)
        out->of[i] /= total;
    return true;
}

/* Picks a lobe; *u, less the probabilities before it, is uniform up to its own. */
static unsigned pick(const struct choice *choice, unsigned count, double *u)
{
    unsigned last = 0;
    double left = *u;
    for (unsigned i = 0; i < count; i++) {
        if (!(choice->of[i] > 0))
            continue;
        last = i;
        if (left < choice->of[i])
            break;
        left -= choice->of[i];
    }
    *u = left;
    return last; /* rounding may leave u beyond the last */
}

/* Density of wi among the lobes of finite density together. */
static double density(const pm_surface *s, const struct choice *choice, pm_vec3 wi)
{
    double sum = 0;
    for (unsigned i = 0; i < s->count; i++)
        if (choice->of[i] > 0)
            sum += choice->of[i] * pm_lobe_pdf(s, &s->lobes[i], wi);
    return sum;
}

static bool sample(const pm_surface *s, pm_rgb throughput, unsigned events, const double u[3],
                   struct choice *choice, pm_scatter *out)
{
    *out = (pm_scatter){.event = PM_EVENT_NONE, .radiance_scale = 1};
    if (!(s->events & events) || !choose(s, throughput, events, choice))
        return false;
    double rest = u[0];
    unsigned i = pick(choice, s->count, &rest);
    pm_lobe_sample(s, &s->lobes[i], u[1], u[2], out);
    if (choice->of[i] < 1)
        out->weight = pm_rgb_scale(out->weight, 1 / choice->of[i]);
    return out->event != PM_EVENT_NONE;
}

void pm_surface_sample(const pm_surface *surface, pm_rgb throughput, const double u[3],
                       pm_scatter *out)
{
    struct choice choice;
    sample(surface, throughput, DIFFUSE | SPECULAR, u, &choice, out);
}

void pm_surface_sample_specular(const pm_surface *surface, pm_rgb throughput, const double u[3],
                                pm_scatter *out)
{
    struct choice choice;
    if (sample(surface, throughput, SPECULAR, u, &choice, out) && out->event == PM_EVENT_GLOSSY)
        out->pdf = density(surface, &choice, out->wi);
}

void pm_surface_sample_diffuse(const pm_surface *surface, const double u[2], pm_scatter *out)
{
    *out = (pm_scatter){.event = PM_EVENT_NONE, .radiance_scale = 1};
    struct choice choice;
    if (!pm_surface_has(surface, PM_EVENT_DIFFUSE) ||
        !choose(surface, pm_rgb_grey(1), DIFFUSE, &choice))
        return;
    double rest = u[0];
    unsigned i = pick(&choice, surface->count, &rest);
    rest = fmin(rest / choice.of[i], 0x1.fffffep-1);
    pm_lobe_sample(surface, &surface->lobes[i], rest, u[1], out);
    if (out->event == PM_EVENT_NONE)
        return;
    out->pdf = density(surface, &choice, out->wi);
    out->weight = pm_rgb_scale(pm_surface_value(surface, PM_EVENT_DIFFUSE, out->wi),
                               out->pdf > 0 ? 1 / out->pdf : 0);
}

double pm_surface_glossy_pdf(const pm_surface *surface, pm_rgb throughput, pm_vec3 wi)
{
    struct choice choice;
    if (!pm_surface_has(surface, PM_EVENT_GLOSSY) ||
        !choose(surface, throughput, SPECULAR, &choice))
        return 0;
    return density(surface, &choice, wi);
}

/* ---- photons ---- */

static bool is_uniform(const pm_lobe *lobe)
{
    return lobe->kind == PM_LOBE_DIFFUSE && !lobe->coat && !lobe->tilted;
}

bool pm_surface_photons(const pm_surface *surface, unsigned side, bool *uniform, pm_rgb *weight)
{
    bool any = false;
    *uniform = true;
    *weight = pm_rgb_grey(0);
    for (unsigned i = 0; i < surface->count; i++) {
        const pm_lobe *lobe = &surface->lobes[i];
        if (lobe->event != PM_EVENT_DIFFUSE || !(lobe->sides & side))
            continue;
        any = true;
        *uniform = *uniform && is_uniform(lobe);
        *weight = pm_rgb_madd(*weight, 1 / PM_PI, lobe->albedo);
    }
    return any;
}

pm_rgb pm_surface_photon_weight(const pm_surface *surface, pm_vec3 wi)
{
    pm_rgb sum = {0, 0, 0};
    for (unsigned i = 0; i < surface->count; i++)
        if (surface->lobes[i].event == PM_EVENT_DIFFUSE)
            sum = pm_rgb_add(sum, pm_lobe_photon_weight(surface, &surface->lobes[i], wi));
    return sum;
}
