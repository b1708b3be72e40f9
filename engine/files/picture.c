#include "files/picture.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/xyz.h"
#include "files/data.h"

/* Rows of length outside these bounds are never run-length encoded the new way (MINELEN,
 * MAXELEN in Radiance's src/common/color.c). */
enum { RUN_WIDTH_MIN = 8, RUN_WIDTH_MAX = 0x7FFF };
enum { PIXELS_MAX = 1 << 27 };
enum { LINE_MAX_BYTES = 2048 };

struct pm_picture {
    uint32_t width, height;
    bool xyz;
    unsigned bands;  /* 0: three colours */
    double nm0, nm1; /* outer edges of the bands */
    pm_data_axis u, v;
    size_t stride;   /* of a pixel: a mantissa for each colour or band, and the exponent */
    uint8_t *pixels; /* rows from the bottom */
};

struct reading {
    const uint8_t *at, *end;
    const char *name;
    pm_error *err;
    bool xyz, spectral;
    int64_t bands;
    double nm0, nm1;
    double aspect;                 /* of a pixel: height over width */
    bool rows;                     /* scan lines run along x */
    bool x_decreases, y_decreases; /* along the file */
    uint32_t width, height;
};

static pm_status bad(const struct reading *r, pm_status status, const char *what)
{
    return pm_error_set_at(r->err, status, r->name, 0, 0, "%s", what);
}

/* ---- header ---- */

/* The next line without its end; false if there is none. */
static bool next_line(struct reading *r, const char **line, size_t *length)
{
    const uint8_t *end = memchr(r->at, '\n', (size_t)(r->end - r->at));
    if (!end || end - r->at > LINE_MAX_BYTES)
        return false;
    *line = (const char *)r->at;
    *length = (size_t)(end - r->at);
    if (*length && (*line)[*length - 1] == '\r')
        --*length;
    r->at = end + 1;
    return true;
}

static bool starts_with(const char *line, size_t length, const char *start)
{
    return length >= strlen(start) && memcmp(line, start, strlen(start)) == 0;
}

static bool is_text(const char *text, size_t length, const char *expected)
{
    return length == strlen(expected) && memcmp(text, expected, length) == 0;
}

static void trim(const char **text, size_t *length)
{
    while (*length && (**text == ' ' || **text == '\t'))
        ++*text, --*length;
    while (*length && ((*text)[*length - 1] == ' ' || (*text)[*length - 1] == '\t'))
        --*length;
}

static pm_status read_format(struct reading *r, const char *text, size_t length)
{
    trim(&text, &length);
    r->xyz = is_text(text, length, "32-bit_rle_xyze");
    r->spectral = is_text(text, length, "Radiance_spectra");
    if (r->xyz || r->spectral || is_text(text, length, "32-bit_rle_rgbe"))
        return PM_OK;
    return pm_error_set_at(r->err, PM_E_UNSUPPORTED, r->name, 0, 0,
                           "the picture's format is '%.*s'; 32-bit_rle_rgbe, 32-bit_rle_xyze "
                           "and Radiance_spectra are read",
                           (int)(length < 40 ? length : 40), text);
}

static pm_status read_aspect(struct reading *r, const char *text, size_t length)
{
    double value = 0;
    trim(&text, &length);
    if (pm_number_real(text, length, &value) || !(value > 1e-6) || !(value < 1e6))
        return bad(r, PM_E_RANGE, "PIXASPECT must be a number from 1e-6 to 1e6");
    r->aspect *= value;
    return PM_OK;
}

static pm_status read_bands(struct reading *r, const char *text, size_t length)
{
    trim(&text, &length);
    if (pm_number_integer(text, length, &r->bands) || r->bands < 3 ||
        r->bands > PM_PICTURE_BANDS)
        return bad(r, PM_E_RANGE, "NCOMP must be a number from 3 to 24");
    return PM_OK;
}

/* Four wavelengths, of which the first and the last bound the bands. */
static pm_status read_splits(struct reading *r, const char *text, size_t length)
{
    double nm[4] = {0};
    bool right = true;
    for (int i = 0; i < 4 && right; i++) {
        trim(&text, &length);
        size_t word = 0;
        while (word < length && text[word] != ' ' && text[word] != '\t')
            word++;
        right = !pm_number_real(text, word, &nm[i]) && nm[i] >= 1 && nm[i] <= 1e6;
        text += word;
        length -= word;
    }
    if (!right || nm[0] == nm[3])
        return bad(r, PM_E_RANGE, "WAVELENGTH_SPLITS must be four wavelengths in nanometres");
    r->nm0 = nm[0];
    r->nm1 = nm[3];
    return PM_OK;
}

