#include "photons/search.h"

#include <assert.h>
#include <emmintrin.h>
#include <math.h>

const pm_kernel *pm_kernel_best(void)
{
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512cd"))
        return &pm_kernel_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") &&
        __builtin_cpu_supports("fma"))
        return &pm_kernel_avx2;
    return &pm_kernel_sse2;
}

/* ---- one search ---- */

/* Not fmin and fmax, which are calls. */
static inline double least(double a, double b)
{
    return a < b ? a : b;
}

static inline double most(double a, double b)
{
    return a > b ? a : b;
}

static inline int64_t grid_units(double p)
{
    return (int64_t)floor(least(most(p * PM_GRID_PER_WORLD, -0x1p60), 0x1p60) + .5);
}

pm_search pm_search_volume(const pm_photon_map *map, pm_vec3 p)
{
    assert(pm_vec3_finite(p));
    return (pm_search){
        .map = map,
        .point = {grid_units(p.x), grid_units(p.y), grid_units(p.z)},
        .content = {PM_CONTENT_ANY, PM_CONTENT_ANY},
    };
}

pm_search pm_search_beside(const pm_search *search, pm_vec3 p)
{
    assert(pm_vec3_finite(p));
    pm_search s = *search;
    s.point[0] = grid_units(p.x);
    s.point[1] = grid_units(p.y);
    s.point[2] = grid_units(p.z);
    return s;
}

static int axis_of(const float n[3])
{
    for (int a = 0; a < 3; a++)
        if (fabsf(n[a]) == 1 && n[(a + 1) % 3] == 0 && n[(a + 2) % 3] == 0)
            return n[a] > 0 ? a + 1 : -a - 1;
    return 0;
}

pm_search pm_search_surface(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                            pm_photon_filter filter)
{
    pm_search s = pm_search_volume(map, point);
    s.normal[0] = (float)normal.x, s.normal[1] = (float)normal.y, s.normal[2] = (float)normal.z;
    s.axis = axis_of(s.normal);
    s.surface = true;
    s.filter = filter;
    s.content[0] = pm_content_sector(normal);
    if (filter != PM_PHOTONS_ALL)
        s.content[1] = filter == PM_PHOTONS_SPECULAR ? PM_CONTENT_SPECULAR : PM_CONTENT_PLAIN;
    s.known_normal = PM_NORMAL_MIXED;
    return s;
}

double pm_search_bound(double radius)
{
    double r = radius * PM_GRID_PER_WORLD;
    return r * r;
}

/* ---- groups ---- */

static void add_search(pm_group *g, const pm_search *s, double radius)
{
    for (int a = 0; a < 3; a++) {
        double p = (double)s->point[a];
        g->low[a] = least(g->low[a], p - radius);
        g->high[a] = most(g->high[a], p + radius);
        g->point_low[a] = least(g->point_low[a], p);
        g->point_high[a] = most(g->point_high[a], p);
    }
    g->least_radius = least(g->least_radius, radius);
    g->axis = s->axis == g->axis ? g->axis : 0;
    g->count++;
}

/* Whether walking along is worth it. */
static bool fits(const pm_group *g, const pm_search *s, double radius, double spread)
{
    const pm_search *first = &g->searches[0];
    if (s->content[0] != first->content[0] || s->filter != first->filter)
        return false;
    double radius_least = least(g->least_radius, radius);
    for (int a = 0; a < 3; a++) {
        double p = (double)s->point[a];
        double low = least(g->low[a], p - radius), high = most(g->high[a], p + radius);
        if (!(high - low <= (2 + spread) * radius_least))
            return false;
    }
    return true;
}

pm_group pm_group_make(pm_search *searches, size_t count, double spread)
{
    pm_group g = {.searches = searches,
                  .axis = searches[0].axis,
                  .low = {INFINITY, INFINITY, INFINITY},
                  .high = {-INFINITY, -INFINITY, -INFINITY},
                  .point_low = {INFINITY, INFINITY, INFINITY},
                  .point_high = {-INFINITY, -INFINITY, -INFINITY},
                  .least_radius = INFINITY,
                  .fluxes = true};
    while (g.count < count && g.count < PM_GROUP_MAX) {
        const pm_search *s = &searches[g.count];
        double radius = (double)s->reach;
        if (g.count && !fits(&g, s, radius, spread))
            break;
        add_search(&g, s, radius);
    }
    return g;
}

