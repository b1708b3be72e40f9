#include "bench_embree.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include <embree3/rtcore.h>

struct bench_embree {
    RTCDevice device;
    RTCScene scene;
};

static void attach(bench_embree *e, const double (*triangles)[9], size_t count)
{
    RTCGeometry geometry = rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                             RTC_FORMAT_FLOAT3, 3 * sizeof *corners, 3 * count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                RTC_FORMAT_UINT3, 3 * sizeof *indices, count);
    for (size_t i = 0; i < 9 * count; i++)
        corners[i] = (float)triangles[i / 9][i % 9];
    for (size_t i = 0; i < 3 * count; i++)
        indices[i] = (uint32_t)i;
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(e->scene, geometry);
    rtcReleaseGeometry(geometry);
}

bench_embree *bench_embree_new(const double (*triangles)[9], size_t count)
{
    bench_embree *e = malloc(sizeof *e);
    if (!e)
        return NULL;
    e->device = rtcNewDevice("threads=1,start_threads=0,set_affinity=0");
    e->scene = rtcNewScene(e->device);
    rtcSetSceneFlags(e->scene, RTC_SCENE_FLAG_ROBUST);
    attach(e, triangles, count);
    rtcCommitScene(e->scene);
    return e;
}

void bench_embree_free(bench_embree *e)
{
    rtcReleaseScene(e->scene);
    rtcReleaseDevice(e->device);
    free(e);
}

double bench_embree_trace(bench_embree *e, pm_vec3 o, pm_vec3 d, pm_vec3 *normal)
{
    struct RTCIntersectContext context;
    struct RTCRayHit r = {.ray = {.org_x = (float)o.x,
                                  .org_y = (float)o.y,
                                  .org_z = (float)o.z,
                                  .dir_x = (float)d.x,
                                  .dir_y = (float)d.y,
                                  .dir_z = (float)d.z,
                                  .tnear = 1e-4F,
                                  .tfar = INFINITY,
                                  .mask = UINT32_MAX},
                          .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcInitIntersectContext(&context);
    rtcIntersect1(e->scene, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return -1;
    *normal = pm_vec3_normalize(
        (pm_vec3){(double)r.hit.Ng_x, (double)r.hit.Ng_y, (double)r.hit.Ng_z});
    return (double)r.ray.tfar;
}
