#include "files_test.h"

#include <math.h>

#include "base/maths.h"
#include "files/mesh.h"

static pm_mesh *mesh_of(const char *text)
{
    pm_error err = PM_ERROR_INIT;
    pm_mesh *mesh = NULL;
    assert_ok(pm_mesh_read(text, strlen(text), "m.obj", NULL, &mesh, &err), &err);
    assert_non_null(mesh);
    return mesh;
}

static void assert_refused(const char *text, const char *message)
{
    pm_error err = PM_ERROR_INIT;
    pm_mesh *mesh = NULL;
    if (!pm_mesh_read(text, strlen(text), "m.obj", NULL, &mesh, &err))
        fail_msg("accepted instead of: %s", message);
    assert_null(mesh);
    assert_message(&err, message);
}

static double area(const pm_mesh *mesh)
{
    double sum = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *c = mesh->triangles[i].corner;
        pm_vec3 a = pm_vec3_sub(mesh->positions[c[1]], mesh->positions[c[0]]);
        pm_vec3 b = pm_vec3_sub(mesh->positions[c[2]], mesh->positions[c[0]]);
        sum += pm_vec3_length(pm_vec3_cross(a, b)) / 2;
    }
    return sum;
}

#define SQUARE "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n"

static void faces_become_triangles(void **state)
{
    (void)state;
    pm_mesh *mesh = mesh_of("# a square\n" SQUARE "f 1 2 3 4\n");
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->triangle_count, 2);
    assert_true(area(mesh) == 4);
    assert_true(mesh->low.x == 0 && mesh->high.x == 2 && mesh->high.z == 0);
    assert_null(mesh->normals);
    assert_null(mesh->uv);
    assert_int_equal(mesh->slot_count, 0);
    for (int i = 0; i < 2; i++) {
        const pm_mesh_triangle *t = &mesh->triangles[i];
        assert_true(t->slot == PM_MESH_NO_SLOT && !t->has_normals && !t->has_uv);
    }
    pm_mesh_free(mesh);
}

/* A star of ten corners and a square with a square hole, joined by a seam. */
static void concave_faces_keep_their_area(void **state)
{
    (void)state;
    char text[2048], *at = text;
    double expected = 0, p[10][2];
    for (int i = 0; i < 10; i++) {
        double r = i % 2 ? 1 : 3;
        p[i][0] = r * cos(PM_PI * i / 5);
        p[i][1] = r * sin(PM_PI * i / 5);
        at += sprintf(at, "v 1 %.17g %.17g\n", p[i][0], p[i][1]);
    }
    for (int i = 0; i < 10; i++)
        expected += p[i][0] * p[(i + 1) % 10][1] - p[(i + 1) % 10][0] * p[i][1];
    strcpy(at, "f 1 2 3 4 5 6 7 8 9 10\n");
    pm_mesh *star = mesh_of(text);
    assert_int_equal(star->triangle_count, 8);
    assert_true(fabs(area(star) - expected / 2) < 1e-14 * expected);
    pm_mesh_free(star);
    pm_mesh *frame = mesh_of(SQUARE "v .5 .5 0\nv .5 1.5 0\nv 1.5 1.5 0\nv 1.5 .5 0\n"
                                    "f 1 2 3 4 1 5 6 7 8 5\n");
    assert_true(area(frame) == 3);
    pm_mesh_free(frame);
}

static void indices_count_backwards(void **state)
{
    (void)state;
    pm_mesh *mesh = mesh_of(SQUARE "f -4 -3 -2\nv 9 9 9\nf -5 -3 4\n");
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(mesh->vertex_count, 4);
    assert_true(mesh->high.z == 0);
    pm_mesh_free(mesh);
}

