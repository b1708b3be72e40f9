#include "world/material.h"

#include <stdlib.h>
#include <string.h>

#include "base/maths.h"
#include "base/warp.h"
#include "world/media.h"
#include "world/shading.h"

/* Stands for an infinite extinction: black after any length, and 0 * length = 0. */
#define BLACK_EXTINCTION 1e300

/* ---- arguments ---- */

static pm_rgb rgb_of(const double *reals)
{
    return (pm_rgb){reals[0], reals[1], reals[2]};
}

/* Extinction that leaves `share` after a unit length (Radiance's dielectric.c, mylog). */
static double extinction_of(double share, double scale)
{
    if (share >= 1)
        return 0;
    if (share <= 0)
        return BLACK_EXTINCTION;
    return -pm_log(share) * scale;
}

static void read_plastic(struct pm_material *m, const pm_primitive *p)
{
    m->specularity = p->reals[3];
    m->roughness = p->reals[4];
    if (p->type == PM_TRANS) {
        m->transmission = p->reals[5];
        m->straight_fraction = p->reals[6];
    }
    if (m->roughness * m->roughness <= 1e-6) /* normal.c: alpha2 <= FTINY is pure */
        m->roughness = 0;
}

/* plastic2, metal2, trans2, ashik2. */
static void read_grained(struct pm_material *m, const pm_primitive *p)
{
    bool phong = p->type == PM_ASHIK2;
    m->specularity = phong ? 0 : p->reals[3];
    m->specular_color = phong ? rgb_of(p->reals + 3) : pm_rgb_grey(0);
    m->roughness = p->reals[phong ? 6 : 4];
    m->across = p->reals[phong ? 7 : 5];
    if (p->type == PM_TRANS2) {
        m->transmission = p->reals[6];
        m->straight_fraction = p->reals[7];
    }
}

/* Whether any of three string arguments is more than "0". */
static bool says_something(const pm_primitive *p, unsigned first)
{
    for (unsigned i = first; i < first + 3; i++)
        if (strcmp(p->strings[i], "0") != 0)
            return true;
    return false;
}

/* What a BRTDfunc may do: its reals and functions stay in its modifier. */
static void read_brtdfunc(struct pm_material *m, const pm_primitive *p)
{
    m->specularity = says_something(p, 0);
    m->straight_fraction = says_something(p, 3);
    m->color = pm_rgb_grey(says_something(p, 6));
    for (int i = 0; i < 9; i += 3)
        m->color = pm_rgb_add(m->color, rgb_of(p->reals + i));
}

/* plasfunc and what is like it. */
static void read_function(struct pm_material *m, const pm_primitive *p)
{
    m->specularity = p->reals[3];
    if (p->type == PM_TRANSFUNC || p->type == PM_TRANSDATA) {
        m->transmission = p->reals[4];
        m->straight_fraction = p->reals[5];
    }
}

static void read_glass(struct pm_material *m, const pm_primitive *p)
{
    m->index = p->real_count > 3 ? p->reals[3] : 1.52; /* glass.c, RINDEX */
}

/* `reals`: transmissivity of a unit length. */
static pm_rgb extinction_from(const double *reals, double scale)
{
    return (pm_rgb){extinction_of(reals[0], scale), extinction_of(reals[1], scale),
                    extinction_of(reals[2], scale)};
}

static void read_dielectric(struct pm_material *m, const pm_primitive *p, double scale)
{
    m->color = pm_rgb_grey(1);
    m->index = p->reals[3] + p->reals[4] / 500; /* dielectric.c, MLAMBDA; no dispersion */
    m->extinction = extinction_from(p->reals, scale);
}

static void read_interface(struct pm_material *m, const pm_primitive *p, double scale)
{
    m->color = pm_rgb_grey(1);
    m->index = p->reals[3] / p->reals[7];
    m->extinction = extinction_from(p->reals, scale);
}

