/* The peer's thirteen defects, by number: what shows that this engine has none of them. Those
 * that other themes prove are named, and looked for there; the rest is here. */
#include "physics.h"

#include <unistd.h>

#include "bundle_text.h"

static const struct {
    int defect;
    const char *what, *file, *test;
} proofs[] = {
    {1, "volume radiance has no factor of the extinction too many",
     "tests/physics/test_media.c", "single_scattering_is_that_of_the_analytic_integral"},
    {1, "along a spotlight's beam likewise", "tests/physics/test_spotlight.c",
     "a_beam_seen_from_the_side_is_scattered_once"},
    {1, "nor has the map's estimate of a point", "tests/physics/test_defects.c",
     "defect_01_density_of_volume_photons"},
    {2, "free paths are drawn anew behind a boundary", "tests/physics/test_media.c",
     "photons_go_on_in_the_mist_behind_a_ball"},
    {3, "mist goes on behind a dielectric in it", "tests/physics/test_mists.c",
     "a_glass_ball_in_mist_has_the_references_light"},
    {4, "no prepass aborts; counts are reached", "tests/physics/test_defects.c",
     "defect_04_bright_rooms_and_thick_mists_reach_their_counts"},
    {5, "no caustic is an answer", "tests/physics/test_pipeline.c",
     "map_that_cannot_be_is_empty_and_says_why"},
    {5, "nor is light that never arrives an error", "tests/physics/test_mirrors.c",
     "concentrator_passes_nothing_beyond_its_acceptance"},
    {6, "scale and offset change nothing", "tests/physics/test_scale.c",
     "answers_do_not_depend_on_unit_and_place"},
    {7, "a caustic map leaves the window's light", "tests/physics/test_ports.c",
     "defect_7_a_caustic_map_leaves_the_windows_light"},
    {8, "corners and edges are as bright as they are", "tests/physics/test_edges.c",
     "edges_and_corners_are_right_within_one_percent"},
    {8, "within a room likewise", "tests/physics/test_corners.c",
     "a_box_is_even_within_one_percent_up_to_its_corners"},
    {8, "no light beyond a wall", "tests/physics/test_edges.c",
     "nothing_comes_through_a_wall_without_thickness"},
    {9, "a map belongs to a scene, whatever its files' times", "tests/physics/test_pipeline.c",
     "map_of_another_scene_is_refused"},
    {10, "a seed fixes every byte, for any threads", "tests/physics/test_pipeline.c",
     "maps_have_the_same_bytes_for_1_2_and_7_threads"},
    {10, "and nobody waits for a clock", "tests/physics/test_defects.c",
     "defect_10_a_small_map_does_not_wait"},
    {11, "errors fall where counts grow with the map", "tests/physics/test_density.c",
     "error_falls_only_if_the_gather_count_grows_with_the_map"},
    {11, "and with the passes", "tests/physics/test_progressive.c",
     "error_falls_with_the_passes_as_theory_says"},
    {12, "commands of a scene do not run", "tests/physics/test_defects.c",
     "defect_12_commands_of_a_scene_do_not_run"},
    {13, "spotlights have their focus", "tests/engine/forward/test_path.c",
     "a_focused_spotlight_keeps_back_flux_by_distance"},
    {13, "bias compensation for volumes", "tests/engine/photons/test_bias.c",
     "even_mist_is_estimated_right"},
};

enum { DEFECTS = 13, PROOFS = sizeof proofs / sizeof *proofs };

static bool is_run_in(const char *name, const char *test)
{
    char path[512], call[200];
    snprintf(path, sizeof path, "%s/%s", PM_SOURCE_DIR, name);
    snprintf(call, sizeof call, "cmocka_unit_test(%s)", test);
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("no file %s", path);
    static char text[1 << 20];
    size_t size = fread(text, 1, sizeof text - 1, file);
    fclose(file);
    text[size] = 0;
    return strstr(text, call);
}

