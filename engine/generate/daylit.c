#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "generate/sky.h"

/* gendaylit(1): the all-weather sky of Perez from direct and diffuse irradiance.
 *
 * Sources: R. Perez, R. Seals, J. Michalsky, "All-weather model for sky luminance
 * distribution", Solar Energy 50(3), 1993 (distribution and its table); R. Perez, P. Ineichen,
 * R. Seals, J. Michalsky, R. Stewart, "Modeling daylight availability and irradiance components
 * from direct and global irradiance", Solar Energy 44(5), 1990 (clearness, luminous
 * efficacies); F. Kasten, "A new table and approximation formula for the relative optical air
 * mass", 1966; J. Spencer, "Fourier series representation of the position of the sun", 1971
 * (distance); D. Erbs, S. Klein, J. Duffie, "Estimation of the diffuse radiation fraction",
 * Solar Energy 28(4), 1982; colours: A. Diakite, TU Berlin; P. Tregenza, "Subdivision of the
 * sky hemisphere for luminance measurements", 1987. Where Radiance's program rounds a table to
 * single precision or limits a value, so does this. */

static const double degrees = PM_PI / 180;

static const double solar_constant = 1367;      /* [W/m^2] */
static const double solar_illuminance = 127500; /* [lux] */
static const double white_efficacy = 179;       /* [lm/W], of Radiance's radiance */
static const double sun_radius_deg = 0.2665;

static const double least_clearness = 1, most_clearness = 12.01;
static const double least_brightness = 0.01, most_brightness = 0.6;

enum { BINS = 8 };

/* Where the clearness bins begin: Perez 1990, table 1. */
static const double bin_starts[BINS] = {1, 1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2};

/* Luminous efficacies, a + b W + c f(zenith angle) + d g(brightness): Perez 1990, table 4. */
static const double diffuse_efficacy[BINS][4] = {
    {97.24, -0.46, 12.00, -8.91},   {107.22, 1.15, 0.59, -3.95},
    {104.97, 2.96, -5.53, -8.77},   {102.39, 5.59, -13.95, -13.90},
    {100.71, 5.94, -22.75, -23.74}, {106.42, 3.83, -36.15, -28.83},
    {141.88, 1.90, -53.24, -14.03}, {152.23, 0.35, -45.27, -7.98}};
static const double direct_efficacy[BINS][4] = {
    {57.20, -4.55, -2.98, 117.12}, {98.99, -3.46, -1.21, 12.38},
    {109.83, -4.90, -1.71, -8.81}, {110.34, -5.84, -1.99, -4.56},
    {106.36, -3.97, -1.75, -6.16}, {107.19, -1.25, -1.51, -26.73},
    {105.75, 0.77, -1.26, -34.44}, {101.18, 1.58, -1.10, -8.29}};

/* Of the distribution: four numbers for each of a, b, c, d, e. Perez 1993, table 1. */
static const float distribution[BINS][5][4] = {
    {{1.3525F, -0.2576F, -0.2690F, -1.4366F},
     {-0.7670F, 0.0007F, 1.2734F, -0.1233F},
     {2.8000F, 0.6004F, 1.2375F, 1.0000F},
     {1.8734F, 0.6297F, 0.9738F, 0.2809F},
     {0.0356F, -0.1246F, -0.5718F, 0.9938F}},
    {{-1.2219F, -0.7730F, 1.4148F, 1.1016F},
     {-0.2054F, 0.0367F, -3.9128F, 0.9156F},
     {6.9750F, 0.1774F, 6.4477F, -0.1239F},
     {-1.5798F, -0.5081F, -1.7812F, 0.1080F},
     {0.2624F, 0.0672F, -0.2190F, -0.4285F}},
    {{-1.1000F, -0.2515F, 0.8952F, 0.0156F},
     {0.2782F, -0.1812F, -4.5000F, 1.1766F},
     {24.7219F, -13.0812F, -37.7000F, 34.8438F},
     {-5.0000F, 1.5218F, 3.9229F, -2.6204F},
     {-0.0156F, 0.1597F, 0.4199F, -0.5562F}},
    {{-0.5484F, -0.6654F, -0.2672F, 0.7117F},
     {0.7234F, -0.6219F, -5.6812F, 2.6297F},
     {33.3389F, -18.3000F, -62.2500F, 52.0781F},
     {-3.5000F, 0.0016F, 1.1477F, 0.1062F},
     {0.4659F, -0.3296F, -0.0876F, -0.0329F}},
    {{-0.6000F, -0.3566F, -2.5000F, 2.3250F},
     {0.2937F, 0.0496F, -5.6812F, 1.8415F},
     {21.0000F, -4.7656F, -21.5906F, 7.2492F},
     {-3.5000F, -0.1554F, 1.4062F, 0.3988F},
     {0.0032F, 0.0766F, -0.0656F, -0.1294F}},
    {{-1.0156F, -0.3670F, 1.0078F, 1.4051F},
     {0.2875F, -0.5328F, -3.8500F, 3.3750F},
     {14.0000F, -0.9999F, -7.1406F, 7.5469F},
     {-3.4000F, -0.1078F, -1.0750F, 1.5702F},
     {-0.0672F, 0.4016F, 0.3017F, -0.4844F}},
    {{-1.0000F, 0.0211F, 0.5025F, -0.5119F},
     {-0.3000F, 0.1922F, 0.7023F, -1.6317F},
     {19.0000F, -5.0000F, 1.2438F, -1.9094F},
     {-4.0000F, 0.0250F, 0.3844F, 0.2656F},
     {1.0468F, -0.3788F, -2.4517F, 1.4656F}},
    {{-1.0500F, 0.0289F, 0.4260F, 0.3590F},
     {-0.3250F, 0.1156F, 0.7781F, 0.0025F},
     {31.0625F, -14.5000F, -46.1148F, 55.3750F},
     {-7.2312F, 0.4050F, 13.3500F, 0.6234F},
     {1.5000F, -0.6426F, 1.8564F, 0.5636F}},
};

