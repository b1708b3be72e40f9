#include "language/language.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "language/language_internal.h"

#define NONE UINT32_MAX
enum { FILE_NAME_MAX = 255 };

/* Expressions that were compiled before: by text, and then by real arguments. */
struct pm_request {
    struct pm_request *next;
    uint32_t hash;
    pm_function function;   /* NONE if it depends on the real arguments */
    struct pm_node **nodes; /* the trees of the texts */
    size_t size;
    unsigned char key[];
};

bool pm_language_grow(void **array, uint32_t count, uint32_t *size, size_t element)
{
    if (count < *size)
        return true;
    uint32_t larger = *size ? 2 * *size : 16;
    void *grown = realloc(*array, larger * element);
    if (!grown)
        return false;
    *array = grown;
    *size = larger;
    return true;
}

pm_status pm_language_error(const pm_language *language, pm_error *err, pm_status status,
                            uint32_t source, int line, int column, const char *format, ...)
{
    char text[sizeof err->text];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return pm_error_set_at(err, status, language->sources[source], line, column, "%s", text);
}

uint32_t pm_language_source(pm_language *language, const char *label)
{
    label = label ? label : "";
    for (uint32_t i = language->source_count; i > 0; i--)
        if (strcmp(language->sources[i - 1], label) == 0)
            return i - 1;
    char *copy = pm_arena_text(&language->arena, label, strlen(label));
    if (!copy || !pm_language_grow((void **)&language->sources, language->source_count,
                                   &language->source_size, sizeof *language->sources))
        return NONE;
    language->sources[language->source_count] = copy;
    return language->source_count++;
}

static pm_status no_memory(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "not enough memory for function files");
}

/* ---- Contexts ---- */

/* The mark of a file's names: its name without .cal, what no name can hold replaced, and told
 * apart from those of other files. */
static void make_mark(const pm_language *language, const char *name,
                      char mark[2 * FILE_NAME_MAX])
{
    size_t length = strlen(name);
    if (length > 4 && strcmp(name + length - 4, ".cal") == 0)
        length -= 4;
    size_t at = 0;
    mark[at++] = '`';
    for (size_t i = 0; i < length; i++) {
        char c = name[i];
        bool fit = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                   c == '.' || c == '_';
        mark[at++] = fit ? c : '_';
    }
    mark[at] = '\0';
    for (uint32_t i = 0; i < language->context_count; i++)
        if (strcmp(language->contexts[i].mark, mark) == 0 && at + 2 < 2 * FILE_NAME_MAX) {
            mark[at++] = '_';
            mark[at] = '\0';
            i = 0;
        }
}

static pm_status add_context(pm_language *language, const char *file, const char *mark,
                             pm_error *err)
{
    char *own_file = pm_arena_text(&language->arena, file, strlen(file));
    char *own_mark = pm_arena_text(&language->arena, mark, strlen(mark));
    if (!own_file || !own_mark ||
        !pm_language_grow((void **)&language->contexts, language->context_count,
                          &language->context_size, sizeof *language->contexts))
        return no_memory(err);
    language->contexts[language->context_count++] = (struct pm_context){own_file, own_mark};
    return PM_OK;
}

bool pm_language_find(const pm_language *language, const char *name, uint32_t *context)
{
    if (strcmp(name, ".") == 0) {
        *context = PM_CONTEXT_GLOBAL;
        return true;
    }
    for (uint32_t i = 1; i < language->context_count; i++)
        if (strcmp(language->contexts[i].file, name) == 0) {
            *context = i;
            return true;
        }
    return false;
}

pm_status pm_language_define(pm_language *language, uint32_t context,
                             const struct pm_language_text *text, size_t size, pm_error *err)
{
    uint32_t source = pm_language_source(language, text->file);
    if (source == NONE)
        return no_memory(err);
    return pm_parse_definitions(language, context, source, text->line, text->column, text->text,
                                size, err);
}

pm_status pm_language_read(pm_language *language, const char *name, const char *text,
                           size_t size, uint32_t *context, pm_error *err)
{
    char mark[2 * FILE_NAME_MAX];
    if (pm_language_find(language, name, context))
        return PM_OK;
    if (strlen(name) > FILE_NAME_MAX)
        return pm_error_set_at(err, PM_E_LIMIT, name, 0, 0,
                               "the name of a function file has at most %d characters",
                               FILE_NAME_MAX);
    make_mark(language, name, mark);
    pm_status st = add_context(language, name, mark, err);
    if (st)
        return st;
    const struct pm_language_text whole = {text, name, 1, 1};
    uint32_t made = language->context_count - 1;
    st = pm_language_define(language, made, &whole, size, err);
    if (st) {
        language->context_count--;
        return st;
    }
    *context = made;
    return PM_OK;
}

