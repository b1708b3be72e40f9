/* Each path from a light to the eye is counted by exactly one estimator: in a room with all
 * kinds of events every mode gives the reference's light, or the part of it that the mode asks
 * for. */
#include "physics.h"

/* A closed room with a lamp, a glass ball, a mirror whose back is black, a pane and a metal
 * ball. */
#define ROOM                                                                                   \
    "void plastic wall 0 0 5 .5 .4 .3 0 0\n" BOX(                                              \
        "wall") "void light bright 0 0 3 3 3 3  bright ring lamp 0 0 8 0 0 .9 0 0 -1 0 .5\n"   \
                "void dielectric clear 0 0 5 .7 .8 .9 1.5 0  clear sphere ball 0 0 4 -.45 "    \
                ".35 -.5 .3\n"                                                                 \
                "void mirror silver 0 0 3 .8 .8 .8\n"                                          \
                "silver polygon m 0 0 12 -.1 .8 -.6 .9 .8 -.6 .9 .8 .6 -.1 .8 .6\n"            \
                "void glass pane 0 0 3 .9 .6 .9\n"                                             \
                "pane polygon p 0 0 12 .5 -.9 -.8 .5 .1 -.8 .5 .1 .5 .5 -.9 .5\n"              \
                "void plastic glaze 0 0 5 .6 .5 .4 .05 0  glaze ring tile 0 0 8 -.5 -.5 -.8 "  \
                "0 0 1 0 .4\n"

#define SMOOTH ROOM "void metal brass 0 0 5 .8 .6 .3 1 0  brass sphere s 0 0 4 .5 .4 -.7 .2\n"
#define ROUGH  ROOM "void metal brass 0 0 5 .8 .6 .3 1 .2  brass sphere s 0 0 4 .5 .4 -.7 .2\n"

/* ---- where it is measured ---- */

/* A spot is a circle of sensors or a cone of rays; their mean is compared. */
enum { MEMBERS = 16, SPOTS = 8, HALF = SPOTS / 2 };

static const struct spot {
    const char *name;
    pm_vec3 point, normal;
    pm_quantity quantity;
    bool in_free_space; /* gathers all its indirect light */
} spots[SPOTS] = {
    {"floor", {.1, -.6, -1}, {0, 0, 1}, PM_IRRADIANCE, false},
    {"floor before the mirror", {.1, 0, -1}, {0, 0, 1}, PM_IRRADIANCE, false},
    {"wall behind the pane", {1, -.4, -.3}, {-1, 0, 0}, PM_IRRADIANCE, false},
    {"free space", {0, 0, 0}, {-.2, -.6, -.8}, PM_IRRADIANCE, true},
    {"ray to the tile", {0, -.8, .2}, {-.5, .3, -1}, PM_RADIANCE, false},
    {"ray through the pane", {0, -.8, .2}, {1, .4, -.4}, PM_RADIANCE, false},
    {"ray into the mirror", {0, -.8, .2}, {.2, 1.6, .1}, PM_RADIANCE, false},
    {"ray into the ball", {0, -.8, .2}, {-.45, 1.15, -.7}, PM_RADIANCE, false},
};

/* Sensors on a circle of that radius, or rays through it one unit ahead. */
static void place_members(const struct spot *spot, double radius, pm_sensor out[MEMBERS])
{
    pm_vec3 n = pm_vec3_normalize(spot->normal);
    pm_vec3 axis = fabs(n.x) < .5 ? (pm_vec3){1, 0, 0} : (pm_vec3){0, 1, 0};
    pm_vec3 u = pm_vec3_normalize(pm_vec3_cross(axis, n)), v = pm_vec3_cross(n, u);
    for (int i = 0; i < MEMBERS; i++) {
        double phi = 2 * PI * i / MEMBERS;
        pm_vec3 off = pm_vec3_add(pm_vec3_scale(u, radius * cos(phi)),
                                  pm_vec3_scale(v, radius * sin(phi)));
        out[i] = (pm_sensor){spot->point, n};
        if (spot->quantity == PM_IRRADIANCE)
            out[i].point = pm_vec3_add(out[i].point, off);
        else
            out[i].normal = pm_vec3_add(n, off);
    }
}

#define CIRCLE .1

/* ---- the reference ---- */

/* Means over the members, and their standard errors. */
struct truth {
    double total[3], error[3];
    double without_ambient[3]; /* direct and caustic */
    double many[3];            /* of total: with more than one diffuse event before the last */
    double curved[3];          /* how much the mean over a wider circle differs */
};

