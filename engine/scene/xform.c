#include "scene/xform.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/maths.h"

/* ---- transforms ---- */

pm_transform pm_transform_identity(void)
{
    return (pm_transform){.turn = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .scale = 1};
}

static void turn_vector(const pm_transform *t, const double v[3], double out[3])
{
    for (int j = 0; j < 3; j++)
        out[j] = v[0] * t->turn[0][j] + v[1] * t->turn[1][j] + v[2] * t->turn[2][j];
}

pm_transform pm_transform_then(const pm_transform *a, const pm_transform *b)
{
    pm_transform ab = {.scale = a->scale * b->scale, .mirrored = a->mirrored != b->mirrored};
    for (int i = 0; i < 3; i++)
        turn_vector(b, a->turn[i], ab.turn[i]);
    turn_vector(b, a->shift, ab.shift);
    for (int j = 0; j < 3; j++)
        ab.shift[j] += b->shift[j];
    return ab;
}

/* `turn` over its scale is orthonormal, so its transpose over the square of it undoes it. */
pm_transform pm_transform_inverse(const pm_transform *t)
{
    double square = t->scale * t->scale;
    pm_transform inverse = {.scale = 1 / t->scale, .mirrored = t->mirrored};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            inverse.turn[i][j] = t->turn[j][i] / square;
    turn_vector(&inverse, t->shift, inverse.shift);
    for (int j = 0; j < 3; j++)
        inverse.shift[j] = -inverse.shift[j];
    return inverse;
}

/* `count` times, by squaring: few roundings, and quick for any count. */
static pm_transform repeated(const pm_transform *transform, uint64_t count)
{
    pm_transform result = pm_transform_identity(), power = *transform;
    while (count) {
        if (count & 1)
            result = pm_transform_then(&result, &power);
        count >>= 1;
        if (count)
            power = pm_transform_then(&power, &power);
    }
    return result;
}

/* Exact for multiples of a quarter turn, so that walls stay on their axes. */
static void sincos_degrees(double degrees, double *sine, double *cosine)
{
    double turn = fmod(degrees, 360); /* exact */
    double quarters = floor(turn / 90 + 0.5);
    double s, c;
    pm_sincos((turn - 90 * quarters) * (PM_PI / 180), &s, &c);
    switch ((int)quarters & 3) {
    case 0:
        *sine = s, *cosine = c;
        break;
    case 1:
        *sine = c, *cosine = -s;
        break;
    case 2:
        *sine = -s, *cosine = -c;
        break;
    default:
        *sine = -c, *cosine = s;
        break;
    }
}

/* Counter-clockwise about an axis (0 x, 1 y, 2 z) that points at the onlooker. */
static pm_transform rotation(int axis, double degrees)
{
    pm_transform t = pm_transform_identity();
    int i = (axis + 1) % 3, j = (axis + 2) % 3;
    double sine, cosine;
    sincos_degrees(degrees, &sine, &cosine);
    t.turn[i][i] = t.turn[j][j] = cosine;
    t.turn[i][j] = sine;
    t.turn[j][i] = -sine;
    return t;
}

static pm_transform scaling(double factor)
{
    pm_transform t = pm_transform_identity();
    for (int i = 0; i < 3; i++)
        t.turn[i][i] = factor;
    t.scale = fabs(factor);
    t.mirrored = factor < 0;
    return t;
}

static pm_transform mirror(int axis)
{
    pm_transform t = pm_transform_identity();
    t.turn[axis][axis] = -1;
    t.mirrored = true;
    return t;
}

/* ---- the command line ---- */

struct reader {
    const pm_command *command;
    size_t at; /* the word in hand */
    pm_error *err;
    pm_arena *arena;
    pm_xform *xform;
    pm_xform_group *groups;
    bool moving; /* past the first transform: -m -n -I are over */
    bool whole;  /* a command, not a primitive's transform */
};

static const pm_word *word(const struct reader *r)
{
    return &r->command->words[r->at];
}

static pm_status take_value(struct reader *r, const char *option, const char *takes)
{
    if (r->at + 1 < r->command->count) {
        r->at++;
        return PM_OK;
    }
    return pm_word_error(word(r), PM_E_SYNTAX, r->command->file, r->err,
                         "xform's %s takes %s; nothing follows it", option, takes);
}

