#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "compile.h"
#include "numbers.h"
#include "octrees.h"
#include "world/body.h"
#include "world/light.h"
#include "world/material.h"
#include "world/media.h"
#include "world/rays.h"

/* Instances of octrees, nested ones and mirrored ones, against the same primitives transformed
 * one by one. */

#define GREY "void plastic grey 0 0 5 .5 .5 .5 0 0\n"

static pm_world *world_of_files(const char *main, const struct file *files, size_t count)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    pm_scene *scene = scene_of_files(main, files, count);
    if (pm_world_compile(scene, &world, &err))
        fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
    pm_scene_free(scene);
    return world;
}

static pm_world *world_of_one(const char *main, const char *tree)
{
    const struct file file = {"tree", tree};
    return world_of_files(main, &file, 1);
}

/* ---- hits ---- */

#define TREE                                                                                   \
    GREY "grey polygon a 0 0 9 0 0 0 1 .1 0 .2 1 .3\n"                                         \
         "grey sphere b 0 0 4 .5 .5 1 .3\n"                                                    \
         "grey cone c 0 0 8 1 1 1 1.5 1.2 2 .4 .1\n"                                           \
         "grey ring d 0 0 8 -.5 .5 .5 1 2 3 .1 .6\n"                                           \
         "grey bubble e 0 0 4 -.5 -.5 1 .3\n"                                                  \
         "grey polygon f 0 0 12 -1 -1 -.5 1 -1 -.5 1 1 -.5 -1 1 -.5\n"

/* From a point about the scene towards a point in it. */
static pm_ray random_ray(const pm_world *world, pm_rng *rng)
{
    double u[6];
    draw(rng, u, 6);
    pm_vec3 size = pm_vec3_sub(world->high, world->low), low = world->low;
    pm_vec3 from = {low.x + (2 * u[0] - .5) * size.x, low.y + (2 * u[1] - .5) * size.y,
                    low.z + (2 * u[2] - .5) * size.z};
    pm_vec3 to = {low.x + u[3] * size.x, low.y + u[4] * size.y, low.z + u[5] * size.z};
    from = pm_world_from_scene(world, from);
    to = pm_world_from_scene(world, to);
    return (pm_ray){from, pm_vec3_normalize(pm_vec3_sub(to, from)), INFINITY, PM_NO_PRIMITIVE};
}

/* The same hits but for a share of rays that pass an edge within rounding. */
static void assert_same_hits(const pm_world *a, const pm_world *b, double tolerance)
{
    enum { RAYS = 20000 };
    pm_rng rng;
    pm_rng_init(&rng, 5, PM_RNG_PATH, 0);
    int met = 0, apart = 0;
    for (int i = 0; i < RAYS; i++) {
        pm_ray ray = random_ray(a, &rng), same = ray;
        same.origin = pm_world_from_scene(b, pm_world_to_scene(a, ray.origin));
        pm_hit p, q;
        bool hit = pm_world_intersect(a, &ray, &p);
        if (hit != pm_world_intersect(b, &same, &q)) {
            apart++;
            continue;
        }
        if (!hit)
            continue;
        met++;
        pm_vec3 x = pm_world_to_scene(a, p.point), y = pm_world_to_scene(b, q.point);
        double grazing = 1 / fabs(pm_vec3_dot(p.normal, ray.direction));
        if (pm_vec3_distance(x, y) > tolerance * a->scale * grazing ||
            pm_vec3_distance(p.normal, q.normal) > tolerance * 16 * grazing)
            apart++;
        assert_true(pm_rays_any(a, &ray));
    }
    assert_in_range(met, RAYS / 20, RAYS);
    assert_in_range(apart, 0, 1);
}

/* The transform of the primitives rounds to 2^-53 of their coordinates, that of the ray to
 * 2^-53 of its own, each a few dozen times. */
