#include "photons/lanes_avx512.h"

#include "photons/kernel.h"

PM_KERNEL(avx512);
