#include "world/shape.h"

#include <math.h>

#include "base/maths.h"
#include "base/warp.h"

static bool is_cone(const struct pm_shape *s)
{
    return s->type >= PM_CONE && s->type <= PM_TUBE;
}

double pm_shape_area(const struct pm_shape *shape)
{
    return shape->area;
}

/* ---- bounds ---- */

/* Half the extents of a disc of radius 1 with unit normal n. */
static pm_vec3 disc_extent(pm_vec3 n)
{
    return pm_vec3_make(sqrt(fmax(0, (1 - n.x) * (1 + n.x))),
                        sqrt(fmax(0, (1 - n.y) * (1 + n.y))),
                        sqrt(fmax(0, (1 - n.z) * (1 + n.z))));
}

static void include(pm_vec3 *low, pm_vec3 *high, pm_vec3 center, pm_vec3 extent)
{
    *low = pm_vec3_min(*low, pm_vec3_sub(center, extent));
    *high = pm_vec3_max(*high, pm_vec3_add(center, extent));
}

void pm_shape_set_bounds(struct pm_shape *s)
{
    pm_vec3 *low = &s->low, *high = &s->high;
    *low = pm_vec3_make(INFINITY, INFINITY, INFINITY);
    *high = pm_vec3_negate(*low);
    if (s->type == PM_POLYGON) {
        for (uint32_t i = 0; i < s->vertex_count; i++)
            include(low, high, s->vertices[i], pm_vec3_make(0, 0, 0));
    } else if (pm_shape_is_ball(s)) {
        include(low, high, s->center, pm_vec3_make(s->r0, s->r0, s->r0));
    } else {
        pm_vec3 extent = disc_extent(s->axis);
        pm_vec3 end = pm_vec3_madd(s->center, s->height, s->axis);
        include(low, high, s->center,
                pm_vec3_scale(extent, s->type == PM_RING ? s->r1 : s->r0));
        include(low, high, end, pm_vec3_scale(extent, s->r1));
    }
}

/* Against rounding, for cubes within [-1, 1]^3. */
#define SLACK 0x1p-48

static bool plane_meets_cube(const struct pm_shape *s, pm_vec3 center, double half)
{
    double reach = half * (fabs(s->axis.x) + fabs(s->axis.y) + fabs(s->axis.z)) + SLACK;
    return fabs(pm_vec3_dot(s->axis, center) - s->offset) <= reach + s->deviation;
}

enum { FEW_CORNERS = 8 }; /* for more corners the closer test costs more than it spares */

static bool has_corner_inside(const pm_vec3 *corner, uint32_t count, double half)
{
    for (uint32_t i = 0; i < count; i++)
        if (fabs(corner[i].x) <= half && fabs(corner[i].y) <= half && fabs(corner[i].z) <= half)
            return true;
    return false;
}

/* Whether the corners' shadows u x + v y lie all on one side of the interval [-reach, reach].
 */
static bool is_beside(const double *x, const double *y, uint32_t count, double u, double v,
                      double half)
{
    double reach = half * (fabs(u) + fabs(v)), low = INFINITY, high = -INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        double at = u * x[i] + v * y[i];
        low = at < low ? at : low;
        high = at > high ? at : high;
    }
    return low > reach || high < -reach;
}

/* Whether the polygon's shadow on an axis at right angles to one of its edges and to one of the
 * cube's is apart from the cube's (Akenine-Moeller, "Fast 3D triangle-box overlap testing", JGT
 * 6(1), 2001; for more corners than three it is as conservative as it is for their hull). */
static bool has_parting_edge(const pm_vec3 *corner, uint32_t count, double half)
{
    double x[FEW_CORNERS], y[FEW_CORNERS], z[FEW_CORNERS];
    for (uint32_t i = 0; i < count; i++) {
        x[i] = corner[i].x;
        y[i] = corner[i].y;
        z[i] = corner[i].z;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t next = i + 1 < count ? i + 1 : 0;
        double ex = x[next] - x[i], ey = y[next] - y[i], ez = z[next] - z[i];
        if (is_beside(y, z, count, -ez, ey, half) || is_beside(x, z, count, ez, -ex, half) ||
            is_beside(x, y, count, -ey, ex, half))
            return true;
    }
    return false;
}

static bool polygon_meets_cube(const struct pm_shape *s, pm_vec3 center, double half)
{
    pm_vec3 corner[FEW_CORNERS];
    if (!plane_meets_cube(s, center, half))
        return false;
    if (s->vertex_count > FEW_CORNERS)
        return true;
    for (uint32_t i = 0; i < s->vertex_count; i++)
        corner[i] = pm_vec3_sub(s->vertices[i], center);
    return has_corner_inside(corner, s->vertex_count, half) ||
           !has_parting_edge(corner, s->vertex_count, half + SLACK);
}