/* ---- from the root to the blocks ---- */

struct walk {
    pm_group *group;
    pm_list *list;
    pm_take_list *take; /* NULL: one list must do */
    void *context;
    bool overflow;
};

/* (p[a] - origin[a]) * steps_per_unit of a node, of three axes. The last lane is of no use. */
static __m128 steps_above(const double p[3], const pm_node *node)
{
    __m128i origin = _mm_loadu_si128((const __m128i *)(const void *)node->origin);
    __m128d xy = _mm_sub_pd(_mm_loadu_pd(p), _mm_cvtepi32_pd(origin));
    __m128d z =
        _mm_sub_sd(_mm_load_sd(p + 2), _mm_cvtepi32_pd(_mm_unpackhi_epi64(origin, origin)));
    __m128 steps = _mm_movelh_ps(_mm_cvtpd_ps(xy), _mm_cvtpd_ps(z));
    return _mm_mul_ps(steps, _mm_set1_ps(node->steps_per_unit));
}

static __m128i bytes_of(const uint8_t bytes[PM_NODE_CHILDREN])
{
    return _mm_loadu_si128((const __m128i *)(const void *)bytes);
}

static __m128i all_bytes(int32_t value)
{
    return _mm_set1_epi8((char)value);
}

/* Children of the node that may hold photons within a bound of the group: those that hold what
 * is sought and whose box meets the group's. */
static unsigned node_mask(const pm_node *node, const pm_group *g)
{
    /* Of all this only the conversion to float rounds, by less than 2^-15 steps below 2^8. */
    const __m128 slack = _mm_set1_ps(0x1p-15F), zero = _mm_setzero_ps();
    __m128 from = _mm_sub_ps(steps_above(g->low, node), slack);
    __m128 to = _mm_add_ps(steps_above(g->high, node), slack);
    __m128 off =
        _mm_or_ps(_mm_cmplt_ps(to, zero), _mm_cmpge_ps(from, _mm_set1_ps(PM_NODE_STEPS)));
    if (_mm_movemask_ps(off) & 7)
        return 0;
    _Alignas(16) int32_t first[4], last[4];
    to = _mm_min_ps(to, _mm_set1_ps(PM_NODE_STEPS - 1));
    _mm_store_si128((__m128i *)(void *)first, _mm_cvttps_epi32(_mm_max_ps(from, zero)));
    _mm_store_si128((__m128i *)(void *)last, _mm_cvttps_epi32(to));
    __m128i meet = _mm_set1_epi8(-1);
    for (int a = 0; a < 3; a++) {
        __m128i low = bytes_of(node->low[a]), high = bytes_of(node->high[a]);
        meet = _mm_and_si128(meet, _mm_cmpeq_epi8(_mm_min_epu8(low, all_bytes(last[a])), low));
        meet =
            _mm_and_si128(meet, _mm_cmpeq_epi8(_mm_max_epu8(high, all_bytes(first[a])), high));
    }
    const pm_search *s = &g->searches[0];
    return (unsigned)_mm_movemask_epi8(meet) & node->holds[s->content[0]] &
           node->holds[s->content[1]];
}

/* False if no photon of child c can lie in the tangent plane: known where all have one normal.
 */
static bool child_in_plane(const pm_node *node, unsigned c, const pm_search *s)
{
    if (node->normal[c] == PM_NORMAL_MIXED)
        return true;
    const pm_photon photon = {
        .normal = {(uint8_t)node->normal[c], (uint8_t)(node->normal[c] >> 8)}};
    const pm_vec3 n = pm_photon_normal(&photon);
    const double own[3] = {n.x, n.y, n.z};
    double step = (double)pm_node_step(node);
    double height = 0, thickness = 0, center2 = 0, half2 = 0;
    for (int a = 0; a < 3; a++) {
        double half = (node->high[a][c] + 1 - node->low[a][c]) * step / 2;
        double center = node->origin[a] + node->low[a][c] * step + half - (double)s->point[a];
        double mean = (own[a] + (double)s->normal[a]) / 2;
        height += center * mean;
        thickness += half * fabs(mean);
        center2 += center * center;
        half2 += half * half;
    }
    double farthest = sqrt(center2) + sqrt(half2);
    double limit = (double)PM_TANGENT_SLOPE * farthest + 2 * (double)PM_TANGENT_SLACK;
    return fabs(height) - thickness <= limit * (1 + 0x1p-18);
}

