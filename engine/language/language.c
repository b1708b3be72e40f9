#include "language/language.h"

#include <stdlib.h>

struct pm_language {
    enum pm_language_kind kind;
};

pm_language *pm_language_new(enum pm_language_kind kind)
{
    pm_language *language = calloc(1, sizeof *language);
    if (language)
        language->kind = kind;
    return language;
}

void pm_language_free(pm_language *language)
{
    free(language);
}

pm_status pm_language_read(pm_language *language, const char *name, const char *text,
                           size_t size, uint32_t *context, pm_error *err)
{
    (void)language, (void)text, (void)size, (void)context;
    return pm_error_set_at(err, PM_E_UNSUPPORTED, name, 0, 0,
                           "function files are not read yet");
}

bool pm_language_find(const pm_language *language, const char *name, uint32_t *context)
{
    (void)language, (void)name, (void)context;
    return false;
}

pm_status pm_language_define(pm_language *language, uint32_t context,
                             const struct pm_language_text *text, size_t size, pm_error *err)
{
    (void)language, (void)context, (void)size;
    return pm_error_set_at(err, PM_E_UNSUPPORTED, text->file, text->line, text->column,
                           "definitions are not read yet");
}

enum pm_language_meaning pm_language_meaning(const pm_language *language, uint32_t context,
                                             const char *name, unsigned *parameters)
{
    (void)language, (void)context, (void)name, (void)parameters;
    return PM_MEANS_NOTHING;
}

pm_status pm_language_compile(pm_language *language, const struct pm_function_request *request,
                              pm_function *out, pm_error *err)
{
    (void)language, (void)out;
    return pm_error_set_at(err, PM_E_UNSUPPORTED, request->texts[0].file,
                           request->texts[0].line, request->texts[0].column,
                           "functions are not compiled yet");
}

uint64_t pm_function_uses(const pm_language *language, pm_function function)
{
    (void)language, (void)function;
    return 0;
}

unsigned pm_function_values(const pm_language *language, pm_function function,
                            const struct pm_ray_values *ray, const double *args,
                            unsigned arg_count, double *values)
{
    (void)language, (void)function, (void)ray, (void)args, (void)arg_count;
    values[0] = 0;
    return PM_FAULT_DOMAIN;
}

double pm_function_value(const pm_language *language, pm_function function,
                         const struct pm_ray_values *ray, const double *args,
                         unsigned arg_count)
{
    (void)language, (void)function, (void)ray, (void)args, (void)arg_count;
    return 0;
}

const char *pm_language_standard(const char *name, size_t *size)
{
    (void)name, (void)size;
    return NULL;
}