static pm_status take_real(struct reader *r, const char *option, const char *takes, double *out)
{
    pm_status st = take_value(r, option, takes);
    if (st)
        return st;
    pm_number number = pm_word_real(word(r), out);
    if (number == PM_NUMBER_MALFORMED)
        return pm_word_error(word(r), PM_E_SYNTAX, r->command->file, r->err,
                             "'%.*s' is no number; xform's %s takes %s", PM_WORD_SHOW(*word(r)),
                             option, takes);
    if (number == PM_NUMBER_HUGE)
        return pm_word_error(word(r), PM_E_RANGE, r->command->file, r->err,
                             "'%.*s' is larger than a double holds", PM_WORD_SHOW(*word(r)));
    return PM_OK;
}

static void move(struct reader *r, pm_transform t)
{
    pm_xform_group *group = &r->groups[r->xform->group_count - 1];
    group->transform = pm_transform_then(&group->transform, &t);
}

static pm_status translate(struct reader *r)
{
    pm_transform t = pm_transform_identity();
    for (int i = 0; i < 3; i++) {
        pm_status st = take_real(r, "-t", "a vector: x y z", &t.shift[i]);
        if (st)
            return st;
    }
    move(r, t);
    return PM_OK;
}

static pm_status rotate(struct reader *r, int axis)
{
    double degrees;
    pm_status st = take_real(r, word(r)->text, "an angle in degrees", &degrees);
    if (!st)
        move(r, rotation(axis, degrees));
    return st;
}

static pm_status rescale(struct reader *r)
{
    double factor;
    pm_status st = take_real(r, "-s", "a factor", &factor);
    if (st)
        return st;
    if (!isnormal(factor) || !isnormal(1 / factor))
        return pm_word_error(
            word(r), PM_E_RANGE, r->command->file, r->err,
            "a scene cannot be scaled by %s; write a factor other than 0, 1 to "
            "keep the size",
            word(r)->text);
    move(r, scaling(factor));
    return PM_OK;
}

static pm_status repeat(struct reader *r, bool array)
{
    int64_t count;
    pm_status st = take_value(r, word(r)->text, "a count");
    if (st)
        return st;
    if (pm_word_integer(word(r), &count) || count < (array ? 1 : 0))
        return pm_word_error(
            word(r), PM_E_RANGE, r->command->file, r->err,
            "'%.*s' is no count for xform's %s; write a whole number, at least %d",
            PM_WORD_SHOW(*word(r)), array ? "-a" : "-i", array ? 1 : 0);
    pm_xform *xform = r->xform;
    if (xform->group_count == PM_XFORM_GROUPS)
        return pm_word_error(
            word(r), PM_E_LIMIT, r->command->file, r->err,
            "more than %d of xform's -a and -i in one line; nest files instead",
            PM_XFORM_GROUPS - 1);
    r->groups[xform->group_count++] = (pm_xform_group){
        .transform = pm_transform_identity(), .count = (uint64_t)count, .array = array};
    if (array && __builtin_mul_overflow(xform->instances, (uint64_t)count, &xform->instances))
        xform->instances = UINT64_MAX;
    return PM_OK;
}

static pm_status transform_option(struct reader *r)
{
    const char *option = word(r)->text;
    r->moving = true;
    if (pm_word_is(word(r), "-t"))
        return translate(r);
    if (pm_word_is(word(r), "-s"))
        return rescale(r);
    if (pm_word_is(word(r), "-a") || pm_word_is(word(r), "-i"))
        return repeat(r, option[1] == 'a');
    if (word(r)->length == 3 && strchr("xyz", option[2])) {
        int axis = option[2] - 'x';
        if (option[1] == 'r')
            return rotate(r, axis);
        if (option[1] == 'm') {
            move(r, mirror(axis));
            return PM_OK;
        }
    }
    return pm_word_error(
        word(r), PM_E_SYNTAX, r->command->file, r->err,
        "'%.*s' is no option of xform; its transforms are -t x y z, -rx -ry -rz "
        "degrees, -s factor, -mx -my -mz, -a count, -i count",
        PM_WORD_SHOW(*word(r)));
}

static pm_status add_prefix(struct reader *r)
{
    const char *old = r->xform->prefix;
    pm_status st = take_value(r, word(r)->text, "a name");
    if (st)
        return st;
    size_t size = strlen(old) + word(r)->length + 2;
    char *prefix = pm_arena_alloc(r->arena, size);
    if (!prefix)
        return pm_error_set(r->err, PM_E_MEMORY, "not enough memory for a name of the scene");
    snprintf(prefix, size, "%s%s%s", old, *old ? "." : "", word(r)->text);
    r->xform->prefix = prefix;
    return PM_OK;
}