static void check_transform(const char *transform)
{
    char main[512], flat[512];
    snprintf(main, sizeof main, GREY "!xform %s place.rad\n", transform);
    snprintf(flat, sizeof flat, GREY "!xform %s tree.rad\n", transform);
    const struct file files[] = {{"tree", TREE}, {"place", "void instance i 1 tree.oct 0 0\n"}};
    pm_world *a = world_of_files(main, files, 2), *b = world_of_files(flat, files, 2);
    assert_int_equal(a->shape_count, 0);
    assert_int_equal(a->main->count, 6);
    double far = pm_vec3_length(a->center) / a->scale;
    assert_same_hits(b, a, 64 * 0x1p-53 * (1 + far));
    pm_world_free(a);
    pm_world_free(b);
}

static void hits_are_those_of_transformed_primitives(void **state)
{
    (void)state;
    check_transform("-t 0 0 0");
    check_transform("-rz 90");
    check_transform("-rx 33 -ry 20 -t 3 4 5");
    check_transform("-s 3 -rz 12.5 -mx");
    check_transform("-my -ry 77 -s .01 -t 1 1 1");
    check_transform("-mz -mx -my");
}

static void scale_and_place_do_no_harm(void **state)
{
    (void)state;
    check_transform("-s 1e-6 -rx 30");
    check_transform("-s 1e6 -ry 30");
    check_transform("-rx 10 -t 1e6 -1e6 1e6");
    check_transform("-s 1e-6 -t 1 0 0");
    check_transform("-s 1e6 -t 1e6 1e6 1e6");
}

/* Together with a floor a million times as large. */
static void a_small_instance_in_a_large_scene_is_met(void **state)
{
    (void)state;
    pm_world *world =
        world_of_one(GREY "void instance i 7 tree.oct -s 1e-6 -t 1 2 3 0 0\n"
                          "grey polygon floor 0 0 12 -9 -9 -9 9 -9 -9 9 9 -9 -9 9 -9\n",
                     GREY "grey sphere b 0 0 4 0 0 0 1\n");
    pm_rng rng;
    pm_rng_init(&rng, 6, PM_RNG_PATH, 0);
    pm_vec3 center = pm_world_from_scene(world, pm_vec3_make(1, 2, 3));
    double radius = 1e-6 / world->scale;
    for (int i = 0; i < 10000; i++) {
        double u[4];
        draw(&rng, u, 4);
        pm_vec3 from = pm_warp_sphere(u[0], u[1]), at = pm_warp_sphere(u[2], u[3]);
        at = pm_vec3_madd(center, .99 * radius, at);
        pm_ray ray = {from, pm_vec3_normalize(pm_vec3_sub(at, from)), INFINITY,
                      PM_NO_PRIMITIVE};
        pm_hit hit;
        assert_true(pm_world_intersect(world, &ray, &hit));
        if (hit.surface == 0) /* the floor is before it */
            continue;
        assert_int_equal(hit.surface, 1);
        assert_near(pm_vec3_distance(hit.point, center), radius, 16 * 0x1p-53);
        assert_at_most(pm_vec3_dot(hit.normal, ray.direction), 0);
    }
    pm_world_free(world);
}

static void instances_nest(void **state)
{
    (void)state;
    const struct file files[] = {
        {"leaf",
         GREY "grey polygon a 0 0 9 0 0 0 1 .1 0 .2 1 .3\ngrey sphere b 0 0 4 1 1 1 .2\n"},
        {"twig", GREY "void instance x 5 leaf.oct -t 1 0 0 0 0\n"
                      "void instance y 4 leaf.oct -rz 40 -mx 0 0\n"
                      "grey sphere c 0 0 4 0 0 -.5 .3\n"},
        {"tree",
         "void instance x 5 twig.oct -t 2 0 1 0 0\nvoid instance y 4 twig.oct -s .5 -my "
         "0 0\nvoid instance z 3 leaf.oct -ry 20 0 0\n"}};
    struct text main = {0};
    pm_world *a = world_of_files("void instance t 5 tree.oct -rx 20 -s 3 0 0\n", files, 3);
    add(&main,
        GREY "!xform -t 1 0 0 -t 2 0 1 -rx 20 -s 3 leaf.rad\n"
             "!xform -rz 40 -mx -t 2 0 1 -rx 20 -s 3 leaf.rad\n"
             "!xform -t 1 0 0 -s .5 -my -rx 20 -s 3 leaf.rad\n"
             "!xform -rz 40 -mx -s .5 -my -rx 20 -s 3 leaf.rad\n"
             "!xform -ry 20 -rx 20 -s 3 leaf.rad\n"
             "!xform -t 2 0 1 -rx 20 -s 3 ball.rad\n!xform -s .5 -my -rx 20 -s 3 ball.rad\n");
    const struct file flat[] = {files[0], {"ball", GREY "grey sphere c 0 0 4 0 0 -.5 .3\n"}};
    pm_world *b = world_of_files(main.data, flat, 2);
    assert_int_equal(a->main->count, 12);
    assert_int_equal(b->shape_count, 12);
    pm_world_info info;
    pm_world_info_get(a, &info);
    assert_int_equal(info.surfaces, 12);
    assert_int_equal(info.diffuse_surfaces, 12);
    double far = pm_vec3_length(a->center) / a->scale;
    assert_same_hits(b, a, 128 * 0x1p-53 * (1 + far));
    pm_world_free(a);
    pm_world_free(b);
    free(main.data);
}

