/* The peak of straight passage, for aBSDF. */
#include <stdlib.h>

#include "base/bytes.h"
#include "base/maths.h"
#include "files/bsdf_internal.h"

/* The search looks along -in and at 1, 2 and 3 steps from it in eight directions of the plane,
 * at 4 in the four main ones. */
enum { PROBES = 1 + 3 * 8 + 4 };
#define PROBE_STEP 0.6 /* in widths of the smallest cell */

static void probe_offset(int i, double *x, double *y)
{
    static const signed char compass[8][2] = {{1, 0}, {0, 1},  {-1, 0},  {0, -1},
                                              {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    int ring = (i + 7) / 8;
    *x = i ? ring * compass[(i - 1) % 8][0] : 0;
    *y = i ? ring * compass[(i - 1) % 8][1] : 0;
}

struct probe {
    double total; /* luminance with the Lambertian part [1/sr] */
    pm_rgb rest;
    struct pm_bsdf_place place;
};

/* Brightest first, and of equals the one met first. Library sorts may allocate. */
static void sort(struct probe *probes, int count)
{
    for (int i = 1; i < count; i++) {
        struct probe p = probes[i];
        int at = i;
        for (; at > 0 && probes[at - 1].total < p.total; at--)
            probes[at] = probes[at - 1];
        probes[at] = p;
    }
}

static double least_cell(const struct pm_bsdf_part *part)
{
    return part->matrix ? part->matrix->least : part->tree->cell;
}

static bool met_before(const struct probe *probes, int count, const struct pm_bsdf_place *place)
{
    for (int i = 0; i < count; i++)
        if (probes[i].place.start == place->start && probes[i].place.share == place->share)
            return true;
    return false;
}

/* The cells that the search meets, each once; brightest first.
 *   diffuse  luminance of the Lambertian part [1/sr] */
static int search(const struct pm_bsdf_part *part, pm_vec3 in, double gain, double diffuse,
                  struct probe *probes)
{
    double step = PROBE_STEP * sqrt(least_cell(part)), x, y;
    int count = 0;
    for (int i = 0; i < PROBES; i++) {
        struct probe *p = &probes[count];
        probe_offset(i, &x, &y);
        pm_vec3 out = pm_vec3_normalize((pm_vec3){-in.x + x * step, -in.y + y * step, -in.z});
        if (!pm_bsdf_cell(part, in, out, &p->place) || met_before(probes, count, &p->place))
            continue;
        p->rest = pm_rgb_scale(pm_bsdf_part_value(part, in, out), gain);
        p->total = pm_rgb_luminance(p->rest) + diffuse;
        count++;
    }
    sort(probes, count);
    return count;
}

static void add_cell(pm_bsdf_peak *peak, const struct pm_bsdf_place *place)
{
    unsigned at = peak->count++;
    for (; at > 0 && peak->cells[at - 1].start > place->start; at--)
        peak->cells[at] = peak->cells[at - 1];
    peak->cells[at] = (struct pm_bsdf_cell){place->start, place->share};
    peak->share += place->share;
}

/* One way through; no symmetry yet. */
static bool search_peak(const pm_bsdf *b, const struct pm_bsdf_part *part, pm_vec3 in,
                        pm_bsdf_peak *out)
{
    struct probe probes[PROBES];
    out->transmittance = pm_rgb_grey(0);
    out->share = 0;
    out->count = 0;
    double diffuse = pm_rgb_luminance(pm_bsdf_diffuse_transmittance(b, in)) / PM_PI;
    int count = search(part, in, pm_bsdf_gain(b, in), diffuse, probes);
    double least = least_cell(part), inside = 0, around = 0, sum = 0;
    if (!count || !(probes[0].total > 1e-6))
        return false;
    for (int i = 0; i < count; i++) {
        const struct probe *p = &probes[i];
        if (p->place.projected > 1.5 * least || sum > 8 * p->total * out->count) {
            if (i == 0)
                return false;
            around += p->place.projected;
            continue;
        }
        out->transmittance = pm_rgb_madd(out->transmittance, p->place.projected, p->rest);
        inside += p->place.projected;
        sum += p->total;
        add_cell(out, &p->place);
    }
    return around > 1e-6 && (sum / out->count - diffuse) * inside >= .0005;
}

/* ---- rows ---- */

static bool rows_suffice(const struct pm_bsdf_part *part)
{
    return part->matrix || pm_tree_rows_suffice(part->tree);
}

static size_t count_rows(const struct pm_bsdf_part *part)
{
    size_t count = 0;
    pm_vec3 in;
    while (pm_bsdf_part_direction(part, count, &in))
        count++;
    return count;
}

static void fill_row(const pm_bsdf *b, const struct pm_bsdf_part *part, pm_vec3 in,
                     struct pm_bsdf_peak_row *row, pm_bytes *cells)
{
    pm_bsdf_peak peak;
    row->found = search_peak(b, part, in, &peak);
    if (!row->found)
        return;
    row->transmittance = peak.transmittance;
    row->share = peak.share;
    row->first = (uint32_t)(cells->size / sizeof *peak.cells);
    row->count = (uint16_t)peak.count;
    pm_bytes_append(cells, peak.cells, peak.count * sizeof *peak.cells);
}

/* Within a row all directions meet the same cells: that in its middle speaks for it. */
static pm_status find_rows(pm_bsdf *b, bool front)
{
    struct pm_bsdf_part part;
    pm_vec3 in = {0, 0, front ? 1 : -1};
    if (!pm_bsdf_part_of(b, in, true, &part) || !rows_suffice(&part))
        return PM_OK;
    size_t count = count_rows(&part);
    struct pm_bsdf_peak_row *rows = calloc(count, sizeof *rows);
    pm_bytes cells = {0};
    for (size_t i = 0; rows && i < count; i++) {
        (void)pm_bsdf_part_direction(&part, i, &in);
        in.z = front ? in.z : -in.z;
        fill_row(b, &part, in, &rows[i], &cells);
    }
    b->peaks[front] = (struct pm_bsdf_peaks){rows, (struct pm_bsdf_cell *)cells.data};
    return rows ? pm_bytes_status(&cells) : PM_E_MEMORY;
}

pm_status pm_bsdf_peaks_find(pm_bsdf *b)
{
    pm_status st = find_rows(b, false);
    return st ? st : find_rows(b, true);
}

void pm_bsdf_peaks_clear(pm_bsdf *b)
{
    for (int front = 0; front < 2; front++) {
        free(b->peaks[front].rows);
        free(b->peaks[front].cells);
    }
}

static int64_t row_of(const struct pm_bsdf_part *part, pm_vec3 in)
{
    return part->matrix ? pm_klems_row(part->matrix, part->reversed, in)
                        : (int64_t)pm_tree_row(part->tree, part->reversed, in);
}

/* One way through. */
static bool peak_one_way(const pm_bsdf *b, pm_vec3 in, bool *reversed, pm_bsdf_peak *out)
{
    struct pm_bsdf_part part;
    if (!pm_bsdf_part_of(b, in, true, &part))
        return false;
    *reversed = part.reversed;
    const struct pm_bsdf_peaks *peaks = &b->peaks[in.z > 0];
    if (!peaks->rows)
        return search_peak(b, &part, in, out);
    int64_t i = row_of(&part, in);
    if (i < 0 || !peaks->rows[i].found)
        return false;
    const struct pm_bsdf_peak_row *row = &peaks->rows[i];
    out->transmittance = row->transmittance;
    out->share = row->share;
    out->count = row->count;
    for (unsigned k = 0; k < row->count; k++)
        out->cells[k] = peaks->cells[row->first + k];
    return true;
}

void pm_bsdf_peak_at(const pm_bsdf *b, pm_vec3 in, pm_bsdf_peak *out)
{
    pm_bsdf_peak back;
    bool out_reversed = false, back_reversed = false;
    if (!peak_one_way(b, in, &out_reversed, out) ||
        !peak_one_way(b, pm_vec3_negate(in), &back_reversed, &back)) {
        out->transmittance = pm_rgb_grey(0);
        out->share = 0;
        out->count = 0;
        return;
    }
    pm_rgb t = out->transmittance, s = back.transmittance;
    if (out_reversed)
        out->transmittance = s;
    else if (!back_reversed)
        out->transmittance = (pm_rgb){fmin(t.r, s.r), fmin(t.g, s.g), fmin(t.b, s.b)};
}

/* ---- what is left without it ---- */

static bool in_peak(const pm_bsdf_peak *peak, const struct pm_bsdf_place *place)
{
    for (unsigned i = 0; i < peak->count; i++)
        if (peak->cells[i].start == place->start && peak->cells[i].share == place->share)
            return true;
    return false;
}

/* Place of a transmitted direction outside the peak; true for those that it cannot hold. */
static bool outside(const pm_bsdf *b, const pm_bsdf_peak *peak, pm_vec3 in, pm_vec3 out)
{
    struct pm_bsdf_part part;
    struct pm_bsdf_place place;
    if (!peak->count || (in.z > 0) == (out.z > 0))
        return true;
    return pm_bsdf_part_of(b, in, true, &part) && pm_bsdf_cell(&part, in, out, &place) &&
           !in_peak(peak, &place);
}

pm_rgb pm_bsdf_value_without(const pm_bsdf *b, const pm_bsdf_peak *peak, pm_vec3 in,
                             pm_vec3 out)
{
    return outside(b, peak, in, out) ? pm_bsdf_value(b, in, out) : pm_rgb_grey(0);
}

/* The unit interval that picks cells, with those of the peak cut out. */
bool pm_bsdf_sample_without(const pm_bsdf *b, const pm_bsdf_peak *peak, pm_vec3 in, double u,
                            double v, pm_vec3 *out)
{
    if (!(peak->share < 1))
        return false;
    u *= 1 - peak->share;
    for (unsigned i = 0; i < peak->count; i++)
        if (u >= peak->cells[i].start)
            u += peak->cells[i].share;
    return u < 1 && pm_bsdf_sample(b, in, true, u, v, out) && outside(b, peak, in, *out);
}

double pm_bsdf_pdf_without(const pm_bsdf *b, const pm_bsdf_peak *peak, pm_vec3 in, pm_vec3 out)
{
    if (!outside(b, peak, in, out))
        return 0;
    double pdf = pm_bsdf_pdf(b, in, out);
    return peak->count && (in.z > 0) != (out.z > 0)
               ? (peak->share < 1 ? pdf / (1 - peak->share) : 0)
               : pdf;
}
