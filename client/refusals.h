#ifndef PM_CLIENT_REFUSALS_H
#define PM_CLIENT_REFUSALS_H

#include "options.h"

/* Why an option of Radiance's program of that name is not offered here, or NULL if that program
 * has no such option. For render and trace: those of rpict and rtrace. */
const char *pm_refusal_of(pm_verb verb, const char *option);

/* Of names[0..count) the one that `word` most likely was meant to be, or NULL: dashes do not
 * count, and at most two letters differ, or one of three. */
const char *pm_closest(const char *word, const char *const *names, size_t count);

#endif
