#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "files/font.h"
#include "language/language.h"
#include "scene/bundle.h"
#include "scene/named_files.h"
#include "scene/names.h"
#include "scene/path.h"

/* All files of a scene together. */
static const size_t limit_bytes = (size_t)1 << 30;

/* A file that was found, and what its name was asked for (named_files.h). */
struct found {
    pm_file file;
    char role;
};

/* Names for one message. */
struct list {
    char text[240];
    size_t count;
};

struct collector {
    pm_bundle *bundle;
    pm_error *err;
    struct found *queue; /* every file once, in the order of their finding */
    size_t queue_length, queue_capacity;
    char **folders; /* whose files may be taken, resolved; the main file's first */
    char **search;  /* folders to look in, resolved */
    size_t folder_count, search_count;
    size_t bytes; /* collected so far */
    struct list missing, outside;
    pm_names found; /* that the file in hand names, and their roles */
    pm_arena arena; /* of those */
};

static pm_status memory_error(struct collector *c)
{
    return pm_error_set(c->err, PM_E_MEMORY, "not enough memory for the files of a scene");
}

static pm_status io_error(struct collector *c, const char *path)
{
    if (errno == ENOMEM)
        return memory_error(c);
    return pm_error_set(c->err, errno == ENOENT ? PM_E_MISSING : PM_E_IO,
                        "cannot read '%.300s': %s", path, strerror(errno));
}

static pm_status too_large(struct collector *c, const char *path)
{
    return pm_error_set(
        c->err, PM_E_LIMIT,
        "'%.300s' makes the scene larger than %zu MiB, which is the limit of its "
        "files together",
        path, limit_bytes >> 20);
}

/* Reads to the end, whatever the size was said to be. */
static pm_status read_all(struct collector *c, int fd, const char *path, pm_bytes *out)
{
    static const size_t chunk = (size_t)1 << 16;
    char *buffer = malloc(chunk);
    if (!buffer)
        return memory_error(c);
    pm_status st = PM_OK;
    for (;;) {
        ssize_t got = read(fd, buffer, chunk);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            st = io_error(c, path);
        else
            pm_bytes_append(out, buffer, (size_t)got);
        if (!st && out->size > limit_bytes - c->bytes)
            st = too_large(c, path);
        if (!st && pm_bytes_status(out))
            st = memory_error(c);
        if (st || got == 0)
            break;
    }
    free(buffer);
    return st;
}

static pm_status folder_error(struct collector *c, const char *path)
{
    return pm_error_set(c->err, PM_E_IO, "'%.300s' is a folder; name a file", path);
}

static pm_status enqueue(struct collector *c, const pm_file *file, char role)
{
    if (c->queue_length == c->queue_capacity) {
        size_t capacity = c->queue_capacity ? 2 * c->queue_capacity : 8;
        struct found *queue = realloc(c->queue, capacity * sizeof *queue);
        if (!queue)
            return memory_error(c);
        c->queue = queue;
        c->queue_capacity = capacity;
    }
    c->queue[c->queue_length++] = (struct found){*file, role};
    return PM_OK;
}

/* Reads the open file into the bundle. Takes the descriptor, unless it is standard input. */
static pm_status add_open_file(struct collector *c, int fd, const char *path, const char *name,
                               char role)
{
    struct stat info;
    pm_bytes data = {0};
    pm_status st = fstat(fd, &info) ? io_error(c, path) : PM_OK;
    if (!st && S_ISDIR(info.st_mode))
        st = folder_error(c, path);
    if (!st)
        st = read_all(c, fd, path, &data);
    if (!st)
        st = pm_bundle_add(c->bundle, name, data.data, data.size, c->err);
    if (!st)
        st = enqueue(c, pm_bundle_find(c->bundle, name, NULL), role);
    c->bytes += data.size;
    pm_bytes_clear(&data);
    if (fd != STDIN_FILENO)
        close(fd);
    return st;
}

/* ---- where files are ---- */

/* True if the path, links resolved, lies in a folder whose files may be taken. */
static bool may_take(const struct collector *c, const char *path)
{
    for (size_t i = 0; i < c->folder_count; i++) {
        size_t length = strlen(c->folders[i]);
        if (strncmp(path, c->folders[i], length) == 0 && path[length] == '/')
            return true;
    }
    return false;
}

/* A place where a name may lie: a path on the disk, and its name in the bundle. */
struct place {
    char path[PATH_MAX];
    char name[PM_PATH_SIZE];
};

/* Place `index` of the name; false for places where it cannot be. *last is set behind the last.
 */
