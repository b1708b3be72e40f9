#include "session.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/bytes.h"
#include "caret.h"
#include "interrupt.h"
#include "map_files.h"
#include "output.h"
#include "private_server.h"
#include "progress.h"
#include "scene/bundle.h"

struct pm_session {
    const pm_options *options;
    pm_private_server *own; /* NULL if --server names one */
    pm_http *http;
};

/* ---- opening ---- */

static pm_status read_token(const char *path, char *token, size_t size, pm_error *err)
{
    FILE *file = fopen(path, "r");
    if (!file)
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be read: %s", strerror(errno));
    bool got = fgets(token, (int)size, file) != NULL;
    fclose(file);
    if (got)
        token[strcspn(token, "\r\n")] = '\0';
    if (got && *token)
        return PM_OK;
    return pm_error_set_at(err, PM_E_SYNTAX, path, 1, 1, "holds no token on its first line");
}

static pm_status connect_to(pm_session *session, pm_error *err)
{
    const pm_options *options = session->options;
    char token[4096] = "", url[1024] = "http://localhost";
    const char *socket = NULL;
    pm_status st = PM_OK;
    if (options->token_file)
        st = read_token(options->token_file, token, sizeof token, err);
    if (!st && !options->server) {
        st = pm_private_server_open(&session->own, err);
        if (!st)
            socket = pm_private_server_socket(session->own);
    }
    if (st)
        return st;
    if (options->server && strlen(options->server) >= sizeof url)
        return pm_error_set(err, PM_E_RANGE, "--server: the address is too long");
    if (options->server) {
        strcpy(url, options->server);
        for (size_t end = strlen(url); end && url[end - 1] == '/'; end--)
            url[end - 1] = '\0';
    }
    session->http = pm_http_new(url, socket, *token ? token : NULL);
    if (!session->http)
        return pm_error_set(err, PM_E_MEMORY, "no memory");
    return PM_OK;
}

pm_status pm_session_open(const pm_options *options, pm_session **out, pm_error *err)
{
    pm_session *session = calloc(1, sizeof *session);
    if (!session)
        return pm_error_set(err, PM_E_MEMORY, "no memory");
    session->options = options;
    pm_status st = connect_to(session, err);
    if (st)
        pm_session_close(session);
    else
        *out = session;
    return st;
}

void pm_session_close(pm_session *session)
{
    if (!session)
        return;
    pm_http_free(session->http);
    pm_private_server_close(session->own);
    free(session);
}

/* ---- calls ---- */

static pm_status status_of(long http)
{
    switch (http) {
    case 404:
        return PM_E_MISSING;
    case 409:
        return PM_E_MISMATCH;
    case 413:
        return PM_E_LIMIT;
    case 422:
        return PM_E_RANGE;
    default:
        return PM_E_IO;
    }
}

/* An RFC 9457 document as an error. */
static pm_status problem_error(const pm_json *problem, pm_status status, pm_error *err)
{
    const char *text = pm_json_get_text(problem, "detail",
                                        pm_json_get_text(problem, "title", "no reason given"));
    return pm_error_set_at(err, status, pm_json_get_text(problem, "file", ""),
                           (int)pm_json_get_integer(problem, "line", 0),
                           (int)pm_json_get_integer(problem, "column", 0), "%s", text);
}

static pm_status response_error(const pm_response *response, const char *method,
                                const char *path, pm_error *err)
{
    pm_json *problem = NULL;
    pm_status st = status_of(response->status);
    if (response->body.size &&
        !pm_json_parse(response->body.data, response->body.size, "answer", &problem, NULL))
        st = problem_error(problem, st, err);
    else
        st = pm_error_set(err, st, "%s %s: HTTP status %ld", method, path, response->status);
    pm_json_free(problem);
    return st;
}

pm_status pm_session_call(pm_session *session, const char *method, const char *path,
                          const pm_http_body *body, pm_json **json, pm_error *err)
{
    pm_response response = {0};
    pm_json *document = NULL;
    pm_status st = pm_http_send(session->http, method, path, body, NULL, &response, err);
    if (st)
        return st;
    if (response.status / 100 != 2)
        st = response_error(&response, method, path, err);
    else if (json &&
             pm_json_parse(response.body.data, response.body.size, "answer", &document, NULL))
        st = pm_error_set(err, PM_E_SYNTAX, "%s %s: the answer is no JSON; is this a pmserver?",
                          method, path);
    if (!st && json)
        *json = document;
    else
        pm_json_free(document);
    pm_response_clear(&response);
    return st;
}

static pm_status post(pm_session *session, const char *path, pm_json *request, pm_json **json,
                      pm_error *err)
{
    char *text = request ? pm_json_text(request) : NULL;
    pm_json_free(request);
    if (!text)
        return pm_error_set(err, PM_E_MEMORY, "the request cannot be written as JSON");
    pm_http_body body = {.type = "application/json", .data = text, .size = strlen(text)};
    pm_status st = pm_session_call(session, "POST", path, &body, json, err);
    free(text);
    return st;
}

