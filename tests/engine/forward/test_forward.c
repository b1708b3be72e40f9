#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "forward/forward.h"

enum {
    GLOBAL = 1 << PM_MAP_GLOBAL,
    CAUSTIC = 1 << PM_MAP_CAUSTIC,
    VOLUME = 1 << PM_MAP_VOLUME,
    ALL = GLOBAL | CAUSTIC | VOLUME | 1 << PM_MAP_DIRECT,
};

#define LAMP "void light bright 0 0 3 5 4 3\nbright ring lamp 0 0 8 0 0 .9 0 0 -1 0 .3\n"

/* A bright room with a mirror ball and a wisp of mist: every kind of photon, and so many of the
 * global kind that some are left out. */
static const char room[] = "void plastic grey 0 0 5 .9 .88 .86 0 0\n" TEST_BOX("grey") LAMP
    "void metal mirror 0 0 5 .9 .9 .9 1 0\nmirror sphere ball 0 0 4 0 0 -.5 .4\n"
    "void mist fog 0 0 7 1 .5 .2 .8 .8 .8 .3\nfog sphere cloud 0 0 4 .5 .5 0 .3\n";

struct fixture {
    pm_world *world;
    pm_pool *pool;
    pm_forward *forward;
};

static struct fixture open_scene(const char *scene, unsigned threads)
{
    struct fixture f = {.world = world_of(scene), .pool = pm_pool_new(threads)};
    pm_error err = PM_ERROR_INIT;
    pm_forward_options options = pm_forward_defaults();
    assert_non_null(f.pool);
    assert_int_equal(pm_forward_new(f.world, &options, f.pool, &f.forward, &err), PM_OK);
    return f;
}

static void close_scene(struct fixture *f)
{
    assert_int_equal(pm_forward_nonfinite(f->forward), 0);
    pm_forward_free(f->forward);
    pm_pool_free(f->pool);
    pm_world_free(f->world);
}

static void trace(const struct fixture *f, uint64_t index, unsigned kinds, pm_batch *out)
{
    pm_error err = PM_ERROR_INIT;
    memset(out, 0, PM_MAP_KINDS * sizeof *out);
    assert_int_equal(pm_forward_batch(f->forward, index, kinds, f->pool, NULL, NULL, out, &err),
                     PM_OK);
}

static void clear(pm_batch *batches)
{
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        pm_batch_clear(&batches[kind]);
}

static void assert_same(const pm_batch *a, const pm_batch *b)
{
    assert_int_equal(a->count, b->count);
    assert_int_equal(a->paths, b->paths);
    assert_int_equal(a->index, b->index);
    assert_int_equal(a->kind, b->kind);
    if (a->count)
        assert_memory_equal(a->photons, b->photons, a->count * sizeof(pm_photon));
    assert_memory_equal(a->ends, b->ends, a->paths * sizeof *a->ends);
    assert_memory_equal(&a->emitted, &b->emitted, sizeof a->emitted);
    assert_memory_equal(&a->absorbed, &b->absorbed, sizeof a->absorbed);
    assert_memory_equal(&a->escaped, &b->escaped, sizeof a->escaped);
}

static void forward_bytes_equal_for_1_2_and_7_threads(void **state)
{
    (void)state;
    const unsigned threads[] = {1, 2, 7};
    pm_batch reference[PM_MAP_KINDS], other[PM_MAP_KINDS];
    for (int i = 0; i < 3; i++) {
        struct fixture f = open_scene(room, threads[i]);
        trace(&f, 3, ALL, i ? other : reference);
        for (int kind = 0; i && kind < PM_MAP_KINDS; kind++)
            assert_same(&reference[kind], &other[kind]);
        if (i)
            clear(other);
        close_scene(&f);
    }
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        assert_true(reference[kind].count > 100);
    clear(reference);
}

static void kinds_do_not_depend_on_each_other(void **state)
{
    (void)state;
    struct fixture f = open_scene(room, 2);
    pm_batch together[PM_MAP_KINDS], alone[PM_MAP_KINDS];
    trace(&f, 0, ALL, together);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        trace(&f, 0, 1U << kind, alone);
        assert_same(&together[kind], &alone[kind]);
        for (int other = 0; other < PM_MAP_KINDS; other++)
            assert_true(other == kind || !alone[other].ends); /* left alone */
        clear(alone);
    }
    clear(together);
    close_scene(&f);
}

