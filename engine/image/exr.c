#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/image.h"
#include "image/notes.h"

/* The one file that knows OpenEXR (C API, OpenEXRCore). */

/* A file in memory and the first thing that went wrong with it. */
struct stream {
    pm_bytes file;       /* being written */
    const uint8_t *data; /* being read */
    size_t size;
    char reason[256];
};

static struct stream *stream_of(exr_const_context_t context)
{
    void *data = NULL;
    exr_get_user_data(context, &data);
    return data;
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *text)
{
    (void)code;
    struct stream *stream = context ? stream_of(context) : NULL;
    if (stream && !stream->reason[0])
        snprintf(stream->reason, sizeof stream->reason, "%s", text);
}

static int64_t on_write(exr_const_context_t context, void *user, const void *data,
                        uint64_t size, uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    struct stream *stream = user;
    pm_bytes *file = &stream->file;
    size_t end = (size_t)(offset + size);
    static const uint8_t zeros[4096] = {0};
    while (!file->failed && file->size < end) {
        size_t missing = end - file->size;
        pm_bytes_append(file, zeros, missing < sizeof zeros ? missing : sizeof zeros);
    }
    if (file->failed) {
        fail(context, EXR_ERR_OUT_OF_MEMORY, "no memory");
        return -1;
    }
    memcpy(file->data + offset, data, (size_t)size);
    return (int64_t)size;
}

static int64_t on_read(exr_const_context_t context, void *user, void *data, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    (void)context;
    (void)fail;
    const struct stream *stream = user;
    if (offset >= stream->size)
        return 0;
    uint64_t left = stream->size - offset;
    uint64_t taken = size < left ? size : left;
    memcpy(data, stream->data + offset, (size_t)taken);
    return (int64_t)taken;
}

static int64_t on_size(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const struct stream *)user)->size;
}

static exr_context_initializer_t initializer(struct stream *stream)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_error;
    init.user_data = stream;
    init.max_image_width = PM_IMAGE_SIDE_MAX;
    init.max_image_height = PM_IMAGE_SIDE_MAX;
    return init;
}

static pm_status fail_with(const struct stream *stream, exr_result_t code, pm_status status,
                           const char *name, pm_error *err)
{
    if (code == EXR_ERR_OUT_OF_MEMORY)
        status = PM_E_MEMORY;
    return pm_error_set_at(err, status, name, 0, 0, "OpenEXR: %s",
                           stream->reason[0] ? stream->reason
                                             : exr_get_error_code_as_string(code));
}

/* ---- writing ---- */

struct header {
    exr_context_t file;
    int part;
};

/* A channel of the file: every `stride`-th value from the first. */
struct source {
    char name[32];
    const float *values;
    unsigned stride;
};

struct sources {
    struct source list[3 + 3 * PM_IMAGE_LAYERS];
    int count;
};

static void add_sources(struct sources *sources, const char *layer, unsigned channels,
                        const float *values)
{
    static const char letters[] = "RGB";
    for (unsigned c = 0; c < channels; c++) {
        struct source *source = &sources->list[sources->count++];
        *source = (struct source){.values = values + c, .stride = channels};
        if (channels == 1)
            snprintf(source->name, sizeof source->name, "%s", layer);
        else
            snprintf(source->name, sizeof source->name, "%s%s%c", layer, *layer ? "." : "",
                     letters[c]);
    }
}

static struct sources sources_of(const pm_image *image)
{
    struct sources sources = {.count = 0};
    add_sources(&sources, "", 3, image->rgb);
    for (unsigned i = 0; i < image->layer_count; i++)
        add_sources(&sources, image->layers[i].name, image->layers[i].channels,
                    image->layers[i].values);
    return sources;
}

static pm_status put_attribute(void *context, const char *name, const char *value)
{
    const struct header *header = context;
    return exr_attr_set_string(header->file, header->part, name, value) ? PM_E_MEMORY : PM_OK;
}

static exr_result_t write_header(exr_context_t file, const pm_image *image,
                                 const struct sources *sources, const pm_image_notes *notes)
{
    struct header header = {.file = file};
    exr_set_longname_support(file, 1);
    exr_result_t rv = exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &header.part);
    if (!rv)
        rv = exr_initialize_required_attr_simple(file, header.part, (int32_t)image->width,
                                                 (int32_t)image->height, EXR_COMPRESSION_ZIP);
    for (int c = 0; !rv && c < sources->count; c++)
        rv = exr_add_channel(file, header.part, sources->list[c].name, EXR_PIXEL_FLOAT,
                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (!rv && pm_image_notes_each(notes, put_attribute, &header))
        rv = EXR_ERR_OUT_OF_MEMORY;
    return rv ? rv : exr_write_header(file);
}

