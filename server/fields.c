#include "fields.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/digest.h"
#include "forward/options.h"
#include "photons/photon_map.h"
#include "surround.h"

/* ---- the tables ---- */

static const char *const kinds[] = {"map", "render", "trace", NULL};
static const char *const quantities[] = {"irradiance", "radiance", NULL};
static const char *const bandwidths[] = {"bias", "chi2", NULL};
static const char *const view_types[] = {"v", "l", "h", "c", "a", "s", NULL};
static const char *const sides[] = {"front", "back", "both", NULL};
static const char *const formats[] = {"exr", "hdr", "png", NULL};

#define SCENE_TEXT_MAX (1 << 20)
#define COORDINATE_MAX 1e30
#define NAME_MAX_BYTES 255 /* of a modifier */
#define EXACT_INTEGER                                                                          \
    9007199254740992.0 /* 2^53: every JSON reader keeps integers up to here                    \
                        */

const pm_field pm_fields_map[] = {
    {.name = "count",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = 1e9,
     .unit = "photons",
     .doc = "Photons wanted; the map is traced, or taken from the store."},
    {.name = "passes",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = PM_PASSES_MAX,
     .unit = "passes",
     .doc = "Of a map job: a sequence of so many maps of `count` photons each, of paths of "
            "their own. A longer sequence traces only the passes that are missing."},
    {.name = "gather",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = PM_GATHER_MAX,
     .unit = "photons",
     .otherwise = "40",
     .doc = "Photons that an estimate gathers."},
    {.name = "gather_max",
     .type = PM_FIELD_INTEGER,
     .low = 2,
     .high = PM_GATHER_MAX,
     .unit = "photons",
     .doc =
         "Greater than gather: an estimate gathers from gather to so many photons, many where "
         "light is even, few where it changes."},
    {.name = "bandwidth",
     .type = PM_FIELD_CHOICE,
     .unit = "",
     .otherwise = "\"bias\"",
     .doc = "How an estimate chooses between gather and gather_max. bias: bias compensation; "
            "chi2: as many as lie evenly about the point by a chi-squared test.",
     .choices = bandwidths},
    {.name = "map",
     .type = PM_FIELD_DIGEST,
     .unit = "",
     .doc = "Digest of an uploaded map file, used instead of a traced map."},
    {.name = NULL},
};

const pm_field pm_fields_medium[] = {
    {.name = "extinction",
     .type = PM_FIELD_VECTOR,
     .low = 0,
     .high = PM_EXTINCTION_MAX,
     .unit = "1 / scene unit",
     .doc = "Red, green and blue; absorption and scattering together.",
     .required = true},
    {.name = "albedo",
     .type = PM_FIELD_VECTOR,
     .low = 0,
     .high = 1,
     .unit = "",
     .otherwise = "[0,0,0]",
     .doc = "What of it is scattered."},
    {.name = "g",
     .type = PM_FIELD_NUMBER,
     .low = -PM_ECCENTRICITY_MAX,
     .high = PM_ECCENTRICITY_MAX,
     .unit = "",
     .otherwise = "0",
     .doc = "Henyey and Greenstein's eccentricity: 0 scatters evenly, 1 forwards."},
    {.name = NULL},
};

const pm_field pm_fields_port[] = {
    {.name = "modifier",
     .type = PM_FIELD_TEXT,
     .low = 1,
     .high = NAME_MAX_BYTES,
     .unit = "bytes",
     .doc = "Of the surfaces; anything in their chain of modifiers.",
     .required = true},
    {.name = "side",
     .type = PM_FIELD_CHOICE,
     .unit = "",
     .otherwise = "\"front\"",
     .doc = "Where light goes: front, along the normals; back, against them; both.",
     .choices = sides},
    {.name = NULL},
};

const pm_field pm_fields_region[] = {
    {.name = "box",
     .type = PM_FIELD_VECTOR,
     .low = -COORDINATE_MAX,
     .high = COORDINATE_MAX,
     .unit = "scene units",
     .doc = "x y z of two opposite corners.",
     .size = 6},
    {.name = "sphere",
     .type = PM_FIELD_VECTOR,
     .low = -COORDINATE_MAX,
     .high = COORDINATE_MAX,
     .unit = "scene units",
     .doc = "x y z of the centre, and the radius.",
     .size = 4},
    {.name = NULL},
};

