/* Light of distant sources that comes through ports into rooms, against closed forms, the
 * reference tracer, and runs without ports. */
#include "physics.h"

/* ---- scenes ---- */

/* Albedo 1/2; the sky's radiance is 1 over the horizon. */
#define GREY_WALL "void plastic wall 0 0 5 .5 .5 .5 0 0\n"
#define SKY       "void glow sky 0 0 4 1 1 1 0 sky source dome 0 0 4 0 0 1 180\n"
#define PORT      "void antimatter port 1 void 0 0\n"
#define PANE      "void glass pane 0 0 3 .9 .9 .9\n"

/* A room whose ceiling has a skylight of 1 by 1; the opening's own surface looks down. */
#define HALL                                                                                   \
    GREY_WALL                                                                                  \
    "wall polygon floor 0 0 12 -1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1\n"                              \
    "wall polygon south 0 0 12 -1 -1 -1 -1 -1 1 1 -1 1 1 -1 -1\n"                              \
    "wall polygon north 0 0 12 -1 1 -1 1 1 -1 1 1 1 -1 1 1\n"                                  \
    "wall polygon west 0 0 12 -1 -1 -1 -1 1 -1 -1 1 1 -1 -1 1\n"                               \
    "wall polygon east 0 0 12 1 -1 -1 1 -1 1 1 1 1 1 1 -1\n"                                   \
    "wall polygon ceiling 0 0 30 -1 -1 1 -1 1 1 1 1 1 1 -1 1 -1 -1 1 -.5 -.5 1 .5 -.5 1 .5 "   \
    ".5 1 -.5 .5 1 -.5 -.5 1\n"
#define ROOM(opening)                                                                          \
    HALL opening " polygon skylight 0 0 12 -.5 -.5 1 -.5 .5 1 .5 .5 1 .5 -.5 1\n"

static void use_port(pm_job *job, const char *modifier, unsigned sides)
{
    static pm_port_option port;
    port = (pm_port_option){modifier, sides};
    job->forward.ports = &port;
    job->forward.port_count = 1;
}

/* Sensors on the floor and a wall; -ab -1 and a final gather, maps and progressive passes. */
static const pm_sensor sensors[] = {{{.3, .2, -1}, {0, 0, 1}}, {{-1, .1, .2}, {1, 0, 0}}};
enum { COUNT = sizeof sensors / sizeof *sensors };

/* ---- rooms ---- */

/* What arrives at the sensors, in a mode; `plain` is the scene without antimatter. A look-up of
 * 30 of some 10,000 photons on 24 units of area has a radius of .15, over which the light of a
 * skylight bends by less than 1 / m^2: r^2 / 4. */
static void expect_room(const char *text, const char *plain, const char *modifier,
                        unsigned sides, const struct mode *mode)
{
    enum { SOME = 4 };
    struct stat got[3 * COUNT] = {0};
    pm_job job = job_of_mode(mode, 10000, 30);
    use_port(&job, modifier, sides);
    look_at(&job, sensors, COUNT, PM_IRRADIANCE);
    job.passes = mode->progressive ? 8 : 200;
    run_seeds(&job, text, SOME, got);
    for (int i = 0; i < COUNT; i++) {
        struct ref_result want = reference_irradiance(plain, &sensors[i], .05, 30000);
        char what[120];
        snprintf(what, sizeof what, "sensor %d, %s", i, mode->name);
        expect_equal_means(what, &got[3 * i + 1], want.total[1], want.total_standard_error[1],
                           .012 * want.total[1]);
    }
}

static void light_through_a_port_is_what_a_tracer_finds(void **state)
{
    (void)state;
    expect_room(ROOM(PORT SKY "port"), HALL SKY, "port", PM_PORT_FRONT, &modes[0]);
    expect_room(ROOM(PORT SKY "port"), HALL SKY, "port", PM_PORT_FRONT, &modes[6]);
    expect_room(ROOM(PANE SKY "pane"), ROOM(PANE SKY "pane"), "pane",
                PM_PORT_FRONT | PM_PORT_BACK, &modes[4]);
}

/* ---- power ---- */

static pm_answer map_of(const char *text, const char *modifier, unsigned sides)
{
    pm_answer answer;
    pm_job job = job_of(PM_JOB_MAP, -1);
    want_map(&job, PM_MAP_GLOBAL, 100000, 0);
    use_port(&job, modifier, sides);
    run_job(&job, text, NULL, &answer);
    return answer;
}