/* Colour temperature by luminance: 4 for a clear sky, 4 for an overcast one, and the three of a
 * daylight locus. Berlin's by default. */
static const float berlin[11] = {-4.843e9F, 2.5568e6F, 0.24282e3F, 0.23258F,
                                 -4.843e9F, 2.5568e6F, 0.24282e3F, 0.23258F,
                                 -1.2848F,  1.7519F,   -0.093786F};
static const float cie[11] = {-4.607e9F,  2.9678e6F, 0.09911e3F, 0.244063F,
                              -2.0064e9F, 1.9018e6F, 0.24748e3F, 0.23704F,
                              -3.0F,      2.87F,     -0.275F};

enum input { PEREZ, NORMAL_IRRADIANCE, ILLUMINANCE, HORIZONTAL_IRRADIANCE, GLOBAL_IRRADIANCE };
enum output { VISIBLE, SOLAR, LUMINANCE };

struct daylit {
    pm_generation *g;
    pm_sky_time time;
    enum input input;
    int64_t output;
    bool cloudy, sun, colored, dark;
    double dew_point, interval; /* [C], [min] */
    double ground_reflectance;
    float locus[11];
    double given[2];
    double zenith_angle; /* of the sun [radian] */
    double direction[3];
    double water;                 /* precipitable [cm] */
    double distance;              /* (mean distance / distance)^2 of the sun */
    double clearness, brightness; /* Perez's epsilon and Delta */
    double direct, diffuse;       /* irradiances: normal, horizontal [W/m^2] */
    double direct_lux, diffuse_lux;
    double shape[5];             /* of the distribution */
    double scale, ground, solar; /* radiances, or luminances */
};

/* ---- options ---- */

static pm_status take_pair(struct daylit *d, enum input input, const char *first,
                           const char *second)
{
    d->input = input;
    pm_status st = pm_take_real(d->g, first, &d->given[0]);
    return st || !second ? st : pm_take_real(d->g, second, &d->given[1]);
}

static pm_status take_locus(struct daylit *d)
{
    pm_status st = PM_OK;
    for (int i = 0; !st && i < 7; i++) {
        double number = 0;
        st = pm_take_real(d->g, "one of -l's seven numbers", &number);
        d->locus[i < 4 ? i : i + 4] = (float)number;
    }
    memcpy(d->locus + 4, d->locus, 4 * sizeof *d->locus);
    return st;
}

/* Options that Radiance's program reads without using them. */
static pm_status take_unused(struct daylit *d)
{
    double unused;
    return pm_take_real(d->g, "a number", &unused);
}

