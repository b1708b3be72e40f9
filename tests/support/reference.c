/* The path tracer: media, surfaces, next-event estimation, averages. */
#include "reference_internal.h"

#include <assert.h>

#define MAX_EVENTS  1000000
#define MEDIA_DEPTH 64

/* ---- random numbers ---- */

static uint64_t splitmix(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

void ref_rng_init(struct ref_rng *rng, uint64_t seed, uint64_t index)
{
    uint64_t state = splitmix(&seed);
    state ^= splitmix(&index);
    for (int i = 0; i < 4; i++)
        rng->s[i] = splitmix(&state);
}

static uint64_t rotate_left(uint64_t x, int k)
{
    return (x << k) | (x >> (64 - k));
}

double ref_rng_uniform(struct ref_rng *rng)
{
    uint64_t *s = rng->s;
    uint64_t out = rotate_left(s[0] + s[3], 23) + s[0];
    uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate_left(s[3], 45);
    return (double)(out >> 11) * 0x1p-53;
}

/* ---- rays ---- */

struct ray {
    struct vec origin, direction; /* unit direction */
    const struct shape *from;     /* the shape it starts on, NULL in free space */
};

struct hit {
    const struct shape *shape; /* NULL: nothing, t is INFINITY */
    double t;
    struct vec point;
    struct vec normal; /* towards where the ray comes from */
    double cosine;     /* between normal and the way back, > 0 */
    bool front;
};

/* Which of two hits counts: the nearer one, and the opaque one where they coincide. */
static bool beats(const struct ref_scene *scene, const struct shape *shape, double t,
                  const struct hit *best)
{
    if (!best->shape || fabs(t - best->t) > scene->epsilon)
        return t < best->t;
    bool clear = material_is_transparent(shape_material(scene, shape));
    bool best_clear = material_is_transparent(shape_material(scene, best->shape));
    return clear == best_clear ? t < best->t : best_clear;
}

static struct hit nearest(const struct ref_scene *scene, const struct ray *ray)
{
    struct hit best = {.shape = NULL, .t = INFINITY};
    for (size_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = &scene->shapes[i];
        double t[2];
        size_t n = ref_shape_roots(shape, ray->origin, ray->direction, ray->from == shape, t);
        size_t k = 0;
        while (k < n && t[k] <= scene->epsilon)
            k++;
        if (k < n && beats(scene, shape, t[k], &best)) {
            best.shape = shape;
            best.t = t[k];
        }
    }
    if (!best.shape)
        return best;
    best.point = vec_along(ray->origin, best.t, ray->direction);
    best.normal = ref_shape_normal(best.shape, best.point);
    best.front = vec_dot(best.normal, ray->direction) < 0;
    if (!best.front)
        best.normal = vec_scale(best.normal, -1);
    best.cosine = fmin(1, -vec_dot(best.normal, ray->direction));
    return best;
}

/* ---- media ---- */

/* The volumes around a point, outermost first, and what they add up to. */
struct media {
    const struct material *inside[MEDIA_DEPTH];
    int count;
    double extinction[3], scattering[3];
    int first; /* that counts */
    bool scatters, attenuates;
};

/* Everything above the innermost dielectric counts, and that dielectric; what is outside it
 * does not reach in. */
static void media_update(struct media *media)
{
    for (int c = 0; c < 3; c++)
        media->extinction[c] = media->scattering[c] = 0;
    media->first = 0;
    media->scatters = media->attenuates = false;
    for (int i = media->count; i-- > 0;) {
        const struct material *m = media->inside[i];
        for (int c = 0; c < 3; c++) {
            media->extinction[c] += m->extinction[c];
            media->scattering[c] += m->scattering[c];
            media->scatters = media->scatters || m->scattering[c] > 0;
            media->attenuates = media->attenuates || m->extinction[c] > 0;
        }
        media->first = i;
        if (m->kind == MATERIAL_DIELECTRIC)
            break;
    }
}

static void media_enter(struct media *media, const struct material *m)
{
    assert(media->count < MEDIA_DEPTH);
    media->inside[media->count++] = m;
    media_update(media);
}

/* Takes out the innermost volume of this material, if there is one. */
static void media_leave(struct media *media, const struct material *m)
{
    int i = media->count - 1;
    while (i >= 0 && media->inside[i] != m)
        i--;
    if (i < 0)
        return;
    for (media->count--; i < media->count; i++)
        media->inside[i] = media->inside[i + 1];
    media_update(media);
}

static void media_cross(struct media *media, const struct material *m, bool entering)
{
    if (entering)
        media_enter(media, m);
    else
        media_leave(media, m);
}

/* exp(-extinction * distance), also where one is 0 and the other infinite. */
static double transmittance(double extinction, double distance)
{
    return extinction > 0 ? exp(-extinction * distance) : 1;
}

/* A boundary of a volume on a ray, ordered by distance, then by number. */
struct crossing {
    double t;
    size_t shape;
    bool leaving;
};

static bool next_crossing(const struct ref_scene *scene, const struct ray *ray,
                          struct crossing *last)
{
    struct crossing best = {.t = INFINITY};
    for (size_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = &scene->shapes[i];
        if (!material_bounds_medium(shape_material(scene, shape)))
            continue;
        double t[2];
        size_t n = ref_shape_roots(shape, ray->origin, ray->direction, false, t);
        for (size_t k = 0; k < n; k++)
            if ((t[k] > last->t || (t[k] == last->t && i > last->shape)) && t[k] < best.t)
                best = (struct crossing){.t = t[k], .shape = i};
    }
    if (best.t == INFINITY)
        return false;
    struct vec point = vec_along(ray->origin, best.t, ray->direction);
    struct vec normal = ref_shape_normal(&scene->shapes[best.shape], point);
    best.leaving = vec_dot(normal, ray->direction) > 0;
    *last = best;
    return true;
}

/* Of material m's boundaries up to `end`: those that the ray leaves less those it enters. */
static int net_left(const struct ref_scene *scene, const struct ray *ray,
                    const struct material *m, const struct crossing *end)
{
    int net = 0;
    struct crossing at = {.t = scene->epsilon, .shape = SIZE_MAX};
    do {
        if (!next_crossing(scene, ray, &at))
            break;
        if (shape_material(scene, &scene->shapes[at.shape]) == m)
            net += at.leaving ? 1 : -1;
    } while (at.t != end->t || at.shape != end->shape);
    return net;
}

static int count_of(const struct material *const *list, int count, const struct material *m)
{
    int n = 0;
    for (int i = 0; i < count; i++)
        n += list[i] == m;
    return n;
}

/* Finds the volumes around a point: those that a ray leaves without having entered them, the
 * innermost first. */
static void media_at(const struct ref_scene *scene, struct vec point, struct vec direction,
                     struct media *media)
{
    *media = (struct media){.count = 0};
    if (!scene->has_media)
        return;
    struct ray ray = {.origin = point, .direction = direction};
    const struct material *found[MEDIA_DEPTH];
    int count = 0;
    struct crossing at = {.t = scene->epsilon, .shape = SIZE_MAX};
    while (next_crossing(scene, &ray, &at)) {
        const struct material *m = shape_material(scene, &scene->shapes[at.shape]);
        if (net_left(scene, &ray, m, &at) <= count_of(found, count, m))
            continue;
        assert(count < MEDIA_DEPTH);
        found[count++] = m;
    }
    while (count-- > 0)
        media_enter(media, found[count]);
}

/* ---- surfaces ---- */

/* Radiance's approximation to the Fresnel reflectance of a smooth surface (normal.c). */
static double fresnel_estimate(double cosine)
{
    return exp(-5.85 * cosine) - 0.00287989916;
}

#define FRESNEL_THRESHOLD 0.017999

static bool has_fresnel(const struct material *m)
{
    return m->specularity >= FRESNEL_THRESHOLD;
}

/* Parts of the light that leave a surface each way; linear RGB, each at most 1 in sum. */
struct lobes {
    double diffuse_reflect[3], diffuse_transmit[3];
    double mirror[3];   /* reflected as in a mirror */
    double straight[3]; /* passes as if nothing were there */
};

/* plastic, metal, trans: Radiance's normal.c for roughness 0. */
static void lobes_normal(const struct material *m, double cosine, struct lobes *lobes)
{
    double estimate = has_fresnel(m) ? fresnel_estimate(cosine) : 0;
    double specular = m->specularity + estimate * (1 - m->specularity);
    double transmitted = m->transmission * (1 - specular);
    for (int c = 0; c < 3; c++) {
        lobes->mirror[c] = specular;
        if (m->kind == MATERIAL_METAL)
            lobes->mirror[c] = estimate + m->color[c] * m->specularity * (1 - estimate);
        lobes->straight[c] = m->color[c] * transmitted * m->straight;
        lobes->diffuse_transmit[c] = m->color[c] * transmitted * (1 - m->straight);
        lobes->diffuse_reflect[c] = m->color[c] * (1 - transmitted - specular);
    }
}

/* A pane with reflectance r at each face and transmissivity a within: the sums of all orders.
 */
static double pane_transmittance(double r, double a)
{
    return (1 - r) * (1 - r) * a / (1 - r * r * a * a);
}

static double pane_reflectance(double r, double a)
{
    return r + r * a * pane_transmittance(r, a);
}

/* Fresnel reflectances, perpendicular (s) and parallel (p), where a ray with cosine c1 on the
 * side of index n1 goes on with c2 on that of n2. */
static void fresnel(double n1, double c1, double n2, double c2, double *s, double *p)
{
    double rs = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2);
    double rp = (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2);
    *s = rs * rs;
    *p = rp * rp;
}

