/* A room behind a window whose scattering comes from a file: what photons bring through it is
 * what the file's values say, and what a backward walk finds. */
#include "physics.h"

#include "../engine/files/bsdf_test.h"

/* ---- files ---- */

/* Reciprocal: light scatters about the straight way, less the farther from it; the same for
 * reflection about the mirrored way. */
static double about(double dx, double dy)
{
    return .03 + .5 * exp(-4 * (dx * dx + dy * dy));
}

static pm_vec3 quarter_centre(int patch)
{
    static const double theta_deg[5] = {0, 18, 36.5, 56, 78};
    static const int counts[5] = {1, 8, 12, 12, 8};
    int ring = 0;
    while (patch >= counts[ring])
        patch -= counts[ring++];
    return polar(cos(theta_deg[ring] * PI / 180), 2 * PI * patch / counts[ring]);
}

struct glass {
    double scale, peak;
};

static double klems_value(void *context, int i)
{
    const struct glass *g = context;
    pm_vec3 a = quarter_centre(i % 41), b = quarter_centre(i / 41);
    return g->scale * about(a.x - b.x, a.y - b.y) + (i % 41 == i / 41 ? g->peak : 0);
}

static double tree_value(void *context, const double *c)
{
    const struct glass *g = context;
    pm_vec3 a = pm_warp_cosine(c[0], c[1]), b = pm_warp_cosine(c[2], c[3]);
    return g->scale * about(a.x - b.x, a.y - b.y);
}

/* Light that comes at radius r, along +x after -in, leaves about the same radius. */
static double isotropic_value(void *context, const double *c)
{
    const struct glass *g = context;
    pm_vec3 b = pm_warp_cosine(c[1], c[2]);
    return c[0] < .5 ? g->scale * about(1 - 2 * c[0] - b.x, b.y) : 0;
}

static void put_part(pm_bytes *b, const char *structure, const char *direction, double scale,
                     double peak)
{
    struct glass g = {scale, peak};
    if (strcmp(structure, "Columns") == 0) {
        put_matrix(b, "Visible", direction, klems_quarter, klems_quarter, 41 * 41, klems_value,
                   &g);
    } else {
        int rank = strcmp(structure, "TensorTree3") ? 4 : 3;
        const struct tree_shape shape = {rank, 3, rank == 3 ? isotropic_value : tree_value,
                                         NULL, &g};
        put_tree(b, "Visible", direction, &shape);
    }
}

enum { FORWARD = 1, BACKWARD = 2, PROGRESSIVE = 4 }; /* ways to look: bits */

static const struct window {
    const char *name, *material, *structure, *transmission;
    double peak;
    unsigned ways;
} windows[] = {
    {"matrix, from outside", "BSDF w 6 0 w.xml 0 1 0 . 0 0", "Columns", "Transmission Front", 0,
     FORWARD | BACKWARD | PROGRESSIVE},
    {"matrix, from inside", "BSDF w 6 0 w.xml .5 1 0 . 0 0", "Columns", "Transmission Back", 0,
     FORWARD},
    {"matrix with reals", "aBSDF w 5 w.xml 0 1 0 . 0 9 0 0 0 0 0 0 .1 .1 .1", "Columns",
     "Transmission Back", 0, FORWARD},
    {"matrix with a peak", "aBSDF w 5 w.xml 0 1 0 . 0 0", "Columns", "Transmission Front", 7,
     FORWARD | BACKWARD},
    {"tree of rank 4", "BSDF w 6 0 w.xml 1 2 0 . 0 0", "TensorTree4", "Transmission Front", 0,
     FORWARD},
    {"tree of rank 3, from outside", "BSDF w 6 0 w.xml 0 1 0 . 0 0", "TensorTree3",
     "Transmission Front", 0, FORWARD | BACKWARD},
    {"tree of rank 3, from inside", "BSDF w 6 0 w.xml 0 1 0 . 0 0", "TensorTree3",
     "Transmission Back", 0, FORWARD},
};
enum { WINDOWS = sizeof windows / sizeof windows[0] };

