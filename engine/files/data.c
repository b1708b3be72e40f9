#include "files/data.h"

#include <math.h>
#include <stdbool.h>

#include "base/arena.h"
#include "files/words.h"

enum { COUNT_MAX = 1 << 30 };

struct pm_data {
    pm_arena arena; /* everything, this struct included */
    unsigned dimensions;
    pm_data_axis axis[PM_DATA_DIMENSIONS];
    const double *values;
};

/* ---- reading ---- */

struct reading {
    pm_words words;
    struct pm_data data;
    pm_error *err;
};

static pm_status memory_error(struct reading *r)
{
    return pm_error_set_at(r->err, PM_E_MEMORY, r->words.file, 0, 0,
                           "not enough memory for the data");
}

/* Whether the rest of the file can hold `count` numbers. */
static bool fits(const struct reading *r, size_t count)
{
    return count <= (pm_words_left(&r->words) + 1) / 2;
}

static pm_status read_ordinates(struct reading *r, pm_data_axis *axis)
{
    if (!fits(r, axis->count))
        return pm_words_error(&r->words, PM_E_SYNTAX, r->err,
                              "the file ends before its %u ordinates", axis->count);
    double *p = pm_arena_array(&r->data.arena, axis->count, sizeof *p);
    if (!p)
        return memory_error(r);
    for (uint32_t i = 0; i < axis->count; i++) {
        pm_status st = pm_words_real(&r->words, "an ordinate", &p[i], r->err);
        if (st)
            return st;
        if (i > 0 && (p[i] == p[i - 1] || (p[i] > p[i - 1]) != (p[1] > p[0])))
            return pm_words_error(&r->words, PM_E_RANGE, r->err,
                                  "ordinates must all rise or all fall, but %.9g follows %.9g",
                                  p[i], p[i - 1]);
    }
    axis->ordinates = p;
    axis->first = p[0];
    axis->last = p[axis->count - 1];
    return PM_OK;
}

/* Differences of coordinates are divided by. */
static pm_status check_width(struct reading *r, const pm_data_axis *axis)
{
    if (isfinite(axis->last - axis->first))
        return PM_OK;
    return pm_words_error(&r->words, PM_E_RANGE, r->err,
                          "a dimension from %.9g to %.9g is too wide", axis->first, axis->last);
}

static pm_status read_axis(struct reading *r, pm_data_axis *axis)
{
    int64_t count = 0;
    pm_status st =
        pm_words_real(&r->words, "the beginning of a dimension", &axis->first, r->err);
    if (!st)
        st = pm_words_real(&r->words, "the end of a dimension", &axis->last, r->err);
    if (!st)
        st = pm_words_integer(&r->words, "the number of points in a dimension", 2, COUNT_MAX,
                              &count, r->err);
    if (st)
        return st;
    axis->count = (uint32_t)count;
    if (axis->first == axis->last)
        st = read_ordinates(r, axis);
    return st ? st : check_width(r, axis);
}

static pm_status count_values(struct reading *r, size_t *out)
{
    size_t count = 1;
    for (unsigned d = 0; d < r->data.dimensions; d++)
        if (__builtin_mul_overflow(count, (size_t)r->data.axis[d].count, &count))
            count = SIZE_MAX;
    if (!fits(r, count))
        return pm_words_error(&r->words, PM_E_SYNTAX, r->err,
                              "the dimensions announce more values than the file holds");
    *out = count;
    return PM_OK;
}

static pm_status read_values(struct reading *r)
{
    size_t count = 0;
    pm_status st = count_values(r, &count);
    if (st)
        return st;
    double *values = pm_arena_array(&r->data.arena, count, sizeof *values);
    if (!values)
        return memory_error(r);
    for (size_t i = 0; i < count && !st; i++)
        st = pm_words_real(&r->words, "a value", &values[i], r->err);
    if (!st && pm_words_more(&r->words))
        st = pm_words_error(&r->words, PM_E_SYNTAX, r->err,
                            "the dimensions announce %zu values, but more follow", count);
    r->data.values = values;
    return st;
}

static pm_status read_all(struct reading *r)
{
    int64_t dimensions = 0;
    pm_status st = pm_words_integer(&r->words, "the number of dimensions", 1,
                                    PM_DATA_DIMENSIONS, &dimensions, r->err);
    r->data.dimensions = (unsigned)dimensions;
    for (unsigned d = 0; d < r->data.dimensions && !st; d++)
        st = read_axis(r, &r->data.axis[d]);
    return st ? st : read_values(r);
}

pm_status pm_data_read(const void *bytes, size_t size, const char *name, pm_data **out,
                       pm_error *err)
{
    struct reading r = {.err = err};
    pm_status st = pm_words_init(&r.words, bytes, size, name, err);
    if (!st)
        st = read_all(&r);
    pm_data *data = st ? NULL : pm_arena_alloc(&r.data.arena, sizeof *data);
    if (!data) {
        st = st ? st : memory_error(&r);
        pm_arena_clear(&r.data.arena);
        return st;
    }
    *data = r.data;
    *out = data;
    return PM_OK;
}

void pm_data_free(pm_data *data)
{
    if (!data)
        return;
    pm_arena arena = data->arena;
    pm_arena_clear(&arena);
}

/* ---- queries ---- */

unsigned pm_data_dimensions(const pm_data *data)
{
    return data->dimensions;
}

const pm_data_axis *pm_data_axis_of(const pm_data *data, unsigned dimension)
{
    return &data->axis[dimension];
}

/* The last interval that starts before `at`, or at it if the ordinates rise. */
static uint32_t find_interval(const pm_data_axis *axis, double at)
{
    const double *p = axis->ordinates;
    bool rising = axis->last > axis->first;
    uint32_t low = 0, high = axis->count - 1;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (rising ? at >= p[middle] : at < p[middle])
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Position in units of intervals, and the interval that counts there. */
static double find_position(const pm_data_axis *axis, double at, uint32_t *interval)
{
    uint32_t most = axis->count - 2;
    if (axis->ordinates) {
        const double *p = axis->ordinates;
        uint32_t i = *interval = find_interval(axis, at);
        return i + (at - p[i]) / (p[i + 1] - p[i]);
    }
    double x = (at - axis->first) / (axis->last - axis->first) * (axis->count - 1);
    *interval = !(x > 0) ? 0 : x >= most ? most : (uint32_t)x;
    return x;
}

pm_data_place pm_data_axis_place(const pm_data_axis *axis, double at)
{
    uint32_t i;
    double x = find_position(axis, at, &i) - i;
    if (x > 2)
        return (pm_data_place){i, -1 / (x + 1), 2 / (x + 1)};
    if (x < -1)
        return (pm_data_place){i, -2 / x, 1 / x};
    return (pm_data_place){i, 1 - x, x};
}

double pm_data_value(const pm_data *data, const double *at)
{
    pm_data_place place[PM_DATA_DIMENSIONS];
    for (unsigned d = 0; d < data->dimensions; d++) {
        if (isnan(at[d]))
            return 0;
        place[d] = pm_data_axis_place(&data->axis[d], at[d]);
    }
    double sum = 0;
    for (unsigned corner = 0; corner < 1U << data->dimensions; corner++) {
        size_t index = 0;
        double weight = 1;
        for (unsigned d = 0; d < data->dimensions; d++) {
            unsigned up = corner >> d & 1;
            index = index * data->axis[d].count + place[d].index + up;
            weight *= up ? place[d].high : place[d].low;
        }
        sum += weight * data->values[index];
    }
    return sum;
}
