#include "physics.h"

#include "bundle_text.h"

/* ---- numbers ---- */

void stat_add(struct stat *stat, double value)
{
    double off = value - stat->mean;
    stat->mean += off / ++stat->count;
    stat->squares += off * (value - stat->mean);
}

double stat_deviation(const struct stat *stat)
{
    return sqrt(stat->squares / (stat->count - 1));
}

double stat_error(const struct stat *stat)
{
    return stat_deviation(stat) / sqrt(stat->count);
}

void expect_equal_means(const char *what, const struct stat *got, double want,
                        double want_error, double slack)
{
    double error = hypot(stat_error(got), want_error);
    double allowed = K_SIGMA * error + slack + ROUNDING * fabs(want);
    if (!(fabs(got->mean - want) <= allowed))
        fail_msg("%s: got %.7g, want %.7g (%+.3f %%), allowed %.3g of which bias %.3g", what,
                 got->mean, want, 100 * (got->mean / want - 1), allowed, slack);
}

void expect_mean(const char *what, const struct stat *got, double want, double slack)
{
    expect_equal_means(what, got, want, 0, slack);
}

void expect_near(const char *what, double got, double want, double slack)
{
    if (!(fabs(got - want) <= slack + ROUNDING * fabs(want)))
        fail_msg("%s: got %.9g, want %.9g, allowed difference %.3g", what, got, want, slack);
}

double integrate(double (*f)(double, const void *), const void *context, double a, double b,
                 int steps)
{
    const double node = 0.7745966692414834; /* sqrt(3 / 5) */
    double half = (b - a) / (2 * steps), sum = 0;
    for (int i = 0; i < steps; i++) {
        double middle = a + (2 * i + 1) * half;
        sum += 8 * f(middle, context) + 5 * f(middle - half * node, context) +
               5 * f(middle + half * node, context);
    }
    return sum * half / 9;
}

pm_vec3 sphere_point(int i, int count)
{
    const double golden = 2.399963229728653; /* pi (3 - sqrt(5)) */
    double z = 1 - 2 * (i + .5) / count, r = sqrt(1 - z * z);
    return (pm_vec3){r * cos(golden * i), r * sin(golden * i), z};
}

/* ---- scenes ---- */

double sun_radiance(void)
{
    return 1 / (4 * PI * pow(sin(SUN_DEGREES * PI / 720), 2));
}

char *text_of(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    int length = vsnprintf(NULL, 0, format, args);
    va_end(args);
    char *text = malloc((size_t)length + 1);
    assert_non_null(text);
    va_start(args, format);
    vsnprintf(text, (size_t)length + 1, format, args);
    va_end(args);
    return text;
}

/* ---- runs ---- */

pm_job job_of(pm_job_kind kind, int ambient_bounces)
{
    pm_job job = {.kind = kind,
                  .main_name = "test.rad",
                  .forward = pm_forward_defaults(),
                  .threads = 1,
                  .view = pm_view_default(),
                  .passes = 1};
    job.wanted.estimator = PM_PROGRESSIVE;
    job.wanted.ambient_bounces = ambient_bounces;
    return job;
}

void want_map(pm_job *job, pm_map_kind kind, uint64_t count, uint32_t gather_count)
{
    job->wanted.estimator = PM_NEAREST;
    job->wanted.maps[kind] =
        (pm_map_wanted){.wanted = true, .count = count, .gather_count = gather_count};
}

const struct mode modes[MODES] = {
    {"progressive -ab -1", -1, true, false, false},
    {"progressive -ab 1", 1, true, false, false},
    {"progressive -ab 0", 0, true, false, false},
    {"caustic map -ab 0", 0, false, false, true},
    {"global map -ab 1", 1, false, true, false},
    {"both maps -ab 1", 1, false, true, true},
    {"global map -ab -1", -1, false, true, false},
    {"both maps -ab -1", -1, false, true, true},
};

pm_job job_of_mode(const struct mode *mode, uint64_t photons, uint32_t gather_count)
{
    pm_job job = job_of(PM_JOB_TRACE, mode->ambient_bounces);
    if (mode->global)
        want_map(&job, PM_MAP_GLOBAL, photons, gather_count);
    if (mode->caustic)
        want_map(&job, PM_MAP_CAUSTIC, photons, gather_count);
    return job;
}

void look_at(pm_job *job, const pm_sensor *sensors, size_t count, pm_quantity quantity)
{
    job->sensors = sensors;
    job->sensor_count = count;
    job->quantity = quantity;
}

void run_job(const pm_job *job, const char *text, const pm_job_hooks *hooks, pm_answer *answer)
{
    pm_error err = PM_ERROR_INIT;
    pm_bundle *bundle = pm_bundle_new();
    assert_non_null(bundle);
    pm_status st = add_texts(bundle, job->main_name, text, &err);
    if (!st)
        st = pm_job_run(job, bundle, hooks, answer, &err);
    pm_bundle_free(bundle);
    if (st)
        fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
    assert_int_equal(answer->nonfinite, 0);
}

static struct stored *find(const struct store *store, const pm_digest *family, uint64_t index)
{
    for (size_t i = 0; i < store->count; i++)
        if (store->list[i].index == index && pm_digest_equal(&store->list[i].family, family))
            return &store->list[i];
    return NULL;
}