static pm_status take_input(struct daylit *d, char letter, bool *known)
{
    *known = true;
    switch (letter) {
    case 'P':
        return take_pair(d, PEREZ, "-P's epsilon", "-P's delta");
    case 'W':
        return take_pair(d, NORMAL_IRRADIANCE, "-W's direct normal irradiance",
                         "-W's diffuse irradiance");
    case 'L':
        return take_pair(d, ILLUMINANCE, "-L's direct normal illuminance",
                         "-L's diffuse illuminance");
    case 'G':
        return take_pair(d, HORIZONTAL_IRRADIANCE, "-G's direct horizontal irradiance",
                         "-G's diffuse irradiance");
    case 'E':
        return take_pair(d, GLOBAL_IRRADIANCE, "-E's global irradiance", NULL);
    default:
        *known = false;
        return PM_OK;
    }
}

static pm_status take_number(struct daylit *d, char letter, bool *known)
{
    pm_status st = PM_OK;
    *known = true;
    switch (letter) {
    case 'O':
        return pm_take_integer(d->g, "-O's output", VISIBLE, LUMINANCE, &d->output);
    case 'g':
        return pm_take_real(d->g, "-g's ground reflectance", &d->ground_reflectance);
    case 'i':
        st = pm_take_real(d->g, "-i's time interval", &d->interval);
        if (!st && d->interval < 0)
            st = pm_generation_fail(d->g, d->g->at - 1, PM_E_RANGE,
                                    "-i takes an interval in minutes, at least 0");
        return st;
    case 'd':
        return pm_take_real(d->g, "-d's dew point", &d->dew_point);
    case 'l':
        return take_locus(d);
    case 't':
    case 'b':
    case 'R':
        return take_unused(d);
    default:
        *known = false;
        return PM_OK;
    }
}

static bool take_switch(struct daylit *d, const char *option)
{
    bool plus = option[0] == '+';
    if (strcmp(option + 1, "CIE") == 0) {
        memcpy(d->locus, cie, sizeof cie);
        return true;
    }
    if (option[1] == '\0' || option[2] != '\0')
        return false;
    switch (option[1]) {
    case 's':
        d->cloudy = false;
        d->sun = plus;
        return true;
    case 'c':
        d->cloudy = true;
        d->sun = false;
        return true;
    case 'C':
        d->colored = true;
        return true;
    default:
        return option[1] == 'w'; /* without warnings: there are none here */
    }
}

static pm_status take_option(struct daylit *d)
{
    pm_generation *g = d->g;
    const char *option = pm_generation_word(g);
    bool known;
    pm_status st = pm_take_site(g, &d->time, &known);
    if (st || known)
        return st;
    g->at++;
    bool signed_word = option[0] == '-' || option[0] == '+';
    if (signed_word && take_switch(d, option))
        return PM_OK;
    char letter = signed_word && option[1] && !option[2] ? option[1] : '\0';
    st = take_input(d, letter, &known);
    if (!st && !known)
        st = take_number(d, letter, &known);
    if (st || known)
        return st;
    return pm_generation_fail(
        g, g->at - 1, PM_E_SYNTAX,
        "'%.60s' is no option; they are -P -W -L -G -E with the weather, -O "
        "-s +s -c -C -CIE -w, and with a value -g -i -d -l -a -o -m -y",
        option);
}

/* ---- the sun ---- */

/* Half the day's length at that site [h]; none where the sun does not rise or set. */
static double half_day(const pm_site *site, int day)
{
    double w = -pm_tan(site->latitude) * pm_tan(pm_sun_declination(day));
    return (PM_PI / 2 - pm_atan2(w, sqrt(1 - w * w))) / (PM_PI / 12);
}

/* Moves the sun into the daylight part of the time interval. False if it is night. */
static bool settle_hour(const struct daylit *d, double *hour)
{
    const pm_moment *m = &d->time.moment;
    double half = half_day(&d->time.site, pm_day_of_year(m->month, m->day));
    double rise = 12 - half, set = 12 + half, slack = d->interval / 120;
    if (d->interval > 0 && fabs(rise - *hour) <= slack)
        *hour = (*hour + slack + rise) / 2;
    if (d->interval > 0 && fabs(set - *hour) < slack)
        *hour = (*hour - slack + set) / 2;
    return !(*hour < rise - slack || *hour > set + slack);
}

