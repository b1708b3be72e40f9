#include "files/bsdf.h"

#include <stdlib.h>

#include "base/maths.h"
#include "base/xyz.h"
#include "files/bsdf_internal.h"

/* ---- colour ---- */

pm_rgb pm_bsdf_rgb(double x, double y, double z)
{
    pm_rgb c = pm_rgb_of_xyz(x, y, z);
    return (pm_rgb){fmax(c.r, 0), fmax(c.g, 0), fmax(c.b, 0)};
}

/* X = 9 u' Y / (4 v'), Z = (12 - 3 u' - 20 v') Y / (4 v') (CIE 1976). */
pm_rgb pm_bsdf_rgb_from_yuv(double y, double u, double v)
{
    if (!(v > 1e-6))
        return pm_rgb_grey(y);
    return pm_bsdf_rgb(9 * u / (4 * v) * y, y, (12 - 3 * u - 20 * v) / (4 * v) * y);
}

/* ---- making ---- */

static bool is_transmission(enum pm_bsdf_way way)
{
    return way >= PM_BSDF_TRANSMIT_BACK;
}

/* Brings one band into [in][out] order, at `step` floats a value. */
static void place_band(const struct pm_bsdf_text *text, const struct pm_bsdf_block *b,
                       float *value, size_t step)
{
    size_t in = b->in.patches, out = b->out.patches;
    for (size_t i = 0; i < in; i++)
        for (size_t o = 0; o < out; o++)
            value[(i * out + o) * step] =
                b->values[text->rows_are_in ? i * out + o : o * in + i];
}

static pm_status make_matrix(const struct pm_bsdf_text *text, const struct pm_bsdf_block *band,
                             enum pm_bsdf_way way, pm_bsdf *bsdf)
{
    bool colour = band[PM_BSDF_FIRST].given && band[PM_BSDF_SECOND].given;
    unsigned channels = colour ? 3 : 1;
    size_t count = band[PM_BSDF_Y].count;
    float *value = calloc(count * channels, sizeof *value);
    if (!value)
        return PM_E_MEMORY;
    if (!colour) {
        place_band(text, &band[PM_BSDF_Y], value, 1);
    } else {
        place_band(text, &band[PM_BSDF_FIRST], value, 3);
        place_band(text, &band[PM_BSDF_Y], value + 1, 3);
        place_band(text, &band[PM_BSDF_SECOND], value + 2, 3);
    }
    for (float *v = value; colour && v < value + 3 * count; v += 3) {
        pm_rgb rgb = pm_bsdf_rgb((double)v[0], (double)v[1], (double)v[2]);
        v[0] = (float)rgb.r;
        v[1] = (float)rgb.g;
        v[2] = (float)rgb.b;
    }
    return pm_klems_new(&band[PM_BSDF_Y].in, &band[PM_BSDF_Y].out, channels, value,
                        &bsdf->matrix[way], &bsdf->diffuse[way]);
}

static pm_status make_part(struct pm_bsdf_text *text, enum pm_bsdf_way way, pm_bsdf *bsdf)
{
    struct pm_bsdf_block *band = text->block[way];
    if (!band[PM_BSDF_Y].given)
        return PM_OK;
    if (!text->rank)
        return make_matrix(text, band, way, bsdf);
    bool colour = band[PM_BSDF_FIRST].given && band[PM_BSDF_SECOND].given;
    return pm_tree_new(&band[PM_BSDF_Y].nodes, colour ? &band[PM_BSDF_FIRST].nodes : NULL,
                       colour ? &band[PM_BSDF_SECOND].nodes : NULL, &bsdf->tree[way],
                       &bsdf->diffuse[way]);
}

/* ---- which data a walk uses ---- */

static enum pm_bsdf_way way_of(pm_vec3 in, bool transmitted)
{
    return (transmitted ? PM_BSDF_TRANSMIT_BACK : PM_BSDF_REFLECT_BACK) + (in.z > 0);
}

static bool has(const pm_bsdf *b, enum pm_bsdf_way way)
{
    return b->matrix[way] || b->tree[way];
}

/* Transmission that is given from one side only serves both. */
bool pm_bsdf_part_of(const pm_bsdf *b, pm_vec3 in, bool transmitted, struct pm_bsdf_part *out)
{
    enum pm_bsdf_way way = way_of(in, transmitted);
    bool reversed = transmitted && !has(b, way);
    if (reversed)
        way ^= 1;
    *out = (struct pm_bsdf_part){b->matrix[way], b->tree[way], reversed};
    return has(b, way);
}

static pm_rgb part_albedo(const struct pm_bsdf_part *p, pm_vec3 in)
{
    return p->matrix ? pm_klems_albedo(p->matrix, p->reversed, in)
                     : pm_rgb_grey(pm_tree_albedo(p->tree, p->reversed, in));
}

