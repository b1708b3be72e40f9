#include "verbs.h"

#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "base/bytes.h"
#include "files/mesh.h"
#include "files/octree_file.h"
#include "output.h"
#include "scene/bundle.h"
#include "scene/scene.h"
#include "world/octree_write.h"

/* Octrees as Radiance's oconv makes them. Nothing is sent anywhere. */

enum { INPUTS_MAX = PM_OPERANDS_MAX + 1 };

struct conversion {
    const pm_options *options;
    pm_error *err;
    const char *paths[INPUTS_MAX], *names[INPUTS_MAX]; /* on the disk, in the bundle */
    size_t count;
    pm_bundle *bundle;
    pm_scene *scene;
    pm_arena arena;
    const char **files; /* that the octree names */
    uint32_t file_count;
    bool frozen;
    pm_bytes octree;
};

pm_status pm_check_oconv(const pm_options *options, pm_error *err)
{
    if (options->output_count > 1)
        return pm_error_set(err, PM_E_RANGE, "-o: one file is enough");
    if (options->oconv.input && options->oconv.bounded)
        return pm_error_set(err, PM_E_RANGE, "-b and -i exclude each other; give one");
    if (!options->operand_count && !options->oconv.input)
        return pm_error_set(err, PM_E_MISSING,
                            "a scene file is missing: pmclient oconv [OPTION...] FILE...");
    return options->output_count ? pm_output_check(options->outputs[0], err) : PM_OK;
}

static pm_status read_scene(struct conversion *c)
{
    static const char *const anywhere[] = {"/"};
    const pm_collect_options collect = {
        .search_path = getenv("RAYPATH"), .allowed = anywhere, .allowed_count = 1};
    pm_status st =
        pm_bundle_collect_files(c->paths, c->count, &collect, &c->bundle, c->names, c->err);
    return st ? st
              : pm_scene_parse_files(c->bundle, c->names, c->count, NULL, &c->scene, c->err);
}

static pm_status add_file(struct conversion *c, const char *name)
{
    if (c->file_count == PM_OCTREE_FILES)
        return pm_error_set(c->err, PM_E_LIMIT,
                            "an octree names %d scene files at most; freeze it (-f), or put "
                            "!xform lines for them into one file",
                            PM_OCTREE_FILES);
    c->files[c->file_count++] = name;
    return PM_OK;
}

/* The names to write: those of the octree that is started from, and those given. */
static pm_status list_files(struct conversion *c)
{
    pm_octree_file input;
    pm_status st = PM_OK;
    c->frozen = c->options->oconv.frozen;
    c->files = pm_arena_array(&c->arena, PM_OCTREE_FILES, sizeof *c->files);
    if (!c->files)
        return pm_error_set(c->err, PM_E_MEMORY, "no memory");
    for (size_t i = 0; !st && i < c->count; i++) {
        const pm_file *file = pm_bundle_find(c->bundle, c->names[i], NULL);
        if (!pm_octree_file_is(file->data, file->size)) {
            c->frozen = c->frozen || !strcmp(c->paths[i], "-");
            st = add_file(c, c->paths[i]);
            continue;
        }
        st = pm_octree_file_read(file->data, file->size, file->name, SIZE_MAX, &c->arena,
                                 &input, c->err);
        c->frozen = c->frozen || input.file_count == 0;
        for (uint32_t k = 0; !st && k < input.file_count; k++)
            st = add_file(c, input.files[k]);
    }
    return st;
}

static void warn(const struct conversion *c)
{
    for (size_t i = 0; !c->options->quiet && i < c->scene->prototype_count; i++) {
        const pm_mesh *mesh = c->scene->prototypes[i].mesh;
        if (mesh && !mesh->is_compiled) {
            fprintf(stderr, "pmclient: note: the scene places a Wavefront mesh, which Radiance "
                            "reads only when it is compiled (obj2mesh)\n");
            return;
        }
    }
}

static pm_status write_octree(struct conversion *c)
{
    const pm_oconv_option *o = &c->options->oconv;
    const pm_octree_options options = {.set_size = o->set_size,
                                       .resolution = o->resolution,
                                       .bounded = o->bounded,
                                       .corner = {o->corner[0], o->corner[1], o->corner[2]},
                                       .edge = o->edge,
                                       .frozen = c->frozen,
                                       .files = c->files,
                                       .file_count = c->file_count,
                                       .command = pm_command_line};
    pm_output output = {0};
    pm_status st = pm_octree_write(c->scene, c->bundle, &options, &c->octree, c->err);
    if (!st)
        st = pm_output_open(&output, c->options->output_count ? c->options->outputs[0] : "-",
                            c->err);
    if (st)
        return st;
    fwrite(c->octree.data, 1, c->octree.size, output.file);
    st = pm_output_commit(&output, c->err);
    pm_output_abandon(&output);
    return st;
}

static pm_status check_input(const struct conversion *c)
{
    for (size_t i = 0; i < c->count; i++) {
        const pm_file *file = pm_bundle_find(c->bundle, c->names[i], NULL);
        bool octree = pm_octree_file_is(file->data, file->size);
        bool wanted = c->options->oconv.input && i == 0;
        if (octree != wanted)
            return pm_error_set_at(c->err, PM_E_RANGE, c->paths[i], 0, 0,
                                   octree ? "is an octree; say -i before it"
                                          : "is no octree, as -i needs one");
    }
    return PM_OK;
}

pm_status pm_verb_oconv(const pm_options *options, pm_error *err)
{
    struct conversion c = {.options = options, .err = err};
    if (options->oconv.input)
        c.paths[c.count++] = options->oconv.input;
    for (unsigned i = 0; i < options->operand_count; i++)
        c.paths[c.count++] = options->operands[i];
    pm_status st = read_scene(&c);
    if (!st)
        st = check_input(&c);
    if (!st)
        st = list_files(&c);
    if (!st)
        warn(&c);
    if (!st)
        st = write_octree(&c);
    pm_bytes_clear(&c.octree);
    pm_arena_clear(&c.arena);
    pm_scene_free(c.scene);
    pm_bundle_free(c.bundle);
    return st;
}
