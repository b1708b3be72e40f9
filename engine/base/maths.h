#ifndef PM_BASE_MATHS_H
#define PM_BASE_MATHS_H

/* Elementary functions whose bits do not depend on the processor: SLEEF's purecfma variants,
 * at most 1 ULP off. The C library picks its own variants at run time, so nothing that steers a
 * path or enters a sum may call sin, cos, exp, log, pow, erf or an inverse of them from
 * <math.h>; sqrt, fabs, floor and fma are exact everywhere and may be used. */

#define PM_PI 3.14159265358979323846

double pm_sin(double x);
double pm_cos(double x);
void pm_sincos(double x, double *sine, double *cosine);
double pm_tan(double x);
double pm_exp(double x);
double pm_log(double x);
double pm_log10(double x);
double pm_pow(double x, double y);
double pm_acos(double x);
double pm_asin(double x);
double pm_atan(double x);
double pm_atan2(double y, double x);
double pm_erf(double x);
double pm_erfc(double x); /* 1.5 ULP */

#endif
