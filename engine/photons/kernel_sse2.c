#include "photons/lanes_sse2.h"

#include "photons/kernel.h"

PM_KERNEL(sse2);
