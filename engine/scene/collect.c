#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/arena.h"
#include "scene/bundle.h"
#include "scene/path.h"
#include "scene/statement.h"
#include "scene/xform.h"

/* All files of a scene together. */
static const size_t limit_bytes = (size_t)1 << 30;

struct collector {
    pm_bundle *bundle;
    pm_error *err;
    pm_file
        *queue; /* every file once, in the order of their finding; borrowed from the bundle */
    size_t queue_length, queue_capacity;
    char *folder; /* of the main file, resolved, without a '/' at its end */
    size_t bytes; /* collected so far */
    char missing[512];
    size_t missing_count;
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

static pm_status enqueue(struct collector *c, const pm_file *file)
{
    if (c->queue_length == c->queue_capacity) {
        size_t capacity = c->queue_capacity ? 2 * c->queue_capacity : 8;
        pm_file *queue = realloc(c->queue, capacity * sizeof *queue);
        if (!queue)
            return memory_error(c);
        c->queue = queue;
        c->queue_capacity = capacity;
    }
    c->queue[c->queue_length++] = *file;
    return PM_OK;
}

/* Reads the open file into the bundle. Takes the descriptor, unless it is standard input. */
static pm_status add_open_file(struct collector *c, int fd, const char *path, const char *name)
{
    struct stat info;
    pm_bytes data = {0};
    pm_status st = fstat(fd, &info) ? io_error(c, path) : PM_OK;
    if (!st && S_ISDIR(info.st_mode))
        st = pm_error_set(c->err, PM_E_IO, "'%.300s' is a folder; name a scene file", path);
    if (!st)
        st = read_all(c, fd, path, &data);
    if (!st)
        st = pm_bundle_add(c->bundle, name, data.data, data.size, c->err);
    if (!st)
        st = enqueue(c, pm_bundle_find(c->bundle, name, NULL));
    c->bytes += data.size;
    pm_bytes_clear(&data);
    if (fd != STDIN_FILENO)
        close(fd);
    return st;
}

/* True if the path, links resolved, lies in the main file's folder. */
static bool is_inside(const struct collector *c, const char *path)
{
    size_t length = strlen(c->folder);
    return strncmp(path, c->folder, length) == 0 && path[length] == '/';
}

/* Opens a file of the folder by its name in the bundle. -1 if it is not there. */
static pm_status open_inside(struct collector *c, const char *name, const pm_word *word,
                             const char *from, int *fd)
{
    char path[PATH_MAX], *resolved;
    *fd = -1;
    if ((size_t)snprintf(path, sizeof path, "%s/%s", c->folder, name) >= sizeof path)
        return PM_OK;
    resolved = realpath(path, NULL);
    if (!resolved)
        return errno == ENOMEM ? memory_error(c) : PM_OK;
    pm_status st = PM_OK;
    if (!is_inside(c, resolved))
        st = pm_word_error(word, PM_E_RANGE, from, c->err,
                           "'%.*s' is a link out of the scene's folder; copy the file into the "
                           "folder of the main file",
                           PM_WORD_SHOW(*word));
    else if ((*fd = open(resolved, O_RDONLY | O_CLOEXEC)) < 0)
        st = io_error(c, path);
    free(resolved);
    return st;
}

static void note_missing(struct collector *c, const pm_word *word, const char *from)
{
    char text[400];
    snprintf(text, sizeof text, "%s'%.*s' (%s:%d:%d)", c->missing_count ? ", " : "",
             PM_WORD_SHOW(*word), from, word->line, word->column);
    if (strlen(c->missing) + strlen(text) < sizeof c->missing)
        strcat(c->missing, text);
    else if (c->missing_count && !strstr(c->missing, ", ..."))
        strncat(c->missing, ", ...", sizeof c->missing - 1 - strlen(c->missing));
    c->missing_count++;
}

/* The file goes into the bundle under the name by which the parser will look for it first. */
static pm_status add_named(struct collector *c, const pm_word *word, const char *from)
{
    char beside[PM_PATH_SIZE], top[PM_PATH_SIZE];
    bool has_beside = pm_path_join(from, word->text, beside);
    bool has_top = pm_path_join(NULL, word->text, top);
    if (!has_beside && !has_top)
        return pm_word_error(
            word, PM_E_RANGE, from, c->err,
            "'%.*s' lies outside the scene's folder; move it beneath the folder "
            "of the main file and write its name relative to that",
            PM_WORD_SHOW(*word));
    int fd = -1;
    pm_status st = has_beside ? open_inside(c, beside, word, from, &fd) : PM_OK;
    const char *name = beside;
    if (!st && fd < 0 && has_top) {
        name = top;
        st = open_inside(c, top, word, from, &fd);
    }
    if (!st && fd < 0)
        note_missing(c, word, from);
    if (st || fd < 0)
        return st;
    const pm_file *known = pm_bundle_find(c->bundle, name, NULL);
    if (!known)
        return add_open_file(c, fd, name, name);
    close(fd);
    return PM_OK;
}

static pm_status add_command(struct collector *c, pm_lexer *lexer, pm_arena *arena)
{
    pm_command command;
    pm_xform xform;
    pm_status st = pm_command_read(lexer, arena, &command, NULL);
    if (!st)
        st = pm_xform_parse(&command, arena, &xform, NULL);
    if (st)
        return st == PM_E_MEMORY ? memory_error(c) : PM_OK; /* the parser tells the rest */
    for (size_t i = 0; !st && i < xform.file_count; i++)
        st = add_named(c, &xform.files[i], lexer->file);
    return st;
}

/* Adds what the file names. What is wrong with its text is for the parser to tell. */
static pm_status add_children(struct collector *c, const pm_file *file)
{
    pm_lexer lexer;
    pm_statement statement;
    pm_arena arena = {0};
    size_t reals;
    pm_status st = pm_lexer_init(&lexer, file, c->err);
    while (!st && !pm_statement_next(&lexer, &statement, NULL) &&
           statement.kind != PM_STATEMENT_END) {
        if (statement.kind == PM_STATEMENT_COMMAND)
            st = add_command(c, &lexer, &arena);
        else if (statement.kind == PM_STATEMENT_PRIMITIVE &&
                 !pm_statement_skip_arguments(&lexer, &reals))
            break;
    }
    pm_arena_clear(&arena);
    return st;
}

static pm_status add_all_children(struct collector *c)
{
    pm_status st = PM_OK;
    for (size_t i = 0; !st && i < c->queue_length; i++) {
        const pm_file file = c->queue[i]; /* the queue moves as it grows */
        st = add_children(c, &file);
    }
    return st;
}

static pm_status find_folder(struct collector *c, const char *path)
{
    const char *slash = strrchr(path, '/');
    char *folder =
        slash ? strndup(path, slash == path ? 1 : (size_t)(slash - path)) : strdup(".");
    c->folder = folder ? realpath(folder, NULL) : NULL;
    free(folder);
    if (!folder)
        return memory_error(c);
    if (!c->folder)
        return io_error(c, path);
    if (strcmp(c->folder, "/") == 0)
        c->folder[0] = '\0';
    return PM_OK;
}

static pm_status collect(struct collector *c, const char *path, const char *name)
{
    bool standard_input = strcmp(path, "-") == 0;
    pm_status st = find_folder(c, standard_input ? "./" : path);
    if (st)
        return st;
    int fd = standard_input ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC);
    st = fd < 0 ? io_error(c, path) : add_open_file(c, fd, path, name);
    if (!st)
        st = add_all_children(c);
    if (!st && c->missing_count)
        st = pm_error_set(
            c->err, PM_E_MISSING,
            "%zu file%s of the scene not found beside the file that names %s nor in "
            "the main file's folder: %s",
            c->missing_count, c->missing_count > 1 ? "s" : "",
            c->missing_count > 1 ? "them" : "it", c->missing);
    return st;
}

pm_status pm_bundle_collect(const char *path, pm_bundle **out, const char **main_name,
                            pm_error *err)
{
    struct collector c = {.bundle = pm_bundle_new(), .err = err};
    const char *slash = strrchr(path, '/');
    const char *name = strcmp(path, "-") == 0 ? "stdin.rad" : slash ? slash + 1 : path;
    pm_status st = c.bundle ? collect(&c, path, name) : memory_error(&c);
    free(c.folder);
    free(c.queue);
    if (st) {
        pm_bundle_free(c.bundle);
        return st;
    }
    *main_name = pm_bundle_find(c.bundle, name, NULL)->name;
    *out = c.bundle;
    return PM_OK;
}
