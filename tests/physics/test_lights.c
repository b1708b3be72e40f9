/* Every kind of light, by quadrature over its area: what next events bring to a sensor, and
 * what photons carry to a receiver by way of a mirror. */
#include "physics.h"

/* ---- surfaces of revolution: ring, sphere, cone, cylinder ---- */

/* The lateral surface between (z0, r0) and (z1, r1) about an axis parallel to z through `axis`;
 * rings have z0 = z1. */
struct band {
    double x, y;
    double z0, r0, z1, r1;
    double side; /* 1: front is outside (cone, cylinder) or up (ring, r1 > r0); -1: the other */
    double cone; /* spotlights that aim down: cosine of half the angle; -1 otherwise */
    double focus;
};

/* Irradiance at p facing n of the band with radiance 1: midpoint sums of `steps` each way. */
static double band_irradiance(const struct band *b, pm_vec3 p, pm_vec3 n, int steps)
{
    double dz = b->z1 - b->z0, dr = b->r1 - b->r0, slant = hypot(dz, dr), sum = 0;
    for (int i = 0; i < steps; i++) {
        double t = (i + .5) / steps, r = b->r0 + t * dr;
        for (int k = 0; k < steps; k++) {
            double phi = 2 * PI * (k + .5) / steps;
            pm_vec3 q = {b->x + r * cos(phi), b->y + r * sin(phi), b->z0 + t * dz};
            pm_vec3 m = {b->side * dz / slant * cos(phi), b->side * dz / slant * sin(phi),
                         (dz == 0 ? 1 : -1) * b->side * dr / slant};
            pm_vec3 w = pm_vec3_sub(q, p);
            double d = pm_vec3_length(w);
            double cosines = fmax(0, pm_vec3_dot(w, n)) * fmax(0, -pm_vec3_dot(w, m));
            double share = d / (d + b->focus);
            if (w.z / d >= b->cone)
                sum += r * cosines / pow(d, 4) * share * share;
        }
    }
    return sum * slant / steps * 2 * PI / steps;
}

/* Each light shines at a floor sensor at the origin (facing up). */
static const struct {
    const char *name, *text;
    struct band band;
} lights[] = {
    {"ring",
     "void light l 0 0 3 1 1 1  l ring a 0 0 8 .3 .1 2 0 0 -1 .2 .7\n",
     {.3, .1, 2, .2, 2, .7, -1, -1, 0}},
    {"glow ring",
     "void glow l 0 0 4 1 1 1 0  l ring a 0 0 8 .3 .1 2 0 0 -1 .2 .7\n",
     {.3, .1, 2, .2, 2, .7, -1, -1, 0}},
    {"glow ring with a radius",
     "void glow l 0 0 4 1 1 1 9  l ring a 0 0 8 .3 .1 2 0 0 -1 .2 .7\n",
     {.3, .1, 2, .2, 2, .7, -1, -1, 0}},
    {"cylinder",
     "void light l 0 0 3 1 1 1  l cylinder a 0 0 7 1 0 1 1 0 2 .2\n",
     {1, 0, 1, .2, 2, .2, 1, -1, 0}},
    {"cone",
     "void light l 0 0 3 1 1 1  l cone a 0 0 8 .3 0 1 .3 0 2 .1 .8\n",
     {.3, 0, 1, .1, 2, .8, 1, -1, 0}},
    {"cup",
     "void light l 0 0 3 1 1 1  l cup a 0 0 8 .3 0 1 .3 0 2 .8 .1\n",
     {.3, 0, 1, .8, 2, .1, -1, -1, 0}},
    {"tube",
     "void light l 0 0 3 1 1 1  l tube a 0 0 7 .3 0 1 .3 0 2 .6\n",
     {.3, 0, 1, .6, 2, .6, -1, -1, 0}},
    /* half of 120 degrees; the focus lies |aim| behind the lamp, where Radiance lets its light
     * come from: (d / (d + focus))^2 */
    {"spotlight",
     "void spotlight l 0 0 7 1 1 1 120 0 0 -1e-9  l ring a 0 0 8 .1 0 2 0 0 -1 0 .3\n",
     {.1, 0, 2, 0, 2, .3, -1, .5, 0}},
    {"focused spotlight",
     "void spotlight l 0 0 7 1 1 1 120 0 0 -.5  l ring a 0 0 8 .1 0 2 0 0 -1 0 .3\n",
     {.1, 0, 2, 0, 2, .3, -1, .5, .5}},
};

