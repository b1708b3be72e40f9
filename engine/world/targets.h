#ifndef PM_WORLD_TARGETS_H
#define PM_WORLD_TARGETS_H

#include "base/error.h"
#include "base/vec3.h"
#include "world/world.h"

/* Balls about the surfaces that reflect or refract specularly or glossily: where light must go
 * to cast a caustic. They only steer: what lies outside all of them is found by unaimed light.
 *
 * In: a world. Next: light_aim.h sends light there, forward/aim.h scatters it there. */

enum { PM_TARGETS_MAX = 32 };

typedef struct pm_targets {
    unsigned count;
    double x[PM_TARGETS_MAX], y[PM_TARGETS_MAX], z[PM_TARGETS_MAX]; /* centres */
    double radius[PM_TARGETS_MAX];
    double weight[PM_TARGETS_MAX]; /* about the share of light that is specularly scattered */
} pm_targets;

/* Surfaces are divided into few groups wherever that makes their balls smaller. Depends on the
 * scene alone. PM_E_MEMORY. */
PM_MUST_USE pm_status pm_targets_find(const pm_world *world, pm_targets *out, pm_error *err);

/* The same about surfaces given by number, whatever they are made of; weights are 1. */
PM_MUST_USE pm_status pm_targets_about(const pm_world *world, const uint32_t *surfaces,
                                       size_t count, pm_targets *out, pm_error *err);

/* Adds a ball, unless there are PM_TARGETS_MAX. */
void pm_targets_add(pm_targets *targets, pm_vec3 center, double radius, double weight);

/* Where light leaves for the targets: by the cosine about `normal`, or within a cone. */
typedef struct pm_target_lobe {
    pm_vec3 normal;
    bool is_cone; /* about `normal`, which is then the axis */
    double versine;
} pm_target_lobe;

/* The targets as seen from a point. Those that hold the point, or more than the whole cone, are
 * not aimed at. */
typedef struct pm_target_view {
    const pm_targets *targets;
    double x[PM_TARGETS_MAX], y[PM_TARGETS_MAX], z[PM_TARGETS_MAX]; /* unit, to the centres */
    double versine[PM_TARGETS_MAX];
    double density[PM_TARGETS_MAX]; /* [1/sr] times `total`; 0: not aimed at */
    double chance[PM_TARGETS_MAX];  /* times `total` */
    double total;                   /* of the chances */
    double around;                  /* likewise, of the targets that are not aimed at */
    double share; /* of the light that leaves by the lobe for those aimed at, at most 1 */
} pm_target_view;

void pm_targets_look(const pm_targets *targets, pm_vec3 point, const pm_target_lobe *lobe,
                     pm_target_view *out);

/* A direction into the cone that a target fills. Needs total > 0; moves u. The density is that
 * of pm_targets_pdf. */
pm_vec3 pm_targets_sample(const pm_target_view *view, double u, double v, double *pdf);

double pm_targets_pdf(const pm_target_view *view, pm_vec3 direction);

#endif
