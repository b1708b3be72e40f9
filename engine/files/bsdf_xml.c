/* The XML of BSDF files: what stands in which element. Values go to bsdf_values.c. */
#include <expat.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "files/bsdf_internal.h"
#include "files/bsdf_values.h"

/* ---- elements ---- */

enum tag {
    OTHER, /* anything that bears no light; so is all that it holds */
    ROOT,
    WINDOW_ELEMENT,
    FILE_TYPE,
    OPTICAL,
    LAYER,
    MATERIAL,
    WIDTH,
    HEIGHT,
    THICKNESS,
    GEOMETRY,
    MGF_BLOCK,
    DATA_DEFINITION,
    STRUCTURE,
    BASIS,
    BASIS_NAME,
    BASIS_BLOCK,
    THETA_BOUNDS,
    LOWER_THETA,
    UPPER_THETA,
    PHI_COUNT,
    WAVELENGTH_DATA,
    WAVELENGTH,
    BLOCK,
    DIRECTION,
    COLUMN_BASIS,
    ROW_BASIS,
    TREE_BASIS,
    SCATTERING,
};

static const struct element {
    enum tag parent, tag;
    const char *name;
} elements[] = {
    {ROOT, WINDOW_ELEMENT, "WindowElement"},
    {WINDOW_ELEMENT, FILE_TYPE, "FileType"},
    {WINDOW_ELEMENT, OPTICAL, "Optical"},
    {OPTICAL, LAYER, "Layer"},
    {LAYER, MATERIAL, "Material"},
    {MATERIAL, WIDTH, "Width"},
    {MATERIAL, HEIGHT, "Height"},
    {MATERIAL, THICKNESS, "Thickness"},
    {LAYER, GEOMETRY, "Geometry"},
    {GEOMETRY, MGF_BLOCK, "MGFblock"},
    {LAYER, DATA_DEFINITION, "DataDefinition"},
    {DATA_DEFINITION, STRUCTURE, "IncidentDataStructure"},
    {DATA_DEFINITION, BASIS, "AngleBasis"},
    {BASIS, BASIS_NAME, "AngleBasisName"},
    {BASIS, BASIS_BLOCK, "AngleBasisBlock"},
    {BASIS_BLOCK, THETA_BOUNDS, "ThetaBounds"},
    {THETA_BOUNDS, LOWER_THETA, "LowerTheta"},
    {THETA_BOUNDS, UPPER_THETA, "UpperTheta"},
    {BASIS_BLOCK, PHI_COUNT, "nPhis"},
    {LAYER, WAVELENGTH_DATA, "WavelengthData"},
    {WAVELENGTH_DATA, WAVELENGTH, "Wavelength"},
    {WAVELENGTH_DATA, BLOCK, "WavelengthDataBlock"},
    {BLOCK, DIRECTION, "WavelengthDataDirection"},
    {BLOCK, COLUMN_BASIS, "ColumnAngleBasis"},
    {BLOCK, ROW_BASIS, "RowAngleBasis"},
    {BLOCK, TREE_BASIS, "AngleBasis"},
    {BLOCK, SCATTERING, "ScatteringData"},
};

enum { NESTING = 64, TEXT = 128, BASES = 8 };

struct reader {
    XML_Parser parser;
    const char *name;
    pm_error *err;
    pm_status status;
    struct pm_bsdf_text *out;

    enum tag tag[NESTING];
    unsigned depth;
    bool has_layer, has_structure;
    char text[TEXT];
    size_t length;
    bool too_long;
    double unit; /* of a dimension [m] */

    struct pm_klems_basis basis[BASES];
    unsigned basis_count;
    double lower_deg, upper_deg, last_deg, phi_count; /* of the ring being read; -1: missing */

    /* of the WavelengthData and the block being read */
    int band; /* enum pm_bsdf_band; -1: not light, -2: not said yet */
    int way;  /* enum pm_bsdf_way; -1: not said yet */
    char column[TEXT], row[TEXT], tree[TEXT];
    bool scattering;
    int block_line;
    struct pm_bsdf_values values;
};

/* ---- errors ---- */