enum pm_language_meaning pm_language_meaning(const pm_language *language, uint32_t context,
                                             const char *name, unsigned *parameters)
{
    const struct pm_name *found =
        pm_name_find(language, language->contexts[context].mark, name);
    const struct pm_builtin *builtin =
        found ? found->builtin : pm_builtin_find(language->kind, name);
    const struct pm_definition *definition = found ? found->definition : NULL;
    if (definition && definition->parameter_count == 0)
        return PM_MEANS_VARIABLE;
    if (!definition && !builtin)
        return PM_MEANS_NOTHING;
    *parameters = definition ? definition->parameter_count : builtin->least;
    return PM_MEANS_FUNCTION;
}

/* ---- Making ---- */

/* The ray's values by name, in the order of enum pm_ray_value. */
static const char scene_names[] =
    "Dx=$1;Dy=$2;Dz=$3;Nx=$4;Ny=$5;Nz=$6;Px=$7;Py=$8;Pz=$9;T=$10;Rdot=$11;S=$12;"
    "Tx=$13;Ty=$14;Tz=$15;Ix=$16;Iy=$17;Iz=$18;Jx=$19;Jy=$20;Jz=$21;Kx=$22;Ky=$23;Kz=$24;"
    "Ts=$25;Lu=$26;Lv=$27;NxP=$28;NyP=$29;NzP=$30;RdotP=$31;CrP=$32;CgP=$33;CbP=$34;"
    "DxA=$35;DyA=$36;DzA=$37;";

static pm_status define_text(pm_language *language, const char *label, const char *text,
                             size_t size, pm_error *err)
{
    const struct pm_language_text whole = {text, label, 1, 1};
    return pm_language_define(language, PM_CONTEXT_GLOBAL, &whole, size, err);
}

static pm_status define_standard(pm_language *language, const char *name, pm_error *err)
{
    size_t size = 0;
    const char *text = pm_language_standard(name, &size);
    return define_text(language, name, text, size, err);
}

static pm_status prepare(pm_language *language, pm_error *err)
{
    bool scene = language->kind == PM_LANGUAGE_SCENE;
    pm_status st = add_context(language, "", "", err);
    if (!st)
        st = define_text(language, "values of the ray", scene ? scene_names : "",
                         scene ? strlen(scene_names) : 0, err);
    if (!st)
        st = define_standard(language, scene ? "rayinit.cal" : "generator.cal", err);
    return st;
}

pm_language *pm_language_new(enum pm_language_kind kind)
{
    pm_language *language = calloc(1, sizeof *language);
    pm_error err = PM_ERROR_INIT;
    if (!language)
        return NULL;
    language->kind = kind;
    if (prepare(language, &err)) {
        pm_language_free(language);
        return NULL;
    }
    return language;
}

void pm_language_free(pm_language *language)
{
    if (!language)
        return;
    pm_arena_clear(&language->arena);
    free(language->names);
    free(language->contexts);
    free(language->sources);
    free(language->programs);
    free(language->requests);
    free(language);
}

/* ---- Requests ---- */

static uint32_t hash_bytes(const unsigned char *data, size_t size)
{
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ data[i]) * 16777619u;
    return hash ^ hash >> 15;
}

static struct pm_request *find_request(const pm_language *language, const pm_bytes *key,
                                       uint32_t hash)
{
    if (!language->request_size)
        return NULL;
    struct pm_request *request = language->requests[hash & (language->request_size - 1)];
    while (request && (request->hash != hash || request->size != key->size ||
                       memcmp(request->key, key->data, key->size) != 0))
        request = request->next;
    return request;
}

static bool grow_requests(pm_language *language)
{
    uint32_t size = language->request_size ? 2 * language->request_size : 64;
    struct pm_request **table = calloc(size, sizeof *table);
    if (!table)
        return false;
    for (uint32_t i = 0; i < language->request_size; i++)
        for (struct pm_request *request = language->requests[i], *next; request;
             request = next) {
            next = request->next;
            request->next = table[request->hash & (size - 1)];
            table[request->hash & (size - 1)] = request;
        }
    free(language->requests);
    language->requests = table;
    language->request_size = size;
    return true;
}

