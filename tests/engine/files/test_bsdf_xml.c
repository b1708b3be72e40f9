#include "bsdf_test.h"

/* ---- what is refused, and how that is said ---- */

#define OPEN   "<WindowElement><Optical><Layer>"
#define CLOSE  "</Layer></Optical></WindowElement>"
#define MATRIX "<DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure>"
#define TREE3                                                                                  \
    "<DataDefinition><IncidentDataStructure>TensorTree3</IncidentDataStructure>"               \
    "</DataDefinition>\n"
#define ONE                                                                                    \
    MATRIX "<AngleBasis><AngleBasisName>one</AngleBasisName><AngleBasisBlock><nPhis>1</nPhis>" \
           "<ThetaBounds><LowerTheta>0</LowerTheta><UpperTheta>90</UpperTheta></ThetaBounds>"  \
           "</AngleBasisBlock></AngleBasis></DataDefinition>\n"
#define BLOCK(wavelength, direction)                                                           \
    "<WavelengthData><Wavelength>" wavelength "</Wavelength><WavelengthDataBlock>"             \
    "<WavelengthDataDirection>" direction "</WavelengthDataDirection>\n"
#define BASES(column, row)                                                                     \
    "<ColumnAngleBasis>" column "</ColumnAngleBasis><RowAngleBasis>" row "</RowAngleBasis>"
#define SHIRLEY   "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>"
#define DATA(...) "<ScatteringData>" __VA_ARGS__ "</ScatteringData>"
#define END_BLOCK "</WavelengthDataBlock></WavelengthData>"
#define TREE(data)                                                                             \
    OPEN TREE3 BLOCK("Visible", "Reflection Back") SHIRLEY DATA(data)                          \
    END_BLOCK CLOSE
#define GOOD                                                                                   \
    OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("0.1") END_BLOCK CLOSE

