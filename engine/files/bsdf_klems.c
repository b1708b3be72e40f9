#include "files/bsdf_klems.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/maths.h"
#include "files/bsdf_internal.h"

/* ---- angle bases ---- */

/* Bounds [deg] and counts of Klems's bases as WINDOW and Radiance have them. */
static const struct known {
    const char *name;
    double theta_deg[10];
    uint32_t count[10];
} known_bases[] = {
    {"LBNL/Klems Full",
     {5, 15, 25, 35, 45, 55, 65, 75, 90},
     {1, 8, 16, 20, 24, 24, 24, 16, 12}},
    {"LBNL/Klems Half", {6.5, 19.5, 32.5, 46.5, 61.5, 76.5, 90}, {1, 8, 12, 16, 20, 12, 4}},
    {"LBNL/Klems Quarter", {9, 27, 46, 66, 90}, {1, 8, 12, 12, 8}},
};

bool pm_klems_basis_known(const char *name, struct pm_klems_basis *out)
{
    for (size_t i = 0; i < sizeof known_bases / sizeof known_bases[0]; i++) {
        const struct known *k = &known_bases[i];
        if (strcasecmp(name, k->name) != 0)
            continue;
        *out = (struct pm_klems_basis){.rings = 0};
        strcpy(out->name, k->name);
        for (int ring = 0; k->count[ring]; ring++)
            (void)pm_klems_basis_add(out, k->theta_deg[ring], k->count[ring]);
        return true;
    }
    return false;
}

bool pm_klems_basis_add(struct pm_klems_basis *b, double theta_deg, uint32_t count)
{
    if (!(theta_deg > 0 && theta_deg <= 90) || count < 1 || b->rings == PM_KLEMS_RINGS ||
        count > PM_KLEMS_PATCHES - b->patches || (count == 1 && b->rings > 0))
        return false;
    if (b->rings == 0)
        b->upper[0] = 1;
    double cosine = theta_deg < 90 ? pm_cos(theta_deg * PM_PI / 180) : 0;
    if (!(cosine < b->upper[b->rings]))
        return false;
    b->count[b->rings] = count;
    b->first[b->rings] = b->patches;
    b->patches += count;
    b->upper[++b->rings] = cosine;
    return true;
}

int32_t pm_klems_patch(const struct pm_klems_basis *b, double x, double y, double z)
{
    uint32_t ring = 0;
    z = fabs(z);
    while (ring < b->rings && z <= b->upper[ring + 1] && b->upper[ring + 1] > 0)
        ring++;
    if (ring == b->rings)
        return -1;
    double turn = pm_atan2(y, x) / (2 * PM_PI);
    double at = (turn < 0 ? turn + 1 : turn) * b->count[ring] + .5;
    uint32_t index = (uint32_t)at;
    return (int32_t)(b->first[ring] + (index < b->count[ring] ? index : 0));
}

static uint32_t ring_of(const struct pm_klems_basis *b, uint32_t patch)
{
    uint32_t ring = 0;
    while (ring + 1 < b->rings && patch >= b->first[ring + 1])
        ring++;
    return ring;
}

double pm_klems_projected(const struct pm_klems_basis *b, uint32_t patch)
{
    uint32_t ring = ring_of(b, patch);
    double outer = b->upper[ring + 1], inner = b->upper[ring];
    return PM_PI * (inner * inner - outer * outer) / b->count[ring];
}

/* Uniform in projected solid angle over the patch. */
static pm_vec3 direction_in(const struct pm_klems_basis *b, uint32_t patch, double u, double v)
{
    uint32_t ring = ring_of(b, patch);
    double inner = b->upper[ring] * b->upper[ring];
    double outer = b->upper[ring + 1] * b->upper[ring + 1], sine, cosine;
    double z2 = inner + u * (outer - inner);
    pm_sincos(2 * PM_PI * (patch - b->first[ring] + v - .5) / b->count[ring], &sine, &cosine);
    double r = sqrt(fmax(1 - z2, 0));
    return (pm_vec3){r * cosine, r * sine, sqrt(fmax(z2, 0x1p-64))};
}

/* ---- matrices ---- */

static pm_rgb entry(const struct pm_klems *m, uint32_t in, uint32_t out)
{
    const float *v = m->value + (in * (size_t)m->out.patches + out) * m->channels;
    return m->channels == 1 ? pm_rgb_grey((double)v[0])
                            : (pm_rgb){(double)v[0], (double)v[1], (double)v[2]};
}

/* The least value of each channel, which is the Lambertian part, is moved to *diffuse. */
static void take_diffuse(struct pm_klems *m, pm_rgb *diffuse)
{
    size_t count = (size_t)m->in.patches * m->out.patches;
    float least[3];
    *diffuse = pm_rgb_grey(0);
    for (unsigned c = 0; c < m->channels; c++)
        least[c] = m->value[c];
    for (size_t i = 0; i < count; i++)
        for (unsigned c = 0; c < m->channels; c++)
            least[c] = fminf(least[c], m->value[i * m->channels + c]);
    pm_rgb part = {(double)least[0], (double)least[m->channels / 2],
                   (double)least[m->channels - 1]};
    if (!(pm_rgb_luminance(part) > PM_BSDF_LEAST_DIFFUSE))
        return;
    *diffuse = pm_rgb_scale(part, PM_PI);
    for (size_t i = 0; i < count; i++)
        for (unsigned c = 0; c < m->channels; c++)
            m->value[i * m->channels + c] -= least[c];
}

