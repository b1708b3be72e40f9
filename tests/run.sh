#!/bin/sh
# Installs what is missing, builds with warnings as errors, and runs every test; then everything but the
# long physics again under AddressSanitizer and UBSan, and what has threads under ThreadSanitizer.
#   sh tests/run.sh          all of it
#   sh tests/run.sh quick    the release build alone
set -eu
cd "$(dirname "$0")/.."
sh deploy/install.sh test

# run_preset NAME CTEST_ARGUMENT...
run_preset()
{
    preset=$1
    shift
    cmake --preset "$preset" -DPM_TESTS=ON -DPM_WERROR=ON
    cmake --build --preset "$preset"
    ctest --preset "$preset" -j 2 "$@"
}

run_preset release
[ "${1-}" = quick ] && exit 0
run_preset debug -E '^physics\.'
run_preset tsan -R '^(base\.pool|forward\.forward|photons\.|backward\.accumulate|server\.|client\.service)'
