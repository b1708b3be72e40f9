#ifndef PM_WORLD_SURFACE_H
#define PM_WORLD_SURFACE_H

#include "base/rgb.h"
#include "world/aniso.h"
#include "world/brdf.h"
#include "world/bsdf_surface.h"
#include "world/media.h"
#include "world/world.h"

/* How a material scatters light at a hit: a list of lobes, each with its own colour, normal and
 * parameters. Mixtures put the scaled lobes of their components one after the other.
 *
 * `wo` and `wi` point away from the surface: wo to where the walk comes from, wi to where it
 * goes on. Forward and backward walks use the same weights, but that refraction scales radiance
 * (not flux) by the square of the indices' ratio, as in Radiance's dielectric.c: a backward
 * walk multiplies by pm_scatter.radiance_scale. A perturbed normal makes a lobe's weights other
 * than their exact adjoint (Veach 1997, 5.3); as in Radiance's photon map, both walks use the
 * weights of the backward one, which never exceed the albedo. */

/* What a scattering is to a walk. */
typedef enum pm_event {
    PM_EVENT_NONE,     /* absorbed */
    PM_EVENT_DIFFUSE,  /* by a lobe that stores photons and is estimated from them */
    PM_EVENT_GLOSSY,   /* by a lobe of finite density that walks follow: an S event */
    PM_EVENT_SPECULAR, /* delta reflection or refraction: an S event */
    PM_EVENT_STRAIGHT, /* straight passage: no event at all */
} pm_event;

typedef enum pm_lobe_kind {
    PM_LOBE_DIFFUSE,     /* Lambertian */
    PM_LOBE_WARD,        /* ward.h: rough reflection */
    PM_LOBE_ROUGH,       /* ward.h: rough transmission about a direction */
    PM_LOBE_GRAIN_WARD,  /* aniso.h: rough reflection, */
    PM_LOBE_GRAIN_ROUGH, /* rough transmission, */
    PM_LOBE_GRAIN_PHONG, /* Ashikhmin and Shirley's reflection */
    PM_LOBE_FUNCTION,    /* brdf.h: what the scene defines */
    PM_LOBE_TABLE,       /* bsdf_surface.h: what a file holds */
    PM_LOBE_MIRROR,      /* delta reflection about the lobe's normal */
    PM_LOBE_DIRECTION,   /* into `wi` alone: refraction, redirection, passage */
    PM_LOBE_KINDS,
} pm_lobe_kind;

/* Sides of the surface that a lobe scatters to; bits. */
enum { PM_SIDE_NEAR = 1 /* wo's */, PM_SIDE_FAR = 2 };

/* What a Lambertian lobe lies under: a share of the light does not reach it. */
typedef enum pm_coat {
    PM_COAT_NONE,
    PM_COAT_SMOOTH,  /* fresnel.h's estimate of a smooth one */
    PM_COAT_SCHLICK, /* (1 - cos)^5, of ashik2 */
} pm_coat;

/* f(wi, wo) |cos wi| = albedo * shape(wi), where the shape's integral over wi is at most 1. */
typedef struct pm_lobe {
    pm_lobe_kind kind : 8;
    pm_event event : 8;
    unsigned sides : 2;
    pm_coat coat : 8; /* of a Lambertian lobe: it carries 1 - F(cos wi) */
    bool tilted : 1;  /* `normal` is not the surface's */
    pm_rgb albedo;
    pm_vec3 normal; /* unit, on wo's side, perturbed by textures; faces wo */
    union {
        struct {
            double alpha;     /* roughness, > 0 */
            pm_vec3 straight; /* unit; transmission: the direction that it is rough about */
        } rough;
        struct {
            pm_vec3 u;
            double along, across;
            pm_vec3 straight; /* of transmission */
        } grain;              /* aniso.h */
        struct {
            unsigned index; /* of pm_surface.functions */
            bool front;     /* where wo lies */
            pm_rgb gain;    /* shape = gain * f |cos wi| */
        } function;
        struct {
            unsigned index; /* of pm_surface.bsdfs */
            pm_rgb gain;    /* albedo * shape = gain * f |cos wi| */
        } table;
        struct {
            pm_vec3 wi; /* unit */
            double radiance_scale;
        } direction;
    } u;
} pm_lobe;

/* A lobe into one direction. */
static inline bool pm_lobe_is_delta(const pm_lobe *lobe)
{
    return lobe->event == PM_EVENT_SPECULAR || lobe->event == PM_EVENT_STRAIGHT;
}

enum { PM_LOBES_MAX = 16, PM_FUNCTIONS_MAX = 4, PM_BSDFS_MAX = 2 };

/* The material evaluated at one hit for one wo. */
typedef struct pm_surface {
    pm_vec3 normal; /* unit, geometric, on wo's side */
    pm_vec3 wo;
    unsigned count;
    unsigned events; /* bit (1 << event) set if a lobe has that event */
    unsigned function_count, bsdf_count;
    double skip; /* [world] light that is transmitted goes on so far behind the surface, beyond
                    the geometry that a BSDF with a thickness stands for; nearly always 0 */
    pm_lobe lobes[PM_LOBES_MAX];
    pm_brdf functions[PM_FUNCTIONS_MAX];
    pm_bsdf_hit bsdfs[PM_BSDFS_MAX];
} pm_surface;

