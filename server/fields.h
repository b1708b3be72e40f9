#ifndef PM_SERVER_FIELDS_H
#define PM_SERVER_FIELDS_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "json.h"

/* The one table of what can be said in a request: name, type, range, unit, default and meaning.
 * It checks requests, writes the OpenAPI document, and gives the client its options' ranges. */

typedef enum pm_field_type {
    PM_FIELD_INTEGER, /* low..high, both allowed */
    PM_FIELD_NUMBER,  /* finite, low..high */
    PM_FIELD_TEXT,    /* at most `high` bytes, without control characters but tab and newline */
    PM_FIELD_CHOICE,  /* one of `choices` */
    PM_FIELD_CHOICES, /* a list of them, each at most once */
    PM_FIELD_DIGEST,  /* 64 lower-case hexadecimal digits */
    PM_FIELD_VECTOR,  /* `size` finite numbers, low..high */
    PM_FIELD_TEXTS,   /* a list of texts of low..high bytes each */
    PM_FIELD_OBJECTS, /* a list of objects of `members` */
    PM_FIELD_SWITCH,  /* true or false */
    PM_FIELD_OBJECT,  /* of `members` */
    PM_FIELD_VIEW,    /* an object of `members`, or the same as text with rpict's options */
} pm_field_type;

/* Entries of a list of texts or objects, 1 to so many. */
enum { PM_FIELD_LIST_MAX = 1024 };

typedef struct pm_field {
    const char *name;
    pm_field_type type;
    double low, high;
    const char *unit;      /* "" if it has none */
    const char *otherwise; /* the default as JSON text; NULL if there is none */
    const char *doc;
    const char *const *choices;     /* ended by NULL */
    const struct pm_field *members; /* ended by a NULL name */
    bool required;
    unsigned size; /* of a vector; 0 means 3 */
} pm_field;

/* Each is ended by a field whose name is NULL. */
extern const pm_field pm_fields_job[];   /* POST /v1/jobs */
extern const pm_field pm_fields_scene[]; /* POST /v1/scenes */
extern const pm_field pm_fields_map[];   /* a member "global", ..., "direct" of a job */
extern const pm_field pm_fields_precomputed[]; /* its member "precomputed" */
extern const pm_field pm_fields_view[];
extern const pm_field pm_fields_medium[]; /* of "medium" */
extern const pm_field pm_fields_region[]; /* of the list "regions" */

const pm_field *pm_field_find(const pm_field *fields, const char *name); /* or NULL */

/* Checks a request against a table. The error's `file` is the member, e.g. "global.count".
 * PM_E_RANGE for a value out of range or of another type, PM_E_UNSUPPORTED for a member that is
 * not in the table, PM_E_MISSING for one that must be there. */
PM_MUST_USE pm_status pm_fields_check(const pm_field *fields, pm_json *object, pm_error *err);

/* Checks a number that came from elsewhere, e.g. a command line. `name` is for the message. */
PM_MUST_USE pm_status pm_field_check_number(const pm_field *field, double value,
                                            const char *name, pm_error *err);

/* The JSON schema (OpenAPI 3.1) of a table; NULL if memory is short. */
pm_json *pm_fields_schema(const pm_field *fields);

#endif
