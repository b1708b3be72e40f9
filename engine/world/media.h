#ifndef PM_WORLD_MEDIA_H
#define PM_WORLD_MEDIA_H

#include "base/rgb.h"
#include "world/world.h"

/* Participating media: mists, and the absorbing insides of dielectrics and both sides of
 * interfaces; and the volumes that antimatter cuts out.
 *
 * A path carries the list of volumes that hold its current point. A dielectric displaces the
 * mists outside it: inside it only what was entered after it counts; leaving it the mists are
 * back. Overlapping mists add their extinctions. Within an antimatter the materials that it
 * lists are invisible, their media too; the list goes on to say in which objects the point
 * would lie, for the antimatter's far boundary. Of more than PM_MEDIA_MAX nested volumes the
 * innermost do not count.
 *
 * A mist's list of light names is accepted; all lights scatter in every mist. In Radiance the
 * list says for which lights a ray without a volume photon map looks (slights, in m_mist.c and
 * srcscatter of source.c); with one, all are in it there too ("unconditional inscattering"). */

enum { PM_MEDIA_MAX = 16 };

typedef struct pm_media {
    uint16_t count;
    uint32_t material[PM_MEDIA_MAX]; /* in order of entry */
} pm_media;

/* What the innermost media are together [1 / world length]. Of mists that overlap each scatters
 * by its own phase function, a share of the light; those of equal g are one. */
typedef struct pm_medium {
    pm_rgb extinction; /* absorption + scattering */
    pm_rgb albedo;     /* scattering / extinction, of the sum */
    unsigned phases;   /* 0 if nothing scatters */
    struct pm_phase_part {
        double g;     /* Henyey-Greenstein */
        pm_rgb share; /* of the scattered light of each channel */
    } phase[PM_MEDIA_MAX];
} pm_medium;

/* The media at a point in free space, by rays to the outside. Cheap (count = 0) in a world
 * without media and antimatter. */
void pm_media_at(const pm_world *world, pm_vec3 point, pm_media *out);

/* A path comes along `direction` to the surface of `hit`. If it is the back of a mist,
 * interface or dielectric that is not listed, the path was in it: the volume has no closed
 * boundary, such as water under a single polygon, and pm_media_at found no way out through it.
 * Radiance's dielectric.c too takes what a ray meets from behind as what it came through, and
 * the medium in front of an interface likewise. */
void pm_media_meet(pm_media *media, const pm_world *world, const pm_hit *hit,
                   pm_vec3 direction);

/* A path goes through the surface of `hit` along `direction` (refraction and straight passage,
 * not reflection). Surfaces that bound no medium change nothing. */
void pm_media_cross(pm_media *media, const pm_world *world, const pm_hit *hit,
                    pm_vec3 direction);

/* False if nothing attenuates there. */
bool pm_media_medium(const pm_media *media, const pm_world *world, pm_medium *out);

/* exp(-extinction * length). Never NaN for any finite extinction and length >= 0. */
pm_rgb pm_medium_transmittance(const pm_medium *medium, double length);

/* Henyey-Greenstein 1941: density [1/sr] at cos of the scattering angle (1 = straight on), and
 * a direction drawn from it. Test: phase_function_is_normalised. */
double pm_phase(double g, double cosine);
pm_vec3 pm_phase_sample(double g, pm_vec3 direction, double u, double v);

/* The phase function of a medium that scatters [1/sr], a channel each: the parts' sum, a
 * channel that nothing scatters 0. And a direction drawn from it for light of that flux; what
 * the flux is multiplied by. The flux of the channels together stays what it was, so weights
 * are bounded; with one part they are 1. Test: overlapping_mists_scatter_each_by_its_own. */
pm_rgb pm_medium_phase(const pm_medium *medium, double cosine);
pm_vec3 pm_medium_scatter(const pm_medium *medium, pm_rgb flux, pm_vec3 direction,
                          const double u[3], pm_rgb *weight);

#endif