static const struct source *source_named(const struct sources *sources, const char *name)
{
    int c = 0;
    while (strcmp(sources->list[c].name, name) != 0)
        c++; /* the pipeline knows none but these */
    return &sources->list[c];
}

/* Points the pipeline's channels into row y of the picture. */
static void set_sources(exr_encode_pipeline_t *pipe, const pm_image *image,
                        const struct sources *sources, int y)
{
    for (int16_t c = 0; c < pipe->channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipe->channels[c];
        const struct source *source = source_named(sources, channel->channel_name);
        size_t row = (size_t)source->stride * image->width;
        channel->user_bytes_per_element = sizeof *source->values;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = (int32_t)(source->stride * sizeof *source->values);
        channel->user_line_stride = (int32_t)(row * sizeof *source->values);
        channel->encode_from_ptr = (const uint8_t *)(source->values + row * (size_t)y);
    }
}

static exr_result_t write_chunk(exr_context_t file, exr_encode_pipeline_t *pipe,
                                const pm_image *image, const struct sources *sources, int y)
{
    exr_chunk_info_t chunk;
    exr_result_t rv = exr_write_scanline_chunk_info(file, 0, y, &chunk);
    if (!rv)
        rv = y ? exr_encoding_update(file, 0, &chunk, pipe)
               : exr_encoding_initialize(file, 0, &chunk, pipe);
    if (!rv)
        set_sources(pipe, image, sources, y);
    if (!rv && !y)
        rv = exr_encoding_choose_default_routines(file, 0, pipe);
    return rv ? rv : exr_encoding_run(file, 0, pipe);
}

static exr_result_t write_rows(exr_context_t file, const pm_image *image,
                               const struct sources *sources)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t rows = 0;
    exr_result_t rv = exr_get_scanlines_per_chunk(file, 0, &rows);
    for (uint32_t y = 0; !rv && y < image->height; y += (uint32_t)rows)
        rv = write_chunk(file, &pipe, image, sources, (int)y);
    exr_encoding_destroy(file, &pipe);
    return rv;
}

pm_status pm_image_write_exr(const pm_image *image, const pm_image_notes *notes, pm_bytes *out,
                             pm_error *err)
{
    pm_status st = pm_image_check(image, true, err);
    if (st)
        return st;
    struct stream stream = {0};
    struct sources sources = sources_of(image);
    exr_context_initializer_t init = initializer(&stream);
    init.write_fn = on_write;
    exr_context_t file = NULL;
    exr_result_t rv = exr_start_write(&file, "picture", EXR_WRITE_FILE_DIRECTLY, &init);
    if (!rv)
        rv = write_header(file, image, &sources, notes);
    if (!rv)
        rv = write_rows(file, image, &sources);
    exr_result_t finished = file ? exr_finish(&file) : EXR_ERR_SUCCESS;
    rv = rv ? rv : finished;
    st = rv ? fail_with(&stream, rv, PM_E_RANGE, "", err) : PM_OK;
    if (!st && !out->failed)
        pm_bytes_append(out, stream.file.data, stream.file.size);
    pm_bytes_clear(&stream.file);
    if (!st && pm_bytes_status(out))
        st = pm_error_set(err, PM_E_MEMORY, "no memory for an OpenEXR file");
    return st;
}

/* ---- reading ---- */

/* What is being read. */
struct reading {
    exr_context_t file;
    const char *name, *layer; /* layer "": the picture itself */
};

/* Which of the layer's channels that is, or -1. */
static int channel_index(const struct reading *reading, const char *name)
{
    static const char letters[] = "RGB";
    size_t length = strlen(reading->layer);
    if (strncmp(name, reading->layer, length) != 0)
        return -1;
    name += length;
    if (length && *name++ != '.')
        return -1;
    const char *letter = *name && !name[1] ? strchr(letters, *name) : NULL;
    return letter ? (int)(letter - letters) : -1;
}

