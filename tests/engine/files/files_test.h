#ifndef FILES_TEST_H
#define FILES_TEST_H

/* What the tests of engine/files share. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/bytes.h"
#include "base/error.h"
#include "files/portable.h"

static inline void assert_message(const pm_error *err, const char *expected)
{
    char text[1200];
    pm_error_format(err, text, sizeof text);
    assert_string_equal(text, expected);
}

static inline void assert_ok(pm_status st, const pm_error *err)
{
    char text[1200];
    pm_error_format(err, text, sizeof text);
    if (st)
        fail_msg("%s", text);
}

/* A compiled mesh of one square in the plane z = 1/2 of the unit cube, two triangles with the
 * materials `red` and `blue`; vertex 4 is in a second patch. */
static inline void put_mesh(pm_bytes *b)
{
    static const uint8_t corner[4][2] = {{0, 0}, {255, 0}, {255, 255}, {0, 255}};
    pm_bytes_text(b, "#?RADIANCE\nobj2mesh -a m.rad square.obj\nFORMAT=Radiance_tmesh\n\n");
    pm_portable_put_integer(b, PM_MESH_MAGIC + 4, 2);
    for (int i = 0; i < 3; i++)
        pm_portable_put_text(b, "0");
    pm_portable_put_text(b, "1");
    for (int i = 0; i < 2; i++) { /* range of u, of v */
        pm_portable_put_real(b, 0);
        pm_portable_put_real(b, 2);
    }
    pm_bytes_u8(b, PM_NODE_FULL);
    pm_portable_put_integer(b, 2, 4);
    pm_portable_put_integer(b, 0, 4);
    pm_portable_put_integer(b, 0x600, 4);
    pm_bytes_append(b, "plastic\0", 9);
    for (int i = 0; i < 2; i++) {
        pm_portable_put_integer(b, 0, 1);
        pm_portable_put_integer(b, -1, 4);
        pm_portable_put_text(b, i ? "blue" : "red");
        pm_portable_put_integer(b, 0, 2);
        pm_portable_put_integer(b, 5, 2);
        for (int k = 0; k < 5; k++)
            pm_portable_put_real(b, k == 2 * i ? .5 : 0);
    }
    pm_portable_put_integer(b, -1, 1);
    pm_portable_put_integer(b, 2, 4); /* patches */
    for (int patch = 0; patch < 2; patch++) {
        int first = patch ? 3 : 0, count = patch ? 1 : 3;
        pm_portable_put_integer(b, 7, 1); /* positions, normals, uv */
        pm_portable_put_integer(b, count, 2);
        for (int i = first; i < first + count; i++) {
            pm_portable_put_integer(b, (int64_t)corner[i][0] << 24, 4);
            pm_portable_put_integer(b, (int64_t)corner[i][1] << 24, 4);
            pm_portable_put_integer(b, (int64_t)1 << 31, 4);
        }
        for (int i = 0; i < count; i++)
            pm_portable_put_integer(b, 0x8, 4); /* x = y = 0, the rest is z */
        for (int i = first; i < first + count; i++) {
            pm_portable_put_integer(b, ((int64_t)corner[i][0] << 24) + 1, 4);
            pm_portable_put_integer(b, ((int64_t)corner[i][1] << 24) + 1, 4);
        }
        pm_portable_put_integer(b, patch ? 0 : 1, 2);
        if (!patch)
            pm_bytes_append(b, "\0\1\2", 3);
        pm_portable_put_integer(b, 1, 2); /* one material: red */
        pm_portable_put_integer(b, 0, 2);
        pm_portable_put_integer(b, 0, 2); /* none joins two patches by one corner */
        pm_portable_put_integer(b, patch, 2);
        if (patch) { /* 0 and 2 of the first patch, 0 of this one, blue */
            pm_portable_put_integer(b, 0, 4);
            pm_portable_put_integer(b, 2, 4);
            pm_portable_put_integer(b, 0, 1);
            pm_portable_put_integer(b, 1, 2);
        }
    }
    assert_int_equal(pm_bytes_status(b), PM_OK);
}

/* A frozen octree: a plastic, a sphere of it in every eighth, an alias. */
static inline void put_octree(pm_bytes *b)
{
    pm_bytes_text(b, "#?RADIANCE\noconv -f a.rad\nFORMAT=Radiance_octree\n\n\x01\x1f");
    pm_bytes_append(b,
                    "-1\0-1\0-1\0"
                    "2\0",
                    11);
    pm_bytes_append(b, "\0", 1);       /* no files: frozen */
    pm_bytes_append(b, "\0\0\0\3", 4); /* objects */
    pm_bytes_append(b, "\2", 1);       /* a node with eight children */
    for (int i = 0; i < 7; i++)
        pm_bytes_append(b, "\1\0\0\0\1\0\0\0\2", 9); /* full: the set {2} */
    pm_bytes_append(b, "\0", 1);                     /* empty */
    pm_bytes_append(b, "plastic\0sphere\0alias\0\0", 22);
    pm_bytes_append(b,
                    "\0\xff\xff\xff\xff"
                    "red\0\0\0\0\5",
                    13);
    for (int i = 0; i < 5; i++) /* 1/2 = 2^30 - 1 and a half, times 2^0 */
        pm_bytes_append(b, i ? "\0\0\0\0\0" : "\x3f\xff\xff\xff\0", 5);
    pm_bytes_append(b,
                    "\2\0\0\0\0"
                    "rot\0\0\0\0\0",
                    13);
    pm_bytes_append(b,
                    "\1\0\0\0\1"
                    "ball\0\0\0\0\4",
                    14);
    for (int i = 0; i < 4; i++)
        pm_bytes_append(b, i < 3 ? "\0\0\0\0\0" : "\x3f\xff\xff\xff\1", 5);
    pm_bytes_append(b, "\xff", 1);
    assert_int_equal(pm_bytes_status(b), PM_OK);
}

#endif
