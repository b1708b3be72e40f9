/* Light pipes and concentrators of mirrors, by unfolding and by a trace in one plane. */
#include "physics.h"

#define REFLECTANCE .8

/* ---- a square pipe ----
 *
 * Mirror images of the pipe [0, 1]^2 x [0, LENGTH] fill the plane with squares (unfolding). A
 * ray whose direction has the slope t = |dx / dz| crosses LENGTH t of them: n = floor(LENGTH t)
 * walls or, from the share LENGTH t - n of the entrance, one more. */
#define LENGTH 3.

static double after_walls(double slope)
{
    double squares = LENGTH * slope, n = floor(squares), more = squares - n;
    return pow(REFLECTANCE, n) * (1 - more + more * REFLECTANCE);
}

/* Share of the entrance from which no wall is met. */
static double past_walls(double slope)
{
    return fmax(0, 1 - LENGTH * slope);
}

#define PIPE                                                                                   \
    "void mirror silver 0 0 3 .8 .8 .8\n"                                                      \
    "silver polygon south 0 0 12 0 0 0 0 0 3 1 0 3 1 0 0\n"                                    \
    "silver polygon north 0 0 12 0 1 0 1 1 0 1 1 3 0 1 3\n"                                    \
    "silver polygon west 0 0 12 0 0 0 0 1 0 0 1 3 0 0 3\n"                                     \
    "silver polygon east 0 0 12 1 0 0 1 0 3 1 1 3 1 1 0\n"                                     \
    "void plastic dark 0 0 5 .001 .001 .001 0 0\n"                                             \
    "dark polygon floor 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n"

/* Flux of all caustic photons, which have met a mirror at least once. */
static struct stat mirrored_flux(const char *text, uint64_t photons)
{
    pm_job job = job_of(PM_JOB_MAP, -1);
    want_map(&job, PM_MAP_CAUSTIC, photons, 40);
    struct stat flux[3];
    run_flux(&job, text, PM_MAP_CAUSTIC, (pm_vec3){0, 0, 0}, 2, flux);
    return flux[0];
}

/* A sun whose direction has slopes (x, y) and irradiance 1 across its light. It moves by 1e-3
 * at most over its disc (.05 degrees), evenly about its middle, so mean slopes are kept to its
 * square. A map ends with photon N: bias 1 / N (Haldane 1945). */
static void pipe_passes_parallel_light_as_unfolding_says(void **state)
{
    (void)state;
    enum { PHOTONS = 10000 };
    static const double slopes[][2] = {{.2, 0}, {.7, .45}, {1.3, .9}};
    for (int i = 0; i < 3; i++) {
        double x = slopes[i][0], y = slopes[i][1], cosine = 1 / sqrt(1 + x * x + y * y);
        double radiance = sun_radiance();
        char *text = text_of("void light sun 0 0 3 %.17g %.17g %.17g\n"
                             "sun source s 0 0 4 %.17g %.17g 1 .1\n" PIPE,
                             radiance, radiance, radiance, x, y);
        double through = after_walls(x) * after_walls(y) - past_walls(x) * past_walls(y);
        struct stat got = mirrored_flux(text, PHOTONS);
        expect_mean("pipe", &got, cosine * through, cosine * through * (1. / PHOTONS + 1e-5));
        free(text);
    }
}

/* Of a Lambertian entrance of exitance pi the flux within slopes dx dy is dx dy / (1 + x^2 +
 * y^2)^2; with x = tan u it is bounded. The middle rule's error, of kinks across cells of width
 * 1e-3, is less than 1e-5. */
static double diffuse_flux(double (*share)(double))
{
    enum { STEPS = 1500 };
    static double tangent[STEPS], value[STEPS];
    double width = PI / 2 / STEPS, sum = 0;
    for (int i = 0; i < STEPS; i++) {
        tangent[i] = tan((i + .5) * width);
        value[i] = share(tangent[i]) * (1 + tangent[i] * tangent[i]);
    }
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < STEPS; k++) {
            double r = 1 + tangent[i] * tangent[i] + tangent[k] * tangent[k];
            sum += value[i] * value[k] / (r * r);
        }
    return 4 * sum * width * width;
}

static void pipe_passes_diffuse_light_as_unfolding_says(void **state)
{
    (void)state;
    enum { PHOTONS = 20000 };
    struct stat got = mirrored_flux(PIPE "void light bright 0 0 3 1 1 1\n"
                                         "bright polygon lid 0 0 12 0 0 3 0 1 3 1 1 3 1 0 3\n",
                                    PHOTONS);
    double want = diffuse_flux(after_walls) - diffuse_flux(past_walls);
    expect_mean("pipe", &got, want, want * (1. / PHOTONS + 1e-4));
}

/* ---- a compound parabolic concentrator ----
 *
 * Welford and Winston, "High Collection Nonimaging Optics", 1989, 4.3: the profile of a
 * concentrator with exit radius 1 that accepts up to the angle T from its axis is
 *   r = 2 f sin(p - T) / (1 - cos p) - 1,  z = 2 f cos(p - T) / (1 - cos p),  f = 1 + sin T,
 * for p from 2 T (entrance) to pi / 2 + T (exit, z = 0). Here it is a chain of cones. */
#define ACCEPTANCE (PI / 6)

enum { CONES = 48 };

struct point {
    double r, z;
};

/* Point 0 is the exit's rim, CONES the entrance's. */
static void profile(struct point p[CONES + 1])
{
    double f = 1 + sin(ACCEPTANCE), from = PI / 2 + ACCEPTANCE, to = 2 * ACCEPTANCE;
    for (int i = 0; i <= CONES; i++) {
        double angle = from + (to - from) * i / CONES, scale = 2 * f / (1 - cos(angle));
        p[i].r = scale * sin(angle - ACCEPTANCE) - 1;
        p[i].z = scale * cos(angle - ACCEPTANCE);
    }
    p[0] = (struct point){1, 0};
}

