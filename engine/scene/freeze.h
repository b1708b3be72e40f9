#ifndef PM_SCENE_FREEZE_H
#define PM_SCENE_FREEZE_H

#include "files/records.h"
#include "scene/scene.h"

/* The main scene's primitives as the records of a frozen octree (files/records.h): aliases and
 * `!` lines are resolved, transforms written as words, files named as the bundle has them. The
 * records point into the scene, the bundle and the arena.
 * Errors: PM_E_UNSUPPORTED where a string argument names a modifier whose name has come to mean
 * another one (a record says its modifier by number, but the strings by name); PM_E_MEMORY.
 * Test: test_freeze.c. */
PM_MUST_USE pm_status pm_scene_freeze(const pm_scene *scene, const pm_bundle *bundle,
                                      pm_arena *arena, pm_record **out, pm_error *err);

#endif