static pm_status add_modifier(struct reader *r)
{
    pm_status st = take_value(r, word(r)->text, "a modifier");
    if (!st && !r->xform->modifier) /* the first counts, as in Radiance */
        r->xform->modifier = word(r);
    return st;
}

static pm_status add_list(struct reader *r)
{
    size_t at = r->at;
    pm_status st = take_value(r, word(r)->text, "a file of argument lists");
    if (!st && r->xform->list)
        return pm_word_error(&r->command->words[at], PM_E_UNSUPPORTED, r->command->file, r->err,
                             "-f cannot stand twice in one xform; join two by '|'");
    if (st)
        return st;
    r->xform->list = word(r);
    r->xform->list_at = at;
    return PM_OK;
}

/* Options that must come before the transforms. *known is false if the word is none of them. */
static pm_status leading_option(struct reader *r, bool *known)
{
    const pm_word *option = word(r);
    *known = option->length == 2 && option->text[1] && strchr("mnIecf", option->text[1]);
    if (!*known)
        return PM_OK;
    if (option->text[1] == 'f' && r->whole)
        return add_list(r);
    if (r->moving)
        return pm_word_error(
            option, PM_E_SYNTAX, r->command->file, r->err,
            "xform's %s must stand before its transforms; move it to the front", option->text);
    if (option->text[1] == 'm')
        return add_modifier(r);
    if (option->text[1] == 'n')
        return add_prefix(r);
    if (option->text[1] == 'I')
        r->xform->invert = !r->xform->invert;
    return PM_OK; /* -e and -c, to expand now or later, come to the same */
}

static pm_status read_options(struct reader *r)
{
    pm_status st = PM_OK;
    for (; !st && r->at < r->command->count && word(r)->text[0] == '-'; r->at++) {
        bool known;
        if (pm_word_is(word(r), "-"))
            return pm_word_error(word(r), PM_E_UNSUPPORTED, r->command->file, r->err,
                                 "xform has no standard input here; name a file, or put the "
                                 "command that makes the text before it: !... | xform ...");
        st = leading_option(r, &known);
        if (!st && !known)
            st = transform_option(r);
    }
    return st;
}

static pm_status read_files(struct reader *r)
{
    const pm_command *command = r->command;
    r->xform->files = command->words + r->at;
    r->xform->file_count = command->count - r->at;
    for (; r->at < command->count; r->at++)
        if (word(r)->text[0] == '-')
            return pm_word_error(
                word(r), PM_E_SYNTAX, command->file, r->err,
                "'%.*s' follows a file's name; xform's options come before its "
                "files",
                PM_WORD_SHOW(*word(r)));
    return PM_OK;
}

/* No more groups than this, of PM_XFORM_GROUPS: a list has very many small ones. */
static size_t group_limit(const pm_command *command)
{
    size_t count = 1;
    for (size_t i = 1; i < command->count && count < PM_XFORM_GROUPS; i++)
        count += pm_word_is(&command->words[i], "-a") || pm_word_is(&command->words[i], "-i");
    return count;
}

pm_status pm_xform_parse(const pm_command *command, pm_arena *arena, pm_xform *out,
                         pm_error *err)
{
    pm_xform xform = {.prefix = "", .instances = 1, .group_count = 1};
    struct reader r = {.command = command,
                       .at = 1,
                       .err = err,
                       .arena = arena,
                       .xform = &xform,
                       .whole = true};
    r.groups = pm_arena_array(arena, group_limit(command), sizeof *r.groups);
    if (!r.groups)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a command of the scene");
    r.groups[0] = (pm_xform_group){.transform = pm_transform_identity(), .count = 1};
    xform.groups = r.groups;
    pm_status st = read_options(&r);
    if (!st)
        st = read_files(&r);
    if (!st)
        *out = xform;
    return st;
}

/* Words of a command end in zero, those of a file do not. */
static const pm_word *terminated(const pm_word *words, size_t count, pm_arena *arena)
{
    pm_word *copies = pm_arena_array(arena, count, sizeof *copies);
    for (size_t i = 0; copies && i < count; i++) {
        copies[i] = words[i];
        copies[i].text = pm_arena_text(arena, words[i].text, words[i].length);
        if (!copies[i].text)
            return NULL;
    }
    return copies;
}

