#ifndef PM_CLIENT_VERBS_H
#define PM_CLIENT_VERBS_H

#include "base/error.h"
#include "options.h"

/* Sees whether a command line makes sense, before anything is done. An error that names no file
 * is one of the command line. */
PM_MUST_USE pm_status pm_check_render(const pm_options *options, pm_error *err); /* and rpict */
PM_MUST_USE pm_status pm_check_trace(const pm_options *options, pm_error *err); /* and rtrace */
PM_MUST_USE pm_status pm_check_mkpmap(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_check_pmapinfo(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_check_pmapdump(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_check_oconv(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_check_look(const pm_options *options, pm_error *err);

/* What each verb does with its options once they are checked. On failure the error says why;
 * nothing half-written is left. */
PM_MUST_USE pm_status pm_verb_render(const pm_options *options, pm_error *err); /* and rpict */
PM_MUST_USE pm_status pm_verb_trace(const pm_options *options, pm_error *err);  /* and rtrace */
PM_MUST_USE pm_status pm_verb_mkpmap(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_verb_pmapinfo(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_verb_pmapdump(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_verb_oconv(const pm_options *options, pm_error *err);
PM_MUST_USE pm_status pm_verb_look(const pm_options *options,
                                   pm_error *err); /* scene map job */

/* The command line as typed, for headers. */
extern const char *pm_command_line;

#endif