/* glass: each polarisation for itself, then their mean (Radiance's glass.c). */
static void lobes_glass(const struct material *m, double cosine, struct lobes *lobes)
{
    double n = m->index, s, p;
    double inner = sqrt(1 - (1 - cosine * cosine) / (n * n));
    fresnel(1, cosine, n, inner, &s, &p);
    for (int c = 0; c < 3; c++) {
        double a = pow(m->color[c], 1 / inner);
        lobes->straight[c] = (pane_transmittance(s, a) + pane_transmittance(p, a)) / 2;
        lobes->mirror[c] = (pane_reflectance(s, a) + pane_reflectance(p, a)) / 2;
    }
}

/* For all materials but lights and boundaries of media. */
static void lobes_at(const struct material *m, const struct hit *hit, struct lobes *lobes)
{
    *lobes = (struct lobes){.mirror = {0}};
    if (m->kind == MATERIAL_GLASS)
        lobes_glass(m, hit->cosine, lobes);
    else if (m->kind != MATERIAL_MIRROR)
        lobes_normal(m, hit->cosine, lobes);
    else if (hit->front) /* a mirror's back is black */
        for (int c = 0; c < 3; c++)
            lobes->mirror[c] = m->color[c];
}

/* Factor of the diffuse BRDF for the light's direction. */
static double light_side_factor(const struct material *m, double cosine)
{
    return has_fresnel(m) ? 1 - fresnel_estimate(cosine) : 1;
}

