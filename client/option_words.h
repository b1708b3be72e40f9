#ifndef PM_CLIENT_OPTION_WORDS_H
#define PM_CLIENT_OPTION_WORDS_H

#include "options.h"

/* Reading a command line: the words, and the options that take them. The table of all options
 * is in options.c. */

enum {
    RENDERING = PM_VERB_RENDER | PM_VERB_TRACE,
    RADIANCE = PM_VERB_RPICT | PM_VERB_RTRACE,
    PICTURES = PM_VERB_RENDER | PM_VERB_RPICT,
    POINTS = PM_VERB_TRACE | PM_VERB_RTRACE,
    LOOKING = RENDERING | RADIANCE,
    WORKING = LOOKING | PM_VERB_MKPMAP,
    TRACING = RENDERING | PM_VERB_MKPMAP, /* verbs that trace photons */
    ONLINE = WORKING | PM_VERB_SCENE | PM_VERB_MAP | PM_VERB_JOB,
    MAPS = PM_VERB_PMAPINFO | PM_VERB_PMAPDUMP,
    ALL = ONLINE | MAPS | PM_VERB_OCONV,
};

struct pm_words;

struct pm_option {
    const char *name;
    unsigned verbs;
    const char *arguments;
    const char *doc;
    pm_status (*take)(struct pm_words *words);
    size_t offset; /* of a switch: its place in pm_options and what it sets there */
    bool value;
    const char *letters; /* one or more of these follow the name; NULL: none do */
};

/* Where reading stands. */
struct pm_words {
    const struct pm_option *entry; /* the option being read, if it is in the table */
    int argc;
    char **argv;
    int at;             /* the next word */
    const char *option; /* the one being read */
    const char *value;  /* what stood behind its '=', until it is taken */
    char name[32];      /* its name then */
    pm_options *out;
    pm_error *err;
};

/* ---- words (option_words.c) ---- */

/* PM_E_RANGE: "OPTION GOT: must be RIGHT". */
PM_MUST_USE pm_status pm_word_bad(const struct pm_words *words, const char *got,
                                  const char *right);

#define PM_SWITCH_TAILS "+1yYtT-0nNfF" /* of a switch of Radiance's: on, then off */

/* Sets what the letter behind the option says; without one it becomes the other. */
void pm_word_toggle(const struct pm_words *words, bool *out);

/* The option's next argument; `what` is for the message. */
PM_MUST_USE pm_status pm_word_text(struct pm_words *words, const char *what, const char **out);
PM_MUST_USE pm_status pm_word_count(struct pm_words *words, const char *what, uint64_t low,
                                    uint64_t high, uint64_t *out);
PM_MUST_USE pm_status pm_word_u32(struct pm_words *words, const char *what, uint32_t low,
                                  uint32_t high, uint32_t *out);
PM_MUST_USE pm_status pm_word_number(struct pm_words *words, const char *what, double *out);
PM_MUST_USE pm_status pm_word_numbers(struct pm_words *words, const char *what, size_t count,
                                      double *out);

/* Whether the next word is a whole number. */
bool pm_word_is_count(const struct pm_words *words);

/* ---- what options take: each reads its arguments into words->out ---- */

/* option_maps.c */
PM_MUST_USE pm_status pm_take_precomputed(struct pm_words *words);
PM_MUST_USE pm_status pm_take_fraction(struct pm_words *words);
PM_MUST_USE pm_status pm_take_map(struct pm_words *words);
PM_MUST_USE pm_status pm_take_detected_map(struct pm_words *words);
PM_MUST_USE pm_status pm_take_bandwidth(struct pm_words *words);
PM_MUST_USE pm_status pm_take_bounces(struct pm_words *words);
PM_MUST_USE pm_status pm_take_sequence(struct pm_words *words);
PM_MUST_USE pm_status pm_take_pass(struct pm_words *words);

/* option_views.c */
PM_MUST_USE pm_status pm_take_vector(struct pm_words *words);
PM_MUST_USE pm_status pm_take_angle(struct pm_words *words);
PM_MUST_USE pm_status pm_take_other_view(struct pm_words *words);
PM_MUST_USE pm_status pm_take_view_file(struct pm_words *words);
PM_MUST_USE pm_status pm_take_size(struct pm_words *words);
PM_MUST_USE pm_status pm_take_aspect(struct pm_words *words);

/* option_forward.c */
PM_MUST_USE pm_status pm_take_seed(struct pm_words *words);
PM_MUST_USE pm_status pm_take_max_events(struct pm_words *words);
PM_MUST_USE pm_status pm_take_max_length(struct pm_words *words);
PM_MUST_USE pm_status pm_take_medium(struct pm_words *words);
PM_MUST_USE pm_status pm_take_eccentricity(struct pm_words *words);
PM_MUST_USE pm_status pm_take_back_faces(struct pm_words *words);
PM_MUST_USE pm_status pm_take_name(struct pm_words *words);
PM_MUST_USE pm_status pm_take_name_file(struct pm_words *words);
PM_MUST_USE pm_status pm_take_port(struct pm_words *words);
PM_MUST_USE pm_status pm_take_port_file(struct pm_words *words);
PM_MUST_USE pm_status pm_take_port_tables(struct pm_words *words);
PM_MUST_USE pm_status pm_take_region(struct pm_words *words);

/* What the options of the forward pass and of the scene say together. */
PM_MUST_USE pm_status pm_check_forward(const pm_options *read, pm_error *err);

#endif