/* pi a square unit; from the balance of a batch of 65536 paths at least. Weights differ by
 * the tables' steps, less than 1: 5 sigma are 5 / 256. */
static void what_enters_is_the_power(void **state)
{
    (void)state;
    pm_answer answer = map_of(ROOM(PORT SKY "port"), "port", PM_PORT_FRONT);
    expect_near("emitted", answer.emitted.r, PI, PI * 5 / 256);
    expect_near("balance", answer.absorbed.r + answer.escaped.r, answer.emitted.r,
                PI * 5 / 256);
    const pm_map_header *h = pm_photon_map_header(answer.map[PM_MAP_GLOBAL]);
    expect_near("header", h->emitted.r * h->world_scale * h->world_scale, PI, PI * 5 / 128);
    pm_answer_clear(&answer);
}

static void nothing_enters_a_port_from_within(void **state)
{
    (void)state;
    pm_answer answer = map_of(ROOM(PORT SKY "port"), "port", PM_PORT_BACK);
    assert_int_equal(pm_photon_map_count(answer.map[PM_MAP_GLOBAL]), 0);
    pm_answer_clear(&answer);
}

/* ---- out and in again ---- */

/* A white court outside: all its light has come through the box of ports about the scene, and
 * that is all the light there is. */
#define COURT                                                                                  \
    ROOM(PANE SKY "pane")                                                                      \
    "void plastic white 0 0 5 .9 .9 .9 0 0\n"                                                  \
    "white polygon facade 0 0 12 -1 -.6 1 1 -.6 1 1 -.6 3 -1 -.6 3\n"

static const char court[] =
    COURT PORT "port polygon p1 0 0 12 -2 -2 -2 2 -2 -2 2 2 -2 -2 2 -2\n"
               "port polygon p2 0 0 12 -2 -2 4 -2 2 4 2 2 4 2 -2 4\n"
               "port polygon p3 0 0 12 -2 -2 -2 -2 -2 4 2 -2 4 2 -2 -2\n"
               "port polygon p4 0 0 12 -2 2 -2 2 2 -2 2 2 4 -2 2 4\n"
               "port polygon p5 0 0 12 -2 -2 -2 -2 2 -2 -2 2 4 -2 -2 4\n"
               "port polygon p6 0 0 12 2 -2 -2 2 -2 4 2 2 4 2 2 -2\n";

static void a_box_of_ports_lets_all_light_in(void **state)
{
    (void)state;
    expect_room(court, COURT, "port", PM_PORT_FRONT, &modes[6]);
}

/* Through the skylight alone: light that the facade throws in has not passed it before, so only
 * what left the room through the skylight comes back by it. */
static void light_that_leaves_may_come_back(void **state)
{
    (void)state;
    static const char lid[] =
        "void plastic lid 0 0 5 1 1 1 0 0\n"
        "lid polygon cover 0 0 12 -.5 -.5 1.5 -.5 .5 1.5 .5 .5 1.5 .5 -.5 "
        "1.5\n";
    char *open = text_of("%s", ROOM(PORT SKY "port"));
    char *covered = text_of("%s%s", ROOM(PORT SKY "port"), lid);
    pm_answer a = map_of(open, "port", PM_PORT_FRONT);
    pm_answer b = map_of(covered, "port", PM_PORT_FRONT);
    double outside = a.escaped.r / a.emitted.r, returned = b.escaped.r / b.emitted.r;
    assert_true(b.emitted.r < .7 * a.emitted.r); /* the lid hides the middle of the sky */
    assert_true(returned < .9 * outside);        /* and sends light back */
    pm_answer_clear(&a);
    pm_answer_clear(&b);
    free(open);
    free(covered);
}

/* ---- defect 7 ---- */

/* Radiance: a caustic map that is loaded takes the light of the window from sensors near a
 * port. Here the maps share it: all modes give the same. */