/* ---- uploads ---- */

static bool has_blob(pm_session *session, const char *hex)
{
    char path[128];
    pm_response response = {0};
    snprintf(path, sizeof path, "/v1/blobs/%s", hex);
    if (pm_http_send(session->http, "HEAD", path, NULL, NULL, &response, NULL))
        return false;
    pm_response_clear(&response);
    return response.status == 200;
}

static pm_status put_blob(pm_session *session, const pm_http_body *body,
                          const pm_digest *digest, pm_error *err)
{
    char hex[PM_DIGEST_HEX];
    pm_json *json = NULL;
    pm_digest_hex(digest, hex);
    if (has_blob(session, hex))
        return PM_OK;
    pm_status st = pm_session_call(session, "PUT", "/v1/blobs", body, &json, err);
    if (!st && strcmp(pm_json_get_text(json, "digest", ""), hex))
        st = pm_error_set(err, PM_E_CORRUPT, "the file changed on its way; try again");
    pm_json_free(json);
    return st;
}

pm_status pm_session_upload(pm_session *session, const void *data, size_t size,
                            pm_digest *digest, pm_error *err)
{
    pm_http_body body = {.type = "application/octet-stream", .data = data, .size = size};
    *digest = pm_digest_of(data, size);
    return put_blob(session, &body, digest, err);
}

static pm_status digest_file(FILE *file, const char *path, uint64_t *size, pm_digest *digest,
                             pm_error *err)
{
    static char buffer[1 << 16];
    pm_hasher *hasher = pm_hasher_new();
    if (!hasher)
        return pm_error_set(err, PM_E_MEMORY, "no memory");
    *size = 0;
    for (size_t got; (got = fread(buffer, 1, sizeof buffer, file)) > 0; *size += got)
        pm_hasher_add(hasher, buffer, got);
    *digest = pm_hasher_finish(hasher);
    pm_hasher_free(hasher);
    if (ferror(file) || fseek(file, 0, SEEK_SET))
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be read: %s", strerror(errno));
    return PM_OK;
}

pm_status pm_session_upload_file(pm_session *session, const char *path, pm_digest *digest,
                                 pm_error *err)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be read: %s", strerror(errno));
    pm_http_body body = {.type = "application/octet-stream", .file = file};
    pm_status st = digest_file(file, path, &body.size, digest, err);
    if (!st)
        st = put_blob(session, &body, digest, err);
    fclose(file);
    return st;
}

/* ---- scenes ---- */

static pm_status upload_bundle(pm_session *session, const pm_bundle *bundle, pm_digest *digest,
                               pm_error *err)
{
    pm_bytes tar = {0};
    pm_status st = pm_bundle_write_tar(bundle, &tar, err);
    if (!st)
        st = pm_session_upload(session, tar.data, tar.size, digest, err);
    pm_bytes_clear(&tar);
    return st;
}

/* The file that the server speaks of, as the user typed it; without its folder if that is too
 * long to be shown. */
static void local_name(const char *path, const char *main_name, const char *name, char *out,
                       size_t size)
{
    const char *slash = strrchr(path, '/');
    int folder = slash ? (int)(slash + 1 - path) : 0;
    if (!strcmp(path, "-"))
        path = "standard input";
    if (!*name || !strcmp(name, main_name))
        name = path + folder;
    if (snprintf(out, size, "%.*s%s", folder, path, name) >= (int)size)
        snprintf(out, size, "%s", name);
}

static pm_status register_scene(pm_session *session, const char *path, const char *main_name,
                                const pm_bundle *files, const pm_digest *bundle,
                                pm_json **scene, pm_error *err)
{
    char hex[PM_DIGEST_HEX], name[sizeof err->file];
    pm_error why = PM_ERROR_INIT;
    pm_digest_hex(bundle, hex);
    pm_status st =
        post(session, "/v1/scenes",
             pm_json_pack("{s:s, s:s}", "bundle", hex, "main", main_name), scene, &why);
    if (!st || st == PM_E_UNREACHABLE || st == PM_E_CANCELLED)
        return st ? pm_error_set(err, st, "%s", why.text) : PM_OK;
    local_name(path, main_name, why.file, name, sizeof name);
    pm_caret_append(&why, pm_bundle_find(files, why.file, NULL), why.line, why.column);
    return pm_error_set_at(err, st, name, why.line, why.column, "%s", why.text);
}

pm_status pm_session_scene(pm_session *session, const char *path, pm_json **scene,
                           pm_error *err)
{
    pm_bundle *bundle = NULL;
    const char *main_name = NULL;
    pm_digest digest;
    const pm_collect_options options = {.search_path = getenv("RAYPATH"),
                                        .allowed = session->options->allowed,
                                        .allowed_count = session->options->allowed_count};
    pm_status st = pm_bundle_collect(path, &options, &bundle, &main_name, err);
    if (st)
        return st;
    st = upload_bundle(session, bundle, &digest, err);
    if (!st)
        st = register_scene(session, path, main_name, bundle, &digest, scene, err);
    pm_bundle_free(bundle);
    return st;
}

