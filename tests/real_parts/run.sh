#!/bin/bash
# Plans real STEP parts that others made and judges the result with the oracle (tests/oracle).
#
#   tests/real_parts/run.sh [--build DIR] [--out DIR] [--pictures] [name ...]
#
# Prints a table; exit code 0 when every part holds every limit, 1 when one does not, 77 (skipped) when the
# files are not there. They are looked for in $AFPTRAJ_SHARED/data/steps, by default ../shared beside the project.
set -u
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
build="$root/build"
out=""
pictures=0
names=()
while [ $# -gt 0 ]; do
  case "$1" in
    --build) build=$(cd "$2" && pwd) || exit 2; shift 2 ;;
    --out) out="$2"; shift 2 ;;
    --pictures) pictures=1; shift ;;
    -h|--help) sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "run.sh: unknown option $1" >&2; exit 2 ;;
    *) names+=("$1"); shift ;;
  esac
done
steps="${AFPTRAJ_SHARED:-$root/../shared}/data/steps"
if [ ! -d "$steps" ]; then
  echo "skipped: no real parts in $steps (set AFPTRAJ_SHARED)"
  exit 77
fi
find_program() {
  local found
  found=$(find "$build" -type f -name "$1" -perm -u+x 2>/dev/null | head -1)
  if [ -z "$found" ]; then echo "run.sh: $1 is not built in $build" >&2; exit 2; fi
  echo "$found"
}
afptraj=$(find_program afptraj) || exit 2
make_plies=$(find_program make_plies) || exit 2
measure=$(find_program measure) || exit 2
check_paths=$(find_program check_paths) || exit 2
render_paths=$(find_program render_paths) || exit 2
if [ -z "$out" ]; then
  out=$(mktemp -d)
  trap 'rm -rf "$out"' EXIT
fi
mkdir -p "$out"

failures=0

