#ifndef PM_SERVER_OPTIONS_H
#define PM_SERVER_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/error.h"

/* The command line of pmserver. */
typedef struct pm_options {
    char *store;                                                  /* to be freed */
    const char *listen, *unix_path, *exit_when_idle, *token_file; /* NULL: not given */
    char *worker;                                                 /* to be freed */
    unsigned jobs;
    uint64_t memory_limit, cpu_limit, blob_limit, store_limit; /* 0 = none */
    unsigned patience_s, connections;
    bool help, verbose;
} pm_options;

extern const char pm_options_help[];

PM_MUST_USE pm_status pm_options_parse(int argc, char **argv, pm_options *out, pm_error *err);
void pm_options_clear(pm_options *options);

#endif
