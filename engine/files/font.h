#ifndef PM_FILES_FONT_H
#define PM_FILES_FONT_H

#include <stdbool.h>
#include <stddef.h>

#include "base/arena.h"
#include "base/error.h"

/* Radiance fonts (.fnt): glyphs as polygons on a grid of 256 x 256, and text set in them.
 *
 * In: a file's bytes. Out: pm_font, pm_text (immutable). Next: world/texture.h asks which
 * points are ink.
 *
 * Format: for each glyph its character 1..255, the number of vertices, and their x y in 0..255,
 * y upwards; `#` starts a comment. Source: Radiance's refer/filefmts, "Font files".
 *
 * An extension of ours: a file that begins with `strokes RADIUS` has glyphs that a round pen
 * draws: a character, the number of pieces, and for each either its number of points and those,
 * or 0 and an arc: centre, radii, first and last angle [deg]. */

typedef struct pm_font pm_font;

PM_MUST_USE pm_status pm_font_read(const void *bytes, size_t size, const char *name,
                                   pm_font **out, pm_error *err);
void pm_font_free(pm_font *font);

/* The bytes of a font that need not be brought, static: "helvet.fnt"; NULL for other names. */
const char *pm_font_standard(const char *name, size_t *size);

/* Lines of text in a font, as colortext, brighttext and mixtext set them. Borrows the font;
 * lives in an arena. */
typedef struct pm_text pm_text;

/* Sets `text`, whose lines end in '\n' (the last may lack it).
 *   spacing  Radiance's real argument: 0 uniform; > 0 proportional, aligned for tables; < 0
 *            squeezed. NULL if the scene does not give it, which is uniform with other widths
 * Source: uniftext, squeeztext, proptext in Radiance's font.c. Tests: test_font.c. */
PM_MUST_USE pm_status pm_text_new(const pm_font *font, const char *text, size_t size,
                                  const double *spacing, pm_arena *arena, const pm_text **out,
                                  pm_error *err);

/* Whether the point `right` character widths to the right of and `down` line heights below the
 * text's upper left corner is ink. Source: intext and inglyph in Radiance's text.c. */
bool pm_text_holds(const pm_text *text, double right, double down);

#endif