/* Where a ray in a plane through the axis meets the cones, of both signs of r: share of the way
 * to infinity, or false. The cone it lies on is left out. */
static bool next_cone(const struct point *p, struct point o, struct point d, int *on,
                      struct point *hit, struct point *normal)
{
    double nearest = INFINITY;
    int met = *on;
    for (int i = 0; i < 2 * CONES; i++) {
        double sign = i < CONES ? 1 : -1;
        struct point a = p[i % CONES], b = p[i % CONES + 1];
        struct point edge = {sign * (b.r - a.r), b.z - a.z};
        double across = d.r * edge.z - d.z * edge.r;
        double way_r = sign * a.r - o.r, way_z = a.z - o.z;
        double t = (way_r * edge.z - way_z * edge.r) / across;
        double s = (way_r * d.z - way_z * d.r) / across;
        if (i == *on || !(t > 0 && s >= 0 && s <= 1 && t < nearest))
            continue;
        double length = hypot(edge.r, edge.z);
        nearest = t;
        met = i;
        *normal = (struct point){edge.z / length, -edge.r / length};
        *hit = (struct point){o.r + t * d.r, o.z + t * d.z};
    }
    *on = met;
    return nearest < INFINITY;
}

/* Mirrors that light parallel to the axis meets at radius r on its way to the exit; it stays in
 * a plane. */
static int mirrors_met(const struct point *p, double r)
{
    struct point o = {r, p[CONES].z + 1}, d = {0, -1}, hit, normal;
    int count = 0, on = -1;
    while (next_cone(p, o, d, &on, &hit, &normal)) {
        double along = 2 * (d.r * normal.r + d.z * normal.z);
        d = (struct point){d.r - along * normal.r, d.z - along * normal.z};
        o = hit;
        count++;
        assert_true(count < 100);
    }
    assert_true(d.z < 0); /* none comes back */
    return count;
}

static char *concentrator(double angle)
{
    struct point p[CONES + 1];
    double radiance = sun_radiance();
    size_t used, size = 256 * (CONES + 4);
    char *text = malloc(size);
    assert_non_null(text);
    profile(p);
    used = (size_t)snprintf(text, size,
                            "void light sun 0 0 3 %.17g %.17g %.17g\n"
                            "sun source s 0 0 4 %.17g 0 %.17g .1\n"
                            "void plastic dark 0 0 5 .001 .001 .001 0 0\n"
                            "dark ring exit 0 0 8 0 0 0 0 0 1 0 1\n"
                            "void mirror silver 0 0 3 .8 .8 .8\n",
                            radiance, radiance, radiance, sin(angle), cos(angle));
    for (int i = 0; i < CONES; i++)
        used += (size_t)snprintf(text + used, size - used,
                                 "silver cup c%d 0 0 8 0 0 %.17g 0 0 %.17g %.17g %.17g\n", i,
                                 p[i].z, p[i + 1].z, p[i].r, p[i + 1].r);
    return text;
}

/* What the entrance takes in, less what the mirrors keep. Rings of the entrance 1e-3 wide: only
 * where the number of mirrors jumps do they err, by half of theirs at a handful of radii. */
static void concentrator_takes_all_light_along_its_axis(void **state)
{
    (void)state;
    enum { PHOTONS = 10000, RINGS = 20000 };
    struct point p[CONES + 1];
    double want = 0;
    profile(p);
    double entrance = p[CONES].r, width = entrance / RINGS;
    expect_near("entrance", entrance, 1 / sin(ACCEPTANCE), 0);
    for (int i = 0; i < RINGS; i++) {
        double r = (i + .5) * width;
        int count = mirrors_met(p, r);
        want += count ? 2 * PI * r * width * pow(REFLECTANCE, count) : 0;
    }
    char *text = concentrator(0);
    struct stat got = mirrored_flux(text, PHOTONS);
    expect_mean("exit", &got, want, want * (1. / PHOTONS + 1e-3));
    free(text);
}

/* Fifteen degrees beyond its acceptance, where cones instead of parabolas change nothing, all
 * light comes back out of the entrance. That is an answer: a map of no photons that says why.
 */
static void concentrator_passes_nothing_beyond_its_acceptance(void **state)
{
    (void)state;
    char *text = concentrator(ACCEPTANCE + PI / 12);
    pm_job job = job_of(PM_JOB_MAP, -1);
    pm_answer answer;
    want_map(&job, PM_MAP_CAUSTIC, 10000, 40);
    want_map(&job, PM_MAP_GLOBAL, 10000, 40);
    run_job(&job, text, NULL, &answer);
    for (int kind = PM_MAP_GLOBAL; kind <= PM_MAP_CAUSTIC; kind++) {
        assert_non_null(answer.map[kind]);
        assert_int_equal(pm_photon_map_count(answer.map[kind]), 0);
        const char *note = pm_photon_map_header(answer.map[kind])->note;
        if (!strstr(note, "photon"))
            fail_msg("the map of no photons says: \"%s\"", note);
    }
    assert_true(pm_rgb_mean(answer.emitted) > 0);
    pm_answer_clear(&answer);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pipe_passes_parallel_light_as_unfolding_says),
        cmocka_unit_test(pipe_passes_diffuse_light_as_unfolding_says),
        cmocka_unit_test(concentrator_takes_all_light_along_its_axis),
        cmocka_unit_test(concentrator_passes_nothing_beyond_its_acceptance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
