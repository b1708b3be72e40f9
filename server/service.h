#ifndef PM_SERVER_SERVICE_H
#define PM_SERVER_SERVICE_H

#include "http.h"
#include "jobs.h"
#include "sandbox.h"
#include "store.h"

/* What is behind the routes. The paths are in service.c, their handlers in routes_*.c. */
typedef struct pm_service {
    pm_store *store;
    pm_jobs *jobs;
    pm_http *http;
    pm_sandbox_parts sandbox;
    const char *worker_path;
    int64_t started_ms; /* since 1970 */
} pm_service;

extern const pm_route pm_service_routes[]; /* for a pm_service; ended by a NULL method */

/* The OpenAPI 3.1 document. NULL if memory is short. */
pm_json *pm_openapi(void);

/* ---- what the handlers share ---- */

/* Replies with what an error in the request deserves: member and reason. */
pm_turn pm_reply_error(pm_exchange *exchange, const pm_error *err);
/* The same, but an error of the store: 500, 503 or 507. */
pm_turn pm_reply_store_error(pm_exchange *exchange, const pm_error *err);
/* Replies with a blob, whose first chunk is checked before. */
pm_turn pm_reply_blob(pm_service *service, pm_exchange *exchange, const pm_blob *blob,
                      const char *type);
/* The same with some of its bytes: first + size <= blob->size. `part` names them apart. */
pm_turn pm_reply_blob_part(pm_service *service, pm_exchange *exchange, const pm_blob *blob,
                           uint64_t first, uint64_t size, const char *part, const char *type);
/* {name: list}, or the error. */
pm_turn pm_reply_list(pm_exchange *exchange, const char *name, pm_status status, pm_json *list,
                      const pm_error *err);

/* ---- handlers ---- */

pm_turn pm_blob_put(void *service, pm_exchange *exchange);
bool pm_blob_receive(void *service, pm_exchange *exchange, const void *data, size_t size);
pm_turn pm_blob_get(void *service, pm_exchange *exchange);

pm_turn pm_scene_post(void *service, pm_exchange *exchange);
pm_turn pm_scene_list(void *service, pm_exchange *exchange);
pm_turn pm_scene_get(void *service, pm_exchange *exchange);

pm_turn pm_job_post(void *service, pm_exchange *exchange);
pm_turn pm_job_list(void *service, pm_exchange *exchange);
pm_turn pm_job_get(void *service, pm_exchange *exchange);
pm_turn pm_job_delete(void *service, pm_exchange *exchange);
pm_turn pm_job_result(void *service, pm_exchange *exchange);

pm_turn pm_map_list(void *service, pm_exchange *exchange);
pm_turn pm_map_get(void *service, pm_exchange *exchange);
pm_turn pm_map_photons(void *service, pm_exchange *exchange);
pm_turn pm_map_pass(void *service, pm_exchange *exchange);

pm_turn pm_about_health(void *service, pm_exchange *exchange);
pm_turn pm_about_ready(void *service, pm_exchange *exchange);
pm_turn pm_about_metrics(void *service, pm_exchange *exchange);
pm_turn pm_about_openapi(void *service, pm_exchange *exchange);

#endif
