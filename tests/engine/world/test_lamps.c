/* Lamps outside of closed rooms: which are aimed, at what, and that it changes no mean. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "base/maths.h"
#include "base/sobol.h"
#include "world/lamps.h"

#define GREY  "void plastic grey 0 0 5 .5 .5 .5 0 0\nvoid light l 0 0 3 1 1 1\n"
#define FIELD "grey ring ground 0 0 8 0 0 -1.1 0 0 1 0 30\n"
#define SKY   "void glow sky 0 0 4 1 1 1 0 sky source dome 0 0 4 0 0 1 180\n"

/* A box of [-1, 1]^3 with a hole of .4 by .4 in its lid, or a pane, whose normal is up. */
#define ROOM                                                                                   \
    GREY "grey polygon w1 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n"                            \
         "grey polygon w2 0 0 12 -1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1\n"                            \
         "grey polygon w3 0 0 12 -1 1 -1 -1 1 1 1 1 1 1 1 -1\n"                                \
         "grey polygon w4 0 0 12 -1 -1 -1 -1 -1 1 -1 1 1 -1 1 -1\n"                            \
         "grey polygon w5 0 0 12 1 -1 -1 1 1 -1 1 1 1 1 -1 1\n"                                \
         "grey polygon lid 0 0 30 -1 -1 1 -1 1 1 1 1 1 1 -1 1 -1 -1 1 -.2 -.2 1 .2 -.2 1 "     \
         ".2 .2 1 -.2 .2 1 -.2 -.2 1\n"
#define PANE                                                                                   \
    "void glass clear 0 0 3 .9 .9 .9 clear polygon p 0 0 12 -.2 -.2 1 .2 -.2 1 .2 .2 1 -.2 "   \
    ".2 1\n"
#define WELL                                                                                   \
    "grey polygon s1 0 0 12 -.5 -.5 1 .5 -.5 1 .5 -.5 4 -.5 -.5 4\n"                           \
    "grey polygon s2 0 0 12 -.5 .5 1 .5 .5 1 .5 .5 4 -.5 .5 4\n"                               \
    "grey polygon s3 0 0 12 -.5 -.5 1 -.5 .5 1 -.5 .5 4 -.5 -.5 4\n"                           \
    "grey polygon s4 0 0 12 .5 -.5 1 .5 .5 1 .5 .5 4 .5 -.5 4\n"                               \
    "grey polygon s5 0 0 12 -.5 -.5 4 .5 -.5 4 .5 .5 4 -.5 .5 4\n"
#define LAMP   "l sphere lamp 0 0 4 0 0 3 .1\n"
#define INDOOR "l sphere indoor 0 0 4 0 0 0 .1\n"

enum { SAMPLES = 1 << 16 };
#define SIGMAS 5

struct room {
    pm_world *world;
    pm_selection ports[2];
    pm_lamps *lamps; /* NULL: none is aimed */
};

/* port: the modifier of surfaces that let light go against their normal; NULL: none. */
static struct room room_of(const char *text, const char *port, bool both)
{
    struct room room = {.world = world_of(text)};
    pm_error err = PM_ERROR_INIT;
    for (int side = 0; side < 2; side++) {
        bool named = port && (side || both);
        if (pm_selection_make(room.world, &port, named, "-apo", &room.ports[side], &err))
            fail_msg("%s", err.text);
    }
    if (pm_lamps_find(room.world, room.ports, &room.lamps, &err))
        fail_msg("%s", err.text);
    return room;
}

static void room_clear(struct room *room)
{
    pm_lamps_free(room->lamps);
    pm_selection_clear(&room->ports[0]);
    pm_selection_clear(&room->ports[1]);
    pm_world_free(room->world);
}

static void draw(uint32_t i, double u[5])
{
    for (unsigned d = 0; d < 5; d++)
        u[d] = pm_sobol(i, d, 3 + d);
}

