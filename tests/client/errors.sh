#!/bin/sh
# Wrong input: the right status, a message that helps, and nothing left behind.
# shellcheck source-path=SCRIPTDIR
. "$(dirname "$0")/common.sh"

expect 2 "usage:" "$pm"
expect 2 "unknown verb" "$pm" frobnicate
expect 2 "unknown option" "$pm" render box.rad --frobnicate
expect 2 "did you mean --time?" "$pm" render box.rad --tiem 3s -o a.exr
expect 2 "did you mean rtrace?" "$pm" rtrac box.rad
expect 2 "takes no value" "$pm" render box.rad --help=3
expect 2 "must be one of list, show, cancel" "$pm" job lst
expect 2 "the scene must be a file" "$pm" trace -
expect 2 "the scene is missing" "$pm" render
expect 2 "-o is missing" "$pm" render box.rad
expect 2 "must end in .exr, .hdr or .png" "$pm" render box.rad -o a.jpg
expect 1 "missing.rad" "$pm" render missing.rad -o a.exr
expect 2 "a whole number from 51" "$pm" rpict -apcb box.cpm 50 40 box.rad
expect 2 "no map asked for" "$pm" mkpmap box.rad
expect 3 "server at http://127.0.0.1:9" "$pm" --server http://127.0.0.1:9 job list
expect 2 "view" "$pm" render box.rad -vd 0 0 1 -o a.exr

# Surfaces and regions of mkpmap: names come from the command line, files or nowhere.
: >empty.txt
printf 'grey\nnone such\n' >names.txt
expect 1 "-ae: no surface has the modifier 'gray'; there are: grey" "$pm" mkpmap -apg a.gpm 1k -ae gray box.rad
expect 1 "-aps: no surface has the modifier 'none'" "$pm" mkpmap -apg a.gpm 1k -apS names.txt box.rad
expect 1 "empty.txt: names no modifier" "$pm" mkpmap -apg a.gpm 1k -aI empty.txt box.rad
expect 1 "missing.txt: cannot be read" "$pm" mkpmap -apg a.gpm 1k -aE missing.txt box.rad
expect 2 "-ae or -ai alone" "$pm" mkpmap -apg a.gpm 1k -ae grey -ai glass box.rad
expect 2 "ball of radius -1" "$pm" mkpmap -apg a.gpm 1k -apI 0 0 0 -1 box.rad
expect 2 "-api nan" "$pm" mkpmap -apg a.gpm 1k -api 0 0 nan 1 1 1 box.rad
expect 2 "dark where no photons are stored" "$pm" render box.rad -ae grey -o a.exr
expect 2 "an extinction must be 0 to" "$pm" render box.rad -me -1 0 0 -o a.exr
expect 2 "give -me r g b" "$pm" render box.rad -ma 1 1 1 -o a.exr
expect 1 "nowhere/messages" "$pm" mkpmap -apg a.gpm 1k -e nowhere/messages box.rad
[ ! -e a.gpm ] || fail "a refused mkpmap left a map"

printf 'void plastic grey 0 0 4 .5 .5 .5 0\ngrey sphere s 0 0 4 0 0 0 1\n' >few.rad
expect 1 "few.rad:1:" "$pm" trace few.rad
printf 'void plastic grey 0 0 5 .5 .5 .5 0 0\n!genclock grey b 1\n' >command.rad
expect 1 "command.rad:2:" "$pm" trace command.rad
expect 1 "genclock grey b 1
     ^" "$pm" trace command.rad
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

# Odd files.
expect 1 "empty.rad: the scene has no surface" sh -c ": >empty.rad; '$pm' scene check empty.rad"
expect 1 "is a folder" "$pm" scene check .
head -c 9000 "$pm" >binary.rad
expect 1 "binary.rad:1:1: byte 0x7F" "$pm" scene check binary.rad
printf '#?RADIANCE\noconv box.rad\nFORMAT=Radiance_octree\n\n\001\037' >box.oct
expect 1 "box.oct: the file is cut off" "$pm" scene check box.oct
printf 'void light l 0 0 3 1 1 1\nl sphere s 0 0 4 0 0 0 1e200\n' >huge.rad
expect 1 "huge.rad: the scene is 2e+200 units wide" "$pm" scene check huge.rad
sed 's/$/\r/' box.rad >lines.rad
[ "$("$pm" scene check box.rad | grep octree)" = "$("$pm" scene check lines.rad | grep octree)" ] ||
    fail "line ends change the scene"
mkdir folder
mv five.txt folder
(cd folder && "$pm" trace ../box.rad <five.txt 2>err.txt) && fail "five numbers were accepted"
grep -q 'standard input:1:' folder/err.txt || fail "points are called $(cat folder/err.txt)"

# Closed and full streams.
expect 1 "standard input: cannot be read" sh -c "'$pm' trace box.rad <&-"
expect 1 "standard output: cannot be written" sh -c "'$pm' map list >&-"
expect 1 "standard output: cannot be written" sh -c "'$pm' --help >/dev/full"
expect 1 "standard output: cannot be written" sh -c "echo 0 0 1 0 0 1 | '$pm' trace box.rad --passes 1 >/dev/full"
expect 0 "" sh -c "'$pm' render box.rad -x 4 -y 4 --passes 1 -vp 0 -.9 1 -o none.exr <&- >&- 2>&-"
[ -s none.exr ] || fail "closed streams, no picture"

# Stores.
head -c 5000 "$pm" >binary.sqlite
expect 1 "not a database" env PM_STORE=binary.sqlite "$pm" map list
sqlite3 other.sqlite 'CREATE TABLE a(b)'
expect 1 "no store of pmserver" env PM_STORE=other.sqlite "$pm" map list
cp store.sqlite newer.sqlite
sqlite3 newer.sqlite 'PRAGMA user_version = 99'
expect 1 "newer.sqlite: has schema 99" env PM_STORE=newer.sqlite "$pm" map list
expect 1 "must name a file" env "PM_STORE=$work" "$pm" map list
expect 1 "too long" env "PM_STORE=$work/$(printf %0200d 0)" "$pm" map list
expect 1 "no place for the cache" env -u PM_STORE -u HOME -u XDG_CACHE_HOME "$pm" map list
(
    ulimit -f 200 # of 512 bytes: a disk that is soon full
    expect 1 "" env "PM_STORE=$work/small.sqlite" "$pm" mkpmap -apg small.gpm 100k box.rad
)
[ ! -e small.gpm ] || fail "a map without room"

# Outputs.
expect 1 "/nonexistent/a.exr" "$pm" render box.rad -x 8 -y 8 --passes 1 -vp 0 -.9 1 -o /nonexistent/a.exr
expect 1 "cannot be written" sh -c "'$pm' rpict -x 8 -y 8 --passes 1 -vp 0 -.9 1 box.rad >/dev/full"
for part in ./*.part*; do
    [ ! -e "$part" ] || fail "$part was left"
done
expect 2 "no key" "$pm" map info ../../etc
expect 1 "there is no such map" "$pm" map info 0123
expect 1 "there is no such map" "$pm" map fetch 0123 -o a.gpm
expect 1 "a.exr: cannot be written" "$pm" render box.rad --passes 1 -o folder/../none/a.exr
expect 1 "must be the name of a file" sh -c "mkdir d.exr; '$pm' render box.rad --passes 1 -o d.exr"
expect 1 "" "$pm" job show 0123
expect 2 "takes" "$pm" job show
echo "$passed passed, 0 failed"
