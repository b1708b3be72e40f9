#include "access.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

enum { TOKEN_MIN = 16, TOKEN_MAX = 256 };

static pm_status add_token(pm_access *access, const char *token, pm_error *err)
{
    char **tokens = realloc(access->tokens, (access->token_count + 1) * sizeof *access->tokens);
    if (tokens)
        access->tokens = tokens;
    char *copy = tokens ? strdup(token) : NULL;
    if (!copy)
        return pm_error_set(err, PM_E_MEMORY, "no memory for tokens");
    access->tokens[access->token_count++] = copy;
    return PM_OK;
}

static pm_status read_lines(FILE *file, const char *path, pm_access *access, pm_error *err)
{
    char line[TOKEN_MAX + 2];
    pm_status st = PM_OK;
    for (int number = 1; !st && fgets(line, sizeof line, file); number++) {
        size_t length = strcspn(line, "\r\n");
        bool is_whole = line[length] || feof(file);
        line[length] = '\0';
        if (!length)
            continue;
        if (!is_whole || length < TOKEN_MIN || strpbrk(line, " \t"))
            return pm_error_set_at(err, PM_E_RANGE, path, number, 1,
                                   "a token has %d to %d characters without blanks", TOKEN_MIN,
                                   TOKEN_MAX);
        st = add_token(access, line, err);
    }
    if (!st && !access->token_count)
        st = pm_error_set_at(err, PM_E_SYNTAX, path, 0, 0, "holds no token");
    return st;
}

pm_status pm_access_read_tokens(const char *path, pm_access *out, pm_error *err)
{
    struct stat about;
    FILE *file = fopen(path, "re");
    if (!file)
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be read: %s", strerror(errno));
    pm_access access = {0};
    pm_status st;
    if (fstat(fileno(file), &about) || (about.st_mode & (S_IRWXG | S_IRWXO)))
        st = pm_error_set_at(err, PM_E_RANGE, path, 0, 0,
                             "may be read by others; `chmod 600` it");
    else
        st = read_lines(file, path, &access, err);
    fclose(file);
    if (st)
        pm_access_clear(&access);
    else
        *out = access;
    return st;
}

void pm_access_clear(pm_access *access)
{
    for (size_t i = 0; i < access->token_count; i++)
        free(access->tokens[i]);
    free(access->tokens);
    *access = (pm_access){0};
}

/* ---- checks ---- */

/* The length of the name in "name:port" or "[address]:port". */
static size_t name_length(const char *host)
{
    if (*host == '[') {
        const char *end = strchr(host, ']');
        return end ? (size_t)(end - host) + 1 : strlen(host);
    }
    return strcspn(host, ":");
}

static bool is_loopback_name(const char *host)
{
    static const char *const names[] = {"localhost", "127.0.0.1", "[::1]"};
    size_t length = name_length(host);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strlen(names[i]) == length && !strncasecmp(host, names[i], length))
            return true;
    return false;
}

static bool is_own_origin(const char *origin, const char *host)
{
    const char *rest = NULL;
    if (!strncasecmp(origin, "http://", 7))
        rest = origin + 7;
    else if (!strncasecmp(origin, "https://", 8))
        rest = origin + 8;
    return rest && !strcasecmp(rest, host);
}

/* Takes the same time wherever two tokens differ. */
static bool equal_tokens(const char *a, const char *b)
{
    size_t length = strlen(a), expected = strlen(b);
    unsigned differ = length != expected;
    for (size_t i = 0; i < length; i++)
        differ |= (unsigned)(a[i] ^ b[expected ? i % expected : 0]);
    return !differ;
}

static bool knows_token(const pm_access *access, const char *authorization)
{
    bool known = false;
    if (!authorization || strncasecmp(authorization, "Bearer ", 7) != 0)
        return false;
    for (size_t i = 0; i < access->token_count; i++)
        known |= equal_tokens(authorization + 7, access->tokens[i]);
    return known;
}

unsigned pm_access_check(const pm_access *access, pm_door door, const char *host,
                         const char *origin, const char *authorization, const char **why)
{
    if (door == PM_DOOR_LOOPBACK && (!host || !is_loopback_name(host))) {
        *why =
            "Host must be localhost, 127.0.0.1 or [::1]: this server answers its own machine";
        return 403;
    }
    if (origin && (!host || !is_own_origin(origin, host))) {
        *why = "Origin is another site";
        return 403;
    }
    if (door != PM_DOOR_UNIX && (access->token_count || door == PM_DOOR_NETWORK) &&
        !knows_token(access, authorization)) {
        *why = "send a token of the server's --token-file as `Authorization: Bearer TOKEN`";
        return 401;
    }
    return 0;
}
