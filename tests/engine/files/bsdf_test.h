#ifndef BSDF_TEST_H
#define BSDF_TEST_H

/* BSDF files as the tests write them, and integrals over directions. */
#include "files_test.h"

#include "../world/numbers.h"
#include "files/bsdf.h"

static const char *const klems_quarter = "LBNL/Klems Quarter";
static const char *const klems_half = "LBNL/Klems Half";
static const char *const klems_full = "LBNL/Klems Full";

static inline void begin_file(pm_bytes *b, const char *structure, const char *definitions)
{
    pm_bytes_format(b,
                    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                    "<WindowElement xmlns=\"http://windows.lbl.gov\">"
                    "<WindowElementType>System</WindowElementType><FileType>BSDF</FileType>\n"
                    "<Optical><Layer>\n<Material><Name>test</Name>"
                    "<Thickness unit=\"Millimeter\">25</Thickness>"
                    "<Width unit=\"Meter\"> 2 </Width></Material>\n"
                    "<DataDefinition><IncidentDataStructure>%s</IncidentDataStructure>\n"
                    "%s</DataDefinition>\n",
                    structure, definitions);
}

static inline void end_file(pm_bytes *b)
{
    pm_bytes_text(b, "</Layer></Optical></WindowElement>\n");
    assert_int_equal(pm_bytes_status(b), PM_OK);
}

static inline void begin_block(pm_bytes *b, const char *wavelength, const char *direction)
{
    pm_bytes_format(b,
                    "<WavelengthData><LayerNumber>System</LayerNumber>"
                    "<Wavelength unit=\"Integral\">%s</Wavelength>\n<WavelengthDataBlock>"
                    "<WavelengthDataDirection>%s</WavelengthDataDirection>\n",
                    wavelength, direction);
}

static inline void end_block(pm_bytes *b)
{
    pm_bytes_text(b, "</ScatteringData></WavelengthDataBlock></WavelengthData>\n");
}

/* Value of the i-th place of a file, by count alone. */
typedef double place_value(void *context, int i);

static inline void put_matrix(pm_bytes *b, const char *wavelength, const char *direction,
                              const char *column, const char *row, int count,
                              place_value *value, void *context)
{
    begin_block(b, wavelength, direction);
    pm_bytes_format(b,
                    "<ColumnAngleBasis>%s</ColumnAngleBasis>"
                    "<RowAngleBasis>%s</RowAngleBasis>\n<ScatteringData>\n",
                    column, row);
    for (int i = 0; i < count; i++)
        pm_bytes_format(b, "%.6g%s", value(context, i), i % 8 == 7 ? ",\n" : ", ");
    end_block(b);
}

/* A tree whose cell of n[rank] and edge is constant if `constant` says so. */
struct tree_shape {
    int rank, depth;
    double (*value)(void *context, const double *centre);
    bool (*splits)(void *context, const double *centre, double edge);
    void *context;
};

static inline void put_cell(pm_bytes *b, const struct tree_shape *s, const double *low,
                            double edge, int level)
{
    double centre[4];
    for (int d = 0; d < s->rank; d++)
        centre[d] = low[d] + edge / 2;
    pm_bytes_text(b, "{");
    if (level == s->depth || (s->splits && !s->splits(s->context, centre, edge)))
        pm_bytes_format(b, "%.6g", s->value(s->context, centre));
    else
        for (int n = 0; n < 1 << s->rank; n++) {
            double below[4];
            for (int d = 0; d < s->rank; d++)
                below[d] = low[d] + (n >> d & 1) * edge / 2;
            put_cell(b, s, below, edge / 2, level + 1);
        }
    pm_bytes_text(b, "}\n");
}

static inline void put_tree(pm_bytes *b, const char *wavelength, const char *direction,
                            const struct tree_shape *shape)
{
    const double low[4] = {0};
    begin_block(b, wavelength, direction);
    pm_bytes_text(b, "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>\n<ScatteringData>\n");
    put_cell(b, shape, low, 1, 0);
    end_block(b);
}

/* Reads and frees the text. */
static inline pm_bsdf *read_file(pm_bytes *b)
{
    pm_bsdf *bsdf = NULL;
    pm_error err = PM_ERROR_INIT;
    assert_ok(pm_bsdf_read(b->data, b->size, "test.xml", &bsdf, &err), &err);
    pm_bytes_clear(b);
    return bsdf;
}

static inline void assert_grey(pm_rgb value, double wanted, double tolerance)
{
    assert_near(value.r, wanted, tolerance);
    assert_near(value.g, wanted, tolerance);
    assert_near(value.b, wanted, tolerance);
}

/* What Radiance's bsdfquery (src/cv, December 2021) says of the same file: light comes along
 * the first direction and leaves along the second; all point away from the surface. */
struct answer {
    double from[3], to[3], value;
};