static void materials_and_groups_name_slots(void **state)
{
    (void)state;
    pm_mesh *mesh = mesh_of(SQUARE "f 1 2 3\ng hull deck\nf 1 2 3\nusemtl red\nf 1 2 3\n"
                                   "g other\nusemtl blue\nf 1 2 3\nusemtl red\nf 1 2 3\n"
                                   "usemtl void\nf 1 2 3\nusemtl\nf 1 2 3\ng\nf 1 2 3\n");
    const uint32_t none = PM_MESH_NO_SLOT, slots[] = {none, 0, 1, 2, 1, none, 3, none};
    assert_int_equal(mesh->slot_count, 4);
    const char *const names[] = {"hull", "red", "blue", "other"};
    for (int i = 0; i < 4; i++)
        assert_string_equal(mesh->slots[i], names[i]);
    for (int i = 0; i < 8; i++)
        assert_int_equal(mesh->triangles[i].slot, slots[i]);
    pm_mesh_free(mesh);
}

/* Radiance's flat_tri (src/common/tmesh.c): all normals back turns the triangle, all within
 * acos .999995 of its own are dropped. */
static void normals_turn_and_smooth(void **state)
{
    (void)state;
    pm_mesh *mesh = mesh_of(SQUARE "vn 0 0 2\nvn 0 .2 1\nvn 0 0 -1\nvn .1 0 -1\n"
                                   "f 1//1 2//1 3//1\nf 1//2 2//1 3//1\nf 1//3 2//3 3//3\n"
                                   "f 1//4 2//3 3//3\nf 1//2 2 3//1\n");
    const int has[] = {0, 1, 0, 1, 0}, turned[] = {0, 0, 1, 1, 0};
    assert_int_equal(mesh->triangle_count, 5);
    for (int i = 0; i < 5; i++) {
        const pm_mesh_triangle *t = &mesh->triangles[i];
        assert_int_equal(t->has_normals, has[i]);
        pm_vec3 first = mesh->positions[t->corner[0]];
        assert_true((first.x == 2 && first.y == 2) == turned[i]);
    }
    const float *n = mesh->normals[mesh->triangles[3].corner[2]];
    assert_true(fabs(n[0] - .1 / sqrt(1.01)) < 1e-7 && fabs(n[2] + 1 / sqrt(1.01)) < 1e-7);
    pm_mesh_free(mesh);
}

static void texture_coordinates_are_kept(void **state)
{
    (void)state;
    pm_mesh *mesh = mesh_of(SQUARE "vt .25 .75\nvt 1\nvt 5 6 7\nf 1/1 2/2 3/3\nf 1/1 2/2 3\n");
    assert_int_equal(mesh->vertex_count, 4); /* the third point with and without */
    assert_true(mesh->triangles[0].has_uv && !mesh->triangles[1].has_uv);
    const double(*uv)[2] = mesh->uv;
    const uint32_t *c = mesh->triangles[0].corner;
    assert_true(uv[c[0]][0] == .25 && uv[c[0]][1] == .75 && uv[c[1]][0] == 1 &&
                uv[c[1]][1] == 0 && uv[c[2]][1] == 6);
    pm_mesh_free(mesh);
}

static void lines_continue_and_end_in_any_way(void **state)
{
    (void)state;
    pm_mesh *mesh = mesh_of("v 0 0 \\\n 0 1\r\nv 1 0 0 .5 .5 .5\r\nv 0 1 0\n\n"
                            "o thing\ns off\nmtllib x.mtl\nl 1 2\nf 1 2 \\\r\n 3");
    assert_int_equal(mesh->triangle_count, 1);
    pm_mesh_free(mesh);
}

static void faces_without_area_are_left_out(void **state)
{
    (void)state;
    pm_mesh *mesh = mesh_of(SQUARE "v 1 0 0\nf 1 5 2\nf 1 1 2\nf 1 5 2 5\nf 1 2 3\n");
    assert_int_equal(mesh->triangle_count, 1);
    pm_mesh_free(mesh);
    assert_refused(SQUARE "f 1 1 2\n", "m.obj: the mesh has no triangle with an area");
}

