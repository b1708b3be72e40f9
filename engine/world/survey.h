#ifndef PM_WORLD_SURVEY_H
#define PM_WORLD_SURVEY_H

#include "world/world.h"

/* What a lighting expert would say of a scene at first sight: what it holds, and what is
 * probably not meant. Nothing here is an error.
 *
 * In: a scene, and the world compiled from it. Out: pm_survey. */

typedef enum pm_warning_kind {
    PM_WARNING_NO_LIGHT,   /* nothing gives light */
    PM_WARNING_OPEN,       /* much of the lamps' light leaves the scene */
    PM_WARNING_LEAK,       /* a little does, through a gap */
    PM_WARNING_LIGHT_AWAY, /* a lamp lights nothing but the outside */
    PM_WARNING_COVERED,    /* a lamp whose light ends right in front of it */
    PM_WARNING_NOT_FLAT,   /* a polygon's vertices do not lie in a plane */
    PM_WARNING_NO_AREA,    /* a polygon without area is left out */
    PM_WARNING_PATTERN,    /* a pattern raises reflectance above 1, where it is cut */
    PM_WARNING_BRIGHT,     /* a reflectance that no paint has */
    PM_WARNING_UNIT,       /* lengths look like millimetres */
    PM_WARNING_KINDS,
} pm_warning_kind;

/* "open", "leak", "light away", ... */
const char *pm_warning_kind_name(pm_warning_kind kind);

typedef struct pm_warning {
    pm_warning_kind kind;
    char text[400];
    char file[256]; /* "" where it is about the whole scene */
    int line, column;
} pm_warning;

typedef struct pm_survey_light {
    char name[64], material[64];
    pm_primitive_type type; /* of its surface; PM_SOURCE */
    double power;           /* [W], mean of the channels, into the scene */
} pm_survey_light;

enum {
    PM_SURVEY_WARNINGS = 40,
    PM_SURVEY_OF_A_KIND = 5, /* warnings told; the rest are counted in the last */
    PM_SURVEY_LIGHTS = 16    /* the strongest */
};

typedef struct pm_survey {
    size_t counts[PM_PRIMITIVE_TYPES]; /* primitives of the main scene */
    size_t in_prototypes;              /* primitives of instances' octrees, once each */
    size_t media;                      /* materials that attenuate light along its way */
    size_t light_count;                /* of lights[] */
    pm_survey_light lights[PM_SURVEY_LIGHTS];
    bool has_paths;  /* there are lamps in the scene, so the next is known */
    double escaping; /* share of the lamps' paths that leave the scene, absorption left out */
    size_t warning_count;
    pm_warning warnings[PM_SURVEY_WARNINGS];
} pm_survey;

/* The same scene gives the same survey. PM_E_MEMORY. Free with free().
 * Test: test_survey.c. */
PM_MUST_USE pm_status pm_survey_make(const pm_scene *scene, const pm_world *world,
                                     pm_survey **out, pm_error *err);

#endif