static void every_defect_has_its_proof(void **state)
{
    (void)state;
    bool proven[DEFECTS + 1] = {false};
    for (int i = 0; i < PROOFS; i++) {
        if (!is_run_in(proofs[i].file, proofs[i].test))
            fail_msg("defect %d (%s): %s runs no %s", proofs[i].defect, proofs[i].what,
                     proofs[i].file, proofs[i].test);
        proven[proofs[i].defect] = true;
    }
    for (int i = 1; i <= DEFECTS; i++)
        if (!proven[i])
            fail_msg("nothing is said of defect %d", i);
}

/* ---- 1 ----
 *
 * Light 1 that falls straight into a fog of extinction s collides s exp(-s h) times a volume at
 * depth h, whatever is scattered: the albedo is 1e-4. Isotropic: 1 / 4 pi of it a steradian. A
 * ball of radius r has 3 (u cosh u - sinh u) / u^3 of that, u = s r. */
static const char cube[] = "fog polygon low 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n"
                           "fog polygon top 0 0 12 -1 -1 1 1 -1 1 1 1 1 -1 1 1\n"
                           "fog polygon south 0 0 12 -1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1\n"
                           "fog polygon north 0 0 12 -1 1 -1 -1 1 1 1 1 1 1 1 -1\n"
                           "fog polygon west 0 0 12 -1 -1 -1 -1 -1 1 -1 1 1 -1 1 -1\n"
                           "fog polygon east 0 0 12 1 -1 -1 1 1 -1 1 1 1 1 -1 1\n";

static void defect_01_density_of_volume_photons(void **state)
{
    (void)state;
    enum { PHOTONS = 20000, PLACES = 25 };
    static const double extinctions[] = {.5, 1, 2, 10};
    for (int i = 0; i < 4; i++) {
        double s = extinctions[i], depth = fmin(.5, 1 / s), r = fmin(.15, .5 / s);
        double radiance = sun_radiance();
        char *text =
            text_of("void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"
                    "void mist fog 0 0 7 %g %g %g 1e-4 1e-4 1e-4 0\n%s",
                    radiance, radiance, radiance, s, s, s, cube);
        pm_job job = job_of(PM_JOB_MAP, -1);
        want_map(&job, PM_MAP_VOLUME, PHOTONS, 50);
        struct stat got = {0};
        for (unsigned seed = 1; seed <= SEEDS; seed++) {
            pm_answer answer;
            job.forward.seed = seed;
            run_job(&job, text, NULL, &answer);
            const pm_photon_map *map = answer.map[PM_MAP_VOLUME];
            const pm_map_header *h = pm_photon_map_header(map);
            double sum = 0;
            for (int k = 0; k < PLACES; k++) {
                pm_vec3 p = {.35 * (k % 5 - 2), .35 * (k / 5 - 2), 1 - depth};
                p = pm_vec3_scale(pm_vec3_sub(p, h->world_center), 1 / h->world_scale);
                /* flux over world volume: W/m^2 a world length */
                sum += pm_photon_map_volume_within(map, p, (pm_vec3){1, 0, 0}, 0,
                                                   r / h->world_scale)
                           .irradiance.r /
                       h->world_scale;
            }
            stat_add(&got, sum / PLACES);
            pm_answer_clear(&answer);
        }
        double u = s * r, spread = 3 * (u * cosh(u) - sinh(u)) / (u * u * u);
        double want = s * exp(-s * depth) * spread / (4 * PI);
        char what[40];
        snprintf(what, sizeof what, "extinction %g", s);
        expect_mean(what, &got, want, want * (1. / PHOTONS + 3e-4));
        free(text);
    }
}

/* ---- 4 ----
 *
 * A map ends before the path that has one photon too many. Small ones take .03 (of 1000) or .9
 * (of 30000) photons a path on average, and the tail falls like a geometric distribution's. */