/* An error `offset` bytes behind where the parser stands. */
static void refuse_text(struct reader *r, pm_status status, int offset, const char *text)
{
    if (r->status)
        return;
    r->status =
        pm_error_set_at(r->err, status, r->name, (int)XML_GetCurrentLineNumber(r->parser),
                        (int)XML_GetCurrentColumnNumber(r->parser) + 1 + offset, "%s", text);
    XML_StopParser(r->parser, XML_FALSE);
}

__attribute__((format(printf, 3, 4))) static void refuse(struct reader *r, pm_status status,
                                                         const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    refuse_text(r, status, 0, text);
}

static void no_memory(struct reader *r)
{
    refuse(r, PM_E_MEMORY, "not enough memory");
}

/* ---- words ---- */

static enum tag now(const struct reader *r)
{
    return r->tag[r->depth];
}

static bool is(const char *text, const char *word)
{
    return strcasecmp(text, word) == 0;
}

/* The text of the element that ends, without the white space around it. */
static const char *trimmed(struct reader *r)
{
    char *text = r->text;
    size_t length = r->length;
    while (length > 0 && strchr(" \t\r\n", text[length - 1]))
        length--;
    text[length] = '\0';
    return text + strspn(text, " \t\r\n");
}

static double number(struct reader *r, const char *what)
{
    const char *text = trimmed(r);
    double value;
    if (!pm_bsdf_number(text, strlen(text), &value)) {
        refuse(r, PM_E_SYNTAX, "%s is '%.40s', which is not a number", what, text);
        return 0;
    }
    return value;
}

static double unit_in_metres(struct reader *r, const char *unit)
{
    static const struct {
        const char *name;
        double metres;
    } units[] = {{"Meter", 1},
                 {"Foot", .3048},
                 {"Inch", .0254},
                 {"Centimeter", .01},
                 {"Millimeter", .001}};
    if (!unit)
        return 1;
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++)
        if (is(unit, units[i].name))
            return units[i].metres;
    refuse(r, PM_E_UNSUPPORTED,
           "unknown unit '%.40s'; known are Meter, Foot, Inch, Centimeter and Millimeter",
           unit);
    return 1;
}

static const char *attribute(const char **attributes, const char *name)
{
    for (; *attributes; attributes += 2)
        if (strcmp(attributes[0], name) == 0)
            return attributes[1];
    return NULL;
}

/* ---- beginnings ---- */

static void begin_block(struct reader *r)
{
    r->way = -1;
    r->column[0] = r->row[0] = r->tree[0] = '\0';
    r->scattering = false;
    r->block_line = (int)XML_GetCurrentLineNumber(r->parser);
    if (r->band == -2)
        refuse(r, PM_E_MISSING, "the Wavelength must stand before its WavelengthDataBlock");
}

static void begin_scattering(struct reader *r)
{
    if (r->band < 0)
        return;
    if (!r->has_structure)
        refuse(r, PM_E_MISSING,
               "the IncidentDataStructure must stand before the first ScatteringData");
    if (r->scattering)
        refuse(r, PM_E_SYNTAX, "a second ScatteringData in the same WavelengthDataBlock");
    r->scattering = true;
    pm_bsdf_values_clear(&r->values);
    r->values.rank = r->out->rank;
}

static void begin_basis(struct reader *r)
{
    if (r->basis_count == BASES) {
        refuse(r, PM_E_LIMIT, "more than %d angle bases", BASES);
        return;
    }
    r->basis[r->basis_count] = (struct pm_klems_basis){.rings = 0};
    r->last_deg = 0;
}

static enum tag tag_of(const struct reader *r, const char *name)
{
    for (size_t i = 0; i < sizeof elements / sizeof elements[0]; i++)
        if (elements[i].parent == now(r) && strcmp(elements[i].name, name) == 0)
            return elements[i].tag;
    return OTHER;
}

static void begin_geometry(struct reader *r, const char *format)
{
    if (format && !is(format, "MGF"))
        refuse(r, PM_E_UNSUPPORTED, "geometry of format '%.40s'; known is MGF", format);
}

