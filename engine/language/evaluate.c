/* Runs programs. What is constant or asked for once costs a step through one switch; variables
 * are evaluated at most once and arguments when they are first asked for, as in Radiance, so a
 * branch that is not taken costs and faults nothing. */
#include "language/language_internal.h"

#include <math.h>

#include "base/maths.h"
#include "language/noise.h"

/* One call: its arguments belong to the frame of the caller. */
struct frame {
    const struct frame *caller;
    const struct pm_definition *definition; /* of the function that is called */
    const uint32_t *args;                   /* operations, evaluated in the caller's frame */
    double *value;
    uint64_t done; /* a bit for each argument that has its value */
};

struct machine {
    const struct pm_code *code;
    const struct pm_op *ops;
    const double *ray;
    const double *reals;
    uint32_t real_count;
    int32_t depth; /* left */
    int32_t work;  /* left */
    double *variable;
    uint64_t *known; /* a bit for each variable that has its value */
    double noise_at[3], noise_value;
    bool noise_known;
    struct pm_run run;
};

static double run(struct machine *m, uint32_t at, struct frame *frame);

/* Leaves without a call. */
static inline double operand(struct machine *m, uint32_t at, struct frame *frame)
{
    const struct pm_op *op = m->ops + at;
    if (op->code == PM_OP_NUMBER)
        return op->number;
    if (op->code == PM_OP_RAY)
        return m->ray[op->a];
    return run(m, at, frame);
}

static double fault(struct machine *m, enum pm_function_fault kind)
{
    m->run.faults |= kind;
    return 0;
}

/* Takes depth for `height` more nested nodes, and work. False stops the evaluation. */
static bool enter(struct machine *m, unsigned height, uint32_t cost,
                  const struct pm_definition *definition)
{
    int32_t need = (int32_t)height + 3;
    if (m->work > 0 && m->depth >= need) {
        m->depth -= need;
        m->work -= (int32_t)cost;
        return true;
    }
    if (!(m->run.faults & (PM_FAULT_DEPTH | PM_FAULT_WORK))) {
        m->run.recursion = definition;
        m->run.faults |= m->work > 0 ? PM_FAULT_DEPTH : PM_FAULT_WORK;
    }
    m->work = 0; /* what is still open ends at once */
    return false;
}

static void leave(struct machine *m, unsigned height)
{
    m->depth += (int32_t)height + 3;
}

static double variable(struct machine *m, uint32_t number)
{
    const struct pm_variable *v = m->code->variables + number;
    uint64_t bit = 1ull << (number & 63);
    if (m->known[number >> 6] & bit)
        return m->variable[number];
    if (!enter(m, v->height, v->cost, v->definition))
        return 0;
    double value = run(m, v->body, NULL);
    leave(m, v->height);
    m->known[number >> 6] |= bit;
    m->variable[number] = value;
    return value;
}

static double argument(struct machine *m, uint32_t i, struct frame *frame)
{
    if (frame->done & 1ull << i)
        return frame->value[i];
    uint32_t at = frame->args[i];
    unsigned height = m->ops[at].height;
    if (!enter(m, height, 1, frame->definition))
        return 0;
    double value = run(m, at, (struct frame *)frame->caller);
    leave(m, height);
    frame->done |= 1ull << i;
    frame->value[i] = value;
    return value;
}

static double call_in(struct machine *m, const struct pm_op *op, struct frame *caller,
                      double *values)
{
    const struct pm_routine *routine = m->code->routines + op->a;
    struct frame frame = {caller, routine->definition, m->code->lists + op->b, values, 0};
    if (!enter(m, routine->height, routine->cost, routine->definition))
        return 0;
    double value = run(m, routine->body, &frame);
    leave(m, routine->height);
    return value;
}

static __attribute__((noinline)) double call_few(struct machine *m, const struct pm_op *op,
                                                 struct frame *caller)
{
    double values[6];
    return call_in(m, op, caller, values);
}