enum { LIGHTS = sizeof lights / sizeof *lights };

/* The sums' own error: of order steps^-2, the integrands being continuous. Halving the steps
 * changes none of them by more than a third of this. */
enum { STEPS = 512 };
#define QUADRATURE 2e-5

static struct stat next_events(const char *text, pm_sensor sensor)
{
    pm_job job = job_of(PM_JOB_TRACE, 0);
    look_at(&job, &sensor, 1, PM_IRRADIANCE);
    job.passes = 1024;
    return run_mean(&job, text, SEEDS, GREY);
}

static void next_events_bring_what_the_area_integral_says(void **state)
{
    (void)state;
    const pm_vec3 up = {0, 0, 1}, tilted = {.6, 0, .8};
    for (int i = 0; i < LIGHTS; i++) {
        double want = band_irradiance(&lights[i].band, (pm_vec3){0, 0, 0}, up, STEPS);
        struct stat got = next_events(lights[i].text, (pm_sensor){{0, 0, 0}, up});
        expect_mean(lights[i].name, &got, want, QUADRATURE * want);
        want = band_irradiance(&lights[i].band, (pm_vec3){.2, -.1, 0}, tilted, STEPS);
        got = next_events(lights[i].text, (pm_sensor){{.2, -.1, 0}, tilted});
        expect_mean(lights[i].name, &got, want, QUADRATURE * want);
    }
}

/* ---- polygons ---- */

/* Lambert 1760: irradiance at the origin facing up of a polygon of radiance 1 above it. */
static double lambert_polygon(const double (*v)[3], size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        const double *a = v[i], *b = v[(i + 1) % n];
        pm_vec3 p = {a[0], a[1], a[2]}, q = {b[0], b[1], b[2]}, across = pm_vec3_cross(p, q);
        double size = pm_vec3_length(across);
        if (size > 0)
            sum += atan2(size, pm_vec3_dot(p, q)) * across.z / size;
    }
    return fabs(sum) / 2;
}

static void concave_polygon_lights_as_lambert_says(void **state)
{
    (void)state;
    static const double corners[6][3] = {{-.5, -.5, 1}, {-.5, 1.5, 1}, {0, 1.5, 1},
                                         {0, 0, 1},     {1, 0, 1},     {1, -.5, 1}};
    struct stat got = next_events("void light l 0 0 3 1 1 1\n"
                                  "l polygon a 0 0 18 -.5 -.5 1  -.5 1.5 1  0 1.5 1\n"
                                  "0 0 1  1 0 1  1 -.5 1\n",
                                  (pm_sensor){{0, 0, 0}, {0, 0, 1}});
    expect_mean("L", &got, lambert_polygon(corners, 6), 0);
}

/* ---- distant sources ---- */

#define SOMETHING "void plastic p 0 0 5 0 0 0 0 0  p sphere a 0 0 4 9 9 -9 .1\n"

/* A disc of half angle b, wholly above the horizon: E = pi L sin(b)^2 cos(theta). */
static void distant_sources_light_by_their_projected_solid_angle(void **state)
{
    (void)state;
    static const double angles[] = {1e-4, .533, 60, 90};
    for (int i = 0; i < 4; i++) {
        char *text = text_of(
            "void light l 0 0 3 1 1 1  l source a 0 0 4 0 0 1 %.17g\n" SOMETHING, angles[i]);
        double sine = sin(angles[i] * PI / 360), want = PI * sine * sine;
        struct stat got = next_events(text, (pm_sensor){{1, 2, 3}, {0, 0, 1}});
        expect_mean("zenith", &got, want, 0);
        got = next_events(text, (pm_sensor){{1, 2, 3}, {.6, 0, .8}});
        expect_mean("at 37 degrees", &got, .8 * want, 0);
        free(text);
    }
}

