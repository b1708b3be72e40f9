#include "cmocka_first.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "protocol.h"

static void open_pair(int pair[2])
{
    assert_int_equal(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), 0);
}

static void a_message_arrives_with_its_files(void **state)
{
    (void)state;
    int pair[2], files[2];
    open_pair(pair);
    assert_int_equal(pm_memory_file_of("one", 3, &files[0], NULL), PM_OK);
    assert_int_equal(pm_memory_file_of("", 0, &files[1], NULL), PM_OK);
    assert_int_equal(pm_message_send(pair[0],
                                     pm_json_pack("{s:s, s:i}", "type", "keep", "index", 7),
                                     files, 2, NULL),
                     PM_OK);
    pm_message message;
    assert_int_equal(pm_message_receive(pair[1], &message, NULL), PM_OK);
    assert_string_equal(pm_message_type(&message), "keep");
    assert_int_equal(pm_json_get_integer(message.json, "index", 0), 7);
    assert_int_equal(message.file_count, 2);
    const void *data;
    size_t size;
    assert_int_equal(pm_memory_map(message.files[0], &data, &size, NULL), PM_OK);
    assert_int_equal(size, 3);
    assert_memory_equal(data, "one", 3);
    pm_memory_unmap(data, size);
    assert_int_equal(pm_memory_map(message.files[1], &data, &size, NULL), PM_OK);
    assert_int_equal(size, 0);
    assert_non_null(data);
    pm_message_clear(&message);
    for (int i = 0; i < 2; i++) {
        close(files[i]);
        close(pair[i]);
    }
}

static void a_sealed_file_cannot_change(void **state)
{
    (void)state;
    int file;
    assert_int_equal(pm_memory_file_of("photons", 7, &file, NULL), PM_OK);
    assert_int_equal(write(file, "x", 1), -1);
    assert_int_equal(pwrite(file, "x", 1, 0), -1);
    assert_int_equal(ftruncate(file, 3), -1);
    assert_ptr_equal(mmap(NULL, 7, PROT_WRITE, MAP_SHARED, file, 0), MAP_FAILED);
    close(file);
}

static void a_file_that_could_still_change_is_refused(void **state)
{
    (void)state;
    int file, pipe_ends[2];
    const void *data;
    size_t size;
    assert_int_equal(pm_memory_file_new(&file, NULL), PM_OK);
    assert_int_equal(pm_memory_map(file, &data, &size, NULL), PM_E_CORRUPT);
    assert_int_equal(fcntl(file, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_GROW), 0);
    assert_int_equal(pm_memory_map(file, &data, &size, NULL), PM_E_CORRUPT); /* could shrink */
    close(file);
    assert_int_equal(pipe(pipe_ends), 0);
    assert_int_equal(pm_memory_map(pipe_ends[0], &data, &size, NULL), PM_E_CORRUPT);
    close(pipe_ends[0]);
    close(pipe_ends[1]);
}

static void a_closed_socket_is_told_from_a_broken_message(void **state)
{
    (void)state;
    int pair[2];
    pm_message message;
    open_pair(pair);
    assert_int_equal(send(pair[0], "{\"type\": ", 9, 0), 9);
    assert_int_equal(pm_message_receive(pair[1], &message, NULL), PM_E_CORRUPT);
    close(pair[0]);
    assert_int_equal(pm_message_receive(pair[1], &message, NULL), PM_E_MISSING);
    assert_int_equal(pm_message_send(pair[1], pm_json_pack("{}"), NULL, 0, NULL), PM_E_MISSING);
    close(pair[1]);
}

static void messages_over_the_limit_are_refused_by_both_sides(void **state)
{
    (void)state;
    int pair[2];
    pm_message message;
    open_pair(pair);
    char *text = calloc(1, PM_MESSAGE_MAX + 2);
    memset(text, 'x', PM_MESSAGE_MAX + 1);
    assert_int_equal(pm_message_send(pair[0], pm_json_pack("{s:s}", "a", text), NULL, 0, NULL),
                     PM_E_LIMIT);
    assert_int_equal(send(pair[0], text, PM_MESSAGE_MAX + 1, 0), PM_MESSAGE_MAX + 1);
    assert_int_equal(pm_message_receive(pair[1], &message, NULL), PM_E_CORRUPT);
    free(text);
    close(pair[0]);
    close(pair[1]);
}

/* The lowest free descriptor is the same before and after, so nothing stayed open. */
static void more_files_than_allowed_leave_none_open(void **state)
{
    (void)state;
    enum { MANY = PM_MESSAGE_FILES + 1 };
    int pair[2], file;
    open_pair(pair);
    assert_int_equal(pm_memory_file_of("x", 1, &file, NULL), PM_OK);
    int lowest = dup(0);
    close(lowest);
    union {
        struct cmsghdr header;
        char bytes[CMSG_SPACE(sizeof(int) * MANY)];
    } control;
    memset(&control, 0, sizeof control);
    struct iovec part = {.iov_base = (void *)"{}", .iov_len = 2};
    struct msghdr sent = {.msg_iov = &part,
                          .msg_iovlen = 1,
                          .msg_control = control.bytes,
                          .msg_controllen = sizeof control.bytes};
    control.header.cmsg_level = SOL_SOCKET;
    control.header.cmsg_type = SCM_RIGHTS;
    control.header.cmsg_len = CMSG_LEN(sizeof(int) * MANY);
    for (size_t i = 0; i < MANY; i++)
        memcpy(CMSG_DATA(&control.header) + i * sizeof file, &file, sizeof file);
    assert_int_equal(sendmsg(pair[0], &sent, 0), 2);
    pm_message message;
    assert_int_equal(pm_message_receive(pair[1], &message, NULL), PM_E_CORRUPT);
    int after = dup(0);
    assert_int_equal(after, lowest);
    close(after);
    close(file);
    close(pair[0]);
    close(pair[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_message_arrives_with_its_files),
        cmocka_unit_test(a_sealed_file_cannot_change),
        cmocka_unit_test(a_file_that_could_still_change_is_refused),
        cmocka_unit_test(a_closed_socket_is_told_from_a_broken_message),
        cmocka_unit_test(messages_over_the_limit_are_refused_by_both_sides),
        cmocka_unit_test(more_files_than_allowed_leave_none_open),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