static void expect_count(const char *what, const char *text, pm_map_kind kind)
{
    static const uint64_t counts[] = {1000, 30000};
    for (int i = 0; i < 2; i++) {
        pm_job job = job_of(PM_JOB_MAP, -1);
        pm_answer answer;
        want_map(&job, kind, counts[i], 50);
        run_job(&job, text, NULL, &answer);
        double photons = (double)pm_photon_map_count(answer.map[kind]);
        double missing = (double)counts[i] - photons;
        if (!(missing >= 0 && missing <= .01 * (double)counts[i]))
            fail_msg("%s: %g photons instead of %g", what, photons, (double)counts[i]);
        assert_string_equal(pm_photon_map_header(answer.map[kind])->note, "");
        pm_answer_clear(&answer);
    }
}

static void defect_04_bright_rooms_and_thick_mists_reach_their_counts(void **state)
{
    (void)state;
    static const double albedos[] = {.9, .99, .999};
    for (int i = 0; i < 3; i++) {
        double a = albedos[i];
        char *room =
            text_of("void light bright 0 0 3 1 1 1  bright sphere lamp 0 0 4 0 0 0 .1\n"
                    "void plastic grey 0 0 5 %g %g %g 0 0  grey bubble wall 0 0 4 0 0 0 1\n",
                    a, a, a);
        expect_count("sphere", room, PM_MAP_GLOBAL);
        char *mist =
            text_of("void light bright 0 0 3 1 1 1  bright sphere lamp 0 0 4 0 0 0 .1\n"
                    "void mist fog 0 0 7 100 100 100 %g %g %g 0\n%s",
                    a, a, a, cube);
        expect_count("mist", mist, PM_MAP_VOLUME);
        free(room);
        free(mist);
    }
}

/* ---- 10: the peer asks its children every second; processor and wall time are the same ----
 */

static void defect_10_a_small_map_does_not_wait(void **state)
{
    (void)state;
    pm_job job = job_of(PM_JOB_MAP, -1);
    pm_answer answer;
    want_map(&job, PM_MAP_GLOBAL, 1000, 50);
    double least = INFINITY; /* of several: the machine may have other things to do */
    for (int i = 0; i < 10; i++) {
        run_job(&job, EVEN_SPHERE, NULL, &answer);
        least = fmin(least, answer.wall_seconds);
        pm_answer_clear(&answer);
    }
    assert_true(least < 2);
}

/* ---- 12 ---- */

static void defect_12_commands_of_a_scene_do_not_run(void **state)
{
    (void)state;
    char path[] = "/tmp/defect_12_XXXXXX";
    assert_non_null(mkdtemp(path));
    static const char *const commands[] = {
        "!touch %s/ran", "!sh -c 'touch %s/ran'", "!xform -n a /dev/null; touch %s/ran",
        "!genbox m n 1 1 1 `touch %s/ran`", "!genbox m n 1 1 $(touch %s/ran)"};
    for (int i = 0; i < 5; i++) {
        char line[200], text[400], file[64];
        pm_error err = PM_ERROR_INIT;
        pm_answer answer;
        pm_bundle *bundle = pm_bundle_new();
        pm_job job = job_of(PM_JOB_CHECK, 0);
        const char *place = strchr(commands[i], '%');
        snprintf(line, sizeof line, "%.*s%s%s", (int)(place - commands[i]), commands[i], path,
                 place + 2);
        snprintf(text, sizeof text, "void plastic m 0 0 5 .5 .5 .5 0 0\n%s\n", line);
        assert_int_equal(add_texts(bundle, job.main_name, text, &err), PM_OK);
        assert_int_not_equal(pm_job_run(&job, bundle, NULL, &answer, &err), PM_OK);
        assert_true(err.line == 2);
        pm_bundle_free(bundle);
        snprintf(file, sizeof file, "%s/ran", path);
        assert_int_not_equal(access(file, F_OK), 0);
    }
    assert_int_equal(rmdir(path), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_defect_has_its_proof),
        cmocka_unit_test(defect_01_density_of_volume_photons),
        cmocka_unit_test(defect_04_bright_rooms_and_thick_mists_reach_their_counts),
        cmocka_unit_test(defect_10_a_small_map_does_not_wait),
        cmocka_unit_test(defect_12_commands_of_a_scene_do_not_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
