#include "http.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <curl/curl.h>

#include "interrupt.h"

struct pm_http {
    CURL *curl;
    char *url;
    char *unix_path;
    char *token;
    int patience; /* signals that end waiting */
};

/* One request on its way. */
struct exchange {
    const pm_http *http;
    const pm_http_body *body;
    uint64_t sent;
    FILE *into;
    pm_response *out;
    int write_error; /* errno of what `into` did not take */
};

static char *copy_text(const char *text)
{
    return text ? strdup(text) : NULL;
}

pm_http *pm_http_new(const char *url, const char *unix_path, const char *token)
{
    pm_http *http = calloc(1, sizeof *http);
    if (!http)
        return NULL;
    http->curl = curl_easy_init();
    http->patience = 1;
    http->url = copy_text(url);
    http->unix_path = copy_text(unix_path);
    http->token = copy_text(token);
    if (http->curl && http->url && (!unix_path || http->unix_path) && (!token || http->token))
        return http;
    pm_http_free(http);
    return NULL;
}

void pm_http_free(pm_http *http)
{
    if (!http)
        return;
    if (http->curl)
        curl_easy_cleanup(http->curl);
    free(http->url);
    free(http->unix_path);
    free(http->token);
    free(http);
}

void pm_http_set_patience(pm_http *http, int signals)
{
    http->patience = signals;
}

static bool is_interrupted(const pm_http *http)
{
    return pm_interrupted >= http->patience;
}

static size_t give_body(char *to, size_t size, size_t count, void *context)
{
    struct exchange *exchange = context;
    uint64_t left = exchange->body->size - exchange->sent;
    size_t wanted = size * count < left ? size * count : (size_t)left;
    size_t got = wanted;
    if (exchange->body->file)
        got = fread(to, 1, wanted, exchange->body->file);
    else
        memcpy(to, (const char *)exchange->body->data + exchange->sent, wanted);
    if (got < wanted)
        return CURL_READFUNC_ABORT; /* the file became shorter than it was */
    exchange->sent += got;
    return got;
}

static size_t take_body(char *from, size_t size, size_t count, void *context)
{
    struct exchange *exchange = context;
    long status = 0;
    curl_easy_getinfo(exchange->http->curl, CURLINFO_RESPONSE_CODE, &status);
    if (exchange->into && status / 100 == 2) {
        size_t written = fwrite(from, 1, size * count, exchange->into);
        if (written != size * count)
            exchange->write_error = errno;
        return written;
    }
    pm_bytes_append(&exchange->out->body, from, size * count);
    return pm_bytes_status(&exchange->out->body) ? 0 : size * count;
}

static size_t take_header(char *from, size_t size, size_t count, void *context)
{
    static const char name[] = "location:";
    struct exchange *exchange = context;
    size_t length = size * count, at = sizeof name - 1;
    if (length <= at || strncasecmp(from, name, at))
        return length;
    while (at < length && from[at] == ' ')
        at++;
    size_t end = length;
    while (end > at && (from[end - 1] == '\r' || from[end - 1] == '\n'))
        end--;
    snprintf(exchange->out->location, sizeof exchange->out->location, "%.*s", (int)(end - at),
             from + at);
    return length;
}

static int watch(void *context, curl_off_t a, curl_off_t b, curl_off_t c, curl_off_t d)
{
    (void)a, (void)b, (void)c, (void)d;
    const struct exchange *exchange = context;
    return is_interrupted(exchange->http);
}

static struct curl_slist *add_header(struct curl_slist *list, const char *name,
                                     const char *value)
{
    char line[8192];
    snprintf(line, sizeof line, "%s: %s", name, value);
    struct curl_slist *longer = curl_slist_append(list, line);
    return longer ? longer : list;
}

static struct curl_slist *headers_of(const pm_http *http, const pm_http_body *body)
{
    struct curl_slist *list = add_header(NULL, "Expect", "");
    if (body->type)
        list = add_header(list, "Content-Type", body->type);
    if (body->idempotency_key)
        list = add_header(list, "Idempotency-Key", body->idempotency_key);
    if (http->token) {
        char bearer[4200];
        snprintf(bearer, sizeof bearer, "Bearer %s", http->token);
        list = add_header(list, "Authorization", bearer);
    }
    return list;
}

static void set_up(pm_http *http, const char *method, const char *url,
                   struct exchange *exchange, struct curl_slist *headers,
                   char message[CURL_ERROR_SIZE])
{
    CURL *curl = http->curl;
    bool has_body = exchange->body->data || exchange->body->file;
    curl_easy_reset(curl);
    curl_easy_setopt(curl, CURLOPT_URL, url);
    curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, method);
    curl_easy_setopt(curl, CURLOPT_NOBODY, (long)!strcmp(method, "HEAD"));
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);
    curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, message);
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_NOPROXY, "*");
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, 10L);
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    if (http->unix_path)
        curl_easy_setopt(curl, CURLOPT_UNIX_SOCKET_PATH, http->unix_path);
    if (has_body) {
        curl_easy_setopt(curl, CURLOPT_UPLOAD, 1L);
        curl_easy_setopt(curl, CURLOPT_READFUNCTION, give_body);
        curl_easy_setopt(curl, CURLOPT_READDATA, exchange);
        curl_easy_setopt(curl, CURLOPT_INFILESIZE_LARGE, (curl_off_t)exchange->body->size);
    }
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, take_body);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, exchange);
    curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, take_header);
    curl_easy_setopt(curl, CURLOPT_HEADERDATA, exchange);
    curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, watch);
    curl_easy_setopt(curl, CURLOPT_XFERINFODATA, exchange);
    curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
}

static pm_status explain(const pm_http *http, CURLcode code, const struct exchange *exchange,
                         const char *message, pm_error *err)
{
    if (code == CURLE_ABORTED_BY_CALLBACK && is_interrupted(http))
        return pm_error_set(err, PM_E_CANCELLED, "interrupted");
    if (exchange->write_error)
        return pm_error_set(err, PM_E_IO, "cannot be written: %s",
                            strerror(exchange->write_error));
    return pm_error_set(err, PM_E_UNREACHABLE, "server at %s: %s",
                        http->unix_path ? http->unix_path : http->url,
                        *message ? message : curl_easy_strerror(code));
}

pm_status pm_http_send(pm_http *http, const char *method, const char *path,
                       const pm_http_body *body, FILE *into, pm_response *out, pm_error *err)
{
    static const pm_http_body nothing;
    char url[2048], message[CURL_ERROR_SIZE] = "";
    pm_response response = {0};
    struct exchange exchange = {
        .http = http, .body = body ? body : &nothing, .into = into, .out = &response};
    snprintf(url, sizeof url, "%s%s", http->url, path);
    struct curl_slist *headers = headers_of(http, exchange.body);
    set_up(http, method, url, &exchange, headers, message);
    CURLcode code = curl_easy_perform(http->curl);
    curl_easy_getinfo(http->curl, CURLINFO_RESPONSE_CODE, &response.status);
    curl_slist_free_all(headers);
    if (code) {
        pm_response_clear(&response);
        return explain(http, code, &exchange, message, err);
    }
    *out = response;
    return PM_OK;
}

void pm_response_clear(pm_response *response)
{
    pm_bytes_clear(&response->body);
}