static inline void check_answers(const pm_bsdf *bsdf, const struct answer *answers,
                                 size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const double *f = answers[i].from, *t = answers[i].to;
        pm_vec3 from = pm_vec3_normalize((pm_vec3){f[0], f[1], f[2]});
        pm_vec3 to = pm_vec3_normalize((pm_vec3){t[0], t[1], t[2]});
        /* Radiance asks with the direction of sight first */
        pm_rgb part = (from.z > 0) == (to.z > 0) ? pm_bsdf_diffuse_reflectance(bsdf, to)
                                                 : pm_bsdf_diffuse_transmittance(bsdf, to);
        double value = pm_bsdf_value(bsdf, to, from).g + part.g / PM_PI;
        assert_near(value, answers[i].value, 2e-6);
    }
}

/* What is tested at a time. */
struct walk {
    const pm_bsdf *bsdf;
    const pm_bsdf_peak *peak; /* or NULL */
    pm_vec3 in;
    bool transmitted;
};

static inline double walk_side(const struct walk *w)
{
    return (w->in.z > 0) != w->transmitted ? 1 : -1;
}

static inline double walk_density(void *context, pm_vec3 out)
{
    const struct walk *w = context;
    if (walk_side(w) * out.z <= 0)
        return 0;
    return w->peak ? pm_bsdf_pdf_without(w->bsdf, w->peak, w->in, out)
                   : pm_bsdf_pdf(w->bsdf, w->in, out);
}

/* Luminance of the rest times the cosine. */
static inline double walk_scattered(void *context, pm_vec3 out)
{
    const struct walk *w = context;
    if (walk_side(w) * out.z <= 0)
        return 0;
    pm_rgb f = w->peak ? pm_bsdf_value_without(w->bsdf, w->peak, w->in, out)
                       : pm_bsdf_value(w->bsdf, w->in, out);
    return pm_rgb_luminance(f) * fabs(out.z);
}

/* Integral over the hemisphere by the midpoint rule in Shirley and Chiu's square, whose cells
 * are tensor trees' (exact for those up to 8 levels if nothing turns them). */
static inline double over_hemisphere(double (*value)(void *, pm_vec3), struct walk *w)
{
    enum { SIDE = 256 };
    double sum = 0, side = walk_side(w);
    for (int i = 0; i < SIDE * SIDE; i++) {
        pm_vec3 d = pm_warp_cosine((i / SIDE + .5) / SIDE, (i % SIDE + .5) / SIDE);
        double z = d.z;
        d.z *= side;
        sum += value(w, d) / z;
    }
    return sum * PM_PI / ((double)SIDE * SIDE);
}

/* The same in rings and sectors of projected solid angle: exact for Klems's ones, whose bounds
 * the caller gives as cosines squared, falling from 1 to 0. */
static inline double over_rings(double (*value)(void *, pm_vec3), struct walk *w,
                                const double *cosine2, int rings)
{
    enum { SECTORS_RING = 480 }; /* a multiple of twice every ring's count */
    double sum = 0, side = walk_side(w);
    for (int i = 0; i < rings * SECTORS_RING; i++) {
        int ring = i / SECTORS_RING;
        double z2 = (cosine2[ring] + cosine2[ring + 1]) / 2, z = sqrt(z2);
        pm_vec3 d = polar(z, 2 * PM_PI * (i % SECTORS_RING + .5) / SECTORS_RING);
        d.z *= side;
        sum += value(w, d) / z * (cosine2[ring] - cosine2[ring + 1]);
    }
    return sum * PM_PI / SECTORS_RING;
}

static inline void check_frequency(struct walk *w, uint64_t seed)
{
    struct histogram h = {.samples = 100000};
    pm_rng rng;
    pm_rng_init(&rng, seed, PM_RNG_PATH, 0);
    for (int k = 0; k < h.samples; k++) {
        double u[2];
        pm_vec3 out;
        draw(&rng, u, 2);
        if (!(w->peak && w->transmitted
                  ? pm_bsdf_sample_without(w->bsdf, w->peak, w->in, u[0], u[1], &out)
                  : pm_bsdf_sample(w->bsdf, w->in, w->transmitted, u[0], u[1], &out)))
            continue;
        assert_true(walk_side(w) * out.z > 0);
        assert_near(pm_vec3_length(out), 1, 1e-12);
        assert_true(walk_density(w, out) > 0);
        histogram_add(&h, out);
    }
    histogram_expect(&h, walk_density, w);
    /* its midpoint rule misses where the density jumps; that it integrates to 1 is tested apart
     */
    double wanted = 0;
    for (int b = 0; b < BINS; b++)
        wanted += h.wanted[b];
    assert_near(wanted, h.samples, .02 * h.samples);
    for (int b = 0; b < BINS; b++)
        h.wanted[b] *= h.samples / wanted;
    histogram_check(&h);
}

#endif
