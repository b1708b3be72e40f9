#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/bytes.h"
#include "interrupt.h"
#include "refusals.h"
#include "verbs.h"

/* Exit statuses, as the manual page lists them. */
enum { EXIT_USAGE = 2, EXIT_UNREACHABLE = 3, EXIT_INTERRUPTED = 130 };

const char *pm_command_line = "";
volatile sig_atomic_t pm_interrupted;

struct verb {
    const char *name;
    pm_verb bit;
    unsigned scenes; /* operands wanted; 0: the verb looks for itself */
    const char *usage, *summary, *text;
    pm_status (*check)(const pm_options *options, pm_error *err);
    pm_status (*run)(const pm_options *options, pm_error *err);
};

static const struct verb verbs[] = {
    {"render", PM_VERB_RENDER, 1, "render SCENE.rad [OPTION...] -o FILE",
     "a picture of a scene",
     "Without map options the picture is progressive: passes of photons with a shrinking "
     "radius,\n"
     "until --error (2% if nothing is said), --time (60s) or --passes. With -apg, -apc, -apv "
     "it is\n"
     "Radiance's way: the K nearest of about N photons, 16 passes if nothing is said.\n\n"
     "  pmclient render room.rad --vf view.vf -x 512 -y 512 --time 20s -o room.exr -o "
     "room.png\n"
     "  pmclient render room.rad --vf view.vf -apg 100k 50 -apc 250k 50 -ab 1 -o room.hdr",
     pm_check_render, pm_verb_render},
    {"trace", PM_VERB_TRACE, 1, "trace SCENE.rad [OPTION...] < POINTS",
     "irradiance at points [W/m^2]",
     "Reads lines of `x y z nx ny nz` and prints a line `r g b` for each, in order.\n\n"
     "  echo '1 2 .8  0 0 1' | pmclient trace room.rad --error 1%",
     pm_check_trace, pm_verb_trace},
    {"mkpmap", PM_VERB_MKPMAP, 1, "mkpmap -apg FILE N [-apc FILE N] [OPTION...] SCENE.rad",
     "photon maps as files",
     "  pmclient mkpmap -apg room.gpm 10k -apc room.cpm 50k -t 10 room.rad", pm_check_mkpmap,
     pm_verb_mkpmap},
    {"rpict", PM_VERB_RPICT, 1, "rpict [OPTION...] SCENE.rad > PICTURE.hdr",
     "a picture from map files, as Radiance's rpict",
     "  pmclient rpict -ab 1 -apg room.gpm 50 -apc room.cpm 50 -vf view.vf room.rad > room.hdr",
     pm_check_render, pm_verb_render},
    {"rtrace", PM_VERB_RTRACE, 1, "rtrace [OPTION...] SCENE.rad < RAYS",
     "values from map files, as Radiance's rtrace",
     "Reads lines of `x y z dx dy dz`; with -I they are points and normals.\n\n"
     "  pmclient rtrace -I -h -ab -1 -apg room.gpm 50 room.rad < points.txt",
     pm_check_trace, pm_verb_trace},
    {"pmapinfo", PM_VERB_PMAPINFO, 0, "pmapinfo FILE...", "what map files hold",
     "  pmclient pmapinfo room.gpm", pm_check_pmapinfo, pm_verb_pmapinfo},
    {"pmapdump", PM_VERB_PMAPDUMP, 0, "pmapdump [OPTION...] MAP... | pmapdump RADIUS MAP...",
     "photons as a scene of spheres, on standard output",
     "Each option is for the next map alone. With a radius in front every photon is a sphere "
     "of "
     "that radius.\n\n"
     "  pmclient pmapdump .01 room.gpm room.cpm | pmclient oconv -n 16 - room.rad > dump.oct\n"
     "  pmclient pmapdump -n 20k -f room.gpm > photons.rad",
     pm_check_pmapdump, pm_verb_pmapdump},
    {"oconv", PM_VERB_OCONV, 0, "oconv [OPTION...] FILE... > OCTREE",
     "an octree of scene files, as Radiance's oconv",
     "The files make one scene, in their order; - is standard input. Without -f the octree "
     "names\n"
     "its files, which must stay where they are; with - among them it is frozen in any case. "
     "Every\n"
     "verb that takes a scene takes an octree, too.\n\n"
     "  pmclient oconv materials.rad room.rad > room.oct\n"
     "  pmclient oconv -f room.rad -o room.oct\n"
     "  pmclient pmapdump .01 room.gpm | pmclient oconv -n 16 - room.rad > dump.oct",
     pm_check_oconv, pm_verb_oconv},
    {"scene", PM_VERB_SCENE, 0, "scene check SCENE.rad", "what a scene holds, or what is wrong",
     "  pmclient scene check room.rad", pm_check_look, pm_verb_look},
    {"map", PM_VERB_MAP, 0, "map list | info KEY | fetch KEY -o FILE",
     "the maps that the server keeps", "  pmclient map list", pm_check_look, pm_verb_look},
    {"job", PM_VERB_JOB, 0, "job list | show ID | cancel ID", "the jobs of the server",
     "  pmclient --server http://127.0.0.1:8080 job list", pm_check_look, pm_verb_look},
};