static void put_window(pm_bytes *b, const struct window *w)
{
    begin_file(b, w->structure, "");
    put_part(b, w->structure, w->transmission, .5, w->peak);
    put_part(b, w->structure, "Reflection Front", .2, 0);
    put_part(b, w->structure, "Reflection Back", .2, 0);
    end_file(b);
}

/* ---- the room ---- */

#define LAMP_RADIUS   .5
#define LAMP_HEIGHT   -.9
#define LAMP_RADIANCE 3.

/* The window faces up, so that the lamp is outside. */
static char *room_of(const struct window *w, double albedo)
{
    pm_bytes b = {0};
    put_window(&b, w);
    pm_bytes_u8(&b, 0);
    char *text = text_of("void plastic wall 0 0 5 %g %g %g 0 0\n" BOX(
                             "wall") "void light bright 0 0 3 %g %g %g\n"
                                     "bright ring lamp 0 0 8 0 0 %g 0 0 1 0 %g\n"
                                     "void %s\n"
                                     "w polygon pane 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n"
                                     "\n#file w.xml\n%s",
                         albedo, albedo, albedo, LAMP_RADIANCE, LAMP_RADIANCE, LAMP_RADIANCE,
                         LAMP_HEIGHT, LAMP_RADIUS, w->material, (const char *)b.data);
    pm_bytes_clear(&b);
    return text;
}

/* ---- what the file says ---- */

/* The frame of the window: x = up x z. */
struct frame {
    pm_vec3 x, y;
};

static struct frame frame_of(const struct window *w)
{
    pm_vec3 up = {0, 1, 0};
    if (strstr(w->material, ".5 1 0"))
        up.x = .5;
    if (strstr(w->material, "1 2 0"))
        up = (pm_vec3){1, 2, 0};
    pm_vec3 x = pm_vec3_normalize(pm_vec3_cross(up, (pm_vec3){0, 0, 1}));
    return (struct frame){x, pm_vec3_cross((pm_vec3){0, 0, 1}, x)};
}

static pm_vec3 local(const struct frame *f, pm_vec3 v)
{
    return (pm_vec3){pm_vec3_dot(v, f->x), pm_vec3_dot(v, f->y), v.z};
}

static pm_vec3 lamp_point(double u, double v)
{
    pm_vec3 p = pm_warp_disc(u, v);
    return (pm_vec3){p.x * LAMP_RADIUS, p.y * LAMP_RADIUS, LAMP_HEIGHT};
}

#define LAMP_AREA (PI * LAMP_RADIUS * LAMP_RADIUS)

/* Cosines at both ends over the squared distance; both planes are horizontal. */
static double exchange(pm_vec3 a, pm_vec3 b)
{
    pm_vec3 d = pm_vec3_sub(a, b);
    return d.z * d.z / (pm_vec3_dot(d, d) * pm_vec3_dot(d, d));
}

/* One draw of the irradiance at a sensor on the ceiling: straight from a point of the lamp, and
 * scattered at a point of the window. */
static double draw_light(const pm_bsdf *bsdf, const struct window *w, const struct frame *f,
                         pm_vec3 sensor, const double *u)
{
    bool peaked = w->material[0] == 'a';
    double real = strstr(w->material, ".1 .1 .1") ? .1 : 0;
    pm_vec3 lamp = lamp_point(u[0], u[1]), pane = {2 * u[2] - 1, 2 * u[3] - 1, 0};
    pm_vec3 in = local(f, pm_vec3_normalize(pm_vec3_sub(sensor, pane)));
    pm_vec3 out = local(f, pm_vec3_normalize(pm_vec3_sub(lamp, pane)));
    pm_vec3 straight = local(f, pm_vec3_normalize(pm_vec3_sub(sensor, lamp)));
    pm_bsdf_peak at_pane = {.count = 0}, at_line = {.count = 0};
    if (peaked) {
        pm_bsdf_peak_at(bsdf, in, &at_pane);
        pm_bsdf_peak_at(bsdf, straight, &at_line);
    }
    double scattering = pm_bsdf_value_without(bsdf, &at_pane, in, out).g +
                        (pm_bsdf_diffuse_transmittance(bsdf, in).g + real) / PI;
    return LAMP_RADIANCE * LAMP_AREA *
           (4 * scattering * exchange(sensor, pane) * exchange(pane, lamp) +
            at_line.transmittance.g * exchange(sensor, lamp));
}