/* Radiance that a light's front sends back along a ray in `direction`. */
static void emission(const struct material *m, struct vec direction, double radiance[3])
{
    bool dark =
        m->kind == MATERIAL_SPOTLIGHT && -vec_dot(direction, m->spot_axis) < m->spot_cosine;
    for (int c = 0; c < 3; c++)
        radiance[c] = dark ? 0 : m->color[c];
}

/* The distant source seen in a direction: the first light, else the first glow, else NULL. */
static const struct shape *source_towards(const struct ref_scene *scene, struct vec direction)
{
    const struct shape *glow = NULL;
    for (size_t i = 0; i < scene->shape_count; i++) {
        const struct shape *s = &scene->shapes[i];
        if (s->kind != SHAPE_SOURCE)
            continue;
        struct vec off = vec_sub(direction, s->axis); /* |off|^2 = 2 (1 - cos) */
        if (REF_PI * vec_dot(off, off) > s->area)
            continue;
        if (shape_material(scene, s)->kind != MATERIAL_GLOW)
            return s;
        if (!glow)
            glow = s;
    }
    return glow;
}

/* ---- paths ---- */

struct path {
    const struct ref_scene *scene;
    const struct ref_options *options;
    struct ref_rng rng;
    struct ray ray;
    struct media media;
    double throughput[3];
    double index_ratio;   /* (index at the sensor / index here)^2, see refract() */
    enum ref_class class; /* by the first event, counted from the sensor */
    bool lights_taken;    /* emission met now was already taken by next-event estimation */
    int diffuse_bounces;
    double value[REF_CLASSES][3]; /* what the path has gathered */
    bool truncated;
};