static pm_status check_bands(const struct reading *r)
{
    if (r->spectral && (r->bands < 4 || !(r->nm0 > 0)))
        return bad(r, PM_E_SYNTAX,
                   "a spectral picture must say NCOMP, 4 to 24, and WAVELENGTH_SPLITS");
    if (!(r->aspect > 1e-6 && r->aspect < 1e6))
        return bad(r, PM_E_RANGE, "PIXASPECT lines together must be from 1e-6 to 1e6");
    return PM_OK;
}

static pm_status read_header_line(struct reading *r, const char *line, size_t length)
{
    static const struct {
        const char *start;
        pm_status (*read)(struct reading *r, const char *text, size_t length);
    } known[] = {{"FORMAT=", read_format},
                 {"PIXASPECT=", read_aspect},
                 {"NCOMP=", read_bands},
                 {"WAVELENGTH_SPLITS=", read_splits}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        size_t start = strlen(known[i].start);
        if (starts_with(line, length, known[i].start))
            return known[i].read(r, line + start, length - start);
    }
    return PM_OK;
}

static pm_status read_header(struct reading *r)
{
    const char *line;
    size_t length;
    if (!next_line(r, &line, &length) || !starts_with(line, length, "#?"))
        return bad(r, PM_E_SYNTAX, "no Radiance picture: it does not start with '#?'");
    pm_status st = PM_OK;
    while (!st) {
        if (!next_line(r, &line, &length))
            return bad(r, PM_E_CORRUPT, "the picture's header has no end");
        if (!length)
            break;
        st = read_header_line(r, line, length);
    }
    return st ? st : check_bands(r);
}

/* "-Y 480 +X 640": sign, axis, count, twice; the first axis changes slowest. */
static bool read_extent(const char **at, const char *end, bool *negative, char *axis,
                        uint32_t *count)
{
    const char *p = *at;
    if (end - p < 4 || (p[0] != '-' && p[0] != '+') || (p[1] != 'X' && p[1] != 'Y') ||
        p[2] != ' ')
        return false;
    *negative = p[0] == '-';
    *axis = p[1];
    for (p += 3; p < end && *p == ' '; p++)
        continue;
    const char *word = p;
    while (p < end && *p != ' ')
        p++;
    int64_t value;
    if (pm_number_integer(word, (size_t)(p - word), &value) || value < 1 || value > INT_MAX)
        return false;
    *count = (uint32_t)value;
    while (p < end && *p == ' ')
        p++;
    *at = p;
    return true;
}

static pm_status read_resolution(struct reading *r)
{
    const char *at;
    size_t length;
    bool negative[2];
    char axis[2];
    uint32_t count[2];
    bool right = next_line(r, &at, &length);
    const char *end = right ? at + length : NULL;
    right = right && read_extent(&at, end, &negative[0], &axis[0], &count[0]) &&
            read_extent(&at, end, &negative[1], &axis[1], &count[1]) && at == end &&
            axis[0] != axis[1];
    if (!right)
        return bad(r, PM_E_SYNTAX,
                   "the picture's size must follow its header, such as '-Y 480 +X 640'");
    r->rows = axis[0] == 'Y';
    int y = r->rows ? 0 : 1;
    r->y_decreases = negative[y];
    r->x_decreases = negative[1 - y];
    r->height = count[y];
    r->width = count[1 - y];
    if (r->spectral && (!r->rows || !r->y_decreases || r->x_decreases))
        return bad(r, PM_E_UNSUPPORTED, "a spectral picture's size must be of the kind -Y +X");
    return PM_OK;
}

/* ---- pixels ---- */

/* One byte plane of a scan line: a count over 128 repeats the next byte (count - 128) times,
 * another count copies as many bytes. */
static bool read_plane(struct reading *r, uint8_t *out, uint32_t length)
{
    for (uint32_t x = 0; x < length;) {
        if (r->end - r->at < 2)
            return false;
        uint32_t code = *r->at++, count = code > 128 ? code - 128 : code;
        size_t bytes = code > 128 ? 1 : count;
        if (count > length - x || bytes > (size_t)(r->end - r->at))
            return false;
        for (uint32_t i = 0; i < count; i++, x++)
            out[4 * (size_t)x] = r->at[code > 128 ? 0 : i];
        r->at += bytes;
    }
    return true;
}

/* Pixels as they are; 1 1 1 n repeats the one before n times, the next such 256 n times. As in
 * Radiance a repetition ends with its scan line. */