/* ---- jobs ---- */

static bool has_ended(const pm_json *job)
{
    const char *state = pm_json_get_text(job, "state", "failed");
    return strcmp(state, "queued") && strcmp(state, "running");
}

static void cancel(pm_session *session, const char *id)
{
    char path[256];
    pm_response response = {0};
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    pm_http_set_patience(session->http, 2);
    if (!pm_http_send(session->http, "DELETE", path, NULL, NULL, &response, NULL))
        pm_response_clear(&response);
}

static pm_status watch(pm_session *session, const char *id, pm_json **job, pm_error *err)
{
    char path[256];
    pm_progress_display display;
    pm_progress_display_init(&display, session->options);
    bool shown = display.bar || display.interval > 0;
    snprintf(path, sizeof path, "/v1/jobs/%s?wait=%d", id, shown ? 1 : 20);
    pm_status st = PM_OK;
    for (pm_json *seen = NULL; !st; pm_json_free(seen)) {
        seen = NULL;
        st = pm_session_call(session, "GET", path, NULL, &seen, err);
        if (!st && pm_interrupted)
            st = pm_error_set(err, PM_E_CANCELLED, "interrupted");
        if (st)
            continue;
        if (has_ended(seen)) {
            *job = seen;
            break;
        }
        pm_progress_display_show(&display, seen);
    }
    pm_progress_display_end(&display);
    if (st == PM_E_CANCELLED)
        cancel(session, id);
    return st;
}

/* What the user calls an input of a job. */
static const char *input_name(const pm_session *session, const char *name)
{
    const pm_options *options = session->options;
    if (!strcmp(name, "points"))
        return "standard input";
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        const char *file = pm_map_files_name(options, (pm_map_kind)kind);
        bool precomputed = kind == PM_MAP_GLOBAL && !strncmp(name, "precomputed", 11);
        const char *word =
            pm_map_kind_name(precomputed ? PM_MAP_PRECOMPUTED : (pm_map_kind)kind);
        if (file && !strncmp(name, word, strlen(word)) && !strcmp(name + strlen(word), " map"))
            return file;
    }
    return name;
}

static pm_status end_of(const pm_session *session, const pm_json *job, pm_error *err)
{
    const char *state = pm_json_get_text(job, "state", "failed");
    if (!strcmp(state, "done"))
        return PM_OK;
    if (!strcmp(state, "cancelled"))
        return pm_error_set(err, PM_E_CANCELLED, "the job was cancelled");
    pm_error problem = PM_ERROR_INIT;
    problem_error(pm_json_get(job, "problem"), PM_E_IO, &problem);
    return pm_error_set_at(err, problem.status, input_name(session, problem.file), problem.line,
                           problem.column, "%s", problem.text);
}

pm_status pm_session_run(pm_session *session, pm_json *request, pm_json **job, pm_error *err)
{
    pm_json *accepted = NULL, *ended = NULL;
    /* Only a job whose id has come can be cancelled, so a first signal waits for that. */
    pm_http_set_patience(session->http, 2);
    pm_status st = post(session, "/v1/jobs", request, &accepted, err);
    pm_http_set_patience(session->http, 1);
    if (st)
        return st;
    st = watch(session, pm_json_get_text(accepted, "id", ""), &ended, err);
    pm_json_free(accepted);
    if (!st)
        st = end_of(session, ended, err);
    if (st)
        pm_json_free(ended);
    else
        *job = ended;
    return st;
}

pm_status pm_session_read(pm_session *session, const char *url, pm_bytes *out, pm_error *err)
{
    pm_response response = {0};
    pm_status st = pm_http_send(session->http, "GET", url, NULL, NULL, &response, err);
    if (!st && response.status / 100 != 2)
        st = response_error(&response, "GET", url, err);
    if (st)
        pm_response_clear(&response);
    else
        *out = response.body;
    return st;
}

pm_status pm_session_receive(pm_session *session, const char *url, FILE *file, pm_error *err)
{
    pm_response response = {0};
    pm_status st = pm_http_send(session->http, "GET", url, NULL, file, &response, err);
    if (!st && response.status / 100 != 2)
        st = response_error(&response, "GET", url, err);
    pm_response_clear(&response);
    return st;
}

static pm_status receive(pm_session *session, const char *url, const pm_output *output,
                         pm_error *err)
{
    pm_error why = PM_ERROR_INIT;
    pm_status st = pm_session_receive(session, url, output->file, &why);
    if (st && ferror(output->file))
        return pm_error_set_at(err, st, output->path, 0, 0, "%s", why.text);
    return st ? pm_error_set_at(err, st, why.file, why.line, why.column, "%s", why.text)
              : PM_OK;
}

pm_status pm_session_fetch(pm_session *session, const char *url, const char *path,
                           pm_error *err)
{
    pm_output output;
    pm_status st = pm_output_open(&output, path, err);
    if (!st)
        st = receive(session, url, &output, err);
    if (!st)
        return pm_output_commit(&output, err);
    pm_output_abandon(&output);
    return st;
}
