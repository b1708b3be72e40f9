#ifndef PM_BACKWARD_INTERNAL_H
#define PM_BACKWARD_INTERNAL_H

#include <math.h>

#include "backward/backward.h"
#include "base/rng.h"
#include "world/light.h"
#include "world/media.h"
#include "world/near.h"
#include "world/surface.h"

/* What the files of this folder share. Nothing outside it includes this header.
 *
 * Reading order: camera.c (a pixel's ray) -> walk.c (from vertex to vertex) -> at each vertex
 * direct.c (next event), lookup.c, queue.c (photon maps), gather.c (final gather), inscatter.c
 * (media on the way) -> sensor.c (walks for a sensor) -> pass.c (all pixels once) ->
 * accumulate.c, interval.c (sums, errors). */

/* ---- samples ---- */

/* The numbers of one sample of one pixel or sensor. The first draws of each use come from its
 * Owen-scrambled Sobol sequence, all others from Philox. */
struct pm_sampler {
    uint32_t index, scramble; /* of the Sobol sequence */
    unsigned used;            /* bit (1 << use) set once its Sobol numbers are handed out */
    uint32_t lookups;         /* asked so far; each has numbers of its own */
    pm_rng rng;
    struct pm_queue *queue; /* for look-ups that may wait; NULL: none may */
    uint32_t slot;          /* of the sample's value there */
};

enum pm_sample_use {
    PM_SAMPLE_LENS,   /* two: place in the pixel */
    PM_SAMPLE_LIGHT,  /* three: which light, where on it */
    PM_SAMPLE_GATHER, /* two: direction of the gather ray */
    PM_SAMPLE_LOBE,   /* three: which lobe, and (Philox) its direction */
};

void pm_sampler_init(struct pm_sampler *sampler, uint64_t seed, uint32_t pass, uint32_t item);
void pm_sampler_draw(struct pm_sampler *sampler, enum pm_sample_use use, double u[3]);

/* ---- camera.c ---- */

struct pm_camera {
    pm_view view;
    pm_vec3 origin;                 /* world coordinates */
    pm_vec3 forward, right, up;     /* unit */
    double half_width, half_height; /* pm_view_extent; of parallel views in world coordinates */
    double fore, aft;               /* world coordinates; aft INFINITY: none */
    uint32_t width, height;
    pm_media media; /* that hold the origin */
};

void pm_camera_init(struct pm_camera *camera, const pm_world *world, const pm_view *view,
                    uint32_t width, uint32_t height);
/* False for a place outside of what the view shows, which is black. The ray ends at the aft
 * clipping plane. Test: test_camera.c. */
bool pm_camera_ray(const struct pm_camera *camera, uint32_t pixel, const double u[2],
                   pm_ray *out);
/* That hold the origin of one of its rays. */
pm_media pm_camera_media(const struct pm_camera *camera, const pm_world *world, pm_vec3 origin);

/* ---- one pass ---- */

/* One question to a photon map. */
struct pm_lookup {
    const pm_photon_map *map;
    bool precomputed; /* the closest; else */
    double radius;    /* > 0, or the nearest: */
    uint32_t gather_count;
    pm_gather_range range; /* most > 0: its number of photons instead */
    pm_photon_filter filter;
};

/* What stands at a diffuse vertex decides which photons count there: the table in plan/plan.h.
 */
enum pm_vertex {
    PM_VERTEX_EYE,    /* the eye's first diffuse surface */
    PM_VERTEX_GATHER, /* the end of a gather ray */
    PM_VERTEX_SENSOR, /* the end of a ray from a sensor in free space */
    PM_VERTEX_KINDS,
};

struct pm_vertex_rule {
    struct pm_lookup lookups[2];
    int lookup_count;
    bool gather;           /* sends a gather ray */
    bool through_specular; /* walks that end at such vertices go through specular surfaces */
    bool after_specular;   /* such vertices count only behind a specular surface */
};

/* Constant during a pass and shared between threads. */
struct pm_pass {
    const pm_world *world;
    struct pm_vertex_rule rules[PM_VERTEX_KINDS];
    struct pm_lookup volume; /* map NULL: none */
    bool shared;             /* other passes look at the same photons */
};

/* Chooses the rules of a pass. PM_E_RANGE for a map without radius or count. */
PM_MUST_USE pm_status pm_pass_init(struct pm_pass *pass, const pm_world *world,
                                   const pm_backward_maps *maps, pm_error *err);

/* One sample's value. */
struct pm_value {
    pm_rgb radiance; /* [W/(m^2 sr)]; of irradiance sensors the irradiance */
    pm_rgb variance; /* of it, from the scatter of the photons that all passes share */
};

