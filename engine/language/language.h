#ifndef PM_LANGUAGE_LANGUAGE_H
#define PM_LANGUAGE_LANGUAGE_H

/* The function language of Radiance's `.cal` files.
 * In: bytes of function files, expressions of a scene. Out: pm_language, immutable programs and
 * their values. Next: files/ (what else a scene names), scene/ (who names it).
 *
 * A language is filled by one thread (read, define, compile) and may then be shared: evaluation
 * takes it const, allocates nothing, keeps its state on the stack and is bounded in depth and
 * work. Names, contexts, constants and order of definition mean what they mean in Radiance
 * (src/common/calexpr.c, caldefn.c, calfunc.c, src/rt/func.c); the standard definitions are our
 * own writing.
 *
 * What is decided when: syntax, undefined names, arguments that lack and recursion that cannot
 * end are errors of read or compile. At evaluation a division by zero, a root of a negative
 * number and the like give 0, as Radiance does, and set a bit of the faults; so do recursion
 * and work beyond PM_LANGUAGE_DEPTH and PM_LANGUAGE_WORK. No value is ever infinite or not a
 * number. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/status.h"

typedef struct pm_language pm_language;

enum {
    PM_LANGUAGE_DEPTH = 32000,      /* nested nodes of one evaluation */
    PM_LANGUAGE_WORK = 1 << 20,     /* of one evaluation, in units of up to four nodes */
    PM_LANGUAGE_NESTING = 400,      /* parentheses, calls and powers inside each other */
    PM_LANGUAGE_PARAMETERS = 64,    /* of a function */
    PM_LANGUAGE_NAME = 127,         /* bytes of a name */
    PM_LANGUAGE_TEXTS = 16,         /* expressions of one function */
    PM_LANGUAGE_TEXT_MAX = 4 << 20, /* bytes of all files of a language */
    PM_LANGUAGE_CODE_MAX = 32 << 20 /* nodes of all programs of a language */
};

/* What a function can ask about a ray (src/rt/func.c, rayinit.cal). In the coordinates of the
 * function: the caller has applied the primitive's transform. */
enum pm_ray_value {
    PM_RAY_DX, /* direction, along the light's way back: from the eye to the surface */
    PM_RAY_DY,
    PM_RAY_DZ,
    PM_RAY_NX, /* the surface's normal, unperturbed */
    PM_RAY_NY,
    PM_RAY_NZ,
    PM_RAY_PX, /* point of intersection; 0 for a ray that met nothing near */
    PM_RAY_PY,
    PM_RAY_PZ,
    PM_RAY_T,    /* distance from the ray's start, through everything */
    PM_RAY_RDOT, /* cosine between ray and normal, -1 .. 1 */
    PM_RAY_S,    /* world scale: the transform's */
    PM_RAY_TX,   /* world origin */
    PM_RAY_TY,
    PM_RAY_TZ,
    PM_RAY_IX, /* world unit vectors */
    PM_RAY_IY,
    PM_RAY_IZ,
    PM_RAY_JX,
    PM_RAY_JY,
    PM_RAY_JZ,
    PM_RAY_KX,
    PM_RAY_KY,
    PM_RAY_KZ,
    PM_RAY_TS,  /* distance of this ray alone */
    PM_RAY_LU,  /* local coordinates, of meshes */
    PM_RAY_LV,  /* the values so far are Radiance's channels $1 .. $27 in order */
    PM_RAY_NXP, /* perturbed normal; from here on for *func and *data materials only */
    PM_RAY_NYP,
    PM_RAY_NZP,
    PM_RAY_RDOTP, /* cosine between ray and perturbed normal */
    PM_RAY_CRP,   /* colour of the patterns */
    PM_RAY_CGP,
    PM_RAY_CBP,
    PM_RAY_DXA, /* direction to the light that prism1 and prism2 aim at; 0 without one */
    PM_RAY_DYA,
    PM_RAY_DZA,
    PM_RAY_VALUES
};

struct pm_ray_values {
    double value[PM_RAY_VALUES];
    const double *reals; /* the primitive's real arguments: A1 .. and arg(n) */
    uint32_t real_count;
};

/* What went wrong inside an evaluation; its value is 0 there. Radiance then drops the pattern
 * or texture ("compute error"). */
enum pm_function_fault {
    PM_FAULT_DIVISION = 1, /* by zero */
    PM_FAULT_DOMAIN = 2,   /* root of a negative number, select out of range, ... */
    PM_FAULT_RANGE = 4,    /* a value too large for a number */
    PM_FAULT_DEPTH = 8,    /* recursion deeper than PM_LANGUAGE_DEPTH */
    PM_FAULT_WORK = 16,    /* more than PM_LANGUAGE_WORK */
    PM_FAULT_REAL = 32     /* arg(n) with n beyond the real arguments */
};

