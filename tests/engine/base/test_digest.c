#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/digest.h"

/* FIPS 180-4 examples: "abc" and the empty message. */
static void digest_known_answers(void **state)
{
    (void)state;
    char hex[PM_DIGEST_HEX];
    pm_digest digest = pm_digest_of("abc", 3);
    pm_digest_hex(&digest, hex);
    assert_string_equal(hex,
                        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    digest = pm_digest_of("", 0);
    pm_digest_hex(&digest, hex);
    assert_string_equal(hex,
                        "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

static void digest_of_pieces_is_digest_of_whole(void **state)
{
    (void)state;
    pm_hasher *hasher = pm_hasher_new();
    assert_non_null(hasher);
    const pm_digest whole = pm_digest_of("photons land here", 17);
    for (int round = 0; round < 2; round++) { /* finish makes it new */
        pm_hasher_add(hasher, "photons ", 8);
        pm_hasher_add(hasher, "land here", 9);
        pm_digest pieces = pm_hasher_finish(hasher);
        assert_true(pm_digest_equal(&pieces, &whole));
    }
    pm_hasher_free(hasher);
}

static void digest_parse_takes_exactly_64_lower_case_digits(void **state)
{
    (void)state;
    pm_digest digest = pm_digest_of("x", 1), parsed = {0};
    char hex[PM_DIGEST_HEX];
    pm_digest_hex(&digest, hex);
    assert_true(pm_digest_parse(hex, &parsed));
    assert_true(pm_digest_equal(&digest, &parsed));
    hex[5] = 'G';
    assert_false(pm_digest_parse(hex, &parsed));
    hex[5] = '\0';
    assert_false(pm_digest_parse(hex, &parsed));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(digest_known_answers),
        cmocka_unit_test(digest_of_pieces_is_digest_of_whole),
        cmocka_unit_test(digest_parse_takes_exactly_64_lower_case_digits),
    };
    return cmocka_run_group_tests_name("base.digest", tests, NULL, NULL);
}