/* The request of this key, made if there is none. NULL if memory is short. */
static struct pm_request *get_request(pm_language *language, const pm_bytes *key)
{
    uint32_t hash = hash_bytes(key->data, key->size);
    struct pm_request *request = find_request(language, key, hash);
    if (request)
        return request;
    if (language->request_count >= language->request_size && !grow_requests(language))
        return NULL;
    request = pm_arena_alloc(&language->arena, sizeof *request + key->size);
    if (!request)
        return NULL;
    request->hash = hash;
    request->function = NONE;
    request->size = key->size;
    memcpy(request->key, key->data, key->size);
    struct pm_request **head = &language->requests[hash & (language->request_size - 1)];
    request->next = *head;
    *head = request;
    language->request_count++;
    return request;
}

static pm_status parse_texts(pm_language *language, struct pm_request *parsed,
                             const struct pm_function_request *request, pm_error *err)
{
    struct pm_node **nodes =
        pm_arena_array(&language->arena, request->text_count, sizeof *nodes);
    if (!nodes)
        return no_memory(err);
    for (unsigned i = 0; i < request->text_count; i++) {
        const struct pm_language_text *text = request->texts + i;
        uint32_t source = pm_language_source(language, text->file);
        if (source == NONE)
            return no_memory(err);
        pm_status st =
            pm_parse_expression(language, request->context, source, text->line, text->column,
                                text->text, strlen(text->text), &nodes[i], err);
        if (st)
            return st;
    }
    parsed->nodes = nodes;
    return PM_OK;
}

static pm_status add_program(pm_language *language, struct pm_node *const *nodes,
                             const struct pm_function_request *request, pm_function *out,
                             bool *asked_reals, pm_error *err)
{
    struct pm_program *program;
    if (!pm_language_grow((void **)&language->programs, language->program_count,
                          &language->program_size, sizeof *language->programs))
        return no_memory(err);
    pm_status st = pm_program_compile(language, nodes, request, &program, asked_reals, err);
    if (st)
        return st;
    language->programs[language->program_count] = program;
    *out = language->program_count++;
    return PM_OK;
}

/* What compile does with the key in a buffer that the caller frees. */
static pm_status compile_keyed(pm_language *language, struct pm_function_request *request,
                               pm_bytes *key, pm_function *out, pm_error *err)
{
    bool asked_reals;
    pm_bytes_u8(key, 'p');
    pm_bytes_u32(key, request->text_count);
    pm_bytes_u32(key, request->context);
    pm_bytes_u32(key, request->arg_count);
    for (unsigned i = 0; i < request->text_count; i++)
        pm_bytes_append(key, request->texts[i].text, strlen(request->texts[i].text) + 1);
    struct pm_request *parsed = key->failed ? NULL : get_request(language, key);
    if (!parsed)
        return no_memory(err);
    pm_status st = parsed->nodes ? PM_OK : parse_texts(language, parsed, request, err);
    if (st)
        return st;
    if (parsed->function != NONE) {
        *out = parsed->function;
        return PM_OK;
    }
    if (!key->failed)
        key->data[0] = request->reals ? 'r' : 'g';
    if (request->reals)
        pm_bytes_append(key, request->reals, request->real_count * sizeof *request->reals);
    struct pm_request *known = key->failed ? NULL : get_request(language, key);
    if (!known)
        return no_memory(err);
    if (known->function == NONE) {
        st = add_program(language, parsed->nodes, request, &known->function, &asked_reals, err);
        if (st)
            return st;
        if (!asked_reals)
            parsed->function = known->function;
    }
    *out = known->function;
    return PM_OK;
}

pm_status pm_language_compile(pm_language *language, const struct pm_function_request *request,
                              pm_function *out, pm_error *err)
{
    pm_error own = PM_ERROR_INIT;
    pm_bytes key = {0};
    struct pm_function_request wanted = *request;
    if (language->code_ops > PM_LANGUAGE_OWN_REALS)
        wanted.reals = NULL;
    pm_status st = compile_keyed(language, &wanted, &key, out, err ? err : &own);
    pm_bytes_clear(&key);
    return st;
}

uint64_t pm_function_uses(const pm_language *language, pm_function function)
{
    return language->programs[function]->uses & ((1ull << PM_RAY_VALUES) - 1);
}
