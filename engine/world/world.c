#include "world/world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/maths.h"
#include "base/warp.h"
#include "world/bodies.h"
#include "world/brdf.h"
#include "world/identity.h"
#include "world/light.h"
#include "world/material.h"
#include "world/octree.h"
#include "world/rays.h"
#include "world/twins.h"
#include "world/world_internal.h"

static pm_status no_memory(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "no memory for the scene's surfaces");
}

static const pm_digest *copy_digests(pm_world *world, const pm_digest *digests, size_t count)
{
    pm_digest *copy = pm_arena_array(&world->arena, count, sizeof *copy);
    if (copy && count)
        memcpy(copy, digests, count * sizeof *copy);
    return copy;
}

/* Both lists are in digest order already. */
static pm_status keep_digests(pm_world *world, const struct pm_identity *identity,
                              pm_error *err)
{
    world->shape_digests =
        copy_digests(world, identity->main.digests, identity->main.surface_count);
    world->distant_digests =
        copy_digests(world, identity->source_digests, identity->source_count);
    return world->shape_digests && world->distant_digests ? PM_OK : no_memory(err);
}

static struct pm_distant make_distant(const pm_primitive *p, uint32_t material)
{
    double half_angle = p->reals[3] / 360 * PM_PI;
    pm_vec3 direction = {p->reals[0], p->reals[1], p->reals[2]};
    return (struct pm_distant){.direction = pm_vec3_normalize(direction),
                               .half_angle = half_angle,
                               .versine = pm_versine(half_angle),
                               .material = material};
}

static pm_status make_distants(pm_world *world, const pm_scene *scene,
                               const struct pm_identity *identity, pm_error *err)
{
    world->distants =
        pm_arena_array(&world->arena, identity->source_count, sizeof *world->distants);
    if (!world->distants)
        return no_memory(err);
    for (size_t i = 0; i < identity->source_count; i++) {
        const pm_primitive *p = &scene->primitives[identity->sources[i]];
        world->distants[i] = make_distant(p, identity->materials.of_primitive[p->modifier]);
        world->distants[i].primitive = identity->sources[i];
    }
    world->distant_count = identity->source_count;
    return PM_OK;
}

static pm_status compile(pm_world *world, const pm_scene *scene,
                         const struct pm_identity *identity, pm_error *err)
{
    const struct pm_content *main = &identity->main;
    if (main->surface_count + main->instance_count + identity->source_count == 0)
        return pm_error_set(err, PM_E_RANGE,
                            "the scene has no surface and no source; there is "
                            "nothing to see");
    pm_status status = pm_bodies_place(world, scene, identity, err);
    if (!status)
        status = keep_digests(world, identity, err);
    if (!status)
        status = pm_materials_compile(world, scene, &identity->materials, err);
    if (!status)
        status = pm_bodies_fill(world, scene, identity, err);
    if (!status)
        status = pm_brdf_tables_build(world, err);
    if (!status)
        status = make_distants(world, scene, identity, err);
    if (!status)
        status = pm_octree_build(world, err);
    if (!status)
        status = pm_twins_find(world, err);
    if (!status)
        status = pm_rays_build(world, err);
    if (!status)
        status = pm_lights_build(world, err);
    return status;
}

pm_status pm_world_compile(const pm_scene *scene, pm_world **out, pm_error *err)
{
    pm_world *world = calloc(1, sizeof *world);
    if (!world)
        return no_memory(err);
    world->assets = pm_assets_share(scene->assets);
    struct pm_identity identity = {0};
    pm_status status = pm_identity_make(scene, &identity, err);
    if (!status)
        status = compile(world, scene, &identity, err);
    pm_identity_clear(&identity);
    if (status)
        pm_world_free(world);
    else
        *out = world;
    return status;
}

void pm_world_free(pm_world *world)
{
    if (!world)
        return;
    pm_rays_free(world->rays);
    pm_assets_free(world->assets);
    pm_arena_clear(&world->arena);
    free(world);
}

void pm_world_hide_back_faces(pm_world *world)
{
    static const char salt[] = "no back faces";
    uint8_t bytes[sizeof salt + sizeof world->hash.bytes];
    memcpy(bytes, salt, sizeof salt);
    memcpy(bytes + sizeof salt, world->hash.bytes, sizeof world->hash.bytes);
    world->hash = pm_digest_of(bytes, sizeof bytes);
    world->hides_back_faces = true;
    world->passes_straight = true;
}

pm_digest pm_world_hash(const pm_world *world)
{
    return world->hash;
}

const pm_digest *pm_world_surface_digest(const pm_world *world, uint32_t surface)
{
    if (surface < world->shape_count)
        return &world->shape_digests[surface];
    struct pm_place place;
    pm_place_find(world->main, surface, &place);
    return &world->main->instance_digests[place.chain[0] - world->main->instances];
}

void pm_world_info_get(const pm_world *world, pm_world_info *out)
{
    const struct pm_body *main = world->main;
    /* one factor after the other: a square might overflow and make 0 * infinity of black */
    pm_rgb power = pm_rgb_scale(pm_light_total_power(world), world->scale);
    *out = (pm_world_info){.center = world->center,
                           .scale = world->scale,
                           .low = world->low,
                           .high = world->high,
                           .surfaces = main->count,
                           .lights = pm_lights_count(world),
                           .specular_surfaces = main->tally.specular,
                           .diffuse_surfaces = main->tally.diffuse,
                           .mist_surfaces = main->tally.mist,
                           .power = pm_rgb_scale(power, world->scale),
                           .octree_nodes = world->octree_nodes};
}

pm_vec3 pm_world_from_scene(const pm_world *world, pm_vec3 scene_point)
{
    return pm_vec3_scale(pm_vec3_sub(scene_point, world->center), 1 / world->scale);
}

pm_vec3 pm_world_to_scene(const pm_world *world, pm_vec3 world_point)
{
    return pm_vec3_madd(world->center, world->scale, world_point);
}