/* Rare, and its frame is larger: counted as several levels. */
static __attribute__((noinline)) double call_many(struct machine *m, const struct pm_op *op,
                                                  struct frame *caller)
{
    double values[PM_LANGUAGE_PARAMETERS];
    if (!enter(m, 8, 1, m->code->routines[op->a].definition))
        return 0;
    double value = call_in(m, op, caller, values);
    leave(m, 8);
    return value;
}

static double divide(struct machine *m, double a, double b)
{
    return b == 0 ? fault(m, PM_FAULT_DIVISION) : a / b;
}

/* What a library function gave, or 0 and a fault (calfunc.c's libfunc, calexpr.c's epow). */
static double checked(struct machine *m, double value)
{
    if (isfinite(value))
        return value;
    return fault(m, isnan(value) ? PM_FAULT_DOMAIN : PM_FAULT_RANGE);
}

static double sum(struct machine *m, const struct pm_op *op, struct frame *frame)
{
    const uint32_t *list = m->code->lists + op->b;
    double total = operand(m, list[0] >> 1, frame);
    for (uint32_t i = 1; i < op->c; i++) {
        double term = operand(m, list[i] >> 1, frame);
        total = list[i] & 1 ? total - term : total + term;
    }
    return total;
}

static double product(struct machine *m, const struct pm_op *op, struct frame *frame)
{
    const uint32_t *list = m->code->lists + op->b;
    double total = operand(m, list[0] >> 1, frame);
    for (uint32_t i = 1; i < op->c; i++) {
        double factor = operand(m, list[i] >> 1, frame);
        total = list[i] & 1 ? divide(m, total, factor) : total * factor;
    }
    return total;
}

static double least_or_most(struct machine *m, const struct pm_op *op, struct frame *frame)
{
    const uint32_t *list = m->code->lists + op->b;
    double best = operand(m, list[0], frame);
    for (uint32_t i = 1; i < op->c; i++) {
        double value = operand(m, list[i], frame);
        if (op->code == PM_OP_MIN ? value < best : value > best)
            best = value;
    }
    return best;
}

/* The list's entry that select chooses, 0 for none and UINT32_MAX for their number. */
static uint32_t selected(struct machine *m, const struct pm_op *op, struct frame *frame)
{
    double which = operand(m, m->code->lists[op->b], frame);
    if (!(which >= -.5) || !(which + .5 < op->c)) {
        fault(m, PM_FAULT_DOMAIN);
        return 0;
    }
    uint32_t n = (uint32_t)(which + .5);
    return n ? n : UINT32_MAX;
}

/* Source: calfunc.c, l_rand. */
static double random_of(double x)
{
    x *= 1 / (1 + x * x) + 2.71828182845904;
    x += .785398163397447 - floor(x);
    x = 1e5 / x;
    return x - floor(x);
}

static double function(struct machine *m, enum pm_op_code code, double x)
{
    switch (code) {
    case PM_OP_SQUARE:
        return checked(m, x * x);
    case PM_OP_SQRT:
        return checked(m, sqrt(x));
    case PM_OP_SIN:
        return checked(m, pm_sin(x));
    case PM_OP_COS:
        return checked(m, pm_cos(x));
    case PM_OP_TAN:
        return checked(m, pm_tan(x));
    case PM_OP_ASIN:
        return checked(m, pm_asin(x));
    case PM_OP_ACOS:
        return checked(m, pm_acos(x));
    case PM_OP_ATAN:
        return checked(m, pm_atan(x));
    case PM_OP_EXP:
        return checked(m, pm_exp(x));
    case PM_OP_LOG:
        return checked(m, pm_log(x));
    case PM_OP_LOG10:
        return checked(m, pm_log10(x));
    case PM_OP_FLOOR:
        return checked(m, floor(x));
    case PM_OP_CEIL:
        return checked(m, ceil(x));
    case PM_OP_RAND:
        return checked(m, random_of(x));
    case PM_OP_ERF:
        return checked(m, pm_erf(x));
    case PM_OP_ERFC:
        return checked(m, pm_erfc(x));
    default:
        return fault(m, PM_FAULT_DOMAIN);
    }
}

