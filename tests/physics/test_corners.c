/* The inside of a box in even light: its edges and corners. */
#include "physics.h"

/* A box of diffuse film under an even sky: of each side's irradiance the share t passes, r is
 * reflected. The sky brings pi outside, so inside every wall has exitance t pi + r E, the same
 * everywhere, and E = t pi / (1 - r): a furnace whose walls shine and reflect alike, up to
 * edges where two walls meet and corners where three do. All light within is indirect. */
enum { PLACES = 24, NEAR = 8, ROW = PLACES * NEAR, ROWS = 3 };

/* The same place on each of the three faces at all eight corners, facing inwards. */
static void within_corners(double x, double y, pm_sensor sensors[PLACES])
{
    for (int i = 0; i < PLACES; i++) {
        const double at[3] = {i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? 1 : -1};
        double p[3], n[3] = {0, 0, 0};
        for (int c = 0; c < 3; c++)
            p[(c + i / 8) % 3] = at[c];
        n[(2 + i / 8) % 3] = -at[2];
        sensors[i] = (pm_sensor){{p[0], p[1], p[2]}, {n[0], n[1], n[2]}};
    }
}

/* Per seed, the mean of each row and of all. */
static void measure(pm_job *job, const char *text, struct stat got[ROWS + 1])
{
    for (unsigned seed = 1; seed <= SEEDS / 2; seed++) {
        pm_answer answer;
        double all = 0;
        job->forward.seed = seed;
        run_job(job, text, NULL, &answer);
        for (int row = 0; row < ROWS; row++) {
            double sum = 0;
            for (int k = row * ROW; k < (row + 1) * ROW; k++)
                sum += (double)answer.values[3 * k] / ROW;
            stat_add(&got[row], sum);
            all += sum / ROWS;
        }
        stat_add(&got[ROWS], all);
        pm_answer_clear(&answer);
    }
}

/* In the corner, near it, along the edge. A quarter of the disc of an estimate lies on the
 * surface in the corner, a half at the edge, and what lies there is found out by chance: that
 * makes most of the noise, so the mean of all decides on the one percent. K photons more even
 * than by chance are off by 1 / K at most: test_density.c. */
static void a_box_is_even_within_one_percent_up_to_its_corners(void **state)
{
    (void)state;
    enum { PHOTONS = 200000, GATHER = 400 };
    static const char *const names[ROWS + 1] = {"corner", "near it", "edge", "all"};
    const double reflected = .4, passed = .4, want = PI * passed / (1 - reflected);
    pm_sensor sensors[ROWS * ROW];
    char *text = text_of("void glow sky 0 0 4 1 1 1 0  sky source all 0 0 4 0 0 1 360\n"
                         "void trans film 0 0 7 %.17g %.17g %.17g 0 0 .5 0\n" BOX("film"),
                         passed + reflected, passed + reflected, passed + reflected);
    for (int i = 0; i < NEAR; i++) {
        double corner = .999 - .001 * i, near = .95 - .005 * i;
        within_corners(corner, corner, &sensors[i * PLACES]);
        within_corners(near, near, &sensors[ROW + i * PLACES]);
        within_corners(.999, .7 - .1 * i, &sensors[2 * ROW + i * PLACES]);
    }
    for (int i = 0; i < 2; i++) {
        pm_job job = job_of(PM_JOB_TRACE, -1);
        struct stat got[ROWS + 1] = {0};
        look_at(&job, sensors, ROWS * ROW, PM_IRRADIANCE);
        job.passes = i ? 12 : 24;
        if (i)
            want_map(&job, PM_MAP_GLOBAL, PHOTONS, GATHER);
        measure(&job, text, got);
        for (int row = 0; row <= ROWS; row++) {
            char what[40];
            snprintf(what, sizeof what, "%s, %s", i ? "nearest" : "progressive", names[row]);
            expect_mean(what, &got[row], want, i ? want / GATHER : 0);
        }
        assert_true(stat_error(&got[ROWS]) < .005 * want);
        assert_true(fabs(got[ROWS].mean / want - 1) < .01);
    }
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_is_even_within_one_percent_up_to_its_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
