#include "generate/sky.h"

#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "base/number.h"

/* gensky(1): the CIE standard overcast sky, its clear sky (standard S 003), the intermediate
 * sky of Matsuura and Iwata (1990), and a uniform one. Zenith luminances in kcd/m^2: clear
 * after Dogniaux by turbidity, overcast by the sun's altitude (IES Lighting Handbook).
 * Luminous efficacies [lm/W] are those of Radiance's src/common/color.h. */

static const double sky_efficacy = 203, sun_efficacy = 208;

/* pi sin^2 of a quarter degree, as Radiance rounds it: the sun's solid angle [sr]. */
static const double sun_solid_angle = 6e-5;

static const double degrees = PM_PI / 180;

/* As the first parameter of skybright.cal. */
enum kind { CLEAR = 1, OVERCAST = 2, UNIFORM = 3, INTERMEDIATE = 4 };

/* How a value was given. */
enum unit { NOT_GIVEN, RADIANCE, IRRADIANCE };

struct sky {
    pm_generation *g;
    pm_sky_time time;
    enum kind kind;
    bool sun;
    double turbidity, ground_reflectance;
    enum unit zenith_unit, solar_unit;
    double zenith, solar; /* radiances [W/(m^2 sr)] */
    double direction[3];
    double ground; /* radiance */
    double scale;  /* of the distribution, relative to its zenith; 0 if overcast */
};

/* ---- time ---- */

/* Standard meridians in degrees west. AST and NDT stand twice: the first is meant. */
static const struct zone {
    char name[5];
    double meridian;
} zones[] = {
    {"YST", 135},  {"YDT", 120},   {"PST", 120},   {"PDT", 105}, {"MST", 105},   {"MDT", 90},
    {"CST", 90},   {"CDT", 75},    {"EST", 75},    {"EDT", 60},  {"AST", 60},    {"ADT", 45},
    {"NST", 52.5}, {"NDT", 37.5},  {"GMT", 0},     {"BST", -15}, {"CET", -15},   {"CEST", -30},
    {"EET", -30},  {"EEST", -45},  {"GST", -60},   {"GDT", -75}, {"IST", -82.5}, {"IDT", -97.5},
    {"JST", -135}, {"NZST", -180}, {"NZDT", -195},
};