static void XMLCALL on_begin(void *user, const char *name, const char **attributes)
{
    struct reader *r = user;
    if (r->depth + 1 == NESTING) {
        refuse(r, PM_E_LIMIT, "elements are nested more than %d deep", NESTING - 2);
        return;
    }
    enum tag tag = tag_of(r, name);
    if (r->depth == 0 && tag != WINDOW_ELEMENT)
        refuse(r, PM_E_UNSUPPORTED,
               "the outermost element is '%.40s'; a BSDF file's is "
               "WindowElement",
               name);
    if (tag == LAYER && r->has_layer)
        tag = OTHER; /* Radiance reads the first one, too */
    r->tag[++r->depth] = tag;
    r->length = 0;
    r->too_long = false;
    switch (tag) {
    case LAYER:
        r->has_layer = true;
        break;
    case WIDTH:
    case HEIGHT:
    case THICKNESS:
        r->unit = unit_in_metres(r, attribute(attributes, "unit"));
        break;
    case GEOMETRY:
        begin_geometry(r, attribute(attributes, "format"));
        break;
    case BASIS:
        begin_basis(r);
        break;
    case BASIS_BLOCK:
        r->lower_deg = r->upper_deg = r->phi_count = -1;
        break;
    case WAVELENGTH_DATA:
        r->band = -2;
        break;
    case BLOCK:
        begin_block(r);
        break;
    case SCATTERING:
        begin_scattering(r);
        break;
    default:
        break;
    }
}

/* ---- text ---- */

/* The others hold elements, and white space without bounds between them. */
static bool holds_words(enum tag tag)
{
    switch (tag) {
    case OTHER:
    case ROOT:
    case WINDOW_ELEMENT:
    case OPTICAL:
    case LAYER:
    case MATERIAL:
    case GEOMETRY:
    case DATA_DEFINITION:
    case BASIS:
    case BASIS_BLOCK:
    case THETA_BOUNDS:
    case WAVELENGTH_DATA:
    case BLOCK:
        return false;
    default:
        return true;
    }
}

static void XMLCALL on_text(void *user, const char *text, int length)
{
    struct reader *r = user;
    if (r->status)
        return;
    if (now(r) == SCATTERING) {
        if (r->band >= 0 && !pm_bsdf_values_add(&r->values, text, (size_t)length))
            refuse_text(r, r->values.status, r->values.at > 0 ? (int)r->values.at : 0,
                        r->values.message);
        return;
    }
    if (!holds_words(now(r)))
        return;
    size_t size = (size_t)length, room = sizeof r->text - 1 - r->length;
    r->too_long |= size > room;
    size = size < room ? size : room;
    memcpy(r->text + r->length, text, size);
    r->length += size;
}

/* ---- ends ---- */

static void end_structure(struct reader *r, const char *text)
{
    static const struct {
        const char *name;
        unsigned rank;
        bool rows;
    } structures[] = {{"Columns", 0, false},
                      {"Rows", 0, true},
                      {"TensorTree3", 3, false},
                      {"TensorTree4", 4, false}};
    for (size_t i = 0; i < sizeof structures / sizeof structures[0]; i++)
        if (is(text, structures[i].name)) {
            r->has_structure = true;
            r->out->rank = structures[i].rank;
            r->out->rows_are_in = structures[i].rows;
            return;
        }
    refuse(r, PM_E_UNSUPPORTED,
           "IncidentDataStructure '%.40s'; known are Columns, Rows, TensorTree3 and "
           "TensorTree4",
           text);
}

static void end_basis_block(struct reader *r)
{
    struct pm_klems_basis *b = &r->basis[r->basis_count];
    if (r->upper_deg < 0 || r->phi_count < 0) {
        refuse(r, PM_E_MISSING, "an AngleBasisBlock needs UpperTheta and nPhis");
        return;
    }
    if (b->rings > 0 && r->lower_deg >= 0 &&
        fabs(r->lower_deg - r->last_deg) > 1e-6 * r->last_deg)
        refuse(r, PM_E_RANGE, "LowerTheta is %g, but the ring before ends at %g", r->lower_deg,
               r->last_deg);
    if (!(r->phi_count >= 1 && r->phi_count <= PM_KLEMS_PATCHES) ||
        r->phi_count != floor(r->phi_count) ||
        !pm_klems_basis_add(b, r->upper_deg, (uint32_t)r->phi_count))
        refuse(r, PM_E_RANGE,
               "a ring up to %g degrees of %g patches; angles must rise to at most 90, only "
               "the first ring may have a single patch, and a basis at most %d rings and %d "
               "patches",
               r->upper_deg, r->phi_count, PM_KLEMS_RINGS, PM_KLEMS_PATCHES);
    r->last_deg = r->upper_deg;
}

