#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fields.h"

static void list_keeps_photons_in_the_order_in_which_they_came(void **state)
{
    (void)state;
    enum { COUNT = 5000 };
    pm_photon *photons = field_photons(field_room, 1, COUNT);
    pm_photon_list list = {0};
    for (size_t at = 0, part = 0; at < COUNT; at += part) {
        part = part + 7 < COUNT - at ? part + 7 : COUNT - at;
        assert_int_equal(pm_photon_list_append(&list, photons + at, part, NULL), PM_OK);
    }
    assert_int_equal(list.count, COUNT);
    assert_memory_equal(list.photons, photons, COUNT * sizeof *photons);
    pm_photon_list_clear(&list);
    assert_null(list.photons);
    free(photons);
}

static void room_that_was_reserved_is_not_moved(void **state)
{
    (void)state;
    enum { COUNT = 1000 };
    pm_photon *photons = field_photons(field_room, 1, COUNT);
    pm_photon_list list = {0};
    assert_int_equal(pm_photon_list_reserve(&list, COUNT, NULL), PM_OK);
    const pm_photon *place = list.photons;
    assert_int_equal(pm_photon_list_append(&list, photons, COUNT, NULL), PM_OK);
    assert_ptr_equal(list.photons, place);
    pm_photon_list_clear(&list);
    free(photons);
}

static void too_many_photons_are_refused_before_any_memory_is_asked(void **state)
{
    (void)state;
    pm_photon_list list = {0};
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_photon_list_reserve(&list, (uint64_t)PM_MAP_PHOTONS_MAX + 1, &err),
                     PM_E_LIMIT);
    assert_string_equal(err.text, "more than 2147483648 photons in one map");
    assert_null(list.photons);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(list_keeps_photons_in_the_order_in_which_they_came),
        cmocka_unit_test(room_that_was_reserved_is_not_moved),
        cmocka_unit_test(too_many_photons_are_refused_before_any_memory_is_asked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
