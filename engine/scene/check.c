#include "scene/check.h"

#include <math.h>
#include <string.h>

/* One letter for each real argument that is bound to something; below is what they ask for. */
static const char *const rules[PM_PRIMITIVE_TYPES] = {
    [PM_LIGHT] = "EEE",
    [PM_GLOW] = "EEE.",
    [PM_SPOTLIGHT] = "EEEAV..",
    [PM_ILLUM] = "EEE",
    [PM_PLASTIC] = "CCCFR",
    [PM_METAL] = "CCCFR",
    [PM_TRANS] = "CCCFRFF",
    [PM_GLASS] = "TTTN",
    [PM_DIELECTRIC] = "TTTIH",
    [PM_PLASTIC2] = "CCCFOO",
    [PM_METAL2] = "CCCFOO",
    [PM_TRANS2] = "CCCFOOFF",
    [PM_ASHIK2] = "CCCCCCUU",
    [PM_INTERFACE] = "TTTITTTI",
    [PM_PLASFUNC] = "CCCF",
    [PM_METFUNC] = "CCCF",
    [PM_TRANSFUNC] = "CCCFFF",
    [PM_BRTDFUNC] = "CCCCCCCCC",
    [PM_PLASDATA] = "CCCF",
    [PM_METDATA] = "CCCF",
    [PM_TRANSDATA] = "CCCFFF",
    [PM_BSDF] = "CCCCCCCCC",
    [PM_ABSDF] = "CCCCCCCCC",
    [PM_COLORTEXT] = "...V..V..",
    [PM_BRIGHTTEXT] = "...V..V..",
    [PM_MIXTEXT] = "...V..V..",
    [PM_SPECTRUM] = "WW",
    [PM_SPECFUNC] = "WW",
    [PM_MIRROR] = "CCC",
    [PM_MIST] = "XXXFFFG",
    [PM_ANTIMATTER] = "",
    [PM_SPHERE] = "...r",
    [PM_BUBBLE] = "...r",
    [PM_CONE] = "L.....Z.",
    [PM_CUP] = "L.....Z.",
    [PM_CYLINDER] = "L.....r",
    [PM_TUBE] = "L.....r",
    [PM_RING] = "...V..DP",
    [PM_SOURCE] = "V..A",
};

static bool is_fraction(double v)
{
    return v >= 0 && v <= 1;
}

