#include "option_words.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* Views and sizes of pictures. */

pm_status pm_take_vector(struct pm_words *words)
{
    pm_view *view = &words->out->view;
    pm_vec3 *v = words->option[2] == 'p'   ? &view->point
                 : words->option[2] == 'd' ? &view->direction
                                           : &view->up;
    pm_status st = pm_word_number(words, "three numbers x y z", &v->x);
    if (!st)
        st = pm_word_number(words, "three numbers x y z", &v->y);
    if (!st)
        st = pm_word_number(words, "three numbers x y z", &v->z);
    return st;
}

pm_status pm_take_angle(struct pm_words *words)
{
    pm_view *view = &words->out->view;
    return pm_word_number(words, "an angle in degrees",
                          words->option[2] == 'h' ? &view->horizontal : &view->vertical);
}

/* What a view file says in the same words, e.g. -vta, -vs .5. */
pm_status pm_take_other_view(struct pm_words *words)
{
    char text[128];
    const char *value = "";
    if (strncmp(words->option, "-vt", 3)) {
        pm_status st = pm_word_text(words, "a number", &value);
        if (st)
            return st;
    }
    snprintf(text, sizeof text, "%s %s", words->option, value);
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_view_parse(text, "view", &words->out->view, &err);
    return st ? pm_error_set(words->err, st, "%s: %s", words->option, err.text) : PM_OK;
}

pm_status pm_take_view_file(struct pm_words *words)
{
    const char *path = NULL;
    pm_status st = pm_word_text(words, "a file", &path);
    if (st)
        return st;
    char text[65536];
    FILE *file = fopen(path, "rb");
    if (!file)
        return pm_error_set_at(words->err, PM_E_IO, path, 0, 0, "cannot be read: %s",
                               strerror(errno));
    size_t size = fread(text, 1, sizeof text - 1, file);
    bool whole = feof(file) && !ferror(file);
    fclose(file);
    text[size] = '\0';
    if (!whole || strlen(text) != size)
        return pm_error_set_at(words->err, PM_E_SYNTAX, path, 0, 0,
                               "is no view file: a line like `rvu -vtv -vp 0 0 1 -vd 0 1 0`");
    return pm_view_parse(text, path, &words->out->view, words->err);
}

pm_status pm_take_size(struct pm_words *words)
{
    return pm_word_u32(words, "pixels", 1, 16384,
                       words->option[1] == 'x' ? &words->out->x : &words->out->y);
}

pm_status pm_take_aspect(struct pm_words *words)
{
    pm_status st = pm_word_number(words, "a number", &words->out->pixel_aspect);
    if (st)
        return st;
    if (!(words->out->pixel_aspect >= 0 && words->out->pixel_aspect <= 1e6))
        return pm_word_bad(
            words, words->argv[words->at - 1],
            "the height of a pixel over its width, at most 1e6, or 0 (exactly -x by -y)");
    return PM_OK;
}