const pm_field pm_fields_precomputed[] = {
    {.name = "count",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = 1e9,
     .unit = "photons",
     .doc = "Photons wanted of the global map that irradiance is precomputed from."},
    {.name = "gather",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = PM_GATHER_MAX,
     .unit = "photons",
     .otherwise = "40",
     .doc = "Photons that irradiance is estimated from; at most count."},
    {.name = "fraction",
     .type = PM_FIELD_NUMBER,
     .low = 1e-9,
     .high = 1,
     .unit = "",
     .otherwise = "0.25",
     .doc = "Share of the photons that irradiance is precomputed for; the others are dropped."},
    {.name = "map",
     .type = PM_FIELD_DIGEST,
     .unit = "",
     .doc = "Digest of an uploaded file of a precomputed map, used instead of a traced one."},
    {.name = NULL},
};

const pm_field pm_fields_view[] = {
    {.name = "vp",
     .type = PM_FIELD_VECTOR,
     .low = -COORDINATE_MAX,
     .high = COORDINATE_MAX,
     .unit = "scene units",
     .otherwise = "[0,0,0]",
     .doc = "View point."},
    {.name = "vd",
     .type = PM_FIELD_VECTOR,
     .low = -COORDINATE_MAX,
     .high = COORDINATE_MAX,
     .unit = "",
     .otherwise = "[0,1,0]",
     .doc = "View direction; its length does not matter."},
    {.name = "vu",
     .type = PM_FIELD_VECTOR,
     .low = -COORDINATE_MAX,
     .high = COORDINATE_MAX,
     .unit = "",
     .otherwise = "[0,0,1]",
     .doc = "Up, not along the view direction."},
    {.name = "vh",
     .type = PM_FIELD_NUMBER,
     .low = 0,
     .high = COORDINATE_MAX,
     .unit = "degrees",
     .otherwise = "45",
     .doc = "Horizontal angle of view; of a parallel view its width in scene units."},
    {.name = "vv",
     .type = PM_FIELD_NUMBER,
     .low = 0,
     .high = COORDINATE_MAX,
     .unit = "degrees",
     .otherwise = "45",
     .doc = "Vertical angle of view; of a parallel view its height in scene units."},
    {.name = "vt",
     .type = PM_FIELD_CHOICE,
     .unit = "",
     .otherwise = "\"v\"",
     .doc = "Type: perspective (v), parallel (l), hemispherical fisheye (h), cylindrical "
            "panorama (c), angular fisheye (a), stereographic fisheye (s).",
     .choices = view_types},
    {.name = "vs",
     .type = PM_FIELD_NUMBER,
     .low = -COORDINATE_MAX,
     .high = COORDINATE_MAX,
     .unit = "widths",
     .otherwise = "0",
     .doc = "Shift of the picture to the right."},
    {.name = "vl",
     .type = PM_FIELD_NUMBER,
     .low = -COORDINATE_MAX,
     .high = COORDINATE_MAX,
     .unit = "heights",
     .otherwise = "0",
     .doc = "Lift of the picture."},
    {.name = "vo",
     .type = PM_FIELD_NUMBER,
     .low = 0,
     .high = COORDINATE_MAX,
     .unit = "scene units",
     .otherwise = "0",
     .doc = "Fore clipping distance; what is nearer is not seen."},
    {.name = "va",
     .type = PM_FIELD_NUMBER,
     .low = 0,
     .high = COORDINATE_MAX,
     .unit = "scene units",
     .otherwise = "0",
     .doc = "Aft clipping distance; what is farther is not seen; 0: none."},
    {.name = NULL},
};