static void read_mist(struct pm_material *m, const pm_primitive *p, double scale)
{
    if (p->real_count > 2)
        m->extinction = pm_rgb_scale(rgb_of(p->reals), scale);
    if (p->real_count > 5)
        m->scattering = pm_rgb_mul(m->extinction, rgb_of(p->reals + 3));
    if (p->real_count > 6)
        m->g = p->reals[6];
}

static void read_spotlight(struct pm_material *m, const pm_primitive *p, double scale)
{
    pm_vec3 aim = {p->reals[4], p->reals[5], p->reals[6]};
    m->aim = pm_vec3_normalize(aim);
    m->focus = pm_vec3_length(aim) / scale;
    m->versine = pm_versine(p->reals[3] * (PM_PI / 360));
}

static void read_reals(struct pm_material *m, const pm_primitive *p, double scale)
{
    m->type = p->type;
    m->alternate = m->components[0] = m->components[1] = m->outside = PM_NO_PRIMITIVE;
    if (p->real_count >= 3)
        m->color = rgb_of(p->reals);
    switch (p->type) {
    case PM_PLASTIC:
    case PM_METAL:
    case PM_TRANS:
        read_plastic(m, p);
        break;
    case PM_GLASS:
        read_glass(m, p);
        break;
    case PM_DIELECTRIC:
        read_dielectric(m, p, scale);
        break;
    case PM_INTERFACE:
        read_interface(m, p, scale);
        break;
    case PM_PLASTIC2:
    case PM_METAL2:
    case PM_TRANS2:
    case PM_ASHIK2:
        read_grained(m, p);
        break;
    case PM_BRTDFUNC:
        read_brtdfunc(m, p);
        break;
    case PM_PLASFUNC:
    case PM_METFUNC:
    case PM_TRANSFUNC:
    case PM_PLASDATA:
    case PM_METDATA:
    case PM_TRANSDATA:
        read_function(m, p);
        break;
    case PM_MIST:
        read_mist(m, p, scale);
        break;
    case PM_SPOTLIGHT:
        read_spotlight(m, p, scale);
        break;
    case PM_GLOW:
        m->reach = p->reals[3];
        break;
    default:
        break;
    }
}

/* ---- references ---- */

struct compiler {
    pm_world *world;
    const pm_scene *scene;
    const struct pm_material_table *table;
    struct pm_texture **textures; /* [scene->count]: made so far */
    pm_error *err;
};

static pm_status memory_error(const struct compiler *c)
{
    return pm_error_set(c->err, PM_E_MEMORY, "out of memory for materials");
}

static pm_status refuse(const struct compiler *c, const pm_primitive *p, const char *what)
{
    return pm_error_set_at(c->err, PM_E_UNSUPPORTED, c->scene->files[p->file], p->line,
                           p->column, "%s '%s' %s", pm_primitive_type_name(p->type), p->name,
                           what);
}

static bool is_lamp(pm_primitive_type type)
{
    return type == PM_LIGHT || type == PM_GLOW || type == PM_SPOTLIGHT;
}

/* The material at the end of a modifier's chain; NULL for none. */
static const pm_primitive *material_at(const struct compiler *c, int32_t modifier)
{
    int32_t material = modifier == PM_VOID ? PM_VOID : c->scene->primitives[modifier].material;
    return material == PM_VOID ? NULL : &c->scene->primitives[material];
}

static uint32_t translate(const struct compiler *c, int32_t modifier)
{
    return modifier == PM_VOID ? PM_NO_PRIMITIVE : c->table->of_primitive[modifier];
}

/* The material that string argument `i` names, through illums; PM_NO_PRIMITIVE for void. */
static pm_status find_alternate(const struct compiler *c, const pm_primitive *p, uint32_t i,
                                uint32_t *out)
{
    int32_t reference = p->references[i];
    const pm_primitive *q = material_at(c, reference);
    while (q && q->type == PM_ILLUM) {
        reference = q->string_count ? q->references[0] : PM_VOID;
        q = material_at(c, reference);
    }
    if (q && ((is_lamp(q->type) && p->type != PM_ILLUM) || q->type == PM_ANTIMATTER))
        return refuse(
            c, p,
            "names a light or an antimatter to be shown instead; name a material that "
            "does not shine");
    *out = q ? translate(c, reference) : PM_NO_PRIMITIVE;
    return PM_OK;
}