enum { SAMPLES = 1 << 12 };

static struct ref_result ask(const struct ref_scene *scene, const struct spot *spot,
                             const pm_sensor *sensor, int bounces, uint64_t seed)
{
    struct ref_options options = REF_OPTIONS_DEFAULT;
    struct ref_result result;
    const double point[3] = {sensor->point.x, sensor->point.y, sensor->point.z};
    const double normal[3] = {sensor->normal.x, sensor->normal.y, sensor->normal.z};
    options.samples = SAMPLES;
    options.seed = seed;
    options.max_diffuse_bounces = bounces;
    (spot->quantity == PM_IRRADIANCE ? ref_irradiance : ref_radiance)(scene, point, normal,
                                                                      &options, &result);
    assert_int_equal(result.nonfinite + result.truncated, 0);
    return result;
}

static void add_truth(struct truth *t, const struct ref_result *all,
                      const struct ref_result *few, const struct ref_result *wide)
{
    for (int c = 0; c < 3; c++) {
        t->total[c] += all->total[c] / MEMBERS;
        t->error[c] = hypot(t->error[c], all->total_standard_error[c] / MEMBERS);
        t->without_ambient[c] +=
            (all->mean[REF_DIRECT][c] + all->mean[REF_CAUSTIC][c]) / MEMBERS;
        t->many[c] += (all->total[c] - few->total[c]) / MEMBERS;
        t->curved[c] += (all->total[c] - wide->total[c]) / MEMBERS;
    }
}

/* Equal seeds, so that differences between two results have little noise. */
static void truth_of(const struct ref_scene *scene, const struct spot *spot, double kernel,
                     struct truth *out)
{
    pm_sensor members[MEMBERS], wider[MEMBERS];
    int last = spot->quantity == PM_IRRADIANCE ? 0 : 1; /* the wall that is seen is an event */
    place_members(spot, CIRCLE, members);
    place_members(spot, CIRCLE + kernel, wider);
    memset(out, 0, sizeof *out);
    for (int i = 0; i < MEMBERS; i++) {
        uint64_t seed = (uint64_t)i + 1;
        struct ref_result all = ask(scene, spot, &members[i], -1, seed);
        struct ref_result few = ask(scene, spot, &members[i], last + 1, seed);
        struct ref_result wide = ask(scene, spot, &wider[i], -1, seed);
        add_truth(out, &all, &few, &wide);
    }
}

/* ---- the engine ---- */

enum { PHOTONS = 60000, CAUSTICS = 12000, GATHER = 50 };

/* The room has 24 units of area, so K of N photons fill a disc of radius r. Where a disc
 * reaches beyond an edge, a look-up misses photons: on a strip of width sqrt(2) r along both
 * sides of 12 edges of length 2 on average 2 / (3 pi) of them (see rim_loss in test_furnace.c).
 */
static double kernel_radius(const struct mode *mode)
{
    /* a pass has 2^16 paths with about .9 photons, of which the first radius holds 40 */
    double share = mode->progressive ? 40. / PM_BATCH_PATHS : (double)GATHER / PHOTONS;
    return sqrt(24 * share / PI);
}

static double edge_loss(double radius)
{
    return 48 * sqrt(2) * radius / 24 * 2 / (3 * PI);
}

/* Each seed's batches are traced once, and shared by the modes and spots. */
static void add_answer(const pm_answer *answer, struct stat got[][3])
{
    for (int i = 0; i < HALF; i++)
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (int k = 0; k < MEMBERS; k++)
                sum += (double)answer->values[3 * (i * MEMBERS + k) + c];
            stat_add(&got[i][c], sum / MEMBERS);
        }
}

/* One half of the spots: those of the same quantity as the first of them. */
static void run_half(const char *text, const struct mode *mode, int first, unsigned seed,
                     const pm_job_hooks *hooks, struct stat got[][3])
{
    pm_sensor sensors[HALF * MEMBERS];
    for (int i = 0; i < HALF; i++)
        place_members(&spots[first + i], CIRCLE, sensors + i * MEMBERS);
    pm_job job = job_of_mode(mode, PHOTONS, GATHER);
    look_at(&job, sensors, HALF * MEMBERS, spots[first].quantity);
    job.wanted.maps[PM_MAP_CAUSTIC].count = CAUSTICS;
    job.forward.seed = seed;
    job.passes = mode->progressive ? 1 : 32;
    pm_answer answer;
    run_job(&job, text, hooks, &answer);
    add_answer(&answer, got + first);
    pm_answer_clear(&answer);
}

