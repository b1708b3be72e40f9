#ifndef PM_TESTS_CMOCKA_FIRST_H
#define PM_TESTS_CMOCKA_FIRST_H

/* cmocka.h wants these before it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#endif
