/* Each kind of texture, pattern and mixture, at points of a square at z = 0 seen along a given
 * direction from 2 above. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/xyz.h"
#include "compile.h"
#include "world/material.h"
#include "world/shading.h"

#define SQUARE                                                                                 \
    "p plastic m 0 0 5 .5 .25 .125 0 0\nm polygon s 0 0 12 -8 -8 0 8 -8 0 8 8 0 -8 8 0\n"

static const char functions[] =
    "linear = A1*Px + A2*Py;\nslope = (Dx + 2*Dy + 4*Dz)/4;\n"
    "up(v) = 3*v; mix3(r,g,b) = r + 10*g + 100*b; square(v) = v*v;\n"
    "first(a,b,c) = a; second(a,b,c) = b; third(a,b,c) = c;\n"
    "band(nm) = if(nm-560, 0, 1); scaled(v,nm) = v*nm/500;\n";
/* f(x) = 1 + x; g(x,y) = 10 x + y; spectrum over 380 .. 780 rising with the wavelength */
static const char line_dat[] = "1\n-1 1 2\n0 2\n";
static const char line2_dat[] = "1\n-1 1 2\n0 4\n";
static const char line3_dat[] = "1\n-1 1 2\n0 6\n";
static const char plane_dat[] = "2\n0 1 2\n0 1 2\n0 1 10 11\n";
static const char spectrum_dat[] = "1\n430 730 4\n.2 .4 .6 .8\n";
static const char spectra_dat[] = "2\n0 1 2\n430 730 4\n0 0 0 0\n.2 .4 .6 .8\n";
/* 2 x 2, with exponent 136: red 10.5 20.5 / 30.5 40.5 from the lower left */
static const char picture_hdr[] = "#?RADIANCE\n\n+Y 2 +X 2\n\012\1\2\210\024\1\2\210\036\1\2"
                                  "\210\050\1\2\210";
/* one column of two: black below, 16.5 .. 64.5 over 780 .. 380 nm above */
static const char spectra_hdr[] = "#?RADIANCE\nFORMAT=Radiance_spectra\nNCOMP=4\n"
                                  "WAVELENGTH_SPLITS=780 588 480 380\n\n-Y 2 +X 1\n"
                                  "\020\040\060\100\210\0\0\0\0\0";
/* a square of half edge 2 with texture coordinates; all its normals lean to the right */
static const char square_obj[] = "v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\n"
                                 "vt 0 0\nvt 1 0\nvt 1 3\nvt 0 3\nvn .6 0 .8\n"
                                 "usemtl cover\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
static const char font_fnt[] = "65 4 0 0 127 0 127 255 0 255\n32 0\n";

static void add_file(pm_bundle *bundle, const char *name, const char *bytes, size_t size)
{
    assert_int_equal(pm_bundle_add(bundle, name, bytes, size, NULL), PM_OK);
}

static pm_status compile_with_files(const char *text, pm_world **world, pm_error *err)
{
    pm_bundle *bundle = pm_bundle_new();
    pm_scene *scene = NULL;
    add_file(bundle, "test.rad", text, strlen(text));
    add_file(bundle, "f.cal", functions, strlen(functions));
    add_file(bundle, "line.dat", line_dat, strlen(line_dat));
    add_file(bundle, "line2.dat", line2_dat, strlen(line2_dat));
    add_file(bundle, "line3.dat", line3_dat, strlen(line3_dat));
    add_file(bundle, "plane.dat", plane_dat, strlen(plane_dat));
    add_file(bundle, "spectrum.dat", spectrum_dat, strlen(spectrum_dat));
    add_file(bundle, "spectra.dat", spectra_dat, strlen(spectra_dat));
    add_file(bundle, "p.hdr", picture_hdr, sizeof picture_hdr - 1);
    add_file(bundle, "spectra.hdr", spectra_hdr, sizeof spectra_hdr - 1);
    add_file(bundle, "a.fnt", font_fnt, strlen(font_fnt));
    add_file(bundle, "square.obj", square_obj, strlen(square_obj));
    add_file(bundle, "a.txt", "A A\n A\n", 7);
    pm_status st = pm_scene_parse(bundle, "test.rad", NULL, &scene, err);
    if (!st)
        st = pm_world_compile(scene, world, err);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return st;
}

