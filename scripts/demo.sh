#!/bin/sh
# From nothing to courses: installs what is missing, builds afptraj, plans the panel sample, prints the
# numbers that matter and where the files are.   scripts/demo.sh [RESULT-DIRECTORY]
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
result=${1:-"$root/build/demo-panel"}
"$root/scripts/setup.sh"
"$root/scripts/build.sh" release afptraj
afptraj="$root/build/release/cli/afptraj"
mkdir -p "$(dirname "$result")"
echo "demo: planning three plies on samples/panel"
"$afptraj" run "$root/samples/panel/part.step" "$root/samples/panel/plies.csv" --job "$root/samples/panel/job.toml" \
  -o "$result" --force
echo "demo: the courses are in $result"
echo "demo: your own part: $afptraj run part.step plies.csv -o result   (faces: $afptraj inspect part.step)"
