#include "listen.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

enum { BACKLOG = 128, FLAGS = SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK };

static pm_status system_error(pm_error *err, const char *name, const char *what)
{
    return pm_error_set_at(err, PM_E_IO, name, 0, 0, "%s: %s", what, strerror(errno));
}

/* ---- Unix ---- */

/* Removes what a dead server left. */
static pm_status clear_way(const struct sockaddr_un *address, pm_error *err)
{
    int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (probe < 0)
        return system_error(err, address->sun_path, "no socket");
    bool is_served = !connect(probe, (const struct sockaddr *)address, sizeof *address);
    int why = errno;
    close(probe);
    if (is_served)
        return pm_error_set_at(err, PM_E_MISMATCH, address->sun_path, 0, 0,
                               "another server listens here");
    struct stat about;
    if (why == ECONNREFUSED && !lstat(address->sun_path, &about) && S_ISSOCK(about.st_mode))
        unlink(address->sun_path);
    return PM_OK;
}

pm_status pm_listen_unix(const char *path, int *out, pm_error *err)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path)
        return pm_error_set_at(err, PM_E_LIMIT, path, 0, 0,
                               "is too long for a socket: at most %zu bytes",
                               sizeof address.sun_path - 1);
    strcpy(address.sun_path, path);
    pm_status st = clear_way(&address, err);
    if (st)
        return st;
    int made = socket(AF_UNIX, FLAGS, 0);
    mode_t mask = umask(S_IRWXG | S_IRWXO); /* the mode holds from the first moment */
    bool bound = made >= 0 && !bind(made, (struct sockaddr *)&address, sizeof address) &&
                 !chmod(path, S_IRUSR | S_IWUSR) && !listen(made, BACKLOG);
    umask(mask);
    if (!bound) {
        st = system_error(err, path, "cannot listen");
        if (made >= 0)
            close(made);
        return st;
    }
    *out = made;
    return PM_OK;
}

/* ---- TCP ---- */

/* Splits "host:port" or "[host]:port". */
static pm_status split(const char *address, char host[256], char port[16], pm_error *err)
{
    const char *colon = strrchr(address, ':');
    const char *first = address, *end = colon;
    if (colon && *address == '[' && colon > address && colon[-1] == ']') {
        first++;
        end--;
    }
    if (!colon || end <= first || end - first > 255 || !colon[1] || strlen(colon + 1) > 5 ||
        strspn(colon + 1, "0123456789") != strlen(colon + 1))
        return pm_error_set_at(err, PM_E_SYNTAX, address, 0, 0,
                               "is no address; write HOST:PORT, e.g. 127.0.0.1:8080");
    snprintf(host, 256, "%.*s", (int)(end - first), first);
    snprintf(port, 16, "%s", colon + 1);
    return PM_OK;
}

static bool is_loopback(const struct sockaddr *address)
{
    if (address->sa_family == AF_INET)
        return ntohl(((const struct sockaddr_in *)(const void *)address)->sin_addr.s_addr) >>
                   24 ==
               127;
    return IN6_IS_ADDR_LOOPBACK(
        &((const struct sockaddr_in6 *)(const void *)address)->sin6_addr);
}

static void describe(int socket, pm_door *door, char url[128])
{
    struct sockaddr_storage bound;
    socklen_t length = sizeof bound;
    char host[64] = "", port[16] = "";
    getsockname(socket, (struct sockaddr *)&bound, &length);
    getnameinfo((struct sockaddr *)&bound, length, host, sizeof host, port, sizeof port,
                NI_NUMERICHOST | NI_NUMERICSERV);
    *door = is_loopback((struct sockaddr *)&bound) ? PM_DOOR_LOOPBACK : PM_DOOR_NETWORK;
    snprintf(url, 128, bound.ss_family == AF_INET6 ? "http://[%s]:%s" : "http://%s:%s", host,
             port);
}

static int open_socket(const struct addrinfo *where)
{
    int made = socket(where->ai_family, FLAGS, 0), on = 1;
    if (made < 0)
        return -1;
    setsockopt(made, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (!bind(made, where->ai_addr, where->ai_addrlen) && !listen(made, BACKLOG))
        return made;
    int why = errno;
    close(made);
    errno = why;
    return -1;
}

pm_status pm_listen_tcp(const char *address, int *out, pm_door *door, char url[128],
                        pm_error *err)
{
    char host[256], port[16];
    pm_status st = split(address, host, port, err);
    if (st)
        return st;
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE}, *found;
    int failed = getaddrinfo(host, port, &hints, &found);
    if (failed)
        return pm_error_set_at(err, PM_E_MISSING, address, 0, 0, "%s", gai_strerror(failed));
    int made = open_socket(found);
    freeaddrinfo(found);
    if (made < 0)
        return system_error(err, address, "cannot listen");
    describe(made, door, url);
    *out = made;
    return PM_OK;
}