static double real_at(struct machine *m, double which)
{
    if (!(which + .5 >= 1))
        return m->real_count;
    if (which + .5 >= (double)m->real_count + 1)
        return fault(m, PM_FAULT_REAL);
    return m->reals[(uint32_t)(which + .5) - 1];
}

/* noise3 and its derivatives are often asked for together. */
static double noise(struct machine *m, enum pm_op_code code, const double at[3])
{
    if (code == PM_OP_FNOISE3)
        return pm_noise_fractal(at[0], at[1], at[2]);
    if (!m->noise_known || at[0] != m->noise_at[0] || at[1] != m->noise_at[1] ||
        at[2] != m->noise_at[2]) {
        for (int i = 0; i < 3; i++)
            m->noise_at[i] = at[i];
        m->noise_value = pm_noise(at[0], at[1], at[2]);
        m->noise_known = true;
    }
    double value = m->noise_value, step = PM_NOISE_STEP;
    switch (code) {
    case PM_OP_NOISE3X:
        return (value - pm_noise(at[0] - step, at[1], at[2])) / step;
    case PM_OP_NOISE3Y:
        return (value - pm_noise(at[0], at[1] - step, at[2])) / step;
    case PM_OP_NOISE3Z:
        return (value - pm_noise(at[0], at[1], at[2] - step)) / step;
    default:
        return value;
    }
}

static double missing(struct machine *m, const struct pm_op *op)
{
    if (!m->run.missing)
        m->run.missing = op->node;
    return fault(m, PM_FAULT_REAL);
}

static double run(struct machine *m, uint32_t at, struct frame *frame)
{
    double a, b, point[3];
    for (;;) {
        const struct pm_op *op = m->ops + at;
        switch ((enum pm_op_code)op->code) {
        case PM_OP_NUMBER:
            return op->number;
        case PM_OP_RAY:
            return m->ray[op->a];
        case PM_OP_ARG:
            return argument(m, op->a, frame);
        case PM_OP_VARIABLE:
            return variable(m, op->a);
        case PM_OP_CALL:
            return op->c <= 6 ? call_few(m, op, frame) : call_many(m, op, frame);
        case PM_OP_REAL:
            return op->a < m->real_count ? m->reals[op->a] : fault(m, PM_FAULT_REAL);
        case PM_OP_REAL_COUNT:
            return m->real_count;
        case PM_OP_REAL_AT:
            return real_at(m, operand(m, op->a, frame));
        case PM_OP_MISSING:
            return missing(m, op);
        case PM_OP_NEGATE:
            return -operand(m, op->a, frame);
        case PM_OP_ADD:
            a = operand(m, op->a, frame);
            return a + operand(m, op->b, frame);
        case PM_OP_SUBTRACT:
            a = operand(m, op->a, frame);
            return a - operand(m, op->b, frame);
        case PM_OP_MULTIPLY:
            a = operand(m, op->a, frame);
            return a * operand(m, op->b, frame);
        case PM_OP_DIVIDE:
            a = operand(m, op->a, frame);
            return divide(m, a, operand(m, op->b, frame));
        case PM_OP_POWER:
            a = operand(m, op->a, frame);
            b = operand(m, op->b, frame);
            return checked(m, pm_pow(a, b));
        case PM_OP_SUM:
            return sum(m, op, frame);
        case PM_OP_PRODUCT:
            return product(m, op, frame);
        case PM_OP_IF:
            at = operand(m, op->a, frame) > 0 ? op->b : op->c;
            continue;
        case PM_OP_SELECT:
            at = selected(m, op, frame);
            if (at == 0 || at == UINT32_MAX)
                return at ? op->c - 1 : 0;
            at = m->code->lists[op->b + at];
            continue;
        case PM_OP_MIN:
        case PM_OP_MAX:
            return least_or_most(m, op, frame);
        case PM_OP_ATAN2:
            a = operand(m, op->a, frame);
            b = operand(m, op->b, frame);
            return checked(m, pm_atan2(a, b));
        case PM_OP_NOISE3:
        case PM_OP_NOISE3X:
        case PM_OP_NOISE3Y:
        case PM_OP_NOISE3Z:
        case PM_OP_FNOISE3:
            point[0] = operand(m, op->a, frame);
            point[1] = operand(m, op->b, frame);
            point[2] = operand(m, op->c, frame);
            return noise(m, op->code, point);
        default:
            return function(m, op->code, operand(m, op->a, frame));
        }
    }
}

