/* What the materials of a world can do: which passes they need. */
#include "world/bsdf_surface.h"
#include "world/material.h"
#include "world/surface.h"

/* ---- how much there is to show ---- */

struct parts {
    unsigned lobes, functions, bsdfs;
};

static bool fit(const struct parts *parts)
{
    return parts->lobes <= PM_LOBES_MAX && parts->functions <= PM_FUNCTIONS_MAX &&
           parts->bsdfs <= PM_BSDFS_MAX;
}

/* At most, whatever the arguments. */
static unsigned most_lobes(const struct pm_material *m)
{
    switch (m->type) {
    case PM_PLASTIC:
    case PM_METAL:
    case PM_PLASTIC2:
    case PM_METAL2:
    case PM_ASHIK2:
    case PM_GLASS:
    case PM_DIELECTRIC:
    case PM_INTERFACE:
    case PM_PRISM2:
        return 2;
    case PM_TRANS:
    case PM_TRANS2:
        return 4;
    case PM_PLASFUNC:
    case PM_METFUNC:
    case PM_PLASDATA:
    case PM_METDATA:
        return 2;
    case PM_TRANSFUNC:
    case PM_TRANSDATA:
        return 4;
    case PM_BRTDFUNC:
        return 6;
    case PM_BSDF:
    case PM_ABSDF:
        return 5;
    default:
        return 1;
    }
}

/* Stops as soon as it is too much, so that mixtures of mixtures take no time. */
static void add_parts_of(const pm_world *world, uint32_t material, struct parts *parts)
{
    if (material == PM_NO_PRIMITIVE) {
        parts->lobes++;
        return;
    }
    const struct pm_material *m = &world->materials[material];
    for (int i = 0; pm_primitive_is_mixture(m->type) && i < 2; i++)
        if (fit(parts))
            add_parts_of(world, m->components[i], parts);
    if (pm_primitive_is_mixture(m->type))
        return;
    if (m->type == PM_ILLUM) {
        add_parts_of(world, m->alternate, parts);
        return;
    }
    parts->lobes += most_lobes(m);
    parts->functions += pm_brdf_is(m->type);
    parts->bsdfs += m->type == PM_BSDF || m->type == PM_ABSDF;
}

bool pm_material_fits(const pm_world *world, uint32_t material)
{
    struct parts parts = {0};
    add_parts_of(world, material, &parts);
    return fit(&parts);
}

/* ---- what there is to show ---- */

static bool bounds_medium(const struct pm_material *m)
{
    return m->type == PM_MIST || m->type == PM_DIELECTRIC || m->type == PM_INTERFACE ||
           m->type == PM_ANTIMATTER;
}

static void mark_cut_objects(pm_world *world)
{
    for (size_t i = 0; i < world->material_count; i++) {
        const struct pm_material *m = &world->materials[i];
        if (m->alternate == PM_NO_PRIMITIVE)
            continue;
        for (uint32_t k = 0; k < m->hides_count; k++)
            world->materials[m->hides[k]].bounds_volume = true;
    }
}

/* Of all that are like plastic: a specular share, and what of the rest is transmitted. */
static void set_plastic(struct pm_material *m, bool metal, bool smooth)
{
    bool colored = !pm_rgb_is_black(m->color);
    double rest = (1 - m->specularity) * colored;
    double passed = rest * m->transmission * m->straight_fraction;
    m->specular = m->specularity > 0 && (colored || !metal);
    m->specular = m->specular || (!smooth && passed > 0);
    m->diffuse = rest * (1 - m->transmission * m->straight_fraction) > 0;
    m->straight = smooth && passed > 0;
}

/* A function's lobe is a diffuse one. */
static void set_function(struct pm_material *m)
{
    set_plastic(m, m->type == PM_METFUNC || m->type == PM_METDATA, false);
    m->diffuse = m->diffuse || m->specular;
    m->specular = false;
}