/* ---- walks ---- */

#define BOX                                                                                    \
    GREY "grey polygon b1 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n"                            \
         "grey polygon b2 0 0 12 -1 -1 1 1 -1 1 1 1 1 -1 1 1\n"                                \
         "grey polygon b3 0 0 12 -1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1\n"                            \
         "grey polygon b4 0 0 12 -1 1 -1 -1 1 1 1 1 1 1 1 -1\n"                                \
         "grey polygon b5 0 0 12 -1 -1 -1 -1 -1 1 -1 1 1 -1 1 -1\n"                            \
         "grey polygon b6 0 0 12 1 -1 -1 1 1 -1 1 1 1 1 -1 1\n"

enum { MOST_MET = 512 };

static int walk(const pm_world *world, const pm_ray *ray, pm_hit *met)
{
    struct pm_ray_walk walk = {.started = false};
    int count = 0;
    while (count < MOST_MET && pm_rays_next(world, ray, &walk, &met[count]))
        count++;
    return count;
}

/* Boxes in a row, some of which overlap; two lie at the same place. */
static pm_world *row_of_boxes(void)
{
    const struct file files[] = {
        {"box", BOX},
        {"pair",
         "void instance x 1 box.oct 0 0\nvoid instance y 7 box.oct -rz 30 -t 1 0 0 0 0\n"}};
    return world_of_files(GREY "!xform -a 20 -t 1.5 .1 0 -rx 1 place.rad\n"
                               "void instance p 1 box.oct 0 0\nvoid instance q 1 box.oct 0 0\n"
                               "grey sphere s 0 0 4 12 0 0 2\n",
                          (const struct file[]){files[0],
                                                files[1],
                                                {"place", "void instance x 1 pair.oct 0 0\n"}},
                          3);
}

static void a_walk_meets_every_surface_once_in_order(void **state)
{
    (void)state;
    pm_world *world = row_of_boxes();
    pm_hit met[MOST_MET];
    pm_rng rng;
    pm_rng_init(&rng, 7, PM_RNG_PATH, 0);
    assert_int_equal(world->main->count, 1 + (20 * 2 + 2) * 6);
    int most = 0;
    for (int i = 0; i < 3000; i++) {
        pm_ray ray = random_ray(world, &rng);
        int count = walk(world, &ray, met);
        assert_in_range(count, 0, MOST_MET - 1);
        for (int k = 0; k < count; k++) {
            assert_true(k == 0 || met[k].t >= met[k - 1].t);
            assert_true(met[k].surface < world->main->count);
            for (int j = 0; j < k; j++) /* a sphere twice, a polygon once */
                assert_true(met[j].surface != met[k].surface || met[k].surface == 0);
        }
        pm_hit first;
        assert_int_equal(pm_world_intersect(world, &ray, &first), count > 0);
        if (count)
            assert_int_equal(first.surface, met[0].surface);
        most = count > most ? count : most;
    }
    assert_true(most > 30);
    pm_world_free(world);
}

