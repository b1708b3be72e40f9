#include "protocol.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SEALS = F_SEAL_SEAL | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE };

union control {
    struct cmsghdr header; /* aligns the bytes */
    char bytes[CMSG_SPACE(sizeof(int) * PM_MESSAGE_FILES)];
};

static pm_status system_error(pm_error *err, const char *what)
{
    return pm_error_set(err, PM_E_IO, "%s: %s", what, strerror(errno));
}

static void attach(struct msghdr *message, union control *control, const int *files,
                   size_t count)
{
    memset(control, 0, sizeof *control);
    message->msg_control = control->bytes;
    message->msg_controllen = CMSG_SPACE(sizeof(int) * count);
    struct cmsghdr *header = CMSG_FIRSTHDR(message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int) * count);
    memcpy(CMSG_DATA(header), files, sizeof(int) * count);
}

static pm_status send_text(int socket, char *text, const int *files, size_t file_count,
                           pm_error *err)
{
    size_t length = strlen(text);
    if (length > PM_MESSAGE_MAX || file_count > PM_MESSAGE_FILES)
        return pm_error_set(err, PM_E_LIMIT, "a message of %zu bytes is too long", length);
    struct iovec part = {.iov_base = text, .iov_len = length};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};
    union control control;
    if (file_count)
        attach(&message, &control, files, file_count);
    ssize_t sent;
    do
        sent = sendmsg(socket, &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    if (sent < 0 && (errno == EPIPE || errno == ECONNRESET))
        return pm_error_set(err, PM_E_MISSING, "the other side has gone");
    return sent < 0 ? system_error(err, "cannot send a message") : PM_OK;
}

pm_status pm_message_send(int socket, pm_json *json, const int *files, size_t file_count,
                          pm_error *err)
{
    char *text = json ? pm_json_text(json) : NULL;
    pm_json_free(json);
    if (!text)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a message");
    pm_status st = send_text(socket, text, files, file_count, err);
    free(text);
    return st;
}

static void take_files(struct msghdr *header, pm_message *out)
{
    for (struct cmsghdr *c = CMSG_FIRSTHDR(header); c; c = CMSG_NXTHDR(header, c)) {
        if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_RIGHTS)
            continue;
        size_t count = (c->cmsg_len - CMSG_LEN(0)) / sizeof(int);
        for (size_t i = 0; i < count; i++) {
            int file;
            memcpy(&file, CMSG_DATA(c) + i * sizeof file, sizeof file);
            if (out->file_count < PM_MESSAGE_FILES)
                out->files[out->file_count++] = file;
            else
                close(file);
        }
    }
}

static pm_status receive(int socket, char *text, pm_message *out, pm_error *err)
{
    struct iovec part = {.iov_base = text, .iov_len = PM_MESSAGE_MAX};
    union control control;
    struct msghdr header = {.msg_iov = &part,
                            .msg_iovlen = 1,
                            .msg_control = control.bytes,
                            .msg_controllen = sizeof control.bytes};
    ssize_t received;
    do
        received = recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
    while (received < 0 && errno == EINTR);
    if (received < 0 && errno != ECONNRESET)
        return system_error(err, "cannot receive a message");
    if (received <= 0)
        return pm_error_set(err, PM_E_MISSING, "the other side has gone");
    take_files(&header, out);
    if (header.msg_flags & (MSG_TRUNC | MSG_CTRUNC))
        return pm_error_set(err, PM_E_CORRUPT, "a message is too long");
    return pm_json_parse(text, (size_t)received, "message", &out->json, err);
}

pm_status pm_message_receive(int socket, pm_message *out, pm_error *err)
{
    char *text = malloc(PM_MESSAGE_MAX);
    if (!text)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a message");
    pm_message message = {0};
    pm_status st = receive(socket, text, &message, err);
    free(text);
    if (st)
        pm_message_clear(&message);
    else
        *out = message;
    return st == PM_E_SYNTAX ? PM_E_CORRUPT : st;
}

void pm_message_clear(pm_message *message)
{
    for (size_t i = 0; i < message->file_count; i++)
        close(message->files[i]);
    pm_json_free(message->json);
    *message = (pm_message){0};
}

const char *pm_message_type(const pm_message *message)
{
    return pm_json_get_text(message->json, "type", "");
}

/* ---- memory files ---- */

pm_status pm_memory_file_new(int *file, pm_error *err)
{
    int made = memfd_create("pm", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (made < 0)
        return system_error(err, "cannot make a memory file");
    *file = made;
    return PM_OK;
}

pm_status pm_memory_file_append(int file, const void *data, size_t size, pm_error *err)
{
    const char *at = data;
    while (size) {
        ssize_t written = write(file, at, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return system_error(err, "cannot fill a memory file");
        at += written;
        size -= (size_t)written;
    }
    return PM_OK;
}

pm_status pm_memory_file_seal(int file, pm_error *err)
{
    if (fcntl(file, F_ADD_SEALS, SEALS))
        return system_error(err, "cannot seal a memory file");
    return PM_OK;
}

pm_status pm_memory_file_of(const void *data, size_t size, int *file, pm_error *err)
{
    int made = -1;
    pm_status st = pm_memory_file_new(&made, err);
    if (!st)
        st = pm_memory_file_append(made, data, size, err);
    if (!st)
        st = pm_memory_file_seal(made, err);
    if (!st)
        *file = made;
    else if (made >= 0)
        close(made);
    return st;
}

static const char nothing[1];

pm_status pm_memory_map(int file, const void **data, size_t *size, pm_error *err)
{
    struct stat about;
    int seals = fcntl(file, F_GET_SEALS);
    if (seals < 0 || (seals & SEALS) != SEALS || fstat(file, &about))
        return pm_error_set(err, PM_E_CORRUPT, "a file in a message is not sealed");
    *size = (size_t)about.st_size;
    *data = nothing;
    if (!*size)
        return PM_OK;
    void *at = mmap(NULL, *size, PROT_READ, MAP_SHARED, file, 0);
    if (at == MAP_FAILED)
        return pm_error_set(err, PM_E_MEMORY, "no address space for %zu bytes", *size);
    *data = at;
    return PM_OK;
}

void pm_memory_unmap(const void *data, size_t size)
{
    if (size)
        munmap((void *)data, size);
}