static void gather(struct path *p, enum ref_class class, const double radiance[3])
{
    for (int c = 0; c < 3; c++)
        p->value[class][c] += p->index_ratio * p->throughput[c] * radiance[c];
}

/* The class of light that comes over one more event. */
static enum ref_class class_after(const struct path *p, enum ref_class event)
{
    return p->class == REF_DIRECT ? event : p->class;
}

static bool may_scatter_diffusely(const struct path *p)
{
    int most = p->options->max_diffuse_bounces;
    return most < 0 || p->diffuse_bounces < most;
}

/* Continues as `event` says; `from` is NULL in a medium. */
static void go_on(struct path *p, enum ref_class event, struct vec point, struct vec direction,
                  const struct shape *from)
{
    p->class = class_after(p, event);
    p->ray = (struct ray){.origin = point, .direction = direction, .from = from};
    p->lights_taken = event == REF_INDIRECT && p->options->next_event;
    p->diffuse_bounces += event == REF_INDIRECT;
}

/* Survives with the largest throughput's probability. */
static bool roulette(struct path *p)
{
    double largest = fmax(p->throughput[0], fmax(p->throughput[1], p->throughput[2]));
    if (largest >= 1)
        return true;
    if (ref_rng_uniform(&p->rng) >= largest)
        return false;
    for (int c = 0; c < 3; c++)
        p->throughput[c] /= largest;
    return true;
}

/* ---- next-event estimation ---- */

enum vertex_kind { VERTEX_SENSOR, VERTEX_SURFACE, VERTEX_VOLUME };

/* A place where lights are sampled. */
struct vertex {
    enum vertex_kind kind;
    struct vec point;
    const struct shape *from;        /* surface */
    struct vec normal;               /* sensor, surface: on the side the path came from */
    struct vec direction;            /* volume: of the path that arrived */
    const struct material *material; /* surface */
    const struct lobes *lobes;       /* surface */
    const struct media *media;       /* volume */
};

/* Henyey and Greenstein 1941; the cosine is 1 for light that goes straight on. [1/sr] */
static double phase(double g, double cosine)
{
    double base = 1 + g * g - 2 * g * cosine;
    return (1 - g * g) / (4 * REF_PI * base * sqrt(base));
}

/* Of all media that count, each scattering its share. */
static double media_phase(const struct media *media, int channel, double cosine)
{
    double sum = 0;
    for (int i = media->first; i < media->count; i++) {
        const struct material *m = media->inside[i];
        if (m->scattering[channel] > 0)
            sum += m->scattering[channel] * phase(m->eccentricity, cosine);
    }
    return sum > 0 ? sum / media->scattering[channel] : 0;
}

/* BRDF times cosine, or phase function, for light from `direction`. The sensor is a white
 * diffuser, so irradiance is pi times what it gathers. False if there is none. */
static bool scatter_value(const struct vertex *v, struct vec direction, double value[3])
{
    double cosine = v->kind == VERTEX_VOLUME ? 0 : vec_dot(v->normal, direction);
    if (v->kind == VERTEX_SENSOR && cosine <= 0)
        return false;
    if (v->kind == VERTEX_VOLUME) {
        for (int c = 0; c < 3; c++)
            value[c] = media_phase(v->media, c, vec_dot(v->direction, direction));
        return value[0] > 0 || value[1] > 0 || value[2] > 0;
    }
    double common = fabs(cosine) / REF_PI;
    if (v->kind == VERTEX_SURFACE)
        common *= light_side_factor(v->material, fabs(cosine));
    const double *lobe = NULL;
    if (v->kind == VERTEX_SURFACE)
        lobe = cosine > 0 ? v->lobes->diffuse_reflect : v->lobes->diffuse_transmit;
    for (int c = 0; c < 3; c++)
        value[c] = lobe ? common * lobe[c] : common;
    return value[0] > 0 || value[1] > 0 || value[2] > 0;
}

static void attenuate(const struct media *media, double distance, double value[3])
{
    if (media->attenuates)
        for (int c = 0; c < 3; c++)
            value[c] *= transmittance(media->extinction[c], distance);
}