static void set_targets(const struct reading *reading, exr_decode_pipeline_t *pipe,
                        const pm_image *image, uint32_t row)
{
    for (int16_t i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipe->channels[i];
        int c = channel_index(reading, channel->channel_name);
        channel->decode_to_ptr = NULL;
        if (c < 0 || !channel->height)
            continue;
        channel->user_bytes_per_element = sizeof *image->rgb;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 3 * (int32_t)sizeof *image->rgb;
        channel->user_line_stride = (int32_t)(3 * sizeof *image->rgb * image->width);
        channel->decode_to_ptr = (uint8_t *)(image->rgb + 3 * (size_t)row * image->width + c);
    }
}

static exr_result_t read_rows(const struct reading *reading, const pm_image *image, int first)
{
    exr_context_t file = reading->file;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t rows = 0;
    exr_result_t rv = exr_get_scanlines_per_chunk(file, 0, &rows);
    for (uint32_t row = 0; !rv && row < image->height; row += (uint32_t)rows) {
        exr_chunk_info_t chunk;
        rv = exr_read_scanline_chunk_info(file, 0, first + (int)row, &chunk);
        if (!rv)
            rv = row ? exr_decoding_update(file, 0, &chunk, &pipe)
                     : exr_decoding_initialize(file, 0, &chunk, &pipe);
        if (!rv)
            set_targets(reading, &pipe, image, row);
        if (!rv && !row)
            rv = exr_decoding_choose_default_routines(file, 0, &pipe);
        if (!rv)
            rv = exr_decoding_run(file, 0, &pipe);
    }
    exr_decoding_destroy(file, &pipe);
    return rv;
}

/* One scanline part with R, G and B at full resolution. */
static pm_status check_layout(const struct reading *reading, pm_error *err)
{
    exr_context_t file = reading->file;
    const char *name = reading->name;
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    const exr_attr_chlist_t *channels = NULL;
    int parts = 0, found = 0;
    if (exr_get_count(file, &parts) || exr_get_storage(file, 0, &storage) ||
        exr_get_channels(file, 0, &channels))
        return pm_error_set_at(err, PM_E_CORRUPT, name, 0, 0, "OpenEXR: no layout");
    if (parts != 1 || storage != EXR_STORAGE_SCANLINE)
        return pm_error_set_at(err, PM_E_UNSUPPORTED, name, 0, 0,
                               "an OpenEXR file of one part of scanlines is wanted");
    for (int i = 0; i < channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &channels->entries[i];
        if (channel_index(reading, entry->name.str) >= 0 && entry->x_sampling == 1 &&
            entry->y_sampling == 1)
            found++;
    }
    if (found != 3)
        return pm_error_set_at(err, PM_E_UNSUPPORTED, name, 0, 0,
                               "channels %s%sR, G and B of full resolution are wanted",
                               reading->layer, *reading->layer ? "." : "");
    return PM_OK;
}

static pm_status read_picture(const struct reading *reading, const struct stream *stream,
                              pm_image *image, pm_error *err)
{
    exr_context_t file = reading->file;
    const char *name = reading->name;
    pm_status st = check_layout(reading, err);
    if (st)
        return st;
    exr_attr_box2i_t window;
    exr_result_t rv = exr_get_data_window(file, 0, &window);
    if (rv)
        return fail_with(stream, rv, PM_E_CORRUPT, name, err);
    st = pm_image_init(image, (uint32_t)(window.max.x - window.min.x + 1),
                       (uint32_t)(window.max.y - window.min.y + 1));
    if (st)
        return pm_error_set_at(err, st, name, 0, 0, "the picture is too large");
    rv = read_rows(reading, image, window.min.y);
    return rv ? fail_with(stream, rv, PM_E_CORRUPT, name, err) : PM_OK;
}

pm_status pm_image_read_exr(const void *data, size_t size, const char *name, const char *layer,
                            pm_image *out, pm_error *err)
{
    struct stream stream = {.data = data, .size = size};
    exr_context_initializer_t init = initializer(&stream);
    init.read_fn = on_read;
    init.size_fn = on_size;
    exr_context_t file = NULL;
    pm_image image = {0};
    exr_result_t rv = exr_start_read(&file, name, &init);
    const struct reading reading = {file, name, layer ? layer : ""};
    pm_status st = rv ? fail_with(&stream, rv, PM_E_CORRUPT, name, err)
                      : read_picture(&reading, &stream, &image, err);
    if (file)
        exr_finish(&file);
    if (st) {
        pm_image_clear(&image);
        return st;
    }
    *out = image;
    return PM_OK;
}
