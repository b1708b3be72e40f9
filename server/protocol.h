#ifndef PM_SERVER_PROTOCOL_H
#define PM_SERVER_PROTOCOL_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "json.h"

/* What server and worker say to each other over a SOCK_SEQPACKET socket pair: a message is one
 * JSON object of at most PM_MESSAGE_MAX bytes with up to PM_MESSAGE_FILES sealed memory files
 * beside it.
 *
 *   type      from    members and files                       answer
 *   job       server  main, request, points, maps;            -
 *                     files: request, bundle, points?, map files as `maps` lists them
 *   begin     worker  family, kind                            begun {joined}
 *   fetch     worker  family, index                           batch {found}; file if found
 *   keep      worker  family, kind, index; file: the batch    kept
 *   end       worker  family                                  ended {ok}: what was kept is
 * stored progress  worker  as GET /v1/jobs/{id} shows it           - piece     worker  name;
 * file: the next bytes of a result  taken {ok} result    worker  name, format; file, or none if
 * its      - pieces are all there done      worker  file: the answer                        -
 * (the last message) failed    worker  status, text, file, line, column        -  (the last
 * message)
 *
 * A piece has PM_PIECE_BYTES, the last one of a result fewer or as many; so large results are
 * in nobody's memory as a whole. A worker serves one job and ends. Neither side trusts lengths,
 * names or seals of the other.
 */

enum {
    PM_MESSAGE_MAX = 32768,
    PM_MESSAGE_FILES = 8,
    PM_PIECE_BYTES = 16 << 20,
};

typedef struct pm_message {
    pm_json *json;
    int files[PM_MESSAGE_FILES]; /* close-on-exec */
    size_t file_count;
} pm_message;

/* Sends; `json` is stolen, NULL is PM_E_MEMORY. The files stay the caller's. PM_E_MISSING
 * if the other side has closed. */
PM_MUST_USE pm_status pm_message_send(int socket, pm_json *json, const int *files,
                                      size_t file_count, pm_error *err);

/* Waits for one. PM_E_MISSING if the other side has closed, PM_E_CORRUPT for what is no
 * message. Clear *out afterwards. */
PM_MUST_USE pm_status pm_message_receive(int socket, pm_message *out, pm_error *err);
void pm_message_clear(pm_message *message);
const char *pm_message_type(const pm_message *message); /* "" if it has none */

/* ---- memory files: written once, then sealed against any change ---- */

PM_MUST_USE pm_status pm_memory_file_new(int *file, pm_error *err);
PM_MUST_USE pm_status pm_memory_file_append(int file, const void *data, size_t size,
                                            pm_error *err);
PM_MUST_USE pm_status pm_memory_file_seal(int file, pm_error *err);

/* The three in one. */
PM_MUST_USE pm_status pm_memory_file_of(const void *data, size_t size, int *file,
                                        pm_error *err);

/* Maps a sealed file for reading; PM_E_CORRUPT if it is not sealed. An empty file gives a
 * valid pointer and size 0. Undo with pm_memory_unmap. */
PM_MUST_USE pm_status pm_memory_map(int file, const void **data, size_t *size, pm_error *err);
void pm_memory_unmap(const void *data, size_t size);

#endif