const pm_field pm_fields_job[] = {
    {.name = "kind",
     .type = PM_FIELD_CHOICE,
     .unit = "",
     .doc = "map: photon map files; render: a picture; trace: values at sensors.",
     .choices = kinds,
     .required = true},
    {.name = "scene",
     .type = PM_FIELD_DIGEST,
     .unit = "",
     .doc = "The id that POST /v1/scenes answered.",
     .required = true},
    {.name = "global",
     .type = PM_FIELD_OBJECT,
     .unit = "",
     .doc =
         "Global map: every indirect hit on a diffuse surface. With no map named, render and "
         "trace work in progressive passes.",
     .members = pm_fields_map},
    {.name = "precomputed",
     .type = PM_FIELD_OBJECT,
     .unit = "",
     .doc = "Instead of global: a map of irradiance at some of the global photons; a look-up "
            "takes that of the closest.",
     .members = pm_fields_precomputed},
    {.name = "caustic",
     .type = PM_FIELD_OBJECT,
     .unit = "",
     .doc = "Caustic map: photons whose last event was specular.",
     .members = pm_fields_map},
    {.name = "volume",
     .type = PM_FIELD_OBJECT,
     .unit = "",
     .doc = "Volume map: scattering in mist.",
     .members = pm_fields_map},
    {.name = "direct",
     .type = PM_FIELD_OBJECT,
     .unit = "",
     .doc = "Of map: direct map, light on its first diffuse surface, to be looked at. Renders "
            "take direct light from next events.",
     .members = pm_fields_map},
    {.name = "ab",
     .type = PM_FIELD_INTEGER,
     .low = -100,
     .high = 100,
     .unit = "bounces",
     .otherwise = "1",
     .doc = "Indirect light: > 0 final gather into the global map, < 0 the map at the first "
            "diffuse surface, 0 none. Only the sign matters where maps are used."},
    {.name = "seed",
     .type = PM_FIELD_INTEGER,
     .low = 0,
     .high = EXACT_INTEGER,
     .unit = "",
     .otherwise = "0",
     .doc = "Seed of the random numbers. Equal seeds give equal bytes."},
    {.name = "max_events",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = 50000,
     .unit = "scatterings",
     .otherwise = "5000",
     .doc = "Most scatterings on a photon's path. From 5000 on those in media do not count: "
            "roulette ends them."},
    {.name = "max_length",
     .type = PM_FIELD_NUMBER,
     .low = 1e-30,
     .high = PM_LENGTH_MAX,
     .unit = "scene units",
     .doc = "Greatest length of a photon's path; it ends there, and what lies beyond is "
            "darker than it should be. Without it, none. Distant light starts where it enters "
            "the scene's cube."},
    {.name = "medium",
     .type = PM_FIELD_OBJECT,
     .unit = "",
     .doc = "A medium that fills the scene: a cube about its surfaces, a hundredth wider than "
            "the greatest of their extents. Maps from files need the same.",
     .members = pm_fields_medium},
    {.name = "back_faces",
     .type = PM_FIELD_SWITCH,
     .unit = "",
     .otherwise = "true",
     .doc = "Whether surfaces are there from behind; false: rays go straight through their "
            "backs, and photons end at those that are opaque. Maps from files need the same."},
    {.name = "ports",
     .type = PM_FIELD_OBJECTS,
     .unit = "",
     .doc = "Photon ports: light of distant sources enters the scene through these surfaces "
            "alone, at their windows for instance. Direct light is not changed by it.",
     .members = pm_fields_port},
    {.name = "direction_resolution",
     .type = PM_FIELD_NUMBER,
     .low = 1,
     .high = PM_DIRECTIONS_MAX,
     .unit = "1/sr",
     .otherwise = "1000",
     .doc = "With ports: directions that their tables of incident light tell apart."},
    {.name = "partition",
     .type = PM_FIELD_NUMBER,
     .low = PM_PARTITION_MIN,
     .high = 1,
     .unit = "",
     .otherwise = "0.01",
     .doc = "With ports: size of the patches into which they are divided, relative to the "
            "scene's cube."},
    {.name = "sensors",
     .type = PM_FIELD_TEXTS,
     .low = 1,
     .high = NAME_MAX_BYTES,
     .unit = "bytes",
     .doc = "Of map: modifiers of surfaces that store photons on their front, too, whatever "
            "they are made of; antimatter lets light pass."},
    {.name = "exclude",
     .type = PM_FIELD_TEXTS,
     .low = 1,
     .high = NAME_MAX_BYTES,
     .unit = "bytes",
     .doc = "Of map: modifiers of surfaces that store no photons. Paths stay what they are; "
            "estimates on these surfaces are dark."},
    {.name = "include",
     .type = PM_FIELD_TEXTS,
     .low = 1,
     .high = NAME_MAX_BYTES,
     .unit = "bytes",
     .doc = "Of map: modifiers of the surfaces that alone store photons; not with exclude."},
    {.name = "regions",
     .type = PM_FIELD_OBJECTS,
     .unit = "",
     .doc = "Of map: photons outside all of these are not stored.",
     .members = pm_fields_region},
    {.name = "view",
     .type = PM_FIELD_VIEW,
     .low = 0,
     .high = 4096,
     .unit = "",
     .doc = "Of render: the view, as members or as text, e.g. \"-vp 0 -5 1 -vd 0 1 0\".",
     .members = pm_fields_view},
    {.name = "x",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = 16384,
     .unit = "pixels",
     .otherwise = "512",
     .doc = "Of render: greatest width; see pa."},
    {.name = "y",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = 16384,
     .unit = "pixels",
     .otherwise = "512",
     .doc = "Of render: greatest height; see pa."},
    {.name = "pa",
     .type = PM_FIELD_NUMBER,
     .low = 0,
     .high = 1e6,
     .unit = "",
     .otherwise = "1",
     .doc = "Of render: height of a pixel over its width, within x by y; 0: exactly x by y, "
            "whatever the pixels' shape."},
    {.name = "points",
     .type = PM_FIELD_DIGEST,
     .unit = "",
     .doc = "Of trace: digest of an uploaded text with a line `x y z nx ny nz` a sensor."},
    {.name = "quantity",
     .type = PM_FIELD_CHOICE,
     .unit = "",
     .otherwise = "\"irradiance\"",
     .doc = "Of trace: irradiance [W/m^2] on the sensor's front side, or radiance "
            "[W/(m^2 sr)] from its direction.",
     .choices = quantities},
    {.name = "fields",
     .type = PM_FIELD_TEXT,
     .low = 1,
     .high = 32,
     .unit = "letters",
     .doc =
         "Of trace: what else is said of each sensor, in columns behind its value and error, "
         "by rtrace's letters: o origin, d direction; of what the ray meets first L its "
         "distance, p the point, n the normal, N without textures, c coordinates of meshes, "
         "s name of the surface, m of its modifier, M of its material."},
    {.name = "passes",
     .type = PM_FIELD_INTEGER,
     .low = 1,
     .high = 1 << 24,
     .unit = "passes",
     .doc = "Of render and trace: stop after so many passes."},
    {.name = "time",
     .type = PM_FIELD_NUMBER,
     .low = 1e-3,
     .high = 2592000,
     .unit = "s",
     .doc = "Of render and trace: stop after so much wall-clock time."},
    {.name = "error",
     .type = PM_FIELD_NUMBER,
     .low = 1e-6,
     .high = 1,
     .unit = "",
     .doc = "Of render and trace: stop at this estimated relative error."},
    {.name = "threads",
     .type = PM_FIELD_INTEGER,
     .low = 0,
     .high = 256,
     .unit = "threads",
     .otherwise = "0",
     .doc =
         "Threads of the job; 0: one a processor, shared out among the server's workers. The "
         "bytes of the answer do not depend on it."},
    {.name = "formats",
     .type = PM_FIELD_CHOICES,
     .unit = "",
     .otherwise = "[\"exr\"]",
     .doc = "Of render: the files wanted.",
     .choices = formats},
    {.name = "command",
     .type = PM_FIELD_TEXT,
     .low = 0,
     .high = 65536,
     .unit = "bytes",
     .doc = "The command line as typed, for the headers of pictures and maps."},
    {.name = NULL},
};

