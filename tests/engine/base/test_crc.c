#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/crc.h"

/* RFC 3720 B.4: 32 bytes each. */
static void crc_of_the_published_examples(void **state)
{
    (void)state;
    uint8_t bytes[32];
    memset(bytes, 0, sizeof bytes);
    assert_int_equal(pm_crc32c(bytes, sizeof bytes), 0x8a9136aa);
    memset(bytes, 0xff, sizeof bytes);
    assert_int_equal(pm_crc32c(bytes, sizeof bytes), 0x62a8ab43);
    for (uint8_t i = 0; i < 32; i++)
        bytes[i] = i;
    assert_int_equal(pm_crc32c(bytes, sizeof bytes), 0x46dd794e);
}

/* The check value of the polynomial: nine bytes, so not whole words alone. */
static void crc_of_an_odd_number_of_bytes(void **state)
{
    (void)state;
    assert_int_equal(pm_crc32c("123456789", 9), 0xe3069283);
    assert_int_equal(pm_crc32c("", 0), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crc_of_the_published_examples),
        cmocka_unit_test(crc_of_an_odd_number_of_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
