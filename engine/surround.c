#include "surround.h"

#include <math.h>

#include "base/bytes.h"
#include "scene/scene.h"

/* In the bundle, beside the scene's own files. */
static const char medium_name[] = ".pm/medium.rad";

/* ---- checks ---- */

static bool is_within(pm_rgb c, double high)
{
    return c.r >= 0 && c.r <= high && c.g >= 0 && c.g <= high && c.b >= 0 && c.b <= high;
}

static bool has_medium(const pm_surroundings *s)
{
    return !pm_rgb_is_black(s->extinction);
}

pm_status pm_surroundings_check(const pm_surroundings *s, pm_error *err)
{
    if (!is_within(s->extinction, PM_EXTINCTION_MAX))
        return pm_error_set(
            err, PM_E_RANGE, "-me %g %g %g: an extinction must be 0 to %g [1 / scene unit]",
            s->extinction.r, s->extinction.g, s->extinction.b, PM_EXTINCTION_MAX);
    if (!is_within(s->albedo, 1))
        return pm_error_set(err, PM_E_RANGE, "-ma %g %g %g: an albedo must be 0 to 1",
                            s->albedo.r, s->albedo.g, s->albedo.b);
    if (!(fabs(s->eccentricity) <= PM_ECCENTRICITY_MAX))
        return pm_error_set(err, PM_E_RANGE,
                            "-mg %g: an eccentricity lies between -1 and 1, without these two",
                            s->eccentricity);
    if (!has_medium(s) && (!pm_rgb_is_black(s->albedo) || s->eccentricity != 0))
        return pm_error_set(
            err, PM_E_RANGE,
            "a medium's albedo (-ma) and eccentricity (-mg) say nothing without "
            "its extinction; give -me r g b");
    return PM_OK;
}

/* ---- the medium's cube ---- */

/* A face across axis `i`, on the low or the high side of the centre, facing outwards. */
static void write_face(pm_bytes *text, const pm_vec3 *center, double half, int i, bool high)
{
    static const int turns[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    const double middle[3] = {center->x, center->y, center->z};
    pm_bytes_format(text, "global_medium polygon side%d%d 0 0 12", i, high);
    for (int k = 0; k < 4; k++) {
        const int *turn = turns[high ? k : 3 - k];
        double p[3];
        p[i] = middle[i] + (high ? half : -half);
        p[(i + 1) % 3] = middle[(i + 1) % 3] + half * turn[0];
        p[(i + 2) % 3] = middle[(i + 2) % 3] + half * turn[1];
        pm_bytes_format(text, " %.17g %.17g %.17g", p[0], p[1], p[2]);
    }
    pm_bytes_text(text, "\n");
}

static void write_medium(const pm_surroundings *s, const pm_world_info *info, pm_bytes *text)
{
    pm_vec3 size = pm_vec3_sub(info->high, info->low);
    pm_vec3 center = pm_vec3_scale(pm_vec3_add(info->low, info->high), .5);
    double half = .505 * fmax(size.x, fmax(size.y, size.z));
    pm_bytes_format(text,
                    "void mist global_medium 0 0 7 %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n",
                    s->extinction.r, s->extinction.g, s->extinction.b, s->albedo.r, s->albedo.g,
                    s->albedo.b, s->eccentricity);
    for (int i = 0; i < 6; i++)
        write_face(text, &center, half, i / 2, i % 2);
}

static pm_status find_bounds(const pm_bundle *bundle, const char *main_name,
                             pm_world_info *info, pm_error *err)
{
    pm_scene *scene = NULL;
    pm_world *world = NULL;
    pm_status st = pm_scene_parse(bundle, main_name, NULL, &scene, err);
    if (!st)
        st = pm_world_compile(scene, &world, err);
    pm_scene_free(scene);
    if (st)
        return st;
    pm_world_info_get(world, info);
    pm_world_free(world);
    if (info->surfaces)
        return PM_OK;
    return pm_error_set(
        err, PM_E_RANGE,
        "-me: a medium fills the space between surfaces, and the scene has none");
}

static pm_status parse_with(const pm_bundle *bundle, const char *main_name,
                            const pm_bytes *medium, pm_scene **out, pm_error *err)
{
    pm_bundle *both = NULL;
    const char *const names[2] = {main_name, medium_name};
    pm_status st = pm_bytes_status(medium);
    if (st)
        return pm_error_set(err, st, "no memory for a medium");
    st = pm_bundle_extend(bundle, medium_name, medium->data, medium->size, &both, err);
    if (!st)
        st = pm_scene_parse_files(both, names, 2, NULL, out, err);
    pm_bundle_free(both);
    return st;
}

pm_status pm_surround_parse(const pm_bundle *bundle, const char *main_name,
                            const pm_surroundings *surroundings, pm_scene **out, pm_error *err)
{
    pm_world_info info;
    pm_bytes medium = {0};
    pm_status st = pm_surroundings_check(surroundings, err);
    if (st)
        return st;
    if (!has_medium(surroundings))
        return pm_scene_parse(bundle, main_name, NULL, out, err);
    st = find_bounds(bundle, main_name, &info, err);
    if (st)
        return st;
    write_medium(surroundings, &info, &medium);
    st = parse_with(bundle, main_name, &medium, out, err);
    pm_bytes_clear(&medium);
    return st;
}
