#ifndef PM_CLIENT_OPTIONS_H
#define PM_CLIENT_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "backward/view.h"
#include "base/error.h"
#include "base/rgb.h"
#include "forward/options.h"
#include "forward/photon.h"
#include "surround.h"

/* The command line: Radiance's option spellings where Radiance has one. */

/* Bits, so that the table of options can say which verbs an option belongs to. */
typedef enum pm_verb {
    PM_VERB_RENDER = 1 << 0,
    PM_VERB_TRACE = 1 << 1,
    PM_VERB_MKPMAP = 1 << 2,
    PM_VERB_RPICT = 1 << 3,
    PM_VERB_RTRACE = 1 << 4,
    PM_VERB_SCENE = 1 << 5,
    PM_VERB_MAP = 1 << 6,
    PM_VERB_JOB = 1 << 7,
    PM_VERB_PMAPINFO = 1 << 8,
    PM_VERB_PMAPDUMP = 1 << 9,
    PM_VERB_OCONV = 1 << 10,
} pm_verb;

/* How one map is dumped: the options before its name. */
typedef struct pm_dump_option {
    uint64_t count;        /* -n: photons at most */
    double radius_scale;   /* -r */
    double radius;         /* of all spheres [scene units]; 0: fitting */
    bool points;           /* -a: lines of x y z r g b, no scene */
    bool by_flux, colored; /* -f; -c */
    pm_rgb color;          /* of -c */
} pm_dump_option;

/* How an octree is made. */
typedef struct pm_oconv_option {
    uint32_t set_size, resolution; /* -n, -r; 0: the default */
    bool bounded;                  /* -b */
    double corner[3], edge;
    bool frozen;       /* -f */
    const char *input; /* -i: an octree to start from */
} pm_oconv_option;

enum {
    PM_OPERANDS_MAX = 255,
    PM_OUTPUTS_MAX = 8,
    PM_ALLOWED_MAX = 16,
    PM_NAMES_MAX = 1024, /* modifiers of one option */
    PM_REGIONS_MAX = 1024,
    PM_NAME_FILES_MAX = 64,
};

typedef struct pm_names_option {
    const char *names[PM_NAMES_MAX];
    size_t count;
} pm_names_option;

/* What was said about one kind of map. */
typedef struct pm_map_option {
    bool given;
    uint64_t count;      /* render, trace, mkpmap: photons wanted */
    uint32_t gather;     /* photons an estimate; 0 = the server's default */
    uint32_t gather_max; /* 0: as many as gather */
    bool precomputed;    /* of the global one: -app */
    const char *file;    /* rpict, rtrace: read; mkpmap: written */
} pm_map_option;

enum { PM_FIELDS_MAX = 16 };

typedef struct pm_options {
    pm_verb verb;
    const char *server;     /* --server or PM_SERVER; NULL: a private one */
    const char *token_file; /* --token-file or PM_TOKEN_FILE */
    bool quiet, verbose, help;
    const char *operands[PM_OPERANDS_MAX]; /* words that are no options */
    unsigned operand_count;
    pm_dump_option dump, dumps[PM_OPERANDS_MAX]; /* pmapdump: of the next operand, of each */

    pm_oconv_option oconv;

    pm_map_option maps[PM_MAP_KINDS];
    pm_map_option detected[PM_MAP_KINDS]; /* -ap FILE: kinds are read from the files */
    unsigned detected_count;
    double fraction;       /* -apf, -apP: of a precomputed map; 0: the server's default */
    const char *bandwidth; /* how to choose between the two; NULL: the server's default */
    int ambient_bounces;   /* -ab */
    pm_view view;
    uint32_t x, y;
    double pixel_aspect; /* -pa; 0: x by y as given */
    uint32_t passes;
    uint32_t sequence; /* mkpmap --passes; 0: one map */
    bool one_pass;     /* map fetch --pass */
    uint32_t pass;
    double seconds, error;
    uint64_t seed;
    uint32_t max_events;                /* 0: the server's default */
    double max_length;                  /* -ld; 0: none */
    pm_surroundings surroundings;       /* -me, -ma, -mg, -bv */
    const char *messages;               /* -e: where messages go; NULL: standard error */
    pm_port_option ports[PM_NAMES_MAX]; /* -apo, -apO */
    size_t port_count;
    double direction_resolution, partition; /* -dp, -ds; 0: the server's default */
    pm_names_option sensors;                /* -aps, -apS */
    pm_names_option exclude, include;       /* -ae, -aE; -ai, -aI */
    pm_region regions[PM_REGIONS_MAX];      /* -api, -apI */
    size_t region_count;
    char *name_files[PM_NAME_FILES_MAX]; /* texts that names point into */
    size_t name_file_count;
    uint32_t threads;
    double progress_seconds;             /* -t */
    bool overwrite;                      /* -fo */
    bool irradiance;                     /* rtrace -I */
    bool no_header;                      /* rtrace -h */
    bool errors;                         /* trace --errors */
    char input_format, output_format;    /* rtrace -f: a, f, d; and c */
    char fields[PM_FIELDS_MAX];          /* rtrace -o: what to print, v the value */
    bool json;                           /* scene, map, job --json */
    const char *outputs[PM_OUTPUTS_MAX]; /* -o */
    unsigned output_count;
    const char *allowed[PM_ALLOWED_MAX]; /* --allow: folders whose files may be sent */
    unsigned allowed_count;
} pm_options;

/* Reads argv[0..argc) behind the verb. PM_E_RANGE, PM_E_MISSING or PM_E_UNSUPPORTED with a text
 * that names the option and what would be right. Borrows argv. What it read from files is freed
 * by pm_options_clear. */
PM_MUST_USE pm_status pm_options_parse(pm_verb verb, int argc, char **argv, pm_options *out,
                                       pm_error *err);
void pm_options_clear(pm_options *read);

/* "100k" -> 100000; k, m, g are powers of 1000, as mkpmap has them. */
PM_MUST_USE pm_status pm_count_parse(const char *text, uint64_t *out);

/* "90", "90s", "1.5m", "2h" -> seconds. */
PM_MUST_USE pm_status pm_seconds_parse(const char *text, double *out);

/* "2%" or ".02" -> .02 */
PM_MUST_USE pm_status pm_share_parse(const char *text, double *out);

/* The options of a verb, a line each, from the same table that reads them. */
void pm_options_print(pm_verb verb, FILE *to);

#endif
