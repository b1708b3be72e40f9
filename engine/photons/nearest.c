#include <assert.h>
#include <emmintrin.h>
#include <math.h>
#include <string.h>

#include "photons/search.h"

/* Searches for the nearest photons: the distance of the farthest one wanted first, then what
 * lies within it. */

/* ---- the distance ---- */

/* A squared radius beyond which there is no photon. */
static double whole_map(const pm_search *s)
{
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        double d = fabs((double)s->point[a]) + PM_GRID_PER_WORLD;
        sum += d * d;
    }
    return sum * (1 + 0x1p-20);
}

/* The greatest float below x > 0. */
static float just_below(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits--;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* One point's search. */
struct job {
    pm_search *search;
    pm_nearest *work;
    uint32_t wanted;
    bool listed;   /* the list at hand has all blocks; else each visit walks */
    bool finished; /* no photon can be nearer than those collected */
    size_t count;  /* collected */
    pm_running_sum sum;
    uint32_t missing;
    pm_candidates *found;
};

static void visit(struct job *job, pm_take_list *take)
{
    if (job->listed) {
        take(job, NULL, &job->work->list);
        return;
    }
    pm_group alone = pm_group_make(job->search, 1, 0);
    pm_group_walk(&alone, &job->work->list, take, job);
}

/* Keeps the `count` least distances, none of them above limit. */
static void keep(struct job *job, size_t count, float limit)
{
    float *values = job->work->distance2;
    size_t n = 0;
    for (size_t i = 0; i < job->count && n < count; i++)
        if (values[i] < limit)
            values[n++] = values[i];
    while (n < count)
        values[n++] = limit;
    job->count = n;
}

static void take_distances(void *context, pm_group *group, pm_list *list)
{
    (void)group;
    struct job *job = context;
    pm_search *s = job->search;
    float *values = job->work->distance2;
    size_t rank = (size_t)job->wanted + 1;
    if (job->finished)
        return;
    job->count += s->map->kernel->collect(list, s, values + job->count);
    if (job->listed || job->count <= rank)
        return;
    float limit = s->map->kernel->select(values, job->count, rank, (float)s->bound);
    keep(job, rank, limit);
    job->finished = limit == 0;
    if (limit > 0)
        pm_search_set_bound(s, (double)just_below(limit));
}

/* The squared distance of the photon behind those wanted; INFINITY if there is none within
 * the bound. */
static double next_distance2(struct job *job)
{
    const pm_search *s = job->search;
    double bound = s->bound;
    job->count = 0;
    job->finished = false;
    visit(job, take_distances);
    if (job->count <= job->wanted)
        return INFINITY;
    return (double)s->map->kernel->select(job->work->distance2, job->count,
                                          (size_t)job->wanted + 1, (float)bound);
}

static struct job start_job(pm_search *s, uint32_t wanted, pm_nearest *work)
{
    assert(wanted && wanted <= PM_GATHER_MAX);
    return (struct job){.search = s, .work = work, .wanted = wanted};
}

static bool ready_list(pm_group *group, pm_list *list)
{
    if (!pm_group_list(group, list))
        return false;
    group->searches[0].map->kernel->prepare(group, list);
    return true;
}

/* Looks in growing balls; leaves the last one's blocks listed if one list holds them. */
static double search_alone(struct job *job, double first, double most)
{
    pm_search *s = job->search;
    for (double bound = first;;) {
        bound = fmin(bound, most);
        pm_search_set_bound(s, bound);
        pm_group alone = pm_group_make(s, 1, 0);
        job->listed = ready_list(&alone, &job->work->list);
        double next2 = next_distance2(job);
        if (isfinite(next2))
            return next2;
        if (bound >= most) {
            pm_search_set_bound(s, most);
            return next2;
        }
        bound *= fmin(1.5 * (job->wanted + 1) / ((double)job->count + 1), 16);
        s->careful = s->surface;
    }
}

static double first_bound(pm_search *s, uint32_t wanted, double most)
{
    return s->map->levels ? pm_search_guess(s, wanted) : most;
}

/* ---- what lies within ---- */

static void take_sum(void *context, pm_group *group, pm_list *list)
{
    (void)group;
    struct job *job = context;
    pm_sum_list(&job->sum, job->search, list);
}

static void take_ties(void *context, pm_group *group, pm_list *list)
{
    (void)group;
    struct job *job = context;
    if (job->missing)
        job->missing = pm_sum_ties(&job->sum, job->search, list, job->missing);
}

static pm_flux_sum sum_below(struct job *job, double next2, const pm_photon_weight *weight)
{
    pm_search *s = job->search;
    pm_sum_begin(&job->sum, weight);
    if (isfinite(next2))
        pm_search_set_bound(s, next2 > 0 ? (double)just_below((float)next2) : 0);
    if (next2 > 0)
        visit(job, take_sum);
    job->missing = job->wanted - job->sum.plain.count - job->sum.others.count;
    if (isfinite(next2) && job->missing) {
        pm_search_set_bound(s, next2);
        visit(job, take_ties);
    }
    return pm_sum_end(&job->sum, s->map);
}

static void take_candidates(void *context, pm_group *group, pm_list *list)
{
    (void)group;
    struct job *job = context;
    pm_found found[PM_LIST_MAX];
    size_t count = job->search->map->kernel->find(list, job->search, found);
    for (size_t i = 0; i < count; i++)
        for (unsigned lanes = found[i].lanes; lanes; lanes &= lanes - 1) {
            unsigned lane = (unsigned)__builtin_ctz(lanes);
            pm_candidates *c = job->found;
            bool tie = job->finished && found[i].distance2[lane] >= (float)job->search->bound;
            if (c->count == job->wanted || (tie && !job->missing))
                continue;
            job->missing -= tie;
            c->distance2[c->count] = (double)found[i].distance2[lane];
            c->index[c->count++] = found[i].block * PM_BLOCK_SIZE + lane;
        }
}

double pm_search_nearest(pm_search *s, uint32_t wanted, pm_candidates *out)
{
    pm_nearest work;
    struct job job = start_job(s, wanted, &work);
    double most = fmin(s->bound, whole_map(s));
    double next2 = search_alone(&job, first_bound(s, wanted + 1, most), most);
    job.found = out;
    out->wanted = wanted;
    out->count = 0;
    job.finished = isfinite(next2); /* then photons at the bound are ties */
    job.missing = wanted;
    if (isfinite(next2)) {
        size_t below = 0;
        for (size_t i = 0; i < job.count; i++)
            below += work.distance2[i] < (float)next2;
        job.missing = wanted - (uint32_t)below;
        pm_search_set_bound(s, next2);
    }
    visit(&job, take_candidates);
    return next2;
}

/* ---- groups ---- */

/* A bound for points near the last ones: what they found, and the spread of a Poisson number.
 */
static double bound_from(const pm_guess *guess, const pm_search *s, double far)
{
    double distance2 = 0;
    for (int a = 0; a < 3; a++) {
        double d = (double)s->point[a] - (double)guess->point[a];
        distance2 += d * d;
    }
    return distance2 <= far * guess->bound ? guess->bound : 0;
}

static void learn(pm_guess *guess, const pm_search *last, double sum, size_t count,
                  double factor)
{
    if (count)
        guess->bound = fmax(sum / (double)count * factor, 1);
    memcpy(guess->point, last->point, sizeof guess->point);
}

/* The bound to begin with at the next few points. */
static double begin(pm_search *s, uint32_t wanted, const pm_guess *guess)
{
    const double far = 64; /* eight radii */
    double bound = bound_from(guess, s, far);
    return bound > 0 ? bound : first_bound(s, wanted, whole_map(s));
}

/* Sums at as many of the points as make a group; returns how many. */
static size_t sum_group(pm_search *searches, size_t many, uint32_t wanted,
                        const pm_photon_weight *const *weights, pm_guess *guess,
                        pm_nearest *work, pm_flux_sum *out, double *next2)
{
    double most[PM_GROUP_MAX], found = 0;
    double first = begin(&searches[0], wanted + 1, guess);
    size_t n = 0, count = many < PM_GROUP_MAX ? many : PM_GROUP_MAX;
    for (size_t i = 0; i < count; i++) {
        most[i] = fmin(searches[i].bound, whole_map(&searches[i]));
        pm_search_set_bound(&searches[i], fmin(first, most[i]));
    }
    pm_group group = pm_group_make(searches, count, PM_SPREAD);
    bool listed = ready_list(&group, &work->list);
    for (size_t i = 0; i < group.count; i++) {
        struct job job = start_job(&searches[i], wanted, work);
        job.listed = listed;
        next2[i] = listed ? next_distance2(&job) : INFINITY;
        if (isinf(next2[i]) && (!listed || searches[i].bound < most[i])) {
            next2[i] = -1; /* later, alone */
            continue;
        }
        found += isfinite(next2[i]) ? next2[i] : 0;
        n += isfinite(next2[i]);
        out[i] = sum_below(&job, next2[i], weights[i]);
    }
    for (size_t i = 0; i < group.count; i++) {
        if (next2[i] >= 0)
            continue;
        struct job job = start_job(&searches[i], wanted, work);
        double alone = listed ? 1.6 * first : first_bound(&searches[i], wanted + 1, most[i]);
        next2[i] = search_alone(&job, alone, most[i]);
        found += isfinite(next2[i]) ? next2[i] : 0;
        n += isfinite(next2[i]);
        out[i] = sum_below(&job, next2[i], weights[i]);
    }
    for (size_t i = group.count; i < count; i++)
        pm_search_set_bound(&searches[i], most[i]);
    learn(guess, &searches[group.count - 1], found, n, 1 + 2 / sqrt(wanted + 1.0));
    return group.count;
}

void pm_nearest_sum(pm_search *searches, size_t count, uint32_t wanted,
                    const pm_photon_weight *const *weights, pm_guess *guess, pm_nearest *work,
                    pm_flux_sum *out, double *next2)
{
    for (size_t i = 0; i < count;)
        i += sum_group(searches + i, count - i, wanted, weights + i, guess, work, out + i,
                       next2 + i);
}

/* ---- the nearest one ---- */

struct closest {
    pm_search *search;
    pm_closest best;
};

static void take_closest(void *context, pm_group *group, pm_list *list)
{
    (void)group;
    struct closest *c = context;
    c->search->map->kernel->closest(list, c->search, &c->best);
}

static void start_closest(struct closest *c, pm_search *s)
{
    c->search = s;
    for (int i = 0; i < PM_BLOCK_SIZE; i++) {
        c->best.distance2[i] = INFINITY;
        c->best.index[i] = 0;
    }
}

static __m128 least_of(const float v[PM_BLOCK_SIZE])
{
    __m128 a = _mm_min_ps(_mm_load_ps(v), _mm_load_ps(v + 4));
    __m128 b = _mm_min_ps(_mm_load_ps(v + 8), _mm_load_ps(v + 12));
    a = _mm_min_ps(a, b);
    a = _mm_min_ps(a, _mm_movehl_ps(a, a));
    a = _mm_min_ss(a, _mm_shuffle_ps(a, a, 1));
    return _mm_shuffle_ps(a, a, 0);
}

static size_t best_index(const pm_closest *best, double *distance2)
{
    __m128 least = least_of(best->distance2);
    *distance2 = (double)_mm_cvtss_f32(least);
    if (isinf(*distance2))
        return SIZE_MAX;
    unsigned lanes = 0;
    for (unsigned i = 0; i < PM_BLOCK_SIZE; i += 4) {
        __m128 same = _mm_cmpeq_ps(_mm_load_ps(best->distance2 + i), least);
        lanes |= (unsigned)_mm_movemask_ps(same) << i;
    }
    size_t index = SIZE_MAX;
    for (; lanes; lanes &= lanes - 1) {
        unsigned lane = (unsigned)__builtin_ctz(lanes);
        uint32_t block;
        memcpy(&block, &best->index[lane], sizeof block);
        size_t here = (size_t)block * PM_BLOCK_SIZE + lane;
        index = here < index ? here : index;
    }
    return index;
}

static size_t closest_alone(pm_search *s, double first, double most, pm_list *list,
                            double *distance2)
{
    for (double bound = first;;) {
        struct closest c;
        start_closest(&c, s);
        bound = fmin(bound, most);
        pm_search_set_bound(s, bound);
        pm_group alone = pm_group_make(s, 1, 0);
        alone.fluxes = false;
        pm_group_walk(&alone, list, take_closest, &c);
        size_t index = best_index(&c.best, distance2);
        if (index != SIZE_MAX || bound >= most)
            return index;
        bound *= 16;
        s->careful = s->surface;
    }
}

static size_t closest_group(pm_search *searches, size_t many, pm_guess *guess, pm_list *list,
                            size_t *index)
{
    double most[PM_GROUP_MAX], first = begin(&searches[0], 1, guess), sum = 0;
    size_t n = 0, count = many < PM_GROUP_MAX ? many : PM_GROUP_MAX;
    for (size_t i = 0; i < count; i++) {
        most[i] = fmin(searches[i].bound, whole_map(&searches[i]));
        pm_search_set_bound(&searches[i], fmin(first, most[i]));
    }
    pm_group group = pm_group_make(searches, count, PM_SPREAD_CLOSEST);
    group.fluxes = false;
    bool listed = ready_list(&group, list);
    double distance2[PM_GROUP_MAX];
    for (size_t i = 0; i < group.count; i++) {
        struct closest c;
        start_closest(&c, &searches[i]);
        if (listed)
            take_closest(&c, NULL, list);
        index[i] = best_index(&c.best, &distance2[i]);
    }
    for (size_t i = 0; i < group.count; i++) {
        if (index[i] == SIZE_MAX && !(listed && first >= most[i]))
            index[i] = closest_alone(&searches[i], listed ? 4 * first : first, most[i], list,
                                     &distance2[i]);
        sum += index[i] == SIZE_MAX ? 0 : distance2[i];
        n += index[i] != SIZE_MAX;
    }
    for (size_t i = group.count; i < count; i++)
        pm_search_set_bound(&searches[i], most[i]);
    learn(guess, &searches[group.count - 1], sum, n, 4);
    return group.count;
}

void pm_nearest_one(pm_search *searches, size_t count, pm_guess *guess, pm_list *list,
                    size_t *index)
{
    for (size_t i = 0; i < count;)
        i += closest_group(searches + i, count - i, guess, list, index + i);
}