const pm_field pm_fields_scene[] = {
    {.name = "bundle",
     .type = PM_FIELD_DIGEST,
     .unit = "",
     .doc = "Digest of an uploaded tar that holds the scene's files."},
    {.name = "text",
     .type = PM_FIELD_TEXT,
     .low = 0,
     .high = SCENE_TEXT_MAX,
     .unit = "bytes",
     .doc = "The text of a scene that is one file, instead of a bundle."},
    {.name = "main",
     .type = PM_FIELD_TEXT,
     .low = 1,
     .high = 1024,
     .unit = "bytes",
     .otherwise = "\"scene.rad\"",
     .doc = "The bundle's file to start from."},
    {.name = NULL},
};

const pm_field *pm_field_find(const pm_field *fields, const char *name)
{
    for (const pm_field *field = fields; field->name; field++)
        if (!strcmp(field->name, name))
            return field;
    return NULL;
}

/* ---- checking ---- */

/* Where a check stands: the path of the member, for messages. */
struct place {
    const char *path;
    pm_error *err;
};

static pm_status refuse(const struct place *at, pm_status status, const char *text)
{
    return pm_error_set_at(at->err, status, at->path, 0, 0, "%s", text);
}

pm_status pm_field_check_number(const pm_field *field, double value, const char *name,
                                pm_error *err)
{
    if (value >= field->low && value <= field->high)
        return PM_OK;
    return pm_error_set_at(err, PM_E_RANGE, name, 0, 0, "is %.17g, must be %.10g to %.10g%s%s",
                           value, field->low, field->high, *field->unit ? " " : "",
                           field->unit);
}