static pm_rgb rest_albedo(const pm_bsdf *b, pm_vec3 in, bool transmitted)
{
    struct pm_bsdf_part part;
    return pm_bsdf_part_of(b, in, transmitted, &part) ? part_albedo(&part, in) : pm_rgb_grey(0);
}

/* Everything that leaves, in its strongest channel; before scaling. */
static double total_albedo(const pm_bsdf *b, pm_vec3 in)
{
    pm_rgb sum = pm_rgb_add(b->diffuse[way_of(in, false)], b->diffuse[way_of(in, true)]);
    sum = pm_rgb_add(sum, rest_albedo(b, in, false));
    return pm_rgb_max(pm_rgb_add(sum, rest_albedo(b, in, true)));
}

double pm_bsdf_gain(const pm_bsdf *b, pm_vec3 in)
{
    double total = total_albedo(b, in);
    return total > 1 ? 1 / total : 1;
}

/* ---- finishing ---- */

bool pm_bsdf_part_direction(const struct pm_bsdf_part *p, size_t i, pm_vec3 *in)
{
    return p->matrix ? pm_klems_direction(p->matrix, p->reversed, (uint32_t)i, in)
                     : pm_tree_direction(p->tree, p->reversed, i, in);
}

/* Largest albedo over the directions that the part distinguishes; `total`: of everything. */
static double largest(const pm_bsdf *b, const struct pm_bsdf_part *p, bool front, bool total,
                      pm_vec3 *where)
{
    double most = 0;
    pm_vec3 in;
    for (size_t i = 0; pm_bsdf_part_direction(p, i, &in); i++) {
        in.z = front ? in.z : -in.z;
        double albedo = total ? total_albedo(b, in) : pm_rgb_max(part_albedo(p, in));
        if (albedo > most) {
            most = albedo;
            *where = in;
        }
    }
    return most;
}

static void drop(pm_bsdf *b, enum pm_bsdf_way way)
{
    pm_klems_free(b->matrix[way]);
    pm_tree_free(b->tree[way]);
    b->matrix[way] = NULL;
    b->tree[way] = NULL;
}

/* Radiance leaves out what scatters at most a thousandth. */
static void drop_insignificant(pm_bsdf *b)
{
    for (int way = 0; way < PM_BSDF_WAYS; way++) {
        struct pm_bsdf_part part = {b->matrix[way], b->tree[way], false};
        pm_vec3 where;
        if (has(b, way) && largest(b, &part, way & 1, false, &where) <= PM_BSDF_LEAST_REST)
            drop(b, way);
    }
}

/* Transmission from the side that the file leaves out. */
static pm_status complete(pm_bsdf *b, const struct pm_bsdf_text *text)
{
    for (int front = 0; front < 2; front++) {
        enum pm_bsdf_way way = PM_BSDF_TRANSMIT_BACK + front;
        if (!text->block[way][PM_BSDF_Y].given)
            b->diffuse[way] = b->diffuse[way ^ 1];
        if (!has(b, way) && b->tree[way ^ 1]) {
            pm_status st = pm_tree_make_reversed(b->tree[way ^ 1]);
            if (st)
                return st;
        }
    }
    return PM_OK;
}

static void describe(pm_bsdf *b, const struct pm_bsdf_text *text)
{
    b->info = (pm_bsdf_info){.width = text->size[0],
                             .height = text->size[1],
                             .thickness = text->size[2],
                             .is_tree = text->rank != 0,
                             .has_geometry = text->has_geometry};
    for (int way = 0; way < PM_BSDF_WAYS; way++) {
        pm_vec3 in = {0, 0, way & 1 ? 1 : -1};
        struct pm_bsdf_part part;
        bool rest = pm_bsdf_part_of(b, in, is_transmission(way), &part);
        bool any = rest || !pm_rgb_is_black(b->diffuse[way]);
        *(is_transmission(way) ? &b->info.transmits : &b->info.reflects) |= any;
        (is_transmission(way) ? b->info.rest_transmits : b->info.rest_reflects)[way & 1] = rest;
    }
}

static pm_status check_albedo(pm_bsdf *b, const char *name, pm_error *err)
{
    pm_vec3 at = {0, 0, 1}, worst = {0, 0, 1};
    double most = fmax(total_albedo(b, at), total_albedo(b, (pm_vec3){0, 0, -1}));
    for (int way = 0; way < PM_BSDF_WAYS; way++) {
        struct pm_bsdf_part part;
        at.z = way & 1 ? 1 : -1;
        if (!pm_bsdf_part_of(b, at, is_transmission(way), &part))
            continue;
        double here = largest(b, &part, way & 1, true, &at);
        if (here > most) {
            most = here;
            worst = at;
        }
    }
    b->info.albedo_max = most;
    if (most <= PM_BSDF_ALBEDO_MAX)
        return PM_OK;
    double theta = pm_acos(fmin(fabs(worst.z), 1)) * 180 / PM_PI;
    return pm_error_set_at(err, PM_E_RANGE, name, 1, 1,
                           "reflects and transmits %.3g times the light that comes from %.0f "
                           "degrees off the normal %s; values are per steradian, and at most "
                           "all of it can leave",
                           most, theta, worst.z > 0 ? "inside" : "outside");
}