static void place_sun(struct daylit *d)
{
    pm_sky_time *time = &d->time;
    int day = 0;
    if (time->moment.month) {
        pm_sun sun = pm_sun_find(&time->site, &time->moment);
        double hour = sun.hour;
        day = pm_day_of_year(time->moment.month, time->moment.day);
        d->dark = !settle_hour(d, &hour);
        pm_sun_turn(&time->site, hour, &sun);
        time->altitude = sun.altitude;
        time->azimuth = sun.azimuth;
    }
    if (!d->dark && !d->cloudy && time->altitude > 87 * degrees)
        time->altitude = 87 * degrees; /* the model does not hold in the zenith */
    pm_sun_direction(time->altitude, time->azimuth, d->direction);
    d->zenith_angle = PM_PI / 2 - time->altitude;
    double angle = 2 * PM_PI * (day - 1) / 365; /* Spencer 1971 */
    d->distance = 1.00011 + 0.034221 * pm_cos(angle) + 0.00128 * pm_sin(angle) +
                  0.000719 * pm_cos(2 * angle) + 0.000077 * pm_sin(2 * angle);
}

/* ---- Perez's parameters ---- */

static double limited(double x, double least, double most, double instead)
{
    return x < least ? least : x > most ? instead : x;
}

static void limit_parameters(struct daylit *d)
{
    d->clearness =
        limited(d->clearness, least_clearness, most_clearness, most_clearness - 0.001);
    d->brightness = limited(d->brightness, least_brightness, most_brightness, most_brightness);
}

/* Relative air mass (Kasten 1966). */
static double air_mass(struct daylit *d)
{
    if (d->zenith_angle > PM_PI / 2)
        d->zenith_angle = PM_PI / 2;
    return 1 / (pm_cos(d->zenith_angle) +
                0.15 * pm_pow(93.885 - d->zenith_angle / degrees, -1.253));
}

/* 1.041 z^3, in the definition of clearness (Perez 1990, equation 1). */
static double zenith_term(const struct daylit *d)
{
    return 1.041 * d->zenith_angle * d->zenith_angle * d->zenith_angle;
}

static void parameters_from_irradiances(struct daylit *d)
{
    d->brightness = d->diffuse * air_mass(d) / (solar_constant * d->distance);
    double term = zenith_term(d);
    d->clearness = ((d->diffuse + d->direct) / d->diffuse + term) / (1 + term);
    limit_parameters(d);
}

static void irradiances_from_parameters(struct daylit *d)
{
    d->diffuse = d->brightness / air_mass(d) * solar_constant * d->distance;
    d->direct = d->diffuse * (d->clearness - 1) * (1 + zenith_term(d));
}

/* The bin of a clearness, -1 if it is none. */
static int bin_of(double clearness)
{
    int bin = -1;
    for (int i = 0; i < BINS && clearness < most_clearness; i++)
        bin = clearness >= bin_starts[i] ? i : bin;
    return bin;
}

static double diffuse_efficacy_of(const struct daylit *d, int bin)
{
    const double *k = diffuse_efficacy[bin];
    return k[0] + k[1] * d->water + k[2] * pm_cos(d->zenith_angle) +
           k[3] * pm_log(d->brightness);
}

static double direct_efficacy_of(const struct daylit *d, int bin)
{
    const double *k = direct_efficacy[bin];
    double value = k[0] + k[1] * d->water + k[2] * pm_exp(5.73 * d->zenith_angle - 5) +
                   k[3] * d->brightness;
    return value < 0 ? 0 : value;
}

/* Negative components count as none. Sets `dark` for a sky that cannot be. */
static void check_components(struct daylit *d, double *direct, double *diffuse, double most)
{
    *direct = *direct < 0 ? 0 : *direct;
    *diffuse = *diffuse < 0 ? 0 : *diffuse;
    d->dark |= (*direct + *diffuse == 0 && d->time.altitude > 0) || *direct > most;
}

static void illuminances_from_irradiances(struct daylit *d)
{
    int bin = bin_of(d->clearness);
    d->dark |= bin < 0;
    if (d->dark || d->output == SOLAR)
        return;
    d->diffuse_lux = d->diffuse * diffuse_efficacy_of(d, bin);
    d->direct_lux = d->direct * direct_efficacy_of(d, bin);
    check_components(d, &d->direct_lux, &d->diffuse_lux, solar_illuminance);
}

