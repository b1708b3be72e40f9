#!/bin/sh
# From a fresh Debian 12 to two pictures of a caustic: installs what is missing, builds, starts a loopback
# server, renders viewpoint A (photons traced), then viewpoint B (photons from the cache), stops the server.
# Pictures land in build/quickstart/. Options: none.
set -eu
cd "$(dirname "$0")/.."
sh deploy/install.sh
cmake --preset release -DPM_TESTS=OFF
cmake --build --preset release

bin=$PWD/build/release/bin
out=build/quickstart
rm -rf "$out"
mkdir -p "$out"

"$bin/pmserver" --store "$out/store.sqlite" --listen 127.0.0.1:0 >"$out/server.log" &
server=$!
trap 'kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true' EXIT
trap 'exit 130' INT TERM

# The server prints its address once it listens.
url=
while [ -z "$url" ]; do
    kill -0 "$server" 2>/dev/null || { echo "pmserver ended: see $out/server.log" >&2; exit 1; }
    url=$(sed -n 's/^listening on //p' "$out/server.log")
    [ -n "$url" ] || sleep 0.1
done

for view in a b; do
    echo "Viewpoint $view:"
    "$bin/pmclient" --server "$url" render scenes/sphere_caustic/scene.rad \
        --vf "scenes/sphere_caustic/$view.vf" -x 512 -y 512 -apg 100k 50 -apc 250k 50 -ab 1 \
        -o "$out/$view.exr" -o "$out/$view.hdr" -o "$out/$view.png"
done
echo "Pictures: $(cd "$out" && pwd)/{a,b}.{exr,hdr,png}"
