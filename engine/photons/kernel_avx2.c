#include "photons/lanes_avx2.h"

#include "photons/kernel.h"

PM_KERNEL(avx2);
