#include "files/bsdf.h"

/* Readers on their way: whoever lands one takes its lines out here. */

#define PENDING(name, what)                                                                    \
    return pm_error_set_at(err, PM_E_UNSUPPORTED, name, 0, 0, "%s cannot be read", what)

pm_status pm_bsdf_read(const void *bytes, size_t size, const char *name, pm_bsdf **out,
                       pm_error *err)
{
    (void)bytes, (void)size, (void)out;
    PENDING(name, "BSDF files");
}

void pm_bsdf_free(pm_bsdf *bsdf)
{
    (void)bsdf;
}
