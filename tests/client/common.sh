# shellcheck shell=sh
# What the scripts share. Call: sh SCRIPT BIN_FOLDER
set -eu
bin=$1
# shellcheck disable=SC2034 # the scripts use it
pm=$bin/pmclient
work=$(mktemp -d /tmp/pm_test_XXXXXX)
# Ends a server that a failed test left, a stopped one included: it holds the test's output open.
clean_up()
{
    for file in "$work"/*.pid; do
        [ -s "$file" ] || continue
        left=$(cat "$file")
        { tr '\0' ' ' <"/proc/$left/cmdline"; } 2>/dev/null | grep -qF "$work" && kill -9 "$left"
    done
    rm -rf "$work"
}
trap clean_up EXIT
cd "$work"
PM_STORE=$work/store.sqlite
export PM_STORE
unset PM_SERVER PM_TOKEN_FILE 2>/dev/null || true
passed=0

fail()
{
    echo "FAILED: $*" >&2
    exit 1
}

# expect STATUS TEXT COMMAND...: the command ends with the status and says the text.
expect()
{
    wanted=$1
    text=$2
    shift 2
    status=0
    "$@" >out.txt 2>err.txt </dev/null || status=$?
    [ "$status" = "$wanted" ] || fail "$*: status $status instead of $wanted: $(cat err.txt)"
    [ -z "$text" ] || cat out.txt err.txt | grep -qF -- "$text" || fail "$*: says '$(cat err.txt)', not '$text'"
    passed=$((passed + 1))
}

# A closed grey box of 2 m with a lamp and a glass ball.
cat >box.rad <<'SCENE'
void plastic grey 0 0 5 .5 .5 .5 0 0
void light lamp 0 0 3 10 10 10
void dielectric glass 0 0 5 1 1 1 1.5 0
grey polygon floor 0 0 12  -1 -1 0  1 -1 0  1 1 0  -1 1 0
grey polygon ceiling 0 0 12  -1 -1 2  -1 1 2  1 1 2  1 -1 2
grey polygon west 0 0 12  -1 -1 0  -1 1 0  -1 1 2  -1 -1 2
grey polygon east 0 0 12  1 -1 0  1 -1 2  1 1 2  1 1 0
grey polygon south 0 0 12  -1 -1 0  -1 -1 2  1 -1 2  1 -1 0
grey polygon north 0 0 12  -1 1 0  1 1 0  1 1 2  -1 1 2
lamp polygon panel 0 0 12  -.2 -.2 1.99  -.2 .2 1.99  .2 .2 1.99  .2 -.2 1.99
glass sphere ball 0 0 4  0 0 .7 .3
SCENE
