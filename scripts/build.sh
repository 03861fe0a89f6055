#!/bin/sh
# Configures and builds a preset (release, clang, asan, bench): scripts/build.sh PRESET [TARGET ...]
# Quiet unless something fails.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
preset=$1
shift
cd "$root"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! cmake --preset "$preset" >"$log" 2>&1; then
  cat "$log" >&2
  echo "build: configuring '$preset' failed" >&2
  exit 1
fi
targets=""
[ $# -eq 0 ] || targets="--target $*"
echo "build: $preset ${*:-everything} in build/$preset"
if ! cmake --build --preset "$preset" $targets >"$log" 2>&1; then
  grep -E "error|FAILED|warning" "$log" | head -40 >&2 || true
  tail -20 "$log" >&2
  echo "build: building '$preset' failed" >&2
  exit 1
fi
