#!/bin/sh
# Each verb does its work over a private server, and the cache serves the second view.
# shellcheck disable=SC2086 # $view is a list of words
# shellcheck source-path=SCRIPTDIR
. "$(dirname "$0")/common.sh"
view="-vp 0 -.9 1 -vd 0 1 -.3 -x 24 -y 24"

expect 0 "wrote box.gpm" "$pm" mkpmap -apg box.gpm 5k -apc box.cpm 2k box.rad
expect 0 "Kind:         global" "$pm" pmapinfo box.gpm
expect 0 "mkpmap -apg box.gpm 5k" "$pm" pmapinfo box.gpm
expect 0 "Kind:         caustic" "$pm" pmapinfo box.cpm

# A dump is a scene: a comment, a glow, and so many spheres; the seed's form takes every photon.
expect 0 "mat.global sphere obj.global" "$pm" pmapdump box.gpm
[ "$("$pm" pmapdump -n 300 box.gpm | grep -c sphere)" = 300 ] || fail "pmapdump -n"
[ "$("$pm" pmapdump -a -n 300 -f box.gpm | awk 'NF == 6' | wc -l)" = 300 ] || fail "pmapdump -a"
[ "$("$pm" pmapdump .01 box.gpm box.cpm | grep -c ' 0\.01$')" -gt 6900 ] || fail "pmapdump RADIUS"
"$pm" pmapdump -n 50 -c 1 0 0 box.gpm -n 20 -f box.cpm | cat box.rad - >dump.rad
expect 0 "" "$pm" scene check dump.rad
expect 2 "exclude each other" "$pm" pmapdump -f -c 1 1 1 box.gpm

# Octrees: what names its file is the scene itself, by its hash; what is frozen stands alone.
"$pm" oconv box.rad >box.oct || fail "oconv"
hash_of() {
    "$pm" scene check "$1" | sed -n 's/.*octree *//p'
}
[ "$(hash_of box.oct)" = "$(hash_of box.rad)" ] || fail "an octree is another scene"
"$pm" rpict -ab 1 -apg box.gpm 50 $view box.oct >oct.hdr || fail "a map does not suit the octree"
"$pm" pmapdump .01 box.gpm | "$pm" oconv -n 16 - box.rad >dump.oct || fail "oconv of a dump"
expect 0 "sphere" "$pm" scene check dump.oct
mkdir alone
"$pm" oconv -f -o alone/box.oct -r 64 box.rad || fail "oconv -f"
expect 0 "" "$pm" scene check alone/box.oct
cp box.oct alone/named.oct
expect 1 "outside the scene's folder" "$pm" scene check alone/named.oct
expect 0 "" "$pm" oconv -i alone/box.oct -o alone/more.oct dump.rad
expect 2 "exclude each other" "$pm" oconv -i box.oct -b 0 0 0 1
expect 2 "missing" "$pm" oconv
expect 1 "say -i before it" "$pm" oconv box.oct
expect 1 "does not hold the scene" "$pm" oconv -b 0 0 0 .1 -o bad.oct box.rad
[ ! -e bad.oct ] || fail "a failed oconv left a file"

# The wanted count within 1 %.
photons=$("$pm" pmapinfo box.gpm | sed -n 's/^Photons: *//p')
if [ "$photons" -lt 4950 ] || [ "$photons" -gt 5050 ]; then
    fail "$photons photons instead of 5000"
fi

"$pm" rpict -ab 1 -apg box.gpm 50 -apc box.cpm 50 $view box.rad >box.hdr
head -c 10 box.hdr | grep -q '#?RADIANCE' || fail "rpict wrote no Radiance picture"
grep -aq '^VIEW=' box.hdr || fail "the picture has no VIEW line"
"$pm" rpict -ap box.gpm 50 -ab -1 $view box.rad >again.hdr || fail "rpict -ap"