/* The shell lies between the cube's nearest and farthest points from its centre. */
static bool ball_meets_cube(const struct pm_shape *s, pm_vec3 center, double half)
{
    pm_vec3 d = pm_vec3_sub(center, s->center);
    d = pm_vec3_make(fabs(d.x), fabs(d.y), fabs(d.z));
    pm_vec3 near = {fmax(d.x - half, 0), fmax(d.y - half, 0), fmax(d.z - half, 0)};
    pm_vec3 far = {d.x + half, d.y + half, d.z + half};
    return pm_vec3_length(near) <= s->r0 && pm_vec3_length(far) >= s->r0;
}

/* From the axis of a cone to the point, at right angles to the axis; *along: where on the axis.
 */
static pm_vec3 from_axis(const struct pm_shape *s, pm_vec3 point, double *along)
{
    pm_vec3 v = pm_vec3_sub(point, s->center);
    *along = pm_vec3_dot(v, s->axis);
    return pm_vec3_madd(v, -*along, s->axis);
}

static double slope(const struct pm_shape *s)
{
    return (s->r1 - s->r0) / s->height;
}

/* In the half plane through the axis the cone is a stretch of a line. */
static bool cone_meets_cube(const struct pm_shape *s, pm_vec3 center, double half)
{
    double along, k = slope(s), reach = 1.7320508075688774 * half; /* sqrt 3 */
    double radius = pm_vec3_length(from_axis(s, center, &along));
    double apart = fabs(radius - s->r0 - k * along) / sqrt(1 + k * k);
    return apart <= reach + SLACK;
}

bool pm_shape_meets_cube(const struct pm_shape *s, pm_vec3 center, double half)
{
    if (s->low.x > center.x + half || s->low.y > center.y + half ||
        s->low.z > center.z + half || s->high.x < center.x - half ||
        s->high.y < center.y - half || s->high.z < center.z - half)
        return false;
    if (s->type == PM_POLYGON)
        return polygon_meets_cube(s, center, half);
    if (s->type == PM_RING)
        return plane_meets_cube(s, center, half);
    if (pm_shape_is_ball(s))
        return ball_meets_cube(s, center, half);
    return cone_meets_cube(s, center, half);
}

/* ---- points and normals ---- */

pm_vec3 pm_shape_cone_normal(const struct pm_shape *s, pm_vec3 point)
{
    double along;
    pm_vec3 radial = pm_vec3_normalize(from_axis(s, point, &along));
    pm_vec3 out = pm_vec3_normalize(pm_vec3_madd(radial, -slope(s), s->axis));
    return s->inward ? pm_vec3_negate(out) : out;
}

/* Along the radius: off by the square of the slope times rounding. */
pm_vec3 pm_shape_cone_project(const struct pm_shape *s, pm_vec3 point)
{
    double along;
    pm_vec3 radial = pm_vec3_normalize(from_axis(s, point, &along));
    pm_vec3 foot = pm_vec3_madd(s->center, along, s->axis);
    return pm_vec3_madd(foot, s->r0 + slope(s) * along, radial);
}

/* ---- sampling ---- */

/* The triangle whose share of the area holds *u, which is spread over [0, 1) again. */
static uint32_t choose_triangle(const struct pm_shape *s, double *u)
{
    uint32_t low = 0, high = s->triangle_count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (*u < s->cumulative[middle])
            high = middle;
        else
            low = middle + 1;
    }
    double start = low ? s->cumulative[low - 1] : 0;
    *u = (*u - start) / (s->cumulative[low] - start);
    return low;
}

static pm_vec3 sample_polygon(const struct pm_shape *s, double u, double v)
{
    const uint32_t *corner = s->triangles[choose_triangle(s, &u)].corner;
    pm_vec3 a = s->vertices[corner[0]];
    pm_vec3 ab = pm_vec3_sub(s->vertices[corner[1]], a);
    pm_vec3 ac = pm_vec3_sub(s->vertices[corner[2]], a);
    double root = sqrt(u);
    return pm_vec3_madd(pm_vec3_madd(a, root * (1 - v), ab), root * v, ac);
}

/* Radius with density in proportion to itself between r0 and r1, turned about the axis. For a
 * cone the place along the axis is (r - r0) / slope, written so that equal radii do no harm. */
static pm_vec3 sample_round(const struct pm_shape *s, double u, double v)
{
    pm_frame frame = pm_frame_make(s->axis);
    double r = sqrt(s->r0 * s->r0 + u * (s->r1 - s->r0) * (s->r1 + s->r0)), sine, cosine;
    double along = s->height * u * ((s->r0 + s->r1) / (s->r0 + r));
    pm_sincos(2 * PM_PI * v, &sine, &cosine);
    pm_vec3 local = {r * cosine, r * sine, s->type == PM_RING ? 0 : along};
    return pm_vec3_add(s->center, pm_frame_to_world(&frame, local));
}

