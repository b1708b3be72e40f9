#include "files/bsdf_values.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"

bool pm_bsdf_number(const char *text, size_t size, double *value)
{
    return pm_number_real(text, size, value) == PM_NUMBER_OK && fabs(*value) <= 1e30;
}

/* ---- errors ---- */

__attribute__((format(printf, 3, 4))) static bool
wrong(struct pm_bsdf_values *v, pm_status status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(v->message, sizeof v->message, format, args);
    va_end(args);
    v->status = status;
    return false;
}

static bool no_memory(struct pm_bsdf_values *v)
{
    return wrong(v, PM_E_MEMORY, "not enough memory");
}

/* ---- trees ---- */

static uint32_t link_count(const struct pm_bsdf_values *v)
{
    return (uint32_t)(v->links.size / sizeof(uint32_t));
}

static bool reserve_links(struct pm_bsdf_values *v)
{
    const uint32_t none[16] = {0};
    size_t size = sizeof none[0] << v->rank;
    if (v->links.size + size > (size_t)UINT32_MAX)
        return wrong(v, PM_E_LIMIT, "a tensor tree of more than 2^30 branches");
    pm_bytes_append(&v->links, none, size);
    return !v->links.failed || no_memory(v);
}

static bool open_brace(struct pm_bsdf_values *v)
{
    if (v->closed)
        return wrong(v, PM_E_SYNTAX, "the tensor tree is complete, but a '{' follows");
    if (v->depth == PM_TREE_LEVELS + 1)
        return wrong(v, PM_E_LIMIT, "a tensor tree of more than %d levels", PM_TREE_LEVELS);
    if (v->depth > 0) {
        struct pm_bsdf_frame *parent = &v->frame[v->depth - 1];
        if (parent->kind == FRAME_GRID)
            return wrong(v, PM_E_SYNTAX, "a '{' among the values of a tensor tree's grid");
        if (parent->kind == FRAME_EMPTY) {
            *parent = (struct pm_bsdf_frame){FRAME_BRANCH, link_count(v), 0};
            if (!reserve_links(v))
                return false;
        }
        if (parent->children == 1U << v->rank)
            return wrong(v, PM_E_SYNTAX, "a branch of a tensor tree has %u parts, not more",
                         1U << v->rank);
        parent->children++;
    }
    v->frame[v->depth++] = (struct pm_bsdf_frame){FRAME_EMPTY, 0, 0};
    return true;
}

static uint32_t append_node(struct pm_bsdf_values *v, uint32_t first, int32_t level)
{
    struct pm_tree_node node = {first, level};
    uint32_t index = (uint32_t)(v->nodes.size / sizeof node);
    pm_bytes_append(&v->nodes, &node, sizeof node);
    return index;
}

/* A grid of 2^(rank level) values; false for another count. */
static bool close_grid(struct pm_bsdf_values *v, const struct pm_bsdf_frame *f, uint32_t *link)
{
    size_t count = v->count - f->first;
    unsigned level = 0;
    while (level < PM_TREE_LEVELS && (size_t)1 << level * v->rank < count)
        level++;
    if ((size_t)1 << level * v->rank != count)
        return wrong(v, PM_E_SYNTAX, "%zu values in a tensor tree's grid; a power of %u is due",
                     count, 1U << v->rank);
    unsigned depth = v->depth - 1 + level;
    if (depth > PM_TREE_LEVELS)
        return wrong(v, PM_E_LIMIT, "a tensor tree of more than %d levels", PM_TREE_LEVELS);
    v->deepest = depth > v->deepest ? depth : v->deepest;
    *link = level ? append_node(v, f->first, (int32_t)level) : PM_TREE_LEAF | f->first;
    return true;
}

static bool close_brace(struct pm_bsdf_values *v)
{
    if (v->depth == 0)
        return wrong(v, PM_E_SYNTAX, "a '}' without its '{' in a tensor tree");
    const struct pm_bsdf_frame *f = &v->frame[v->depth - 1];
    uint32_t link = 0;
    if (f->kind == FRAME_EMPTY)
        return wrong(v, PM_E_SYNTAX, "an empty '{}' in a tensor tree");
    if (f->kind == FRAME_GRID && !close_grid(v, f, &link))
        return false;
    if (f->kind == FRAME_BRANCH) {
        if (f->children != 1U << v->rank)
            return wrong(v, PM_E_SYNTAX, "%u parts in a branch of a tensor tree; %u are due",
                         f->children, 1U << v->rank);
        link = append_node(v, f->first, -1);
    }
    if (v->nodes.failed)
        return no_memory(v);
    v->depth--;
    v->closed = v->depth == 0;
    if (v->closed) {
        v->root = link;
    } else {
        const struct pm_bsdf_frame *parent = &v->frame[v->depth - 1];
        memcpy(v->links.data + (parent->first + parent->children - 1) * sizeof link, &link,
               sizeof link);
    }
    return true;
}

