#include "output.h"

#include <errno.h>
#include <fcntl.h>
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
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash + 1 - path) : 1,
             slash ? path : ".");
    return access(folder, W_OK | X_OK) ? system_error(err, path, "cannot be written") : PM_OK;
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
    snprintf(output->temporary, sizeof output->temporary, "%s.part%ld", path, (long)getpid());
    int file = open(output->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    output->file = file < 0 ? NULL : fdopen(file, "wb");
    if (output->file)
        return PM_OK;
    pm_status st = system_error(err, path, "cannot be written");
    if (file >= 0) {
        close(file);
        unlink(output->temporary);
    }
    return st;
}

pm_status pm_output_commit(pm_output *output, pm_error *err)
{
    pm_status st = PM_OK;
    if (fflush(output->file) || ferror(output->file))
        st = system_error(err, output->path, "cannot be written whole");
    if (output->temporary[0]) {
        if (!st && fsync(fileno(output->file)) && errno != EINVAL)
            st = system_error(err, output->path, "cannot be written whole");
        if (fclose(output->file) && !st)
            st = system_error(err, output->path, "cannot be written whole");
        output->file = NULL;
        if (!st && rename(output->temporary, output->path))
            st = system_error(err, output->path, "cannot be put in place");
        if (st)
            unlink(output->temporary);
    }
    output->file = NULL;
    return st;
}

void pm_output_abandon(pm_output *output)
{
    if (output->file && output->temporary[0]) {
        fclose(output->file);
        unlink(output->temporary);
    }
    output->file = NULL;
}
