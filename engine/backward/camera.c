#include "backward/backward_internal.h"
#include "base/maths.h"

void pm_camera_init(struct pm_camera *camera, const pm_world *world, const pm_view *view,
                    uint32_t width, uint32_t height)
{
    pm_world_info info;
    pm_world_info_get(world, &info);
    double scale = info.scale;
    camera->view = *view;
    camera->forward = pm_view_unit(view->direction);
    camera->right = pm_vec3_normalize(pm_vec3_cross(camera->forward, pm_view_unit(view->up)));
    camera->up = pm_vec3_cross(camera->right, camera->forward);
    camera->origin = pm_world_from_scene(world, view->point);
    camera->fore = view->fore / scale;
    camera->aft = view->aft > 0 ? view->aft / scale : INFINITY;
    camera->width = width;
    camera->height = height;
    pm_view_extent(view, &camera->half_width, &camera->half_height);
    if (view->type == PM_VIEW_PARALLEL) {
        camera->half_width /= scale;
        camera->half_height /= scale;
    }
    pm_media_at(world, camera->origin, &camera->media);
}

/* ---- directions: right, up and forward parts for a place of the picture ---- */

/* sin(a) / a, without 0 / 0. */
static double sine_ratio(double a)
{
    return a > 1e-8 ? pm_sin(a) / a : 1;
}

/* False outside of what the type shows. The length of a perspective or cylindrical direction is
 * such that the fore plane or cylinder is at 1. Source: viewray() in Radiance's
 * src/common/image.c. */
static bool direction_at(pm_view_type type, double x, double y, pm_vec3 *out)
{
    double square = x * x + y * y, angle, ratio;
    switch (type) {
    case PM_VIEW_PERSPECTIVE:
        *out = (pm_vec3){x, y, 1};
        return true;
    case PM_VIEW_PARALLEL:
        *out = (pm_vec3){0, 0, 1};
        return true;
    case PM_VIEW_HEMISPHERICAL:
        *out = (pm_vec3){x, y, sqrt(fmax(1 - square, 0))};
        return square <= 1;
    case PM_VIEW_CYLINDRICAL:
        *out = (pm_vec3){pm_sin(x), y, pm_cos(x)};
        return fabs(x) <= PM_PI;
    case PM_VIEW_ANGULAR:
        angle = sqrt(square);
        ratio = sine_ratio(angle);
        *out = (pm_vec3){x * ratio, y * ratio, pm_cos(angle)};
        return angle <= PM_PI;
    default:
        ratio = 2 / (1 + square);
        *out = (pm_vec3){x * ratio, y * ratio, (1 - square) / (1 + square)};
        return true;
    }
}

/* u is the place in the pixel, (0, 0) at its left upper corner: box filter. */
bool pm_camera_ray(const struct pm_camera *camera, uint32_t pixel, const double u[2],
                   pm_ray *out)
{
    double column = (pixel % camera->width + u[0]) / camera->width;
    double row = (pixel / camera->width + u[1]) / camera->height;
    double x = (2 * column - 1 + 2 * camera->view.shift) * camera->half_width;
    double y = (1 - 2 * row + 2 * camera->view.lift) * camera->half_height;
    pm_vec3 parts, origin = camera->origin;
    if (!direction_at(camera->view.type, x, y, &parts))
        return false;
    pm_vec3 direction = pm_vec3_scale(camera->forward, parts.z);
    direction = pm_vec3_madd(direction, parts.x, camera->right);
    direction = pm_vec3_madd(direction, parts.y, camera->up);
    if (camera->view.type == PM_VIEW_PARALLEL) {
        origin = pm_vec3_madd(origin, x, camera->right);
        origin = pm_vec3_madd(origin, y, camera->up);
    }
    if (camera->fore != 0)
        origin = pm_vec3_madd(origin, camera->fore, direction);
    double length = (camera->aft - camera->fore) * pm_vec3_length(direction);
    *out = (pm_ray){.origin = origin,
                    .direction = pm_vec3_normalize(direction),
                    .t_max = length,
                    .from = PM_NO_PRIMITIVE};
    return true;
}

pm_media pm_camera_media(const struct pm_camera *camera, const pm_world *world, pm_vec3 origin)
{
    pm_media media = camera->media;
    if (camera->view.type == PM_VIEW_PARALLEL || camera->fore != 0)
        pm_media_at(world, origin, &media);
    return media;
}