/* Progressive passes know only no bounce or all: a twin gives the same numbers. -ab 0 is
 * compared with the reference at surfaces alone: its caustic map shows light that was diffuse
 * and then specular, L D S D E, and it has no such map where a ray or a free sensor sees a wall
 * in a mirror; the reference has no word for what is left out there. */
static bool is_compared(const struct mode *mode, const struct spot *spot, bool reference)
{
    if (mode->ambient_bounces)
        return !mode->progressive || mode->ambient_bounces < 0;
    return reference && spot->quantity == PM_IRRADIANCE && !spot->in_free_space;
}

static void run_spots(const char *text, bool reference, struct stat got[MODES][SPOTS][3])
{
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        struct store store = {0};
        pm_job_hooks hooks = store_hooks(&store);
        for (int m = 0; m < MODES; m++)
            for (int first = 0; first < SPOTS; first += HALF)
                if (is_compared(&modes[m], &spots[first], reference))
                    run_half(text, &modes[m], first, seed, &hooks, got[m]);
        store_clear(&store);
    }
}

/* ---- claims ---- */

static void expect_spot(const struct mode *mode, const struct spot *spot,
                        const struct truth *truth, const struct stat got[3])
{
    double loss = edge_loss(kernel_radius(mode));
    bool at_eye = spot->quantity == PM_IRRADIANCE && !spot->in_free_space &&
                  (mode->progressive || mode->ambient_bounces <= 0);
    for (int c = 0; c < 3; c++) {
        char what[100];
        snprintf(what, sizeof what, "%s, %s, channel %d", mode->name, spot->name, c);
        double slack = fabs(truth->curved[c]) + (at_eye ? 0 : loss * truth->many[c]);
        double want = mode->ambient_bounces ? truth->total[c] : truth->without_ambient[c];
        expect_equal_means(what, &got[c], want, truth->error[c], slack);
    }
}

static void partition_counts_each_path_once(void **state)
{
    (void)state;
    static struct stat got[MODES][SPOTS][3];
    struct ref_scene *scene = reference_of(SMOOTH);
    run_spots(SMOOTH, true, got);
    for (int i = 0; i < SPOTS; i++) {
        struct truth truth;
        truth_of(scene, &spots[i], .05, &truth);
        for (int m = 0; m < MODES; m++)
            if (is_compared(&modes[m], &spots[i], true))
                expect_spot(&modes[m], &spots[i], &truth, got[m][i]);
    }
    ref_free(scene);
}

/* The reference has no rough metal. All modes must still agree on it: within the edges' loss of
 * those that gather, which is less than of all light. */
static void partition_counts_glossy_paths_once(void **state)
{
    (void)state;
    static struct stat got[MODES][SPOTS][3];
    run_spots(ROUGH, false, got);
    for (int i = 0; i < SPOTS; i++)
        for (int m = 0; m < MODES; m++) {
            const struct stat *want = got[MODES - 1][i];
            if (!is_compared(&modes[m], &spots[i], false))
                continue;
            for (int c = 0; c < 3; c++) {
                char what[100];
                snprintf(what, sizeof what, "%s, %s, channel %d", modes[m].name, spots[i].name,
                         c);
                double loss = edge_loss(kernel_radius(&modes[m]));
                bool gathers = modes[m].ambient_bounces > 0 || spots[i].in_free_space;
                expect_equal_means(what, &got[m][i][c], want[c].mean, stat_error(&want[c]),
                                   gathers ? loss * want[c].mean : 0);
            }
        }
}

/* Progressive passes have no gather rays: the number of bounces asked for changes nothing. */
static void progressive_passes_know_only_no_bounce_or_all(void **state)
{
    (void)state;
    pm_sensor sensor = {spots[0].point, spots[0].normal};
    pm_answer answers[3];
    static const int bounces[3] = {1, -1, 3};
    for (int i = 0; i < 3; i++) {
        pm_job job = job_of(PM_JOB_TRACE, bounces[i]);
        look_at(&job, &sensor, 1, PM_IRRADIANCE);
        run_job(&job, SMOOTH, NULL, &answers[i]);
        assert_memory_equal(answers[i].values, answers[0].values, 3 * sizeof(float));
    }
    for (int i = 0; i < 3; i++)
        pm_answer_clear(&answers[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(partition_counts_each_path_once),
        cmocka_unit_test(partition_counts_glossy_paths_once),
        cmocka_unit_test(progressive_passes_know_only_no_bounce_or_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
