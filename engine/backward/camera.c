#include "backward/backward_internal.h"
#include "base/maths.h"

/* rpict's perspective: linear on the image plane, x along direction x up, y along up
 * (setview() in Radiance's src/common/image.c). */
void pm_camera_init(struct pm_camera *camera, const pm_world *world, const pm_view *view,
                    uint32_t width, uint32_t height)
{
    pm_vec3 forward = pm_view_unit(view->direction);
    pm_vec3 right = pm_vec3_normalize(pm_vec3_cross(forward, pm_view_unit(view->up)));
    pm_vec3 up = pm_vec3_cross(right, forward);
    double half_width = pm_tan(view->horizontal * (PM_PI / 360));
    double half_height = pm_tan(view->vertical * (PM_PI / 360));
    camera->origin = pm_world_from_scene(world, view->point);
    camera->forward = forward;
    camera->right = pm_vec3_scale(right, half_width);
    camera->up = pm_vec3_scale(up, half_height);
    camera->width = width;
    camera->height = height;
    pm_media_at(world, camera->origin, &camera->media);
}

/* u is the place in the pixel, (0, 0) at its left upper corner: box filter. */
pm_ray pm_camera_ray(const struct pm_camera *camera, uint32_t pixel, const double u[2])
{
    double x = 2 * (pixel % camera->width + u[0]) / camera->width - 1;
    double y = 1 - 2 * (pixel / camera->width + u[1]) / camera->height;
    pm_vec3 direction = pm_vec3_madd(camera->forward, x, camera->right);
    direction = pm_vec3_normalize(pm_vec3_madd(direction, y, camera->up));
    return (pm_ray){.origin = camera->origin,
                    .direction = direction,
                    .t_max = INFINITY,
                    .from = PM_NO_PRIMITIVE};
}