/* Takes a next-event ray through a hit: false if it is blocked there. */
static bool pass_straight(const struct hit *hit, const struct material *m, struct media *media,
                          double value[3])
{
    if (m->kind == MATERIAL_MIST) {
        media_cross(media, m, hit->front);
        return true;
    }
    if (m->kind != MATERIAL_GLASS && m->kind != MATERIAL_TRANS)
        return false;
    struct lobes lobes;
    lobes_at(m, hit, &lobes);
    for (int c = 0; c < 3; c++)
        value[c] *= lobes.straight[c];
    return value[0] > 0 || value[1] > 0 || value[2] > 0;
}

/* Multiplies `value` by what passes along `distance` of the ray; false if that is nothing. */
static bool shadow(const struct path *p, struct ray ray, double distance, double value[3])
{
    /* The light's own surface is no obstacle. */
    double slack = isfinite(distance) ? 1e-7 * distance : 0;
    struct media media = p->media;
    double left = distance;
    for (;;) {
        struct hit hit = nearest(p->scene, &ray);
        if (!hit.shape || hit.t >= left - slack) {
            attenuate(&media, left, value);
            return true;
        }
        attenuate(&media, hit.t, value);
        if (!pass_straight(&hit, shape_material(p->scene, hit.shape), &media, value))
            return false;
        left -= hit.t;
        ray.origin = hit.point;
        ray.from = hit.shape;
    }
}

static void sample_light(struct path *p, const struct vertex *v, enum ref_class class,
                         const struct shape *light)
{
    struct light_sample sample;
    double value[3], radiance[3];
    if (!ref_shape_sample(light, v->point, &p->rng, &sample) ||
        !scatter_value(v, sample.direction, value))
        return;
    if (light->kind == SHAPE_SOURCE && source_towards(p->scene, sample.direction) != light)
        return;
    emission(shape_material(p->scene, light), sample.direction, radiance);
    for (int c = 0; c < 3; c++)
        value[c] *= radiance[c] / sample.pdf_solid_angle;
    struct ray ray = {.origin = v->point, .direction = sample.direction, .from = v->from};
    if (shadow(p, ray, sample.distance, value))
        gather(p, class, value);
}

static void next_event(struct path *p, const struct vertex *v, enum ref_class class)
{
    if (!p->options->next_event)
        return;
    for (size_t i = 0; i < p->scene->shape_count; i++)
        if (material_emits(shape_material(p->scene, &p->scene->shapes[i])))
            sample_light(p, v, class, &p->scene->shapes[i]);
}

/* ---- events: each returns false where the path ends ---- */

static struct vec cosine_direction(struct vec normal, struct ref_rng *rng)
{
    double cosine = sqrt(1 - ref_rng_uniform(rng)); /* (0, 1] */
    double phi = 2 * REF_PI * ref_rng_uniform(rng);
    return vec_polar(normal, cosine, phi);
}

/* Draws from the distribution that phase() is the density of. */
static struct vec phase_direction(struct vec forward, double g, struct ref_rng *rng)
{
    double u = ref_rng_uniform(rng);
    double cosine = 1 - 2 * u;
    if (fabs(g) > 1e-4) {
        double s = (1 - g * g) / (1 + g - 2 * g * u);
        cosine = (1 + g * g - s * s) / (2 * g);
    }
    double phi = 2 * REF_PI * ref_rng_uniform(rng);
    return vec_polar(forward, fmax(-1, fmin(1, cosine)), phi);
}

static double scattering_of(const struct material *m)
{
    return m->scattering[0] + m->scattering[1] + m->scattering[2];
}

/* One of the media, in proportion to what it scatters of white light. */
static double draw_eccentricity(const struct media *media, struct ref_rng *rng)
{
    double sum = media->scattering[0] + media->scattering[1] + media->scattering[2];
    double x = ref_rng_uniform(rng) * sum;
    int i = media->first;
    for (; i + 1 < media->count && x >= scattering_of(media->inside[i]); i++)
        x -= scattering_of(media->inside[i]);
    return media->inside[i]->eccentricity;
}

/* The density of that draw and a direction of the drawn one's phase function. */
static double drawn_phase(const struct media *media, double cosine)
{
    double sum = media->scattering[0] + media->scattering[1] + media->scattering[2];
    double density = 0;
    for (int c = 0; c < 3; c++)
        density += media->scattering[c] / sum * media_phase(media, c, cosine);
    return density;
}

