#include "language/language_internal.h"

#include <stdlib.h>
#include <string.h>

/* Sorted by name. `arg` alone is not constant when its argument is. */
static const struct pm_builtin library[] = {
    {"acos", PM_OP_ACOS, 1, true, false},      {"arg", PM_OP_REAL_AT, 1, false, true},
    {"asin", PM_OP_ASIN, 1, true, false},      {"atan", PM_OP_ATAN, 1, true, false},
    {"atan2", PM_OP_ATAN2, 2, true, false},    {"ceil", PM_OP_CEIL, 1, true, false},
    {"cos", PM_OP_COS, 1, true, false},        {"erf", PM_OP_ERF, 1, true, true},
    {"erfc", PM_OP_ERFC, 1, true, true},       {"exp", PM_OP_EXP, 1, true, false},
    {"floor", PM_OP_FLOOR, 1, true, false},    {"fnoise3", PM_OP_FNOISE3, 3, true, true},
    {"if", PM_OP_IF, 3, true, false},          {"log", PM_OP_LOG, 1, true, false},
    {"log10", PM_OP_LOG10, 1, true, false},    {"max", PM_OP_MAX, 1, true, false},
    {"min", PM_OP_MIN, 1, true, false},        {"noise3", PM_OP_NOISE3, 3, true, true},
    {"noise3x", PM_OP_NOISE3X, 3, true, true}, {"noise3y", PM_OP_NOISE3Y, 3, true, true},
    {"noise3z", PM_OP_NOISE3Z, 3, true, true}, {"rand", PM_OP_RAND, 1, true, false},
    {"select", PM_OP_SELECT, 1, true, false},  {"sin", PM_OP_SIN, 1, true, false},
    {"sqrt", PM_OP_SQRT, 1, true, false},      {"tan", PM_OP_TAN, 1, true, false},
};

static int compare(const void *name, const void *entry)
{
    return strcmp(name, ((const struct pm_builtin *)entry)->name);
}

const struct pm_builtin *pm_builtin_find(enum pm_language_kind kind, const char *name)
{
    const struct pm_builtin *found =
        bsearch(name, library, sizeof library / sizeof *library, sizeof *library, compare);
    return found && found->scenes_only && kind != PM_LANGUAGE_SCENE ? NULL : found;
}