/* Where light that the surface scatters towards wi starts: at the hit `point` itself, but for
 * `skip`. *from, the surface that the ray comes from, changes alike. */
static inline pm_vec3 pm_surface_exit(const pm_surface *surface, pm_vec3 point, pm_vec3 wi,
                                      uint32_t *from)
{
    if (!(surface->skip > 0) || pm_vec3_dot(surface->normal, wi) > 0)
        return point;
    *from = PM_NO_PRIMITIVE;
    return pm_vec3_madd(point, -surface->skip, surface->normal);
}

typedef struct pm_scatter {
    pm_event event;
    bool transmitted; /* the walk goes through the surface: cross media */
    pm_vec3 wi;       /* unit */
    pm_rgb weight;    /* f |cos wi| / pdf: what the throughput is multiplied by */
    double pdf;       /* [1/sr] of wi among the lobes of finite density drawn from, for multiple
                         importance sampling; 0 for the others, and by pm_surface_sample */
    double radiance_scale; /* (index on wo's side / on wi's side)^2; of prisms the ratio of the
                              cosines; 1 for the others */
} pm_scatter;

/* The material of `hit` seen from wo by a walk that `media` hold, for bounces.
 * An illum is its alternate material here. A surface that an antimatter in `media` hides is
 * straight passage; the boundary of an antimatter within an object that it cuts is that
 * antimatter's first material (Radiance's m_clip.c). Emission is apart: light.h. */
void pm_surface_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo, const pm_media *media,
                   pm_surface *out);

/* The same for photons. It is another thing only where back faces are hidden (world.h). */
void pm_surface_lit_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                       const pm_media *media, pm_surface *out);

/* The same for walks from the eye that met nothing but specular and straight events so far: a
 * mirror with an alternate material shows that one (Radiance's m_mirror.c). */
void pm_surface_seen_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                        const pm_media *media, pm_surface *out);

/* A white Lambertian receiver of that unit normal, whose radiance is its irradiance / pi. */
void pm_surface_receiver(pm_vec3 normal, pm_surface *out);

/* Whether a lobe of that event is there. Diffuse ones store photons. */
static inline bool pm_surface_has(const pm_surface *surface, pm_event event)
{
    return surface->events >> event & 1;
}

/* Sum of f(wi, wo) |cos wi| over the lobes of one event, diffuse or glossy. Others are deltas
 * and give nothing. */
pm_rgb pm_surface_value(const pm_surface *surface, pm_event event, pm_vec3 wi);

/* The share of light that all lobes together scatter or pass. False if it is not known in
 * closed form (all lobes but plain Lambertian and delta ones); then it is the mean weight of
 * pm_surface_sample. */
bool pm_surface_albedo(const pm_surface *surface, pm_rgb *out);

/* Sum of the albedos of the lobes of one event on one side; a bound where
 * pm_surface_albedo knows none. */
pm_rgb pm_surface_part(const pm_surface *surface, pm_event event, unsigned side);

/* ---- sampling ---- */

/* Draws one lobe in proportion to its mean albedo weighted by `throughput`, then a direction
 * from it. u[0] picks the lobe, u[1] and u[2] the direction. PM_EVENT_NONE if all are black, or
 * if the direction falls on the wrong side. Never draws absorption: E[weight] is the albedo,
 * roulette is the caller's. */
void pm_surface_sample(const pm_surface *surface, pm_rgb throughput, const double u[3],
                       pm_scatter *out);

/* Draws from the lobes that are not diffuse, likewise. For the backward walk, which gathers
 * the diffuse part from the photon maps. */
void pm_surface_sample_specular(const pm_surface *surface, pm_rgb throughput, const double u[3],
                                pm_scatter *out);

/* Draws from the diffuse lobes alone; the weight is that of all of them together. u[0] picks
 * the lobe and, rescaled so that its stratification goes on, the direction with u[1]. */
void pm_surface_sample_diffuse(const pm_surface *surface, const double u[2], pm_scatter *out);

/* Density of pm_surface_sample_specular for wi among the glossy lobes. */
double pm_surface_glossy_pdf(const pm_surface *surface, pm_rgb throughput, pm_vec3 wi);

/* ---- photons ---- */

/* Radiance towards wo that the photons on one side of the surface give:
 *   sum over the photons of flux * pm_surface_photon_weight(wi) / area.
 * pm_surface_photons says whether any lobe takes them there; *uniform is true if that weight
 * is *weight whatever wi, as it is of plain Lambertian lobes. */
bool pm_surface_photons(const pm_surface *surface, unsigned side, bool *uniform,
                        pm_rgb *weight);

/* f(wi, wo) of the diffuse lobes together, times |cos wi| about a lobe's normal over |cos wi|
 * about the surface's, at most PM_TILT_MAX: photons bring flux through the surface itself, and
 * grazing ones would else count without bound. */
#define PM_TILT_MAX 4
pm_rgb pm_surface_photon_weight(const pm_surface *surface, pm_vec3 wi);

/* Whether an antimatter in `media` hides the surface. */
bool pm_surface_is_hidden(const pm_world *world, const pm_hit *hit, const pm_media *media);

/* Whether the material of a hit has a diffuse part anywhere, so that photons may lie there. */
bool pm_surface_may_store(const pm_world *world, const pm_hit *hit);

/* Whether its material lets no light straight through, and bounds no mist. */
bool pm_surface_blocks(const pm_world *world, const pm_hit *hit);

#endif