wanted() {
  [ ${#names[@]} -eq 0 ] && return 0
  local n
  for n in "${names[@]}"; do [ "$n" = "$1" ] && return 0; done
  return 1
}

# part NAME FILE FACES TOWS TOW_WIDTH UNIT SAMPLE "options of make_plies" "options of run"
part() {
  local name=$1 file=$2 faces=$3 tows=$4 width=$5 unit=$6 sample=$7 ply_options=$8 run_options=$9
  wanted "$name" || return 0
  local dir="$out/$name" unit_option=""
  rm -rf "$dir"; mkdir -p "$dir"
  [ -n "$unit" ] && unit_option="--unit $unit"
  # shellcheck disable=SC2086
  if ! "$make_plies" "$steps/$file" --faces "$faces" $unit_option $ply_options -o "$dir/plies.csv" 2>"$dir/make_plies.txt"; then
    printf '%-24s FAIL no ply points: %s\n' "$name" "$(head -1 "$dir/make_plies.txt")"
    failures=$((failures + 1)); return 0
  fi
  printf '[planning]\nsample = %s\n' "$sample" > "$dir/job.toml"
  # shellcheck disable=SC2086
  "$measure" "$dir/measure.txt" "$afptraj" run "$steps/$file" "$dir/plies.csv" -o "$dir/result" --job "$dir/job.toml" \
    --face "$faces" --tows "$tows" --tow-width "$width" $unit_option $run_options --timeout 300 -q >"$dir/stdout.txt" 2>"$dir/stderr.txt"
  local code=$?
  if [ $code -ne 0 ] || [ ! -f "$dir/result/paths.csv" ]; then
    printf '%-24s FAIL exit code %d: %s\n' "$name" $code "$(tail -1 "$dir/stderr.txt")"
    failures=$((failures + 1)); return 0
  fi
  local band row
  band=$(awk "BEGIN { printf \"%.10g\", $tows * $width }")
  # shellcheck disable=SC2086
  row=$("$check_paths" "$steps/$file" "$dir/result/paths.csv" --band "$band" --faces "$faces" $unit_option \
    --summary "$dir/result/summary.json" --label "$name" --json "$dir/check.json" 2>"$dir/check.txt") || failures=$((failures + 1))
  [ -n "$row" ] || row="$name FAIL check_paths: $(tail -1 "$dir/check.txt")"
  read -r seconds megabytes < "$dir/measure.txt"
  printf '%7s s %6s MB  %s\n' "$seconds" "$megabytes" "$row"
  if [ $pictures -eq 1 ]; then
    # shellcheck disable=SC2086
    "$render_paths" "$steps/$file" "$dir/result/paths.csv" "$out/$name.png" --band "$band" --tows "$tows" \
      --faces "$faces" $unit_option --plies "$dir/plies.csv"
  fi
}

# refused FILE: exit code 3, one line, nothing written.
refused() {
  local name
  name=$(basename "$1"); name=${name%.*}
  wanted "$name" || return 0
  local dir="$out/$name" problem="" code lines
  rm -rf "$dir"; mkdir -p "$dir"
  printf 'ply,x,y,z,dx,dy,dz\nP1,1e5,2e5,3e5,1,0,0\n' > "$dir/plies.csv"
  "$measure" "$dir/measure.txt" "$afptraj" run "$steps/$1" "$dir/plies.csv" -o "$dir/result" >"$dir/stdout.txt" 2>"$dir/stderr.txt"
  code=$?
  lines=$(wc -l < "$dir/stderr.txt")
  [ $code -eq 3 ] || problem="exit code $code, not 3; "
  [ "$lines" -eq 1 ] || problem="$problem$lines lines on stderr; "
  grep -q '^afptraj: ' "$dir/stderr.txt" || problem="${problem}no 'afptraj: ...' line; "
  [ -s "$dir/stdout.txt" ] && problem="${problem}text on stdout; "
  [ -z "$(find "$dir" -maxdepth 1 -name '*result*')" ] || problem="${problem}something was written; "
  if [ -n "$problem" ]; then
    failures=$((failures + 1))
    printf '%-34s FAIL %s%s\n' "$name" "$problem" "$(head -1 "$dir/stderr.txt")"
  else
    printf '%-34s ok  3  %s\n' "$name" "$(head -1 "$dir/stderr.txt" | sed "s|$steps/||g")"
  fi
}

echo "     time  memory  part                     ply      faces courses  segm  length mm   surface       E_k       end  crossings coverage % farthest"
part nacelle_cowl      tigl_nacelle.stp 3,4 8 12.7 "" 4 "--direction 1,0,0 --count 80" "--range 500"
part hull              goteborg_hull_m.step 2,3 8 6.35 "" 4 "--direction 1,0,0 --count 80" "--range 800"
part blade             iea15mw_blade_cfd.stp 2,3 8 50.8 m 40 "--direction 0,0,1 --count 200" "--range 8000 --step 20"
part wing_foot         caddee_simple_wing_foot.stp 3,4 8 6.35 "" 4 "--direction 0.1,1,0 --count 100" "--range 600"
part bend_and_hole     ncc_compost_x_test_141.stp 1,2,3 4 3.175 "" 2 "--direction 1,0,0 --angle 45 --count 60" "--range 60"
part cone              brl_rhino_primitives_m.stp 6 8 100 "" 40 "--direction 1,0,0 --count 80 --start 0,44000,5000" "--range 6000 --step 20"
part dome              brl_rhino_primitives_m.stp 7 8 100 "" 40 "--direction 1,0.3,0 --count 80 --start 52000,49000,-9700" "--range 6000 --step 20"
part dome_hoops        brl_rhino_primitives_m.stp 7 8 100 "" 40 "--direction 0,0,1 --count 80" "--range 6000 --step 20"
part cylinder          brl_rhino_primitives_m.stp 8 8 100 "" 40 "--axis 50000,0,0,0,0,1 --angle 45 --count 80" "--range 6000 --step 20"
part cylinder_axial    brl_rhino_primitives_m.stp 8 8 100 "" 40 "--axis 50000,0,0,0,0,1 --angle 0 --count 80" "--range 6000 --step 20"
part head_pole         cax_s1_head_rational_pole.stp 1,4 4 3.175 "" 2 "--direction 0,1,0.2 --count 60" "--range 40"
part fish              openvsp_fish_m.stp 1-8 8 3.175 "" 4 "--direction 1,0,0 --count 80" "--range 200"
part nacelle_45        tigl_nacelle.stp 3,4 8 12.7 "" 4 "--direction 1,0,0 --angle 45 --count 80" "--range 500"
part nacelle_hoops     tigl_nacelle.stp 3,4 8 12.7 "" 4 "--axis 0,0,0,1,0,0 --angle 90 --count 80" "--range 500"
# Of the engine's 16 smooth groups the nozzle's: its faces meet. Those of the outer skin (11,20-31,34,35,38) lie up to
# 1.57 mm apart along their edges, so that no spacing across them is defined to 1e-3 mm.
part engine            volmdlr_aircraft_engine.step 52,53 8 12.7 "" 4 "--axis 5717,1544,0,0,0,1 --angle 20 --count 100" "--range 900"
part engine_hoops      volmdlr_aircraft_engine.step 52,53 8 12.7 "" 4 "--axis 5717,1544,0,0,0,1 --angle 90 --count 100" "--range 900"
part box_wing          aeroshape_box_wing.step 1 8 25.4 m 20 "--direction 0.15,1,0 --count 150" "--range 2500 --step 5"

echo
refused malformed/gitlfs_pointer.step
refused malformed/ap209_fem_only.stp
refused malformed/assembly_missing_external_parts.stp
refused malformed/no_freeform_as1_assembly.stp
refused malformed/empty.step
refused malformed/truncated_60pct_nacelle.stp
refused malformed/iges_renamed.stp

echo
if [ $failures -gt 0 ]; then
  echo "$failures FAILED (* in the coverage: named in the summary with a reason)"
  exit 1
fi
echo "all hold (* in the coverage: named in the summary with a reason)"