/* From inside a closed box, mirrored or not, there is no way out, and none from its sides. */
static void check_closed(pm_world *world, int rays)
{
    pm_rng rng;
    pm_rng_init(&rng, 8, PM_RNG_PATH, 0);
    pm_vec3 inside = pm_world_from_scene(world, pm_vec3_make(0, 0, 0));
    for (int i = 0; i < rays; i++) {
        pm_hit hit = {.point = inside, .surface = PM_NO_PRIMITIVE};
        for (int bounce = 0; bounce < 8; bounce++) {
            double u[2];
            draw(&rng, u, 2);
            pm_vec3 direction = pm_warp_sphere(u[0], u[1]);
            if (bounce && pm_vec3_dot(direction, hit.normal) > 0) /* they face outwards */
                direction = pm_vec3_negate(direction);
            pm_ray ray = {hit.point, direction, INFINITY, hit.surface};
            uint32_t before = hit.surface;
            assert_true(pm_world_intersect(world, &ray, &hit));
            assert_true(pm_rays_any(world, &ray));
            assert_true(hit.surface != before);
            assert_true(pm_vec3_dot(hit.normal, direction) > 0);
        }
    }
    pm_world_free(world);
}

static void closed_instances_leak_no_ray(void **state)
{
    (void)state;
    check_closed(world_of_one("void instance i 1 tree.oct 0 0\n", BOX), 10000);
    check_closed(world_of_one("void instance i 6 tree.oct -rx 20 -ry 33 -mx 0 0\n" GREY
                              "grey sphere far 0 0 4 99 0 0 1\n",
                              BOX),
                 10000);
    check_closed(world_of_one("void instance i 5 tree.oct -s 1e-5 -rx 21 0 0\n" GREY
                              "grey sphere far 0 0 4 9 0 0 1\n",
                              BOX),
                 10000);
}

/* Two equal instances at one place, and the same once more in the main scene: what leaves their
 * sides outwards is free. */
static void equal_instances_do_not_shade_each_other(void **state)
{
    (void)state;
    pm_world *world = world_of_one("void instance i 5 tree.oct -rx 20 -ry 33 0 0\n"
                                   "void instance j 5 tree.oct -rx 20 -ry 33 0 0\n" GREY
                                   "grey sphere far 0 0 4 9 9 9 1\n",
                                   BOX);
    pm_rng rng;
    pm_rng_init(&rng, 10, PM_RNG_PATH, 0);
    int met = 0;
    for (int i = 0; i < 20000; i++) {
        pm_ray ray = random_ray(world, &rng);
        pm_hit hit, other;
        if (!pm_world_intersect(world, &ray, &hit) || hit.surface == 0 ||
            pm_vec3_dot(hit.normal, ray.direction) > 0)
            continue;
        double u[2];
        draw(&rng, u, 2);
        pm_vec3 out = pm_warp_sphere(u[0], u[1]);
        if (pm_vec3_dot(out, hit.normal) < 0)
            out = pm_vec3_negate(out);
        pm_ray on = {hit.point, out, INFINITY, hit.surface};
        assert_true(!pm_world_intersect(world, &on, &other) || other.surface == 0);
        met++;
    }
    assert_in_range(met, 500, 20000);
    pm_world_free(world);
}

static void surfaces_of_void_are_not_there(void **state)
{
    (void)state;
    pm_world *world =
        world_of_one("void sphere s 0 0 4 0 0 0 9\nvoid instance i 1 tree.oct 0 0\n"
                     "void polygon p 0 0 9 -1 -1 .5 1 -1 .5 0 1 .5\n",
                     GREY "grey sphere s 0 0 4 0 0 0 1\n"
                          "void sphere t 0 0 4 0 0 0 2\n");
    pm_ray ray = {pm_world_from_scene(world, pm_vec3_make(0, 0, 5)),
                  {0, 0, -1},
                  INFINITY,
                  PM_NO_PRIMITIVE};
    pm_hit met[4];
    assert_int_equal(world->shape_count, 0);
    assert_int_equal(walk(world, &ray, met), 2);
    assert_near(pm_world_to_scene(world, met[0].point).z, 1, 1e-14);
    pm_world_free(world);
}

/* ---- materials ---- */