/* Even skies: pi L for a hemisphere seen whole, half of it for one seen edge on. */
static void skies_light_by_their_hemisphere(void **state)
{
    (void)state;
    const char *half = "void glow g 0 0 4 1 1 1 0  g source a 0 0 4 0 0 1 180\n" SOMETHING;
    const char *whole = "void glow g 0 0 4 1 1 1 0  g source a 0 0 4 0 0 1 360\n" SOMETHING;
    struct stat got = next_events(half, (pm_sensor){{0, 0, 0}, {0, 0, 1}});
    expect_mean("hemisphere", &got, PI, 0);
    got = next_events(half, (pm_sensor){{0, 0, 0}, {1, 0, 0}});
    expect_mean("hemisphere edge on", &got, PI / 2, 0);
    got = next_events(whole, (pm_sensor){{0, 0, 0}, {1, 0, 0}});
    expect_mean("sphere", &got, PI, 0);
}

/* ---- photons by way of a mirror ---- */

/* The mirror z = MIRROR shows a disc that looks down its lamps' images: as many photons as from
 * the lamps themselves on the disc's own image, z = 2 MIRROR - DISC facing up. The disc is so
 * far to the side that nothing stands in the way, and none of its photons came otherwise: its
 * direct light is not stored. */
#define MIRROR .9
#define DISC   2.2
#define RADIUS .8

#define RECEIVER                                                                               \
    "void mirror silver 0 0 3 1 1 1  silver ring floor 0 0 8 0 0 .9 0 0 1 0 6\n"               \
    "void plastic dark 0 0 5 .001 .001 .001 0 0  dark ring disc 0 0 8 -2 0 2.2 0 0 -1 0 .8\n"

/* Equal areas, midpoints: irradiance is smooth on the disc. */
static double disc_flux(const struct band *band, int rings, int steps)
{
    double sum = 0;
    for (int i = 0; i < rings; i++)
        for (int k = 0; k < 4 * rings; k++) {
            double r = RADIUS * sqrt((i + .5) / rings), phi = PI * (k + .5) / (2 * rings);
            pm_vec3 p = {-2 + r * cos(phi), r * sin(phi), 2 * MIRROR - DISC};
            sum += band_irradiance(band, p, (pm_vec3){0, 0, 1}, steps);
        }
    return sum / (4 * rings * rings) * PI * RADIUS * RADIUS;
}

/* The map stops at the path that fills it: N / paths is off by at most 1 / N (Haldane 1945). */
enum { PHOTONS = 2000 };

static void photons_carry_what_next_events_bring(void **state)
{
    (void)state;
    for (int i = 0; i < LIGHTS; i++) {
        const struct band *band = &lights[i].band;
        if (band->focus > 0 || (band->side < 0 && band->z0 != band->z1))
            continue; /* light from within would be caught within */
        char *text = text_of("%s" RECEIVER, lights[i].text);
        double want = disc_flux(band, 4, 64), finer = disc_flux(band, 6, 96);
        pm_job job = job_of(PM_JOB_MAP, -1);
        want_map(&job, PM_MAP_CAUSTIC, PHOTONS, 40);
        struct stat got[3];
        run_flux(&job, text, PM_MAP_CAUSTIC, (pm_vec3){-2, 0, DISC}, 2 * RADIUS, got);
        expect_mean(lights[i].name, &got[0], finer, fabs(finer - want) + finer / PHOTONS);
        free(text);
    }
}

/* ---- lights that could be counted twice ---- */

static void expect_in_all_modes(const char *text, const pm_sensor *sensors, size_t count,
                                double want, double slack)
{
    for (int i = 0; i < MODES; i++) {
        pm_job job = job_of_mode(&modes[i], 2000, 50);
        look_at(&job, sensors, count, PM_IRRADIANCE);
        job.passes = modes[i].progressive ? 1 : 16;
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        expect_mean(modes[i].name, &got, want, slack);
    }
}

/* A disc of radius r at height h over the sensor: E = pi r^2 / (r^2 + h^2). The floor is black,
 * so that nothing but the light itself counts. */
#define FLOOR "void plastic black 0 0 5 0 0 0 0 0  black ring floor 0 0 8 0 0 0 0 0 1 0 2\n"

