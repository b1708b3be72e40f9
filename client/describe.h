#ifndef PM_CLIENT_DESCRIBE_H
#define PM_CLIENT_DESCRIBE_H

#include <stdbool.h>
#include <stdio.h>

#include "json.h"

/* The server's documents as text for people. Members that are missing are passed over. */
void pm_describe_scene(const pm_json *scene, FILE *to);
void pm_describe_map(const pm_json *map, FILE *to);
void pm_describe_job(const pm_json *job, FILE *to);

/* Lists, a line an entry; the first word is what `info` and `show` take. */
void pm_describe_maps(const pm_json *maps, bool heading, FILE *to);
void pm_describe_jobs(const pm_json *jobs, bool heading, FILE *to);

#endif
