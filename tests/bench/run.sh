#!/bin/sh
# Prints the tables of the benchmarks named: sh tests/bench/run.sh forward build mkpmap lookup render language world
# BUILD names another build tree than the release preset's.
set -eu
cd "$(dirname "$0")/../.."
build=${BUILD:-build/release}
[ $# -gt 0 ] || set -- forward build mkpmap lookup render world language
[ -f "$build/build.ninja" ] || cmake --preset release >/dev/null
for name in "$@"; do
    [ -f "tests/bench/bench_$name.c" ] || {
        echo "no benchmark '$name'; there are:" tests/bench/bench_*.c >&2
        exit 2
    }
    cmake --build "$build" --target "bench_$name" >&2
    "$build/bench/bench_$name"
done