static pm_status parse_transform(const pm_word *file_words, size_t count, const char *file,
                                 pm_arena *arena, pm_transform *out, pm_error *err)
{
    const pm_word *words = terminated(file_words, count, arena);
    const pm_command command = {file, words, count};
    pm_xform xform = {.prefix = "", .instances = 1, .group_count = 1};
    struct reader r = {
        .command = &command, .err = err, .arena = arena, .xform = &xform, .moving = true};
    r.groups = pm_arena_array(arena, PM_XFORM_GROUPS, sizeof *r.groups);
    if (!r.groups || !words)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a transform of the scene");
    r.groups[0] = (pm_xform_group){.transform = pm_transform_identity(), .count = 1};
    xform.groups = r.groups;
    pm_status st = read_options(&r);
    if (!st && r.at < command.count)
        st = pm_word_error(word(&r), PM_E_SYNTAX, file, err,
                           "'%.*s' is no part of a transform; it has -t x y z, -rx -ry -rz "
                           "degrees, -s factor, -mx -my -mz, -i count",
                           PM_WORD_SHOW(*word(&r)));
    if (!st && xform.instances > 1)
        st = pm_word_error(&words[0], PM_E_SYNTAX, file, err,
                           "a primitive's transform takes no array (-a); write an !xform line");
    if (!st)
        *out = pm_xform_instance(&xform, 0);
    return st;
}

/* A scene may have a million of these: what each takes is given back. */
pm_status pm_xform_parse_transform(const pm_word *words, size_t count, const char *file,
                                   pm_transform *out, pm_error *err)
{
    pm_arena arena = {0};
    pm_status st = parse_transform(words, count, file, &arena, out, err);
    pm_arena_clear(&arena);
    return st;
}

/* ---- instances ---- */

/* How often `group` repeats in the instance. Arrays are the digits of its index, the first
 * array's leading. `*rest` starts at the number of instances. */
static uint64_t repetitions(const pm_xform_group *group, uint64_t index, uint64_t *rest)
{
    if (!group->array)
        return group->count;
    *rest /= group->count;
    return index / *rest % group->count;
}

pm_transform pm_xform_instance(const pm_xform *xform, uint64_t index)
{
    pm_transform result = pm_transform_identity();
    uint64_t rest = xform->instances;
    for (size_t i = 0; i < xform->group_count; i++) {
        const pm_xform_group *group = &xform->groups[i];
        pm_transform part = repeated(&group->transform, repetitions(group, index, &rest));
        result = pm_transform_then(&result, &part);
    }
    return result;
}

size_t pm_xform_prefix_size(const pm_xform *xform)
{
    enum { DIGITS = 21 }; /* of a uint64_t, and a point */
    return strlen(xform->prefix) + 2 + DIGITS * xform->group_count;
}

void pm_xform_instance_prefix(const pm_xform *xform, uint64_t index, char *out)
{
    size_t size = pm_xform_prefix_size(xform), used = strlen(xform->prefix);
    memcpy(out, xform->prefix, used + 1);
    uint64_t rest = xform->instances;
    for (size_t i = 0; i < xform->group_count; i++) {
        const pm_xform_group *group = &xform->groups[i];
        uint64_t digit = repetitions(group, index, &rest);
        if (group->array)
            used += (size_t)snprintf(out + used, size - used, "%s%llu", used ? "." : "a",
                                     (unsigned long long)digit);
    }
}

/* ---- primitives ---- */

static void move_point(const pm_transform *t, double p[3])
{
    double q[3];
    turn_vector(t, p, q);
    for (int j = 0; j < 3; j++)
        p[j] = q[j] + t->shift[j];
}

/* Turns a vector; its length scales too. */
static void move_vector(const pm_transform *t, double v[3])
{
    double w[3];
    turn_vector(t, v, w);
    memcpy(v, w, sizeof w);
}

/* Turns a vector whose length means nothing. */
static void move_direction(const pm_transform *t, double v[3])
{
    move_vector(t, v);
    for (int j = 0; j < 3; j++)
        v[j] /= t->scale;
}

static void move_polygon(const pm_transform *t, bool backwards, double *v, size_t count)
{
    for (size_t i = 0; i < count; i += 3)
        move_point(t, v + i);
    for (size_t i = 0, j = count - 3; backwards && i < j; i += 3, j -= 3) {
        double swap[3];
        memcpy(swap, v + i, sizeof swap);
        memcpy(v + i, v + j, sizeof swap);
        memcpy(v + j, swap, sizeof swap);
    }
}

