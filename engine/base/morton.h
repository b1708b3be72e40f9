#ifndef PM_BASE_MORTON_H
#define PM_BASE_MORTON_H

#include <stdint.h>

/* The low 21 bits of v, two zeros between each and the next. */
static inline uint64_t pm_morton_spread(uint64_t v)
{
    v &= 0x1FFFFF;
    v = (v | v << 32) & 0x001F00000000FFFF;
    v = (v | v << 16) & 0x001F0000FF0000FF;
    v = (v | v << 8) & 0x100F00F00F00F00F;
    v = (v | v << 4) & 0x10C30C30C30C30C3;
    v = (v | v << 2) & 0x1249249249249249;
    return v;
}

/* Of a coordinate in [-1, 1], 21 bits; of one beyond, the end's. */
static inline uint64_t pm_morton_coordinate(double x)
{
    double cell = (x + 1) * 0x1p20;
    return cell > 0 ? cell < 0x1FFFFF ? (uint64_t)cell : 0x1FFFFF : 0;
}

/* Morton code of a point in [-1, 1]^3: neighbours in space are mostly neighbours by code. */
static inline uint64_t pm_morton_code(double x, double y, double z)
{
    return pm_morton_spread(pm_morton_coordinate(x)) |
           pm_morton_spread(pm_morton_coordinate(y)) << 1 |
           pm_morton_spread(pm_morton_coordinate(z)) << 2;
}

#endif
