#include "generate/functions.h"

#include <stdio.h>
#include <string.h>

/* What an expression is called in the language. */
static void function_name(char out[32], unsigned index)
{
    snprintf(out, 32, "generated_%u", index + 1);
}

/* An error without a place is about the word; one with a place is in a file. */
static pm_status place_error(pm_functions *f, size_t word, const pm_error *why)
{
    pm_generation *g = f->g;
    if (why->file[0])
        return pm_error_set_at(g->err, why->status, why->file, why->line, why->column, "%s",
                               why->text);
    return pm_generation_fail(g, word, why->status, "%s", why->text);
}

static pm_status start(pm_functions *f)
{
    if (!f->language)
        f->language = pm_language_new(PM_LANGUAGE_GENERATOR);
    return f->language
               ? PM_OK
               : pm_error_set(f->g->err, PM_E_MEMORY, "not enough memory for functions");
}

/* Takes from the budget of functions. */
static pm_status spend(const pm_functions *f, uint64_t work)
{
    uint64_t *left = f->g->request->work;
    if (!left)
        return PM_OK;
    if (*left < work)
        return pm_generation_fail(f->g, 0, PM_E_LIMIT,
                                  "the functions of this scene's commands take too long; make "
                                  "fewer parts, or simpler functions");
    *left -= work;
    return PM_OK;
}

static pm_status define(pm_functions *f, size_t word, const char *text, size_t size,
                        const char *file)
{
    pm_error why = PM_ERROR_INIT;
    const struct pm_language_text place = {text, file, file != NULL, file != NULL};
    pm_status st = start(f);
    if (!st)
        st = spend(f, size);
    if (st)
        return st;
    st = pm_language_define(f->language, PM_CONTEXT_GLOBAL, &place, size, &why);
    return st ? place_error(f, word, &why) : PM_OK;
}

/* ---- options ---- */

static pm_status read_file(pm_functions *f, size_t word)
{
    const pm_generate_request *request = f->g->request;
    const char *name = request->words[word];
    pm_generate_file file = {0};
    if (request->find)
        file = request->find(request->find_context, name);
    if (!file.data)
        file.data = pm_language_standard(name, &file.size);
    if (!file.data)
        return pm_generation_fail(f->g, word, PM_E_MISSING,
                                  "there is no function file '%.60s', neither beside this file "
                                  "nor beside the main file",
                                  name);
    return define(f, word, file.data, file.size, name);
}

static pm_status take_definitions(pm_functions *f, const char *option)
{
    pm_generation *g = f->g;
    const char *word = pm_generation_word(g);
    if (!word)
        return pm_generation_fail(g, g->at - 1, PM_E_SYNTAX, "%s takes %s; nothing follows it",
                                  option, option[1] == 'e' ? "definitions" : "a file");
    size_t at = g->at++;
    return option[1] == 'f' ? read_file(f, at) : define(f, at, word, strlen(word), NULL);
}

pm_status pm_functions_options(pm_functions *f, const char *others, pm_take_switch *take,
                               void *context)
{
    pm_generation *g = f->g;
    pm_status st = PM_OK;
    for (const char *option; !st && (option = pm_generation_word(g));) {
        bool known = strcmp(option, "-e") == 0 || strcmp(option, "-f") == 0;
        g->at++;
        if (known)
            st = take_definitions(f, option);
        else if (take)
            st = take(context, option, &known);
        if (!st && !known)
            st = pm_generation_fail(g, g->at - 1, PM_E_SYNTAX,
                                    "'%.60s' is no option; they are %s-e definitions, -f file",
                                    option, others);
    }
    return st;
}

/* ---- functions ---- */

static pm_status define_expression(pm_functions *f, unsigned index, size_t word)
{
    const char *expression = f->g->request->words[word];
    char name[32];
    pm_bytes text = {0};
    function_name(name, index);
    pm_bytes_format(&text, "%s(%s)=", name, f->parameters);
    pm_bytes_text(&text, expression);
    pm_bytes_text(&text, ";");
    pm_status st = pm_bytes_status(&text)
                       ? pm_error_set(f->g->err, PM_E_MEMORY, "not enough memory for functions")
                       : define(f, word, (const char *)text.data, text.size, NULL);
    pm_bytes_clear(&text);
    return st;
}

