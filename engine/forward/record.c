#include "forward/record.h"

#include <stdlib.h>

static pm_photon *buffer_append(struct pm_photon_buffer *buffer)
{
    if (buffer->count == buffer->capacity) {
        size_t capacity = buffer->capacity ? 2 * buffer->capacity : 4096;
        pm_photon *photons = realloc(buffer->photons, capacity * sizeof *photons);
        if (!photons)
            return NULL;
        buffer->photons = photons;
        buffer->capacity = capacity;
    }
    return &buffer->photons[buffer->count++];
}

/* A photon in the unit that it was packed in. */
struct packed {
    pm_photon photon;
    double scale; /* 0: not yet */
};

/* Dividing the flux by the storage probability is multiplying its unit with it. */
static void store(struct pm_recorder *recorder, int kind, const pm_photon_record *photon,
                  struct packed *packed)
{
    double scale = recorder->flux_scale * recorder->probability[kind];
    pm_photon *place = buffer_append(&recorder->buffer[kind]);
    if (scale != packed->scale)
        pm_photon_pack(photon, scale, &packed->photon);
    packed->scale = scale;
    if (place)
        *place = packed->photon;
    else
        recorder->out_of_memory = true;
}

static bool is_drawn(const struct pm_recorder *recorder, int kind, const pm_rng *draws)
{
    double probability = recorder->probability[kind], draw = 0;
    if (probability == 1)
        return true;
    pm_rng rng = *draws;
    for (int i = 0; i <= kind; i++)
        draw = pm_rng_uniform(&rng);
    return draw < probability;
}

void pm_record_deposit(struct pm_recorder *recorder, unsigned kinds, pm_photon_record *photon,
                       const pm_rng *draws)
{
    if (!pm_rgb_finite(photon->flux) || !pm_vec3_finite(photon->position)) {
        recorder->nonfinite++;
        return;
    }
    struct packed packed = {.scale = 0};
    photon->replicate = recorder->replicate;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        if (!(kinds & (1U << kind)))
            continue;
        recorder->deposits[kind]++;
        if (recorder->kinds & (1U << kind) && is_drawn(recorder, kind, draws))
            store(recorder, kind, photon, &packed);
    }
}