static void defect_7_a_caustic_map_leaves_the_windows_light(void **state)
{
    (void)state;
    const pm_sensor near = {{.1, .1, .9}, {0, 0, 1}};
    static const char text[] = ROOM(
        PANE SKY
        "pane") "void metal mirror 0 0 5 .9 .9 .9 1 0 mirror sphere ball 0 0 4 .5 .5 -.6 .2\n";
    struct stat with[2];
    for (int caustic = 0; caustic < 2; caustic++) {
        pm_job job = job_of_mode(&modes[caustic ? 7 : 6], 10000, 30);
        use_port(&job, "pane", PM_PORT_FRONT);
        look_at(&job, &near, 1, PM_IRRADIANCE);
        with[caustic] = run_mean(&job, text, 6, GREY);
    }
    expect_equal_means("with a caustic map", &with[1], with[0].mean, stat_error(&with[0]),
                       .01 * with[0].mean);
    assert_true(with[0].mean > 2); /* the sky through the pane: pi * .9 at most */
}

/* ---- found by themselves ---- */

/* A room with a hole of .3 by .3 and no port named. */
#define CELLAR                                                                                 \
    GREY_WALL SKY PORT                                                                         \
        "wall polygon floor 0 0 12 -1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1\n"                          \
        "wall polygon south 0 0 12 -1 -1 -1 -1 -1 1 1 -1 1 1 -1 -1\n"                          \
        "wall polygon north 0 0 12 -1 1 -1 1 1 -1 1 1 1 -1 1 1\n"                              \
        "wall polygon west 0 0 12 -1 -1 -1 -1 1 -1 -1 1 1 -1 -1 1\n"                           \
        "wall polygon east 0 0 12 1 -1 -1 1 -1 1 1 1 1 1 1 -1\n"                               \
        "wall polygon ceiling 0 0 30 -1 -1 1 -1 1 1 1 1 1 1 -1 1 -1 -1 1 -.15 -.15 1 .15 "     \
        "-.15 1 "                                                                              \
        ".15 .15 1 -.15 .15 1 -.15 -.15 1\n"                                                   \
        "port polygon hole 0 0 12 -.15 -.15 1 -.15 .15 1 .15 .15 1 .15 -.15 1\n"

/* What has been reflected lies on the floor within 1 of its middle; light comes by the hole. */
static void a_closed_room_is_lit_by_its_window(void **state)
{
    (void)state;
    struct stat flux[2][3];
    for (int named = 0; named < 2; named++) {
        pm_job job = job_of(PM_JOB_MAP, -1);
        want_map(&job, PM_MAP_GLOBAL, 20000, 0);
        if (named)
            use_port(&job, "port", PM_PORT_FRONT);
        run_flux(&job, CELLAR, PM_MAP_GLOBAL, (pm_vec3){0, 0, -1}, 1, flux[named]);
    }
    expect_equal_means("found", &flux[0][1], flux[1][1].mean, stat_error(&flux[1][1]), 0);
    pm_answer answer;
    pm_job job = job_of(PM_JOB_MAP, -1);
    want_map(&job, PM_MAP_GLOBAL, 20000, 0);
    run_job(&job, CELLAR, NULL, &answer);
    assert_non_null(strstr(answer.plan.pass[PM_MAP_GLOBAL].reason, "openings"));
    assert_non_null(strstr(pm_photon_map_header(answer.map[PM_MAP_GLOBAL])->note, "openings"));
    pm_answer_clear(&answer);
}

/* ---- names ---- */

static void unknown_ports_are_refused(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    pm_job job = job_of(PM_JOB_MAP, -1);
    pm_answer answer;
    want_map(&job, PM_MAP_GLOBAL, 1000, 0);
    use_port(&job, "glazing", PM_PORT_FRONT);
    pm_bundle *bundle = pm_bundle_new();
    static const char text[] = ROOM(PANE SKY "pane");
    assert_int_equal(pm_bundle_add(bundle, job.main_name, text, sizeof text - 1, &err), PM_OK);
    assert_int_equal(pm_job_run(&job, bundle, NULL, &answer, &err), PM_E_MISSING);
    assert_non_null(strstr(err.text, "wall, pane"));
    pm_bundle_free(bundle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_through_a_port_is_what_a_tracer_finds),
        cmocka_unit_test(what_enters_is_the_power),
        cmocka_unit_test(nothing_enters_a_port_from_within),
        cmocka_unit_test(a_box_of_ports_lets_all_light_in),
        cmocka_unit_test(light_that_leaves_may_come_back),
        cmocka_unit_test(defect_7_a_caustic_map_leaves_the_windows_light),
        cmocka_unit_test(a_closed_room_is_lit_by_its_window),
        cmocka_unit_test(unknown_ports_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