static bool scatter_in_medium(struct path *p, struct vec point)
{
    if (!may_scatter_diffusely(p))
        return false;
    const struct media media = p->media;
    struct vertex v = {
        .kind = VERTEX_VOLUME, .point = point, .direction = p->ray.direction, .media = &media};
    next_event(p, &v, class_after(p, REF_INDIRECT));
    double g = draw_eccentricity(&media, &p->rng);
    struct vec to = phase_direction(p->ray.direction, g, &p->rng);
    double cosine = vec_dot(p->ray.direction, to), density = drawn_phase(&media, cosine);
    for (int c = 0; c < 3; c++)
        p->throughput[c] *= media_phase(&media, c, cosine) / density;
    go_on(p, REF_INDIRECT, point, to, NULL);
    return true;
}

/* Chance of each channel to set the free path: its share of the throughput. */
static void channel_chances(const struct path *p, double chance[3])
{
    double sum = p->throughput[0] + p->throughput[1] + p->throughput[2];
    for (int c = 0; c < 3; c++)
        chance[c] = p->throughput[c] / sum;
}

static double free_path(struct path *p, const double chance[3])
{
    double u = ref_rng_uniform(&p->rng);
    int c = u < chance[0] ? 0 : u < chance[0] + chance[1] ? 1 : 2;
    double extinction = p->media.extinction[c];
    double depth = -log1p(-ref_rng_uniform(&p->rng));
    return extinction > 0 ? depth / extinction : INFINITY;
}

/* Moves through the medium as far as `distance`. One channel draws the free path, all three
 * weigh it by the mean density (balance heuristic over channels), which bounds the weights.
 * Returns true if the path scatters, with *point set. */
static bool medium_event(struct path *p, double distance, struct vec *point)
{
    const struct media *m = &p->media;
    if (!m->scatters) {
        attenuate(m, distance, p->throughput);
        return false;
    }
    double chance[3], pdf = 0;
    channel_chances(p, chance);
    double t = free_path(p, chance);
    bool scattered = t < distance;
    double gone = scattered ? t : distance;
    for (int c = 0; c < 3; c++) {
        double passed = transmittance(m->extinction[c], gone);
        pdf += chance[c] * passed * (scattered ? m->extinction[c] : 1);
        p->throughput[c] *= passed * (scattered ? m->scattering[c] : 1);
    }
    for (int c = 0; c < 3; c++)
        p->throughput[c] /= pdf;
    *point = vec_along(p->ray.origin, gone, p->ray.direction);
    return scattered;
}

static struct vec mirror_direction(const struct path *p, const struct hit *hit)
{
    return vec_unit(vec_along(p->ray.direction, 2 * hit->cosine, hit->normal));
}

/* Exact unpolarised Fresnel. Radiance scales with the square of the index: L/n^2 is constant
 * along a ray, so the path's value is multiplied by (n1/n2)^2 going from n1 to n2. */
static bool refract(struct path *p, const struct hit *hit, const struct material *m)
{
    double n1 = hit->front ? 1 : m->index, n2 = hit->front ? m->index : 1;
    double ratio = n1 / n2;
    double square = 1 - ratio * ratio * (1 - hit->cosine * hit->cosine);
    double inner = square > 0 ? sqrt(square) : 0;
    double perpendicular = 1, parallel = 1; /* total reflection */
    if (square > 0)
        fresnel(n1, hit->cosine, n2, inner, &perpendicular, &parallel);
    if (ref_rng_uniform(&p->rng) < (perpendicular + parallel) / 2) {
        go_on(p, REF_CAUSTIC, hit->point, mirror_direction(p, hit), hit->shape);
        return true;
    }
    struct vec to =
        vec_along(vec_scale(p->ray.direction, ratio), ratio * hit->cosine - inner, hit->normal);
    p->index_ratio *= ratio * ratio;
    media_cross(&p->media, m, hit->front);
    go_on(p, REF_CAUSTIC, hit->point, vec_unit(to), hit->shape);
    return true;
}

/* Crosses without an event: neither class nor the lights taken change. */
static void step_over(struct path *p, const struct hit *hit)
{
    p->ray.origin = hit->point;
    p->ray.from = hit->shape;
}

