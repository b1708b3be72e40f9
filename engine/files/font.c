#include "files/font.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "base/maths.h"
#include "files/words.h"

enum { CHARACTERS = 256, VERTICES_MAX = 32000, GRID = 255 };
enum { LINE_LENGTH_MAX = 511 }; /* Radiance's gettext cuts longer ones */
enum { SPACING_MAX = 1000 };    /* character widths */
enum { STROKES_MAX = 256, PIECES_MAX = 64, PEN_MAX = 60, ARC_STEP = 15 }; /* [deg] */
enum { INDENT_SPACES = 3 }; /* so many and more align a column (text.c, proptext) */

/* What a pen draws on a straight way. */
struct stroke {
    double x0, y0, x1, y1;
};

struct glyph {
    bool given;
    uint16_t count;                   /* vertices or strokes; 0: a blank */
    uint8_t left, right, bottom, top; /* the centre 128 included, as in Radiance's font.c */
    uint8_t (*vertices)[2];           /* of the outline; NULL if a pen draws the glyph */
    struct stroke *strokes;
};

struct pm_font {
    pm_arena arena; /* everything, this struct included */
    int mean_width; /* of glyphs that have an area */
    double pen;     /* its radius, if glyphs are strokes */
    struct glyph glyph[CHARACTERS];
};

/* ---- reading ---- */

static pm_status memory_error(const char *name, pm_error *err)
{
    return pm_error_set_at(err, PM_E_MEMORY, name, 0, 0, "not enough memory for the font");
}

static void extend(struct glyph *g, unsigned x, unsigned y)
{
    g->left = x < g->left ? (uint8_t)x : g->left;
    g->right = x > g->right ? (uint8_t)x : g->right;
    g->bottom = y < g->bottom ? (uint8_t)y : g->bottom;
    g->top = y > g->top ? (uint8_t)y : g->top;
}

static pm_status read_vertices(pm_words *words, struct glyph *g, uint8_t (*out)[2],
                               pm_error *err)
{
    for (unsigned i = 0; i < g->count; i++) {
        int64_t x = 0, y = 0;
        pm_status st = pm_words_integer(words, "x of a vertex", 0, GRID, &x, err);
        if (!st)
            st = pm_words_integer(words, "y of a vertex", 0, GRID, &y, err);
        if (st)
            return st;
        out[i][0] = (uint8_t)x;
        out[i][1] = (uint8_t)y;
        extend(g, (unsigned)x, (unsigned)y);
    }
    return PM_OK;
}

static pm_status read_outline(pm_words *words, pm_font *font, int character, pm_error *err)
{
    int64_t count = 0;
    struct glyph *g = &font->glyph[character];
    pm_status st =
        pm_words_integer(words, "a glyph's number of vertices", 0, VERTICES_MAX, &count, err);
    if (!st && 4 * (size_t)count > pm_words_left(words) + 1)
        st = pm_words_error(words, PM_E_SYNTAX, err,
                            "the file ends before the %d vertices of character %d", (int)count,
                            character);
    if (st)
        return st;
    g->count = (uint16_t)count;
    g->vertices = pm_arena_array(&font->arena, (size_t)count + 1, sizeof *g->vertices);
    return g->vertices ? read_vertices(words, g, g->vertices, err)
                       : memory_error(words->file, err);
}

/* ---- glyphs that a pen draws ---- */

/* Strokes of one glyph as they are read. */
struct drawing {
    struct stroke strokes[STROKES_MAX];
    unsigned count;
};

static pm_status draw(pm_words *words, struct drawing *d, double x0, double y0, double x1,
                      double y1, pm_error *err)
{
    if (d->count == STROKES_MAX)
        return pm_words_error(words, PM_E_LIMIT, err, "a glyph has more than %d strokes",
                              STROKES_MAX);
    d->strokes[d->count++] = (struct stroke){x0, y0, x1, y1};
    return PM_OK;
}

static pm_status read_line(pm_words *words, int64_t points, struct drawing *d, pm_error *err)
{
    int64_t x = 0, y = 0, x0 = 0, y0 = 0;
    for (int64_t i = 0; i < points; i++, x0 = x, y0 = y) {
        pm_status st = pm_words_integer(words, "x of a point", 0, GRID, &x, err);
        if (!st)
            st = pm_words_integer(words, "y of a point", 0, GRID, &y, err);
        if (!st && i > 0)
            st = draw(words, d, (double)x0, (double)y0, (double)x, (double)y, err);
        if (st)
            return st;
    }
    return PM_OK;
}