static bool store_fetch(void *context, const pm_digest *family, uint64_t index,
                        const void **data, size_t *size)
{
    struct store *store = context;
    const struct stored *found = find(store, family, index);
    if (!found)
        return false;
    store->fetched++;
    *data = found->bytes.data;
    *size = found->bytes.size;
    return true;
}

static void store_keep(void *context, const pm_digest *family, pm_map_kind kind, uint64_t index,
                       const pm_bytes *bytes)
{
    struct store *store = context;
    (void)kind;
    store->kept++;
    assert_null(find(store, family, index));
    store->list = realloc(store->list, (store->count + 1) * sizeof *store->list);
    assert_non_null(store->list);
    struct stored *added = &store->list[store->count++];
    *added = (struct stored){*family, index, {0}};
    added->bytes.data = malloc(bytes->size);
    assert_non_null(added->bytes.data);
    memcpy(added->bytes.data, bytes->data, bytes->size);
    added->bytes.size = bytes->size;
}

pm_job_hooks store_hooks(struct store *store)
{
    return (pm_job_hooks){.context = store, .fetch = store_fetch, .keep = store_keep};
}

void store_clear(struct store *store)
{
    for (size_t i = 0; i < store->count; i++)
        free(store->list[i].bytes.data);
    free(store->list);
    *store = (struct store){0};
}

void run_seeds(pm_job *job, const char *text, unsigned count, struct stat *stats)
{
    for (unsigned seed = 1; seed <= count; seed++) {
        pm_answer answer;
        job->forward.seed = seed;
        run_job(job, text, NULL, &answer);
        for (size_t i = 0; i < 3 * job->sensor_count; i++)
            stat_add(&stats[i], (double)answer.values[i]);
        pm_answer_clear(&answer);
    }
}

double sensor_mean(const pm_answer *answer, size_t sensors, int channel)
{
    double sum = 0, count = 0;
    for (size_t i = 0; i < 3 * sensors; i++)
        if (channel == GREY || (int)(i % 3) == channel) {
            sum += (double)answer->values[i];
            count++;
        }
    return sum / count;
}

struct stat run_mean(pm_job *job, const char *text, unsigned count, int channel)
{
    struct stat stat = {0};
    for (unsigned seed = 1; seed <= count; seed++) {
        pm_answer answer;
        job->forward.seed = seed;
        run_job(job, text, NULL, &answer);
        stat_add(&stat, sensor_mean(&answer, job->sensor_count, channel));
        pm_answer_clear(&answer);
    }
    return stat;
}

/* ---- photons ---- */

pm_rgb flux_of(const pm_photon_map *map, size_t i, pm_vec3 *position)
{
    const pm_map_header *h = pm_photon_map_header(map);
    pm_photon photon;
    pm_photon_map_photon(map, i, &photon);
    if (position)
        *position = pm_vec3_madd(h->world_center, h->world_scale, pm_photon_position(&photon));
    double unit = h->flux_scale * h->world_scale * h->world_scale / (double)h->paths;
    return pm_rgb_scale(pm_photon_flux(&photon), unit);
}

pm_rgb flux_within(const pm_photon_map *map, pm_vec3 center, double radius)
{
    pm_rgb sum = {0, 0, 0};
    for (size_t i = 0; i < pm_photon_map_count(map); i++) {
        pm_vec3 position;
        pm_rgb flux = flux_of(map, i, &position);
        if (pm_vec3_distance(position, center) <= radius)
            sum = pm_rgb_add(sum, flux);
    }
    return sum;
}

void run_flux(pm_job *job, const char *text, pm_map_kind kind, pm_vec3 center, double radius,
              struct stat flux[3])
{
    memset(flux, 0, 3 * sizeof *flux);
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        pm_answer answer;
        job->forward.seed = seed;
        run_job(job, text, NULL, &answer);
        assert_non_null(answer.map[kind]);
        pm_rgb sum = flux_within(answer.map[kind], center, radius);
        stat_add(&flux[0], sum.r);
        stat_add(&flux[1], sum.g);
        stat_add(&flux[2], sum.b);
        pm_answer_clear(&answer);
    }
}

/* ---- the reference ---- */

struct ref_scene *reference_of(const char *text)
{
    char error[REF_ERROR_SIZE] = "";
    struct ref_scene *scene = ref_load_string(text, error);
    if (!scene)
        fail_msg("reference: %s", error);
    return scene;
}

struct ref_result reference_irradiance(const char *text, const pm_sensor *sensor, double radius,
                                       uint64_t samples)
{
    struct ref_scene *scene = reference_of(text);
    struct ref_options options = REF_OPTIONS_DEFAULT;
    struct ref_result result;
    const double point[3] = {sensor->point.x, sensor->point.y, sensor->point.z};
    const double normal[3] = {sensor->normal.x, sensor->normal.y, sensor->normal.z};
    options.samples = samples;
    ref_irradiance_disc(scene, point, normal, radius, &options, &result);
    ref_free(scene);
    assert_int_equal(result.nonfinite, 0);
    assert_int_equal(result.truncated, 0);
    return result;
}
