#include "base/maths.h"

#include <immintrin.h> /* sleef.h needs its vector types */

#include <sleef.h>

double pm_sin(double x)
{
    return Sleef_finz_sind1_u10purecfma(x);
}

double pm_cos(double x)
{
    return Sleef_finz_cosd1_u10purecfma(x);
}

void pm_sincos(double x, double *sine, double *cosine)
{
    Sleef_double_2 both = Sleef_finz_sincosd1_u10purecfma(x);
    *sine = both.x;
    *cosine = both.y;
}

double pm_tan(double x)
{
    return Sleef_finz_tand1_u10purecfma(x);
}

double pm_exp(double x)
{
    return Sleef_finz_expd1_u10purecfma(x);
}

double pm_log(double x)
{
    return Sleef_finz_logd1_u10purecfma(x);
}

double pm_pow(double x, double y)
{
    return Sleef_finz_powd1_u10purecfma(x, y);
}

double pm_acos(double x)
{
    return Sleef_finz_acosd1_u10purecfma(x);
}

double pm_atan2(double y, double x)
{
    return Sleef_finz_atan2d1_u10purecfma(y, x);
}

double pm_asin(double x)
{
    return Sleef_finz_asind1_u10purecfma(x);
}

double pm_atan(double x)
{
    return Sleef_finz_atand1_u10purecfma(x);
}

double pm_log10(double x)
{
    return Sleef_finz_log10d1_u10purecfma(x);
}

double pm_erf(double x)
{
    return Sleef_finz_erfd1_u10purecfma(x);
}

double pm_erfc(double x)
{
    return Sleef_finz_erfcd1_u15purecfma(x);
}