static bool place_of(const struct collector *c, const char *name, const char *from,
                     size_t index, struct place *out, bool *last)
{
    const char *main_folder = c->folders[0];
    *last = index >= 2 + c->search_count;
    if (*last)
        return false;
    if (index < 2)
        return pm_path_join(index == 0 ? from : NULL, name, out->name) &&
               pm_path_in_folder(main_folder, out->name, out->path, sizeof out->path);
    int length = snprintf(out->path, sizeof out->path, "%s/%s", c->search[index - 2], name);
    return name[0] != '/' && (size_t)length < sizeof out->path &&
           pm_path_join(NULL, name, out->name);
}

static void note(struct list *list, const pm_word *word, const char *from)
{
    char text[300], place[32] = ""; /* two ints */
    if (word->line)
        snprintf(place, sizeof place, ":%d:%d", word->line, word->column);
    snprintf(text, sizeof text, "%s'%.*s' (%.150s%s)", list->count ? ", " : "",
             PM_WORD_SHOW(*word), from, place);
    if (strlen(list->text) + strlen(text) < sizeof list->text - sizeof ", ...")
        strcat(list->text, text);
    else if (!strstr(list->text, ", ..."))
        strcat(list->text, ", ...");
    list->count++;
}

/* Takes the file at a place that is there. */
static pm_status take(struct collector *c, const struct place *place, const char *resolved,
                      const pm_file *from, const pm_word *word, char role)
{
    if (pm_bundle_find(c->bundle, place->name, NULL))
        return PM_OK;
    if (!may_take(c, resolved)) {
        note(&c->outside, word, from->name);
        return PM_OK;
    }
    struct stat info; /* a pipe would be waited for without end */
    if (!stat(resolved, &info) && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode))
        return pm_error_set(c->err, PM_E_IO,
                            "'%.300s' is a pipe or a device; a scene names files", place->name);
    int fd = open(resolved, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    return fd < 0 ? io_error(c, place->path)
                  : add_open_file(c, fd, place->path, place->name, role);
}

/* A file may name another a million times: the disk is asked once. */
static pm_status note_found(struct collector *c, const pm_word *word, char role)
{
    return pm_names_set(&c->found, word, role) ? memory_error(c) : PM_OK;
}

/* The file goes into the bundle under the name by which the parser will look for it first. */
static pm_status add_named(void *context, const pm_file *from, const pm_word *word, char role)
{
    struct collector *c = context;
    struct place place;
    bool last = false;
    size_t size;
    if (pm_names_find(&c->found, word) == role)
        return PM_OK;
    for (size_t i = 0; !last; i++) {
        if (!place_of(c, word->text, from->name, i, &place, &last))
            continue;
        char *resolved = realpath(place.path, NULL);
        if (!resolved && errno == ENOMEM)
            return memory_error(c);
        if (!resolved)
            continue;
        pm_status st = take(c, &place, resolved, from, word, role);
        free(resolved);
        return st || !pm_bundle_find(c->bundle, place.name, NULL) ? st
                                                                  : note_found(c, word, role);
    }
    bool standard = (role == 'c' && pm_language_standard(word->text, &size)) ||
                    (role == 't' && pm_font_standard(word->text, &size));
    if (!standard && role != '?')
        note(&c->missing, word, from->name);
    return PM_OK;
}

static pm_status add_all_named(struct collector *c)
{
    pm_status st = PM_OK;
    for (size_t i = 0; !st && i < c->queue_length; i++) {
        const struct found found = c->queue[i]; /* the queue moves as it grows */
        pm_arena_clear(&c->arena);
        c->found = (pm_names){.arena = &c->arena};
        st = pm_named_files_visit(&found.file, found.role, add_named, c);
        if (st == PM_E_MEMORY)
            return memory_error(c);
    }
    return st;
}

/* ---- folders ---- */

/* `shown` in a message, if the folder is not there. */
static pm_status add_folder(struct collector *c, const char *path, const char *shown,
                            char ***list, size_t *count)
{
    char *resolved = realpath(path, NULL);
    if (!resolved)
        return io_error(c, shown);
    if (strcmp(resolved, "/") == 0)
        resolved[0] = '\0';
    char **more = realloc(*list, (*count + 1) * sizeof *more);
    if (!more) {
        free(resolved);
        return memory_error(c);
    }
    *list = more;
    more[(*count)++] = resolved;
    return PM_OK;
}

static pm_status add_main_folder(struct collector *c, const char *path)
{
    const char *slash = strrchr(path, '/');
    char *folder =
        slash ? strndup(path, slash == path ? 1 : (size_t)(slash - path)) : strdup(".");
    pm_status st =
        folder ? add_folder(c, folder, path, &c->folders, &c->folder_count) : memory_error(c);
    free(folder);
    return st;
}

/* Folders of the search path that are not there are passed over, as in Radiance. */
static pm_status add_search_path(struct collector *c, const char *path)
{
    char *copy = strdup(path), *rest = copy;
    pm_status st = copy ? PM_OK : memory_error(c);
    for (char *folder; !st && (folder = strsep(&rest, ":"));) {
        if (!*folder || access(folder, X_OK))
            continue;
        st = add_folder(c, folder, folder, &c->search, &c->search_count);
        if (!st)
            st = add_folder(c, folder, folder, &c->folders, &c->folder_count);
    }
    free(copy);
    return st;
}