static pm_world *world_with(const char *patterns)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    struct text text = {0};
    add(&text, "%s" SQUARE, patterns);
    if (compile_with_files(text.data, &world, &err))
        fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
    free(text.data);
    return world;
}

/* What there is at (x, y) of the square for a ray along (dx, dy, dz). */
static struct pm_shading look_along(const pm_world *world, pm_hit *hit, double x, double y,
                                    pm_vec3 along)
{
    struct pm_shading shading;
    pm_vec3 direction = pm_vec3_normalize(along), at = {x, y, 0};
    double back = 2 / fabs(direction.z);
    pm_vec3 origin = pm_world_from_scene(world, pm_vec3_madd(at, -back, direction));
    const pm_ray ray = {origin, direction, INFINITY, PM_NO_PRIMITIVE};
    assert_true(pm_world_intersect(world, &ray, hit));
    pm_shading_init(&shading, world, hit, pm_vec3_negate(direction), hit->t);
    pm_textures_apply(&world->materials[hit->material], &shading);
    return shading;
}

static struct pm_shading look(const pm_world *world, double x, double y)
{
    static pm_hit hit;
    return look_along(world, &hit, x, y, (pm_vec3){0, 0, -1});
}

/* World coordinates are rounded once, and so are the intersections: 1e-9 is generous. */
static void assert_color(const struct pm_shading *s, double r, double g, double b)
{
    const double is[3] = {s->color.r, s->color.g, s->color.b}, want[3] = {r, g, b};
    for (int i = 0; i < 3; i++)
        if (!(fabs(is[i] - want[i]) <= 1e-9 * (1 + fabs(want[i]))))
            fail_msg("%.12g %.12g %.12g is not %.12g %.12g %.12g", is[0], is[1], is[2], r, g,
                     b);
}

static void assert_color_at(const pm_world *world, double x, double y, double r, double g,
                            double b)
{
    const struct pm_shading s = look(world, x, y);
    assert_color(&s, r, g, b);
}

static void assert_vec(pm_vec3 v, double x, double y, double z)
{
    if (!(pm_vec3_distance(v, (pm_vec3){x, y, z}) <= 1e-9))
        fail_msg("%.12g %.12g %.12g is not %.12g %.12g %.12g", v.x, v.y, v.z, x, y, z);
}

static void functions_multiply_brightness_and_color(void **state)
{
    (void)state;
    pm_world *world = world_with("void brightfunc q 2 linear f.cal 0 2 3 .5\n"
                                 "q colorfunc p 4 Px Py 7 . 0 0\n");
    assert_color_at(world, 2, 4, 8 * 2, 8 * 4, 8 * 7);
    assert_color_at(world, -1, 1, 2.5, -2.5, -17.5);
    pm_world_free(world);
}

/* Scaled by 2, turned by 90 degrees, then moved: the point (x, y) was at ((y - 1) / 2, -x / 2),
 * and a direction (a, b, c) was (b, -a, c). */
static void functions_see_their_own_coordinates(void **state)
{
    (void)state;
    pm_hit hit;
    pm_world *world =
        world_with("void colorfunc p 12 Px Py S f.cal -s 2 -rz 90 -t 0 1 0 0 0\n");
    assert_color_at(world, 3, 5, 2, -1.5, 0.5);
    pm_world_free(world);
    world = world_with("void brightfunc p 6 slope f.cal -s 2 -rz 90 0 0\n");
    struct pm_shading s = look_along(world, &hit, 0, 0, (pm_vec3){2, -1, -2});
    assert_color(&s, (-1. / 3 - 4. / 3 - 8. / 3) / 4, (-13. / 3) / 4, (-13. / 3) / 4);
    pm_world_free(world);
    world = world_with("void colorfunc p 6 T Rdot Nz . -s 2 0 0\n");
    s = look_along(world, &hit, 0, 0, (pm_vec3){0, 3, -4});
    assert_color(&s, 2 / 0.8 / 2, 0.8, 1);
    s = look_along(world, &hit, 0, 0, (pm_vec3){0, 3, 4});
    assert_color(&s, 2 / 0.8 / 2, -0.8, 1);
    pm_world_free(world);
}