/* Ten steps at most towards irradiances whose efficacies give these illuminances. */
static void irradiances_from_illuminances(struct daylit *d)
{
    double last_diffuse = 0.1, last_direct = 0.1;
    d->diffuse = d->diffuse_lux * solar_constant / solar_illuminance;
    d->direct = d->direct_lux * solar_constant / solar_illuminance;
    parameters_from_irradiances(d);
    for (int step = 0; step < 9; step++) {
        bool settled = fabs(d->diffuse - last_diffuse) <= 10 &&
                       fabs(d->direct - last_direct) <= 10 &&
                       (d->clearness < least_clearness || d->clearness > most_clearness) &&
                       (d->brightness < least_brightness || d->brightness > most_brightness);
        int bin = bin_of(d->clearness);
        d->dark |= bin < 0;
        if (settled || d->dark)
            return;
        last_diffuse = d->diffuse;
        last_direct = d->direct;
        d->diffuse = d->diffuse_lux / diffuse_efficacy_of(d, bin);
        double efficacy = direct_efficacy_of(d, bin);
        d->direct = efficacy < 0.1 ? 0 : d->direct_lux / efficacy;
        parameters_from_irradiances(d);
    }
}

/* Splits global irradiance into direct and diffuse (Erbs 1982). */
static void split_global(struct daylit *d)
{
    double sine = d->direction[2], global = d->given[0];
    d->direct = d->diffuse = 0;
    if (d->time.altitude <= 0)
        return;
    double most = solar_constant * d->distance * sine;
    global = global > most ? 0.999 * most : global;
    double kt = global / most, share = 0.165;
    if (kt <= 0.22)
        share = 1 - 0.09 * kt;
    else if (kt <= 0.8)
        share = 0.9511 + kt * (-0.1604 + kt * (4.388 + kt * (-16.638 + kt * 12.336)));
    d->diffuse = global * share;
    d->direct = (global - d->diffuse) / sine;
}

static void read_weather(struct daylit *d)
{
    d->clearness = d->given[0];
    d->brightness = d->given[1];
    d->direct = d->direct_lux = d->given[0];
    d->diffuse = d->diffuse_lux = d->given[1];
    if (d->input == ILLUMINANCE) {
        check_components(d, &d->direct_lux, &d->diffuse_lux, solar_illuminance);
        if (!d->dark)
            irradiances_from_illuminances(d);
        return;
    }
    bool sets = d->input == HORIZONTAL_IRRADIANCE && d->time.altitude <= 0;
    if (d->input == GLOBAL_IRRADIANCE)
        split_global(d);
    else if (d->input == HORIZONTAL_IRRADIANCE)
        d->direct = sets ? 0 : d->direct / d->direction[2];
    d->diffuse = sets ? 0 : d->diffuse;
    if (d->input == PEREZ) {
        limit_parameters(d);
        irradiances_from_parameters(d);
    }
    check_components(d, &d->direct, &d->diffuse, solar_constant);
    if (!d->dark && d->input != PEREZ)
        parameters_from_irradiances(d);
    if (!d->dark)
        illuminances_from_irradiances(d);
}

/* ---- the distribution ---- */

/* Perez 1993, equations 6 to 9. */
static void shape_sky(struct daylit *d)
{
    int bin = bin_of(d->clearness);
    double z = d->zenith_angle, delta = d->brightness;
    if (d->clearness > 1.065 && d->clearness < 2.8 && delta < 0.2)
        delta = 0.2; /* the authors' correction */
    for (int i = 0; i < 5; i++) {
        const float *x = distribution[bin][i];
        d->shape[i] =
            (double)x[0] + (double)x[1] * z + delta * ((double)x[2] + (double)x[3] * z);
        if (bin == 0 && i == 2)
            d->shape[i] =
                pm_exp(pm_pow(delta * ((double)x[0] + (double)x[1] * z), (double)x[2])) -
                (double)x[3];
        if (bin == 0 && i == 3)
            d->shape[i] = -pm_exp(delta * ((double)x[0] + (double)x[1] * z)) + (double)x[2] +
                          delta * (double)x[3];
    }
}

/* Relative luminance at an angle from the zenith, and from the sun (equation 1). */
static double relative(const struct daylit *d, double cos_zenith, double cos_sun)
{
    const double *k = d->shape;
    double c = cos_sun > 1 ? 1 : cos_sun < -1 ? -1 : cos_sun;
    return (1 + k[0] * pm_exp(k[1] / cos_zenith)) *
           (1 + k[2] * pm_exp(k[3] * pm_acos(c)) + k[4] * c * c);
}

/* Irradiance of the relative sky: the 145 patches of Tregenza, each the same solid angle. */
static double integrate(const struct daylit *d)
{
    static const int rows[8] = {30, 30, 24, 24, 18, 12, 6, 1};
    double sum = 0, sz, cz;
    pm_sincos(d->zenith_angle, &sz, &cz);
    for (int row = 0; row < 8; row++) {
        double s, c;
        pm_sincos((84 - 12 * row) * degrees, &s, &c);
        for (int i = 0; i < rows[row]; i++) {
            double turn = pm_cos(2 * PM_PI * i / rows[row]);
            sum += (double)(float)relative(d, c, cz * c + sz * s * turn) * c;
        }
    }
    return sum * 2 * PM_PI / 145;
}

