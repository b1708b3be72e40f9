#!/bin/sh
# Installs the Debian packages that are missing: sh deploy/install.sh [test]
# Exits 0 at once if nothing is missing, so that it needs no root on a machine that has them.
set -eu
packages="gcc libc6-dev cmake ninja-build pkg-config libembree-dev libsleef-dev libmicrohttpd-dev libjansson-dev
libsqlite3-dev libseccomp-dev libcurl4-openssl-dev libarchive-dev libexpat1-dev libssl-dev libopenexr-dev libpng-dev libzstd-dev"
[ "${1-}" = test ] && packages="$packages libcmocka-dev curl sqlite3"
missing=
for package in $packages; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
sudo=
if [ "$(id -u)" -ne 0 ]; then
    sudo=sudo
    command -v sudo >/dev/null || {
        echo "install.sh: these Debian packages are missing, and installing them needs root:$missing" >&2
        exit 1
    }
fi
echo "Installing:$missing" >&2
$sudo apt-get update -qq
# shellcheck disable=SC2086 # a list of words is meant
DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends $missing >&2