/* Running sums and albedos of walks one way: rows of `from`, columns of `to`. */
static bool sum_rows(struct pm_klems *m, bool reversed)
{
    const struct pm_klems_basis *from = reversed ? &m->out : &m->in;
    const struct pm_klems_basis *to = reversed ? &m->in : &m->out;
    size_t width = (size_t)to->patches + 1;
    float *sums = calloc(from->patches * width, sizeof *sums);
    pm_rgb *albedo = calloc(from->patches, sizeof *albedo);
    m->cumulative[reversed] = sums;
    m->albedo[reversed] = albedo;
    if (!sums || !albedo)
        return false;
    for (uint32_t i = 0; i < from->patches; i++) {
        double sum = 0;
        for (uint32_t o = 0; o < to->patches; o++) {
            pm_rgb value = reversed ? entry(m, o, i) : entry(m, i, o);
            pm_rgb mass = pm_rgb_scale(value, pm_klems_projected(to, o));
            albedo[i] = pm_rgb_add(albedo[i], mass);
            sum += pm_rgb_mean(mass);
            sums[i * width + o + 1] = (float)sum;
        }
    }
    return true;
}

static double least_projected(const struct pm_klems_basis *b, double least)
{
    for (uint32_t ring = 0; ring < b->rings; ring++)
        least = fmin(least, pm_klems_projected(b, b->first[ring]));
    return least;
}

pm_status pm_klems_new(const struct pm_klems_basis *in, const struct pm_klems_basis *out,
                       unsigned channels, float *value, struct pm_klems **matrix,
                       pm_rgb *diffuse)
{
    struct pm_klems *m = calloc(1, sizeof *m);
    if (!m) {
        free(value);
        return PM_E_MEMORY;
    }
    *m = (struct pm_klems){.in = *in, .out = *out, .channels = channels, .value = value};
    m->least = least_projected(out, least_projected(in, PM_PI));
    pm_rgb part;
    take_diffuse(m, &part);
    if (!sum_rows(m, false) || !sum_rows(m, true)) {
        pm_klems_free(m);
        return PM_E_MEMORY;
    }
    *matrix = m;
    *diffuse = part;
    return PM_OK;
}

void pm_klems_free(struct pm_klems *m)
{
    if (!m)
        return;
    for (int i = 0; i < 2; i++) {
        free(m->cumulative[i]);
        free(m->albedo[i]);
    }
    free(m->value);
    free(m);
}

/* ---- queries ---- */

/* Columns are named by where light goes, rows by where it goes on: Klems's patch of a direction
 * that light comes from is that of its opposite in the plane. */
static int32_t in_patch(const struct pm_klems *m, pm_vec3 in)
{
    return pm_klems_patch(&m->in, -in.x, -in.y, in.z);
}

static int32_t out_patch(const struct pm_klems *m, pm_vec3 out)
{
    return pm_klems_patch(&m->out, out.x, out.y, out.z);
}

pm_rgb pm_klems_value(const struct pm_klems *m, bool reversed, pm_vec3 in, pm_vec3 out)
{
    int32_t i = in_patch(m, reversed ? out : in), o = out_patch(m, reversed ? in : out);
    return i < 0 || o < 0 ? pm_rgb_grey(0) : entry(m, (uint32_t)i, (uint32_t)o);
}

int32_t pm_klems_row(const struct pm_klems *m, bool reversed, pm_vec3 in)
{
    return reversed ? out_patch(m, in) : in_patch(m, in);
}

pm_rgb pm_klems_albedo(const struct pm_klems *m, bool reversed, pm_vec3 in)
{
    int32_t row = pm_klems_row(m, reversed, in);
    return row < 0 ? pm_rgb_grey(0) : m->albedo[reversed][row];
}

/* The running sums for walks from `in`; NULL if there is nothing to draw. */
static const float *sums_of(const struct pm_klems *m, bool reversed, pm_vec3 in, size_t *count)
{
    int32_t row = pm_klems_row(m, reversed, in);
    *count = reversed ? m->in.patches : m->out.patches;
    const float *sums = row < 0 ? NULL : m->cumulative[reversed] + (size_t)row * (*count + 1);
    return sums && sums[*count] > 0 ? sums : NULL;
}

bool pm_klems_cell(const struct pm_klems *m, bool reversed, pm_vec3 in, pm_vec3 out,
                   struct pm_bsdf_place *place)
{
    size_t count;
    const float *sums = sums_of(m, reversed, in, &count);
    int32_t column = reversed ? in_patch(m, out) : out_patch(m, out);
    if (!sums || column < 0)
        return false;
    double total = (double)sums[count];
    place->start = (double)sums[column] / total;
    place->share = ((double)sums[column + 1] - (double)sums[column]) / total;
    place->projected = pm_klems_projected(reversed ? &m->in : &m->out, (uint32_t)column);
    return true;
}

bool pm_klems_sample(const struct pm_klems *m, bool reversed, pm_vec3 in, double u, double v,
                     pm_vec3 *out)
{
    size_t count;
    const float *sums = sums_of(m, reversed, in, &count);
    if (!sums)
        return false;
    double rest;
    size_t column = pm_bsdf_step(sums, count, u * (double)sums[count], &rest);
    *out = direction_in(reversed ? &m->in : &m->out, (uint32_t)column, rest, v);
    if (reversed)
        *out = (pm_vec3){-out->x, -out->y, out->z};
    return true;
}

bool pm_klems_direction(const struct pm_klems *m, bool reversed, uint32_t i, pm_vec3 *in)
{
    const struct pm_klems_basis *b = reversed ? &m->out : &m->in;
    if (i >= b->patches)
        return false;
    *in = direction_in(b, i, .5, .5);
    if (!reversed)
        *in = (pm_vec3){-in->x, -in->y, in->z};
    return true;
}