"$pm" rpict -apcb box.cpm 20 200 $view box.rad >bias.hdr || fail "rpict -apcb"
"$pm" rpict -ap box.cpm 20 200 $view box.rad >bias2.hdr || fail "rpict -ap K K2"
"$pm" rpict -apc box.cpm 20 $view box.rad >fixed.hdr
"$pm" rpict -apc box.cpm 20 200 --bandwidth chi2 $view box.rad >chi2.hdr
body_of() {
    sed '1,/^$/d' "$1" | cksum
}
[ "$(body_of bias.hdr)" = "$(body_of bias2.hdr)" ] || fail "-apcb and -ap K K2 differ"
[ "$(body_of bias.hdr)" != "$(body_of fixed.hdr)" ] || fail "K2 changes nothing"
[ "$(body_of bias.hdr)" != "$(body_of chi2.hdr)" ] || fail "--bandwidth changes nothing"

# Precomputed maps.
expect 0 "cache: miss" "$pm" mkpmap -app box.pgpm 4k 50 -apf .3 -apr 9 box.rad
expect 0 "cache: hit" "$pm" mkpmap -fo -app again.pgpm 4k 50 -apP .3 -apr 9 box.rad
expect 0 "Kind:         precomputed" "$pm" pmapinfo box.pgpm
kept=$("$pm" pmapinfo box.pgpm | sed -n 's/^Photons: *//p')
[ "$kept" -ge 1188 ] && [ "$kept" -le 1210 ] || fail "$kept precomputed photons instead of 1200"
dumped=$("$pm" pmapdump -f -a -n 4k box.pgpm | awk '{ sum += $4 } END { print sum / NR }')
"$pm" pmapinfo box.pgpm | awk -v d="$dumped" '/^Average/ { r = $3 / d; exit !(r > .998 && r < 1.002) }' ||
    fail "pmapinfo and pmapdump tell different irradiances, $dumped"
[ "$("$pm" pmapdump -f -a -n 100 box.pgpm | awk 'NF == 6' | wc -l)" = 100 ] || fail "pmapdump"
key=$("$pm" map list -q | sed -n 's/ .*precomputed.*//p')
"$pm" map info "$key" >/dev/null || fail "the precomputed map is not kept as $key"
"$pm" rpict -ab -1 -app box.pgpm $view box.rad >app.hdr || fail "rpict -app"
"$pm" rpict -ab -1 -app box.pgpm 1 $view box.rad >app1.hdr || fail "rpict -app FILE 1"
"$pm" rpict -ab -1 -ap box.pgpm $view box.rad >ap.hdr || fail "rpict -ap of a precomputed map"
"$pm" rpict -ab -1 -apg box.gpm 30 -apc box.cpm 20 $view box.rad >named.hdr || fail "rpict -apg -apc"
"$pm" rpict -ab -1 -ap box.cpm 20 -ap box.gpm 30 $view box.rad >found.hdr || fail "rpict -ap -ap"
[ "$(body_of named.hdr)" = "$(body_of found.hdr)" ] || fail "of two -ap one was left out"
expect 1 "is a second global map" "$pm" rpict -ap box.gpm 30 -ap box.pgpm $view box.rad
"$pm" render -ab -1 -app 4k 50 -apP .3 -apr 9 $view -o app.exr box.rad || fail "render -app"
[ "$(body_of app.hdr)" = "$(body_of ap.hdr)" ] || fail "-ap and -app differ"
[ "$(body_of app.hdr)" = "$(body_of app1.hdr)" ] || fail "-app FILE and -app FILE 1 differ"
expect 1 "holds precomputed photons, but is given as the global map" "$pm" rpict -apg box.pgpm $view box.rad
expect 1 "holds global photons, but is given as the precomputed map" "$pm" rpict -app box.gpm $view box.rad
expect 1 "leave out the number behind it" "$pm" rpict -ap box.pgpm 50 $view box.rad