/* Whether it passes the hole in the lid, and comes to the middle of the floor. */
static bool arrives(const pm_world *world, const pm_emission *e, double z, double half)
{
    pm_vec3 from = pm_world_to_scene(world, e->origin);
    double t = (z - from.z) / e->direction.z;
    pm_vec3 at = pm_vec3_madd(from, t, e->direction);
    return from.z > 1 && t > 0 && fabs(at.x) < half && fabs(at.y) < half;
}

/* Of the flux a photon: all, what passes the hole, what then falls on the floor's middle. */
enum { ALL, ENTERING, ON_FLOOR, SUMS };
#define MIDDLE .25 /* half its width: all of LAMP is seen from there */

struct means {
    double mean[SUMS], error[SUMS];
    double share; /* of the photons that enter */
};

static struct means means_of(const pm_world *world, const pm_lamps *lamps)
{
    struct means m = {.share = 0};
    double squares[SUMS] = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double u[5];
        pm_emission e;
        draw(i, u);
        assert_true(pm_lamps_emit(lamps, world, u, &e));
        assert_true(e.flux.r >= 0 && isfinite(e.flux.r));
        bool in = e.flux.r > 0 && arrives(world, &e, 1, .2);
        bool on_floor = in && arrives(world, &e, -1, MIDDLE);
        double values[SUMS] = {e.flux.r, in ? e.flux.r : 0, on_floor ? e.flux.r : 0};
        m.share += in ? 1. / SAMPLES : 0;
        for (int k = 0; k < SUMS; k++) {
            m.mean[k] += values[k] / SAMPLES;
            squares[k] += values[k] * values[k] / SAMPLES;
        }
    }
    for (int k = 0; k < SUMS; k++)
        m.error[k] = sqrt(fmax(squares[k] - m.mean[k] * m.mean[k], 0) / SAMPLES);
    return m;
}

static void expect_equal(const char *what, double got, double want, double error)
{
    if (!(fabs(got - want) <= SIGMAS * error + 1e-9 * want))
        fail_msg("%s: got %.7g, want %.7g, error %.2g", what, got, want, error);
}

static const struct {
    const char *text, *port;
} outdoors[] = {
    {ROOM LAMP, NULL},
    {ROOM PANE LAMP, NULL},
    {ROOM PANE FIELD LAMP INDOOR, NULL},
    {ROOM FIELD SKY "l cylinder lamp 0 0 7 -.5 1 3 .5 1 3 .05\n", NULL},
    {ROOM "void spotlight s 0 0 7 9 9 9 60 .5 0 -1\ns ring lamp 0 0 8 -1 0 3 .5 0 -1 0 .1\n",
     NULL},
    {ROOM "l polygon panel 0 0 12 -.1 -.1 4 -.1 .1 4 .1 .1 4 .1 -.1 4\n", NULL},
    {ROOM PANE LAMP INDOOR, "clear"},
    {ROOM WELL PANE LAMP INDOOR, "clear"},
};

/* Of all, of what enters and of what comes to the floor. */
static void aim_changes_no_mean(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof outdoors / sizeof *outdoors; i++) {
        struct room room = room_of(outdoors[i].text, outdoors[i].port, false);
        if (!room.lamps)
            fail_msg("%zu: not aimed", i);
        struct means a = means_of(room.world, room.lamps), b = means_of(room.world, NULL);
        for (int k = 0; k < SUMS; k++)
            expect_equal(outdoors[i].text, a.mean[k], b.mean[k], hypot(a.error[k], b.error[k]));
        assert_true(b.mean[ENTERING] > 0);
        room_clear(&room);
    }
}

/* Solid angle of a square of that half width, seen from over its middle. */
static double square_from(double height, double half)
{
    double slant = sqrt(2 * half * half + height * height);
    return 4 * atan(half * half / (height * slant));
}

/* A uniform ball lights like a point: the middle of the floor gets its solid angle's share of
 * the power, the hole the same (the ball is small before its distance of 2, 4 times that).
 * Half of the photons are aimed, half of those start where the lamp faces the hole, and of
 * these the hole takes its share of the disc about it, which is wider by 1.15 where it was
 * found: .159 and .120 of all. Unaimed ones enter by the hole's share of the sphere, .0031. */