static pm_hit seen_from(const pm_world *world, pm_vec3 from, pm_vec3 direction)
{
    pm_ray ray = {pm_world_from_scene(world, from), direction, INFINITY, PM_NO_PRIMITIVE};
    pm_hit hit;
    assert_true(pm_world_intersect(world, &ray, &hit));
    return hit;
}

static double red_of(const pm_world *world, const pm_hit *hit)
{
    return world->materials[hit->material].color.r;
}

#define PAINTS "void plastic a 0 0 5 .1 0 0 0 0\nvoid plastic b 0 0 5 .2 0 0 0 0\n"

/* The outermost modifier counts; what has none is there only if one outside it has. */
static void the_outermost_modifier_replaces_all(void **state)
{
    (void)state;
    const struct file files[] = {
        {"ball", "void sphere unseen 0 0 4 0 0 0 2\nvoid plastic c 0 0 5 .3 0 0 0 0\n"
                 "c sphere s 0 0 4 0 0 0 1\n"},
        {"painted", "void plastic d 0 0 5 .4 0 0 0 0\nd instance i 1 ball.oct 0 0\n"},
        {"twice", "void instance j 1 painted.oct 0 0\n"}};
    pm_world *world = world_of_files(PAINTS "void instance i 1 ball.oct 0 0\n"
                                            "a instance j 5 ball.oct -t 10 0 0 0 0\n"
                                            "void instance k 5 twice.oct -t 20 0 0 0 0\n"
                                            "b instance l 5 twice.oct -t 30 0 0 0 0\n",
                                     files, 3);
    static const double red[] = {.3, .1, .4, .2}, height[] = {1, 2, 2, 2};
    for (int i = 0; i < 4; i++) {
        pm_hit hit = seen_from(world, pm_vec3_make(10 * i, 0, 9), pm_vec3_make(0, 0, -1));
        assert_near(red_of(world, &hit), red[i], 0);
        assert_near(pm_world_to_scene(world, hit.point).z, height[i], 1e-13);
    }
    pm_world_free(world);
}

static void instances_do_not_shine_but_are_seen(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    pm_world *world = world_of_one("void instance i 1 tree.oct 0 0\n",
                                   "void light l 0 0 3 1 2 3\nl sphere s 0 0 4 0 0 0 1\n");
    pm_world_info info;
    pm_world_info_get(world, &info);
    assert_int_equal(info.lights, 0);
    assert_int_equal(info.surfaces, 1);
    pm_hit hit = seen_from(world, pm_vec3_make(0, 0, 9), pm_vec3_make(0, 0, -1));
    pm_vec3 up = {0, 0, 1};
    assert_near(pm_light_seen_radiance(world, &hit, up).g, 2, 0);
    assert_near(pm_light_radiance(world, &hit, up).g, 0, 0);
    assert_near(pm_light_pdf_surface(world, up, pm_vec3_negate(up), &hit), 0, 0);
    pm_world_free(world);

    pm_scene *scene = scene_of_files(
        "void light l 0 0 3 1 2 3\nl instance i 1 tree.oct 0 0\n",
        (const struct file[]){{"tree", GREY "grey sphere s 0 0 4 0 0 0 1\n"}}, 1);
    assert_int_equal(pm_world_compile(scene, &world, &err), PM_E_UNSUPPORTED);
    assert_int_equal(err.line, 2);
    assert_non_null(strstr(err.text, "has a light as its modifier"));
    pm_scene_free(scene);
}

/* A sun's power is radiance, solid angle and the disc that the scene shows it. */
static void the_sun_lights_a_scene_of_instances(void **state)
{
    (void)state;
    const char *sun = "void light bright 0 0 3 1 1 1\nbright source sun 0 0 4 0 0 1 .5\n";
    struct text placed = {0}, written = {0};
    add(&placed, "%svoid instance i 1 tree.oct 0 0\n", sun);
    add(&written, "%s%s", sun, BOX);
    pm_world *a = world_of_one(placed.data, BOX), *b = world_of_one(written.data, BOX);
    pm_world_info p, q;
    pm_world_info_get(a, &p);
    pm_world_info_get(b, &q);
    assert_true(p.power.g > 0);
    assert_near(p.power.g, q.power.g, 1e-12 * q.power.g);
    pm_world_free(a);
    pm_world_free(b);
    free(placed.data);
    free(written.data);
}

