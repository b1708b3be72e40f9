#ifndef PM_SERVER_PROBLEM_H
#define PM_SERVER_PROBLEM_H

#include "base/error.h"
#include "json.h"

/* Problem documents (RFC 9457): {type, status, title, detail} and, where known, file, line,
 * column or member. */

/* The HTTP status of an error in what somebody asked for. */
unsigned pm_problem_status(pm_status status);

/* Both return NULL if memory is short. */
pm_json *pm_problem(unsigned status, const char *detail);
pm_json *pm_problem_of(const pm_error *err);        /* a scene, a map file, a job */
pm_json *pm_problem_of_member(const pm_error *err); /* err->file is a member of the body */

/* The phrase of an HTTP status, e.g. "Not Found". */
const char *pm_problem_title(unsigned status);

#endif