/* Sensors all over the ceiling but its rim; their mean is compared. */
enum { ROW = 6, SENSORS = ROW * ROW };

static pm_sensor sensor_of(int i)
{
    return (pm_sensor){{(i % ROW - 2.5) * .3, (i / ROW - 2.5) * .3, 1}, {0, 0, -1}};
}

static struct stat light_of(const struct window *w)
{
    enum { DRAWS = 400000 };
    pm_bytes b = {0};
    put_window(&b, w);
    pm_bsdf *bsdf = read_file(&b);
    struct frame f = frame_of(w);
    struct stat stat = {0};
    pm_rng rng;
    pm_rng_init(&rng, 11, PM_RNG_PATH, 0);
    for (int i = 0; i < DRAWS; i++) {
        double u[4];
        draw(&rng, u, 4);
        stat_add(&stat, draw_light(bsdf, w, &f, sensor_of(i % SENSORS).point, u));
    }
    pm_bsdf_free(bsdf);
    return stat;
}

/* ---- claims ---- */

/* Photons through the window alone; gather rays that go on through it; progressive passes. */
static const struct mode *mode_of(unsigned way)
{
    return &modes[way == FORWARD ? MODES - 1 : way == BACKWARD ? 4 : 0];
}

enum { PHOTONS = 5000 };

static struct stat run_mode(const struct mode *mode, const char *text)
{
    pm_job job = job_of_mode(mode, PHOTONS, 10);
    job.wanted.maps[PM_MAP_CAUSTIC].count = mode->caustic ? PHOTONS : 0;
    pm_sensor sensors[SENSORS];
    for (int i = 0; i < SENSORS; i++)
        sensors[i] = sensor_of(i);
    look_at(&job, sensors, SENSORS, PM_IRRADIANCE);
    job.passes = mode->progressive ? 1 : 16;
    return run_mean(&job, text, SEEDS, GREY);
}

static void expect_light(const struct window *w, unsigned way, const char *text,
                         const struct stat *want, double slack)
{
    const struct mode *mode = mode_of(way);
    struct stat got = run_mode(mode, text);
    char what[120];
    snprintf(what, sizeof what, "%s, %s", w->name, mode->name);
    expect_equal_means(what, &got, want->mean, stat_error(want), slack * want->mean);
}

/* Walls reflect a thousandth: what they add is less than .003 of the light. A look-up holds 10
 * of some 5,000 photons of 12 units of area or more: r = .09, over which this light's
 * curvature, at most 2 / m^2, gives r^2 / 4 * 2 = .004 of it. */
static void photons_bring_what_the_file_says(void **state)
{
    (void)state;
    for (int i = 0; i < WINDOWS; i++) {
        struct stat want = light_of(&windows[i]);
        char *text = room_of(&windows[i], .001);
        for (unsigned way = FORWARD; way <= PROGRESSIVE; way *= 2)
            if (windows[i].ways & way)
                expect_light(&windows[i], way, text, &want, .007);
        free(text);
    }
}

/* With walls that reflect, all modes still agree: each path is counted once. Where a disc of
 * photons reaches over an edge, those modes that gather lose 48 sqrt(2) r / 24 * 2 / (3 pi) of
 * what was reflected more than once (see test_partition.c). */
static void every_mode_gives_the_same_light(void **state)
{
    (void)state;
    static const int some[] = {3, 5};
    for (size_t i = 0; i < sizeof some / sizeof some[0]; i++) {
        const struct window *w = &windows[some[i]];
        char *text = room_of(w, .5);
        struct stat want = run_mode(mode_of(FORWARD), text);
        expect_light(w, BACKWARD, text, &want, 48 * sqrt(2) * .09 / 24 * 2 / (3 * PI));
        expect_light(w, PROGRESSIVE, text, &want, .007);
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(photons_bring_what_the_file_says),
        cmocka_unit_test(every_mode_gives_the_same_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
