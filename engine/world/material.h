#ifndef PM_WORLD_MATERIAL_H
#define PM_WORLD_MATERIAL_H

#include <stdbool.h>
#include <stdint.h>

#include "base/rgb.h"
#include "base/vec3.h"
#include "world/world_internal.h"

/* What a modifier's functions and files need, copied from its primitive. */
struct pm_modifier {
    pm_primitive_type type;
    const double *reals;
    const int32_t *assets; /* [string_count], or NULL */
    uint32_t real_count, string_count;
    pm_function expressions, functions, coordinates; /* or PM_NO_FUNCTION */
    uint8_t lone_functions;                          /* see pm_primitive */
    pm_transform transform, inverse; /* from its own coordinates to the scene's, and back */
    pm_rgb color;                    /* spectrum, specfile */
    const struct pm_ink *ink;        /* colortext, brighttext, mixtext */
};

/* Set text in space: the point at `anchor` + v is right . v characters to the right of its
 * upper left corner, and down . v lines below. */
struct pm_ink {
    const pm_text *text;
    pm_vec3 anchor, right, down;
};

/* modifier.c: what evaluation needs besides the arguments: inverse, color, ink. Refused are
 * text vectors that are parallel, and data that are no spectrum, with the primitive's place. */
PM_MUST_USE pm_status pm_modifier_prepare(struct pm_modifier *modifier, pm_world *world,
                                          const pm_scene *scene, const pm_primitive *primitive,
                                          pm_error *err);

/* A texture, a pattern, or a mixture of such, and those that follow it. Shared between the
 * materials whose chains end alike. */
struct pm_texture {
    struct pm_modifier modifier;
    const struct pm_texture *components[2]; /* a mixture's: foreground, background; or NULL */
    const struct pm_texture *next;
};

/* Materials as surface.c, light.c and media.c need them. Which reals mean what: Radiance
 * reference manual, 2.1.2. */
struct pm_material {
    pm_primitive_type type;

    /* Its own functions and files. A mixture's say how much of the foreground shows. */
    struct pm_modifier modifier;
    /* The textures and patterns of the chain, in the order in which they apply: first those
     * over the material, then those below it (Radiance's rayshade and raytexture). */
    const struct pm_texture *textures;
    /* A mixture's foreground and background; PM_NO_PRIMITIVE: straight passage. */
    uint32_t components[2];

    /* Reflectance, transmissivity of glass, or emitted radiance. BRTDfunc: black if it has no
     * diffuse part; then specularity and straight_fraction say whether it has such parts. */
    pm_rgb color;

    pm_rgb specular_color; /* ashik2 */

    /* plastic, metal, trans; of those with a 2: roughness along the orientation and across it;
     * ashik2: its exponents */
    double specularity, roughness, across;
    double transmission;      /* trans: share of what is not reflected specularly */
    double straight_fraction; /* trans: of that, the specular share */

    double index; /* glass, dielectric; interface: the inside's over the outside's */

    /* mist, dielectric, inside of an interface [1 / scale] */
    pm_rgb extinction, scattering;
    double g;
    uint32_t outside;    /* interface: what stands for the medium in front of it, see media.h;
                            PM_NO_PRIMITIVE: empty space */
    bool stands_outside; /* such a stand-in, which no surface has */

    const struct pm_brdf_table *brdf; /* brdf.c */

    double reach; /* glow: Radiance's maxrad; only its sign counts */

    /* spotlight */
    pm_vec3 aim;
    double versine; /* 1 - cos(half the cone's angle) */
    double focus;   /* [scale] */

    /* illum and mirror: what is seen instead; antimatter: what its boundary shows within an
     * object that it cuts. PM_NO_PRIMITIVE: invisible. Never itself an illum or a light. */
    uint32_t alternate;
    bool has_alternate; /* illum, mirror: the scene names one, void included */

    /* antimatter: the materials that it hides, ascending */
    const uint32_t *hides;
    uint32_t hides_count;

    bool bounds_volume; /* walks list it in pm_media while inside: a medium, an antimatter, or
                           an object that an antimatter cuts and gives a new boundary */

    bool plain; /* no texture, pattern, function or part: all hits are alike */

    /* What its surfaces can do, by themselves or through the alternate. */
    bool specular, diffuse, straight;
};

bool pm_material_emits(const struct pm_material *material); /* into the scene */
bool pm_material_hides(const struct pm_material *antimatter, uint32_t material);

/* Whether an antimatter in `media` makes surfaces of this material invisible. */
bool pm_material_is_hidden(const pm_world *world, const struct pm_media *media,
                           uint32_t material);

/* ability.c: whether what a material may show at once fits into a pm_surface; then, as the last
 * step of pm_materials_compile, what materials can do. */
bool pm_material_fits(const pm_world *world, uint32_t material);
void pm_materials_set_abilities(pm_world *world);

/* What a surface shows to a walk, with illum, mirror and antimatter resolved. */
struct pm_shown {
    const struct pm_material *material; /* NULL: nothing, straight passage */
    bool flipped;                       /* front and back are exchanged */
};

/* `seen`: by a walk from the eye with nothing but specular and straight events so far. */
struct pm_shown pm_material_shown(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                                  const struct pm_media *media, bool seen);

#endif