static bool find_basis(const struct reader *r, const char *name, struct pm_klems_basis *out)
{
    if (pm_klems_basis_known(name, out))
        return true;
    for (unsigned i = 0; i < r->basis_count; i++)
        if (is(name, r->basis[i].name)) {
            *out = r->basis[i];
            return true;
        }
    return false;
}

/* One whose name is known is taken to be the same, as in Radiance. */
static void end_basis(struct reader *r)
{
    struct pm_klems_basis *b = &r->basis[r->basis_count], known;
    if (!b->name[0] || b->rings == 0)
        refuse(r, PM_E_MISSING, "an AngleBasis needs an AngleBasisName and an AngleBasisBlock");
    else if (!find_basis(r, b->name, &known))
        r->basis_count++;
}

static void end_wavelength(struct reader *r, const char *text)
{
    const char *bands[3] = {"Visible", r->out->rank ? "CIE-u" : "CIE-X",
                            r->out->rank ? "CIE-v" : "CIE-Z"};
    r->band = -1;
    for (int i = 0; i < 3; i++)
        if (is(text, bands[i]))
            r->band = i;
}

/* The file's front is the exterior, the back of the surface here. */
static void end_direction(struct reader *r, const char *text)
{
    static const char *const directions[PM_BSDF_WAYS] = {
        "Reflection Front", "Reflection Back", "Transmission Front", "Transmission Back"};
    for (int i = 0; i < PM_BSDF_WAYS; i++)
        if (is(text, directions[i]))
            r->way = i;
    if (r->way < 0 && r->band >= 0)
        refuse(r, PM_E_UNSUPPORTED,
               "WavelengthDataDirection '%.40s'; known are Transmission Front, Transmission "
               "Back, Reflection Front and Reflection Back",
               text);
}

static void end_scattering(struct reader *r)
{
    if (r->band >= 0 && !pm_bsdf_values_end(&r->values))
        refuse(r, r->values.status, "%s", r->values.message);
}

/* ---- blocks ---- */

static bool block_bases(struct reader *r, struct pm_klems_basis *in, struct pm_klems_basis *out)
{
    const char *names[2] = {r->column, r->row};
    struct pm_klems_basis *bases[2] = {in, out};
    for (int i = 0; i < 2; i++) {
        const char *which = i ? "RowAngleBasis" : "ColumnAngleBasis";
        if (!names[i][0])
            refuse(r, PM_E_MISSING, "a WavelengthDataBlock without %s", which);
        else if (!find_basis(r, names[i], bases[i]))
            refuse(r, PM_E_MISSING,
                   "%s '%.60s' is not defined; known without definition are LBNL/Klems Full, "
                   "Half and Quarter",
                   which, names[i]);
    }
    return !r->status;
}

static void keep_matrix(struct reader *r, struct pm_bsdf_block *block)
{
    struct pm_klems_basis in, out;
    if (!block_bases(r, &in, &out))
        return;
    size_t wanted = (size_t)in.patches * out.patches;
    if (r->values.count != wanted) {
        refuse(r, PM_E_SYNTAX,
               "%zu values in the ScatteringData of line %d, but %u x %u directions",
               r->values.count, r->block_line, in.patches, out.patches);
        return;
    }
    free(block->values);
    block->in = in;
    block->out = out;
    block->values = pm_bsdf_values_take(&r->values);
    block->count = wanted;
}

static void keep_tree(struct reader *r, struct pm_bsdf_block *block)
{
    if (!r->tree[0])
        refuse(r, PM_E_MISSING, "a WavelengthDataBlock without AngleBasis");
    else if (!is(r->tree, "LBNL/Shirley-Chiu"))
        refuse(r, PM_E_UNSUPPORTED,
               "AngleBasis '%.60s'; that of a tensor tree is LBNL/Shirley-Chiu", r->tree);
    if (r->status)
        return;
    pm_tree_nodes_clear(&block->nodes);
    pm_bsdf_values_take_nodes(&r->values, &block->nodes);
}

