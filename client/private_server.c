#include "private_server.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "interrupt.h"

struct pm_private_server {
    char store[PATH_MAX];
    char lease_path[PATH_MAX + 8];
    char lock_path[PATH_MAX + 8];
    char socket_path[PATH_MAX + 8];
    int lease;
    pid_t child; /* 0 if somebody else started the server */
};

static pm_status system_error(pm_error *err, const char *path, const char *what)
{
    return pm_error_set_at(err, PM_E_IO, path, 0, 0, "%s: %s", what, strerror(errno));
}

/* Makes the folders above `path`, like mkdir -p, readable by the user alone. */
static bool make_folders(const char *path)
{
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", path);
    for (char *slash = strchr(folder + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        if (mkdir(folder, 0700) && errno != EEXIST)
            return false;
        *slash = '/';
    }
    return true;
}

static pm_status choose_store(char store[PATH_MAX], pm_error *err)
{
    const char *named = getenv("PM_STORE");
    const char *cache = getenv("XDG_CACHE_HOME");
    const char *home = getenv("HOME");
    int length = 0;
    if (named && *named)
        length = snprintf(store, PATH_MAX, "%s", named);
    else if (cache && *cache == '/')
        length = snprintf(store, PATH_MAX, "%s/pm/store.sqlite", cache);
    else if (home && *home)
        length = snprintf(store, PATH_MAX, "%s/.cache/pm/store.sqlite", home);
    else
        return pm_error_set(err, PM_E_MISSING,
                            "no place for the cache: set PM_STORE to a file, or HOME");
    if (length >= PATH_MAX)
        return pm_error_set(err, PM_E_RANGE, "the cache's file name is too long: set PM_STORE");
    struct stat about;
    if (!make_folders(store))
        return system_error(err, store,
                            "cannot make the cache's folder (PM_STORE names another)");
    if (!stat(store, &about) && !S_ISREG(about.st_mode))
        return pm_error_set_at(err, PM_E_IO, store, 0, 0,
                               "cannot be the cache: PM_STORE must name a file");
    return PM_OK;
}

static int open_lock(const char *path, int operation)
{
    int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (file < 0)
        return -1;
    int failed;
    do {
        failed = flock(file, operation);
    } while (failed && errno == EINTR && !pm_interrupted);
    if (failed) {
        int why = errno;
        close(file);
        errno = why;
        return -1;
    }
    return file;
}

static bool answers(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int file = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (file < 0)
        return false;
    memcpy(address.sun_path, path, strlen(path)); /* name_files saw that it fits */
    bool connected = !connect(file, (const struct sockaddr *)&address, sizeof address);
    close(file);
    return connected;
}

/* pmserver beside this program, else the one on PATH. */
static void find_program(char program[PATH_MAX])
{
    ssize_t length = readlink("/proc/self/exe", program, PATH_MAX - 16);
    if (length > 0) {
        program[length] = '\0';
        char *slash = strrchr(program, '/');
        strcpy(slash ? slash + 1 : program, "pmserver");
        if (!access(program, X_OK))
            return;
    }
    strcpy(program, "pmserver");
}

/* In the child: becomes pmserver. Its own process group, so that Ctrl-C reaches it through the
 * client, which first cancels its job. */
static _Noreturn void become_server(const pm_private_server *server, int ready)
{
    char program[PATH_MAX];
    find_program(program);
    setpgid(0, 0);
    dup2(ready, STDOUT_FILENO);
    execlp(program, "pmserver", "--store", server->store, "--unix", server->socket_path,
           "--exit-when-idle", server->lease_path, (char *)NULL);
    fprintf(stderr, "pmclient: cannot start %s: %s\n", program, strerror(errno));
    _exit(127);
}

/* True once the server has said that it listens. */
static bool wait_until_ready(int ready)
{
    char text[512];
    size_t used = 0;
    while (used < sizeof text - 1) {
        ssize_t got = read(ready, text + used, sizeof text - 1 - used);
        if (got < 0 && errno == EINTR && !pm_interrupted)
            continue;
        if (got <= 0)
            return false;
        used += (size_t)got;
        text[used] = '\0';
        if (strstr(text, "listening on"))
            return true;
    }
    return false;
}

static pm_status start(pm_private_server *server, pm_error *err)
{
    int ready[2];
    if (pipe2(ready, O_CLOEXEC))
        return system_error(err, "pmserver", "cannot be started");
    unlink(server->socket_path); /* nobody answered there: it is a dead server's */
    server->child = fork();
    if (server->child == 0)
        become_server(server, ready[1]);
    close(ready[1]);
    bool listening = server->child > 0 && wait_until_ready(ready[0]);
    close(ready[0]);
    if (listening)
        return PM_OK;
    /* If it runs all the same (we were interrupted), it ends once we give the lease back; so it
     * is waited for then. */
    return pm_error_set(err, PM_E_IO,
                        "the private server did not start; what it said stands above");
}

static pm_status find_or_start(pm_private_server *server, pm_error *err)
{
    int lock = open_lock(server->lock_path, LOCK_EX);
    if (lock < 0)
        return system_error(err, server->lock_path, "cannot be locked");
    pm_status st = answers(server->socket_path) ? PM_OK : start(server, err);
    close(lock);
    return st;
}

static pm_status name_files(pm_private_server *server, pm_error *err)
{
    struct sockaddr_un address;
    snprintf(server->lease_path, sizeof server->lease_path, "%s.lease", server->store);
    snprintf(server->lock_path, sizeof server->lock_path, "%s.lock", server->store);
    snprintf(server->socket_path, sizeof server->socket_path, "%s.sock", server->store);
    if (strlen(server->socket_path) < sizeof address.sun_path)
        return PM_OK;
    return pm_error_set_at(err, PM_E_RANGE, server->socket_path, 0, 0,
                           "is too long for a socket (%zu bytes at most): set PM_STORE to a "
                           "shorter name",
                           sizeof address.sun_path - 1);
}

pm_status pm_private_server_open(pm_private_server **out, pm_error *err)
{
    pm_private_server *server = calloc(1, sizeof *server);
    if (!server)
        return pm_error_set(err, PM_E_MEMORY, "no memory");
    server->lease = -1;
    pm_status st = choose_store(server->store, err);
    if (!st)
        st = name_files(server, err);
    if (!st) {
        server->lease = open_lock(server->lease_path, LOCK_SH);
        st = server->lease < 0 ? system_error(err, server->lease_path, "cannot be locked")
                               : find_or_start(server, err);
    }
    if (st)
        pm_private_server_close(server);
    else
        *out = server;
    return st;
}

const char *pm_private_server_socket(const pm_private_server *server)
{
    return server->socket_path;
}

/* Gives the lease back. True if other clients hold it, so that the server lives on. */
static bool leave_to_others(int lease)
{
    bool alone = !flock(lease, LOCK_EX | LOCK_NB);
    /* Somebody has a lock: clients theirs, shared, or the server the exclusive one, at its end.
     */
    bool shared = !alone && !flock(lease, LOCK_SH | LOCK_NB);
    close(lease);
    return shared;
}

void pm_private_server_close(pm_private_server *server)
{
    if (!server)
        return;
    bool left = server->lease >= 0 && leave_to_others(server->lease);
    if (server->child > 0 && !left && pm_interrupted < 2)
        (void)!waitpid(server->child, NULL, 0); /* until a signal comes */
    free(server);
}