static const struct {
    const char *text, *message;
} bad[] = {
    {"", "b.xml:1:1: not well-formed XML: no element found"},
    {"<WindowElement>", "b.xml:1:16: not well-formed XML: no element found"},
    {"<WindowElement></Window>", "b.xml:1:18: not well-formed XML: mismatched tag"},
    {"<radiance/>", "b.xml:1:1: the outermost element is 'radiance'; a BSDF file's is "
                    "WindowElement"},
    {"<!DOCTYPE WindowElement [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;\">]>" GOOD,
     "b.xml:1:25: a document type declaration, which BSDF files do without; entities are not "
     "read"},
    {"<!DOCTYPE WindowElement SYSTEM \"file:///etc/passwd\">" GOOD,
     "b.xml:1:52: a document type declaration, which BSDF files do without; entities are not "
     "read"},
    {"<WindowElement>&lol;</WindowElement>",
     "b.xml:1:16: not well-formed XML: undefined entity"},
    {"<WindowElement><FileType>IES</FileType></WindowElement>",
     "b.xml:1:29: FileType 'IES'; a BSDF file's is BSDF"},
    {"<WindowElement></WindowElement>", "b.xml:1:1: no WindowElement/Optical/Layer in it"},
    {OPEN CLOSE, "b.xml:1:1: no WavelengthData of Wavelength Visible in its first Layer"},
    {OPEN "<Material><Thickness unit=\"cubit\">1</Thickness></Material>" CLOSE,
     "b.xml:1:42: unknown unit 'cubit'; known are Meter, Foot, Inch, Centimeter and "
     "Millimeter"},
    {OPEN "<Material><Width>wide</Width></Material>" CLOSE,
     "b.xml:1:53: a dimension is 'wide', which is not a number"},
    {OPEN "<Material><Width>-1</Width></Material>" CLOSE, "b.xml:1:51: a dimension below 0"},
    {OPEN "<Geometry format=\"STEP\"/>" CLOSE,
     "b.xml:1:32: geometry of format 'STEP'; known is MGF"},
    {OPEN "<DataDefinition><IncidentDataStructure>Diagonals</IncidentDataStructure>",
     "b.xml:1:80: IncidentDataStructure 'Diagonals'; known are Columns, Rows, TensorTree3 and "
     "TensorTree4"},
    {OPEN BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("1"),
     "b.xml:2:75: the IncidentDataStructure must stand before the first ScatteringData"},
    {OPEN ONE "<WavelengthData><WavelengthDataBlock>",
     "b.xml:2:17: the Wavelength must stand before its WavelengthDataBlock"},
    {OPEN ONE BLOCK("Visible", "Sideways"),
     "b.xml:2:103: WavelengthDataDirection 'Sideways'; known are Transmission Front, "
     "Transmission Back, Reflection Front and Reflection Back"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "two") DATA("1") END_BLOCK,
     "b.xml:3:109: RowAngleBasis 'two' is not defined; known without definition are LBNL/Klems "
     "Full, Half and Quarter"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") DATA("1") END_BLOCK,
     "b.xml:3:35: a WavelengthDataBlock without ColumnAngleBasis"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") END_BLOCK,
     "b.xml:3:75: a WavelengthDataBlock without ScatteringData"},
    {OPEN ONE "<WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>" DATA("1")
         END_BLOCK,
     "b.xml:2:104: a WavelengthDataBlock without WavelengthDataDirection"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("1 2") END_BLOCK,
     "b.xml:3:111: 2 values in the ScatteringData of line 2, but 1 x 1 directions"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("") END_BLOCK,
     "b.xml:3:108: 0 values in the ScatteringData of line 2, but 1 x 1 directions"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("1\nnan 2"),
     "b.xml:4:1: 'nan' among the ScatteringData is not a number"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("0x1p3 "),
     "b.xml:3:91: '0x1p3' among the ScatteringData is not a number"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("1e99 "),
     "b.xml:3:91: '1e99' among the ScatteringData is not a number"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("{1}"),
     "b.xml:3:91: a '{' among the values of a matrix"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("1") DATA("1"),
     "b.xml:3:109: a second ScatteringData in the same WavelengthDataBlock"},
    {OPEN ONE BLOCK("CIE-X", "Reflection Back") BASES("one", "one") DATA("1") END_BLOCK BLOCK(
         "Visible", "Reflection Front") BASES("one", "one") DATA(".1") END_BLOCK CLOSE,
     "b.xml:2:1: colour without the Visible data of the same direction"},
    {OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("1") END_BLOCK CLOSE,
     "b.xml:1:1: reflects and transmits 3.14 times the light that comes from 0 degrees off the "
     "normal inside; values are per steradian, and at most all of it can leave"},
    {OPEN MATRIX "<AngleBasis><AngleBasisName>x</AngleBasisName></AngleBasis>",
     "b.xml:1:148: an AngleBasis needs an AngleBasisName and an AngleBasisBlock"},
    {OPEN MATRIX "<AngleBasis><AngleBasisBlock><nPhis>3</nPhis></AngleBasisBlock>",
     "b.xml:1:147: an AngleBasisBlock needs UpperTheta and nPhis"},
    {OPEN MATRIX "<AngleBasis><AngleBasisBlock><nPhis>0</nPhis><ThetaBounds><UpperTheta>9"
                 "</UpperTheta></ThetaBounds></AngleBasisBlock>",
     "b.xml:1:200: a ring up to 9 degrees of 0 patches; angles must rise to at most 90, only "
     "the first ring may have a single patch, and a basis at most 46 rings and 2048 patches"},
    {OPEN MATRIX "<AngleBasis><AngleBasisBlock><nPhis>4</nPhis><ThetaBounds><UpperTheta>9"
                 "</UpperTheta></ThetaBounds></AngleBasisBlock><AngleBasisBlock><nPhis>4"
                 "</nPhis><ThetaBounds><LowerTheta>10</LowerTheta><UpperTheta>90</UpperTheta>"
                 "</ThetaBounds></AngleBasisBlock>",
     "b.xml:1:332: LowerTheta is 10, but the ring before ends at 9"},
    {OPEN TREE3 BLOCK("Visible", "Reflection Back") DATA("{.1}") END_BLOCK,
     "b.xml:3:38: a WavelengthDataBlock without AngleBasis"},
    {OPEN TREE3 BLOCK("Visible",
                      "Reflection Back") "<AngleBasis>LBNL/Klems Full</AngleBasis>" DATA("{.1}")
         END_BLOCK,
     "b.xml:3:78: AngleBasis 'LBNL/Klems Full'; that of a tensor tree is LBNL/Shirley-Chiu"},
    {TREE(".1 "), "b.xml:3:61: a value outside the braces of a tensor tree"},
    {TREE(""), "b.xml:3:59: ScatteringData without a tensor tree"},
    {TREE("{.1"), "b.xml:3:62: a tensor tree lacks its '}'"},
    {TREE("{}"), "b.xml:3:60: an empty '{}' in a tensor tree"},
    {TREE("}"), "b.xml:3:59: a '}' without its '{' in a tensor tree"},
    {TREE("{.1}{.1}"), "b.xml:3:63: the tensor tree is complete, but a '{' follows"},
    {TREE("{.1 .2}"), "b.xml:3:65: 2 values in a tensor tree's grid; a power of 8 is due"},
    {TREE("{.1 {.2}}"), "b.xml:3:63: a '{' among the values of a tensor tree's grid"},
    {TREE("{{.1} .2 }"), "b.xml:3:67: a value among the branches of a tensor tree"},
    {TREE("{{.1}{.1}}"), "b.xml:3:68: 2 parts in a branch of a tensor tree; 8 are due"},
    {TREE("{{1}{1}{1}{1}{1}{1}{1}{1}{1}}"),
     "b.xml:3:84: a branch of a tensor tree has 8 parts, not more"},
    {TREE("{{{{{{{{{{{{{{{{{{"), "b.xml:3:72: a tensor tree of more than 12 levels"},
    {OPEN ONE BLOCK("Visible", "Reflection Back")
         BASES("0123456789012345678901234567890123456789012345678901234567890123456789012345678"
               "901234567890123456789012345678901234567890123456789",
               "one"),
     "b.xml:3:149: text of more than 127 characters where a word is due"},
};

