#ifndef PM_SERVER_JSON_H
#define PM_SERVER_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

/* JSON values, over jansson. Shared by server, worker and client; json.c is the one file that
 * includes jansson.h. A document is owned by who made it; `get` lends. */
typedef struct json_t pm_json;

/* Reads one document of UTF-8. A member given twice is an error. `name` is for messages; the
 * place is in the error. */
PM_MUST_USE pm_status pm_json_parse(const void *text, size_t size, const char *name,
                                    pm_json **out, pm_error *err);

/* The text of a document on one line, or indented; to be freed. NULL if memory is short. */
char *pm_json_text(const pm_json *json);
char *pm_json_pretty(const pm_json *json);

void pm_json_free(pm_json *json); /* NULL is fine */

/* Builds a value as jansson's json_pack: {} objects, [] arrays, s text (s? may be NULL), i int,
 * I long long, f double, b bool, o a value (stolen even on failure; o? may be NULL). NULL if
 * memory is short, a number is not finite or a text is not UTF-8; so one check at the end
 * suffices. */
pm_json *pm_json_pack(const char *format, ...);

/* A number, or null where it is not finite (JSON has no infinity). */
pm_json *pm_json_finite(double value);

/* A text that may not be UTF-8 (it quotes somebody's file): foreign bytes become '?'. */
pm_json *pm_json_quote(const char *text);

pm_json *pm_json_copy(const pm_json *json); /* deep */

/* Both steal `value` in any case and return false if it is NULL or memory is short. */
bool pm_json_put(pm_json *object, const char *name, pm_json *value);
bool pm_json_append(pm_json *array, pm_json *value);

void pm_json_remove(pm_json *object, const char *name);

/* Adds the members of `from` to `object`, replacing those of the same name. */
bool pm_json_merge(pm_json *object, const pm_json *from);

typedef enum pm_json_type {
    PM_JSON_NONE, /* NULL was given */
    PM_JSON_NULL,
    PM_JSON_BOOL,
    PM_JSON_INTEGER,
    PM_JSON_REAL,
    PM_JSON_TEXT,
    PM_JSON_ARRAY,
    PM_JSON_OBJECT,
} pm_json_type;

pm_json_type pm_json_type_of(const pm_json *json);

/* A member, or NULL. `object` may be NULL or no object. */
pm_json *pm_json_get(const pm_json *object, const char *name);
/* Members of a given type; `otherwise` if there is none or it is of another type. */
const char *pm_json_get_text(const pm_json *object, const char *name, const char *otherwise);
double pm_json_get_number(const pm_json *object, const char *name, double otherwise);
int64_t pm_json_get_integer(const pm_json *object, const char *name, int64_t otherwise);
bool pm_json_get_bool(const pm_json *object, const char *name, bool otherwise);

double pm_json_number(const pm_json *json);      /* 0 if it is no number */
int64_t pm_json_integer(const pm_json *json);    /* 0 if it is no integer */
const char *pm_json_string(const pm_json *json); /* NULL if it is no text */
size_t pm_json_length(const pm_json *json);      /* members, elements, or bytes of a text */
pm_json *pm_json_at(const pm_json *array, size_t index);

/* Walks an object: `previous` NULL gives the first name; NULL is the end. */
const char *pm_json_next(pm_json *object, const char *previous);

#endif
