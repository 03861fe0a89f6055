#!/bin/sh
# Installs what is missing, builds everything and runs all tests.
#   scripts/test.sh            release build
#   scripts/test.sh asan       with address and undefined-behaviour sanitizers
#   scripts/test.sh clang      with Clang, which must be installed
# Further arguments go to ctest, for example: scripts/test.sh release -R cli
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
preset=${1:-release}
[ $# -eq 0 ] || shift
"$root/scripts/setup.sh"
"$root/scripts/build.sh" "$preset"
if [ "$preset" = release ]; then
  # every public header compiles alone
  "$root/scripts/build.sh" "$preset" all_verify_interface_header_sets
fi
cd "$root"
exec ctest --preset "$preset" --parallel "$(nproc)" "$@"