static void a_fault_leaves_the_color_as_it_was(void **state)
{
    (void)state;
    pm_world *world = world_with("void brightfunc q 2 sqrt(Px) . 0 0\n"
                                 "q colorfunc r 4 1/(Px-1) 5 5 . 0 0\n"
                                 "r texfunc p 4 1/Py 0 0 . 0 0\n");
    assert_color_at(world, 4, 1, 2. / 3, 10, 10);
    assert_color_at(world, -1, 1, -0.5, 5, 5); /* the root's pattern is not there */
    struct pm_shading s = look(world, 4, 0);
    assert_vec(s.perturbation, 0, 0, 0);
    pm_world_free(world);
    world = world_with("void brightfunc q 2 1e300 . 0 0\nq brightfunc p 2 1e300 . 0 0\n");
    assert_color_at(world, 0, 0, 1e300, 1e300, 1e300);
    pm_world_free(world);
}

static void data_are_looked_up_at_expressions(void **state)
{
    (void)state;
    pm_world *world = world_with("void brightdata p 4 up line.dat f.cal Px 0 0\n");
    assert_color_at(world, 0.5, 0, 4.5, 4.5, 4.5);
    pm_world_free(world);
    world = world_with("void brightdata p 9 up plane.dat f.cal Px Py -t .25 0 0 0 0\n");
    assert_color_at(world, 0.75, 0.25, 3 * 5.25, 3 * 5.25, 3 * 5.25);
    pm_world_free(world);
}

/* Functions of three arguments see all three values, others their own (p_data.c). */
static void color_functions_get_three_values_or_their_own(void **state)
{
    (void)state;
    pm_world *world = world_with("void colordata p 8 mix3 square up line.dat line2.dat "
                                 "line3.dat f.cal Px 0 0\n");
    assert_color_at(world, 0.5, 0, 1.5 + 30 + 450, 9, 13.5);
    pm_world_free(world);
}

static void pictures_are_looked_up_at_u_and_v(void **state)
{
    (void)state;
    pm_world *world =
        world_with("void colorpict p 7 first second third p.hdr f.cal Px Py 0 0\n");
    assert_color_at(world, 0, 0, 10.5, 1.5, 2.5);
    assert_color_at(world, 0.5, 0.5, 25.5, 1.5, 2.5);
    pm_world_free(world);
}

/* The glyph fills the left 127 / 255 of its cell. Lines are 2 high, characters 1 wide. */
static void text_is_ink_or_paper(void **state)
{
    (void)state;
    pm_world *world = world_with("void brighttext p 2 a.fnt a.txt 0\n"
                                 "11 0 4 0 1 0 0 0 -2 0 .25 .75\n");
    assert_color_at(world, 0.4, 3, .25, .25, .25);
    assert_color_at(world, 0.6, 3, .75, .75, .75);
    assert_color_at(world, 1.4, 3, .75, .75, .75);
    assert_color_at(world, 2.4, 3, .25, .25, .25);
    assert_color_at(world, 0.4, 1, .75, .75, .75);
    assert_color_at(world, 1.4, 1, .25, .25, .25);
    assert_color_at(world, 0.4, -1, .75, .75, .75);
    pm_world_free(world);
    world = world_with("void colortext p 4 a.fnt . A A 0\n"
                       "15 0 4 0 1 0 0 0 -2 0 .1 .2 .3 .4 .5 .6\n");
    assert_color_at(world, 0.4, 3, .1, .2, .3);
    assert_color_at(world, 0.6, 3, .4, .5, .6);
    pm_world_free(world);
}