expect 0 "cache: hit" "$pm" render box.rad $view -apg 5k 50 -apc 2k 50 -o a.exr
expect 0 "cache: miss" "$pm" render box.rad $view -apr 3 -apg 5k 50 -o b.exr -o b.hdr -o b.png
expect 0 "cache: hit" "$pm" render box.rad $view -apr 3 -apg 5k 50 -o c.exr
expect 0 "cache: extended" "$pm" render box.rad $view -apr 3 -apg 300k 50 --passes 1 -o d.exr
for picture in b.exr b.hdr b.png; do
    [ -s $picture ] || fail "$picture is missing"
done

# Values at points: a line a point, in order, the same for any number of threads.
printf '0.7 0.7 0  0 0 1\n\n0 0 0  0 0 1\n' >points.txt
"$pm" trace box.rad --passes 8 <points.txt >values.txt
[ "$(wc -l <values.txt)" = 2 ] || fail "trace: two points, $(wc -l <values.txt) lines"
[ "$(awk '{print NF}' values.txt | sort -u)" = 3 ] || fail "trace: not three columns"
awk '{ if (!($1 > 0)) exit 1 }' values.txt || fail "trace: dark points"
"$pm" trace box.rad --passes 8 -n 1 <points.txt | cmp - values.txt || fail "threads change values"
"$pm" trace box.rad --passes 8 --errors <points.txt | awk 'NF != 6 {exit 1}' || fail "--errors"
"$pm" rtrace -I -h -ab -1 -apg box.gpm 50 box.rad <points.txt | awk 'NF != 3 {exit 1}' || fail "rtrace"

# Columns and formats of rtrace.
printf '%s\n' '0 0 1.5 0 0 -1' '0 0 1.5 0 0 1' >rays.txt
"$pm" rtrace -h -oLsmv -ab 0 --passes 2 box.rad <rays.txt | awk 'NF != 6 {exit 1}' || fail "rtrace -oLsmv"
zero='\000\000\000\000\000\000\000\000'
# shellcheck disable=SC2059 # the doubles 0 0 1.5 0 0 -1
printf "$zero$zero\\000\\000\\000\\000\\000\\000\\370\\077$zero$zero\\000\\000\\000\\000\\000\\000\\360\\277" >rays.double
"$pm" rtrace -h -fdf -oovd -ab 0 --passes 2 box.rad <rays.double | od -A n -v -w36 -t f4 >values.float
awk 'NF != 9 || $1 != 0 || $3 != 1.5 || $9 != -1 {exit 1}' values.float || fail "rtrace -fdf: $(cat values.float)"
"$pm" rtrace -fac -x 2 -y 1 -ab 0 --passes 2 box.rad <rays.txt >values.hdr
grep -aq '^-Y 1 +X 2$' values.hdr || fail "rtrace -x -y: no picture"
"$pm" rtrace -fac -x 2 -y 2 -ab 0 --passes 2 box.rad <rays.txt >values.hdr 2>err.txt && fail "three values too few were accepted"
grep -q "4 values, but there are 2 points" err.txt || fail "count of values: $(cat err.txt)"
"$pm" rtrace -I -apg box.gpm box.rad <points.txt | head -1 | grep -q '^#?RADIANCE' || fail "header"

# Without a glass ball there is no caustic map, and that is an answer.
grep -v ball box.rad >plain.rad
expect 0 "plain.cpm: " "$pm" mkpmap -apc plain.cpm 1k plain.rad
expect 0 "Photons:      0" "$pm" pmapinfo plain.cpm

key=$("$pm" map list -q | sed -n '1s/ .*//p')
expect 0 "$key" "$pm" map info "$key"
expect 0 "" "$pm" map fetch "$key" -o fetched.map
expect 0 "Kind:" "$pm" pmapinfo fetched.map
expect 0 "Kind:" "$pm" pmapinfo "$key"
job=$("$pm" job list -q | sed -n '1s/ .*//p')
expect 0 "$job" "$pm" job show "$job"