#define INK "void dielectric ink 0 0 5 .5 .6 .7 1.3 0\n"

static void media_are_found_inside_instances(void **state)
{
    (void)state;
    pm_world *world = world_of_one(INK "ink sphere whole 0 0 4 0 0 0 4\n"
                                       "void instance i 4 tree.oct -mx -s 2 0 0\n",
                                   "void mist fog 0 0 7 .1 .2 .3 .5 .5 .5 0\n"
                                   "fog sphere s 0 0 4 0 0 0 1\n");
    pm_media media;
    pm_media_at(world, pm_world_from_scene(world, pm_vec3_make(.5, .1, .2)), &media);
    assert_int_equal(media.count, 2);
    assert_int_equal(world->materials[media.material[0]].type, PM_DIELECTRIC);
    assert_int_equal(world->materials[media.material[1]].type, PM_MIST);
    pm_media_at(world, pm_world_from_scene(world, pm_vec3_make(.5, 3, .2)), &media);
    assert_int_equal(media.count, 1);

    /* through 2 of ink, 4 of fog and ink, 2 of ink */
    pm_ray ray = {pm_world_from_scene(world, pm_vec3_make(0, -3.5, 0)), {0, 1, 0}, 0, 0};
    ray.t_max = 7 / world->scale;
    ray.from = PM_NO_PRIMITIVE;
    pm_media_at(world, ray.origin, &media);
    pm_rgb share = pm_world_transmittance(world, &ray, &media, false);
    assert_near(share.g, pow(.6, 7) * exp(-.2 * 4), 1e-14);
    pm_world_free(world);
}

#define CUT                                                                                    \
    "void plastic p 0 0 5 .5 .5 .5 0 0\nvoid antimatter hole 1 p 0 0\n"                        \
    "p sphere s 0 0 4 0 0 0 1\nhole sphere h 0 0 4 0 0 1 .5\n"

/* A ball with a dent, as instance, shows the dent where the plain one does. */
static void antimatter_cuts_within_instances(void **state)
{
    (void)state;
    pm_world *a = world_of_one("void instance i 1 tree.oct 0 0\n", CUT);
    pm_world *b = world_of_one(CUT "void instance none 1 tree.oct 0 0\n", GREY);
    pm_vec3 down = {0, 0, -1};
    for (int k = 0; k < 2; k++) {
        const pm_world *world = k ? b : a;
        pm_ray ray = {pm_world_from_scene(world, pm_vec3_make(.1, 0, 3)), down, INFINITY,
                      PM_NO_PRIMITIVE};
        pm_hit met[MOST_MET];
        assert_int_equal(walk(world, &ray, met), 4);
        pm_media media = {0};
        pm_media_cross(&media, world, &met[0], down);
        assert_true(pm_material_is_hidden(world, &media, met[1].material));
        assert_near(pm_world_to_scene(world, met[0].point).z, 1 + sqrt(.25 - .01), 1e-14);
    }
    pm_world_free(a);
    pm_world_free(b);
}

/* ---- functions' coordinates ---- */

static pm_vec3 moved(const pm_transform *t, double x, double y, double z)
{
    const double p[3] = {x, y, z};
    double q[3];
    for (int k = 0; k < 3; k++)
        q[k] = p[0] * t->turn[0][k] + p[1] * t->turn[1][k] + p[2] * t->turn[2][k] + t->shift[k];
    return pm_vec3_make(q[0], q[1], q[2]);
}

/* A ball about (5, 6, 7), turned to (-6, 5, 7), moved to (-5, 7, 10), twice as large and
 * mirrored at (10, 14, 20). */