void pm_shape_sample(const struct pm_shape *s, double u, double v, pm_vec3 *point,
                     pm_vec3 *normal)
{
    if (s->type == PM_POLYGON)
        *point = sample_polygon(s, u, v);
    else if (pm_shape_is_ball(s))
        *point = pm_vec3_madd(s->center, s->r0, pm_warp_sphere(u, v));
    else
        *point = sample_round(s, u, v);
    *normal = pm_shape_normal(s, *point);
}

/* ---- lines through curved shapes ---- */

/* Ascending roots, the lesser of two kept first. */
static int sorted(double a, double b, double t[2])
{
    t[0] = fmin(a, b);
    t[1] = fmax(a, b);
    return 2;
}

/* Haines, Guenther, Akenine-Moeller, "Precision improvements for ray/sphere intersection", Ray
 * Tracing Gems, ch. 7: the discriminant from the line's nearest approach to the centre, not
 * from the difference of two large squares. */
static int ball_roots(const struct pm_shape *s, pm_vec3 origin, pm_vec3 direction, bool on,
                      double t[2])
{
    pm_vec3 o = pm_vec3_sub(origin, s->center);
    double near = -pm_vec3_dot(o, direction);
    if (on)
        return sorted(0, 2 * near, t);
    double distance = pm_vec3_length(pm_vec3_madd(o, near, direction));
    double discriminant = (s->r0 - distance) * (s->r0 + distance);
    if (!(discriminant >= 0))
        return 0;
    double half = sqrt(discriminant);
    return sorted(near - half, near + half, t);
}

/* a t^2 + 2 b t + c = 0, without cancellation (Press et al., Numerical Recipes, 5.6). */
static int quadratic_roots(double a, double b, double c, double t[2])
{
    double discriminant = b * b - a * c;
    if (!(discriminant >= 0))
        return 0;
    double q = -(b + copysign(sqrt(discriminant), b));
    if (q == 0) { /* b = 0 and a c = 0 */
        t[0] = 0;
        return a != 0;
    }
    t[0] = c / q;
    return a == 0 ? 1 : sorted(q / a, c / q, t);
}

/* Where to put the line's zero so that the numbers that cancel are as small as the cone: at its
 * nearest approach to the axis, but within the sphere about the cone. False if it misses that.
 */
static bool center_line(const struct pm_shape *s, pm_vec3 origin, pm_vec3 direction,
                        double *start)
{
    pm_vec3 middle = pm_vec3_madd(s->center, s->height / 2, s->axis);
    double widest = fmax(s->r0, s->r1);
    double reach = sqrt(s->height * s->height / 4 + widest * widest) * (1 + 0x1p-40);
    pm_vec3 o = pm_vec3_sub(origin, middle);
    double near = -pm_vec3_dot(o, direction);
    if (pm_vec3_length(pm_vec3_madd(o, near, direction)) > reach)
        return false;
    double along = pm_vec3_dot(direction, s->axis);
    pm_vec3 across = pm_vec3_madd(direction, -along, s->axis);
    double square = pm_vec3_dot(across, across);
    double wanted = square > 0 ? -pm_vec3_dot(o, across) / square : near;
    *start = fmin(fmax(wanted, near - reach), near + reach);
    return true;
}

/* Roots between the ends. */
static int clip_to_ends(const struct pm_shape *s, int count, double along, double rate,
                        double t[2])
{
    int kept = 0;
    for (int i = 0; i < count; i++) {
        double z = along + t[i] * rate;
        if (z >= 0 && z <= s->height)
            t[kept++] = t[i];
    }
    return kept;
}

static int cone_roots(const struct pm_shape *s, pm_vec3 origin, pm_vec3 direction, bool on,
                      double t[2])
{
    double start = 0, z;
    if (!on && !center_line(s, origin, direction, &start))
        return 0;
    pm_vec3 o = from_axis(s, pm_vec3_madd(origin, start, direction), &z);
    double k = slope(s), dz = pm_vec3_dot(direction, s->axis), r = s->r0 + k * z;
    pm_vec3 d = pm_vec3_madd(direction, -dz, s->axis);
    double a = pm_vec3_dot(d, d) - k * k * dz * dz;
    double b = pm_vec3_dot(o, d) - k * dz * r;
    if (on) {
        /* the origin is on it: no need to ask whether it lies between the ends */
        double other = -2 * b / a, far[2] = {other, 0};
        if (!isfinite(other) || !clip_to_ends(s, 1, z, dz, far)) {
            t[0] = 0;
            return 1;
        }
        return sorted(0, other, t);
    }
    double radius = pm_vec3_length(o);
    int count = quadratic_roots(a, b, (radius - r) * (radius + r), t);
    count = clip_to_ends(s, count, z, dz, t);
    for (int i = 0; i < count; i++)
        t[i] += start;
    return count;
}

int pm_shape_roots(const struct pm_shape *s, pm_vec3 origin, pm_vec3 direction, bool on,
                   double t[2])
{
    if (is_cone(s))
        return cone_roots(s, origin, direction, on, t);
    return ball_roots(s, origin, direction, on, t);
}