/* Ascending, without repeats. */
static uint32_t insert_sorted(uint32_t *list, uint32_t count, uint32_t value)
{
    uint32_t at = count;
    while (at > 0 && list[at - 1] > value)
        at--;
    if (at > 0 && list[at - 1] == value)
        return count;
    for (uint32_t i = count; i > at; i--)
        list[i] = list[i - 1];
    list[at] = value;
    return count + 1;
}

static pm_status compile_antimatter(const struct compiler *c, const pm_primitive *p,
                                    struct pm_material *m)
{
    uint32_t *hides = pm_arena_array(&c->world->arena, p->string_count, sizeof *hides);
    if (!hides)
        return memory_error(c);
    uint32_t count = 0;
    for (uint32_t i = 0; i < p->string_count; i++) {
        const pm_primitive *q = material_at(c, p->references[i]);
        if (!q)
            continue;
        if (is_lamp(q->type) || q->type == PM_ILLUM || q->type == PM_ANTIMATTER)
            return refuse(c, p,
                          "lists a light, an illum or an antimatter; those cannot be cut");
        uint32_t hidden = translate(c, p->references[i]);
        if (hidden != PM_NO_PRIMITIVE) /* else no surface has it */
            count = insert_sorted(hides, count, hidden);
    }
    m->hides = hides;
    m->hides_count = count;
    return find_alternate(c, p, 0, &m->alternate);
}

static pm_status compile_references(const struct compiler *c, const pm_primitive *p,
                                    struct pm_material *m)
{
    if (p->type == PM_ANTIMATTER)
        return compile_antimatter(c, p, m);
    for (int i = 0; pm_primitive_is_mixture(p->type) && i < 2; i++)
        m->components[i] = translate(c, p->references[i]);
    if ((p->type != PM_ILLUM && p->type != PM_MIRROR) || !p->string_count)
        return PM_OK;
    m->has_alternate = true;
    return find_alternate(c, p, 0, &m->alternate);
}

/* ---- chains ---- */

static pm_status make_modifier(const struct compiler *c, const pm_primitive *p,
                               struct pm_modifier *out)
{
    pm_arena *arena = &c->world->arena;
    double *reals = pm_arena_array(arena, p->real_count, sizeof *reals);
    int32_t *assets = pm_arena_array(arena, p->string_count, sizeof *assets);
    if (!reals || !assets)
        return memory_error(c);
    memcpy(reals, p->reals, p->real_count * sizeof *reals);
    if (p->assets)
        memcpy(assets, p->assets, p->string_count * sizeof *assets);
    *out = (struct pm_modifier){.type = p->type,
                                .reals = reals,
                                .assets = p->assets ? assets : NULL,
                                .real_count = p->real_count,
                                .string_count = p->string_count,
                                .expressions = p->expressions,
                                .functions = p->functions,
                                .coordinates = p->coordinates,
                                .lone_functions = p->lone_functions,
                                .transform =
                                    p->transform ? *p->transform : pm_transform_identity()};
    return pm_modifier_prepare(out, c->world, c->scene, p, c->err);
}

/* The textures and patterns of the chain that starts there; *out is NULL if there are none.
 * Recursion is bounded by PM_MODIFIERS_MAX. */
static pm_status compile_textures(const struct compiler *c, int32_t modifier,
                                  const struct pm_texture **out)
{
    *out = NULL;
    if (modifier == PM_VOID)
        return PM_OK;
    const pm_primitive *p = &c->scene->primitives[modifier];
    if (p->material == modifier)
        return compile_textures(c, p->modifier, out);
    struct pm_texture *texture = c->textures[modifier];
    *out = texture;
    if (texture)
        return PM_OK;
    texture = pm_arena_alloc(&c->world->arena, sizeof *texture);
    if (!texture)
        return memory_error(c);
    *out = c->textures[modifier] = texture;
    pm_status status = make_modifier(c, p, &texture->modifier);
    if (!status)
        status = compile_textures(c, p->modifier, &texture->next);
    for (int i = 0; !status && pm_primitive_is_mixture(p->type) && i < 2; i++)
        status = compile_textures(c, p->references[i], &texture->components[i]);
    return status;
}