static pm_status compile(pm_functions *f, const struct pm_language_text *texts, unsigned count,
                         unsigned arg_count, size_t word, pm_function *out)
{
    pm_error why = PM_ERROR_INIT;
    const struct pm_function_request request = {.context = PM_CONTEXT_GLOBAL,
                                                .texts = texts,
                                                .text_count = count,
                                                .arg_count = arg_count};
    pm_status st = pm_language_compile(f->language, &request, out, &why);
    return st ? place_error(f, word, &why) : PM_OK;
}

pm_status pm_functions_compile(pm_functions *f, size_t first, unsigned count, unsigned skip)
{
    char names[PM_FUNCTIONS_MOST][32];
    struct pm_language_text texts[PM_FUNCTIONS_MOST] = {0};
    pm_status st = start(f);
    f->count = count;
    for (unsigned i = 0; !st && i < count; i++) {
        const char *zero = "0";
        f->words[i] = first + i;
        function_name(names[i], i);
        texts[i].text = names[i];
        if (!(skip >> i & 1)) {
            st = define_expression(f, i, first + i);
        } else {
            char text[64];
            int length =
                snprintf(text, sizeof text, "%s(%s)=%s;", names[i], f->parameters, zero);
            st = define(f, first + i, text, (size_t)length, NULL);
        }
        /* One at a time, so that an error is told at its own word. */
        pm_function unused;
        if (!st)
            st = compile(f, &texts[i], 1, f->parameter_count, first + i, &unused);
    }
    if (!st)
        st = compile(f, texts, count, f->parameter_count, first, &f->all);
    unsigned parameters = 0;
    f->has_valid = !st &&
                   pm_language_meaning(f->language, PM_CONTEXT_GLOBAL, "valid", &parameters) ==
                       PM_MEANS_FUNCTION &&
                   parameters == 2 && f->parameter_count == 2;
    const struct pm_language_text valid = {.text = "valid"};
    if (f->has_valid)
        st = compile(f, &valid, 1, 2, 0, &f->valid);
    return st;
}

pm_status pm_functions_count(pm_functions *f, size_t word, const char *what, int64_t *out)
{
    pm_generation *g = f->g;
    const struct pm_language_text text = {.text = g->request->words[word]};
    pm_function function;
    double value = 0;
    pm_status st = start(f);
    if (!st)
        st = compile(f, &text, 1, 0, word, &function);
    if (st)
        return st;
    unsigned faults = pm_function_values(f->language, function, NULL, NULL, 0, &value);
    if (faults || !(value + 0.5 >= 1 && value < INT32_MAX))
        return pm_generation_fail(g, word, PM_E_RANGE,
                                  "'%.60s' is no number of %s; write a whole number above 0",
                                  text.text, what);
    *out = (int64_t)(value + 0.5);
    return PM_OK;
}

pm_status pm_functions_values(const pm_functions *f, const double *parameters, double *out)
{
    uint32_t work;
    unsigned faults = pm_function_values_counted(f->language, f->all, NULL, parameters,
                                                 f->parameter_count, out, &work);
    if (faults & (PM_FAULT_DEPTH | PM_FAULT_WORK))
        return pm_generation_fail(f->g, f->words[0], PM_E_LIMIT,
                                  "the functions call themselves without end; at %s = %g",
                                  f->parameter_count == 1 ? "t" : "s", parameters[0]);
    return spend(f, work);
}

pm_status pm_functions_along(const pm_functions *f, int64_t index, int64_t segments,
                             double *out)
{
    double t = (double)index / (double)segments, *radius = &out[f->count - 1];
    pm_status st = pm_functions_values(f, &t, out);
    if (*radius < 0 && *radius > -1e-9)
        *radius = 0; /* of rounding */
    if (!st && *radius < 0)
        st = pm_generation_fail(f->g, f->words[f->count - 1], PM_E_RANGE,
                                "the radius r(t) is %g at t = %g; it must not be below 0",
                                *radius, t);
    return st;
}

pm_status pm_functions_valid(const pm_functions *f, const double *parameters, bool *out)
{
    double value = 1;
    uint32_t work = 0;
    if (f->has_valid)
        pm_function_values_counted(f->language, f->valid, NULL, parameters, 2, &value, &work);
    *out = value > 0;
    return spend(f, work);
}

void pm_functions_clear(pm_functions *f)
{
    pm_language_free(f->language);
    f->language = NULL;
}
