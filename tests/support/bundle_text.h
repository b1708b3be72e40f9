#ifndef PM_TESTS_BUNDLE_TEXT_H
#define PM_TESTS_BUNDLE_TEXT_H

#include <string.h>

#include "scene/bundle.h"

/* A scene of several files in one text: lines `#file NAME` start the others. */
static inline pm_status add_texts(pm_bundle *bundle, const char *main_name, const char *text,
                                  pm_error *err)
{
    static const char mark[] = "\n#file ";
    char name[64];
    strncpy(name, main_name, sizeof name - 1);
    name[sizeof name - 1] = 0;
    for (;;) {
        const char *end = strstr(text, mark);
        size_t size = end ? (size_t)(end + 1 - text) : strlen(text);
        pm_status st = pm_bundle_add(bundle, name, text, size, err);
        if (st || !end)
            return st;
        const char *next = end + sizeof mark - 1;
        size_t length = strcspn(next, "\n");
        if (length >= sizeof name)
            return PM_E_RANGE;
        memcpy(name, next, length);
        name[length] = 0;
        text = next + length + (next[length] != 0);
    }
}

#endif