/* Patterns scale what a dielectric or an interface lets through a unit length, and a mist's
 * extinction (Radiance's dielectric.c, m_mist.c). There they count where a ray leaves or enters
 * the medium; here a medium is alike everywhere. */
static pm_status fold_patterns(const struct compiler *c, const pm_primitive *p,
                               struct pm_material *m)
{
    bool mist = m->type == PM_MIST;
    pm_rgb color;
    if (!m->textures || (!mist && m->type != PM_DIELECTRIC && m->type != PM_INTERFACE))
        return PM_OK;
    if (!pm_textures_constant_color(c->world, m, &color))
        return refuse(
            c, p,
            "has a pattern that varies; what it fills is alike everywhere, so give it "
            "patterns without coordinates");
    color = (pm_rgb){fmax(color.r, 0), fmax(color.g, 0), fmax(color.b, 0)};
    if (mist) {
        m->extinction = pm_rgb_mul(m->extinction, color);
        m->scattering = pm_rgb_mul(m->scattering, color);
        return PM_OK;
    }
    m->color = color; /* for what is in front of an interface */
    pm_rgb passed = pm_rgb_mul(rgb_of(p->reals), color);
    m->extinction =
        extinction_from((const double[]){passed.r, passed.g, passed.b}, c->world->scale);
    return PM_OK;
}

/* `top` is where the material's chain starts. */
static pm_status compile_material(const struct compiler *c, uint32_t top, struct pm_material *m)
{
    const pm_primitive *p = material_at(c, (int32_t)top);
    read_reals(m, p, c->world->scale);
    pm_status status = make_modifier(c, p, &m->modifier);
    if (!status)
        status = compile_references(c, p, m);
    if (!status)
        status = compile_textures(c, (int32_t)top, &m->textures);
    return status ? status : fold_patterns(c, p, m);
}

/* A cone of directions at infinity, each of them again a cone: nobody can mean that. */
static pm_status check_sources(const struct compiler *c)
{
    for (size_t i = 0; i < c->scene->count; i++) {
        const pm_primitive *p = &c->scene->primitives[i];
        const pm_primitive *material = material_at(c, p->modifier);
        if (p->type == PM_SOURCE && material && material->type == PM_SPOTLIGHT)
            return refuse(c, p, "is a spotlight; a distant source takes light, glow or illum");
    }
    return PM_OK;
}

static size_t count_interfaces(const struct compiler *c)
{
    size_t count = 0;
    for (size_t i = 0; i < c->table->count; i++)
        count += material_at(c, (int32_t)c->table->primitive[i])->type == PM_INTERFACE;
    return count;
}

/* Appends what is in front of each interface, unless that is empty space: a dielectric that no
 * surface has. */
static void add_outsides(const struct compiler *c)
{
    static const double vacuum[4] = {1, 1, 1, 1};
    for (size_t i = 0; i < c->table->count; i++) {
        struct pm_material *m = &c->world->materials[i];
        if (m->type != PM_INTERFACE || !memcmp(m->modifier.reals + 4, vacuum, sizeof vacuum))
            continue;
        m->outside = (uint32_t)c->world->material_count++;
        struct pm_material *outside = &c->world->materials[m->outside];
        pm_rgb passed = pm_rgb_mul(rgb_of(m->modifier.reals + 4), m->color);
        *outside = (struct pm_material){
            .type = PM_DIELECTRIC,
            .modifier = m->modifier,
            .color = pm_rgb_grey(1),
            .index = m->modifier.reals[7],
            .extinction = extinction_from((const double[]){passed.r, passed.g, passed.b},
                                          c->world->scale),
            .alternate = PM_NO_PRIMITIVE,
            .outside = PM_NO_PRIMITIVE,
            .components = {PM_NO_PRIMITIVE, PM_NO_PRIMITIVE},
            .stands_outside = true};
    }
}