static bool has_sun(const struct daylit *d)
{
    return d->sun && d->clearness > 1;
}

static void compute(struct daylit *d)
{
    shape_sky(d);
    double diffuse = d->output == SOLAR ? d->diffuse : d->diffuse_lux;
    double direct = d->output == SOLAR ? d->direct : d->direct_lux;
    double unit = d->output == VISIBLE ? white_efficacy : 1;
    d->scale = diffuse / integrate(d) / unit;
    d->solar = direct / (2 * PM_PI * (1 - pm_cos(sun_radius_deg * degrees))) / unit;
    double zenith = relative(d, 1, pm_cos(d->zenith_angle)) * d->scale;
    double factor =
        d->clearness == 1 ? 0.777778 : pm_sky_zenith_factor(d->time.altitude, d->clearness < 6);
    d->ground = zenith * factor;
    if (has_sun(d))
        d->ground += 6.8e-5 / PM_PI * d->solar * d->direction[2];
    d->ground *= d->ground_reflectance;
    /* Brightness that grows without end towards the horizon is no sky. */
    d->dark = d->shape[1] > 0 || !isfinite(d->scale + d->ground + d->solar);
}

/* ---- writing ---- */

static void put_sun(const struct daylit *d)
{
    double radiance = has_sun(d) ? d->solar : 0;
    if (d->sun)
        pm_put(d->g,
               "void light solar\n0\n0\n3 %.3e %.3e %.3e\nsolar source sun\n0\n0\n"
               "4 %f %f %f %f\n",
               radiance, radiance, radiance, d->direction[0], d->direction[1], d->direction[2],
               2 * sun_radius_deg);
}

static void put_sky(const struct daylit *d)
{
    const double *k = d->shape, *v = d->direction;
    /* The colour model has no intermediate skies. */
    bool colored = d->colored && !(d->clearness < 4.5 && d->clearness > 1.065);
    if (colored)
        pm_put(d->g, "void colorfunc skyfunc\n4 skybright_r skybright_g skybright_b "
                     "perezlum_c.cal\n0\n22");
    else
        pm_put(d->g, "void brightfunc skyfunc\n2 skybright perezlum.cal\n0\n10");
    pm_put(d->g, " %.3e %.3e %f %f %f %f %f %f %f %f", d->scale, d->ground, k[0], k[1], k[2],
           k[3], k[4], v[0], v[1], v[2]);
    if (colored)
        pm_put(d->g, " %f", d->clearness);
    for (int i = 0; colored && i < 11; i++)
        pm_put(d->g, " %f", (double)d->locus[i]);
    pm_put(d->g, "\n");
}

/* What Radiance's program makes of a night, or of weather that cannot be: a black sky. */
static void put_dark(const struct daylit *d)
{
    const double *v = d->direction;
    pm_put(d->g,
           "void brightfunc skyfunc\n2 skybright perezlum.cal\n0\n10 0 0 0 0 0 0 0 %f %f %f\n",
           v[0], v[1], v[2]);
}

static pm_status read_daylit(struct daylit *d)
{
    static const double radiance_dew_point = 10.97353115; /* 2 cm of water */
    pm_status st = pm_take_sky_time(d->g, false, &d->time);
    while (!st && pm_generation_word(d->g))
        st = take_option(d);
    if (d->dew_point < -40 || d->dew_point > 40)
        d->dew_point = radiance_dew_point;
    d->water = pm_exp(0.07 * d->dew_point - 0.075); /* Perez 1990, equation 3 */
    return st;
}

pm_status pm_gendaylit(pm_generation *g)
{
    struct daylit d = {.g = g, .sun = true, .ground_reflectance = 0.2, .dew_point = 1e9};
    memcpy(d.locus, berlin, sizeof berlin);
    pm_status st = read_daylit(&d);
    if (st || !pm_generation_begin(g, 3, 29, 0))
        return st;
    place_sun(&d);
    if (!d.dark)
        read_weather(&d);
    if (!d.dark)
        compute(&d);
    if (d.dark) {
        put_dark(&d);
    } else {
        put_sun(&d);
        put_sky(&d);
    }
    return pm_generation_end(g);
}