static pm_status finish(pm_bsdf *b, const struct pm_bsdf_text *text, const char *name,
                        pm_error *err)
{
    drop_insignificant(b);
    pm_status st = complete(b, text);
    if (st)
        return st;
    describe(b, text);
    st = check_albedo(b, name, err);
    return st ? st : pm_bsdf_peaks_find(b);
}

pm_status pm_bsdf_read(const void *bytes, size_t size, const char *name, pm_bsdf **out,
                       pm_error *err)
{
    struct pm_bsdf_text text = {.rank = 0};
    pm_bsdf *b = calloc(1, sizeof *b);
    pm_status st = b ? pm_bsdf_text_read(bytes, size, name, &text, err) : PM_E_MEMORY;
    for (int way = 0; !st && way < PM_BSDF_WAYS; way++)
        st = make_part(&text, way, b);
    if (!st)
        st = finish(b, &text, name, err);
    pm_bsdf_text_clear(&text);
    if (st) {
        pm_bsdf_free(b);
        return pm_error_set(err, st, "%s: not enough memory", name);
    }
    *out = b;
    return PM_OK;
}

void pm_bsdf_free(pm_bsdf *b)
{
    if (!b)
        return;
    for (int way = 0; way < PM_BSDF_WAYS; way++)
        drop(b, way);
    pm_bsdf_peaks_clear(b);
    free(b);
}

/* ---- queries ---- */

void pm_bsdf_info_get(const pm_bsdf *b, pm_bsdf_info *out)
{
    *out = b->info;
}

pm_rgb pm_bsdf_diffuse_reflectance(const pm_bsdf *b, pm_vec3 in)
{
    return pm_rgb_scale(b->diffuse[way_of(in, false)], pm_bsdf_gain(b, in));
}

pm_rgb pm_bsdf_diffuse_transmittance(const pm_bsdf *b, pm_vec3 in)
{
    return pm_rgb_scale(b->diffuse[way_of(in, true)], pm_bsdf_gain(b, in));
}

static bool passes(pm_vec3 in, pm_vec3 out)
{
    return (in.z > 0) != (out.z > 0);
}

pm_rgb pm_bsdf_part_value(const struct pm_bsdf_part *p, pm_vec3 in, pm_vec3 out)
{
    return p->matrix ? pm_klems_value(p->matrix, p->reversed, in, out)
                     : pm_tree_value(p->tree, p->reversed, in, out);
}

pm_rgb pm_bsdf_value(const pm_bsdf *b, pm_vec3 in, pm_vec3 out)
{
    struct pm_bsdf_part part;
    if (!pm_bsdf_part_of(b, in, passes(in, out), &part))
        return pm_rgb_grey(0);
    pm_rgb f = pm_bsdf_part_value(&part, in, out);
    return pm_rgb_is_black(f) ? f : pm_rgb_scale(f, pm_bsdf_gain(b, in));
}

pm_rgb pm_bsdf_albedo(const pm_bsdf *b, pm_vec3 in, bool transmitted)
{
    return pm_rgb_scale(rest_albedo(b, in, transmitted), pm_bsdf_gain(b, in));
}

bool pm_bsdf_sample(const pm_bsdf *b, pm_vec3 in, bool transmitted, double u, double v,
                    pm_vec3 *out)
{
    struct pm_bsdf_part part;
    if (!pm_bsdf_part_of(b, in, transmitted, &part))
        return false;
    bool drawn = part.matrix ? pm_klems_sample(part.matrix, part.reversed, in, u, v, out)
                             : pm_tree_sample(part.tree, part.reversed, in, u, v, out);
    if (drawn && (in.z > 0) == transmitted)
        out->z = -out->z;
    return drawn;
}

bool pm_bsdf_cell(const struct pm_bsdf_part *p, pm_vec3 in, pm_vec3 out,
                  struct pm_bsdf_place *place)
{
    return p->matrix ? pm_klems_cell(p->matrix, p->reversed, in, out, place)
                     : pm_tree_cell(p->tree, p->reversed, in, out, place);
}

double pm_bsdf_pdf(const pm_bsdf *b, pm_vec3 in, pm_vec3 out)
{
    struct pm_bsdf_part part;
    struct pm_bsdf_place place;
    if (!pm_bsdf_part_of(b, in, passes(in, out), &part) ||
        !pm_bsdf_cell(&part, in, out, &place))
        return 0;
    return place.share / place.projected * fabs(out.z);
}
