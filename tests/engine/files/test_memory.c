#include "files_test.h"

#include "../../support/failing_malloc.h"
#include "files/bsdf.h"
#include "files/data.h"
#include "files/font.h"
#include "files/mesh.h"
#include "files/octree_file.h"
#include "files/picture.h"

typedef pm_status reader(const pm_bytes *bytes, pm_error *err);

static pm_status read_mesh(const pm_bytes *bytes, pm_error *err)
{
    pm_mesh *mesh = NULL;
    pm_status st = pm_mesh_read(bytes->data, bytes->size, "m", NULL, &mesh, err);
    assert_true(!st == (mesh != NULL));
    pm_mesh_free(mesh);
    return st;
}

static pm_status read_materials(const pm_bytes *bytes, pm_error *err)
{
    pm_arena arena = {0};
    pm_records records;
    pm_status st = pm_mesh_materials(bytes->data, bytes->size, "m", &arena, &records, err);
    pm_arena_clear(&arena);
    return st;
}

static pm_status read_octree(const pm_bytes *bytes, pm_error *err)
{
    pm_arena arena = {0};
    pm_octree_file file;
    pm_status st =
        pm_octree_file_read(bytes->data, bytes->size, "m", 1000000, &arena, &file, err);
    pm_arena_clear(&arena);
    return st;
}

static pm_status read_data(const pm_bytes *bytes, pm_error *err)
{
    pm_data *data = NULL;
    pm_status st = pm_data_read(bytes->data, bytes->size, "m", &data, err);
    assert_true(!st == (data != NULL));
    pm_data_free(data);
    return st;
}

static pm_status read_picture(const pm_bytes *bytes, pm_error *err)
{
    pm_picture *picture = NULL;
    pm_status st = pm_picture_read(bytes->data, bytes->size, "m", &picture, err);
    assert_true(!st == (picture != NULL));
    pm_picture_free(picture);
    return st;
}

static pm_status read_font(const pm_bytes *bytes, pm_error *err)
{
    pm_font *font = NULL;
    pm_arena arena = {0};
    const pm_text *text;
    pm_status st = pm_font_read(bytes->data, bytes->size, "m", &font, err);
    assert_true(!st == (font != NULL));
    if (!st)
        st = pm_text_new(font, "A\nAA", 4, NULL, &arena, &text, err);
    pm_arena_clear(&arena);
    pm_font_free(font);
    return st;
}

static void assert_sweep(reader *read, const pm_bytes *bytes, long at_least)
{
    long n = 0;
    for (pm_status st = PM_E_MEMORY; st; n++) {
        pm_error err = PM_ERROR_INIT;
        until_failure = n;
        st = read(bytes, &err);
        until_failure = -1;
        if (st) {
            assert_int_equal(st, PM_E_MEMORY);
            assert_int_equal(err.status, PM_E_MEMORY);
        }
    }
    assert_true(n > at_least);
}

static void compiled_meshes(void **state)
{
    (void)state;
    pm_bytes b = {0};
    put_mesh(&b);
    assert_sweep(read_mesh, &b, 8);
    assert_sweep(read_materials, &b, 2);
    pm_bytes_clear(&b);
}

static void wavefront_meshes(void **state)
{
    (void)state;
    pm_bytes b = {0};
    for (int i = 0; i < 300; i++)
        pm_bytes_format(&b, "usemtl m%d\nv %d 0 %d\nvn 1 0 %d\nvt %d 0\n", i, i, i * i % 7, i,
                        i);
    for (int i = 1; i < 295; i++)
        pm_bytes_format(&b, "f %d/%d/%d %d/%d/%d %d/%d/%d\n", i, i, i, i + 1, i, i, i + 2, 1,
                        1);
    pm_bytes_text(&b, "v 0 0 0\nv 1 0 0\nv .5 .5 0\nv 1 1 0\nv 0 1 0\nf -5 -4 -3 -2 -1\n");
    assert_sweep(read_mesh, &b, 20);
    pm_bytes_clear(&b);
}

static void octrees(void **state)
{
    (void)state;
    pm_bytes b = {0};
    put_octree(&b);
    assert_sweep(read_octree, &b, 3);
    pm_bytes_clear(&b);
}

static void data_pictures_and_fonts(void **state)
{
    (void)state;
    pm_bytes data = {0}, picture = {0}, font = {0};
    pm_bytes_text(&data, "2\n0 0 2000\n");
    for (int i = 0; i < 2000; i++)
        pm_bytes_format(&data, "%d\n", i);
    pm_bytes_text(&data, "0 1 2\n");
    for (int i = 0; i < 4000; i++)
        pm_bytes_format(&data, "%d\n", i);
    assert_sweep(read_data, &data, 1);
    pm_bytes_text(&picture, "#?RADIANCE\n\n-Y 1 +X 2\nabcdefgh");
    assert_sweep(read_picture, &picture, 2);
    pm_bytes_text(&font, "66 20000\n");
    for (int i = 0; i < 20000; i++)
        pm_bytes_text(&font, "7 9\n");
    pm_bytes_text(&font, "65 3 0 0 255 0 128 255\n");
    assert_sweep(read_font, &font, 1);
    pm_bytes_clear(&data);
    pm_bytes_clear(&picture);
    pm_bytes_clear(&font);
}

static pm_status read_bsdf(const pm_bytes *bytes, pm_error *err)
{
    pm_bsdf *bsdf = NULL;
    pm_status st = pm_bsdf_read(bytes->data, bytes->size, "m", &bsdf, err);
    assert_true(!st == (bsdf != NULL));
    pm_bsdf_free(bsdf);
    return st;
}

static void put_bsdf(pm_bytes *b, const char *structure, const char *basis, const char *data)
{
    static const char *const directions[3] = {"Transmission Front", "Reflection Front",
                                              "Reflection Back"};
    pm_bytes_format(b,
                    "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>%s"
                    "</IncidentDataStructure><AngleBasis><AngleBasisName>two</AngleBasisName>"
                    "<AngleBasisBlock><nPhis>2</nPhis><ThetaBounds><UpperTheta>90</UpperTheta>"
                    "</ThetaBounds></AngleBasisBlock></AngleBasis></DataDefinition>",
                    structure);
    for (int i = 0; i < 3; i++)
        pm_bytes_format(b,
                        "<WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>"
                        "<WavelengthDataDirection>%s</WavelengthDataDirection>%s"
                        "<ScatteringData>%s</ScatteringData></WavelengthDataBlock>"
                        "</WavelengthData>",
                        directions[i], basis, data);
    pm_bytes_text(b, "</Layer></Optical></WindowElement>");
}

static void bsdfs(void **state)
{
    (void)state;
    pm_bytes b = {0};
    put_bsdf(&b, "Columns",
             "<ColumnAngleBasis>two</ColumnAngleBasis><RowAngleBasis>two</RowAngleBasis>",
             ".1 .2 .1 .05");
    assert_sweep(read_bsdf, &b, 20);
    pm_bytes_clear(&b);
    put_bsdf(&b, "TensorTree3", "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>",
             "{{.1}{.2}{.1}{.1}{.05}{.1}{.1}{.1 .1 .1 .1 .2 .2 .2 .2}}");
    assert_sweep(read_bsdf, &b, 20);
    pm_bytes_clear(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(compiled_meshes),
        cmocka_unit_test(wavefront_meshes),
        cmocka_unit_test(octrees),
        cmocka_unit_test(bsdfs),
        cmocka_unit_test(data_pictures_and_fonts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