static unsigned children_in_plane(const pm_node *node, unsigned mask, const pm_search *s)
{
    for (unsigned rest = mask; rest; rest &= rest - 1)
        if (!child_in_plane(node, (unsigned)__builtin_ctz(rest), s))
            mask ^= rest & -rest;
    return mask;
}

static void fetch_block(const pm_photon_block *block)
{
    for (size_t i = 0; i < sizeof *block; i += 64)
        __builtin_prefetch((const char *)block + i);
}

static void list_block(struct walk *w, const pm_node *node, unsigned c, size_t index, bool wide)
{
    pm_ready *r = &w->list->ready[w->list->count++];
    size_t block = index * PM_NODE_CHILDREN + c;
    r->block = &w->group->searches[0].map->blocks[block];
    r->index = (uint32_t)block;
    r->code = node->normal[c];
    r->wide = wide;
    fetch_block(r->block);
}

/* Whether differences between points and photons of a node may not fit 32 bits. */
static bool is_wide(const pm_node *node, const pm_group *g)
{
    double size = PM_NODE_STEPS * (double)pm_node_step(node);
    bool wide = false;
    for (int a = 0; a < 3; a++)
        wide |= node->origin[a] + size - g->point_low[a] > INT32_MAX ||
                node->origin[a] - g->point_high[a] < INT32_MIN;
    return wide;
}

static void take_list(struct walk *w, bool last)
{
    pm_group *g = w->group;
    w->list->last = last;
    g->searches[0].map->kernel->prepare(g, w->list);
    w->take(w->context, g, w->list);
    w->list->count = 0;
}

static void list_children(struct walk *w, size_t index, unsigned mask)
{
    const pm_search *s = &w->group->searches[0];
    const pm_node *node = &s->map->nodes[index];
    bool wide = is_wide(node, w->group);
    if (w->list->count + (unsigned)__builtin_popcount(mask) > PM_LIST_MAX) {
        w->overflow = !w->take;
        if (w->overflow)
            return;
        take_list(w, false);
    }
    s->map->kernel->list_boxes(node, mask, s->point, w->list);
    for (; mask; mask &= mask - 1)
        list_block(w, node, (unsigned)__builtin_ctz(mask), index, wide);
}

static void walk_node(struct walk *w, int level, size_t index)
{
    const pm_photon_map *map = w->group->searches[0].map;
    const pm_node *node = &map->nodes[map->level_start[level] + index];
    unsigned mask = node_mask(node, w->group);
    if (w->group->searches[0].careful && w->group->count == 1)
        mask = children_in_plane(node, mask, &w->group->searches[0]);
    if (!level) {
        if (mask)
            list_children(w, index, mask);
        return;
    }
    for (; mask && !w->overflow; mask &= mask - 1)
        walk_node(w, level - 1, index * PM_NODE_CHILDREN + (unsigned)__builtin_ctz(mask));
}

static void start_walk(struct walk *w)
{
    pm_group *g = w->group;
    const pm_photon_map *map = g->searches[0].map;
    w->list->count = 0;
    for (size_t i = 0; i < g->count; i++)
        for (int a = 0; a < 3; a++)
            g->searches[i].offset[a] =
                (float)(g->searches[i].point[a] - g->searches[0].point[a]);
    if (map->levels)
        walk_node(w, map->levels - 1, 0);
}

void pm_group_walk(pm_group *group, pm_list *list, pm_take_list *take, void *context)
{
    struct walk w = {group, list, take, context, false};
    start_walk(&w);
    take_list(&w, true);
}

bool pm_group_list(pm_group *group, pm_list *list)
{
    struct walk w = {.group = group, .list = list};
    list->last = true;
    start_walk(&w);
    return !w.overflow;
}