/* Of two that are for the same the last one holds, as in Radiance. */
static void end_block(struct reader *r)
{
    if (r->band < 0)
        return;
    if (r->way < 0)
        refuse(r, PM_E_MISSING, "a WavelengthDataBlock without WavelengthDataDirection");
    if (!r->scattering)
        refuse(r, PM_E_MISSING, "a WavelengthDataBlock without ScatteringData");
    if (r->status)
        return;
    struct pm_bsdf_block *block = &r->out->block[r->way][r->band];
    if (r->out->rank)
        keep_tree(r, block);
    else
        keep_matrix(r, block);
    block->given = true;
    block->line = r->block_line;
    pm_bsdf_values_clear(&r->values);
}

static void end_name(struct reader *r, const char *text, char *name, size_t size)
{
    if (strlen(text) >= size)
        refuse(r, PM_E_LIMIT, "a name of more than %zu characters", size - 1);
    else
        strcpy(name, text);
}

static void end_size(struct reader *r, int which)
{
    double value = number(r, "a dimension") * r->unit;
    if (value < 0)
        refuse(r, PM_E_RANGE, "a dimension below 0");
    r->out->size[which] = value;
}

static void end_definition_text(struct reader *r, enum tag tag)
{
    switch (tag) {
    case FILE_TYPE:
        if (strcmp(trimmed(r), "BSDF") != 0)
            refuse(r, PM_E_UNSUPPORTED, "FileType '%.40s'; a BSDF file's is BSDF", trimmed(r));
        break;
    case WIDTH:
    case HEIGHT:
    case THICKNESS:
        end_size(r, (int)(tag - WIDTH));
        break;
    case MGF_BLOCK:
        r->out->has_geometry = trimmed(r)[0] || r->too_long;
        break;
    case STRUCTURE:
        end_structure(r, trimmed(r));
        break;
    case BASIS_NAME:
        end_name(r, trimmed(r), r->basis[r->basis_count].name, PM_KLEMS_NAME);
        break;
    case LOWER_THETA:
        r->lower_deg = number(r, "LowerTheta");
        break;
    case UPPER_THETA:
        r->upper_deg = number(r, "UpperTheta");
        break;
    case PHI_COUNT:
        r->phi_count = number(r, "nPhis");
        break;
    default:
        break;
    }
}

static void end_data_text(struct reader *r, enum tag tag)
{
    switch (tag) {
    case WAVELENGTH:
        end_wavelength(r, trimmed(r));
        break;
    case DIRECTION:
        end_direction(r, trimmed(r));
        break;
    case COLUMN_BASIS:
        end_name(r, trimmed(r), r->column, sizeof r->column);
        break;
    case ROW_BASIS:
        end_name(r, trimmed(r), r->row, sizeof r->row);
        break;
    case TREE_BASIS:
        end_name(r, trimmed(r), r->tree, sizeof r->tree);
        break;
    default:
        break;
    }
}

static void end_text(struct reader *r, enum tag tag)
{
    if (r->too_long && tag != MGF_BLOCK) {
        refuse(r, PM_E_LIMIT, "text of more than %d characters where a word is due", TEXT - 1);
        return;
    }
    end_definition_text(r, tag);
    end_data_text(r, tag);
}

static void XMLCALL on_end(void *user, const char *name)
{
    (void)name;
    struct reader *r = user;
    if (r->status)
        return;
    enum tag tag = now(r);
    end_text(r, tag);
    switch (tag) {
    case BASIS_BLOCK:
        end_basis_block(r);
        break;
    case BASIS:
        end_basis(r);
        break;
    case SCATTERING:
        end_scattering(r);
        break;
    case BLOCK:
        end_block(r);
        break;
    default:
        break;
    }
    r->length = 0;
    r->too_long = false;
    r->depth--;
}

static void XMLCALL on_doctype(void *user, const char *name, const char *system,
                               const char *public, int has_subset)
{
    (void)name, (void)system, (void)public, (void)has_subset;
    refuse(user, PM_E_UNSUPPORTED,
           "a document type declaration, which BSDF files do without; entities are not read");
}