static pm_status add_folders(struct collector *c, const char *path,
                             const pm_collect_options *options)
{
    static const char radiance[] = "/usr/local/lib/ray:/usr/share/radiance/lib";
    pm_status st = add_main_folder(c, path);
    if (!st)
        st = add_folder(c, ".", ".", &c->search, &c->search_count);
    if (!st)
        st = add_search_path(c,
                             options && options->search_path ? options->search_path : radiance);
    for (size_t i = 0; !st && options && i < options->allowed_count; i++)
        st = add_folder(c, options->allowed[i], options->allowed[i], &c->folders,
                        &c->folder_count);
    return st;
}

static void free_folders(char **list, size_t count)
{
    for (size_t i = 0; i < count; i++)
        free(list[i]);
    free(list);
}

/* ---- the scene ---- */

static const char *plural(size_t count)
{
    return count > 1 ? "s" : "";
}

static pm_status tell_absent(struct collector *c)
{
    const struct list *missing = &c->missing, *outside = &c->outside;
    char text[1000] = "";
    size_t used = 0;
    if (missing->count)
        used = (size_t)snprintf(
            text, sizeof text,
            "%zu file%s of the scene not found beside the file that names %s, in the main "
            "file's folder, in the current one nor in RAYPATH: %s",
            missing->count, plural(missing->count), missing->count > 1 ? "them" : "it",
            missing->text);
    if (outside->count)
        snprintf(text + used, sizeof text - used,
                 "%s%zu file%s outside the scene's folder and RAYPATH, not sent; add --allow "
                 "with %s folder to send %s: %s",
                 used ? "; " : "", outside->count, plural(outside->count),
                 outside->count > 1 ? "their" : "its", outside->count > 1 ? "them" : "it",
                 outside->text);
    if (!text[0])
        return PM_OK;
    return pm_error_set(c->err, PM_E_MISSING, "%s", text);
}

/* The main file's name in the bundle: its base name, or, of several, where it lies as seen from
 * the current folder. */
static pm_status name_main(struct collector *c, const char *path, size_t count,
                           char out[PM_PATH_SIZE])
{
    const char *slash = strrchr(path, '/');
    const char *name = strcmp(path, "-") == 0 ? "stdin.rad"
                       : count == 1 && slash  ? slash + 1
                                              : path;
    struct stat info;
    if (pm_path_join(NULL, name, out))
        return PM_OK;
    if (!stat(path, &info) && S_ISDIR(info.st_mode))
        return folder_error(c, path);
    return pm_error_set(c->err, PM_E_RANGE,
                        "'%.200s' cannot be the name of a scene's file; give a shorter one, "
                        "relative to the current folder",
                        path);
}

static pm_status add_main(struct collector *c, const char *path, size_t count)
{
    char name[PM_PATH_SIZE];
    pm_status st = name_main(c, path, count, name);
    if (st || pm_bundle_find(c->bundle, name, NULL))
        return st;
    int fd = strcmp(path, "-") == 0 ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC);
    return fd < 0 ? io_error(c, path) : add_open_file(c, fd, path, name, 'r');
}

static pm_status collect(struct collector *c, const char *const *paths, size_t count,
                         const pm_collect_options *options)
{
    bool here = count > 1 || strcmp(paths[0], "-") == 0;
    pm_status st = add_folders(c, here ? "./" : paths[0], options);
    for (size_t i = 0; !st && i < count; i++)
        st = add_main(c, paths[i], count);
    if (!st)
        st = add_all_named(c);
    return st ? st : tell_absent(c);
}

pm_status pm_bundle_collect_files(const char *const *paths, size_t count,
                                  const pm_collect_options *options, pm_bundle **out,
                                  const char **names, pm_error *err)
{
    struct collector c = {.bundle = pm_bundle_new(), .err = err};
    pm_status st = c.bundle ? collect(&c, paths, count, options) : memory_error(&c);
    for (size_t i = 0; !st && i < count; i++) {
        char name[PM_PATH_SIZE];
        st = name_main(&c, paths[i], count, name);
        if (!st)
            names[i] = pm_bundle_find(c.bundle, name, NULL)->name;
    }
    free_folders(c.folders, c.folder_count);
    free_folders(c.search, c.search_count);
    free(c.queue);
    pm_arena_clear(&c.arena);
    if (st)
        pm_bundle_free(c.bundle);
    else
        *out = c.bundle;
    return st;
}

pm_status pm_bundle_collect(const char *path, const pm_collect_options *options,
                            pm_bundle **out, const char **main_name, pm_error *err)
{
    return pm_bundle_collect_files(&path, 1, options, out, main_name, err);
}
