#include "forward/forward.h"

#include <string.h>

#include "forward/forward_internal.h"

/* Raise it whenever a stored byte of any photon can change for the same scene and options. */
enum { FORMAT_VERSION = 9 };

/* What decides which surface a ray meets (world/rays.h): the tree has no say in it. */
static const char ray_kernel[] = "exact in double";

/* The digest's input, little-endian. */
struct canonical {
    uint8_t bytes[256];
    size_t size;
};

static void put_number(struct canonical *c, uint64_t value)
{
    for (int i = 0; i < 8; i++)
        c->bytes[c->size++] = (uint8_t)(value >> 8 * i);
}

/* Terminator included, so that neighbours cannot run into each other. */
static void put_text(struct canonical *c, const char *text)
{
    size_t size = strlen(text) + 1;
    memcpy(c->bytes + c->size, text, size);
    c->size += size;
}

pm_digest pm_forward_family(const pm_forward *forward, pm_map_kind kind)
{
    pm_digest scene = pm_world_hash(forward->world);
    struct canonical c = {.size = 0};
    put_text(&c, "photon family");
    put_number(&c, FORMAT_VERSION);
    memcpy(c.bytes + c.size, scene.bytes, sizeof scene.bytes);
    c.size += sizeof scene.bytes;
    put_text(&c, pm_map_kind_name(kind));
    memcpy(c.bytes + c.size, forward->choice.digest.bytes, sizeof forward->choice.digest.bytes);
    c.size += sizeof forward->choice.digest.bytes;
    put_number(&c, PM_BATCH_PATHS);
    put_number(&c, PM_REPLICATES);
    put_number(&c, PM_FORWARD_PREPASS_PATHS);
    put_number(&c, PM_FORWARD_PHOTONS_A_PATH);
    put_text(&c, ray_kernel);
    put_text(&c, forward->aim && kind == PM_MAP_CAUSTIC ? "aimed" : "unaimed");
    return pm_digest_of(c.bytes, c.size);
}