static pm_status read_arc(pm_words *words, struct drawing *d, pm_error *err)
{
    int64_t v[6] = {0}; /* centre, radii, angles */
    pm_status st = PM_OK;
    for (int i = 0; i < 6 && !st; i++)
        st = pm_words_integer(words, "a number of an arc", i < 4 ? 0 : -360, 360, &v[i], err);
    int steps = (int)(llabs(v[5] - v[4]) + ARC_STEP - 1) / ARC_STEP;
    double x0 = 0, y0 = 0;
    for (int i = 0; i <= steps && !st; i++) {
        double sine, cosine, share = steps ? (double)i / steps : 0;
        pm_sincos(((double)v[4] + share * (double)(v[5] - v[4])) * (PM_PI / 180), &sine,
                  &cosine);
        double x = (double)v[0] + (double)v[2] * cosine, y = (double)v[1] + (double)v[3] * sine;
        if (i > 0)
            st = draw(words, d, x0, y0, x, y, err);
        x0 = x;
        y0 = y;
    }
    return st;
}

static double clipped(double x)
{
    return fmin(fmax(x, 0), GRID);
}

static pm_status keep_strokes(pm_words *words, const struct drawing *d, pm_font *font,
                              struct glyph *g, pm_error *err)
{
    g->strokes = pm_arena_array(&font->arena, d->count + 1, sizeof *g->strokes);
    if (!g->strokes)
        return memory_error(words->file, err);
    g->count = (uint16_t)d->count;
    memcpy(g->strokes, d->strokes, d->count * sizeof *g->strokes);
    for (unsigned i = 0; i < d->count; i++) {
        const struct stroke *s = &d->strokes[i];
        extend(g, (unsigned)clipped(floor(fmin(s->x0, s->x1) - font->pen)),
               (unsigned)clipped(floor(fmin(s->y0, s->y1) - font->pen)));
        extend(g, (unsigned)clipped(ceil(fmax(s->x0, s->x1) + font->pen)),
               (unsigned)clipped(ceil(fmax(s->y0, s->y1) + font->pen)));
    }
    return PM_OK;
}

static pm_status read_drawing(pm_words *words, pm_font *font, int character, pm_error *err)
{
    struct drawing d = {.count = 0};
    int64_t pieces = 0, points = 0;
    pm_status st =
        pm_words_integer(words, "a glyph's number of pieces", 0, PIECES_MAX, &pieces, err);
    for (int64_t i = 0; i < pieces && !st; i++) {
        st =
            pm_words_integer(words, "a piece's number of points", 0, STROKES_MAX, &points, err);
        if (!st)
            st = points ? read_line(words, points, &d, err) : read_arc(words, &d, err);
    }
    return st ? st : keep_strokes(words, &d, font, &font->glyph[character], err);
}

/* ---- the whole ---- */

static pm_status read_glyph(pm_words *words, pm_font *font, pm_error *err)
{
    int64_t character = 0;
    pm_status st =
        pm_words_integer(words, "a glyph's character", 1, CHARACTERS - 1, &character, err);
    struct glyph *g = &font->glyph[character];
    if (!st && g->given)
        st = pm_words_error(words, PM_E_SYNTAX, err, "character %d has two glyphs",
                            (int)character);
    if (st)
        return st;
    *g = (struct glyph){true, 0, 128, 128, 128, 128, NULL, NULL};
    return font->pen > 0 ? read_drawing(words, font, (int)character, err)
                         : read_outline(words, font, (int)character, err);
}

/* A font whose glyphs are strokes says so first. */
static pm_status read_pen(pm_words *words, pm_font *font, pm_error *err)
{
    int64_t pen = 0;
    if (!pm_words_take(words, "strokes"))
        return PM_OK;
    pm_status st = pm_words_integer(words, "the pen's radius", 1, PEN_MAX, &pen, err);
    font->pen = (double)pen;
    return st;
}

static int mean_width(const pm_font *font)
{
    int sum = 0, count = 0;
    for (int c = 0; c < CHARACTERS; c++) {
        const struct glyph *g = &font->glyph[c];
        if (g->right == g->left || g->top == g->bottom)
            continue;
        sum += g->right - g->left;
        count++;
    }
    return count ? sum / count : 0;
}