/* tau' = tau^(1/scale). False where a double cannot hold tau', or the absorption -log tau' to
 * four digits: 1 - tau' is known to 2^-53, so it must be at least 2^-40. */
static bool rescale_transmission(double scale, double *tau)
{
    if (scale == 1 || *tau == 0 || *tau == 1)
        return true;
    *tau = pm_pow(*tau, 1 / scale);
    return *tau >= DBL_MIN && *tau <= 1 - 0x1p-40;
}

/* The transmissions of one side: of a dielectric, or of an interface. */
static pm_status move_dielectric(const pm_transform *t, double *reals, const char **reason)
{
    for (int i = 0; i < 3; i++) {
        if (!rescale_transmission(t->scale, &reals[i])) {
            *reason =
                "its transmission per unit length would leave the range of numbers; scale "
                "less, or write the dielectric where it is not scaled";
            return PM_E_RANGE;
        }
    }
    return PM_OK;
}

static void move_surface(const pm_transform *t, bool inverted, pm_primitive_type type,
                         double *reals, size_t count)
{
    switch (type) {
    case PM_POLYGON:
        move_polygon(t, inverted != t->mirrored, reals, count);
        break;
    case PM_SOURCE:
        move_direction(t, reals);
        break;
    case PM_RING:
        move_point(t, reals);
        move_direction(t, reals + 3);
        for (int j = 3; j < 6; j++)
            reals[j] = inverted ? 0 - reals[j] : reals[j];
        break;
    case PM_SPHERE:
    case PM_BUBBLE:
        move_point(t, reals);
        break;
    default:
        move_point(t, reals);
        move_point(t, reals + 3);
        break;
    }
    /* Radii follow one center, or two ends, or a center and a normal. */
    size_t radii = type == PM_SPHERE || type == PM_BUBBLE ? 3 : 6;
    for (size_t i = radii; type != PM_POLYGON && type != PM_SOURCE && i < count; i++)
        reals[i] *= t->scale;
}

static pm_primitive_type inverse(pm_primitive_type type)
{
    static const pm_primitive_type inverses[PM_PRIMITIVE_TYPES] = {
        [PM_POLYGON] = PM_POLYGON, [PM_SPHERE] = PM_BUBBLE, [PM_BUBBLE] = PM_SPHERE,
        [PM_CONE] = PM_CUP,        [PM_CUP] = PM_CONE,      [PM_CYLINDER] = PM_TUBE,
        [PM_TUBE] = PM_CYLINDER,   [PM_RING] = PM_RING,     [PM_SOURCE] = PM_SOURCE,
    };
    return inverses[type];
}

/* Text lies where its origin and two vectors say. */
static void move_text(const pm_transform *t, double *reals)
{
    move_point(t, reals);
    move_vector(t, reals + 3);
    move_vector(t, reals + 6);
}

static pm_status move_modifier(const pm_transform *t, pm_primitive_type type, double *reals,
                               size_t count, const char **reason)
{
    pm_status st = PM_OK;
    if (type == PM_DIELECTRIC || type == PM_INTERFACE)
        st = move_dielectric(t, reals, reason);
    if (!st && type == PM_INTERFACE)
        st = move_dielectric(t, reals + 4, reason);
    if (type == PM_GLOW)
        reals[3] *= t->scale;
    if (type == PM_SPOTLIGHT)
        move_vector(t, reals + 4);
    if (type == PM_COLORTEXT || type == PM_BRIGHTTEXT || type == PM_MIXTEXT)
        move_text(t, reals);
    for (size_t i = 0; type == PM_MIST && i < 3 && i < count; i++)
        reals[i] /= t->scale;
    return st;
}

pm_status pm_transform_primitive(const pm_transform *transform, bool inverted,
                                 pm_primitive_type *type, double *reals, size_t count,
                                 const char **reason)
{
    pm_status st = PM_OK;
    if (*type == PM_INSTANCE || *type == PM_MESH) {
        if (inverted) {
            *reason = "an instance or a mesh cannot face the other way (-I)";
            st = PM_E_UNSUPPORTED;
        }
    } else if (pm_primitive_is_surface(*type)) {
        move_surface(transform, inverted, *type, reals, count);
        *type = inverted ? inverse(*type) : *type;
    } else {
        st = move_modifier(transform, *type, reals, count, reason);
    }
    for (size_t i = 0; !st && i < count; i++) {
        if (!isfinite(reals[i])) {
            *reason = "the result would be larger than a double holds; scale or move it less";
            st = PM_E_RANGE;
        }
    }
    return st;
}
