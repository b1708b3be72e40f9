/* A spotlight's narrow beam in mist: where its light collides, and what of it is seen from the
 * side. */
#include "physics.h"

static const double extinctions[] = {.5, 1, 2, 10};

/* A disc of radius R = .2 in the plane z = 0, in a cylinder of fog, of radiance 1 / (pi sin^2)
 * in a cone of half angle 1 degree: exitance 1, flux pi R^2. Light leaves the fog at 1.5. Of
 * what collides a share w is scattered, so little that light of a second collision is less than
 * w. The focus is too near to matter. */
#define FOG_ALBEDO  1e-4
#define LAMP_RADIUS .2
#define FOG_RADIUS  .35
#define FOG_END     1.5
#define HALF_ANGLE  (PI / 180)

static char *beam_scene(double extinction, double g)
{
    double radiance = 1 / (PI * pow(sin(HALF_ANGLE), 2)), s = extinction, w = FOG_ALBEDO;
    return text_of(
        "void spotlight beam 0 0 7 %.17g %.17g %.17g 2 0 0 1e-6\n"
        "beam ring lamp 0 0 8 0 0 0 0 0 1 0 %g\n"
        "void mist fog 0 0 7 %g %g %g %g %g %g %g\n"
        "fog cylinder side 0 0 7 0 0 -.1 0 0 %g %g\n"
        "fog ring far 0 0 8 0 0 %g 0 0 1 0 %g  fog ring near 0 0 8 0 0 -.1 0 0 -1 0 %g\n",
        radiance, radiance, radiance, LAMP_RADIUS, s, s, s, w, w, w, g, FOG_END, FOG_RADIUS,
        FOG_END, FOG_RADIUS, FOG_RADIUS);
}

/* ---- collisions: Beer and Lambert ---- */

enum { BINS = 7, BEAM_PHOTONS = 20000 };

/* Flux of the volume photons by depth, the last bin up to 1.4. Paths are longer than z by 1 /
 * cos, at most 1.5e-4. Photons elsewhere than in the cone belong to second collisions. */
static void collisions_along_a_beam_follow_beer_and_lambert(void **state)
{
    (void)state;
    const double flux = PI * LAMP_RADIUS * LAMP_RADIUS, width = .2;
    for (int i = 0; i < 4; i++) {
        struct stat got[BINS] = {0}, outside = {0};
        double s = extinctions[i];
        char *text = beam_scene(s, 0);
        pm_job job = job_of(PM_JOB_MAP, -1);
        want_map(&job, PM_MAP_VOLUME, BEAM_PHOTONS, 50);
        for (unsigned seed = 1; seed <= SEEDS / 2; seed++) {
            pm_answer answer;
            double bins[BINS] = {0}, rest = 0;
            job.forward.seed = seed;
            run_job(&job, text, NULL, &answer);
            const pm_photon_map *map = answer.map[PM_MAP_VOLUME];
            for (size_t k = 0; k < pm_photon_map_count(map); k++) {
                pm_vec3 p;
                double photon = flux_of(map, k, &p).g;
                bool in = hypot(p.x, p.y) < LAMP_RADIUS + p.z * tan(HALF_ANGLE) + 1e-6;
                if (!in)
                    rest += photon;
                else if (p.z < BINS * width)
                    bins[(int)(p.z / width)] += photon;
            }
            for (int b = 0; b < BINS; b++)
                stat_add(&got[b], bins[b]);
            stat_add(&outside, rest);
            pm_answer_clear(&answer);
        }
        for (int b = 0; b < BINS; b++) {
            double from = width * b, to = from + width;
            double want = flux * (exp(-s * from) - exp(-s * to));
            char what[60];
            snprintf(what, sizeof what, "extinction %g, depth %g to %g", s, from, to);
            /* a map ends with photon N: bias 1 / N. Deep bins have few photons or none, so
             * their error is not that of the seeds alone, but that of independent photons. */
            double photon = flux * (1 - exp(-s * FOG_END)) / BEAM_PHOTONS / got[b].count;
            double slack = want * (1. / BEAM_PHOTONS + s * to * 1.5e-4 + FOG_ALBEDO);
            expect_equal_means(what, &got[b], want, sqrt(want * photon), slack);
        }
        expect_mean("outside", &outside, 0, FOG_ALBEDO * flux);
        free(text);
    }
}

/* ---- single scattering, seen from the side ---- */

/* Area that a disc of radius c around a point at x has in common with the lamp's. */
static double common_area(double x, double c)
{
    double r = LAMP_RADIUS;
    if (x + c <= r)
        return PI * c * c;
    if (x >= r + c)
        return 0;
    double a = acos((x * x + c * c - r * r) / (2 * x * c));
    double b = acos((x * x + r * r - c * c) / (2 * x * r));
    return c * c * (a - sin(2 * a) / 2) + r * r * (b - sin(2 * b) / 2);
}

