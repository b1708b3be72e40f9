#include "photons/visit.h"

#include "world/media.h"

/* Sums over the photons within a fixed radius. */

enum { NO_NORMAL = 0x10000 };

pm_search pm_search_volume(const pm_photon_map *map, pm_vec3 p)
{
    return (pm_search){
        .map = map,
        .point = {p.x * PM_GRID_PER_WORLD, p.y * PM_GRID_PER_WORLD, p.z * PM_GRID_PER_WORLD},
        .content = PM_CONTENT_ANY,
    };
}

pm_search pm_search_surface(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                            pm_photon_filter filter)
{
    pm_search s = pm_search_volume(map, point);
    s.normal[0] = (float)normal.x, s.normal[1] = (float)normal.y, s.normal[2] = (float)normal.z;
    s.surface = true;
    s.filter = filter;
    s.content =
        pm_content_sector(normal) | (filter == PM_PHOTONS_ALL        ? PM_CONTENT_ANY
                                     : filter == PM_PHOTONS_SPECULAR ? PM_CONTENT_SPECULAR
                                                                     : PM_CONTENT_PLAIN);
    s.known_normal = NO_NORMAL;
    return s;
}

/* ---- sums within a fixed radius ---- */

/* Four virtual lanes, so that sums do not depend on the width of the machine's registers. */
struct sums {
    __m256d sum[3], square[3];
    uint32_t count;
};

static inline void add_channel(__m256d *sum, __m256d *square, __m128i mantissa, __m256d unit)
{
    __m256d v = _mm256_mul_pd(_mm256_cvtepi32_pd(mantissa), unit);
    *sum = _mm256_add_pd(*sum, v);
    *square = _mm256_fmadd_pd(v, v, *square);
}

static inline __m128i load_bytes(const uint8_t *bytes) /* 4 of them */
{
    return _mm_loadu_si32(bytes);
}

/* Adds those of photons k .. k + 3 of the block whose bit is set in lanes. */
static inline void add_four(struct sums *t, const pm_photon_block *b, int k, unsigned lanes)
{
    const __m256i bits = _mm256_setr_epi64x(1, 2, 4, 8);
    __m256i taken = _mm256_and_si256(_mm256_set1_epi64x((long long)(lanes >> k)), bits);
    __m256i exponent = _mm256_cvtepu8_epi64(load_bytes(b->exponent + k));
    exponent = _mm256_add_epi64(exponent, _mm256_set1_epi64x(1023 - 200));
    __m256i unit =
        _mm256_and_si256(_mm256_slli_epi64(exponent, 52), _mm256_cmpeq_epi64(taken, bits));
    __m128i flux = _mm_load_si128((const __m128i *)(const void *)(b->flux + k)),
            low = _mm_set1_epi32(0x3FF);
    add_channel(&t->sum[0], &t->square[0], _mm_and_si128(flux, low), _mm256_castsi256_pd(unit));
    add_channel(&t->sum[1], &t->square[1], _mm_and_si128(_mm_srli_epi32(flux, 10), low),
                _mm256_castsi256_pd(unit));
    add_channel(&t->sum[2], &t->square[2], _mm_and_si128(_mm_srli_epi32(flux, 20), low),
                _mm256_castsi256_pd(unit));
}

static inline void take_sum(void *context, pm_search *s, size_t i, unsigned lanes,
                            const double *d2)
{
    (void)d2;
    struct sums *t = context;
    const pm_photon_block *b = &s->map->blocks[i];
    t->count += (uint32_t)__builtin_popcount(lanes);
    add_four(t, b, 0, lanes);
    add_four(t, b, 4, lanes);
    add_four(t, b, 8, lanes);
    add_four(t, b, 12, lanes);
}

static pm_rgb rgb_of_lanes(const __m256d v[3])
{
    double sum[3];
    for (int a = 0; a < 3; a++) {
        _Alignas(32) double lane[4];
        _mm256_store_pd(lane, v[a]);
        sum[a] = (lane[0] + lane[1]) + (lane[2] + lane[3]);
    }
    return (pm_rgb){sum[0], sum[1], sum[2]};
}

pm_flux_sum pm_search_sum(pm_search *search)
{
    const __m256d zero = _mm256_setzero_pd();
    struct sums t = {{zero, zero, zero}, {zero, zero, zero}, 0};
    visit(search, take_sum, &t);
    return (pm_flux_sum){rgb_of_lanes(t.sum), rgb_of_lanes(t.square), t.count};
}

/* ---- volumes ---- */

struct phase_sums {
    pm_flux_sum *out;
    pm_vec3 direction;
    double g;
};

static void add_phase(const pm_photon_map *map, size_t i, pm_vec3 direction, double g,
                      pm_flux_sum *out)
{
    pm_photon photon;
    pm_photon_map_photon(map, i, &photon);
    /* the photon came from its direction, so it was going the other way */
    double cosine = -pm_vec3_dot(pm_photon_direction(&photon), direction);
    pm_rgb v = pm_rgb_scale(pm_photon_flux(&photon), pm_phase(g, cosine));
    out->sum = pm_rgb_add(out->sum, v);
    out->square = pm_rgb_add(out->square, pm_rgb_mul(v, v));
    out->count++;
}

static inline void take_phase(void *context, pm_search *s, size_t i, unsigned lanes,
                              const double *d2)
{
    (void)d2;
    const struct phase_sums *t = context;
    for (; lanes; lanes &= lanes - 1)
        add_phase(s->map, i * PM_BLOCK_SIZE + (unsigned)__builtin_ctz(lanes), t->direction,
                  t->g, t->out);
}

pm_flux_sum pm_search_sum_phase(pm_search *search, pm_vec3 direction, double g)
{
    pm_flux_sum out = {{0, 0, 0}, {0, 0, 0}, 0};
    struct phase_sums t = {&out, direction, g};
    visit(search, take_phase, &t);
    return out;
}

/* ---- candidates of a nearest search ---- */

static pm_rgb rgb_of_pixel(__m256d v)
{
    _Alignas(32) double lane[4];
    _mm256_store_pd(lane, v);
    return (pm_rgb){lane[0], lane[1], lane[2]};
}

pm_flux_sum pm_candidates_sum(const pm_photon_map *map, const pm_candidates *c)
{
    __m256d sum[2], square[2];
    sum[0] = sum[1] = square[0] = square[1] = _mm256_setzero_pd();
    for (uint32_t i = 0; i < c->count; i++) {
        const pm_photon_block *b = &map->blocks[c->index[i] / PM_BLOCK_SIZE];
        __m256d v = photon_flux(b, c->index[i] % PM_BLOCK_SIZE);
        sum[i & 1] = _mm256_add_pd(sum[i & 1], v);
        square[i & 1] = _mm256_fmadd_pd(v, v, square[i & 1]);
    }
    return (pm_flux_sum){rgb_of_pixel(_mm256_add_pd(sum[0], sum[1])),
                         rgb_of_pixel(_mm256_add_pd(square[0], square[1])), c->count};
}

pm_flux_sum pm_candidates_sum_phase(const pm_photon_map *map, const pm_candidates *c,
                                    pm_vec3 direction, double g)
{
    pm_flux_sum out = {{0, 0, 0}, {0, 0, 0}, 0};
    for (uint32_t i = 0; i < c->count; i++)
        add_phase(map, c->index[i], direction, g, &out);
    return out;
}