pm_status pm_font_read(const void *bytes, size_t size, const char *name, pm_font **out,
                       pm_error *err)
{
    pm_words words;
    pm_status st = pm_words_init(&words, bytes, size, name, err);
    if (st)
        return st;
    pm_arena arena = {0};
    pm_font *font = pm_arena_alloc(&arena, sizeof *font);
    if (!font) {
        pm_arena_clear(&arena);
        return memory_error(name, err);
    }
    font->arena = arena;
    st = read_pen(&words, font, err);
    while (!st && pm_words_more(&words))
        st = read_glyph(&words, font, err);
    if (st) {
        pm_font_free(font);
        return st;
    }
    font->mean_width = mean_width(font);
    *out = font;
    return PM_OK;
}

void pm_font_free(pm_font *font)
{
    if (!font)
        return;
    pm_arena arena = font->arena;
    pm_arena_clear(&arena);
}

/* ---- setting text ---- */

/* step[i] leads from the start of character i - 1 (0: of the line) to that of character i, and
 * step[length] to the line's end [grid]. */
struct line {
    const char *text;
    int length, width;
    const int *step;
};

struct pm_text {
    const pm_font *font;
    double grid; /* units of `right` in the grid of glyphs */
    size_t line_count;
    struct line *lines;
};

static const struct glyph *glyph_of(const pm_font *font, char c)
{
    const struct glyph *g = &font->glyph[(unsigned char)c];
    return g->given ? g : NULL;
}

static int set_uniform(const pm_font *font, const struct line *line, int *step)
{
    int width = 0;
    step[0] = 0;
    for (int i = 0; i < line->length; i++)
        width += step[i + 1] = glyph_of(font, line->text[i]) ? GRID : 0;
    return width;
}

/* Each glyph as wide as it is drawn, `gap` between two. */
static int set_squeezed(const pm_font *font, const struct line *line, int gap, int *step)
{
    int width = 0, i = 0, half = gap / 2;
    while (i < line->length && !glyph_of(font, line->text[i]))
        step[i++] = 0;
    step[i] = half;
    for (; i < line->length; i++) {
        const struct glyph *g = glyph_of(font, line->text[i]);
        if (g && g->count)
            step[i] += half - g->left;
        width += step[i];
        step[i + 1] = !g ? 0 : g->count ? g->right + half : font->mean_width;
    }
    step[i] += half;
    return width + step[i];
}

/* Where the run of characters that starts at `at` and ends in an indent, or the line, ends. Its
 * cells are those of characters that have a glyph and of the blanks that follow them. */
static int find_run(const pm_font *font, const struct line *line, int at, int *cells)
{
    *cells = 0;
    while (at < line->length) {
        int end = at + 1;
        if (glyph_of(font, line->text[at])) {
            const struct glyph *g;
            while (end < line->length && (g = glyph_of(font, line->text[end])) && !g->count)
                end++;
            *cells += end - at;
        }
        bool indent = end - at > INDENT_SPACES;
        at = end;
        if (indent)
            break;
    }
    return at;
}

/* As squeezed, but what follows an indent starts where cells of mean width put it, and the
 * difference is spread over the characters before. */
static int set_proportional(const pm_font *font, const struct line *line, int gap, int *step)
{
    set_squeezed(font, line, gap, step);
    int width = step[0];
    for (int at = 0; at < line->length;) {
        int cells, end = find_run(font, line, at, &cells);
        int length = cells * (font->mean_width + gap), rest = length;
        width += length;
        for (int i = at; i < end; i++)
            rest -= step[i + 1];
        for (int i = at; i < end; i++) {
            int share = rest / (end - i);
            step[i + 1] += share;
            rest -= share;
        }
        at = end;
    }
    return width;
}

static pm_status set_line(const pm_text *text, struct line *line, int gap, pm_arena *arena,
                          pm_error *err)
{
    if (line->length > LINE_LENGTH_MAX)
        return pm_error_set(err, PM_E_LIMIT, "a line of text has %d characters; %d are allowed",
                            line->length, LINE_LENGTH_MAX);
    int *step = pm_arena_array(arena, (size_t)line->length + 1, sizeof *step);
    if (!step)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a text");
    line->step = step;
    line->width = gap < 0   ? set_squeezed(text->font, line, -gap, step)
                  : gap > 0 ? set_proportional(text->font, line, gap, step)
                            : set_uniform(text->font, line, step);
    return PM_OK;
}