static void run_roots(struct machine *m, const uint32_t *roots, unsigned root_count,
                      const double *args, double *values)
{
    struct frame frame = {NULL, NULL, NULL, (double *)args, UINT64_MAX};
    for (unsigned i = 0; i < root_count; i++) {
        double value = run(m, roots[i], &frame);
        values[i] = isfinite(value) ? value : fault(m, PM_FAULT_RANGE);
    }
    if (m->run.faults & (PM_FAULT_DEPTH | PM_FAULT_WORK))
        for (unsigned i = 0; i < root_count; i++)
            values[i] = 0;
}

enum { FEW = 64 };

static __attribute__((noinline)) void run_with_many(struct machine *m, const uint32_t *roots,
                                                    unsigned root_count, const double *args,
                                                    double *values)
{
    double variables[PM_LANGUAGE_VARIABLES];
    uint64_t known[PM_LANGUAGE_VARIABLES / 64];
    for (uint32_t i = 0; i < (m->code->variable_count + 63) / 64; i++)
        known[i] = 0;
    m->variable = variables;
    m->known = known;
    run_roots(m, roots, root_count, args, values);
}

static const struct pm_ray_values no_ray;

void pm_code_run(const struct pm_code *code, const uint32_t *roots, unsigned root_count,
                 const struct pm_ray_values *ray, const double *args, double *values,
                 struct pm_run *out)
{
    double variables[FEW];
    uint64_t known[FEW / 64] = {0};
    struct machine m;
    ray = ray ? ray : &no_ray;
    m.code = code;
    m.ops = code->ops;
    m.ray = ray->value;
    m.reals = code->own_reals ? code->reals : ray->reals;
    m.real_count = code->own_reals ? code->real_count : ray->real_count;
    m.depth = PM_LANGUAGE_DEPTH;
    m.work = PM_LANGUAGE_WORK;
    m.variable = variables;
    m.known = known;
    m.noise_known = false;
    m.run = (struct pm_run){0};
    if (code->variable_count <= FEW)
        run_roots(&m, roots, root_count, args, values);
    else
        run_with_many(&m, roots, root_count, args, values);
    m.run.work = (uint32_t)(PM_LANGUAGE_WORK - m.work);
    *out = m.run;
}

unsigned pm_function_values_counted(const pm_language *language, pm_function function,
                                    const struct pm_ray_values *ray, const double *args,
                                    unsigned arg_count, double *values, uint32_t *work)
{
    const struct pm_program *program = language->programs[function];
    struct pm_run result;
    (void)arg_count; /* of the request, at least */
    pm_code_run(&program->code, program->roots, program->root_count, ray, args, values,
                &result);
    *work = result.work;
    return result.faults;
}

unsigned pm_function_values(const pm_language *language, pm_function function,
                            const struct pm_ray_values *ray, const double *args,
                            unsigned arg_count, double *values)
{
    uint32_t work;
    return pm_function_values_counted(language, function, ray, args, arg_count, values, &work);
}

double pm_function_value(const pm_language *language, pm_function function,
                         const struct pm_ray_values *ray, const double *args,
                         unsigned arg_count)
{
    double values[PM_LANGUAGE_TEXTS];
    pm_function_values(language, function, ray, args, arg_count, values);
    return values[0];
}
