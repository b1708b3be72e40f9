#!/bin/sh
# Clients at once, interrupted, killed; servers and workers killed. Nothing hangs, nothing is left.
# shellcheck source-path=SCRIPTDIR
. "$(dirname "$0")/common.sh"
view="-vp 0 -.9 1 -vd 0 1 -.3 -x 64 -y 64"

# render_long: a job that would take ten minutes, in the background; $client is its process.
render_long()
{
    # A shell has SIGINT ignored in the background; a terminal has not.
    # shellcheck disable=SC2086 # the view is a list of words
    env --default-signal=INT "$pm" render box.rad $view --time 600s -o long.exr 2>long.txt &
    client=$!
}

wait_until_running()
{
    until "$pm" "$@" job list -q | grep -q running; do
        sleep 0.1
    done
}

# ended STATUS...: the client ended with one of them, left no file, and its server goes too.
ended()
{
    status=0
    wait "$client" || status=$?
    case " $* " in
    *" $status "*) ;;
    *) fail "status $status instead of $*: $(cat long.txt)" ;;
    esac
    ! ls ./long.exr* 2>/dev/null || fail "a file was left"
    [ ! -s "$PM_STORE.pid" ] || gone "$(cat "$PM_STORE.pid")"
    passed=$((passed + 1))
}

# gone PROCESS: waits for its end.
gone()
{
    while kill -0 "$1" 2>/dev/null; do
        sleep 0.1
    done
}

# Two commands at once share one server, and both get their answer.
"$pm" mkpmap -apg a.gpm 20k box.rad 2>a.txt &
first=$!
"$pm" mkpmap -apg b.gpm 20k box.rad 2>b.txt &
second=$!
wait $first || fail "first: $(cat a.txt)"
wait $second || fail "second: $(cat b.txt)"
# The trailers hold each command line; the photons before them are the same.
[ "$("$pm" pmapdump -a -f a.gpm | cksum)" = "$("$pm" pmapdump -a -f b.gpm | cksum)" ] || fail "maps differ"
passed=$((passed + 1))

# A signal in mid-job: status 130, the job is cancelled.
for signal in INT TERM HUP; do
    render_long
    wait_until_running
    kill -$signal "$client"
    ended 130
    grep -q interrupted long.txt || fail "SIG$signal says $(cat long.txt)"
done
"$pm" job list -q | grep -q running && fail "a job goes on after Ctrl-C"

# A signal at any stage: while the server starts, the scene is sent, the job begins. At first
# nobody catches it yet.
for delay in 0 0.005 0.01 0.02 0.03 0.05 0.1; do
    render_long
    sleep $delay
    kill -TERM "$client"
    ended 130 143
done

# A server that does not answer: the second signal ends the client.
render_long
wait_until_running
server=$(cat "$PM_STORE.pid")
kill -STOP "$server"
until grep -q '^State:.*T' "/proc/$server/status"; do
    sleep 0.1
done
kill -INT "$client"
sleep 0.3
kill -INT "$client" || fail "the first signal was enough: $(cat long.txt)"
status=0
wait "$client" || status=$?
kill -CONT "$server"
[ "$status" = 130 ] || fail "second SIGINT: status $status"
gone "$server"
passed=$((passed + 1))

# kill -9: of the client, the worker, the private server.
render_long
wait_until_running
server=$(cat "$PM_STORE.pid")
kill -9 "$client"
ended 137
render_long
wait_until_running
server=$(cat "$PM_STORE.pid")
for process in /proc/[0-9]*; do
    case $({ tr '\0' ' ' <"$process/cmdline"; } 2>/dev/null || true) in
    *"pmworker $server "*) kill -9 "${process#/proc/}" ;;
    esac
done
ended 1
grep -q 'worker was killed (SIGKILL)' long.txt || fail "killed worker: $(cat long.txt)"
render_long
wait_until_running
kill -9 "$(cat "$PM_STORE.pid")"
ended 3
expect 0 "cancelled" "$pm" job list # the next server took the lost job up, and its client is gone

# kill -9 of a server in mid-job: started again on the same store, it takes the job up.
start_server()
{
    "$bin/pmserver" --store kill.sqlite --listen 127.0.0.1:0 >server.txt 2>server.err &
    server=$!
    url=
    while [ -z "$url" ]; do
        kill -0 "$server" || fail "pmserver: $(cat server.err)"
        sleep 0.1
        url=$(sed -n 's/^listening on //p' server.txt)
    done
}
start_server
# shellcheck disable=SC2086 # the view is a list of words
"$pm" --server "$url" render box.rad $view -apg 20m 50 -o killed.exr 2>killed.txt &
client=$!
wait_until_running --server "$url"
kill -9 $server
wait $server 2>/dev/null || true
status=0
wait $client || status=$?
[ "$status" = 3 ] || fail "server killed: status $status: $(cat killed.txt)"
[ ! -e killed.exr ] || fail "a picture of a killed server"
start_server
expect 0 "render" "$pm" --server "$url" job show 1
"$pm" --server "$url" job show 1 | grep -qE '^state +(queued|running|done)' ||
    fail "the job is lost: $("$pm" --server "$url" job show 1)"
"$pm" --server "$url" map list -q >maps.txt
while read -r key rest; do
    "$pm" --server "$url" map fetch "$key" -o kept.map || fail "map $key $rest cannot be fetched"
    "$pm" pmapinfo kept.map >/dev/null || fail "map $key is broken"
done <maps.txt
expect 0 "cancel" "$pm" --server "$url" job cancel 1
kill -TERM $server
status=0
wait $server || status=$?
[ "$status" = 0 ] || fail "pmserver ended with $status"
echo "$passed passed, 0 failed"