static void bad_files_say_what_is_wrong(void **state)
{
    (void)state;
    int wrong = 0;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        pm_bsdf *bsdf = NULL;
        pm_error err = PM_ERROR_INIT;
        char text[1200] = "(accepted)";
        pm_status st = pm_bsdf_read(bad[i].text, strlen(bad[i].text), "b.xml", &bsdf, &err);
        if (st)
            pm_error_format(&err, text, sizeof text);
        if (!st || st != err.status || bsdf || strcmp(text, bad[i].message) != 0) {
            print_error("%zu says %s\n  not %s\n", i, text, bad[i].message);
            wrong++;
        }
        pm_bsdf_free(bsdf);
    }
    assert_int_equal(wrong, 0);
}

static pm_status read_text(const char *text, size_t size)
{
    pm_bsdf *bsdf = NULL;
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_bsdf_read(text, size, "b.xml", &bsdf, &err);
    assert_int_equal(st, err.status);
    pm_bsdf_free(bsdf);
    return st;
}

static void good_file_is_read(void **state)
{
    (void)state;
    assert_int_equal(read_text(GOOD, strlen(GOOD)), PM_OK);
}

static void cut_files_are_refused(void **state)
{
    (void)state;
    for (size_t cut = 0; cut < strlen(GOOD); cut++)
        assert_true(read_text(GOOD, cut) != PM_OK);
}

static void nesting_is_bounded(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_bytes_text(&b, "<WindowElement>");
    for (int i = 0; i < 100000; i++)
        pm_bytes_text(&b, "<a>");
    assert_int_equal(read_text((const char *)b.data, b.size), PM_E_LIMIT);
    pm_bytes_clear(&b);
}

/* Unknown elements, layers after the first, geometry: nothing of them counts. */
static void what_bears_no_light_is_passed_over(void **state)
{
    (void)state;
    static const char text[] =
        "<?xml version=\"1.0\"?><WindowElement xmlns=\"x\"><FileType> BSDF </FileType>"
        "<Note><Optical><Layer/></Optical></Note><Optical><Layer>"
        "<Geometry format=\"MGF\"><MGFblock unit=\"Meter\">\nxf -t 0 0 "
        "1\n</MGFblock></Geometry>" ONE BLOCK("visible", "reflection BACK") BASES("ONE", "one")
            DATA(" 1e-1,\n") END_BLOCK
        "                                                                                "
        "                                                                                "
        "</Layer><Layer>" BLOCK("Visible", "Reflection Back") BASES("one", "one") DATA("?")
            END_BLOCK CLOSE;
    pm_bsdf *bsdf = NULL;
    pm_error err = PM_ERROR_INIT;
    assert_ok(pm_bsdf_read(text, sizeof text - 1, "b.xml", &bsdf, &err), &err);
    assert_grey(pm_bsdf_diffuse_reflectance(bsdf, (pm_vec3){0, 0, 1}), .1 * PM_PI, 1e-6);
    pm_bsdf_info info;
    pm_bsdf_info_get(bsdf, &info);
    assert_true(info.has_geometry);
    pm_bsdf_free(bsdf);
}

static void negative_values_are_nothing(void **state)
{
    (void)state;
    static const char text[] = OPEN ONE BLOCK("Visible", "Reflection Back") BASES("one", "one")
        DATA("-3") END_BLOCK CLOSE;
    pm_bsdf *bsdf = NULL;
    pm_error err = PM_ERROR_INIT;
    assert_ok(pm_bsdf_read(text, sizeof text - 1, "b.xml", &bsdf, &err), &err);
    assert_grey(pm_bsdf_diffuse_reflectance(bsdf, (pm_vec3){0, 0, 1}), 0, 0);
    pm_bsdf_free(bsdf);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_files_say_what_is_wrong),
        cmocka_unit_test(good_file_is_read),
        cmocka_unit_test(cut_files_are_refused),
        cmocka_unit_test(nesting_is_bounded),
        cmocka_unit_test(what_bears_no_light_is_passed_over),
        cmocka_unit_test(negative_values_are_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
