#include "files_test.h"

#include <math.h>

#include "files/mesh.h"

static pm_status read(const void *data, size_t size, pm_mesh **out, pm_error *err)
{
    return pm_mesh_read(data, size, "m.rtm", NULL, out, err);
}

/* Positions are (code + 1/2) / 2^32 of the cube. */
static void a_compiled_mesh_is_read(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_error err = PM_ERROR_INIT;
    pm_mesh *mesh = NULL;
    put_mesh(&b);
    assert_ok(read(b.data, b.size, &mesh, &err), &err);
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(mesh->slot_count, 2);
    assert_string_equal(mesh->slots[1], "blue");
    const uint32_t corners[2][3] = {{0, 1, 2}, {0, 2, 3}};
    for (uint32_t i = 0; i < 2; i++) {
        const pm_mesh_triangle *t = &mesh->triangles[i];
        assert_memory_equal(t->corner, corners[i], sizeof corners[i]);
        assert_true(t->slot == i && t->has_normals && t->has_uv);
    }
    assert_true(mesh->positions[2].x == 255 / 256. + 0x1p-33);
    assert_true(mesh->positions[3].z == .5 + 0x1p-33);
    assert_true(mesh->uv[2][1] == 2 * (255 / 256. + 0x1.8p-32));
    assert_true(mesh->normals[0][0] == 0 && mesh->normals[0][1] == 0 &&
                mesh->normals[0][2] == 1);
    pm_mesh_free(mesh);
    pm_bytes_clear(&b);
}

static void its_materials_are_read(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_arena arena = {0};
    pm_records records;
    pm_error err = PM_ERROR_INIT;
    put_mesh(&b);
    assert_ok(pm_mesh_materials(b.data, b.size, "m.rtm", &arena, &records, &err), &err);
    assert_int_equal(records.count, 2);
    assert_string_equal(records.items[1].name, "blue");
    assert_true(records.items[1].reals[2] == .5 && records.items[0].reals[0] == .5);
    assert_ok(pm_mesh_materials("v 0 0 0\n", 8, "m.obj", &arena, &records, &err), &err);
    assert_int_equal(records.count, 0);
    pm_arena_clear(&arena);
    pm_bytes_clear(&b);
}

static size_t normal_at(const pm_bytes *b)
{
    static const uint8_t codes[12] = {0, 0, 0, 8, 0, 0, 0, 8, 0, 0, 0, 8};
    for (size_t i = 0; i + sizeof codes <= b->size; i++)
        if (memcmp(b->data + i, codes, sizeof codes) == 0)
            return i;
    fail_msg("no normals");
    return 0;
}

/* Two components in 13 bits of scale 1 / 11584.5, the largest from the unit length
 * (src/common/dircode.c): code bits 0-2 signs, 3 the first is x, 4 the second is z. */
static void normals_are_unit_and_signed(void **state)
{
    (void)state;
    const double s = 3000 / 11584.5, t = 5000 / 11584.5, rest = sqrt(1 - s * s - t * t);
    const struct {
        uint32_t flags;
        double n[3];
    } cases[] = {{8, {s, t, rest}},   {0, {t, s, rest}},    {24, {s, rest, t}},
                 {16, {rest, s, t}},  {9, {-s, t, rest}},   {2, {t, -s, rest}},
                 {28, {s, rest, -t}}, {31, {-s, -rest, -t}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pm_bytes b = {0};
        pm_mesh *mesh = NULL;
        pm_error err = PM_ERROR_INIT;
        uint32_t code = cases[i].flags | 3000u << 5 | 5000u << 18;
        put_mesh(&b);
        uint8_t *at = b.data + normal_at(&b);
        for (int k = 0; k < 4; k++)
            at[k] = (uint8_t)(code >> (24 - 8 * k));
        assert_ok(read(b.data, b.size, &mesh, &err), &err);
        for (int k = 0; k < 3; k++)
            assert_true(fabs(mesh->normals[0][k] - cases[i].n[k]) < 1e-7);
        pm_mesh_free(mesh);
        pm_bytes_clear(&b);
    }
}

static void a_vertex_without_normal_has_none(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_mesh *mesh = NULL;
    pm_error err = PM_ERROR_INIT;
    put_mesh(&b);
    b.data[normal_at(&b) + 7] = 0; /* of vertex 1 */
    assert_ok(read(b.data, b.size, &mesh, &err), &err);
    assert_false(mesh->triangles[0].has_normals);
    assert_true(mesh->triangles[1].has_normals);
    pm_mesh_free(mesh);
    pm_bytes_clear(&b);
}

static void every_cut_is_refused(void **state)
{
    (void)state;
    pm_bytes b = {0};
    put_mesh(&b);
    for (size_t size = 2; size < b.size; size++) { /* shorter ones are no rtm */
        pm_mesh *mesh = NULL;
        pm_error err = PM_ERROR_INIT;
        void *copy = malloc(size);
        memcpy(copy, b.data, size);
        assert_int_equal(read(copy, size, &mesh, &err), PM_E_CORRUPT);
        assert_true(!mesh && err.text[0] && strcmp(err.file, "m.rtm") == 0);
        free(copy);
    }
    pm_bytes_clear(&b);
}

static void no_changed_byte_does_harm(void **state)
{
    (void)state;
    pm_bytes b = {0};
    put_mesh(&b);
    for (size_t i = 0; i < b.size; i++) {
        for (int bit = 0; bit < 8; bit++) {
            pm_mesh *mesh = NULL;
            pm_error err = PM_ERROR_INIT;
            b.data[i] ^= (uint8_t)(1 << bit);
            pm_status st = read(b.data, b.size, &mesh, &err);
            assert_int_equal(st, err.status);
            for (uint32_t k = 0; !st && k < mesh->triangle_count; k++)
                assert_true(mesh->triangles[k].corner[2] < mesh->vertex_count);
            pm_mesh_free(mesh);
            b.data[i] ^= (uint8_t)(1 << bit);
        }
    }
    pm_bytes_clear(&b);
}

static void bytes_after_the_end_are_refused(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_mesh *mesh = NULL;
    pm_error err = PM_ERROR_INIT;
    put_mesh(&b);
    pm_bytes_u8(&b, 0);
    assert_int_equal(read(b.data, b.size, &mesh, &err), PM_E_CORRUPT);
    pm_bytes_clear(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_compiled_mesh_is_read),
        cmocka_unit_test(its_materials_are_read),
        cmocka_unit_test(normals_are_unit_and_signed),
        cmocka_unit_test(a_vertex_without_normal_has_none),
        cmocka_unit_test(every_cut_is_refused),
        cmocka_unit_test(no_changed_byte_does_harm),
        cmocka_unit_test(bytes_after_the_end_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