static void functions_see_the_instances_coordinates(void **state)
{
    (void)state;
    const struct file files[] = {{"ball", GREY "grey sphere s 0 0 4 5 6 7 1\n"},
                                 {"twig", "void instance i 7 ball.oct -rz 90 -t 1 2 3 0 0\n"}};
    pm_world *world = world_of_files("void instance t 4 twig.oct -s 2 -mx 0 0\n" GREY
                                     "grey instance u 5 twig.oct -t 99 0 0 0 0\n"
                                     "grey sphere s 0 0 4 -50 0 0 1\n",
                                     files, 2);
    pm_transform from, to;
    pm_hit hit = seen_from(world, pm_vec3_make(10, 14, 40), pm_vec3_make(0, 0, -1));
    assert_near(pm_world_to_scene(world, hit.point).z, 22, 1e-12);
    assert_true(pm_world_instance_transform(world, hit.surface, &from, &to));
    assert_near(from.scale, 2, 1e-15);
    assert_near(to.scale, .5, 1e-15);
    assert_true(from.mirrored && to.mirrored);
    assert_near(pm_vec3_distance(moved(&from, 5, 6, 7), pm_vec3_make(10, 14, 20)), 0, 1e-13);
    assert_near(pm_vec3_distance(moved(&to, 10, 14, 20), pm_vec3_make(5, 6, 7)), 0, 1e-13);
    assert_near(pm_vec3_distance(moved(&to, 10, 14, 22), pm_vec3_make(5, 6, 8)), 0, 1e-13);
    /* a modifier of an instance is one of the scene */
    hit = seen_from(world, pm_vec3_make(94, 7, 40), pm_vec3_make(0, 0, -1));
    assert_false(pm_world_instance_transform(world, hit.surface, &from, &to));
    hit = seen_from(world, pm_vec3_make(-50, 0, 40), pm_vec3_make(0, 0, -1));
    assert_false(pm_world_instance_transform(world, hit.surface, &from, &to));
    assert_false(pm_world_instance_transform(world, PM_NO_PRIMITIVE, &from, &to));
    pm_world_free(world);
}

/* ---- identity ---- */

static void hash_of(const char *main, const struct file *files, size_t count, char *hex)
{
    pm_world *world = world_of_files(main, files, count);
    pm_digest digest = pm_world_hash(world);
    pm_digest_hex(&digest, hex);
    pm_world_free(world);
}

static void assert_hashes(bool same, const char *main_a, const char *tree_a, const char *main_b,
                          const char *name_b, const char *tree_b)
{
    char a[PM_DIGEST_HEX], b[PM_DIGEST_HEX];
    hash_of(main_a, &(struct file){"tree", tree_a}, 1, a);
    hash_of(main_b, &(struct file){name_b, tree_b}, 1, b);
    if ((strcmp(a, b) == 0) != same)
        fail_msg("%s\n%s\nand\n%s\n%s", main_a, tree_a, main_b, tree_b);
}

static void digests_cover_contents_transform_and_modifier(void **state)
{
    (void)state;
    const char *main = "void instance i 5 tree.oct -t 1 2 3 0 0\n";
    const char *tree = GREY "grey sphere s 0 0 4 0 0 0 1\ngrey sphere t 0 0 4 3 0 0 1\n";
    assert_hashes(true, main, tree, "# other names\nvoid instance j 5 x.oct -t 1 2 3 0 0\n",
                  "x",
                  "void plastic q 0 0 5 .5 .5 .5 0 0\nq sphere u 0 0 4 3 0 0 1\n"
                  "q sphere v 0 0 4 0 0 0 1\n");
    assert_hashes(false, main, tree, "void instance i 5 tree.oct -t 1 2 4 0 0\n", "tree", tree);
    assert_hashes(false, main, tree, "void instance i 7 tree.oct -rz 1 -t 1 2 3 0 0\n", "tree",
                  tree);
    assert_hashes(false, main, tree, "void instance i 6 tree.oct -mx -t 1 2 3 0 0\n", "tree",
                  tree);
    assert_hashes(false, main, tree, GREY "grey instance i 5 tree.oct -t 1 2 3 0 0\n", "tree",
                  tree);
    assert_hashes(false, main, tree, main, "tree", GREY "grey sphere s 0 0 4 0 0 0 1\n");
    assert_hashes(false, main, tree, main, "tree",
                  "void plastic grey 0 0 5 .5 .5 .6 0 0\ngrey sphere s 0 0 4 0 0 0 1\n"
                  "grey sphere t 0 0 4 3 0 0 1\n");
}