static void batches_do_not_depend_on_their_order(void **state)
{
    (void)state;
    struct fixture f = open_scene(room, 1), g = open_scene(room, 1);
    pm_batch first[PM_MAP_KINDS], second[PM_MAP_KINDS], again[PM_MAP_KINDS];
    trace(&f, 0, VOLUME, first);
    trace(&f, 16, VOLUME, second);
    trace(&g, 16, VOLUME, again);
    assert_same(&second[PM_MAP_VOLUME], &again[PM_MAP_VOLUME]);
    clear(again);
    trace(&g, 0, VOLUME, again);
    assert_same(&first[PM_MAP_VOLUME], &again[PM_MAP_VOLUME]);
    assert_true(first[PM_MAP_VOLUME].count != second[PM_MAP_VOLUME].count);
    clear(first);
    clear(second);
    clear(again);
    close_scene(&f);
    close_scene(&g);
}

static void photons_carry_their_replicate(void **state)
{
    (void)state;
    struct fixture f = open_scene(room, 1);
    pm_batch out[PM_MAP_KINDS];
    trace(&f, 21, CAUSTIC, out);
    for (size_t i = 0; i < out[PM_MAP_CAUSTIC].count; i++)
        assert_int_equal(out[PM_MAP_CAUSTIC].photons[i].flags & PM_PHOTON_REPLICATE, 21 % 16);
    clear(out);
    close_scene(&f);
}

static void truncation_cuts_at_a_path(void **state)
{
    (void)state;
    struct fixture f = open_scene(room, 1);
    pm_batch whole[PM_MAP_KINDS], cut[PM_MAP_KINDS];
    trace(&f, 0, GLOBAL, whole);
    pm_batch *w = &whole[PM_MAP_GLOBAL], *c = &cut[PM_MAP_GLOBAL];
    const uint32_t paths[] = {PM_BATCH_PATHS, 5000, 1, 0};
    for (int i = 0; i < 4; i++) {
        trace(&f, 0, GLOBAL, cut);
        pm_batch_truncate(c, paths[i]);
        assert_int_equal(c->paths, paths[i]);
        assert_int_equal(c->count, paths[i] ? w->ends[paths[i] - 1] : 0);
        if (c->count)
            assert_memory_equal(c->photons, w->photons, c->count * sizeof(pm_photon));
        assert_true(i == 0 || pm_rgb_is_black(c->emitted));
        clear(cut);
    }
    assert_int_equal(w->ends[PM_BATCH_PATHS - 1], w->count);
    clear(whole);
    close_scene(&f);
}

/* Of n photons kept with probability p there are n p, 5 sqrt(n p (1 - p)) off; each is one of
 * the batch, in its order, and counted for its path. */
static void thinning_keeps_a_share_of_each_paths_photons(void **state)
{
    (void)state;
    struct fixture f = open_scene(room, 1);
    pm_batch whole[PM_MAP_KINDS], thin[PM_MAP_KINDS];
    trace(&f, 0, GLOBAL, whole);
    trace(&f, 0, GLOBAL, thin);
    pm_batch *w = &whole[PM_MAP_GLOBAL], *t = &thin[PM_MAP_GLOBAL];
    pm_batch_thin(t, 7, 1);
    assert_same(w, t);
    pm_batch_thin(t, 7, .25);
    double n = (double)w->count;
    assert_true(fabs((double)t->count - .25 * n) < 5 * sqrt(n * .25 * .75));
    assert_int_equal(t->ends[PM_BATCH_PATHS - 1], t->count);
    for (uint32_t path = 0, at = 0, from = 0; path < PM_BATCH_PATHS; path++) {
        for (; at < t->ends[path]; at++, from++) {
            while (from < w->ends[path] &&
                   memcmp(&w->photons[from], &t->photons[at], sizeof *t->photons))
                from++;
            assert_true(from < w->ends[path]);
        }
        from = w->ends[path];
    }
    clear(whole);
    clear(thin);
    close_scene(&f);
}

static pm_rgb mean_flux(const pm_batch *batch, double scale)
{
    pm_rgb sum = {0, 0, 0};
    for (size_t i = 0; i < batch->count; i++)
        sum = pm_rgb_add(sum, pm_photon_flux(&batch->photons[i]));
    return pm_rgb_scale(sum, scale / batch->paths);
}

