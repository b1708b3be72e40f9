/* Reads the input as a function file whose last line is an expression, compiles that in its
 * context as an expression, with and without real arguments, and as the name of a function, and
 * checks what the header promises of errors and values. LLVM's libFuzzer calls it, and
 * replay.c. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "language/language.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_error(const pm_error *err, pm_status st)
{
    check(err->status == st && err->text[0]);
    check(memchr(err->text, '\0', sizeof err->text) != NULL);
    check(err->line >= 0 && err->column >= 0);
}

static void evaluate(const pm_language *language, pm_function function, const double *args,
                     unsigned arg_count)
{
    static const double reals[3] = {.5, 2, -1};
    for (int i = 0; i < 3; i++) {
        struct pm_ray_values ray = {.reals = reals, .real_count = (uint32_t)i};
        double value;
        for (int k = 0; k < PM_RAY_VALUES; k++)
            ray.value[k] = i * (.75 - k % 5 * .4);
        unsigned faults = pm_function_values(language, function, &ray, args, arg_count, &value);
        check(isfinite(value) && faults < 64);
        double again = pm_function_value(language, function, &ray, args, arg_count);
        check(memcmp(&again, &value, sizeof value) == 0);
    }
}

static void compile(pm_language *language, uint32_t context, const char *text,
                    unsigned arg_count, const double *reals)
{
    static const double args[2] = {.25, 3};
    const struct pm_language_text where = {text, "main.rad", 1, 1};
    const struct pm_function_request request = {.context = context,
                                                .texts = &where,
                                                .text_count = 1,
                                                .arg_count = arg_count,
                                                .reals = reals,
                                                .real_count = reals ? 2 : 0};
    pm_error err = PM_ERROR_INIT;
    pm_function function, same;
    pm_status st = pm_language_compile(language, &request, &function, &err);
    if (st) {
        check_error(&err, st);
        return;
    }
    check(!pm_language_compile(language, &request, &same, &err));
    evaluate(language, function, args, arg_count);
    evaluate(language, same, args, arg_count);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const double reals[2] = {.25, 4};
    pm_error err = PM_ERROR_INIT;
    uint32_t context = 7;
    char line[200] = "";
    size_t end = size;
    while (end > 0 && data[end - 1] != '\n')
        end--;
    if (size - end < sizeof line)
        memcpy(line, data + end, size - end);
    pm_language *language = pm_language_new(PM_LANGUAGE_SCENE);
    check(language != NULL);
    pm_status st = pm_language_read(language, "f.cal", (const char *)data, end, &context, &err);
    if (st) {
        check_error(&err, st);
        check(context == 7);
    } else {
        compile(language, context, line, 0, NULL);
        compile(language, context, line, 0, reals);
        compile(language, context, line, 2, NULL);
    }
    pm_language_free(language);
    return 0;
}