static bool enter_value(struct pm_bsdf_values *v)
{
    if (!v->rank)
        return true;
    if (v->depth == 0)
        return wrong(v, PM_E_SYNTAX, "a value outside the braces of a tensor tree");
    struct pm_bsdf_frame *f = &v->frame[v->depth - 1];
    if (f->kind == FRAME_BRANCH)
        return wrong(v, PM_E_SYNTAX, "a value among the branches of a tensor tree");
    if (f->kind == FRAME_EMPTY)
        *f = (struct pm_bsdf_frame){FRAME_GRID, (uint32_t)v->count, 0};
    return true;
}

/* ---- the stream ---- */

static bool end_word(struct pm_bsdf_values *v)
{
    double value;
    if (v->length == 0)
        return true;
    if (!pm_bsdf_number(v->word, v->length, &value))
        return wrong(v, PM_E_SYNTAX, "'%.*s' among the ScatteringData is not a number%s",
                     (int)v->length, v->word, v->length == sizeof v->word ? " (cut)" : "");
    v->length = 0;
    if (v->count == (size_t)1 << 30)
        return wrong(v, PM_E_LIMIT, "more than 2^30 values");
    if (!enter_value(v))
        return false;
    float f = value > 0 ? (float)value : 0;
    pm_bytes_append(&v->numbers, &f, sizeof f);
    v->count++;
    return !v->numbers.failed || no_memory(v);
}

static bool add_character(struct pm_bsdf_values *v, char c)
{
    bool brace = c == '{' || c == '}';
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',')
        return end_word(v);
    if (brace && !v->rank)
        return wrong(v, PM_E_SYNTAX, "a '%c' among the values of a matrix", c);
    if (brace)
        return end_word(v) && (c == '{' ? open_brace(v) : close_brace(v));
    if (v->length < sizeof v->word)
        v->word[v->length++] = c;
    else
        return end_word(v); /* too long for a number: says so */
    return true;
}

bool pm_bsdf_values_add(struct pm_bsdf_values *v, const char *text, size_t size)
{
    for (size_t i = 0; i < size; i++)
        if (!add_character(v, text[i])) {
            v->at = (ptrdiff_t)i - (ptrdiff_t)v->length;
            return false;
        }
    return true;
}

bool pm_bsdf_values_end(struct pm_bsdf_values *v)
{
    if (!end_word(v))
        return false;
    if (v->rank && !v->closed)
        return wrong(v, PM_E_SYNTAX,
                     v->depth ? "a tensor tree lacks its '}'"
                              : "ScatteringData without a tensor tree");
    return true;
}

void pm_bsdf_values_clear(struct pm_bsdf_values *v)
{
    pm_bytes_clear(&v->numbers);
    pm_bytes_clear(&v->nodes);
    pm_bytes_clear(&v->links);
    *v = (struct pm_bsdf_values){.rank = 0};
}

/* The bytes, without the room for growth. */
static void *take(pm_bytes *bytes)
{
    void *data = bytes->size ? realloc(bytes->data, bytes->size) : NULL;
    if (!data)
        data = bytes->data;
    *bytes = (pm_bytes){0};
    return data;
}

float *pm_bsdf_values_take(struct pm_bsdf_values *v)
{
    return take(&v->numbers);
}

void pm_bsdf_values_take_nodes(struct pm_bsdf_values *v, struct pm_tree_nodes *nodes)
{
    *nodes = (struct pm_tree_nodes){.node_count =
                                        (uint32_t)(v->nodes.size / sizeof(struct pm_tree_node)),
                                    .link_count = link_count(v),
                                    .value_count = (uint32_t)v->count,
                                    .root = v->root,
                                    .rank = v->rank,
                                    .depth = v->deepest};
    nodes->nodes = take(&v->nodes);
    nodes->links = take(&v->links);
    nodes->values = take(&v->numbers);
}