/* The squared length of a vector to be normalised must not leave the range of doubles. */
static bool has_length(const double v[3])
{
    return isnormal(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static bool apart(const double a[3], const double b[3])
{
    return a[0] != b[0] || a[1] != b[1] || a[2] != b[2];
}

/* Radiance's index of refraction at its mean wavelength: n + hc / 500 nm (src/rt/dielectric.c).
 */
static bool hartmann_is_right(const double *hc)
{
    return hc[-1] + hc[0] / 500 > 0;
}

/* Rules about one material argument. */
static const char *check_material(char rule, const double *v)
{
    switch (rule) {
    case 'E':
        return *v >= 0 ? NULL : "radiance must not be negative";
    case 'A':
        return *v > 0 && *v <= 360 ? NULL
                                   : "a full angle lies above 0 and is at most 360 degrees";
    case 'C':
        return is_fraction(*v)
                   ? NULL
                   : "a reflectance lies between 0 and 1; above 1 the surface would "
                     "create light";
    case 'F':
        return is_fraction(*v) ? NULL : "a fraction lies between 0 and 1";
    case 'R':
        return is_fraction(*v)
                   ? NULL
                   : "roughness is the rms slope of facets, between 0 (smooth) and 1";
    case 'O': /* Radiance's FTINY (src/rt/aniso.c) */
        return *v > 1e-6 && *v <= 1 ? NULL
                                    : "roughness is the rms slope of facets, above 0 (the type "
                                      "without a 2 is for smooth ones) and at most 1";
    case 'T':
        return is_fraction(*v)
                   ? NULL
                   : "a transmission lies between 0 and 1; above 1 the material would "
                     "create light";
    case 'N':
        return *v >= 1 ? NULL : "the index of refraction of a thin pane is at least 1";
    case 'I':
        return *v > 0 ? NULL : "an index of refraction is greater than 0, about 1.5 for glass";
    case 'H':
        return hartmann_is_right(v) ? NULL : "n + hc / 500 must be greater than 0";
    case 'U':
        return *v >= 0 ? NULL : "a Phong exponent must not be negative";
    case 'W':
        return *v > 0 ? NULL : "a wavelength [nm] is greater than 0";
    case 'X':
        return *v >= 0 ? NULL : "an extinction must not be negative";
    case 'G':
        return *v > -1 && *v < 1 ? NULL
                                 : "the eccentricity lies between -1 and 1, without these two";
    default:
        return NULL;
    }
}

/* Rules that look at one surface argument and those after it. */
static const char *check_surface(char rule, const double *v)
{
    switch (rule) {
    case 'V':
        return has_length(v) ? NULL
                             : "a direction needs a length, and one between 1e-150 and 1e150";
    case 'L':
        return apart(v, v + 3) ? NULL : "the two ends of the axis must lie apart";
    case 'r':
        return v[0] != 0 ? NULL : "a radius must not be 0";
    case 'Z':
        if (v[0] == 0 && v[1] == 0)
            return "one of the radii must be greater than 0";
        return v[0] * v[1] >= 0 ? NULL : "the radii must not have different signs";
    case 'D':
        if (v[0] == v[1])
            return "the inner and the outer radius must differ";
        return v[0] >= 0 ? NULL : "a ring's radius must not be negative";
    case 'P':
        return v[0] >= 0 ? NULL : "a ring's radius must not be negative";
    default:
        return NULL;
    }
}

const char *pm_check_reals(pm_primitive_type type, const double *reals, size_t count,
                           size_t *index)
{
    const char *rule = rules[type];
    for (size_t i = 0; rule && i < count && rule[i]; i++) {
        const char *text = check_material(rule[i], reals + i);
        if (!text)
            text = check_surface(rule[i], reals + i);
        if (text) {
            *index = i;
            return text;
        }
    }
    return NULL;
}

/* Twice the area is the length of the sum of the triangles' normals about the first corner; in
 * units of the polygon's extent, whose square a double might not hold. */
bool pm_check_has_area(const double *v, size_t count)
{
    double normal[3] = {0}, before[3] = {0}, rim = 0, largest = 0, extent = 0, square = 0;
    for (size_t i = 0; i < count; i++) {
        largest = fmax(largest, fabs(v[i]));
        extent = fmax(extent, fabs(v[i] - v[i % 3]));
    }
    for (size_t i = 3; extent > 0 && i < count; i += 3) {
        double here[3], edge = 0;
        for (size_t k = 0; k < 3; k++) {
            here[k] = (v[i + k] - v[k]) / extent;
            edge += (here[k] - before[k]) * (here[k] - before[k]);
        }
        for (size_t k = 0; k < 3; k++)
            normal[k] += before[(k + 1) % 3] * here[(k + 2) % 3] -
                         before[(k + 2) % 3] * here[(k + 1) % 3];
        memcpy(before, here, sizeof before);
        rim += sqrt(edge);
    }
    for (size_t k = 0; k < 3; k++)
        square += normal[k] * normal[k];
    /* what is no number is left to the world, which refuses it with its place */
    return extent > 0 && !(sqrt(square) <= 0x1p-50 * (largest / extent) * rim);
}

static void flip_radius(pm_primitive_type *type, double *radius, pm_primitive_type other)
{
    if (*radius < 0) {
        *radius = -*radius;
        *type = other;
    }
}

static void canonical_cone(pm_primitive_type *type, double *reals, uint32_t *count)
{
    if (reals[6] < 0 || reals[7] < 0)
        *type = *type == PM_CONE ? PM_CUP : PM_CONE;
    reals[6] = fabs(reals[6]);
    reals[7] = fabs(reals[7]);
    if (reals[6] == reals[7]) {
        *type = *type == PM_CONE ? PM_CYLINDER : PM_TUBE;
        *count = 7;
    }
}

void pm_check_canonical(pm_primitive_type *type, double *reals, uint32_t *count)
{
    switch (*type) {
    case PM_SPHERE:
        flip_radius(type, &reals[3], PM_BUBBLE);
        break;
    case PM_BUBBLE:
        flip_radius(type, &reals[3], PM_SPHERE);
        break;
    case PM_CYLINDER:
        flip_radius(type, &reals[6], PM_TUBE);
        break;
    case PM_TUBE:
        flip_radius(type, &reals[6], PM_CYLINDER);
        break;
    case PM_CONE:
    case PM_CUP:
        canonical_cone(type, reals, count);
        break;
    case PM_RING:
        if (reals[6] > reals[7]) {
            double outer = reals[6];
            reals[6] = reals[7];
            reals[7] = outer;
        }
        break;
    default:
        break;
    }
}