# Sequences: passes are listed and fetched one by one; a dump and a picture take all of them.
expect 0 "3 passes" "$pm" mkpmap -apg seq.gpm 2k --passes 3 box.rad
expect 0 "extended" "$pm" mkpmap -apg more.gpm 2k --passes 5 -apr 0 box.rad
[ "$("$pm" pmapinfo more.gpm | grep -c '^  pass ')" = 5 ] || fail "pmapinfo of a sequence"
size=$(($(wc -c <seq.gpm) - 200)) # without the end, which has the command line
[ "$(head -c $size seq.gpm | cksum)" = "$(head -c $size more.gpm | cksum)" ] || fail "passes differ"
key=$("$pm" map list -q | sed -n 's/ .*//; /-2000-5$/p')
expect 0 "" "$pm" map fetch "$key" --pass 4 -o last.gpm
expect 0 "Photons:      200" "$pm" pmapinfo last.gpm
expect 1 "passes 0 to 4" "$pm" map fetch "$key" --pass 5 -o none.gpm
expect 2 "belongs to" "$pm" map list --pass 1
[ "$("$pm" pmapdump -n 100 more.gpm | grep -c sphere)" = 100 ] || fail "pmapdump of a sequence"
"$pm" rpict -ab -1 -apg more.gpm 50 $view box.rad >sequence.hdr || fail "rpict of a sequence"
expect 2 "--passes" "$pm" mkpmap -apg zero.gpm 2k --passes 0 box.rad

# The dump is a scene that renders.
"$pm" pmapdump -n 400 -c 3 3 3 box.gpm >glow.rad || fail "pmapdump"
"$pm" rtrace -h -ab 0 --passes 2 glow.rad >seen.txt <<RAYS || fail "a dump does not render"
$(awk '/ sphere / { near = 1 } near && /^4 / { print $2, $3, $4 + 2 * $5, 0, 0, -1; exit }' glow.rad)
RAYS
awk '{ exit !($1 > 0 || $2 > 0 || $3 > 0) }' seen.txt || fail "a dump is dark: $(cat seen.txt)"

# A scene on standard input, and !xform of a file beside it.
echo '!xform -t 5 0 0 box.rad' >moved.rad
echo '4.3 .7 0  0 0 1' | "$pm" trace moved.rad --passes 2 | awk '{ if (!($1 > 0)) exit 1 }' || fail "xform"

# What is stored where; the medium and back faces are of the scene; messages go to a file.
expect 0 "wrote floor.gpm" "$pm" mkpmap -apg floor.gpm 500 -apd floor.dpm 500 -api -2 -2 -.1 2 2 .1 box.rad
"$pm" pmapdump -a floor.gpm -a floor.dpm | awk '$3 > .1001 { exit 1 } END { exit (NR < 1000) }' ||
    fail "photons outside the region: $("$pm" pmapdump -a floor.gpm | head -3)"
expect 0 "Kind:         direct" "$pm" pmapinfo floor.dpm
expect 1 "to be looked at with pmapdump" "$pm" rpict -x 8 -y 8 -ap floor.dpm box.rad
expect 0 "" "$pm" mkpmap -apg fog.gpm 1k -apv fog.vpm 1k -me .2 .2 .2 -ma .5 .5 .5 -v -e messages.txt box.rad
grep -q "^# .*mkpmap -apg fog.gpm" messages.txt && grep -q "% escaped" messages.txt &&
    grep -q "wrote fog.vpm" messages.txt || fail "messages: $(cat messages.txt)"
expect 1 "with the same -me -ma -mg -bv" "$pm" rpict -x 8 -y 8 -apg fog.gpm box.rad
expect 0 "" "$pm" rpict -x 8 -y 8 -apg fog.gpm -apv fog.vpm -me .2 .2 .2 -ma .5 .5 .5 box.rad

# Nobody else uses the server, so it was gone before its client.
[ ! -e "$PM_STORE.sock" ] || fail "the server stayed"
echo "$passed passed, 0 failed"
