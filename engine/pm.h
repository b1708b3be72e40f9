#ifndef PM_H
#define PM_H

/* The engine, in reading order: each stage takes what the one before it made.
 * pipeline.h runs the whole flow for one job. */
#include "language/language.h"   /* function files -> programs and their values */
#include "generate/generate.h"   /* genbox, gensky, ... -> scene text */
#include "scene/scene.h"         /* bytes -> pm_scene */
#include "world/world.h"         /* pm_scene -> pm_world */
#include "world/media.h"         /*   what fills space */
#include "world/surface.h"       /*   how surfaces scatter */
#include "world/light.h"         /*   what shines */
#include "world/survey.h"        /*   what an expert would say of it */
#include "plan/plan.h"           /* pm_world + wanted -> pm_plan */
#include "forward/forward.h"     /* world + plan -> batches of photons */
#include "photons/photon_map.h"  /* batches -> pm_photon_map */
#include "backward/backward.h"   /* world + maps -> values */
#include "image/image.h"         /* values -> files */
#include "pipeline.h"

#endif
