/* Brute-force reference path tracer: the answer that the engine's photon maps are tested
 * against.
 *
 * In: Radiance scene text. Out: irradiance or radiance with standard errors. Tests only.
 *
 * It shares no code with engine/ and has no photon map, no density estimation and no
 * acceleration structure: paths run backward from the sensor, in double precision, until
 * Russian roulette ends them, so every mean is unbiased. Where it and the engine agree, two
 * independent readings of the same physics agree.
 *
 * Scene subset (semantics of the Radiance reference manual and of Radiance 5.4a's sources):
 *   materials  plastic metal trans (roughness 0 unless they have no specular part) glass
 *              dielectric mirror light glow spotlight mist
 *   shapes     polygon (planar, convex or not) sphere bubble ring cylinder tube cone cup
 *   source     disc at infinity: direction to it, full angle [deg]
 * Anything else, textures, patterns and aliases included, is an error with its line number.
 *
 * Choices where Radiance leaves one or contradicts itself:
 *   - Smooth plastic, metal and trans with specularity >= 0.017999 have the diffuse BRDF
 *     rgb/pi * rdiff(view) * (1 - F(light)) for direct *and* indirect light. Radiance drops the
 *     last factor for indirect light, which is not reciprocal.
 *   - Straight passage through `glass`, through the specular transmission of smooth `trans` and
 *     across a mist's boundary is no event: next-event rays pass, path classes do not change.
 *   - Lights are black bodies of any size; `glow`'s radius, a spotlight's focus length and a
 * mist's source list are ignored. Where distant sources overlap, the first light hides the
 * others, and a glow shows only where no light does.
 *   - A mist does not exist inside a dielectric that stands in it and resumes behind it. Mists
 * that overlap add up; a dielectric's outside always has refractive index 1.
 *   - Boundaries of two transparent volumes must not coincide. A transparent boundary may lie
 * in an opaque surface; the opaque one is hit.
 */
#ifndef PM_TESTS_SUPPORT_REFERENCE_H
#define PM_TESTS_SUPPORT_REFERENCE_H

#include <stdbool.h>
#include <stdint.h>

#define REF_ERROR_SIZE 200

/* What happened to the light last before it reached the sensor. */
enum ref_class {
    REF_DIRECT,  /* nothing: straight from a light, panes of glass and unscattered mist included
                  */
    REF_CAUSTIC, /* a specular event: reflection or refraction, L(D|S)*S+D */
    REF_INDIRECT, /* a diffuse event or scattering in a mist */
    REF_CLASSES
};

struct ref_scene;

struct ref_options {
    uint64_t samples; /* paths, >= 2 for standard errors */
    uint64_t seed;    /* path i depends on (seed, i) and the scene alone */
    bool next_event;  /* sample lights at diffuse and scattering vertices and at the sensor */
    /* Diffuse and volume events a path may have, the sensor not counted: 0 leaves direct light
     * and specular chains; -1 is unlimited. */
    int max_diffuse_bounces;
};

#define REF_OPTIONS_DEFAULT                                                                    \
    (struct ref_options)                                                                       \
    {                                                                                          \
        .samples = 1u << 16, .seed = 1, .next_event = true, .max_diffuse_bounces = -1          \
    }

/* Linear RGB, W/m^2 for irradiance and W/(m^2 sr) for radiance. Classes of one path are
 * correlated, hence the total's own standard error. */
struct ref_result {
    double mean[REF_CLASSES][3];
    double standard_error[REF_CLASSES][3]; /* of the mean: s / sqrt(samples) */
    double total[3];
    double total_standard_error[3];
    uint64_t nonfinite; /* samples that were not finite: left in the mean; a test demands 0 */
    uint64_t truncated; /* paths cut after 10^6 events: caught for ever, such as by
                         * total reflection around a sensor in a clear dielectric; demand 0 */
};

/* Parses scene text; the caller frees the scene with ref_free.
 *   error  out, may be NULL: "LINE: what is wrong" when the result is NULL, else untouched
 * Returns NULL for malformed text, an unsupported construct, or lack of memory. */
struct ref_scene *ref_load_string(const char *text, char error[REF_ERROR_SIZE]);
struct ref_scene *ref_load_file(const char *path, char error[REF_ERROR_SIZE]);
void ref_free(struct ref_scene *scene);

/* Irradiance at `point` [scene units] on a virtual surface with unit `normal`, from the
 * hemisphere around it. A point may lie in a surface (to 1e-12 of the scene's extent). Mists
 * and dielectrics around it are found by counting their boundaries along a ray. Test:
 * test_reference.c, all of it. */
void ref_irradiance(const struct ref_scene *scene, const double point[3],
                    const double normal[3], const struct ref_options *options,
                    struct ref_result *result);

/* Mean irradiance over the flat disc around `center` with `radius` >= 0; times pi radius^2 it
 * is the flux through the disc, for instance that of a caustic. Test:
 * disc_mean_is_the_view_factor. */
void ref_irradiance_disc(const struct ref_scene *scene, const double center[3],
                         const double normal[3], double radius,
                         const struct ref_options *options, struct ref_result *result);

/* Radiance that arrives at `origin` from unit `direction` (pointing away from it). Classes as
 * for a sensor: a light seen is direct, one seen in a mirror caustic, a lit diffuse wall
 * indirect; so max_diffuse_bounces >= 1 is needed to see a wall at all. */
void ref_radiance(const struct ref_scene *scene, const double origin[3],
                  const double direction[3], const struct ref_options *options,
                  struct ref_result *result);

#endif