static void each_light_counts_once_in_all_modes(void **state)
{
    (void)state;
    static const char *const texts[] = {
        FLOOR "void light l 0 0 3 1 1 1  l ring a 0 0 8 0 0 1 0 0 -1 0 .5\n",
        FLOOR "void glow l 0 0 4 1 1 1 0  l ring a 0 0 8 0 0 1 0 0 -1 0 .5\n",
        FLOOR "void illum l 0 0 3 1 1 1  l ring a 0 0 8 0 0 1 0 0 -1 0 .5\n",
        /* an illum that is seen as a black plate: nothing behind it matters either */
        FLOOR "void plastic p 0 0 5 0 0 0 0 0  void illum l 1 p 0 3 1 1 1\n"
              "l ring a 0 0 8 0 0 1 0 0 -1 0 .5\n",
        /* an illum stands for the sky behind it, which itself lights nothing through it */
        FLOOR "void glow sky 0 0 4 7 7 7 0  sky source s 0 0 4 0 0 1 20\n"
              "void illum l 0 0 3 1 1 1  l ring a 0 0 8 0 0 1 0 0 -1 0 .5\n",
    };
    pm_sensor sensors[16];
    for (int i = 0; i < 16; i++)
        sensors[i] = (pm_sensor){{0, 0, 0}, {0, 0, 1}};
    for (int i = 0; i < 5; i++)
        expect_in_all_modes(texts[i], sensors, 16, PI * .25 / 1.25, 0);
}

/* A glow of negative radius is seen and lights nothing. */
static void glow_of_negative_radius_is_only_seen(void **state)
{
    (void)state;
    const char *text = FLOOR "void glow l 0 0 4 1 1 1 -1  l ring a 0 0 8 0 0 1 0 0 -1 0 .5\n";
    pm_sensor sensor = {{0, 0, 0}, {0, 0, 1}};
    expect_in_all_modes(text, &sensor, 1, 0, 0);
    pm_job job = job_of(PM_JOB_TRACE, -1);
    look_at(&job, &sensor, 1, PM_RADIANCE);
    struct stat got = run_mean(&job, text, 2, GREY);
    expect_mean("seen", &got, 1, 0);
}

/* A mirror's image counts once, wherever the mode finds it: photons, or gather rays that meet
 * the mirror. The sensors lie under a dark disc and look down at the image of a ring around it,
 * .8 as bright and 3 below. The disc reflects a thousandth, so that light which comes to it
 * again counts for less than .001 of its irradiance; it throws no shadow on the way. */
static void mirror_images_count_once_in_all_modes(void **state)
{
    (void)state;
    const char *text =
        "void mirror silver 0 0 3 .8 .8 .8  silver ring m 0 0 8 0 0 0 0 0 1 0 9\n"
        "void light l 0 0 3 1 1 1  l ring a 0 0 8 0 0 2 0 0 -1 1.5 2\n"
        "void plastic dark 0 0 5 .001 .001 .001 0 0\n"
        "dark ring disc 0 0 8 0 0 1 0 0 -1 0 .5\n";
    const struct band image = {0, 0, -2, 1.5, -2, 2, 1, -1, 0};
    const pm_vec3 down = {0, 0, -1};
    pm_sensor sensors[16];
    for (int i = 0; i < 16; i++) {
        double phi = PI * i / 8;
        sensors[i] = (pm_sensor){{.2 * cos(phi), .2 * sin(phi), 1}, down};
    }
    double want = .8 * band_irradiance(&image, sensors[0].point, down, STEPS), bias = 0;
    /* Look-ups average over discs of at most .1: 50 of 2000 photons on an area of pi / 4 take
     * .08, 12 of the 800 of a pass .06. On such a disc irradiance differs from its mean by less
     * than over the disc's rim. */
    for (int i = 0; i < 8; i++) {
        double phi = PI * i / 4;
        pm_vec3 p = {.2 + .1 * cos(phi), .1 * sin(phi), 1};
        bias += .8 / 8 * band_irradiance(&image, p, down, STEPS);
    }
    expect_in_all_modes(text, sensors, 16, want, fabs(bias - want) + .001 * want);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(next_events_bring_what_the_area_integral_says),
        cmocka_unit_test(concave_polygon_lights_as_lambert_says),
        cmocka_unit_test(distant_sources_light_by_their_projected_solid_angle),
        cmocka_unit_test(skies_light_by_their_hemisphere),
        cmocka_unit_test(photons_carry_what_next_events_bring),
        cmocka_unit_test(each_light_counts_once_in_all_modes),
        cmocka_unit_test(glow_of_negative_radius_is_only_seen),
        cmocka_unit_test(mirror_images_count_once_in_all_modes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