static bool scatter_diffusely(struct path *p, const struct hit *hit, const struct material *m,
                              struct vec normal)
{
    if (!may_scatter_diffusely(p))
        return false;
    struct vec to = cosine_direction(normal, &p->rng);
    double factor = light_side_factor(m, vec_dot(normal, to));
    for (int c = 0; c < 3; c++)
        p->throughput[c] *= factor;
    go_on(p, REF_INDIRECT, hit->point, to, hit->shape);
    return true;
}

/* Picks a lobe by its share of what the path carries; returns 0 to 3, or -1 for none. */
static int choose_lobe(struct path *p, const double *lobe[4])
{
    double weight[4] = {0, 0, 0, 0}, sum = 0;
    for (int i = 0; i < 4; i++) {
        for (int c = 0; c < 3; c++)
            weight[i] += lobe[i][c] * p->throughput[c];
        sum += weight[i];
    }
    if (!(sum > 0))
        return -1;
    double u = ref_rng_uniform(&p->rng) * sum;
    int i = 0, last = 0;
    for (; i < 4; u -= weight[i++]) {
        if (weight[i] > 0)
            last = i;
        if (u < weight[i])
            break;
    }
    for (int c = 0; c < 3; c++)
        p->throughput[c] *= lobe[last][c] * (sum / weight[last]);
    return last;
}

static bool any_positive(const double a[3])
{
    return a[0] > 0 || a[1] > 0 || a[2] > 0;
}

static bool scatter_at_surface(struct path *p, const struct hit *hit, const struct material *m)
{
    struct lobes lobes;
    lobes_at(m, hit, &lobes);
    struct vertex v = {.kind = VERTEX_SURFACE,
                       .point = hit->point,
                       .from = hit->shape,
                       .normal = hit->normal,
                       .material = m,
                       .lobes = &lobes};
    bool diffuse = any_positive(lobes.diffuse_reflect) || any_positive(lobes.diffuse_transmit);
    if (diffuse && may_scatter_diffusely(p))
        next_event(p, &v, class_after(p, REF_INDIRECT));
    const double *all[4] = {lobes.diffuse_reflect, lobes.diffuse_transmit, lobes.mirror,
                            lobes.straight};
    switch (choose_lobe(p, all)) {
    case 0:
        return scatter_diffusely(p, hit, m, hit->normal);
    case 1:
        return scatter_diffusely(p, hit, m, vec_scale(hit->normal, -1));
    case 2:
        go_on(p, REF_CAUSTIC, hit->point, mirror_direction(p, hit), hit->shape);
        return true;
    case 3:
        step_over(p, hit);
        return true;
    default:
        return false;
    }
}

static void see_light(struct path *p, const struct material *m)
{
    double radiance[3];
    if (p->lights_taken)
        return;
    emission(m, p->ray.direction, radiance);
    gather(p, p->class, radiance);
}

static bool surface_event(struct path *p, const struct hit *hit)
{
    const struct material *m = shape_material(p->scene, hit->shape);
    if (material_emits(m)) { /* lights absorb, and their backs are black */
        if (hit->front)
            see_light(p, m);
        return false;
    }
    if (m->kind == MATERIAL_DIELECTRIC)
        return refract(p, hit, m);
    if (m->kind != MATERIAL_MIST)
        return scatter_at_surface(p, hit, m);
    media_cross(&p->media, m, hit->front);
    step_over(p, hit);
    return true;
}

/* Returns false when the path has ended. */
static bool step(struct path *p)
{
    struct hit hit = nearest(p->scene, &p->ray);
    struct vec point;
    if (medium_event(p, hit.t, &point))
        return scatter_in_medium(p, point) && roulette(p);
    if (hit.shape)
        return surface_event(p, &hit) && roulette(p);
    const struct shape *source = source_towards(p->scene, p->ray.direction);
    if (source)
        see_light(p, shape_material(p->scene, source));
    return false;
}

static void trace(struct path *p)
{
    int left = MAX_EVENTS;
    while (left > 0 && step(p))
        left--;
    p->truncated = left == 0;
}

/* ---- sensors ---- */

struct sensor {
    struct vec point, normal; /* `normal` is the direction looked into for radiance */
    double radius;
    bool is_radiance;
};