static void set_scattering(const pm_world *world, struct pm_material *m)
{
    bool colored = !pm_rgb_is_black(m->color);
    switch (m->type) {
    case PM_PLASTIC:
    case PM_TRANS:
        set_plastic(m, false, !(m->roughness > 0));
        break;
    case PM_METAL:
        set_plastic(m, true, !(m->roughness > 0));
        break;
    case PM_PLASTIC2:
    case PM_TRANS2:
        set_plastic(m, false, false);
        break;
    case PM_METAL2:
        set_plastic(m, true, false);
        break;
    case PM_ASHIK2:
        m->diffuse = colored;
        m->specular = !pm_rgb_is_black(m->specular_color);
        break;
    case PM_GLASS:
        m->specular = true;
        m->straight = colored;
        break;
    case PM_DIELECTRIC:
    case PM_INTERFACE:
    case PM_PRISM1:
    case PM_PRISM2:
        m->specular = true;
        break;
    case PM_MIRROR:
        m->specular = colored;
        break;
    case PM_PLASFUNC:
    case PM_METFUNC:
    case PM_TRANSFUNC:
    case PM_PLASDATA:
    case PM_METDATA:
    case PM_TRANSDATA:
        set_function(m);
        break;
    case PM_BSDF:
    case PM_ABSDF:
        pm_bsdf_set_abilities(world, m);
        break;
    case PM_BRTDFUNC: /* what its expressions may give */
        m->diffuse = colored;
        m->specular = m->specularity > 0;
        m->straight = m->straight_fraction > 0;
        break;
    case PM_MIST:
    case PM_ANTIMATTER:
        m->straight = true;
        break;
    case PM_ILLUM:
        m->straight = m->alternate == PM_NO_PRIMITIVE;
        break;
    default:
        break;
    }
}

/* What `m` may show instead, or as a part, it can do. True if that is new. */
static bool add_part(const pm_world *world, struct pm_material *m, uint32_t part)
{
    static const struct pm_material nothing = {.straight = true};
    const struct pm_material *shown =
        part == PM_NO_PRIMITIVE ? &nothing : &world->materials[part];
    bool more = (shown->specular && !m->specular) || (shown->diffuse && !m->diffuse) ||
                (shown->straight && !m->straight);
    m->specular = m->specular || shown->specular;
    m->diffuse = m->diffuse || shown->diffuse;
    m->straight = m->straight || shown->straight;
    return more;
}

static bool add_parts(const pm_world *world, struct pm_material *m)
{
    bool more = false;
    if (m->has_alternate || m->alternate != PM_NO_PRIMITIVE)
        more = add_part(world, m, m->alternate);
    for (int i = 0; pm_primitive_is_mixture(m->type) && i < 2; i++)
        more = add_part(world, m, m->components[i]) || more;
    return more;
}

static bool is_plain(const struct pm_material *m)
{
    return !m->textures && m->modifier.expressions == PM_NO_FUNCTION &&
           m->modifier.functions == PM_NO_FUNCTION && !pm_primitive_is_mixture(m->type);
}

void pm_materials_set_abilities(pm_world *world)
{
    for (size_t i = 0; i < world->material_count; i++) {
        world->materials[i].bounds_volume = bounds_medium(&world->materials[i]);
        world->materials[i].plain = is_plain(&world->materials[i]);
        set_scattering(world, &world->materials[i]);
    }
    mark_cut_objects(world);
    bool more = true;
    for (int round = 0; more && round < PM_MODIFIERS_MAX; round++) {
        more = false;
        for (size_t i = 0; i < world->material_count; i++)
            more = add_parts(world, &world->materials[i]) || more;
    }
    for (size_t i = 0; i < world->material_count; i++) {
        const struct pm_material *m = &world->materials[i];
        world->passes_straight = world->passes_straight || m->straight;
        world->has_media = world->has_media || m->type == PM_MIST || m->type == PM_ANTIMATTER ||
                           !pm_rgb_is_black(m->extinction);
    }
}
