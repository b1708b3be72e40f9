#include "problem.h"

#include <stdio.h>

unsigned pm_problem_status(pm_status status)
{
    switch (status) {
    case PM_E_IO:
        return 507;
    case PM_E_MEMORY:
        return 503;
    case PM_E_CANCELLED:
        return 409;
    default:
        return 422;
    }
}

static const struct {
    unsigned status;
    const char *title;
} titles[] = {
    {400, "Bad Request"},
    {401, "Unauthorized"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {409, "Conflict"},
    {410, "Gone"},
    {413, "Content Too Large"},
    {415, "Unsupported Media Type"},
    {416, "Range Not Satisfiable"},
    {422, "Unprocessable Content"},
    {500, "Internal Server Error"},
    {503, "Service Unavailable"},
    {507, "Insufficient Storage"},
};

const char *pm_problem_title(unsigned status)
{
    for (size_t i = 0; i < sizeof titles / sizeof *titles; i++)
        if (titles[i].status == status)
            return titles[i].title;
    return "Error";
}

pm_json *pm_problem(unsigned status, const char *detail)
{
    return pm_json_pack("{s:s, s:i, s:s, s:o}", "type", "about:blank", "status", (int)status,
                        "title", pm_problem_title(status), "detail", pm_json_quote(detail));
}

static bool put_place(pm_json *problem, const pm_error *err)
{
    bool made = !err->file[0] || pm_json_put(problem, "file", pm_json_quote(err->file));
    if (made && err->line > 0)
        made = pm_json_put(problem, "line", pm_json_pack("i", err->line)) &&
               pm_json_put(problem, "column", pm_json_pack("i", err->column));
    return made;
}

pm_json *pm_problem_of(const pm_error *err)
{
    pm_json *problem = pm_problem(pm_problem_status(err->status), err->text);
    if (problem && put_place(problem, err))
        return problem;
    pm_json_free(problem);
    return NULL;
}

pm_json *pm_problem_of_member(const pm_error *err)
{
    char text[1200];
    pm_error_format(err, text, sizeof text);
    pm_json *problem = pm_problem(pm_problem_status(err->status), text);
    if (problem && (!err->file[0] || pm_json_put(problem, "member", pm_json_quote(err->file))))
        return problem;
    pm_json_free(problem);
    return NULL;
}