/* Off the normal, so that a ray from a sensor along a box's edge or diagonal meets no corner.
 */
static struct vec probe_direction(struct vec normal)
{
    return vec_polar(normal, 0.9428090415820634, 0.7390851332151607);
}

static void start_radiance(struct path *p, const struct sensor *s)
{
    p->ray = (struct ray){.origin = s->point, .direction = s->normal};
    media_at(p->scene, s->point, s->normal, &p->media);
    trace(p);
}

static void start_irradiance(struct path *p, const struct sensor *s)
{
    double radius = s->radius * sqrt(ref_rng_uniform(&p->rng));
    double phi = 2 * REF_PI * ref_rng_uniform(&p->rng);
    struct vec point = vec_along(s->point, radius, vec_polar(s->normal, 0, phi));
    media_at(p->scene, point, probe_direction(s->normal), &p->media);
    struct vertex v = {.kind = VERTEX_SENSOR, .point = point, .normal = s->normal};
    next_event(p, &v, REF_DIRECT);
    p->ray = (struct ray){.origin = point, .direction = cosine_direction(s->normal, &p->rng)};
    p->lights_taken = p->options->next_event;
    trace(p);
    for (int k = 0; k < REF_CLASSES; k++)
        for (int c = 0; c < 3; c++)
            p->value[k][c] *= REF_PI;
}

/* ---- averages ---- */

/* Running mean and sum of squared differences (Welford 1962). */
static void welford(double x, double n, double *mean, double *squares)
{
    double off = x - *mean;
    *mean += off / n;
    *squares += off * (x - *mean);
}

/* Adds sample number n. Until finish(), the errors hold sums of squares. */
static void add_sample(struct ref_result *r, const struct path *p, double n)
{
    bool finite = true;
    for (int c = 0; c < 3; c++) {
        double total = 0;
        for (int k = 0; k < REF_CLASSES; k++) {
            welford(p->value[k][c], n, &r->mean[k][c], &r->standard_error[k][c]);
            total += p->value[k][c];
        }
        welford(total, n, &r->total[c], &r->total_standard_error[c]);
        finite = finite && isfinite(total);
    }
    r->nonfinite += !finite;
    r->truncated += p->truncated;
}

static double error_of_mean(double squares, double n)
{
    return n > 1 ? sqrt(squares / (n * (n - 1))) : 0;
}

static void finish(struct ref_result *r, double n)
{
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < REF_CLASSES; k++)
            r->standard_error[k][c] = error_of_mean(r->standard_error[k][c], n);
        r->total_standard_error[c] = error_of_mean(r->total_standard_error[c], n);
    }
}

static void measure(const struct ref_scene *scene, const struct sensor *sensor,
                    const struct ref_options *options, struct ref_result *result)
{
    *result = (struct ref_result){.nonfinite = 0};
    for (uint64_t i = 0; i < options->samples; i++) {
        struct path p = {.scene = scene,
                         .options = options,
                         .throughput = {1, 1, 1},
                         .index_ratio = 1,
                         .class = REF_DIRECT};
        ref_rng_init(&p.rng, options->seed, i);
        if (sensor->is_radiance)
            start_radiance(&p, sensor);
        else
            start_irradiance(&p, sensor);
        add_sample(result, &p, (double)(i + 1));
    }
    finish(result, (double)options->samples);
}

void ref_irradiance(const struct ref_scene *scene, const double point[3],
                    const double normal[3], const struct ref_options *options,
                    struct ref_result *result)
{
    ref_irradiance_disc(scene, point, normal, 0, options, result);
}

void ref_irradiance_disc(const struct ref_scene *scene, const double center[3],
                         const double normal[3], double radius,
                         const struct ref_options *options, struct ref_result *result)
{
    struct sensor s = {
        .point = vec_from(center), .normal = vec_unit(vec_from(normal)), .radius = radius};
    measure(scene, &s, options, result);
}

void ref_radiance(const struct ref_scene *scene, const double origin[3],
                  const double direction[3], const struct ref_options *options,
                  struct ref_result *result)
{
    struct sensor s = {.point = vec_from(origin),
                       .normal = vec_unit(vec_from(direction)),
                       .is_radiance = true};
    measure(scene, &s, options, result);
}