/* Whatever their order in the files. */
static void numbers_do_not_depend_on_order(void **state)
{
    (void)state;
#define PLACE(x) "void instance i" #x " 5 tree.oct -t " #x " 0 0 0 0\n"
    pm_world *a = world_of_one(PLACE(0) PLACE(3) PLACE(6) PLACE(9), TREE);
    pm_world *b = world_of_one(PLACE(6) PLACE(9) PLACE(0) PLACE(3), TREE);
    pm_rng rng;
    pm_rng_init(&rng, 9, PM_RNG_PATH, 0);
    for (int i = 0; i < 2000; i++) {
        pm_ray ray = random_ray(a, &rng);
        pm_hit p, q;
        bool hit = pm_world_intersect(a, &ray, &p);
        assert_int_equal(hit, pm_world_intersect(b, &ray, &q));
        if (!hit)
            continue;
        assert_int_equal(p.surface, q.surface);
        assert_memory_equal(&p.point, &q.point, sizeof p.point);
        const pm_digest *c = pm_world_surface_digest(a, p.surface);
        assert_true(pm_digest_equal(c, pm_world_surface_digest(b, q.surface)));
    }
    pm_world_free(a);
    pm_world_free(b);
}

/* ---- lamps ---- */

/* As in Radiance only what is not in an instance is a source. Patterns see the instance's own
 * coordinates: there the ray that looks down comes along -x. */
static void lamps_in_instances_are_seen_and_light_nothing(void **state)
{
    (void)state;
    pm_world *world =
        world_of_one(GREY "void instance i 3 tree.oct -ry -90 0 0\n"
                          "grey polygon floor 0 0 12 -2 -2 -2 2 -2 -2 2 2 -2 -2 2 -2\n",
                     "void brightfunc b 2 2-Dx . 0 0\nb light l 0 0 3 1 2 3\n"
                     "l ring r 0 0 8 0 0 0 1 0 0 0 1\n");
    const pm_vec3 up = {0, 0, 1}, down = {0, 0, -1};
    pm_ray ray = {pm_world_from_scene(world, up), down, INFINITY, PM_NO_PRIMITIVE};
    pm_hit hit;
    pm_light_sample sample;
    pm_emission emission;
    assert_true(pm_world_intersect(world, &ray, &hit));
    assert_true(hit.surface >= world->shape_count);
    assert_near(pm_light_seen_radiance(world, &hit, up).g, 6, 1e-12);
    assert_true(pm_rgb_is_black(pm_light_seen_radiance(world, &hit, down)));
    assert_true(pm_rgb_is_black(pm_light_radiance(world, &hit, up)));
    assert_near(pm_light_pdf_surface(world, up, down, &hit), 0, 0);
    assert_false(pm_light_sample_at(world, up, (double[3]){.5, .5, .5}, &sample));
    assert_false(pm_light_emit(world, (double[5]){.5, .5, .5, .5, .5}, &emission));
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_transformed_primitives),
        cmocka_unit_test(scale_and_place_do_no_harm),
        cmocka_unit_test(a_small_instance_in_a_large_scene_is_met),
        cmocka_unit_test(instances_nest),
        cmocka_unit_test(a_walk_meets_every_surface_once_in_order),
        cmocka_unit_test(closed_instances_leak_no_ray),
        cmocka_unit_test(equal_instances_do_not_shade_each_other),
        cmocka_unit_test(surfaces_of_void_are_not_there),
        cmocka_unit_test(the_outermost_modifier_replaces_all),
        cmocka_unit_test(instances_do_not_shine_but_are_seen),
        cmocka_unit_test(the_sun_lights_a_scene_of_instances),
        cmocka_unit_test(media_are_found_inside_instances),
        cmocka_unit_test(antimatter_cuts_within_instances),
        cmocka_unit_test(functions_see_the_instances_coordinates),
        cmocka_unit_test(digests_cover_contents_transform_and_modifier),
        cmocka_unit_test(numbers_do_not_depend_on_order),
        cmocka_unit_test(lamps_in_instances_are_seen_and_light_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