/* In a closed sphere of albedo rho the hits after the first bring rho / (1 - rho) of the
 * emitted flux. Their number has the variance rho / (1 - rho)^2; storing each with probability
 * p and flux 1 / p adds rho / (1 - rho) (1 - p) / p. k = 4; the lamp hides 1e-6
 * of the view. */
static void storage_probability_keeps_the_flux(void **state)
{
    (void)state;
    struct fixture f = open_scene("void plastic wall 0 0 5 .95 .95 .95 0 0\n"
                                  "wall bubble room 0 0 4 0 0 0 1\n"
                                  "void light bright 0 0 3 1e6 1e6 1e6\n"
                                  "bright sphere lamp 0 0 4 0 0 0 .001\n",
                                  1);
    pm_batch out[PM_MAP_KINDS];
    trace(&f, 0, GLOBAL, out);
    double p = pm_forward_storage_probability(f.forward, PM_MAP_GLOBAL);
    double expected = .95 / .05, spread = .95 / (.05 * .05) + expected * (1 - p) / p;
    double emitted = out[PM_MAP_GLOBAL].emitted.r / PM_BATCH_PATHS;
    double found = mean_flux(&out[PM_MAP_GLOBAL], pm_forward_flux_scale(f.forward)).r / emitted;
    double sigma = sqrt(spread / PM_BATCH_PATHS);
    assert_true(p < .25);
    assert_true(fabs(found - expected) < 4 * sigma + expected * 1e-4);
    clear(out);
    close_scene(&f);
}

/* At most 4 stored photons a path on the pre-run's average, and the rate foretells a batch:
 * both means scatter, by sigma of the number of hits (variance rho / (1 - rho)^2 as above)
 * times p. */
static void rate_foretells_the_photons_of_a_batch(void **state)
{
    (void)state;
    struct fixture f = open_scene("void plastic wall 0 0 5 .9 .9 .9 0 0\n"
                                  "wall bubble room 0 0 4 0 0 0 1\n"
                                  "void light bright 0 0 3 1e6 1e6 1e6\n"
                                  "bright sphere lamp 0 0 4 0 0 0 .001\n",
                                  1);
    pm_batch out[PM_MAP_KINDS];
    trace(&f, 0, GLOBAL, out);
    double p = pm_forward_storage_probability(f.forward, PM_MAP_GLOBAL);
    double rate = pm_forward_rate(f.forward, PM_MAP_GLOBAL);
    double sigma = sqrt(p * p * .9 / .01 + 9 * p * (1 - p));
    assert_true(rate <= 4 + 1e-8);
    assert_true(fabs((double)out[PM_MAP_GLOBAL].count / PM_BATCH_PATHS - rate) <
                4 * sigma * sqrt(1. / PM_BATCH_PATHS + 1. / 16384));
    assert_true(pm_forward_storage_probability(f.forward, PM_MAP_CAUSTIC) == 1);
    assert_true(pm_forward_rate(f.forward, PM_MAP_CAUSTIC) == 0);
    clear(out);
    close_scene(&f);
}

static void a_scene_without_light_gives_empty_batches(void **state)
{
    (void)state;
    struct fixture f = open_scene("void plastic grey 0 0 5 .5 .5 .5 0 0\n" TEST_BOX("grey"), 2);
    pm_batch out[PM_MAP_KINDS];
    trace(&f, 0, ALL, out);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        assert_int_equal(out[kind].count, 0);
        assert_int_equal(out[kind].paths, PM_BATCH_PATHS);
        assert_int_equal(out[kind].ends[PM_BATCH_PATHS - 1], 0);
    }
    clear(out);
    close_scene(&f);
}

static void the_bound_on_events_ends_paths(void **state)
{
    (void)state;
    pm_world *world = world_of(room);
    pm_pool *pool = pm_pool_new(1);
    pm_forward *forward = NULL;
    pm_forward_options options = {.max_events = 1};
    pm_batch out[PM_MAP_KINDS] = {0};
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_forward_new(world, &options, pool, &forward, &err), PM_OK);
    assert_int_equal(pm_forward_batch(forward, 0, GLOBAL, pool, NULL, NULL, out, &err), PM_OK);
    const uint32_t *ends = out[PM_MAP_GLOBAL].ends;
    for (uint32_t i = 0; i < PM_BATCH_PATHS; i++)
        assert_true(ends[i] - (i ? ends[i - 1] : 0) <= 1);
    assert_true(out[PM_MAP_GLOBAL].count > 0);
    clear(out);
    pm_forward_free(forward);
    pm_pool_free(pool);
    pm_world_free(world);
}