enum { VERBS = sizeof verbs / sizeof *verbs };

static void print_help(FILE *to)
{
    fprintf(to, "pmclient: photon maps for Radiance scenes\n\nusage:\n");
    for (size_t i = 0; i < VERBS; i++)
        fprintf(to, "  pmclient %-58s %s\n", verbs[i].usage, verbs[i].summary);
    fprintf(
        to,
        "\n`pmclient VERB --help` says more. Without --server URL (or PM_SERVER) a private\n"
        "server runs for as long as the command; its cache is $PM_STORE, or\n"
        "~/.cache/pm/store.sqlite.\n");
}

static void print_verb_help(const struct verb *verb)
{
    printf("usage: pmclient %s\n\n%s.\n\n%s\n\noptions:\n", verb->usage, verb->summary,
           verb->text);
    pm_options_print(verb->bit, stdout);
}

static void interrupt(int signal_number)
{
    (void)signal_number;
    pm_interrupted = pm_interrupted + 1;
}

/* Without SA_RESTART, so that waiting ends. Whoever ignores SIGHUP (nohup) goes on doing so. */
static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = interrupt}, old;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    if (!sigaction(SIGHUP, NULL, &old) && old.sa_handler != SIG_IGN)
        sigaction(SIGHUP, &action, NULL);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* a file size limit is a full disk */
}

/* A standard stream that the caller closed must not become some file that is opened later. What
 * stands in for it cannot be used: reading or writing it is the error that it should be. */
static bool fill_standard_streams(void)
{
    for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; stream++)
        if (fcntl(stream, F_GETFD) < 0 &&
            open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream)
            return false;
    return true;
}

/* A word of the command line as a shell would need it. */
static void quote(pm_bytes *line, const char *word)
{
    if (*word && !strpbrk(word, " \t\n'\"\\$`*?[]{}()<>|&;~#!")) {
        pm_bytes_text(line, word);
        return;
    }
    pm_bytes_text(line, "'");
    for (; *word; word++) {
        if (*word == '\'')
            pm_bytes_text(line, "'\\''");
        else if ((unsigned char)*word >= ' ')
            pm_bytes_u8(line, (uint8_t)*word);
    }
    pm_bytes_text(line, "'");
}

static void join(pm_bytes *line, int argc, char **argv)
{
    for (int i = 0; i < argc; i++) {
        if (i)
            pm_bytes_text(line, " ");
        quote(line, i ? argv[i] : "pmclient");
    }
    pm_bytes_u8(line, 0);
}

static int fail(pm_status st, const pm_error *err, bool usage)
{
    char text[1200];
    pm_error_format(err, text, sizeof text);
    fprintf(stderr, "pmclient: %s\n", pm_interrupted ? "interrupted" : text);
    if (pm_interrupted)
        return EXIT_INTERRUPTED;
    if (usage)
        return EXIT_USAGE;
    return st == PM_E_UNREACHABLE ? EXIT_UNREACHABLE : EXIT_FAILURE;
}

static pm_status check(const struct verb *verb, const pm_options *options, pm_error *err)
{
    if (verb->scenes && options->operand_count != verb->scenes) {
        if (!options->operand_count)
            return pm_error_set(err, PM_E_MISSING, "the scene is missing: pmclient %s",
                                verb->usage);
        return pm_error_set(err, PM_E_RANGE, "%s: one scene is enough: pmclient %s",
                            options->operands[1], verb->usage);
    }
    return verb->check(options, err);
}