static void what_is_wrong_is_named(void **state)
{
    (void)state;
    assert_refused("", "m.obj: the mesh has no triangle with an area");
    assert_refused("v 0 0\n", "m.obj:1:6: the line ends, but a point's z should come here");
    assert_refused("v 0 x 0\n", "m.obj:1:5: 'x' is no number; a point's y should come here");
    assert_refused("v 0 nan 0\n",
                   "m.obj:1:5: 'nan' is no number; a point's y should come here");
    assert_refused("v 0 0 1e400\n",
                   "m.obj:1:7: a point's z is 1e400; at most 1e+75 can be handled");
    assert_refused("v 0 0 -1e80\n",
                   "m.obj:1:7: a point's z is -1e80; at most 1e+75 can be handled");
    assert_refused("\nvn 0 0 0\n", "m.obj:2:1: a normal has no length; write a direction");
    assert_refused(SQUARE "f 1 2\n", "m.obj:5:1: a face has at least 3 corners; here are 2");
    assert_refused(SQUARE "f 1 2 5\n",
                   "m.obj:5:7: there is no point 5; 4 stand above this line");
    assert_refused(SQUARE "f 1 2 -5\n",
                   "m.obj:5:7: there is no point -5; 4 stand above this line");
    assert_refused(SQUARE "f 1 2 0\n",
                   "m.obj:5:7: there is no point 0; 4 stand above this line");
    assert_refused(SQUARE "f 1/1 2 3\n",
                   "m.obj:5:3: there is no texture coordinate 1; 0 stand above this line");
    assert_refused(SQUARE "f 1//2 2 3\n",
                   "m.obj:5:3: there is no normal 2; 0 stand above this line");
    assert_refused(SQUARE "f a 2 3\n", "m.obj:5:3: 'a' is no corner of a face; write v, v/t, "
                                       "v//n or v/t/n");
    assert_refused(SQUARE "f 1///1 2 3\n",
                   "m.obj:5:3: '1///1' is no corner of a face; write v, "
                   "v/t, v//n or v/t/n");
    assert_refused(SQUARE "f 1 3 2 4\n", "m.obj:5:1: the edges of this face cross each other; "
                                         "divide it into triangles");
    assert_refused(
        "v 0 3 0\nv 2 -3 0\nv -3 1 0\nv 3 1 0\nv -2 -3 0\nf 1 2 3 4 5\n",
        "m.obj:6:1: the edges of this face cross each other; divide it into triangles");
    assert_refused("cstype bezier\n", "m.obj:1:1: 'cstype' belongs to a curved surface; write "
                                      "the model as polygons");
    assert_refused("void plastic a\n",
                   "m.obj:1:1: 'void' is no statement of a Wavefront .obj file");
}

static void too_many_triangles_are_refused(void **state)
{
    (void)state;
    const pm_mesh_limits limits = {.triangles = 1};
    pm_error err = PM_ERROR_INIT;
    pm_mesh *mesh = NULL;
    static const char text[] = SQUARE "f 1 2 3 4\n";
    assert_int_equal(pm_mesh_read(text, sizeof text - 1, "m.obj", &limits, &mesh, &err),
                     PM_E_LIMIT);
    assert_message(&err, "m.obj: the mesh has more than 1 triangles; split it");
}

/* The same point with other normals and other materials each time: no list may be walked. */
static void no_choice_of_corners_is_slow(void **state)
{
    (void)state;
    enum { FACES = 60000 };
    char *text = malloc(FACES * 64), *at = text;
    assert_non_null(text);
    at += sprintf(at, SQUARE);
    for (int i = 0; i < FACES; i++)
        at += sprintf(at, "vn %d 1 1\nusemtl m%d\nf 1//%d 2 3\n", i, i, i + 1);
    pm_mesh *mesh = mesh_of(text);
    assert_int_equal(mesh->slot_count, FACES);
    assert_int_equal(mesh->vertex_count, FACES + 2);
    pm_mesh_free(mesh);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faces_become_triangles),
        cmocka_unit_test(concave_faces_keep_their_area),
        cmocka_unit_test(indices_count_backwards),
        cmocka_unit_test(materials_and_groups_name_slots),
        cmocka_unit_test(normals_turn_and_smooth),
        cmocka_unit_test(texture_coordinates_are_kept),
        cmocka_unit_test(lines_continue_and_end_in_any_way),
        cmocka_unit_test(faces_without_area_are_left_out),
        cmocka_unit_test(what_is_wrong_is_named),
        cmocka_unit_test(too_many_triangles_are_refused),
        cmocka_unit_test(no_choice_of_corners_is_slow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
