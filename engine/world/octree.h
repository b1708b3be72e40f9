#ifndef PM_WORLD_OCTREE_H
#define PM_WORLD_OCTREE_H

#include "world/world_internal.h"

/* The Merkle tree over the world's cube, divided as Radiance's oconv -n 32 divides: a cube that
 * meets more than 32 surfaces and instances is cut into eight, down to 1/2^14 of the edge (-r).
 * Large surfaces that cross each other everywhere, or coincide, would be cut without end: the
 * sets of all nodes together have at most 1024 entries for each surface, shared out on the way
 * down in proportion to what the cubes hold, so that the division of a cube depends only on
 * what lies in it and in those above.
 *
 *   leaf  SHA-256('L', digests of the surfaces that it meets, ascending,
 *         then those of the instances whose boxes it meets, ascending)
 *   node  SHA-256('N', digests of its eight children, x fastest, then y, then z)
 *   root  SHA-256("photon map scene 2", cube, top node,
 *         digests of distant sources, ascending)
 *
 * Scenes of format 1 were cut from 7 surfaces on: of a million triangles that took two seconds
 * more. Sets world->hash and world->octree_nodes. Tests: test_octree.c. */
PM_MUST_USE pm_status pm_octree_build(pm_world *world, pm_error *err);

#endif