/* A ray that starts at x = -EYE and crosses the axis at depth z. The beam at x has the
 * irradiance of as much of the lamp as a cone back from there meets. */
#define EYE .3

struct crossing {
    double extinction, depth;
};

static double scattered_at(double x, const void *context)
{
    const struct crossing *c = context;
    double cone = c->depth * tan(HALF_ANGLE);
    double irradiance = common_area(fabs(x), cone) / (PI * cone * cone);
    return irradiance * c->extinction * exp(-c->extinction * (c->depth + x + EYE));
}

/* What the K nearest photons find too much at a plane edge of even photons, in all, in units of
 * the radius far within, a: at t outside the edge a ball of radius r holds as many as one of
 * radius a within where its part behind the edge is 4/3 pi a^3, and says (a / r)^3. */
static double part_behind(double r, double t)
{
    double h = fmax(0, fmin(2 * r, r - t));
    return h * h * (3 * r - h) / 4; /* over 4/3 pi */
}

static double edge_estimate(double t, const void *context)
{
    (void)context;
    double low = 0, high = fabs(t) + 2;
    for (int i = 0; i < 60; i++) {
        double middle = (low + high) / 2;
        if (part_behind(middle, t) < 1)
            low = middle;
        else
            high = middle;
    }
    return pow(low, -3);
}

static double edge_excess(void)
{
    return integrate(edge_estimate, NULL, 0, 50, 2000) +
           integrate(edge_estimate, NULL, -1, 0, 100) - 1;
}

enum { AROUND = 16, DEPTHS = 4, GATHER = 20, SEEN_PHOTONS = 30000 };

/* Bias as a share of what is seen. Photons lie too dense by the mean of exp(-s z) over a ball,
 * and along the ray likewise: u^2 / 10 each, u = s r, to first order; and at both edges as by
 * edge_excess, which is weighed by the way to the eye. */
static double seen_bias(double s, double depth)
{
    double density = SEEN_PHOTONS * s * exp(-s * depth) / (1 - exp(-s * FOG_END)) /
                     (PI * LAMP_RADIUS * LAMP_RADIUS);
    double r = cbrt(GATHER / (density * 4 / 3 * PI)), far = exp(-2 * s * LAMP_RADIUS);
    return s * r * s * r / 5 + edge_excess() * r * s * (1 + far) / (1 - far) + FOG_ALBEDO +
           1. / GATHER / SEEN_PHOTONS;
}

static void expect_beam_seen(double s, double g)
{
    pm_sensor rays[DEPTHS * AROUND];
    struct stat got[DEPTHS] = {0};
    char *text = beam_scene(s, g);
    double step = fmin(.25, .5 / s);
    for (int i = 0; i < DEPTHS * AROUND; i++) {
        double angle = 2 * PI * (i % AROUND + .3) / AROUND, c = cos(angle), n = sin(angle);
        rays[i] = (pm_sensor){{-EYE * c, -EYE * n, step * (i / AROUND + 1)}, {c, n, 0}};
    }
    pm_job job = job_of(PM_JOB_TRACE, -1);
    want_map(&job, PM_MAP_VOLUME, SEEN_PHOTONS, GATHER);
    look_at(&job, rays, DEPTHS * AROUND, PM_RADIANCE);
    job.passes = 8;
    for (unsigned seed = 1; seed <= SEEDS / 2; seed++) {
        pm_answer answer;
        job.forward.seed = seed;
        run_job(&job, text, NULL, &answer);
        for (int d = 0; d < DEPTHS; d++) {
            double sum = 0;
            for (int i = d * AROUND; i < (d + 1) * AROUND; i++)
                sum += (double)answer.values[3 * i] / AROUND;
            stat_add(&got[d], sum);
        }
        pm_answer_clear(&answer);
    }
    double phase = (1 - g * g) / (4 * PI * pow(1 + g * g, 1.5)); /* at right angles */
    for (int d = 0; d < DEPTHS; d++) {
        struct crossing at = {s, step * (d + 1)};
        double want = FOG_ALBEDO * phase * integrate(scattered_at, &at, -EYE, EYE, 400);
        char what[60];
        snprintf(what, sizeof what, "extinction %g, g %g, depth %g", s, g, at.depth);
        expect_mean(what, &got[d], want, want * seen_bias(s, at.depth));
    }
    free(text);
}

static void a_beam_seen_from_the_side_is_scattered_once(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        expect_beam_seen(extinctions[i], 0);
        expect_beam_seen(extinctions[i], .5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(collisions_along_a_beam_follow_beer_and_lambert),
        cmocka_unit_test(a_beam_seen_from_the_side_is_scattered_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