static bool read_flat(struct reading *r, uint8_t (*out)[4], uint32_t length)
{
    unsigned shift = 0;
    for (uint32_t x = 0; x < length;) {
        if (r->end - r->at < 4)
            return false;
        memcpy(out[x], r->at, 4);
        r->at += 4;
        if (out[x][0] != 1 || out[x][1] != 1 || out[x][2] != 1) {
            x++;
            shift = 0;
            continue;
        }
        if (x == 0 || shift > 24)
            return false;
        uint64_t count = (uint64_t)out[x][3] << shift;
        for (; count && x < length; count--, x++)
            memcpy(out[x], out[x - 1], 4);
        shift += 8;
    }
    return true;
}

static bool read_line(struct reading *r, uint8_t (*out)[4], uint32_t length)
{
    const uint8_t *p = r->at;
    if (length < RUN_WIDTH_MIN || length > RUN_WIDTH_MAX || r->end - p < 4 || p[0] != 2 ||
        p[1] != 2 || p[2] & 0x80)
        return read_flat(r, out, length);
    if ((uint32_t)p[2] << 8 != (length & 0xFF00) || p[3] != (length & 0xFF))
        return false;
    r->at += 4;
    for (int i = 0; i < 4; i++)
        if (!read_plane(r, &out[0][i], length))
            return false;
    return true;
}

/* Where pixel `i` of scan line `line` stands. */
static size_t place_of(const struct reading *r, uint32_t line, uint32_t i)
{
    uint32_t x = r->rows ? i : line, y = r->rows ? line : i;
    x = r->x_decreases ? r->width - 1 - x : x;
    y = r->y_decreases ? r->height - 1 - y : y;
    return (size_t)y * r->width + x;
}

/* Spectra are not compressed. */
static bool read_spectra(struct reading *r, uint8_t *out, size_t size)
{
    if ((size_t)(r->end - r->at) < size)
        return false;
    memcpy(out, r->at, size);
    r->at += size;
    return true;
}

static pm_status read_lines(struct reading *r, pm_picture *picture, uint8_t (*scan)[4])
{
    uint32_t lines = r->rows ? r->height : r->width, length = r->rows ? r->width : r->height;
    for (uint32_t line = 0; line < lines; line++) {
        uint8_t *row = picture->pixels + picture->stride * place_of(r, line, 0);
        if (!(r->spectral ? read_spectra(r, row, picture->stride * length)
                          : read_line(r, scan, length)))
            return pm_error_set_at(r->err, PM_E_CORRUPT, r->name, 0, 0,
                                   "scan line %u of the picture's %u is damaged or missing",
                                   line + 1, lines);
        for (uint32_t i = 0; i < length && !r->spectral; i++)
            memcpy(picture->pixels + 4 * place_of(r, line, i), scan[i], 4);
    }
    return PM_OK;
}

/* ---- the whole ---- */

static pm_status check_size(const struct reading *r)
{
    uint64_t lines = r->rows ? r->height : r->width;
    if ((uint64_t)r->width * r->height > PIXELS_MAX)
        return pm_error_set_at(r->err, PM_E_LIMIT, r->name, 0, 0,
                               "the picture has %u x %u pixels; 2^27 are allowed", r->width,
                               r->height);
    uint64_t least = r->spectral ? (uint64_t)r->width * (uint64_t)(r->bands + 1) : 4;
    if ((uint64_t)(r->end - r->at) / least < lines) /* no scan line takes less */
        return pm_error_set_at(r->err, PM_E_CORRUPT, r->name, 0, 0,
                               "the picture of %u x %u pixels is cut short", r->width,
                               r->height);
    return PM_OK;
}

/* The shorter side is 1 long (getpict in Radiance's data.c). */
static void set_axes(pm_picture *picture, double aspect)
{
    double width = picture->width, height = picture->height * aspect;
    bool upright = width <= height;
    picture->u = (pm_data_axis){0, upright ? 1 : width / height, picture->width, NULL};
    picture->v = (pm_data_axis){0, upright ? height / width : 1, picture->height, NULL};
}

static pm_status read_pixels(struct reading *r, pm_picture *picture)
{
    uint32_t length = r->rows ? r->width : r->height;
    uint8_t(*scan)[4] = malloc(4 * (size_t)length);
    picture->pixels = malloc(picture->stride * r->width * r->height);
    pm_status st = scan && picture->pixels
                       ? read_lines(r, picture, scan)
                       : bad(r, PM_E_MEMORY, "not enough memory for the picture");
    free(scan);
    return st;
}