/* Down leans: two to the right for each two below. A point is measured along both motions. */
static void text_leans_with_its_vectors(void **state)
{
    (void)state;
    pm_world *world = world_with("void brighttext p 3 a.fnt . AA 0\n"
                                 "11 0 4 0 1 0 0 2 -2 0 .25 .75\n");
    assert_color_at(world, 0.4 + 1, 3, .25, .25, .25);
    assert_color_at(world, 0.6 + 1, 3, .75, .75, .75);
    assert_color_at(world, 1.4 + 1, 3, .25, .25, .25);
    assert_color_at(world, 0.4, 3, .75, .75, .75);
    pm_world_free(world);
}

static void spectra_become_colors(void **state)
{
    (void)state;
    const double rising[4] = {.2, .4, .6, .8};
    const pm_rgb c = pm_rgb_of_spectrum(rising, 4, 380, 780);
    pm_world *world = world_with("void spectrum p 0 0 6 430 730 .2 .4 .6 .8\n");
    assert_color_at(world, 0, 0, c.r, c.g, c.b);
    pm_world_free(world);
    world = world_with("void spectrum p 0 0 6 730 430 .8 .6 .4 .2\n");
    assert_color_at(world, 0, 0, c.r, c.g, c.b);
    pm_world_free(world);
    world = world_with("void specfile p 1 spectrum.dat 0 0\n");
    assert_color_at(world, 0, 0, c.r, c.g, c.b);
    pm_world_free(world);
    world = world_with("void specdata p 4 scaled spectra.dat f.cal Px 0 0\n");
    const double tilted[4] = {.1 * 430 / 500, .2 * 530 / 500, .3 * 630 / 500, .4 * 730 / 500};
    const pm_rgb t = pm_rgb_of_spectrum(tilted, 4, 380, 780);
    assert_color_at(world, .5, 0, t.r, t.g, t.b);
    pm_world_free(world);
    world = world_with("void specpict p 5 scaled spectra.hdr f.cal Px Py 0 0\n");
    const double bands[4] = {8.25 * 730 / 500, 16.25 * 630 / 500, 24.25 * 530 / 500,
                             32.25 * 430 / 500};
    const pm_rgb b = pm_rgb_of_spectrum(bands, 4, 780, 380);
    assert_color_at(world, 0, 1, b.r, b.g, b.b); /* half way up a picture that is 2 high */
    pm_world_free(world);
    /* blue and green to 560 nm; each of the 40 steps is all inside or all outside */
    world = world_with("void specfunc p 2 band f.cal 0 2 300 1000\n");
    const double one = 1;
    const pm_rgb half = pm_rgb_of_spectrum(&one, 1, 380, 560);
    assert_color_at(world, 0, 0, half.r, half.g, half.b);
    pm_world_free(world);
}

/* Turned by 90 degrees, a perturbation along x points along y; scaled or mirrored it keeps its
 * length. Two add up. */
static void textures_add_up_in_the_world(void **state)
{
    (void)state;
    pm_world *world = world_with("void texfunc p 8 .5 0 .25 . -s 3 -rz 90 0 0\n");
    struct pm_shading s = look(world, 1, 1);
    assert_vec(s.perturbation, 0, .5, .25);
    assert_vec(pm_shading_normal(&s), 0, .5 / sqrt(1.8125), 1.25 / sqrt(1.8125));
    pm_world_free(world);
    world = world_with("void texfunc q 5 .5 0 .25 . -mx 0 0\n"
                       "q texdata p 9 first second third line.dat line2.dat line3.dat f.cal Px "
                       "-mx 0 0\n");
    s = look(world, -0.5, 1); /* 0.5 before the mirror */
    assert_vec(s.perturbation, -.5 - 1.5, 3, .25 + 4.5);
    pm_world_free(world);
}