/* ---- walk.c ---- */

/* How the emission of the next surface counts. */
enum pm_emission_rule {
    PM_EMISSION_SEEN,     /* in full, the eye looks at it */
    PM_EMISSION_FULL,     /* in full, behind a delta lobe */
    PM_EMISSION_WEIGHTED, /* behind a glossy lobe: multiple importance sampling with next event
                           */
    PM_EMISSION_NONE,     /* next event at the last vertex has it */
};

/* A walk on its way. */
struct pm_walk {
    pm_ray ray;
    pm_media media; /* that hold the ray's origin */
    pm_rgb throughput;
    enum pm_vertex vertex; /* what its diffuse vertices are */
    enum pm_emission_rule emission;
    bool seen;       /* from the eye through specular and straight events only */
    bool specular;   /* met a specular or glossy event */
    pm_vec3 bend;    /* where the last event was */
    double bend_pdf; /* [1/sr] of a glossy one */
    double length;   /* since the last event */
    unsigned bounces;
};

/* Walks to the end; adds throughput times what is met. */
void pm_walk_run(const struct pm_pass *pass, struct pm_walk *walk, struct pm_sampler *sampler,
                 struct pm_value *value);

/* A diffuse or glossy vertex of a walk. */
struct pm_spot {
    const pm_surface *surface;
    const pm_hit *hit;     /* NULL: a sensor in free space, which bounds no medium */
    const pm_media *media; /* on wo's side */
    pm_vec3 point;
    uint32_t from; /* surface or PM_NO_PRIMITIVE */
};

/* ---- what light a vertex has ---- */

/* direct.c: radiance towards wo by one next event; the glossy part weighted against sampling
 * its lobe with `throughput`. `lobes` are those that next event stands for. */
enum { PM_DIRECT_DIFFUSE = 1, PM_DIRECT_GLOSSY = 2 };
pm_rgb pm_direct_light(const struct pm_pass *pass, const struct pm_spot *spot,
                       pm_rgb throughput, unsigned lobes, struct pm_sampler *sampler);

/* Multiple importance sampling: weight of a sample drawn with density `pdf` that another
 * strategy draws with density `other`; power heuristic with exponent 2, Veach 1997, eq. 9.13.
 */
static inline double pm_power_weight(double pdf, double other)
{
    double ratio = other / pdf;
    return 1 / (1 + ratio * ratio);
}

/* lookup.c: radiance towards wo of the vertex's photons, times throughput, added to `value`. */
void pm_lookup_surface(const struct pm_pass *pass, const struct pm_spot *spot,
                       pm_rgb throughput, enum pm_vertex vertex, struct pm_sampler *sampler,
                       struct pm_value *value);

/* ---- queue.c: look-ups of neighbouring samples wait for each other, as a batch is faster ----
 *
 * A value's light from them is summed by itself and in the order of asking, so that the bytes
 * depend neither on what else waits nor on when it is answered. */

enum {
    PM_QUEUE_VALUES = 256, /* samples that may share a queue */
    PM_QUEUE_MAX = 256,    /* look-ups that wait */
};

/* A look-up, and what becomes of its answer. */
struct pm_waiting {
    const struct pm_lookup *lookup;
    struct pm_spot spot; /* of one that waits point and from alone */
    pm_vec3 normal;      /* on the side asked */
    enum pm_vertex vertex;
    bool far;      /* asks for the far side of the surface */
    bool uniform;  /* photons of all directions count the same */
    pm_rgb weight; /* of the estimate */
    pm_rng rng;    /* for its boundary factor */
};

struct pm_queue {
    struct pm_value values[PM_QUEUE_VALUES]; /* so far */
    size_t count;
    struct pm_waiting waiting[PM_QUEUE_MAX];
    uint32_t slot[PM_QUEUE_MAX];
};

void pm_queue_start(struct pm_queue *queue, size_t values);
void pm_queue_add(const struct pm_pass *pass, struct pm_queue *queue,
                  const struct pm_waiting *waiting, uint32_t slot);
/* Answers all that wait. */
void pm_queue_finish(const struct pm_pass *pass, struct pm_queue *queue);

/* lookup.c: what a precomputed map's closest photon, or SIZE_MAX for none, says; near walls,
 * the closest of a few that is in sight. */
pm_estimate pm_lookup_closest(const struct pm_pass *pass, const struct pm_waiting *waiting,
                              size_t index);

/* lookup.c: adds an estimate to a value; near walls, what of it is in sight. */
void pm_lookup_add(const struct pm_pass *pass, struct pm_waiting *waiting,
                   const pm_estimate *estimate, struct pm_value *value);

