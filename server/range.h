#ifndef PM_SERVER_RANGE_H
#define PM_SERVER_RANGE_H

#include <stdbool.h>
#include <stdint.h>

/* The parts of HTTP that read a request's conditions (RFC 9110, 13 and 14). */

typedef enum pm_range {
    PM_RANGE_ALL, /* no range, or one that a server may leave unread: several parts, other units
                   */
    PM_RANGE_PART,    /* 206 */
    PM_RANGE_NOWHERE, /* 416 */
} pm_range;

/* `header` is the value of Range, or NULL. *first and *length are set in every case but the
 * last. */
pm_range pm_range_parse(const char *header, uint64_t size, uint64_t *first, uint64_t *length);

/* Whether a list of entity tags, as in If-None-Match, holds `tag` (with its quotes) or is "*".
 */
bool pm_tag_listed(const char *header, const char *tag);

#endif
