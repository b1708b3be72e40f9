#include "options.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

const char pm_options_help[] =
    "pmserver - photon maps and pictures of Radiance scenes, over HTTP\n"
    "\n"
    "  pmserver [--store FILE] [--listen HOST:PORT] [options]\n"
    "\n"
    "Keeps scenes, photon maps, jobs and results in one SQLite file, and runs each job in a "
    "worker\n"
    "process of its own. Photons that were traced once are taken from the store afterwards. "
    "Prints\n"
    "`listening on http://127.0.0.1:PORT` and serves until it gets SIGINT or SIGTERM; jobs "
    "that were\n"
    "running are taken up again by the next pmserver on the same file.\n"
    "\n"
    "Where it listens\n"
    "  --listen HOST:PORT   default 127.0.0.1:8430; port 0: any free one. An address other "
    "than\n"
    "                       loopback needs --token-file, and a proxy that speaks TLS before "
    "it\n"
    "  --unix PATH          also on a Unix socket of mode 0600; alone, if --listen is not "
    "given\n"
    "  --token-file FILE    bearer tokens, one a line, 16 characters or more; file of mode "
    "0600\n"
    "  --connections N      most connections at a time, default 256\n"
    "  --patience SECONDS   for a request's head and for idle connections, default 30; bodies "
    "have\n"
    "                       a second more for each 16 KiB\n"
    "What it keeps\n"
    "  --store FILE         default $XDG_CACHE_HOME/pm/store.sqlite "
    "(~/.cache/pm/store.sqlite)\n"
    "  --store-limit BYTES  evict the least recently used batches and results above this; "
    "default\n"
    "                       none. k, m, g, t mean 2^10, 2^20, 2^30, 2^40\n"
    "  --blob-limit BYTES   largest upload, default 4g; 0: any\n"
    "How it works\n"
    "  --jobs N             jobs at a time, default 1\n"
    "  --memory-limit BYTES address space of a worker; default: three quarters of the "
    "machine's\n"
    "                       memory, shared out among the jobs and a scene check; 0: any\n"
    "  --cpu-limit SECONDS  CPU time of a worker, default none\n"
    "  --worker FILE        default: pmworker beside pmserver\n"
    "  --exit-when-idle FILE  private server: who uses it holds a shared flock(2) on FILE; "
    "when\n"
    "                       nobody does any more, it cancels what is left and ends\n"
    "  -v                   say on stderr what happens\n"
    "\n"
    "Try it, with a scene of one file:\n"
    "  curl --json \"$(jq -n --rawfile t scene.rad '{text: $t}')\" localhost:8430/v1/scenes\n"
    "  curl --json '{\"kind\": \"render\", \"scene\": \"ID\", \"view\": \"-vp 0 -5 1\", "
    "\"formats\": [\"png\"]}' \\\n"
    "       localhost:8430/v1/jobs\n"
    "  curl 'localhost:8430/v1/jobs/1?wait=30'; curl -o a.png localhost:8430/v1/jobs/1/result\n"
    "The whole API: curl localhost:8430/openapi.json\n";

/* ---- values ---- */

static pm_status read_count(const char *name, const char *text, uint64_t low, uint64_t high,
                            uint64_t *out, pm_error *err)
{
    static const char units[] = "kmgt";
    char *end;
    errno = 0;
    uint64_t value = strtoull(text, &end, 10);
    const char *unit = *end ? strchr(units, *end | 32) : NULL;
    unsigned shift = unit ? 10 * (unsigned)(unit - units + 1) : 0;
    if (unit)
        end++;
    if (errno || *text < '0' || *text > '9' || *end || value > UINT64_MAX >> shift ||
        value << shift < low || value << shift > high)
        return pm_error_set(err, PM_E_RANGE, "%s: \"%s\" must be an integer from %llu to %llu",
                            name, text, (unsigned long long)low, (unsigned long long)high);
    *out = value << shift;
    return PM_OK;
}

struct option {
    const char *name;
    size_t offset;
    enum { TEXT, OWNED, COUNT64, COUNT } type;
    uint64_t low, high;
};

static const struct option table[] = {
    {"--store", offsetof(pm_options, store), OWNED, 0, 0},
    {"--worker", offsetof(pm_options, worker), OWNED, 0, 0},
    {"--listen", offsetof(pm_options, listen), TEXT, 0, 0},
    {"--unix", offsetof(pm_options, unix_path), TEXT, 0, 0},
    {"--exit-when-idle", offsetof(pm_options, exit_when_idle), TEXT, 0, 0},
    {"--token-file", offsetof(pm_options, token_file), TEXT, 0, 0},
    {"--jobs", offsetof(pm_options, jobs), COUNT, 1, 64},
    {"--connections", offsetof(pm_options, connections), COUNT, 2, 10000},
    {"--patience", offsetof(pm_options, patience_s), COUNT, 1, 3600},
    {"--memory-limit", offsetof(pm_options, memory_limit), COUNT64, 0, UINT64_MAX},
    {"--cpu-limit", offsetof(pm_options, cpu_limit), COUNT64, 0, 1 << 30},
    {"--blob-limit", offsetof(pm_options, blob_limit), COUNT64, 0, UINT64_MAX},
    {"--store-limit", offsetof(pm_options, store_limit), COUNT64, 0, UINT64_MAX},
};