/* boundary.c: an estimate from the disc of a radius divides by the disc's area, though a part
 * of it may lie beyond the surface's edges, where no photon can be. The number of places that
 * are drawn from the disc until one lies on the surface has the mean disc / surface, so that
 * the estimate times that number has no bias from edges, whatever their shape; well inside a
 * surface the first place does. After a first failure 4 successes are drawn, for less noise:
 * the rest of a geometric distribution is the same distribution again. Test:
 * corners_and_edges_are_as_bright_as_they_are. */
double pm_boundary_factor(const struct pm_pass *pass, const struct pm_spot *spot,
                          pm_vec3 normal, double radius, const pm_between *walls, pm_rng *rng);

/* The mean of 16 such draws for precomputed photon i. */
double pm_boundary_mean(const struct pm_pass *pass, const struct pm_spot *spot, pm_vec3 normal,
                        double radius, const pm_between *walls, uint64_t i);

/* sight.c: photons behind a wall that stands on the surface do not count, nor does the part of
 * the disc behind it, though the surface may go on there. pm_walls_near says whether there may
 * be any, and which; then pm_sees tells of a place, its normal on the photons' side. Most
 * places are told by those walls' planes alone, the others by a ray. Test:
 * nothing_comes_through_a_wall_without_thickness. */
bool pm_walls_near(const struct pm_pass *pass, const struct pm_spot *spot, pm_vec3 normal,
                   double radius, pm_between *walls);
bool pm_sees(const struct pm_pass *pass, const struct pm_spot *spot, const pm_between *walls,
             pm_vec3 normal, pm_vec3 place, pm_vec3 place_normal);

/* gather.c: the same by one gather ray, whose diffuse vertices are of kind `end`. */
void pm_gather(const struct pm_pass *pass, const struct pm_spot *spot, pm_rgb throughput,
               enum pm_vertex end, struct pm_sampler *sampler, struct pm_value *value);

/* The media on the far side of a spot, for light that goes through it towards `direction`. */
pm_media pm_spot_media(const struct pm_pass *pass, const struct pm_spot *spot,
                       pm_vec3 direction);

/* inscatter.c: adds what a medium scatters towards the walk on the next `length` of its ray
 * (INFINITY allowed), and attenuates its throughput. */
void pm_inscatter(const struct pm_pass *pass, struct pm_walk *walk, double length,
                  struct pm_sampler *sampler, struct pm_value *value);

/* Draws where on the next `length` the medium scatters; density [1 / world length] for all
 * channels together. False if none scatters. Test: distances_estimate_every_extinction. */
bool pm_inscatter_distance(const pm_medium *medium, double length, struct pm_sampler *sampler,
                           double *distance, double *pdf);

/* ---- sensor.c ---- */

/* A sensor in world coordinates, unit direction. */
struct pm_probe {
    pm_vec3 point, normal;
};

void pm_probe_irradiance(const struct pm_pass *pass, const struct pm_probe *probe,
                         struct pm_sampler *sampler, struct pm_value *value);
void pm_probe_radiance(const struct pm_pass *pass, const struct pm_probe *probe,
                       struct pm_sampler *sampler, struct pm_value *value);

/* ---- accumulate.c ---- */

struct pm_accumulation {
    const pm_world *world;
    uint64_t seed;
    size_t count; /* pixels or sensors */
    struct pm_camera camera;
    struct pm_probe *probes; /* NULL: a picture */
    pm_quantity quantity;
    bool lit; /* the world has lights */

    uint32_t passes, next_pass;
    uint32_t replicate_passes[PM_REPLICATES];
    double *sums;      /* [PM_REPLICATES][count][3] */
    double *deviation; /* [count][3]: sums of the samples' standard deviations from shared
                          photons */
    uint64_t nonfinite;
    struct pm_value *values; /* [count], of the pass under way */
};

/* Adds `values` as pass `pass`. */
void pm_accumulation_add(pm_accumulation *accumulation, uint32_t pass);

/* ---- interval.c ---- */

/* Mean and squared standard error from sums of replicates that have unequal numbers of passes;
 * the error is infinite with fewer than two replicates that have any.
 *   sum, passes  [PM_REPLICATES] */
struct pm_interval {
    double mean, variance;
    unsigned freedom; /* degrees of freedom of Student's t */
};
struct pm_interval pm_interval_of(const double sum[PM_REPLICATES],
                                  const uint32_t passes[PM_REPLICATES]);

/* Quantile .975 of Student's t; freedom 1 .. PM_REPLICATES - 1. */
double pm_student_quantile(unsigned freedom);

#endif