static void closed_form_through_hole_pane_and_port(void **state)
{
    (void)state;
    static const struct {
        const char *text, *port;
    } rooms[] = {{ROOM LAMP, NULL}, {ROOM PANE LAMP, NULL}, {ROOM PANE LAMP, "clear"}};
    double floor = square_from(4, MIDDLE) / (4 * PM_PI),
           hole = square_from(2, .2) / (4 * PM_PI);
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++) {
        struct room room = room_of(rooms[i].text, rooms[i].port, false);
        assert_non_null(room.lamps);
        double power = pm_light_total_power(room.world).r;
        struct means aimed = means_of(room.world, room.lamps);
        struct means unaimed = means_of(room.world, NULL);
        expect_equal("power", aimed.mean[ALL], power, aimed.error[ALL]);
        expect_equal("hole", aimed.mean[ENTERING], hole * power, aimed.error[ENTERING]);
        expect_equal("floor", aimed.mean[ON_FLOOR], floor * power, aimed.error[ON_FLOOR]);
        expect_equal("unaimed photons", unaimed.share, hole, sqrt(hole / SAMPLES));
        if (!(aimed.share > (rooms[i].port ? .15 : .11)))
            fail_msg("%zu: a share of %g enters, %g unaimed", i, aimed.share, unaimed.share);
        room_clear(&room);
    }
}

/* Photons of a lamp inside, and of a room without one outside, stay what they are. */
static void lamps_inside_keep_their_photons(void **state)
{
    (void)state;
    static const struct {
        const char *text, *port;
    } rooms[] = {{ROOM LAMP INDOOR, NULL},
                 {ROOM PANE LAMP INDOOR, "clear"},
                 {ROOM WELL PANE LAMP INDOOR, "clear"}};
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++) {
        struct room room = room_of(rooms[i].text, rooms[i].port, false);
        assert_non_null(room.lamps);
        assert_non_null(strstr(pm_lamps_note(room.lamps), "1 lamp outside"));
        unsigned inside = 0;
        for (uint32_t s = 0; s < 4096; s++) {
            double u[5];
            pm_emission a, b;
            draw(s, u);
            assert_true(pm_lamps_emit(room.lamps, room.world, u, &a));
            assert_true(pm_light_emit(room.world, u, &b));
            assert_int_equal(a.light, b.light);
            if (pm_world_to_scene(room.world, b.origin).z > 1)
                continue;
            inside++;
            assert_true(a.flux.r == b.flux.r && a.origin.x == b.origin.x &&
                        a.direction.x == b.direction.x && a.direction.z == b.direction.z);
        }
        assert_true(inside > 1000);
        room_clear(&room);
    }
}

static void no_lamp_is_aimed_that_gains_nothing(void **state)
{
    (void)state;
    static const struct {
        const char *text, *port;
        bool both;
    } rooms[] = {
        {ROOM INDOOR, NULL, false},                /* inside */
        {ROOM PANE FIELD SKY INDOOR, NULL, false}, /* inside, under a sky */
        {ROOM PANE INDOOR, "clear", false},        /* inside, on the port's wrong side */
        {ROOM PANE INDOOR, "clear", true},         /* inside, with a port for both sides */
        {ROOM SKY, NULL, false},                   /* no lamp */
        {GREY FIELD LAMP, NULL, false},            /* no room */
        {ROOM WELL PANE LAMP, NULL, false},        /* all closed, no port named */
        {ROOM "l ring lamp 0 0 8 0 0 3 0 0 1 0 .1\n", NULL, false}, /* it shines away */
    };
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++) {
        struct room room = room_of(rooms[i].text, rooms[i].port, rooms[i].both);
        if (room.lamps)
            fail_msg("%zu: %s", i, pm_lamps_note(room.lamps));
        room_clear(&room);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(aim_changes_no_mean),
        cmocka_unit_test(closed_form_through_hole_pane_and_port),
        cmocka_unit_test(lamps_inside_keep_their_photons),
        cmocka_unit_test(no_lamp_is_aimed_that_gains_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