static pm_status check_number(const pm_field *field, const pm_json *value,
                              const struct place *at)
{
    pm_json_type type = pm_json_type_of(value);
    if (type != PM_JSON_INTEGER && (type != PM_JSON_REAL || field->type == PM_FIELD_INTEGER))
        return refuse(at, PM_E_RANGE,
                      field->type == PM_FIELD_INTEGER ? "must be an integer"
                                                      : "must be a number");
    return pm_field_check_number(field, pm_json_number(value), at->path, at->err);
}

static pm_status check_text(const pm_field *field, const pm_json *value, const struct place *at)
{
    if (pm_json_type_of(value) != PM_JSON_TEXT)
        return refuse(at, PM_E_RANGE, "must be a text");
    size_t length = pm_json_length(value);
    if ((double)length < field->low || (double)length > field->high)
        return pm_error_set_at(at->err, PM_E_RANGE, at->path, 0, 0,
                               "has %zu bytes, must have %.0f to %.0f", length, field->low,
                               field->high);
    for (const char *c = pm_json_string(value); *c; c++)
        if (((unsigned char)*c < ' ' && !strchr("\t\r\n", *c)) || *c == 127)
            return refuse(at, PM_E_RANGE, "holds a control character");
    return PM_OK;
}

static pm_status check_choice(const pm_field *field, const pm_json *value,
                              const struct place *at)
{
    char list[128] = "";
    size_t used = 0;
    for (const char *const *choice = field->choices; *choice; choice++) {
        const char *text = pm_json_string(value);
        if (text && !strcmp(text, *choice))
            return PM_OK;
        used += (size_t)snprintf(list + used, sizeof list - used, "%s\"%s\"", used ? ", " : "",
                                 *choice);
    }
    return pm_error_set_at(at->err, PM_E_RANGE, at->path, 0, 0, "must be one of %s", list);
}

static pm_status check_choices(const pm_field *field, const pm_json *value,
                               const struct place *at)
{
    if (pm_json_type_of(value) != PM_JSON_ARRAY || !pm_json_length(value))
        return refuse(at, PM_E_RANGE, "must be a list with at least one entry");
    for (size_t i = 0; i < pm_json_length(value); i++) {
        pm_status st = check_choice(field, pm_json_at(value, i), at);
        if (st)
            return st;
        for (size_t j = 0; j < i; j++)
            if (!strcmp(pm_json_string(pm_json_at(value, i)),
                        pm_json_string(pm_json_at(value, j))))
                return refuse(at, PM_E_RANGE, "names an entry twice");
    }
    return PM_OK;
}

static pm_status check_digest(const pm_json *value, const struct place *at)
{
    pm_digest digest;
    const char *text = pm_json_string(value);
    if (!text || !pm_digest_parse(text, &digest))
        return refuse(at, PM_E_RANGE, "must be 64 lower-case hexadecimal digits");
    return PM_OK;
}

static size_t vector_size(const pm_field *field)
{
    return field->size ? field->size : 3;
}