pm_status pm_picture_read(const void *bytes, size_t size, const char *name, pm_picture **out,
                          pm_error *err)
{
    struct reading r = {.at = bytes, .name = name, .err = err, .aspect = 1};
    r.end = r.at + size;
    pm_status st = size ? read_header(&r) : bad(&r, PM_E_SYNTAX, "the picture is empty");
    if (!st)
        st = read_resolution(&r);
    if (!st)
        st = check_size(&r);
    if (st)
        return st;
    pm_picture *picture = calloc(1, sizeof *picture);
    if (!picture)
        return bad(&r, PM_E_MEMORY, "not enough memory for the picture");
    picture->width = r.width;
    picture->height = r.height;
    picture->xyz = r.xyz;
    picture->bands = r.spectral ? (unsigned)r.bands : 0;
    picture->stride = r.spectral ? picture->bands + 1 : 4;
    picture->nm0 = r.nm0;
    picture->nm1 = r.nm1;
    set_axes(picture, r.aspect);
    st = read_pixels(&r, picture);
    if (st)
        pm_picture_free(picture);
    else
        *out = picture;
    return st;
}

void pm_picture_free(pm_picture *picture)
{
    if (picture)
        free(picture->pixels);
    free(picture);
}

/* ---- queries ---- */

uint32_t pm_picture_width(const pm_picture *picture)
{
    return picture->width;
}

uint32_t pm_picture_height(const pm_picture *picture)
{
    return picture->height;
}

void pm_picture_extent(const pm_picture *picture, double *u, double *v)
{
    *u = picture->u.last;
    *v = picture->v.last;
}

/* (mantissa + 1/2) 2^(exponent - 136); black if the exponent is 0. */
static pm_rgb decode(const uint8_t pixel[4])
{
    if (!pixel[3])
        return (pm_rgb){0, 0, 0};
    double unit = ldexp(1, pixel[3] - 136);
    return (pm_rgb){(pixel[0] + 0.5) * unit, (pixel[1] + 0.5) * unit, (pixel[2] + 0.5) * unit};
}

static pm_rgb stored(const pm_picture *picture, uint32_t x, uint32_t y)
{
    return decode(picture->pixels + 4 * ((size_t)y * picture->width + x));
}

static pm_rgb to_rgb(const pm_picture *picture, pm_rgb stored_color)
{
    return picture->xyz ? pm_rgb_of_xyz(stored_color.r, stored_color.g, stored_color.b)
                        : stored_color;
}

pm_rgb pm_picture_pixel(const pm_picture *picture, uint32_t x, uint32_t y)
{
    return to_rgb(picture, stored(picture, x, y));
}

/* An axis of one pixel has its colour everywhere. */
static pm_data_place place(const pm_data_axis *axis, double at)
{
    return axis->count > 1 ? pm_data_axis_place(axis, at) : (pm_data_place){0, 1, 0};
}

/* Row y between the columns of `x`. */
static pm_rgb along_row(const pm_picture *picture, pm_data_place x, uint32_t y)
{
    pm_rgb sum = pm_rgb_scale(stored(picture, x.index, y), x.low);
    return x.index + 1 < picture->width
               ? pm_rgb_madd(sum, x.high, stored(picture, x.index + 1, y))
               : sum;
}

pm_rgb pm_picture_value(const pm_picture *picture, double u, double v)
{
    if (isnan(u) || isnan(v))
        return (pm_rgb){0, 0, 0};
    pm_data_place x = place(&picture->u, u), y = place(&picture->v, v);
    pm_rgb sum = pm_rgb_scale(along_row(picture, x, y.index), y.low);
    if (y.index + 1 < picture->height)
        sum = pm_rgb_madd(sum, y.high, along_row(picture, x, y.index + 1));
    return to_rgb(picture, sum);
}

/* ---- spectra ---- */

unsigned pm_picture_bands(const pm_picture *picture, double *nm0, double *nm1)
{
    if (picture->bands) {
        *nm0 = picture->nm0;
        *nm1 = picture->nm1;
    }
    return picture->bands;
}

static void add_spectrum(const pm_picture *picture, uint32_t x, uint32_t y, double weight,
                         double *samples)
{
    if (x >= picture->width || y >= picture->height)
        return;
    const uint8_t *p = picture->pixels + picture->stride * ((size_t)y * picture->width + x);
    int exponent = p[picture->bands];
    double unit = exponent ? ldexp(weight, exponent - 136) : 0;
    for (unsigned i = 0; i < picture->bands; i++)
        samples[i] += unit * (p[i] + 0.5);
}

void pm_picture_spectrum(const pm_picture *picture, double u, double v, double *samples)
{
    memset(samples, 0, picture->bands * sizeof *samples);
    if (isnan(u) || isnan(v))
        return;
    pm_data_place x = place(&picture->u, u), y = place(&picture->v, v);
    for (unsigned corner = 0; corner < 4; corner++)
        add_spectrum(picture, x.index + (corner & 1), y.index + (corner >> 1),
                     (corner & 1 ? x.high : x.low) * (corner >> 1 ? y.high : y.low), samples);
}
