#include "cmocka_first.h"

#include <pthread.h>
#include <sched.h>

#include "building.h"

struct job {
    pm_building *building;
    pm_digest family;
    int64_t id;
    atomic_bool stop, begun;
    bool joined;
};

static void *begin_main(void *context)
{
    struct job *job = context;
    job->joined = pm_building_begin(job->building, &job->family, job->id, &job->stop);
    atomic_store(&job->begun, true);
    return NULL;
}

static void wait_for_waiter(pm_building *building)
{
    while (!pm_building_waiting(building))
        sched_yield();
}

static void the_second_job_waits_for_the_first(void **state)
{
    (void)state;
    pm_building *building = pm_building_new();
    struct job a = {building, pm_digest_of("f", 1), 1, false, false, true};
    struct job b = {building, pm_digest_of("f", 1), 2, false, false, false};
    struct job c = {building, pm_digest_of("g", 1), 3, false, false, true};
    begin_main(&a);
    begin_main(&c); /* another family does not wait */
    assert_false(a.joined || c.joined);
    pthread_t thread;
    pthread_create(&thread, NULL, begin_main, &b);
    wait_for_waiter(building);
    assert_false(atomic_load(&b.begun));
    pm_building_end(building, &a.family, 1);
    pthread_join(thread, NULL);
    assert_true(b.joined);
    pm_building_end_all(building, 2);
    pm_building_end_all(building, 3);
    pm_building_free(building);
}

static void a_dead_job_lets_all_its_families_go(void **state)
{
    (void)state;
    pm_building *building = pm_building_new();
    struct job a = {.building = building, .family = pm_digest_of("f", 1), .id = 1};
    struct job b = {.building = building, .family = pm_digest_of("g", 1), .id = 1};
    struct job c = {.building = building, .family = pm_digest_of("g", 1), .id = 2};
    begin_main(&a);
    begin_main(&b);
    pthread_t thread;
    pthread_create(&thread, NULL, begin_main, &c);
    wait_for_waiter(building);
    pm_building_end_all(building, 1);
    pthread_join(thread, NULL);
    assert_true(c.joined);
    pm_building_end_all(building, 2);
    begin_main(&a);
    assert_false(a.joined);
    pm_building_free(building);
}

static void a_stopped_job_waits_no_longer(void **state)
{
    (void)state;
    pm_building *building = pm_building_new();
    struct job a = {.building = building, .family = pm_digest_of("f", 1), .id = 1};
    struct job b = {.building = building, .family = pm_digest_of("f", 1), .id = 2};
    begin_main(&a);
    pthread_t thread;
    pthread_create(&thread, NULL, begin_main, &b);
    wait_for_waiter(building);
    atomic_store(&b.stop, true);
    pm_building_wake(building);
    pthread_join(thread, NULL); /* ends */
    pm_building_end_all(building, 2);
    pm_building_end_all(building, 1);
    pm_building_free(building);
}

/* Job 1 has f and wants g, job 2 has g and wants f: one of them must go on without. */
static void waiting_in_a_circle_does_not_happen(void **state)
{
    (void)state;
    pm_building *building = pm_building_new();
    struct job f1 = {.building = building, .family = pm_digest_of("f", 1), .id = 1};
    struct job g2 = {.building = building, .family = pm_digest_of("g", 1), .id = 2};
    struct job g1 = {.building = building, .family = pm_digest_of("g", 1), .id = 1};
    struct job f2 = {.building = building, .family = pm_digest_of("f", 1), .id = 2};
    begin_main(&f1);
    begin_main(&g2);
    pthread_t one, two;
    pthread_create(&one, NULL, begin_main, &g1);
    pthread_create(&two, NULL, begin_main, &f2);
    while (!atomic_load(&g1.begun) && !atomic_load(&f2.begun))
        sched_yield();
    pm_building_end_all(building, atomic_load(&g1.begun) ? 1 : 2);
    pthread_join(one, NULL);
    pthread_join(two, NULL);
    pm_building_end_all(building, 1);
    pm_building_end_all(building, 2);
    pm_building_free(building);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_second_job_waits_for_the_first),
        cmocka_unit_test(a_dead_job_lets_all_its_families_go),
        cmocka_unit_test(a_stopped_job_waits_no_longer),
        cmocka_unit_test(waiting_in_a_circle_does_not_happen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
