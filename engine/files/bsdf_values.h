#ifndef PM_FILES_BSDF_VALUES_H
#define PM_FILES_BSDF_VALUES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"
#include "base/status.h"
#include "files/bsdf_tree.h"

/* ScatteringData as it streams in, cut anywhere: numbers for a matrix, nested braces for a
 * tensor tree. Zero-initialised storage is empty; `rank` is set before the first text. */
struct pm_bsdf_values {
    unsigned rank;    /* of the tree; 0: a matrix */
    pm_bytes numbers; /* floats */
    pm_bytes nodes, links;
    size_t count; /* of numbers */

    char word[64]; /* begun, not yet ended */
    size_t length;

    struct pm_bsdf_frame { /* open braces */
        enum { FRAME_EMPTY, FRAME_BRANCH, FRAME_GRID } kind;
        uint32_t first, children;
    } frame[PM_TREE_LEVELS + 2];
    unsigned depth, deepest;
    bool closed;
    uint32_t root;

    pm_status status; /* why an addition failed */
    ptrdiff_t at;     /* and where in its text; below 0 if in one before it */
    char message[160];
};

/* False with status and message if the text is not what it should be. */
bool pm_bsdf_values_add(struct pm_bsdf_values *values, const char *text, size_t size);
bool pm_bsdf_values_end(struct pm_bsdf_values *values);
void pm_bsdf_values_clear(struct pm_bsdf_values *values);

/* After a successful end: the caller frees. */
float *pm_bsdf_values_take(struct pm_bsdf_values *values);
void pm_bsdf_values_take_nodes(struct pm_bsdf_values *values, struct pm_tree_nodes *nodes);

/* A decimal number; false for anything else, and for one that a float cannot hold. */
bool pm_bsdf_number(const char *text, size_t size, double *value);

#endif
