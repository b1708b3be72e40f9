/* Maps have the number of photons wanted, or say what was reached, and the work is bounded. */
#include "physics.h"

#define LAMP "void light bright 0 0 3 1 1 1  bright ring lamp 0 0 8 0 0 0 0 0 -1 0 .1\n"
#define GREY_FLOOR                                                                             \
    "void plastic grey 0 0 5 .5 .5 .5 0 0  grey ring floor 0 0 8 0 0 -1 0 0 1 0 2\n"

static void make(const char *text, pm_map_kind kind, uint64_t photons, pm_answer *answer)
{
    pm_job job = job_of(PM_JOB_MAP, -1);
    want_map(&job, kind, photons, 50);
    run_job(&job, text, NULL, answer);
}

static bool says(const pm_answer *answer, pm_map_kind kind, const char *words)
{
    return strstr(answer->maps[kind].note, words);
}

/* Where a path has tens of photons, too: fewer than a hundred are met exactly. */
static void small_maps_of_bright_rooms_have_what_was_asked(void **state)
{
    (void)state;
    static const uint64_t wanted[] = {1, 99, 1000};
    for (int i = 0; i < 6; i++) {
        pm_answer answer;
        pm_map_kind kind = i % 2 ? PM_MAP_CAUSTIC : PM_MAP_GLOBAL;
        make("void plastic white 0 0 5 .9 .9 .9 0 0\n" BOX("white") LAMP
             "void dielectric clear 0 0 5 1 1 1 1.5 0  clear sphere ball 0 0 4 0 0 -.5 .2\n",
             kind, wanted[i / 2], &answer);
        assert_in_range(answer.maps[kind].photons, wanted[i / 2] - wanted[i / 2] / 100,
                        wanted[i / 2]);
        assert_string_equal(answer.maps[kind].note, "");
        pm_answer_clear(&answer);
    }
}

/* The flux of a small map is that of its paths, though it takes a share of the photons: in a
 * closed sphere the light after the first hit is s / (1 - s) of the lamp's (test_sphere.c). */
static void small_maps_have_all_the_flux(void **state)
{
    (void)state;
    struct stat flux = {0};
    double s = .5 * (1 - .02 * .02), power = PI * 4 * PI * .02 * .02;
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        pm_answer answer;
        pm_job job = job_of(PM_JOB_MAP, -1);
        want_map(&job, PM_MAP_GLOBAL, 1000, 50);
        job.forward.seed = seed;
        run_job(&job, EVEN_SPHERE, NULL, &answer);
        stat_add(&flux,
                 flux_within(answer.map[PM_MAP_GLOBAL], (pm_vec3){0, 0, 0}, 2).r / power);
        pm_answer_clear(&answer);
    }
    expect_mean("flux", &flux, s / (1 - s), .002);
}

/* Light that never comes to a surface, that a closed case holds, or that a hole of 10^-6 lets
 * through: an answer that tells where it went, after 2^22 paths and 1000 a photon found. */
static void maps_that_do_not_fill_say_where_the_light_went(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {GREY_FLOOR "void light bright 0 0 3 1 1 1  bright ring lamp 0 0 8 0 0 0 0 0 1 0 .1\n",
         "with 0 of 1000 photons: too few paths end here; 100 % of the light escaped, 0 % was "
         "absorbed"},
        {GREY_FLOOR LAMP
         "void plastic black 0 0 5 0 0 0 0 0  black bubble case 0 0 4 0 0 0 .5\n",
         "0 % of the light escaped, 100 % was absorbed"},
        {GREY_FLOOR LAMP
         "void plastic black 0 0 5 0 0 0 0 0  black ring sheet 0 0 8 0 0 -.5 0 0 1 .0005 99\n",
         "of 1000 photons: too few paths end here"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pm_answer answer;
        make(cases[i].text, PM_MAP_GLOBAL, 1000, &answer);
        const pm_map_summary *map = &answer.maps[PM_MAP_GLOBAL];
        if (!says(&answer, PM_MAP_GLOBAL, cases[i].words))
            fail_msg("case %zu says '%s'", i, map->note);
        assert_in_range(map->paths, 1 << 22, (1 << 22) + 1000 * map->photons + PM_BATCH_PATHS);
        pm_answer_clear(&answer);
    }
}

/* Where paths are long, fewer are traced: here 20 stretches each, on average, not 8. */
static void long_paths_count_for_more(void **state)
{
    (void)state;
    pm_answer answer;
    make("void plastic white 0 0 5 .98 .98 .98 0 0\n" BOX("white") LAMP
         "void dielectric clear 0 0 5 1 1 1 1.5 0  clear sphere ball 0 0 4 0 0 -3 .2\n",
         PM_MAP_CAUSTIC, 1000, &answer);
    const pm_map_summary *map = &answer.maps[PM_MAP_CAUSTIC];
    assert_int_equal(map->photons, 0);
    assert_in_range(map->paths, 1 << 20, 1 << 21);
    assert_true(says(&answer, PM_MAP_CAUSTIC, "0 % of the light escaped, 100 % was absorbed"));
    pm_answer_clear(&answer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_maps_of_bright_rooms_have_what_was_asked),
        cmocka_unit_test(small_maps_have_all_the_flux),
        cmocka_unit_test(maps_that_do_not_fill_say_where_the_light_went),
        cmocka_unit_test(long_paths_count_for_more),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
