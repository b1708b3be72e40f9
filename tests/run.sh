#!/bin/sh
# Installs what is missing, builds with warnings as errors, and runs every test.
set -eu
cd "$(dirname "$0")/.."
sh deploy/install.sh test
cmake --preset release -DPM_WERROR=ON
cmake --build --preset release
ctest --preset release "$@"
