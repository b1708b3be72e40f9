#include "files/bsdf.h"
#include "files/mesh.h"

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

pm_status pm_mesh_read(const void *data, size_t size, const char *name,
                       const pm_mesh_limits *limits, pm_mesh **out, pm_error *err)
{
    (void)data, (void)size, (void)limits, (void)out;
    PENDING(name, "meshes");
}

void pm_mesh_free(pm_mesh *mesh)
{
    (void)mesh;
}
