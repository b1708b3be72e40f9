#ifndef PM_SERVER_WORKER_JOB_H
#define PM_SERVER_WORKER_JOB_H

/* Serves the one job of a worker: takes the message "job" from the socket, runs it, and sends
 * what came of it. Returns the process's exit status: 0 if an answer or a reason was sent. */
int pm_worker_serve(int socket);

#endif
