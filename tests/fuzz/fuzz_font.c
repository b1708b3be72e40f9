/* Reads the input as a font and sets text in it; asks points all over it. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "files/font.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void ask(const pm_text *text)
{
    for (double down = -0.3; down < 3.5; down += 0.13)
        for (double right = -0.3; right < 9; right += 0.17)
            (void)pm_text_holds(text, right, down);
    check(!pm_text_holds(text, NAN, 0) && !pm_text_holds(text, 0, NAN));
    check(!pm_text_holds(text, INFINITY, 0) && !pm_text_holds(text, 0, INFINITY));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const double spacings[] = {0, -0.2, 0.3, 7};
    static const char words[] = "AB  A    C\n\nx\tB\xff A";
    pm_error err = PM_ERROR_INIT;
    pm_font *font = NULL;
    if (pm_font_read(data, size, "fuzz", &font, &err)) {
        check(err.status && err.text[0] && !font);
        return 0;
    }
    for (size_t i = 0; i < sizeof spacings / sizeof *spacings; i++) {
        pm_arena arena = {0};
        const pm_text *text = NULL;
        check(!pm_text_new(font, words, strlen(words), i ? &spacings[i] : NULL, &arena, &text,
                           NULL));
        ask(text);
        if (!pm_text_new(font, (const char *)data, size, &spacings[i], &arena, &text, NULL))
            ask(text);
        pm_arena_clear(&arena);
    }
    pm_font_free(font);
    return 0;
}
