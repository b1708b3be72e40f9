#include "json.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

pm_status pm_json_parse(const void *text, size_t size, const char *name, pm_json **out,
                        pm_error *err)
{
    json_error_t where;
    json_t *json = json_loadb(text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &where);
    if (!json && json_error_code(&where) == json_error_out_of_memory)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a JSON document");
    if (!json)
        return pm_error_set_at(err, PM_E_SYNTAX, name, where.line > 0 ? where.line : 1,
                               where.column > 0 ? where.column : 1, "%s", where.text);
    *out = json;
    return PM_OK;
}

char *pm_json_text(const pm_json *json)
{
    return json_dumps(json, JSON_COMPACT | JSON_ENCODE_ANY);
}

char *pm_json_pretty(const pm_json *json)
{
    return json_dumps(json, JSON_INDENT(2) | JSON_ENCODE_ANY);
}

void pm_json_free(pm_json *json)
{
    json_decref(json);
}

pm_json *pm_json_pack(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    json_t *json = json_vpack_ex(NULL, 0, format, args);
    va_end(args);
    return json;
}

pm_json *pm_json_finite(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

pm_json *pm_json_quote(const char *text)
{
    json_t *json = json_string(text);
    char *copy = json ? NULL : strdup(text);
    if (!copy)
        return json;
    for (char *c = copy; *c; c++)
        if ((unsigned char)*c > 126)
            *c = '?';
    json = json_string(copy);
    free(copy);
    return json;
}

pm_json *pm_json_copy(const pm_json *json)
{
    return json_deep_copy(json);
}

bool pm_json_put(pm_json *object, const char *name, pm_json *value)
{
    return json_object_set_new(object, name, value) == 0;
}

bool pm_json_append(pm_json *array, pm_json *value)
{
    return json_array_append_new(array, value) == 0;
}

void pm_json_remove(pm_json *object, const char *name)
{
    json_object_del(object, name);
}

bool pm_json_merge(pm_json *object, const pm_json *from)
{
    json_t *copy = json_deep_copy(from);
    bool merged = copy && json_object_update(object, copy) == 0;
    json_decref(copy);
    return merged;
}

pm_json_type pm_json_type_of(const pm_json *json)
{
    if (!json)
        return PM_JSON_NONE;
    switch (json_typeof(json)) {
    case JSON_OBJECT:
        return PM_JSON_OBJECT;
    case JSON_ARRAY:
        return PM_JSON_ARRAY;
    case JSON_STRING:
        return PM_JSON_TEXT;
    case JSON_INTEGER:
        return PM_JSON_INTEGER;
    case JSON_REAL:
        return PM_JSON_REAL;
    case JSON_TRUE:
    case JSON_FALSE:
        return PM_JSON_BOOL;
    case JSON_NULL:
        break;
    }
    return PM_JSON_NULL;
}

pm_json *pm_json_get(const pm_json *object, const char *name)
{
    return json_object_get(object, name);
}

const char *pm_json_get_text(const pm_json *object, const char *name, const char *otherwise)
{
    const json_t *value = json_object_get(object, name);
    return json_is_string(value) ? json_string_value(value) : otherwise;
}

double pm_json_get_number(const pm_json *object, const char *name, double otherwise)
{
    const json_t *value = json_object_get(object, name);
    return json_is_number(value) ? json_number_value(value) : otherwise;
}

int64_t pm_json_get_integer(const pm_json *object, const char *name, int64_t otherwise)
{
    const json_t *value = json_object_get(object, name);
    return json_is_integer(value) ? json_integer_value(value) : otherwise;
}

bool pm_json_get_bool(const pm_json *object, const char *name, bool otherwise)
{
    const json_t *value = json_object_get(object, name);
    return json_is_boolean(value) ? json_is_true(value) : otherwise;
}

double pm_json_number(const pm_json *json)
{
    return json_number_value(json);
}

int64_t pm_json_integer(const pm_json *json)
{
    return json_integer_value(json);
}

const char *pm_json_string(const pm_json *json)
{
    return json_string_value(json);
}

size_t pm_json_length(const pm_json *json)
{
    if (json_is_string(json))
        return json_string_length(json);
    return json_is_array(json) ? json_array_size(json) : json_object_size(json);
}

pm_json *pm_json_at(const pm_json *array, size_t index)
{
    return json_array_get(array, index);
}

const char *pm_json_next(pm_json *object, const char *previous)
{
    void *at = previous ? json_object_iter_next(object, json_object_key_to_iter(previous))
                        : json_object_iter(object);
    return json_object_iter_key(at);
}