/* raynormal: a normal that leaves the side of the eye is mirrored about the plane of sight. */
static void normals_stay_on_the_side_of_sight(void **state)
{
    (void)state;
    pm_hit hit;
    pm_world *world = world_with("void texfunc p 4 3 0 0 . 0 0\n");
    struct pm_shading s = look_along(world, &hit, 0, 0, (pm_vec3){1, 0, -1});
    pm_vec3 normal = pm_shading_normal(&s), steep = pm_vec3_normalize((pm_vec3){3, 0, 1});
    double cosine = pm_vec3_dot(steep, s.wo);
    assert_true(cosine < 0);
    assert_true(fabs(pm_vec3_dot(normal, s.wo) + cosine) < 1e-12);
    assert_true(fabs(pm_vec3_length(normal) - 1) < 1e-12);
    s = look_along(world, &hit, 0, 0, (pm_vec3){-1, 0, -1});
    assert_vec(pm_shading_normal(&s), steep.x, steep.y, steep.z);
    pm_world_free(world);
    world = world_with("void texfunc p 4 0 0 -1 . 0 0\n"); /* nothing is left of the normal */
    s = look(world, 0, 0);
    assert_vec(pm_shading_normal(&s), 0, 0, 1);
    pm_world_free(world);
}

#define SIDES                                                                                  \
    "void brightfunc a 2 3 . 0 0\na texfunc fore 4 .5 0 0 . 0 0\n"                             \
    "void brightfunc back 2 7 . 0 0\n"

static void mixtures_weigh_their_sides(void **state)
{
    (void)state;
    pm_world *world = world_with(SIDES "void brightfunc q 2 2 . 0 0\n"
                                       "q mixfunc p 4 fore back Px . 0 0\n");
    struct pm_shading s = look(world, 0.25, 0);
    assert_color(&s, 2 * 6, 2 * 6, 2 * 6);
    assert_vec(s.perturbation, .125, 0, 0);
    assert_color_at(world, 5, 0, 6, 6, 6);
    assert_color_at(world, -5, 0, 14, 14, 14);
    pm_world_free(world);
    world = world_with(SIDES "void mixdata p 6 fore void up line.dat f.cal Px 0 0\n");
    assert_color_at(world, -0.75, 0, 3 * .75 + .25, 2.5, 2.5);
    pm_world_free(world);
    world = world_with(SIDES "void mixpict p 7 fore back third p.hdr f.cal Px Py 0 0\n");
    assert_color_at(world, .5, .5, 3, 3, 3);
    pm_world_free(world);
    world = world_with(SIDES "void mixtext p 5 fore back a.fnt . A 0 9 0 4 0 1 0 0 0 -2 0\n");
    assert_color_at(world, .4, 3, 3, 3, 3);
    assert_color_at(world, .6, 3, 7, 7, 7);
    pm_world_free(world);
}

static void mixtures_hold_mixtures_and_faults(void **state)
{
    (void)state;
    pm_world *world = world_with(SIDES "void mixfunc inner 4 fore back .5 . 0 0\n"
                                       "void mixfunc p 4 inner back Px . 0 0\n");
    assert_color_at(world, 0.5, 0, 6, 6, 6);
    pm_world_free(world);
    world = world_with(SIDES "void mixfunc p 4 fore back sqrt(Px) . 0 0\n");
    assert_color_at(world, -1, 0, 1, 1, 1);
    assert_color_at(world, 4, 0, 3, 3, 3);
    pm_world_free(world);
}

static void patterns_do_not_make_energy(void **state)
{
    (void)state;
    pm_world *world = world_with("void colorfunc p 4 3 .5 -1 . 0 0\n");
    const struct pm_shading s = look(world, 0, 0);
    pm_rgb r = pm_shading_reflectance(&s, (pm_rgb){.5, .25, .125});
    assert_true(r.r == 1 && r.g == .125 && r.b == 0);
    r = pm_shading_radiance(&s, (pm_rgb){10, 10, 10});
    assert_true(r.r == 30 && r.g == 5 && r.b == 0);
    pm_world_free(world);
}

/* The first material of a scene whose surface has it. */
static const struct pm_material *only_material(const pm_world *world)
{
    assert_int_equal(world->material_count, 1);
    return &world->materials[0];
}

