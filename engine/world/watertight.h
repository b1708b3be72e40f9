#ifndef PM_WORLD_WATERTIGHT_H
#define PM_WORLD_WATERTIGHT_H

#include "world/probe.h"

/* The sides of edges as a ray sees them. Woop, Benthin, Wald, "Watertight ray/triangle
 * intersection", JCGT 2(1), 2013: corners are sheared so that the ray is the z axis. Equal
 * corners become equal numbers and the sides of edges are exact, so no ray slips between
 * triangles that share an edge. */

/* x_a y_b - y_a x_b with the right sign: where the difference of the rounded products could
 * lie, their errors are added (Kahan; Jeannerod, Louvet, Muller, Math. Comp. 82, 2013). Exactly
 * antisymmetric in a and b. */
static inline double pm_edge(double xa, double ya, double xb, double yb)
{
    double p = xa * yb, q = ya * xb, e = p - q;
    if (fabs(e) <= 0x1p-51 * (fabs(p) + fabs(q)))
        e += fma(xa, yb, -p) - fma(ya, xb, -q);
    return e;
}

/* All on one side, or on the edge; not all on it: the triangle is then seen from its edge. */
static inline bool pm_edges_agree(double a, double b, double c)
{
    bool in = (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
    return in && (a != 0 || b != 0 || c != 0);
}

#endif
