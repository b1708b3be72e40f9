#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static pm_status system_error(pm_error *err, const char *path, const char *what)
{
    return pm_error_set_at(err, PM_E_IO, strcmp(path, "-") ? path : "standard output", 0, 0,
                           "%s: %s", what, strerror(errno));
}

pm_status pm_output_check(const char *path, pm_error *err)
{
    struct stat about;
    char folder[sizeof((pm_output *)NULL)->path];
    if (!strcmp(path, "-"))
        return PM_OK;
    if (strlen(path) >= sizeof folder)
        return pm_error_set_at(err, PM_E_RANGE, path, 0, 0, "is too long a name");
    if (!*path || (!stat(path, &about) && S_ISDIR(about.st_mode)))
        return pm_error_set_at(err, PM_E_IO, *path ? path : "\"\"", 0, 0,
                               "cannot be written: it must be the name of a file");
    if (!stat(path, &about) && !S_ISREG(about.st_mode))
        return access(path, W_OK) ? system_error(err, path, "cannot be written") : PM_OK;
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash + 1 - path) : 1,
             slash ? path : ".");
    return access(folder, W_OK | X_OK) ? system_error(err, path, "cannot be written") : PM_OK;
}

/* The file itself where links lead to one: they stay links. */
static void follow_links(pm_output *output, const char *path)
{
    char *real = realpath(path, NULL);
    const char *name = real && strlen(real) < sizeof output->path ? real : path;
    strcpy(output->path, name);
    free(real);
}

/* Devices and pipes are written as they are: a file that is put in their place is none. */
static bool is_written_in_place(const char *path)
{
    struct stat about;
    return !stat(path, &about) && !S_ISREG(about.st_mode);
}

static int open_beside(pm_output *output, const char *path)
{
    follow_links(output, path);
    snprintf(output->temporary, sizeof output->temporary, "%s.part%ld", output->path,
             (long)getpid());
    return open(output->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
}

pm_status pm_output_open(pm_output *output, const char *path, pm_error *err)
{
    *output = (pm_output){0};
    if (strlen(path) >= sizeof output->path)
        return pm_error_set_at(err, PM_E_RANGE, path, 0, 0, "is too long a name");
    strcpy(output->path, path);
    if (!strcmp(path, "-")) {
        output->file = stdout;
        return PM_OK;
    }
    int file = is_written_in_place(path) ? open(path, O_WRONLY | O_NOCTTY | O_CLOEXEC)
                                         : open_beside(output, path);
    output->file = file < 0 ? NULL : fdopen(file, "wb");
    if (output->file)
        return PM_OK;
    pm_status st = system_error(err, path, "cannot be written");
    if (file >= 0) {
        close(file);
        if (output->temporary[0])
            unlink(output->temporary);
    }
    return st;
}

/* fsync knows no devices nor pipes: they have nothing to make last. */
static bool is_on_disk(FILE *file)
{
    return !fsync(fileno(file)) || errno == EINVAL || errno == ENOTSUP || errno == ENOSYS;
}

/* 0, or errno of what failed first. */
static int finish(FILE *file)
{
    int error = fflush(file) ? errno : ferror(file) ? EIO : 0;
    if (file == stdout)
        return error;
    if (!error && !is_on_disk(file))
        error = errno;
    if (fclose(file) && !error)
        error = errno;
    return error;
}

pm_status pm_output_commit(pm_output *output, pm_error *err)
{
    const char *what = "cannot be written whole";
    int error = finish(output->file);
    output->file = NULL;
    if (!error && output->temporary[0] && rename(output->temporary, output->path)) {
        what = "cannot be put in place";
        error = errno;
    }
    if (error && output->temporary[0])
        unlink(output->temporary);
    errno = error;
    return error ? system_error(err, output->path, what) : PM_OK;
}

void pm_output_abandon(pm_output *output)
{
    if (output->file && output->file != stdout) {
        fclose(output->file);
        if (output->temporary[0])
            unlink(output->temporary);
    }
    output->file = NULL;
}
