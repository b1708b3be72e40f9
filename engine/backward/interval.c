#include <assert.h>
#include <stdlib.h>

#include "backward/backward_internal.h"
#include "base/maths.h"

double pm_student_quantile(unsigned freedom)
{
    /* Abramowitz and Stegun 1964, table 26.10. */
    static const double quantiles[PM_REPLICATES - 1] = {12.706, 4.303, 3.182, 2.776, 2.571,
                                                        2.447,  2.365, 2.306, 2.262, 2.228,
                                                        2.201,  2.179, 2.160, 2.145, 2.131};
    assert(freedom >= 1 && freedom < PM_REPLICATES);
    return quantiles[freedom - 1];
}

/* A replicate mean of n passes has a variance in proportion to 1 / n. So with weights n the
 * estimate of the variance of the common mean is sum n (m - M)^2 / ((R - 1) sum n) (Cochran,
 * Sampling Techniques, 1977, 5.3: strata in proportion). */
struct pm_interval pm_interval_of(const double sum[PM_REPLICATES],
                                  const uint32_t passes[PM_REPLICATES])
{
    double total = 0, weight = 0, scatter = 0;
    unsigned replicates = 0;
    for (int r = 0; r < PM_REPLICATES; r++) {
        total += sum[r];
        weight += passes[r];
        replicates += passes[r] > 0;
    }
    double mean = weight > 0 ? total / weight : 0;
    if (replicates < 2)
        return (struct pm_interval){mean, INFINITY, 1};
    for (int r = 0; r < PM_REPLICATES; r++) {
        double off = passes[r] ? sum[r] / passes[r] - mean : 0;
        scatter += passes[r] * off * off;
    }
    return (struct pm_interval){mean, scatter / ((replicates - 1) * weight), replicates - 1};
}

static struct pm_interval interval_at(const pm_accumulation *a, size_t i)
{
    double sum[PM_REPLICATES];
    for (size_t r = 0; r < PM_REPLICATES; r++)
        sum[r] = a->sums[r * 3 * a->count + i];
    return pm_interval_of(sum, a->replicate_passes);
}

/* Squared standard error from photons that all passes share. Their noise is the same in each,
 * so deviations add up, not variances. */
static double shared_variance(const pm_accumulation *a, size_t i)
{
    double deviation = a->passes ? a->deviation[i] / a->passes : 0;
    return deviation * deviation;
}

void pm_accumulation_mean(const pm_accumulation *accumulation, float *out)
{
    for (size_t i = 0; i < 3 * accumulation->count; i++)
        out[i] = (float)interval_at(accumulation, i).mean;
}

/* The rule of three: what n samples never showed is, at 95 %, rarer than 3 / n. Its size is
 * unknown; the greatest value of that channel elsewhere stands for it. */
static double unseen_bound(const pm_accumulation *a, double greatest)
{
    if (!a->lit)
        return 0;
    return greatest > 0 ? fmin(1, 3.0 / a->passes) * greatest : INFINITY;
}

void pm_accumulation_half_width(const pm_accumulation *accumulation, float *out)
{
    const double normal_quantile = 1.960;
    double greatest[3] = {0};
    size_t values = 3 * accumulation->count;
    for (size_t i = 0; i < values; i++)
        greatest[i % 3] = fmax(greatest[i % 3], interval_at(accumulation, i).mean);
    for (size_t i = 0; i < values; i++) {
        struct pm_interval interval = interval_at(accumulation, i);
        double student = pm_student_quantile(interval.freedom);
        double shared = shared_variance(accumulation, i);
        double square =
            student * student * interval.variance + normal_quantile * normal_quantile * shared;
        bool unseen = interval.mean == 0 && square == 0;
        out[i] = (float)(unseen ? unseen_bound(accumulation, greatest[i % 3]) : sqrt(square));
    }
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median of the replicate means: unlike the mean, one stray sample does not move it. */
static double median_at(const pm_accumulation *a, size_t i)
{
    double means[PM_REPLICATES];
    size_t replicates = 0;
    for (size_t r = 0; r < PM_REPLICATES; r++)
        if (a->replicate_passes[r])
            means[replicates++] = a->sums[r * 3 * a->count + i] / a->replicate_passes[r];
    qsort(means, replicates, sizeof *means, by_size);
    return means[replicates / 2];
}

static double mean_value(const pm_accumulation *a)
{
    double sum = 0;
    size_t values = 3 * a->count;
    for (size_t i = 0; i < values; i++)
        sum += interval_at(a, i).mean;
    return values ? sum / (double)values : 0;
}

double pm_accumulation_error(const pm_accumulation *accumulation)
{
    double squares = 0, common = mean_value(accumulation);
    size_t values = 3 * accumulation->count;
    if (accumulation->passes < 2)
        return INFINITY;
    if (common == 0)
        return accumulation->lit ? INFINITY : 0;
    for (size_t i = 0; i < values; i++) {
        struct pm_interval interval = interval_at(accumulation, i);
        double scale =
            interval.mean > common ? fmax(median_at(accumulation, i), common) : common;
        squares += (interval.variance + shared_variance(accumulation, i)) / (scale * scale);
    }
    return sqrt(squares / (double)values);
}

/* Gamma(n + 1 + alpha) / Gamma(n + 2), to 1e-14 from n = 1000 on (Tricomi and
 * Erdelyi, "The asymptotic expansion of a ratio of gamma functions", Pacific J. Math. 1, 1951).
 */
static double late_share(double n, double alpha)
{
    double w = n + 1 + alpha / 2;
    return pm_pow(w, alpha - 1) * (1 - alpha * (alpha - 1) * (alpha - 2) / (24 * w * w));
}

double pm_progressive_radius(double first_radius, uint32_t pass)
{
    enum { EARLY = 1024 };
    const double alpha = 2.0 / 3;
    double square = first_radius * first_radius;
    for (uint32_t k = 1; k <= pass && k <= EARLY; k++)
        square *= (k + alpha) / (k + 1.0);
    if (pass > EARLY)
        square *= late_share(pass, alpha) / late_share(EARLY, alpha);
    return sqrt(square);
}
