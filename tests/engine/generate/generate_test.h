#ifndef GENERATE_TEST_H
#define GENERATE_TEST_H

/* What the tests of engine/generate share: they read the primitives back that a command makes.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/bytes.h"
#include "base/maths.h"
#include "generate/generate.h"

enum { WORDS_MOST = 64, REALS_MOST = 64 };

/* A command split at blanks; a word in '' keeps them. */
struct command {
    char text[1000];
    const char *words[WORDS_MOST];
    size_t count;
};

static inline void split(const char *text, struct command *c)
{
    snprintf(c->text, sizeof c->text, "%s", text);
    c->count = 0;
    for (char *at = c->text; *at;) {
        char end = *at == '\'' ? '\'' : ' ';
        at += end == '\'';
        assert_true(c->count < WORDS_MOST);
        c->words[c->count++] = at;
        at += strcspn(at, end == ' ' ? " " : "'");
        if (*at)
            *at++ = '\0';
        at += strspn(at, " ");
    }
}

static inline pm_generate_request request_of(const char *text, struct command *c)
{
    split(text, c);
    return (pm_generate_request){.words = c->words, .count = c->count};
}

static inline pm_status append_text(void *context, const void *text, size_t size)
{
    pm_bytes_append(context, text, size);
    return PM_OK;
}

struct made {
    char modifier[40], type[40], name[40];
    size_t real_count;
    double reals[REALS_MOST];
};

struct scene {
    struct made *items;
    size_t count;
    pm_generate_size size; /* as measured */
    size_t bytes;          /* of text */
};

static inline char *next(char **at)
{
    char *word = strtok_r(NULL, " \n", at);
    if (!word)
        fail_msg("the text breaks off");
    return word;
}

static inline void read_primitive(const char *modifier, char **at, struct made *out)
{
    snprintf(out->modifier, sizeof out->modifier, "%s", modifier);
    snprintf(out->type, sizeof out->type, "%s", next(at));
    snprintf(out->name, sizeof out->name, "%s", next(at));
    for (int strings = atoi(next(at)); strings > 0; strings--)
        next(at);
    assert_string_equal(next(at), "0");
    out->real_count = (size_t)atoi(next(at));
    assert_in_range(out->real_count, 0, REALS_MOST);
    for (size_t i = 0; i < out->real_count; i++)
        out->reals[i] = strtod(next(at), NULL);
}

/* What a command makes that must be right. */
static inline struct scene make_with(const pm_generate_request *request)
{
    struct scene scene = {0};
    pm_bytes text = {0};
    size_t wrong;
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_generate_measure(request, &scene.size, &wrong, &err);
    if (!st)
        st = pm_generate_run(request, append_text, &text, &wrong, &err);
    if (st)
        fail_msg("word %zu: %s", wrong, err.text);
    scene.bytes = text.size;
    pm_bytes_u8(&text, 0);
    scene.items = calloc(scene.size.primitives + 1, sizeof *scene.items);
    char *at, *word = strtok_r((char *)text.data, " \n", &at);
    for (; word; word = strtok_r(NULL, " \n", &at)) {
        assert_true(scene.count < scene.size.primitives);
        read_primitive(word, &at, &scene.items[scene.count++]);
    }
    pm_bytes_clear(&text);
    return scene;
}

static inline struct scene make(const char *text)
{
    struct command command;
    pm_generate_request request = request_of(text, &command);
    return make_with(&request);
}

static inline void free_scene(struct scene *scene)
{
    free(scene->items);
}

static inline size_t count_type(const struct scene *scene, const char *type)
{
    size_t count = 0;
    for (size_t i = 0; i < scene->count; i++)
        count += strcmp(scene->items[i].type, type) == 0;
    return count;
}

static inline const struct made *named(const struct scene *scene, const char *name)
{
    for (size_t i = 0; i < scene->count; i++)
        if (strcmp(scene->items[i].name, name) == 0)
            return &scene->items[i];
    fail_msg("nothing is named %s", name);
    return NULL;
}

#define assert_near(a, b, tolerance)                                                           \
    do {                                                                                       \
        double a_ = (a), b_ = (b);                                                             \
        if (!(fabs(a_ - b_) <= (tolerance)))                                                   \
            fail_msg("%s is %.12g, not %.12g", #a, a_, b_);                                    \
    } while (0)

/* The vector area of a polygon, and by the divergence theorem its share of the volume that a
 * closed surface encloses. */
static inline void polygon_area(const struct made *p, double area[3])
{
    const double *v = p->reals;
    memset(area, 0, 3 * sizeof *area);
    for (size_t i = 3; i + 3 < p->real_count; i += 3)
        for (int j = 0; j < 3; j++) {
            int k = (j + 1) % 3, l = (j + 2) % 3;
            area[j] += 0.5 * ((v[i + (size_t)k] - v[k]) * (v[i + 3 + (size_t)l] - v[l]) -
                              (v[i + (size_t)l] - v[l]) * (v[i + 3 + (size_t)k] - v[k]));
        }
}

static inline double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static inline double total_area(const struct scene *scene)
{
    double sum = 0, area[3];
    for (size_t i = 0; i < scene->count; i++) {
        if (strcmp(scene->items[i].type, "polygon") != 0)
            continue;
        polygon_area(&scene->items[i], area);
        sum += length(area);
    }
    return sum;
}

static inline double enclosed_volume(const struct scene *scene)
{
    double sum = 0, area[3];
    for (size_t i = 0; i < scene->count; i++) {
        const struct made *p = &scene->items[i];
        if (strcmp(p->type, "polygon") != 0)
            continue;
        polygon_area(p, area);
        sum += (p->reals[0] * area[0] + p->reals[1] * area[1] + p->reals[2] * area[2]) / 3;
    }
    return sum;
}

/* A command that must be refused, with this message about this word. */
static inline void assert_refused(const char *text, pm_status expected, size_t expected_word,
                                  const char *message)
{
    struct command command;
    pm_generate_request request = request_of(text, &command);
    pm_generate_size size = {7, 7, 7};
    size_t wrong = 99;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_generate_measure(&request, &size, &wrong, &err), expected);
    assert_string_equal(err.text, message);
    assert_int_equal(wrong, expected_word);
    assert_int_equal(size.primitives, 7);
}

#endif