static pm_status set_owned(char **at, const char *value, pm_error *err)
{
    char *copy = strdup(value);
    if (!copy)
        return pm_error_set(err, PM_E_MEMORY, "no memory for options");
    free(*at);
    *at = copy;
    return PM_OK;
}

static pm_status set(const struct option *option, const char *value, pm_options *out,
                     pm_error *err)
{
    void *at = (char *)out + option->offset;
    uint64_t count = 0;
    if (option->type == OWNED)
        return set_owned(at, value, err);
    if (option->type == TEXT) {
        *(const char **)at = value;
        return PM_OK;
    }
    pm_status st = read_count(option->name, value, option->low, option->high, &count, err);
    if (!st && option->type == COUNT)
        *(unsigned *)at = (unsigned)count;
    else if (!st)
        *(uint64_t *)at = count;
    return st;
}

static pm_status read_word(char **argv, int *at, pm_options *out, pm_error *err)
{
    const char *word = argv[*at];
    if (!strcmp(word, "-v")) {
        out->verbose = true;
        return PM_OK;
    }
    if (!strcmp(word, "--help") || !strcmp(word, "-h")) {
        out->help = true;
        return PM_OK;
    }
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        if (strcmp(word, table[i].name) != 0)
            continue;
        if (!argv[*at + 1])
            return pm_error_set(err, PM_E_MISSING, "%s needs a value; see pmserver --help",
                                word);
        return set(&table[i], argv[++*at], out, err);
    }
    return pm_error_set(err, PM_E_UNSUPPORTED, "%s: no such option; see pmserver --help", word);
}

/* ---- defaults ---- */

static pm_status default_store(pm_options *out, pm_error *err)
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    char folder[3072], path[4096];
    if (cache && *cache == '/')
        snprintf(folder, sizeof folder, "%s", cache);
    else if (home && *home)
        snprintf(folder, sizeof folder, "%s/.cache", home);
    else
        return pm_error_set(err, PM_E_MISSING,
                            "no --store, and neither XDG_CACHE_HOME nor HOME");
    mkdir(folder, 0700);
    snprintf(path, sizeof path, "%s/pm", folder);
    if (mkdir(path, 0700) && errno != EEXIST)
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be made: %s", strerror(errno));
    strcat(path, "/store.sqlite");
    return set_owned(&out->store, path, err);
}

static pm_status default_worker(pm_options *out, pm_error *err)
{
    char path[4096];
    ssize_t length = readlink("/proc/self/exe", path, sizeof path - 16);
    char *slash = length > 0 ? memrchr(path, '/', (size_t)length) : NULL;
    if (!slash)
        return pm_error_set(err, PM_E_MISSING, "cannot find pmworker; give --worker");
    strcpy(slash + 1, "pmworker");
    return set_owned(&out->worker, path, err);
}

/* One scene that unfolds to more than the machine holds must not take the others with it. */
static uint64_t default_memory_limit(unsigned jobs)
{
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGE_SIZE);
    if (pages <= 0 || page <= 0)
        return 0;
    return (uint64_t)pages * (uint64_t)page / 4 * 3 / (jobs + 1);
}

pm_status pm_options_parse(int argc, char **argv, pm_options *out, pm_error *err)
{
    const uint64_t unset = UINT64_MAX;
    pm_options options = {.jobs = 1,
                          .connections = 256,
                          .patience_s = 30,
                          .memory_limit = unset,
                          .blob_limit = UINT64_C(4) << 30};
    pm_status st = PM_OK;
    for (int i = 1; i < argc && !st; i++)
        st = read_word(argv, &i, &options, err);
    if (options.memory_limit == unset)
        options.memory_limit = default_memory_limit(options.jobs);
    if (!st && !options.listen && !options.unix_path)
        options.listen = "127.0.0.1:8430";
    if (!st && !options.help && !options.store)
        st = default_store(&options, err);
    if (!st && !options.help && !options.worker)
        st = default_worker(&options, err);
    if (st)
        pm_options_clear(&options);
    else
        *out = options;
    return st;
}

void pm_options_clear(pm_options *options)
{
    free(options->store);
    free(options->worker);
    *options = (pm_options){0};
}