static bool find_zone(const char *name, double *meridian)
{
    for (size_t i = 0; i < sizeof zones / sizeof *zones; i++) {
        size_t at = 0;
        while (name[at] && (name[at] & ~0x20) == zones[i].name[at])
            at++;
        if (!name[at] && !zones[i].name[at]) {
            *meridian = zones[i].meridian * degrees;
            return true;
        }
    }
    return false;
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Hours as "14.5" or "14:30". *rest is what follows. */
static bool read_hour(const char *text, double *hour, const char **rest)
{
    size_t whole = 0, part;
    while (is_digit(text[whole]))
        whole++;
    double minutes = 0;
    bool colon = text[whole] == ':';
    for (part = whole + (colon || text[whole] == '.'); is_digit(text[part]); part++)
        ;
    *rest = text + part;
    if (!colon)
        return pm_number_real(text, part, hour) == PM_NUMBER_OK;
    return pm_number_real(text, whole, hour) == PM_NUMBER_OK &&
           pm_number_real(text + whole + 1, part - whole - 1, &minutes) == PM_NUMBER_OK &&
           minutes < 60 && (*hour += minutes / 60, true);
}

static pm_status take_hour(pm_generation *g, bool with_zones, pm_sky_time *out)
{
    const char *word = pm_generation_word(g);
    if (!word)
        return pm_generation_fail(g, g->request->count - 1, PM_E_SYNTAX,
                                  "the hour is missing; it should come after the day");
    const char *rest;
    out->moment.solar = word[0] == '+';
    if (!read_hour(word + out->moment.solar, &out->moment.hour, &rest) ||
        out->moment.hour > 24 || (!with_zones && out->moment.hour == 24))
        return pm_generation_fail(g, g->at, PM_E_SYNTAX,
                                  "'%.60s' is no hour; write 14.5%s, or +14.5 for solar time",
                                  word, with_zones ? ", 14:30, 14.5EST" : "");
    if (*rest && (!with_zones || out->moment.solar))
        return pm_generation_fail(g, g->at, PM_E_SYNTAX, "'%.60s' follows the hour; %s", rest,
                                  with_zones ? "solar time knows no time zone"
                                             : "give the time zone by -m meridian");
    out->zone = *rest != '\0';
    if (out->zone && !find_zone(rest, &out->site.meridian))
        return pm_generation_fail(
            g, g->at, PM_E_SYNTAX,
            "there is no time zone '%.60s'; write one such as EST, GMT or "
            "CEST, or give its meridian by -m",
            rest);
    g->at++;
    return PM_OK;
}

static pm_status take_date(pm_generation *g, bool with_zones, pm_sky_time *out)
{
    int64_t month, day;
    pm_status st = pm_take_integer(g, "the month", 1, 12, &month);
    if (!st)
        st = pm_take_integer(g, "the day", 1, 31, &day);
    if (st)
        return st;
    out->moment.month = (int)month;
    out->moment.day = (int)day;
    return take_hour(g, with_zones, out);
}

pm_status pm_take_sky_time(pm_generation *g, bool with_zones, pm_sky_time *out)
{
    *out = (pm_sky_time){.site = pm_site_default};
    const char *word = pm_generation_word(g);
    if (!word || strcmp(word, "-ang") != 0)
        return take_date(g, with_zones, out);
    g->at++;
    pm_status st = pm_take_real(g, "the sun's altitude in degrees", &out->altitude);
    if (!st)
        st = pm_take_real(g, "the sun's azimuth in degrees", &out->azimuth);
    out->altitude *= degrees;
    out->azimuth *= degrees;
    return st;
}

static pm_status take_degrees(pm_generation *g, const char *what, double *out)
{
    pm_status st = pm_take_real(g, what, out);
    *out *= degrees;
    return st;
}

static pm_status take_year(pm_generation *g, pm_moment *moment)
{
    int64_t year;
    pm_status st = pm_take_integer(g, "-y's year", 1901, 2099, &year);
    if (!st)
        moment->year = (int)year;
    return st;
}

pm_status pm_take_site(pm_generation *g, pm_sky_time *time, bool *known)
{
    const char *option = pm_generation_word(g);
    *known = option[0] == '-' && option[1] && strchr("yaom", option[1]) && !option[2];
    if (!*known)
        return PM_OK;
    g->at++;
    if (option[1] == 'y')
        return take_year(g, &time->moment);
    if (option[1] == 'a')
        return take_degrees(g, "-a's latitude", &time->site.latitude);
    if (option[1] == 'o')
        return take_degrees(g, "-o's longitude", &time->site.longitude);
    double meridian = time->site.meridian;
    pm_status st = take_degrees(g, "-m's meridian", &meridian);
    if (!time->zone)
        time->site.meridian = meridian;
    return st;
}

/* ---- options ---- */

static pm_status take_radiance(struct sky *s, const char *what, bool irradiance,
                               enum unit *unit, double *out)
{
    *unit = irradiance ? IRRADIANCE : RADIANCE;
    return pm_take_real(s->g, what, out);
}

static pm_status take_value(struct sky *s, char letter, bool *known)
{
    *known = true;
    switch (letter) {
    case 'g':
        return pm_take_real(s->g, "-g's ground reflectance", &s->ground_reflectance);
    case 't':
        return pm_take_real(s->g, "-t's turbidity", &s->turbidity);
    case 'b':
        return take_radiance(s, "-b's zenith radiance", false, &s->zenith_unit, &s->zenith);
    case 'B':
        return take_radiance(s, "-B's diffuse irradiance", true, &s->zenith_unit, &s->zenith);
    case 'r':
        return take_radiance(s, "-r's solar radiance", false, &s->solar_unit, &s->solar);
    case 'R':
        return take_radiance(s, "-R's direct irradiance", true, &s->solar_unit, &s->solar);
    default:
        *known = false;
        return PM_OK;
    }
}

static pm_status take_option(struct sky *s)
{
    pm_generation *g = s->g;
    const char *option = pm_generation_word(g);
    bool known, plus = option[0] == '+';
    pm_status st = pm_take_site(g, &s->time, &known);
    if (st || known)
        return st;
    char letter = (plus || option[0] == '-') && option[1] && !option[2] ? option[1] : '\0';
    g->at++;
    if (letter == 's' || letter == 'i') {
        s->kind = letter == 's' ? CLEAR : INTERMEDIATE;
        s->sun = plus;
        return PM_OK;
    }
    if (letter == 'c' || letter == 'u') {
        s->kind = letter == 'c' ? OVERCAST : UNIFORM;
        return PM_OK;
    }
    st = take_value(s, letter, &known);
    if (st || known)
        return st;
    return pm_generation_fail(
        g, g->at - 1, PM_E_SYNTAX,
        "'%.60s' is no option; they are -s +s -i +i -c -u, and with a value "
        "-g -t -b -B -r -R -a -o -m -y",
        option);
}

/* ---- the sky ---- */

double pm_sky_zenith(double altitude, bool intermediate)
{
    double from_zenith = PM_PI / 2 - altitude, sine = pm_sin(altitude);
    if (intermediate)
        return (2.739 + 0.9891 * pm_sin(0.3119 + 2.6 * altitude)) *
               pm_exp(-from_zenith * (0.4441 + 1.48 * altitude));
    return 0.274 * (0.91 + 10 * pm_exp(-3 * from_zenith) + 0.45 * sine * sine);
}

double pm_sky_zenith_factor(double altitude, bool intermediate)
{
    static const double fits[2][5] = {{2.766521, 0.547665, -0.369832, 0.009237, 0.059229},
                                      {3.5556, -2.7152, -1.3081, 1.0660, 0.60227}};
    double x = altitude / (PM_PI / 4) - 1, integral = 0;
    for (int i = 4; i >= 0; i--)
        integral = integral * x + fits[intermediate][i];
    return integral / pm_sky_zenith(altitude, intermediate) / PM_PI;
}

static bool is_overcast(const struct sky *s)
{
    return s->kind == OVERCAST || s->kind == UNIFORM;
}

/* Diffuse horizontal irradiance / (pi zenith radiance); 7/9 is exact for the overcast sky. */
static double zenith_factor(const struct sky *s)
{
    if (s->kind == UNIFORM)
        return 1;
    if (s->kind == OVERCAST)
        return 0.777778;
    return pm_sky_zenith_factor(s->time.altitude, s->kind == INTERMEDIATE);
}

static double default_zenith(const struct sky *s)
{
    double overcast = 8.6 * s->direction[2] + 0.123;
    double clear = (1.376 * s->turbidity - 1.81) * pm_tan(s->time.altitude) + 0.38;
    double value = is_overcast(s)            ? overcast
                   : s->kind == INTERMEDIATE ? (clear + overcast) / 2
                                             : clear;
    return value < 0 ? 0 : value * 1000 / sky_efficacy;
}

static double default_solar(const struct sky *s)
{
    double sine = s->direction[2] > 0.16 ? s->direction[2] : 0.16;
    double value = 1.5e9 / sun_efficacy * (1.147 - 0.147 / sine);
    return s->kind == INTERMEDIATE ? value * 0.15 : value;
}

static void place_sun(struct sky *s)
{
    pm_sky_time *time = &s->time;
    if (time->moment.month) {
        pm_sun sun = pm_sun_find(&time->site, &time->moment);
        time->altitude = sun.altitude;
        time->azimuth = sun.azimuth;
    }
    /* The models do not hold with the sun in the zenith. */
    if (!is_overcast(s) && time->altitude > 87 * degrees)
        time->altitude = 87 * degrees;
    pm_sun_direction(time->altitude, time->azimuth, s->direction);
}

static void compute(struct sky *s)
{
    place_sun(s);
    double factor = zenith_factor(s), sine = s->direction[2];
    s->scale = is_overcast(s) ? 0 : pm_sky_zenith(s->time.altitude, s->kind == INTERMEDIATE);
    if (s->zenith_unit == IRRADIANCE)
        s->zenith /= factor * PM_PI;
    else if (s->zenith_unit == NOT_GIVEN)
        s->zenith = default_zenith(s);
    s->ground = s->zenith * factor;
    if (!is_overcast(s) && sine > 0 && (s->solar_unit == NOT_GIVEN || s->solar > 0)) {
        if (s->solar_unit == IRRADIANCE)
            s->solar /= sun_solid_angle * sine;
        else if (s->solar_unit == NOT_GIVEN)
            s->solar = default_solar(s);
        s->ground += sun_solid_angle / PM_PI * s->solar * sine;
    } else {
        s->sun = false;
    }
    s->ground *= s->ground_reflectance;
}

/* With the digits that Radiance prints: its skies are known to no more, and so are ours. */
static void put_sky(const struct sky *s)
{
    pm_generation *g = s->g;
    const double *d = s->direction;
    if (s->sun)
        pm_put(g,
               "void light solar\n0\n0\n3 %.2e %.2e %.2e\nsolar source sun\n0\n0\n"
               "4 %f %f %f 0.5\n",
               s->solar, s->solar, s->solar, d[0], d[1], d[2]);
    pm_put(g, "void brightfunc skyfunc\n2 skybr skybright.cal\n0\n");
    if (is_overcast(s))
        pm_put(g, "3 %d %.2e %.2e\n", s->kind, s->zenith, s->ground);
    else
        pm_put(g, "7 %d %.2e %.2e %.2e %f %f %f\n", s->kind, s->zenith, s->ground, s->scale,
               d[0], d[1], d[2]);
}

pm_status pm_gensky(pm_generation *g)
{
    struct sky s = {
        .g = g, .kind = CLEAR, .sun = true, .turbidity = 2.45, .ground_reflectance = 0.2};
    pm_status st = pm_take_sky_time(g, true, &s.time);
    while (!st && pm_generation_word(g))
        st = take_option(&s);
    if (st || !pm_generation_begin(g, 3, 14, 0))
        return st;
    compute(&s);
    if (!isfinite(s.zenith + s.ground + s.solar + s.scale))
        return pm_generation_fail(g, 0, PM_E_RANGE,
                                  "these arguments lead to a sky that is not finite; look at "
                                  "the altitude and the radiances");
    put_sky(&s);
    return pm_generation_end(g);
}