/* Empty lines take memory too, so few bytes of each. */
static pm_status cut_lines(pm_text *text, const char *bytes, size_t size, pm_arena *arena)
{
    size_t count = size && bytes[size - 1] != '\n';
    for (size_t i = 0; i < size; i++)
        count += bytes[i] == '\n';
    text->lines = pm_arena_array(arena, count + 1, sizeof *text->lines);
    char *copy = pm_arena_text(arena, bytes, size);
    if (!text->lines || !copy)
        return PM_E_MEMORY;
    for (const char *at = copy; text->line_count < count; text->line_count++) {
        const char *end = memchr(at, '\n', (size_t)(copy + size - at));
        end = end ? end : copy + size;
        size_t length = (size_t)(end - at);
        struct line *line = &text->lines[text->line_count];
        *line = (struct line){at, length < INT32_MAX ? (int)length : INT32_MAX, 0, NULL};
        at = end + 1;
    }
    return PM_OK;
}

static pm_status set_text(pm_text *text, const char *bytes, size_t size, double spacing,
                          pm_arena *arena, pm_error *err)
{
    if (cut_lines(text, bytes, size, arena))
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a text");
    pm_status st = PM_OK;
    for (size_t i = 0; i < text->line_count && !st; i++)
        st = set_line(text, &text->lines[i], (int)(spacing * GRID), arena, err);
    return st;
}

pm_status pm_text_new(const pm_font *font, const char *bytes, size_t size,
                      const double *spacing, pm_arena *arena, const pm_text **out,
                      pm_error *err)
{
    if (spacing && !(fabs(*spacing) <= SPACING_MAX))
        return pm_error_set(err, PM_E_RANGE, "spacing %.9g is not from -%d to %d", *spacing,
                            SPACING_MAX, SPACING_MAX);
    pm_text *text = pm_arena_alloc(arena, sizeof *text);
    if (!text)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a text");
    text->font = font;
    text->grid = spacing ? font->mean_width + GRID * fabs(*spacing) : GRID;
    pm_status st = set_text(text, bytes, size, spacing ? *spacing : 0, arena, err);
    if (!st)
        *out = text;
    return st;
}

/* ---- queries ---- */

/* Whether the ray to the right of the point crosses the edge. Cells of the grid are asked at
 * their centre, so that no vertex lies on the ray; an edge that spans the point's column is
 * decided by the point itself. */
static bool crosses(const uint8_t a[2], const uint8_t b[2], double x, double y, int cell_x,
                    int cell_y)
{
    if ((a[1] > cell_y) == (b[1] > cell_y))
        return false;
    bool a_right = a[0] > cell_x, b_right = b[0] > cell_x;
    if (a_right == b_right)
        return a_right;
    return (b[1] > a[1]) != ((a[1] - y) * (b[0] - x) > (a[0] - x) * (b[1] - y));
}

/* Whether a round pen of that radius comes over the point. */
static bool covers(const struct stroke *s, double pen, double x, double y)
{
    double dx = s->x1 - s->x0, dy = s->y1 - s->y0, px = x - s->x0, py = y - s->y0;
    double square = dx * dx + dy * dy, t = square > 0 ? (px * dx + py * dy) / square : 0;
    t = fmin(fmax(t, 0), 1);
    px -= t * dx;
    py -= t * dy;
    return px * px + py * py < pen * pen;
}

static bool in_glyph(const pm_font *font, const struct glyph *g, double x, double y)
{
    int cell_x = (int)x, cell_y = (int)y;
    if (g->left > cell_x || g->right <= cell_x || g->bottom > cell_y || g->top <= cell_y)
        return false;
    bool inside = false;
    for (unsigned i = 0; g->strokes && i < g->count; i++)
        if (covers(&g->strokes[i], font->pen, x, y))
            return true;
    for (unsigned i = 0; g->vertices && i < g->count; i++)
        inside ^= crosses(g->vertices[i ? i - 1 : g->count - 1u], g->vertices[i], x, y, cell_x,
                          cell_y);
    return inside;
}

static bool in_line(const pm_font *font, const struct line *line, int cell, double part,
                    double y)
{
    for (int i = 0; i < line->length; i++) {
        cell -= line->step[i];
        if (cell < 0)
            return false;
        const struct glyph *g = glyph_of(font, line->text[i]);
        if (g && cell < GRID && in_glyph(font, g, cell + part, y))
            return true;
    }
    return false;
}

bool pm_text_holds(const pm_text *text, double right, double down)
{
    double x = right * text->grid;
    if (!(x >= 0) || !(down >= 0) || !(down < (double)text->line_count))
        return false;
    size_t row = (size_t)down;
    const struct line *line = &text->lines[row];
    if (!(x < line->width))
        return false;
    int cell = (int)x;
    return in_line(text->font, line, cell, x - cell, ((double)(row + 1) - down) * GRID);
}