enum pm_language_kind {
    PM_LANGUAGE_SCENE,     /* the ray's values, arg(n), noise, erf and rayinit */
    PM_LANGUAGE_GENERATOR, /* gensurf, genrev, genworm: mathematics, PI, hermite, bezier,
                              bspline */
};

/* NULL if memory is short. */
pm_language *pm_language_new(enum pm_language_kind kind);
void pm_language_free(pm_language *language);

/* The context of rayinit alone, which the file name "." means, and where generators define. */
enum { PM_CONTEXT_GLOBAL = 0 };

/* Reads a function file into a context of its name, as scenes name it ("dir/x.cal"); a name
 * that was read before gives its context again and reads nothing.
 *   text, size  the file's bytes; borrowed for the call
 *   context     out
 * Errors: PM_E_SYNTAX, PM_E_LIMIT, PM_E_RANGE (a constant that has no value), PM_E_MISSING (a
 * constant that names what is not there), PM_E_MEMORY, with file, line and column. The language
 * is then fit for pm_language_free only. Tests: test_parse.c, test_names.c. */
PM_MUST_USE pm_status pm_language_read(pm_language *language, const char *name,
                                       const char *text, size_t size, uint32_t *context,
                                       pm_error *err);

/* The context of a file that was read; false if it was not. */
bool pm_language_find(const pm_language *language, const char *name, uint32_t *context);

/* An expression, and where it stands for errors; file NULL and line 0 where there is no place.
 */
struct pm_language_text {
    const char *text;
    const char *file;
    int line, column;
};

/* Reads definitions into a context that is there: what generators take with -e and -f. */
PM_MUST_USE pm_status pm_language_define(pm_language *language, uint32_t context,
                                         const struct pm_language_text *text, size_t size,
                                         pm_error *err);

/* What a name means in a context. */
enum pm_language_meaning {
    PM_MEANS_NOTHING,
    PM_MEANS_VARIABLE,
    PM_MEANS_FUNCTION, /* *parameters: how many arguments it wants */
};
enum pm_language_meaning pm_language_meaning(const pm_language *language, uint32_t context,
                                             const char *name, unsigned *parameters);

/* Names a compiled function of a language. */
typedef uint32_t pm_function;

struct pm_function_request {
    uint32_t context;
    const struct pm_language_text *texts; /* one result each */
    unsigned text_count;                  /* 1 .. PM_LANGUAGE_TEXTS */
    /* 0: texts are expressions. Else each is the name of a function, which will be called with
     * so many arguments (brightdata's func, colorpict's, the generators'). */
    unsigned arg_count;
    /* Not NULL: the primitive's real arguments, known now: they are folded into the program and
     * one that is not there is an error. Where programs are very many they are read from the
     * ray all the same, so the ray has them too. */
    const double *reals;
    uint32_t real_count;
};

/* Compiles; equal requests give the same function, and variables that several texts share are
 * evaluated once. Errors as pm_language_read, at the place where something undefined is used;
 * the language stays as it was. Tests: test_compile.c, test_recursion.c, test_random.c. */
PM_MUST_USE pm_status pm_language_compile(pm_language *language,
                                          const struct pm_function_request *request,
                                          pm_function *out, pm_error *err);

/* A bit (1 << PM_RAY_..) for each value of the ray that the function can ask for. A pattern
 * that asks for one of PM_RAY_OF_MATERIALS is an error (undefined variable in Radiance). */
uint64_t pm_function_uses(const pm_language *language, pm_function function);
#define PM_RAY_OF_MATERIALS (((1ull << PM_RAY_DXA) - 1) & ~((1ull << PM_RAY_NXP) - 1))
#define PM_RAY_OF_PRISMS    (((1ull << PM_RAY_VALUES) - 1) & ~((1ull << PM_RAY_DXA) - 1))

/* All results of a function.
 *   ray     NULL for functions that use none
 *   args    [arg_count] of the request; NULL if 0
 *   values  out: [text_count], finite
 * Returns the faults, 0 if there were none; after PM_FAULT_DEPTH or PM_FAULT_WORK all values
 * are 0. At most 2.7 MiB of stack. Tests: test_evaluate.c, test_builtin.c, test_random.c. */
unsigned pm_function_values(const pm_language *language, pm_function function,
                            const struct pm_ray_values *ray, const double *args,
                            unsigned arg_count, double *values);

/* The same, and what it took of PM_LANGUAGE_WORK: for callers that have a budget. */
unsigned pm_function_values_counted(const pm_language *language, pm_function function,
                                    const struct pm_ray_values *ray, const double *args,
                                    unsigned arg_count, double *values, uint32_t *work);

/* The first result, faults being 0 inside it. */
double pm_function_value(const pm_language *language, pm_function function,
                         const struct pm_ray_values *ray, const double *args,
                         unsigned arg_count);

/* The text of a standard file ("skybright.cal"), or NULL if there is none of this name. Static.
 * Each agrees with Radiance's file of the name. Test: files_agree_with_radiance. */
const char *pm_language_standard(const char *name, size_t *size);

#endif