/* Refuses mixtures of more than a pm_surface holds. */
static pm_status check_parts(const struct compiler *c)
{
    for (size_t i = 0; i < c->table->count; i++)
        if (!pm_material_fits(c->world, (uint32_t)i))
            return refuse(c, material_at(c, (int32_t)c->table->primitive[i]),
                          "mixes too much: in all 16 ways of scattering (plastic has 2 to 4, "
                          "BRTDfunc 6), 4 functions and 2 BSDFs can be mixed");
    return PM_OK;
}

pm_status pm_materials_compile(pm_world *world, const pm_scene *scene,
                               const struct pm_material_table *table, pm_error *err)
{
    struct compiler c = {world, scene, table, NULL, err};
    c.textures = calloc(scene->count + 1, sizeof *c.textures);
    size_t count = table->count + count_interfaces(&c);
    world->materials = pm_arena_array(&world->arena, count, sizeof *world->materials);
    pm_status status = world->materials && c.textures ? check_sources(&c) : memory_error(&c);
    for (size_t i = 0; i < table->count && !status; i++)
        status = compile_material(&c, table->primitive[i], &world->materials[i]);
    free(c.textures);
    world->material_count = table->count;
    if (!status)
        add_outsides(&c);
    if (!status)
        status = check_parts(&c);
    if (!status)
        pm_materials_set_abilities(world);
    return status;
}

/* ---- queries ---- */

bool pm_material_emits(const struct pm_material *m)
{
    bool lamp = m->type == PM_LIGHT || m->type == PM_SPOTLIGHT || m->type == PM_ILLUM ||
                (m->type == PM_GLOW && m->reach >= 0);
    return lamp && !pm_rgb_is_black(m->color);
}

bool pm_material_is_specular(const struct pm_material *m)
{
    return m->specular;
}

bool pm_material_is_diffuse(const struct pm_material *m)
{
    return m->diffuse;
}

bool pm_material_is_mist(const struct pm_material *m)
{
    return m->type == PM_MIST && !pm_rgb_is_black(m->scattering);
}

bool pm_material_hides(const struct pm_material *antimatter, uint32_t material)
{
    uint32_t low = 0, high = antimatter->hides_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (antimatter->hides[middle] < material)
            low = middle + 1;
        else
            high = middle;
    }
    return low < antimatter->hides_count && antimatter->hides[low] == material;
}

bool pm_material_is_hidden(const pm_world *world, const pm_media *media, uint32_t material)
{
    for (int i = 0; i < media->count; i++)
        if (pm_material_hides(&world->materials[media->material[i]], material))
            return true;
    return false;
}

/* Whether the walk is inside an object that the antimatter cuts. */
static bool inside_cut_object(const struct pm_material *antimatter, const pm_media *media)
{
    for (int i = 0; i < media->count; i++)
        if (pm_material_hides(antimatter, media->material[i]))
            return true;
    return false;
}

static const struct pm_material *alternate_of(const pm_world *world,
                                              const struct pm_material *m)
{
    return m->alternate == PM_NO_PRIMITIVE ? NULL : &world->materials[m->alternate];
}

struct pm_shown pm_material_shown(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                                  const pm_media *media, bool seen)
{
    const struct pm_material *m = &world->materials[hit->material];
    struct pm_shown shown = {.material = m};
    if (media->count && pm_material_is_hidden(world, media, hit->material))
        shown.material = NULL;
    else if (m->type == PM_ILLUM)
        shown.material = alternate_of(world, m);
    else if (m->type == PM_MIRROR && m->has_alternate &&
             (seen || pm_vec3_dot(wo, hit->normal) < 0))
        shown.material = alternate_of(world, m);
    else if (m->type == PM_ANTIMATTER) {
        shown.flipped = inside_cut_object(m, media);
        shown.material = shown.flipped ? alternate_of(world, m) : NULL;
    }
    return shown;
}
