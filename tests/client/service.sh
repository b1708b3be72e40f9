#!/bin/sh
# A server killed in mid-job, Ctrl-C in mid-job, two clients at once.
. "$(dirname "$0")/common.sh"
pm="$bin/pmclient"
view="-vp 0 -.9 1 -vd 0 1 -.3 -x 64 -y 64"

# Two commands at once share one server, and both get their answer.
"$pm" mkpmap -apg a.gpm 20k box.rad 2>a.txt &
first=$!
"$pm" mkpmap -apg b.gpm 20k box.rad 2>b.txt &
second=$!
wait $first || fail "first: $(cat a.txt)"
wait $second || fail "second: $(cat b.txt)"
cmp a.gpm b.gpm 2>/dev/null || {
    # The trailers hold each command line; the photons before them are the same.
    [ "$(head -c 400000 a.gpm | cksum)" = "$(head -c 400000 b.gpm | cksum)" ] || fail "maps differ"
}

# Ctrl-C: status 130, the job is cancelled, nothing half-written.
# shellcheck disable=SC2086 # the view is a list of words
"$bin/pmclient" render box.rad $view --time 600s -o long.exr 2>long.txt &
client=$!
sleep 2
kill -INT $client
status=0
wait $client || status=$?
[ "$status" = 130 ] || fail "Ctrl-C: status $status: $(cat long.txt)"
ls | grep long.exr && fail "Ctrl-C left a file"

# kill -9 of a server in mid-job: started again on the same store, it ends the job.
"$bin/pmserver" --store kill.sqlite --listen 127.0.0.1:0 >server.txt 2>server.err &
server=$!
url=
while [ -z "$url" ]; do
    sleep 0.1
    url=$(sed -n 's/^listening on //p' server.txt)
done
"$pm" --server "$url" render box.rad $view --time 3s -apg 20m 50 -o killed.exr 2>killed.txt &
client=$!
sleep 2
kill -9 $server
wait $server 2>/dev/null || true
status=0
wait $client || status=$?
[ "$status" = 3 ] || fail "server killed: status $status: $(cat killed.txt)"
[ ! -e killed.exr ] || fail "a picture of a killed server"
"$bin/pmserver" --store kill.sqlite --listen 127.0.0.1:0 >server.txt 2>server.err &
server=$!
url=
while [ -z "$url" ]; do
    sleep 0.1
    url=$(sed -n 's/^listening on //p' server.txt)
done
"$pm" --server "$url" job list -q >jobs.txt
grep -qE 'running|queued|failed|done' jobs.txt || fail "the job is lost: $(cat jobs.txt)"
"$pm" --server "$url" map list -q >maps.txt
while read -r key rest; do
    "$pm" --server "$url" map fetch "$key" -o kept.map || fail "map $key cannot be fetched"
    "$pm" pmapinfo kept.map >/dev/null || fail "map $key is broken"
done <maps.txt
job=$(cut -d ' ' -f 1 jobs.txt | head -1)
"$pm" --server "$url" job cancel "$job" >/dev/null 2>&1 || true
kill -TERM $server
status=0
wait $server || status=$?
[ "$status" = 0 ] || fail "pmserver ended with $status"
echo "5 passed, 0 failed"