static pm_status check_vector(const pm_field *field, const pm_json *value,
                              const struct place *at)
{
    size_t size = vector_size(field);
    if (pm_json_type_of(value) != PM_JSON_ARRAY || pm_json_length(value) != size)
        return pm_error_set_at(at->err, PM_E_RANGE, at->path, 0, 0,
                               "must be a list of %zu numbers", size);
    pm_status st = PM_OK;
    for (size_t i = 0; i < size && !st; i++)
        st = check_number(field, pm_json_at(value, i), at);
    return st;
}

static pm_status check_members(const pm_field *fields, pm_json *object, const struct place *at);

static pm_status check_switch(const pm_json *value, const struct place *at)
{
    return pm_json_type_of(value) == PM_JSON_BOOL
               ? PM_OK
               : refuse(at, PM_E_RANGE, "must be true or false");
}

static pm_status check_list(const pm_field *field, const pm_json *value, const struct place *at)
{
    size_t length = pm_json_length(value);
    if (pm_json_type_of(value) != PM_JSON_ARRAY || !length || length > PM_FIELD_LIST_MAX)
        return pm_error_set_at(at->err, PM_E_RANGE, at->path, 0, 0,
                               "must be a list of 1 to %d entries", PM_FIELD_LIST_MAX);
    pm_status st = PM_OK;
    for (size_t i = 0; i < length && !st; i++) {
        char path[128];
        snprintf(path, sizeof path, "%.100s[%zu]", at->path, i);
        const struct place inner = {path, at->err};
        pm_json *entry = pm_json_at(value, i);
        st = field->type == PM_FIELD_TEXTS ? check_text(field, entry, &inner)
                                           : check_members(field->members, entry, &inner);
    }
    return st;
}

static pm_status check_value(const pm_field *field, pm_json *value, const struct place *at)
{
    switch (field->type) {
    case PM_FIELD_INTEGER:
    case PM_FIELD_NUMBER:
        return check_number(field, value, at);
    case PM_FIELD_TEXT:
        return check_text(field, value, at);
    case PM_FIELD_CHOICE:
        return check_choice(field, value, at);
    case PM_FIELD_CHOICES:
        return check_choices(field, value, at);
    case PM_FIELD_DIGEST:
        return check_digest(value, at);
    case PM_FIELD_VECTOR:
        return check_vector(field, value, at);
    case PM_FIELD_SWITCH:
        return check_switch(value, at);
    case PM_FIELD_TEXTS:
    case PM_FIELD_OBJECTS:
        return check_list(field, value, at);
    case PM_FIELD_VIEW:
        if (pm_json_type_of(value) == PM_JSON_TEXT)
            return check_text(field, value, at);
        break;
    case PM_FIELD_OBJECT:
        break;
    }
    return check_members(field->members, value, at);
}

static pm_status check_required(const pm_field *fields, const pm_json *object,
                                const struct place *at)
{
    for (const pm_field *field = fields; field->name; field++)
        if (field->required && !pm_json_get(object, field->name)) {
            char path[128];
            snprintf(path, sizeof path, "%s%s%s", at->path, *at->path ? "." : "", field->name);
            return pm_error_set_at(at->err, PM_E_MISSING, path, 0, 0, "is missing");
        }
    return PM_OK;
}

static pm_status check_members(const pm_field *fields, pm_json *object, const struct place *at)
{
    if (pm_json_type_of(object) != PM_JSON_OBJECT)
        return refuse(at, PM_E_RANGE, "must be an object");
    const char *name = NULL;
    while ((name = pm_json_next(object, name))) {
        char path[128];
        snprintf(path, sizeof path, "%s%s%.80s", at->path, *at->path ? "." : "", name);
        const struct place inner = {path, at->err};
        const pm_field *field = pm_field_find(fields, name);
        if (!field)
            return refuse(&inner, PM_E_UNSUPPORTED, "is not a member that is known here");
        pm_status st = check_value(field, pm_json_get(object, name), &inner);
        if (st)
            return st;
    }
    return check_required(fields, object, at);
}

pm_status pm_fields_check(const pm_field *fields, pm_json *object, pm_error *err)
{
    const struct place top = {"", err};
    return check_members(fields, object, &top);
}

