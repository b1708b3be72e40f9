#!/bin/sh
# Wrong input: the right status, a message that helps, and nothing left behind.
# shellcheck source-path=SCRIPTDIR
. "$(dirname "$0")/common.sh"

expect 2 "usage:" "$pm"
expect 2 "unknown verb" "$pm" frobnicate
expect 2 "unknown option" "$pm" render box.rad --frob
expect 2 "the scene is missing" "$pm" render
expect 2 "-o is missing" "$pm" render box.rad
expect 2 "must end in .exr, .hdr or .png" "$pm" render box.rad -o a.jpg
expect 1 "missing.rad" "$pm" render missing.rad -o a.exr
expect 2 "bias compensation" "$pm" rpict -apcb box.cpm 50 500 box.rad
expect 2 "no map asked for" "$pm" mkpmap box.rad
expect 3 "server at http://127.0.0.1:9" "$pm" --server http://127.0.0.1:9 job list
expect 2 "view" "$pm" render box.rad -vd 0 0 1 -o a.exr

printf 'void plastic grey 0 0 4 .5 .5 .5 0\ngrey sphere s 0 0 4 0 0 0 1\n' >few.rad
expect 1 "few.rad:1:" "$pm" trace few.rad
printf 'void plastic grey 0 0 5 .5 .5 .5 0 0\n!genbox grey b 1 1 1\n' >command.rad
expect 1 "command.rad:2:" "$pm" trace command.rad
printf 'void prism1 p 0 0 0\n' >prism.rad
expect 1 "prism1" "$pm" trace prism.rad
printf 'void plastic grey 0 0 5 nan .5 .5 0 0\n' >nan.rad
expect 1 "nan.rad:1:25" "$pm" trace nan.rad

# Points.
printf '0 0 1 0 0 1\n0 0 0 0 0 0\n' >zero.txt
"$pm" trace box.rad <zero.txt >out.txt 2>err.txt && fail "a zero normal was accepted"
grep -q ':2:' err.txt || fail "zero normal: $(cat err.txt)"
printf '0 0 1 0 0\n' >five.txt
"$pm" trace box.rad <five.txt >out.txt 2>err.txt && fail "five numbers were accepted"
grep -q ':1:' err.txt || fail "five numbers: $(cat err.txt)"

# Maps.
"$pm" mkpmap -apg box.gpm 1k box.rad 2>/dev/null
expect 1 "exists already" "$pm" mkpmap -apg box.gpm 1k box.rad
grep -v ball box.rad >other.rad
expect 1 "another scene" sh -c "'$pm' rpict -apg box.gpm -x 8 -y 8 other.rad >o.hdr"
touch -d '2001-01-01' box.rad
expect 0 "" sh -c "'$pm' rpict -apg box.gpm -x 8 -y 8 -vp 0 -.9 1 box.rad >o.hdr"
expect 1 "holds global photons" sh -c "'$pm' rpict -apc box.gpm -x 8 -y 8 box.rad >o.hdr"
head -c 3000 box.gpm >short.gpm
expect 1 "short.gpm" "$pm" pmapinfo short.gpm
expect 1 "box.rad" "$pm" pmapinfo box.rad
expect 1 "" sh -c "'$pm' rpict -apg short.gpm -x 8 -y 8 box.rad >o.hdr"

# Outputs.
expect 1 "/nonexistent/a.exr" "$pm" render box.rad -x 8 -y 8 --passes 1 -vp 0 -.9 1 -o /nonexistent/a.exr
expect 1 "cannot be written" sh -c "'$pm' rpict -x 8 -y 8 --passes 1 -vp 0 -.9 1 box.rad >/dev/full"
for part in ./*.part*; do
    [ ! -e "$part" ] || fail "$part was left"
done
expect 2 "no key" "$pm" map info ../../etc
expect 1 "" "$pm" map info 0123
expect 1 "" "$pm" job show 0123
expect 2 "takes" "$pm" job show
echo "$passed passed, 0 failed"