/* A pattern multiplies what a medium lets through, or a mist's extinction. */
static void media_take_constant_patterns(void **state)
{
    (void)state;
    static const char *const pairs[][2] = {
        {"void brightfunc q 2 .5 . 0 0\nq dielectric p 0 0 5 .8 .6 .4 1.5 0\n",
         "void dielectric p 0 0 5 .4 .3 .2 1.5 0\n"},
        {"void brightfunc q 2 sqrt(4) . 0 0\nq mist p 0 0 7 .1 .2 .3 .5 .5 .5 0\n",
         "void mist p 0 0 7 .2 .4 .6 .5 .5 .5 0\n"},
        {"void brightfunc a 2 2 . 0 0\nvoid texfunc b 4 Px 0 0 . 0 0\n"
         "void mixfunc q 4 a b .25 . 0 0\nq interface p 0 0 8 .4 .4 .4 1.5 1 1 1 1\n",
         "void interface p 0 0 8 .5 .5 .5 1.5 1 1 1 1\n"},
    };
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        pm_world *world[2];
        for (int k = 0; k < 2; k++) {
            pm_error err = PM_ERROR_INIT;
            struct text text = {0};
            add(&text, "%sp sphere s 0 0 4 0 0 0 1\n", pairs[i][k]);
            if (compile_with_files(text.data, &world[k], &err))
                fail_msg("%s", err.text);
            free(text.data);
        }
        const struct pm_material *m = only_material(world[0]), *n = only_material(world[1]);
        const double is[6] = {m->extinction.r, m->extinction.g, m->extinction.b,
                              m->scattering.r, m->scattering.g, m->scattering.b};
        const double want[6] = {n->extinction.r, n->extinction.g, n->extinction.b,
                                n->scattering.r, n->scattering.g, n->scattering.b};
        for (int k = 0; k < 6; k++)
            assert_true(fabs(is[k] - want[k]) <= 1e-12 * fabs(want[k]));
        pm_world_free(world[0]);
        pm_world_free(world[1]);
    }
}

static void refuses(const char *patterns, const char *message)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    struct text text = {0};
    char said[1200];
    add(&text, "%s" SQUARE, patterns);
    pm_status st = compile_with_files(text.data, &world, &err);
    assert_true(st && st == err.status);
    pm_error_format(&err, said, sizeof said);
    assert_string_equal(said, message);
    free(text.data);
}

/* A mesh of half the size, turned by 90 degrees and moved 1 up. Its own material's functions
 * see its coordinates, a material given for all of it sees the scene's. */
static void meshes_bring_coordinates_and_normals(void **state)
{
    (void)state;
#define COVER "void texfunc t 4 0 .5 0 . 0 0\nt colorfunc p 4 Px Lu Lv . 0 0\n"
#define MESH  "square.obj -s .5 -rz 90 -t 0 1 0 0 0\n"
    static const char *const scenes[2] = {
        COVER "p plastic cover 0 0 5 .5 .5 .5 0 0\nvoid mesh s 9 " MESH,
        COVER "p plastic other 0 0 5 .5 .5 .5 0 0\nother mesh s 9 " MESH,
    };
    for (int i = 0; i < 2; i++) {
        pm_error err = PM_ERROR_INIT;
        pm_world *world = NULL;
        if (compile_with_files(scenes[i], &world, &err))
            fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
        /* (-.25, 1.5) was (1, .5) */
        struct pm_shading s = look(world, -.25, 1.5);
        assert_color(&s, i ? -.25 : 1, .75, 3 * .625);
        pm_vec3 want = i ? (pm_vec3){0, 1.1, -.2} : (pm_vec3){-.5, .6, -.2};
        assert_true(pm_vec3_distance(s.perturbation, want) < 1e-7); /* normals are floats */
        pm_world_free(world);
    }
}

static void refuses_scene(const char *scene, const char *message)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    char said[1200];
    assert_true(compile_with_files(scene, &world, &err));
    pm_error_format(&err, said, sizeof said);
    assert_string_equal(said, message);
}