/* ---- the schema ---- */

static pm_json *choices_schema(const pm_field *field)
{
    pm_json *list = pm_json_pack("[]");
    for (const char *const *choice = field->choices; list && *choice; choice++)
        if (!pm_json_append(list, pm_json_pack("s", *choice))) {
            pm_json_free(list);
            return NULL;
        }
    return pm_json_pack("{s:s, s:o}", "type", "string", "enum", list);
}

static pm_json *list_schema(pm_json *entry)
{
    return pm_json_pack("{s:s, s:i, s:i, s:o}", "type", "array", "minItems", 1, "maxItems",
                        PM_FIELD_LIST_MAX, "items", entry);
}

static pm_json *type_schema(const pm_field *field)
{
    switch (field->type) {
    case PM_FIELD_INTEGER:
        return pm_json_pack("{s:s, s:I, s:I}", "type", "integer", "minimum",
                            (long long)field->low, "maximum", (long long)field->high);
    case PM_FIELD_NUMBER:
        return pm_json_pack("{s:s, s:f, s:f}", "type", "number", "minimum", field->low,
                            "maximum", field->high);
    case PM_FIELD_TEXT:
        return pm_json_pack("{s:s, s:I, s:I}", "type", "string", "minLength",
                            (long long)field->low, "maxLength", (long long)field->high);
    case PM_FIELD_CHOICE:
        return choices_schema(field);
    case PM_FIELD_CHOICES:
        return pm_json_pack("{s:s, s:i, s:b, s:o}", "type", "array", "minItems", 1,
                            "uniqueItems", 1, "items", choices_schema(field));
    case PM_FIELD_DIGEST:
        return pm_json_pack("{s:s, s:s}", "type", "string", "pattern", "^[0-9a-f]{64}$");
    case PM_FIELD_VECTOR:
        return pm_json_pack("{s:s, s:i, s:i, s:{s:s, s:f, s:f}}", "type", "array", "minItems",
                            (int)vector_size(field), "maxItems", (int)vector_size(field),
                            "items", "type", "number", "minimum", field->low, "maximum",
                            field->high);
    case PM_FIELD_SWITCH:
        return pm_json_pack("{s:s}", "type", "boolean");
    case PM_FIELD_TEXTS:
        return list_schema(pm_json_pack("{s:s, s:I, s:I}", "type", "string", "minLength",
                                        (long long)field->low, "maxLength",
                                        (long long)field->high));
    case PM_FIELD_OBJECTS:
        return list_schema(pm_fields_schema(field->members));
    case PM_FIELD_OBJECT:
        return pm_fields_schema(field->members);
    case PM_FIELD_VIEW:
        break;
    }
    return pm_json_pack("{s:[o, {s:s, s:I}]}", "oneOf", pm_fields_schema(field->members),
                        "type", "string", "maxLength", (long long)field->high);
}

static pm_json *field_schema(const pm_field *field)
{
    char doc[512];
    snprintf(doc, sizeof doc, *field->unit ? "%s [%s]" : "%s", field->doc, field->unit);
    pm_json *schema = type_schema(field), *otherwise = NULL;
    bool made = schema && pm_json_put(schema, "description", pm_json_pack("s", doc));
    if (made && field->otherwise)
        made = !pm_json_parse(field->otherwise, strlen(field->otherwise), NULL, &otherwise,
                              NULL) &&
               pm_json_put(schema, "default", otherwise);
    if (made)
        return schema;
    pm_json_free(schema);
    return NULL;
}

pm_json *pm_fields_schema(const pm_field *fields)
{
    pm_json *properties = pm_json_pack("{}"), *required = pm_json_pack("[]");
    bool made = properties && required;
    for (const pm_field *field = fields; made && field->name; field++) {
        made = pm_json_put(properties, field->name, field_schema(field));
        if (made && field->required)
            made = pm_json_append(required, pm_json_pack("s", field->name));
    }
    if (made)
        return pm_json_pack("{s:s, s:b, s:o, s:o}", "type", "object", "additionalProperties", 0,
                            "properties", properties, "required", required);
    pm_json_free(properties);
    pm_json_free(required);
    return NULL;
}
