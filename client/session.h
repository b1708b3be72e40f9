#ifndef PM_CLIENT_SESSION_H
#define PM_CLIENT_SESSION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/bytes.h"
#include "base/digest.h"
#include "base/error.h"
#include "http.h"
#include "json.h"
#include "options.h"

/* A conversation with the server: scenes and files go there, jobs run, answers come back. */
typedef struct pm_session pm_session;

/* Connects to --server, or opens the private one. */
PM_MUST_USE pm_status pm_session_open(const pm_options *options, pm_session **out,
                                      pm_error *err);
void pm_session_close(pm_session *session);

/* Sends a request and wants a 2xx answer; anything else becomes an error with the problem's
 * text and place. `json` (may be NULL) receives the answer's document. */
PM_MUST_USE pm_status pm_session_call(pm_session *session, const char *method, const char *path,
                                      const pm_http_body *body, pm_json **json, pm_error *err);

/* Keeps bytes at the server unless it has them; *digest names them. */
PM_MUST_USE pm_status pm_session_upload(pm_session *session, const void *data, size_t size,
                                        pm_digest *digest, pm_error *err);
PM_MUST_USE pm_status pm_session_upload_file(pm_session *session, const char *path,
                                             pm_digest *digest, pm_error *err);

/* Collects the scene's files, uploads them and has them compiled; *scene is the server's
 * description. Messages about the scene name files as the user would. */
PM_MUST_USE pm_status pm_session_scene(pm_session *session, const char *path, pm_json **scene,
                                       pm_error *err);

/* Runs a job to its end, with progress on a terminal. `request` is stolen. *job is its final
 * description. A failed job is an error with its reason. */
PM_MUST_USE pm_status pm_session_run(pm_session *session, pm_json *request, pm_json **job,
                                     pm_error *err);

/* Fetches into memory. */
PM_MUST_USE pm_status pm_session_read(pm_session *session, const char *url, pm_bytes *out,
                                      pm_error *err);

/* Fetches into an open file. */
PM_MUST_USE pm_status pm_session_receive(pm_session *session, const char *url, FILE *file,
                                         pm_error *err);

/* Fetches to a file (stdout for "-"), whole or not at all. */
PM_MUST_USE pm_status pm_session_fetch(pm_session *session, const char *url, const char *path,
                                       pm_error *err);

#endif