static void what_cannot_be_evaluated_is_refused(void **state)
{
    (void)state;
    refuses_scene("void brightfunc q 2 Px . 0 0\nq mist p 0 0 3 .1 .1 .1\n"
                  "p sphere s 0 0 4 0 0 0 1\n",
                  "test.rad:2:3: mist 'p' has a pattern that varies; what it fills is alike "
                  "everywhere, so give it patterns without coordinates");
    refuses("void brighttext p 3 a.fnt . A 0 11 0 0 0 1 0 0 2 0 0 1 1\n",
            "test.rad:1:6: brighttext 'p' has its vectors to the right and down parallel, or "
            "too short");
    refuses("void brighttext p 3 a.fnt . A 0 12 0 0 0 1 0 0 0 1 0 1 1 1e9\n",
            "test.rad:1:6: brighttext 'p' cannot be set: spacing 1e+09 is not from -1000 to "
            "1000");
    refuses("void spectrum p 0 0 6 500 500 1 1 1 1\n",
            "test.rad:1:6: spectrum 'p' has its first wavelength equal to its last");
    refuses("void specfile p 1 plane.dat 0 0\n",
            "test.rad:1:19: 'plane.dat' has 2 dimensions; a spectrum has one, the wavelength");
    refuses("void specdata p 3 scaled line.dat f.cal 0 0\n",
            "test.rad:1:26: 'line.dat' has 1 dimension; specdata takes 2 or more, of which the "
            "last is the wavelength");
    refuses("void specpict p 5 scaled p.hdr f.cal Px Py 0 0\n",
            "test.rad:1:26: 'p.hdr' holds colours; specpict takes a picture of spectra "
            "(Radiance_spectra)");
    refuses("void colorpict p 7 up up up spectra.hdr f.cal Px Py 0 0\n",
            "test.rad:1:29: 'spectra.hdr' holds spectra; colorpict takes a picture of colours");
    refuses("void colordata p 8 up up up line.dat plane.dat line.dat f.cal Px 0 0\n",
            "test.rad:1:38: 'plane.dat' has 2 dimensions, the data file before it 1; they must "
            "have as many");
}

/* Each primitive sets its text anew, so all together are limited. */
static void texts_are_limited(void **state)
{
    (void)state;
    enum { SIZE = 1 << 20, LINE = 500 };
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    pm_scene *scene = NULL;
    struct text text = {0};
    char *long_text = malloc(SIZE);
    assert_non_null(long_text);
    for (int i = 0; i < SIZE; i++)
        long_text[i] = i % LINE ? 'A' : '\n';
    for (int i = 0; i < 5; i++)
        add(&text, "%s brighttext %s 2 a.fnt l.txt 0 11 0 0 %d 1 0 0 0 1 0 1 0\n",
            i ? "p" : "void", "p", i);
    add(&text, SQUARE);
    pm_bundle *bundle = pm_bundle_new();
    add_file(bundle, "test.rad", text.data, text.size);
    add_file(bundle, "a.fnt", font_fnt, strlen(font_fnt));
    add_file(bundle, "l.txt", long_text, SIZE);
    assert_int_equal(pm_scene_parse(bundle, "test.rad", NULL, &scene, &err), PM_OK);
    assert_int_equal(pm_world_compile(scene, &world, &err), PM_E_LIMIT);
    assert_string_equal(err.text, "brighttext 'p' brings the scene's texts to more than 4 MiB");
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    free(long_text);
    free(text.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(functions_multiply_brightness_and_color),
        cmocka_unit_test(functions_see_their_own_coordinates),
        cmocka_unit_test(a_fault_leaves_the_color_as_it_was),
        cmocka_unit_test(data_are_looked_up_at_expressions),
        cmocka_unit_test(color_functions_get_three_values_or_their_own),
        cmocka_unit_test(pictures_are_looked_up_at_u_and_v),
        cmocka_unit_test(text_is_ink_or_paper),
        cmocka_unit_test(text_leans_with_its_vectors),
        cmocka_unit_test(spectra_become_colors),
        cmocka_unit_test(textures_add_up_in_the_world),
        cmocka_unit_test(normals_stay_on_the_side_of_sight),
        cmocka_unit_test(mixtures_weigh_their_sides),
        cmocka_unit_test(mixtures_hold_mixtures_and_faults),
        cmocka_unit_test(patterns_do_not_make_energy),
        cmocka_unit_test(media_take_constant_patterns),
        cmocka_unit_test(meshes_bring_coordinates_and_normals),
        cmocka_unit_test(texts_are_limited),
        cmocka_unit_test(what_cannot_be_evaluated_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