/* ---- the whole ---- */

static void parse(struct reader *r, const char *bytes, size_t size)
{
    enum { PIECE = 1 << 20 };
    do {
        int length = (int)(size < PIECE ? size : PIECE);
        bool last = (size_t)length == size;
        if (XML_Parse(r->parser, bytes, length, last) != XML_STATUS_OK && !r->status) {
            enum XML_Error error = XML_GetErrorCode(r->parser);
            if (error == XML_ERROR_NO_MEMORY)
                no_memory(r);
            else
                refuse(r, PM_E_SYNTAX, "not well-formed XML: %s", XML_ErrorString(error));
        }
        bytes += length;
        size -= (size_t)length;
    } while (size > 0 && !r->status);
}

static bool same_basis(const struct pm_klems_basis *a, const struct pm_klems_basis *b)
{
    return a->rings == b->rings && a->patches == b->patches;
}

static pm_status check_colour(const struct pm_bsdf_text *t, const char *name, pm_error *err)
{
    for (int way = 0; way < PM_BSDF_WAYS; way++) {
        const struct pm_bsdf_block *b = t->block[way];
        for (int i = PM_BSDF_FIRST; i < PM_BSDF_BANDS; i++) {
            if (!b[i].given)
                continue;
            if (!b[PM_BSDF_Y].given)
                return pm_error_set_at(err, PM_E_MISSING, name, b[i].line, 1,
                                       "colour without the Visible data of the same direction");
            if (!t->rank && (!same_basis(&b[i].in, &b[PM_BSDF_Y].in) ||
                             !same_basis(&b[i].out, &b[PM_BSDF_Y].out)))
                return pm_error_set_at(err, PM_E_MISMATCH, name, b[i].line, 1,
                                       "colour over other directions than the Visible data");
        }
    }
    return PM_OK;
}

static pm_status check_whole(const struct reader *r)
{
    const struct pm_bsdf_text *t = r->out;
    bool any = false;
    for (int way = 0; way < PM_BSDF_WAYS; way++)
        any |= t->block[way][PM_BSDF_Y].given;
    if (!r->has_layer)
        return pm_error_set_at(r->err, PM_E_MISSING, r->name, 1, 1,
                               "no WindowElement/Optical/Layer in it");
    if (!any)
        return pm_error_set_at(r->err, PM_E_MISSING, r->name, 1, 1,
                               "no WavelengthData of Wavelength Visible in its first Layer");
    return check_colour(t, r->name, r->err);
}

pm_status pm_bsdf_text_read(const void *bytes, size_t size, const char *name,
                            struct pm_bsdf_text *out, pm_error *err)
{
    struct reader *r = calloc(1, sizeof *r);
    /* memory of this library's linkage, so that tests can make it fail */
    const XML_Memory_Handling_Suite memory = {malloc, realloc, free};
    XML_Parser parser = r ? XML_ParserCreate_MM(NULL, &memory, NULL) : NULL;
    if (!parser) {
        free(r);
        return pm_error_set(err, PM_E_MEMORY, "%s: not enough memory", name);
    }
    *r = (struct reader){
        .parser = parser, .name = name, .err = err, .out = out, .tag = {ROOT}, .band = -2};
    XML_SetUserData(parser, r);
    XML_SetElementHandler(parser, on_begin, on_end);
    XML_SetCharacterDataHandler(parser, on_text);
    XML_SetStartDoctypeDeclHandler(parser, on_doctype);
    XML_SetHashSalt(parser, 0x9e3779b9); /* no run differs from another */
    parse(r, bytes, size);
    XML_ParserFree(parser);
    pm_bsdf_values_clear(&r->values);
    pm_status st = r->status ? r->status : check_whole(r);
    free(r);
    return st;
}

void pm_bsdf_text_clear(struct pm_bsdf_text *text)
{
    for (int way = 0; way < PM_BSDF_WAYS; way++)
        for (int band = 0; band < PM_BSDF_BANDS; band++) {
            free(text->block[way][band].values);
            pm_tree_nodes_clear(&text->block[way][band].nodes);
        }
    *text = (struct pm_bsdf_text){.rank = 0};
}
