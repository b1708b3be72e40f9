#ifndef PM_CLIENT_VERBS_H
#define PM_CLIENT_VERBS_H

#include "base/error.h"
#include "options.h"

/* What each verb does with its options. On failure the error says why; nothing half-written is
 * left. */
PM_MUST_USE pm_status pm_verb_render(const pm_options *options, pm_error *err); /* and rpict */
PM_MUST_USE pm_status pm_verb_trace(const pm_options *options, pm_error *err);  /* and rtrace */
PM_MUST_USE pm_status pm_verb_mkpmap(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_verb_pmapinfo(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_verb_map(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_verb_job(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_verb_scene(const pm_options *options, pm_error *err);

/* The command line as typed, for headers. */
extern const char *pm_command_line;

#endif