static void options_and_batches_out_of_range_are_refused(void **state)
{
    (void)state;
    struct fixture f = open_scene(room, 1);
    pm_forward_options options = {.max_events = 50001};
    pm_forward *forward = NULL;
    pm_error err = PM_ERROR_INIT, err2 = PM_ERROR_INIT;
    assert_int_equal(pm_forward_new(f.world, &options, f.pool, &forward, &err), PM_E_RANGE);
    assert_null(forward);
    assert_string_equal(err.text, "a bound of 50001 scatterings a path; at most 50000");
    pm_batch out[PM_MAP_KINDS] = {0};
    assert_int_equal(pm_forward_batch(f.forward, 1 << 20, ALL, f.pool, NULL, NULL, out, &err2),
                     PM_E_RANGE);
    assert_string_equal(err2.text, "batch 1048576; a family has at most 1048576");
    assert_null(out[0].ends);
    close_scene(&f);
}

static bool stop_at_third_call(void *context)
{
    int *calls = context;
    return ++*calls == 3;
}

static void cancelling_leaves_the_outputs_untouched(void **state)
{
    (void)state;
    struct fixture f = open_scene(room, 1);
    pm_batch out[PM_MAP_KINDS] = {0};
    pm_error err = PM_ERROR_INIT;
    int calls = 0;
    assert_int_equal(
        pm_forward_batch(f.forward, 0, ALL, f.pool, stop_at_third_call, &calls, out, &err),
        PM_E_CANCELLED);
    assert_int_equal(calls, 3);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        assert_true(!out[kind].ends && !out[kind].photons && !out[kind].count);
    close_scene(&f);
}

/* ---- families ---- */

static pm_digest family_of(const char *scene, uint64_t seed, uint32_t max_events,
                           pm_map_kind kind)
{
    pm_world *world = world_of(scene);
    pm_pool *pool = pm_pool_new(1);
    pm_forward *forward = NULL;
    pm_error err = PM_ERROR_INIT;
    pm_forward_options options = {.seed = seed, .max_events = max_events};
    assert_int_equal(pm_forward_new(world, &options, pool, &forward, &err), PM_OK);
    pm_digest family = pm_forward_family(forward, kind);
    pm_forward_free(forward);
    pm_pool_free(pool);
    pm_world_free(world);
    return family;
}

static void families_differ_by_scene_kind_and_options_alone(void **state)
{
    (void)state;
    static const char scene[] = "void plastic grey 0 0 5 .5 .5 .5 0 0\n" TEST_BOX("grey") LAMP;
    static const char same[] =
        "# a comment\nvoid plastic gray 0 0 5 .50 .5 .5 0 0\n" TEST_BOX("gray") LAMP;
    pm_digest digests[] = {
        family_of(scene, 0, 5000, PM_MAP_GLOBAL), family_of(scene, 0, 5000, PM_MAP_CAUSTIC),
        family_of(scene, 1, 5000, PM_MAP_GLOBAL), family_of(scene, 0, 4999, PM_MAP_GLOBAL),
        family_of(room, 0, 5000, PM_MAP_GLOBAL),
    };
    pm_digest again = family_of(same, 0, 5000, PM_MAP_GLOBAL);
    assert_true(pm_digest_equal(&digests[0], &again));
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < i; j++)
            assert_false(pm_digest_equal(&digests[i], &digests[j]));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forward_bytes_equal_for_1_2_and_7_threads),
        cmocka_unit_test(kinds_do_not_depend_on_each_other),
        cmocka_unit_test(batches_do_not_depend_on_their_order),
        cmocka_unit_test(photons_carry_their_replicate),
        cmocka_unit_test(truncation_cuts_at_a_path),
        cmocka_unit_test(thinning_keeps_a_share_of_each_paths_photons),
        cmocka_unit_test(storage_probability_keeps_the_flux),
        cmocka_unit_test(rate_foretells_the_photons_of_a_batch),
        cmocka_unit_test(a_scene_without_light_gives_empty_batches),
        cmocka_unit_test(the_bound_on_events_ends_paths),
        cmocka_unit_test(options_and_batches_out_of_range_are_refused),
        cmocka_unit_test(cancelling_leaves_the_outputs_untouched),
        cmocka_unit_test(families_differ_by_scene_kind_and_options_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
