#!/bin/sh
# Installs what a build of afptraj needs on Debian 12 and is not there yet; says what it does. May be
# run again: it then does nothing. Needs root or sudo only when something is missing.
set -eu

# docs/dependencies.md gives the reason and licence of each.
packages="g++ cmake ninja-build ccache
libeigen3-dev libtbb-dev libceres-dev libcgal-dev libboost-dev libpolyclipping-dev
libocct-foundation-dev libocct-modeling-data-dev libocct-modeling-algorithms-dev libocct-ocaf-dev
libocct-visualization-dev libocct-data-exchange-dev
libtoml11-dev nlohmann-json3-dev libcli11-dev libgtest-dev libbenchmark-dev zlib1g-dev"

if ! command -v dpkg-query >/dev/null 2>&1; then
  echo "setup: this is no Debian system; install by hand:" $packages >&2
  exit 1
fi
missing=""
for package in $packages; do
  state=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$state" = installed ] || missing="$missing $package"
done
if [ -z "$missing" ]; then
  echo "setup: everything is installed"
  exit 0
fi

as_root=""
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null 2>&1; then
    echo "setup: missing:$missing" >&2
    echo "setup: needs root: run as root 'apt-get install$missing', or install sudo" >&2
    exit 1
  fi
  as_root="sudo"
fi
echo "setup: installing$missing"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
install() {
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >"$log" 2>&1
}
# the lists of packages may be old or empty: fetch them only when the first try fails
if ! install; then
  $as_root apt-get update -qq >"$log" 2>&1 || { cat "$log" >&2; echo "setup: apt-get update failed" >&2; exit 1; }
  install || { cat "$log" >&2; echo "setup: apt-get install failed" >&2; exit 1; }
fi
echo "setup: done"