/* -e FILE: whatever is said from here on is appended there, under the command. */
static pm_status redirect_messages(const char *path, pm_error *err)
{
    int file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (file < 0 || dup2(file, STDERR_FILENO) < 0) {
        pm_status st =
            pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be written: %s", strerror(errno));
        if (file >= 0)
            close(file);
        return st;
    }
    close(file);
    fprintf(stderr, "# %s\n", pm_command_line);
    return PM_OK;
}

static int work(const struct verb *verb, const pm_options *options)
{
    pm_error err = PM_ERROR_INIT;
    pm_status st = check(verb, options, &err);
    if (st)
        return fail(st, &err, !err.file[0]);
    if (options->messages)
        st = redirect_messages(options->messages, &err);
    if (!st)
        st = verb->run(options, &err);
    return st ? fail(st, &err, false) : EXIT_SUCCESS;
}

static int run(const struct verb *verb, int argc, char **argv)
{
    pm_options options;
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_options_parse(verb->bit, argc, argv, &options, &err);
    if (st)
        return fail(st, &err, !err.file[0]);
    int status = options.help ? EXIT_SUCCESS : work(verb, &options);
    if (options.help)
        print_verb_help(verb);
    pm_options_clear(&options);
    return status;
}

/* Global options may stand before the verb: they move behind it. */
static int find_verb(int argc, char **argv)
{
    int at = 1;
    while (at < argc && argv[at][0] == '-')
        at += !strcmp(argv[at], "--server") || !strcmp(argv[at], "--token-file") ? 2 : 1;
    return at < argc ? at : 0;
}

static void move_behind(char **argv, int at)
{
    char *verb = argv[at];
    memmove(argv + 2, argv + 1, (size_t)(at - 1) * sizeof *argv);
    argv[1] = verb;
}

static const struct verb *verb_named(const char *name)
{
    for (size_t i = 0; i < VERBS; i++)
        if (!strcmp(name, verbs[i].name))
            return &verbs[i];
    return NULL;
}

static int refuse_verb(const char *name)
{
    const char *names[VERBS];
    for (size_t i = 0; i < VERBS; i++)
        names[i] = verbs[i].name;
    const char *closest = pm_closest(name, names, VERBS);
    if (closest)
        fprintf(stderr, "pmclient: %s: unknown verb; did you mean %s?\n", name, closest);
    else
        fprintf(stderr, "pmclient: %s: unknown verb; pmclient --help lists them\n", name);
    return EXIT_USAGE;
}

/* Without a verb: --help, --version, or nothing that makes sense. */
static int run_bare(int argc, char **argv)
{
    bool help = argc == 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"));
    if (argc == 2 && !strcmp(argv[1], "--version")) {
        puts("pmclient " PM_VERSION);
        return EXIT_SUCCESS;
    }
    print_help(help ? stdout : stderr);
    return help ? EXIT_SUCCESS : EXIT_USAGE;
}

static int run_words(int argc, char **argv)
{
    int at = find_verb(argc, argv);
    if (!at)
        return run_bare(argc, argv);
    move_behind(argv, at);
    if (!strcmp(argv[1], "help") && argc == 2)
        return run_bare(2, (char *[]){argv[0], "--help", NULL});
    if (!strcmp(argv[1], "help") && verb_named(argv[2])) {
        print_verb_help(verb_named(argv[2]));
        return EXIT_SUCCESS;
    }
    const struct verb *verb = verb_named(argv[1]);
    return verb ? run(verb, argc - 2, argv + 2) : refuse_verb(argv[1]);
}

/* Text that did not reach its file must not pass for success. A reader who has seen enough of a
 * pipe needs no message. */
static int finish_output(int status)
{
    errno = 0;
    if (!fflush(stdout) && !ferror(stdout))
        return status;
    if (errno != EPIPE && status == EXIT_SUCCESS)
        fprintf(stderr, "pmclient: standard output: cannot be written: %s\n",
                errno ? strerror(errno) : "an earlier error");
    return status ? status : EXIT_FAILURE;
}

int main(int argc, char **argv)
{
    pm_bytes line = {0};
    if (!fill_standard_streams())
        return EXIT_FAILURE;
    join(&line, argc, argv);
    if (!pm_bytes_status(&line))
        pm_command_line = (const char *)line.data;
    catch_signals();
    int status = finish_output(run_words(argc, argv));
    pm_bytes_clear(&line);
    return status;
}
