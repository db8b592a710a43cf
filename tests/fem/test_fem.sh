#!/bin/sh
# Tests of the FreeFEM truth: one line per check, "ok - sentence" or "not ok - sentence: measured vs wanted".
# Exits 0 when every check passed. Needs FreeFem++-nw and gmsh; takes under a minute.
#
# Sample runs: tests/fem/test_fem.sh           the groups of `make test`
#              tests/fem/test_fem.sh long      those of `make test-fe`: inertia, memory and touch, two minutes
#              tests/fem/test_fem.sh scripts|laws|shapes|orders|mirror|patch|inertia|memory|touch|refusals      one group alone
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
fem=$here/../../fem
long=" inertia memory touch "
. "$here/groups"
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT INT TERM
# the packaged preferences name a plugin folder that does not exist
: "${FF_LOADPATH:=$(dirname "$(dpkg -L libfreefem++ | grep '/gmsh\.so$' | grep -v /mpi/ | head -n 1)")}"
export FF_LOADPATH OPENBLAS_NUM_THREADS=1
results=$work/results
: > "$results"

say() { echo "$1" | tee -a "$results"; }
# runs a test script; a script that ends without its own verdict is a failed check
script() {
  log=$work/log
  if ! FreeFem++-nw -nw -v 0 "$here/$1" $2 -C1 263 -C2 491 > "$log" 2>&1; then
    grep -q '^not ok' "$log" || say "not ok - $1 $2 runs: $(grep -v '^ok' "$log" | tail -n 3 | tr '\n' ' ') vs a verdict"
  fi
  grep -E '^(not )?ok - ' "$log" | tee -a "$results"
}
mesh() { gmsh -v 1 -2 -format msh22 -setnumber cells_x "$1" -setnumber cells_y "$1" "$fem/block.geo" -o "$work/$1.msh" > /dev/null; }
# law_of ARGUMENT...: law, the material's parameters where the arguments name no law of their own
law_of() { case " $* " in *" -law ogden "*) law='' ;; *) law='-C1 263 -C2 491' ;; esac; }
# solve NAME MESH DEPTH RECORDS X Y DX DY [more]
solve() {
  name=$1 cells=$2 depth=$3 records=$4 x=$5 y=$6 dx=$7 dy=$8
  shift 8
  law_of "$@"
  FreeFem++-nw -nw -v 0 "$fem/solve_path.edp" -mesh "$work/$cells.msh" -out "$work/$name.csv" -width 0.1 -height 0.1 \
    -thickness 0.001 $law -cells_x 10 -cells_y 10 -contact_x "$x" -contact_y "$y" -direction_x "$dx" \
    -direction_y "$dy" -depth "$depth" -records "$records" -tolerance 1e-11 -max_newton 12 "$@" \
    > "$work/$name.log" 2> "$work/$name.err"
}
mesh 10; mesh 20; mesh 40

# paths that must be refused: exit 1 (2 for arguments), one line on stderr, no end line
refused() {  # NAME STATUS WANTED-CODE WORDS SENTENCE
  lines=$(wc -l < "$work/$1.err")
  if [ "$2" = "$3" ] && [ "$lines" = 1 ] && grep -q -e "$4" "$work/$1.err" && ! { [ -f "$work/$1.csv" ] && grep -q '^end' "$work/$1.csv"; }
  then say "ok - $5"
  else say "not ok - $5: exit $2, $lines lines, '$(head -c 200 "$work/$1.err")' vs exit $3 and one line with '$4'"; fi
}

# ---- closed forms, derivatives, balance, refusals: the scripts' own checks
if group scripts; then for f in plane-stress plane-strain; do
  script homogeneous.edp "-formulation $f -state uniaxial"
  script homogeneous.edp "-formulation $f -state shear"
  script tangent.edp "-formulation $f"
  script law_chain.edp "-formulation $f"
  script folding.edp "-formulation $f"
  script balance.edp "-formulation $f -mesh $work/10.msh -contact_x 0.05 -contact_y 0.1 -direction_x 0 -direction_y -1"
  script balance.edp "-formulation $f -mesh $work/20.msh -contact_x 0 -contact_y 0.0537 -direction_x 0.8 -direction_y -0.6 -indenter patch"
  script balance.edp "-formulation $f -mesh $work/20.msh -contact_x 0.098 -contact_y 0.1 -direction_x -0.6 -direction_y -0.8 -indenter patch"
done; fi

# ---- another law, and regions of their own material
ogden="-law ogden -terms 2 -mu1 900 -alpha1 3.7 -mu2 -300 -alpha2 -9.3"
# same ONE OTHER TOLERANCE SENTENCE: the records of two paths, number by number, relative to each kind's largest
same() {
  awk -F, -v tolerance="$3" -v what="$4" '
    function size(a) { return a < 0 ? -a : a }
    FNR == NR { if ($1 == "node") for (i = 4; i <= 7; ++i) { n++; a[n] = $i; if (size($i) > largest[i > 5]) largest[i > 5] = size($i) } next }
    $1 == "node" { for (i = 4; i <= 7; ++i) { m++; e = size($i - a[m]) / largest[i > 5]; if (e > worst) worst = e } }
    END {
      if (n > 0 && n == m && worst <= tolerance) print "ok - " what
      else print "not ok - " what ": " n + 0 " and " m + 0 " numbers, relative difference " worst " vs " tolerance
    }' "$work/$1.csv" "$work/$2.csv" | tee -a "$results"
}
if group laws; then for f in plane-stress plane-strain; do
  for state in uniaxial shear; do script homogeneous.edp "-formulation $f -state $state $ogden"; done
  script tangent.edp "-formulation $f $ogden"
  push="0 0.063 0.8 -0.6 -formulation $f -indenter patch"
  solve m 20 0.006 3 $push
  solve o 20 0.006 3 $push -law ogden -terms 2 -mu1 526 -alpha1 2 -mu2 -982 -alpha2 -2
  same m o 1e-10 "Ogden with alpha = 2, -2 is Mooney-Rivlin, $f"
  solve o 20 0.006 3 $push -law ogden -terms 1 -mu1 526 -alpha1 2
  FreeFem++-nw -nw -v 0 "$fem/solve_path.edp" -mesh "$work/20.msh" -out "$work/n.csv" -width 0.1 -height 0.1 -thickness 0.001 \
    -C1 263 -C2 0 -cells_x 10 -cells_y 10 -contact_x 0 -contact_y 0.063 -direction_x 0.8 -direction_y -0.6 -depth 0.006 \
    -records 3 -tolerance 1e-11 -max_newton 12 -formulation $f -indenter patch > "$work/n.log" 2>&1
  same n o 1e-10 "Ogden with alpha = 2 is the neo-Hookean solid, $f"
done
script laminate.edp "-formulation plane-strain -C1_11 900 -C2_11 1500"
script laminate.edp "-formulation plane-stress -C1 754 -C2 0 -C1_11 2400 -C2_11 0"
script laminate.edp "-formulation plane-stress -state stretch -C1_11 900 -C2_11 1500"
fi

# ---- the block as any other shape: its triangles split by refine, its walls one free surface
shape() {  # NAME MESH DEPTH RECORDS X Y DX DY [more]: as solve, of a shape's mesh
  name=$1 file=$2 depth=$3 records=$4 x=$5 y=$6 dx=$7 dy=$8
  shift 8
  FreeFem++-nw -nw -v 0 "$fem/solve_path.edp" -mesh "$work/$file.msh" -out "$work/$name.csv" -thickness 0.001 -C1 263 -C2 491 \
    -contact_x "$x" -contact_y "$y" -direction_x "$dx" -direction_y "$dy" -depth "$depth" -records "$records" \
    -tolerance 1e-11 -max_newton 12 "$@" > "$work/$name.log" 2> "$work/$name.err"
}
if group shapes; then
awk '/^\$Elements/ { inside = 1 } inside && $2 == 1 && $4 > 1 { $4 = 2 } { print }' "$work/10.msh" > "$work/box.msh"
awk '/^\$Elements/ { inside = 1 } inside && $2 == 2 && $1 % 2 { $4 = 11 } { print }' "$work/box.msh" > "$work/patched.msh"
for f in plane-stress plane-strain; do
  # the lattices of block and shape have diagonals of their own, so what is lumped may differ between nodes: forces of the
  # contact are compared, and the field where no patch end slides nodes
  solve b 20 0.006 3 0 0.05 0.8 -0.6 -formulation $f -indenter patch
  shape s box 0.006 3 0 0.05 0.8 -0.6 -refine 2 -formulation $f -indenter patch
  awk -F, -v f=$f 'FNR == NR { if ($1 == "step" && $2 == 3) { x = $5; y = $6 } next }
    $1 == "step" && $2 == 3 { e = ($5 - x) ^ 2 + ($6 - y) ^ 2; l = x * x + y * y; seen = 1 }
    END { if (seen && e <= 1e-16 * l) print "ok - the block as a shape has the block'"'"'s contact force, " f
          else print "not ok - the block as a shape has the block'"'"'s contact force, " f ": relative square " e / (l + 1e-300) " vs 1e-16" }' \
    "$work/b.csv" "$work/s.csv" | tee -a "$results"
  shape t patched 0.006 3 0 0.05 0.8 -0.6 -refine 2 -formulation $f -indenter patch -C1_11 263 -C2_11 491
  if cmp -s "$work/s.csv" "$work/t.csv"; then say "ok - a region of the same material changes no bit, $f"
  else say "not ok - a region of the same material changes no bit, $f: $(cmp "$work/s.csv" "$work/t.csv" 2>&1) vs none"; fi
  shape h patched 0.002 1 0 0.05 0.8 -0.6 -refine 2 -formulation $f -indenter patch -C1_11 526 -C2_11 982
  awk -F, -v f=$f 'FNR == NR { if ($1 == "step" && $2 == 1) soft = $4; next } $1 == "step" && $2 == 1 { ratio = $4 / soft }
    END { if (ratio > 1.05 && ratio < 2) print "ok - half of the triangles twice as stiff: more energy, less than twice, " f
          else print "not ok - half of the triangles twice as stiff, " f ": energy times " ratio " vs 1.05 to 2" }' \
    "$work/s.csv" "$work/h.csv" | tee -a "$results"
  # a patch between nodes, round the corner: lumped forces add up, and its force is the block's but for the mesh
  shape r box 0.006 3 0.0968 0.1 -0.6 -0.8 -refine 3 -formulation $f -indenter patch
  awk -F, -v f=$f '$1 == "step" { r = $2; cx[r] = $5; cy[r] = $6; sx[r] = $7; sy[r] = $8; x[r] = y[r] = 0 } $1 == "node" { x[r] += $6; y[r] += $7 }
    END { big = cy[3] < 0 ? -cy[3] : cy[3]; e = (x[3] ^ 2 + y[3] ^ 2 + (cx[3] + sx[3]) ^ 2 + (cy[3] + sy[3]) ^ 2) / (big * big + 1e-300)
          if (r == 3 && e <= 1e-16) print "ok - a patch between the nodes of a shape balances, lumped too, " f
          else print "not ok - a patch between the nodes of a shape balances, " f ": record " r + 0 ", relative square " e " vs 1e-16" }' \
    "$work/r.csv" | tee -a "$results"
done
shape loose 10 0.005 5 0 0.05 1 0 -refine 1
refused loose $? 1 "boundary labelled 1 (fixed) beside one labelled 2 (free)" "a mesh without a free surface is refused as a shape"
shape first box 0.002 1 0.1 0.006 -1 0 -refine 2 -indenter patch
refused first $? 1 " 6 mm along the surface from the fixed edge; a patch needs 15 mm" "a patch near the beginning of a shape's free surface is refused"
shape last box 0.002 1 0 0.006 1 0 -refine 2 -indenter patch
refused last $? 1 " 6 mm along the surface from the fixed edge; a patch needs 15 mm" "a patch near the end of a shape's free surface is refused"
shape held box 0.002 1 0.05 0 0 1 -refine 2 -indenter patch
refused held $? 1 "not on the free surface" "a patch on the part of a shape that is held is refused"
fi

# ---- a smooth solution: P2 displacement of order 3 in L2 and 2 in H1, P1 pressure of order 2 in L2
if group orders; then for f in plane-stress plane-strain; do
  : > "$work/orders"
  for cells in 8 16 32; do
    FreeFem++-nw -nw -v 0 "$here/manufactured.edp" -C1 263 -C2 491 -formulation $f -cells $cells 2>&1 | grep -E '^(errors|not ok)' >> "$work/orders"
  done
  awk -v f="$f" '
    function check(what, a, b, order,   rate) {
      rate = (b > 0) ? log(a / b) / log(2) : 0
      if (rate > order - 0.15 && rate < order + 0.4) printf "ok - %s converges with order %d, measured %.2f, %s\n", what, order, rate, f
      else printf "not ok - %s converges with order %d, %s: %.2f vs %d\n", what, order, f, rate, order
    }
    /^errors/ { n++; l2[n] = $3; h1[n] = $4; p[n] = $5 }
    /^not ok/ { print }
    END {
      if (n < 3) print "not ok - manufactured solution solves on three meshes, " f ": " n + 0 " vs 3"
      else {
        check("displacement in L2", l2[2], l2[3], 3); check("displacement in H1", h1[2], h1[3], 2)
        if (f == "plane-strain") check("pressure in L2", p[2], p[3], 2)
      }
    }' "$work/orders" | tee -a "$results"
done; fi

# ---- mirrored cases give mirrored answers
mirrored() {
  awk -F, -v what="$3" '
    function size(a) { return a < 0 ? -a : a }
    $1 == "step" { r = $2 }
    FNR == NR && $1 == "node" { key = r "," sprintf("%.6f,%.6f", 0.1 - $2, $3); for (i = 4; i <= 7; ++i) a[key, i] = (i % 2 == 0) ? -$i : $i }
    FNR != NR && $1 == "node" {
      key = r "," sprintf("%.6f,%.6f", $2, $3); ++n; if (!((key, 4) in a)) bad = 1e9
      for (i = 4; i <= 7; ++i) {
        g = i > 5; e = size($i - a[key, i]); if (e > worst[g]) worst[g] = e; if (size($i) > largest[g]) largest[g] = size($i)
      }
    }
    END {
      e = (largest[0] > 0 && largest[1] > 0) ? worst[0] / largest[0] + worst[1] / largest[1] + bad : 1e9
      if (n > 0 && e <= 1e-8) print "ok - " what
      else print "not ok - " what ": relative difference " e " vs 1e-8"
    }' "$work/$1.csv" "$work/$2.csv" | tee -a "$results"
}
if group mirror; then for f in plane-stress plane-strain; do
  solve l 10 0.004 8 0 0.05 1 0 -formulation $f;  solve r 10 0.004 8 0.1 0.05 -1 0 -formulation $f
  mirrored l r "left and right point pushes mirror each other, $f"
  solve l 10 0.006 6 0 0.1 0.6 -0.8 -formulation $f -indenter patch;  solve r 10 0.006 6 0.1 0.1 -0.6 -0.8 -formulation $f -indenter patch
  mirrored l r "patches round the two top corners mirror each other, $f"
  solve l 20 0.006 6 0.037 0.1 0.28 -0.96 -formulation $f -indenter patch;  solve r 20 0.006 6 0.063 0.1 -0.28 -0.96 -formulation $f -indenter patch
  mirrored l r "patches between nodes of the top mirror each other, $f"
done; fi

# ---- the patch force settles under refinement
if group patch; then for f in plane-stress plane-strain; do
  for where in "0 0.05 1 0" "0.05 0.1 0 -1" "0 0.063 1 0"; do
    set -- $where
    for cells in 10 20 40; do solve p$cells $cells 0.005 5 $1 $2 $3 $4 -formulation $f -indenter patch; done
    awk -F, -v what="patch at ($1, $2), $f" -v dx="$3" -v dy="$4" '
      $1 == "step" && $2 == 5 { n++; force[n] = 1e3 * ($5 * dx + $6 * dy) }
      END {
        a = force[1] - force[2]; b = force[2] - force[3]; if (a < 0) a = -a; if (b < 0) b = -b
        line = sprintf("%.4f %.4f %.4f mN on 10, 5, 2.5 mm elements", force[1], force[2], force[3])
        if (n == 3 && b < a) printf "ok - differences shrink under refinement, rate %.2f, %s: %s\n", log(a / b) / log(2), what, line
        else printf "not ok - differences shrink under refinement, %s: %s vs shrinking\n", what, line
      }' "$work/p10.csv" "$work/p20.csv" "$work/p40.csv" | tee -a "$results"
  done
done; fi

# ---- tissue that relaxes: closed forms, and histories of a patch
if group inertia; then
script inertia.edp "-formulation plane-strain -density 1040"
for f in plane-stress plane-strain; do script swing.edp "-formulation $f -density 1040 -lasting 1"; done
script swing.edp "-formulation plane-strain -density 1040"
script swing.edp "-formulation plane-strain -density 1040 -branches 1 -g1 0.4 -tau1 0.05"
poke() { # NAME MORE: a patch of the top follows $work/poke.history
  name=$1
  shift
  solve "$name" 10 0.01 1 0.05 0.1 0 -1 -formulation plane-strain -indenter patch -history "$work/$name.history" "$@"
}
for t in 40 0.1; do
  awk -v T=$t 'BEGIN { for (n = 0; n <= 75; ++n) { s = n / 50; if (s > 1) s = 1; print n * T / 50, 0, -0.01 * s * s * s * (10 - 15 * s + 6 * s * s), 0 } }' > "$work/still$t.history"
  cp "$work/still$t.history" "$work/moving$t.history"
  poke still$t
  poke moving$t -density 1040
done
# far FROM TO: largest distance of forces, relative to the largest force
far() {
  awk -F, 'FNR == NR { if ($1 == "step") f[$2] = $8; next } $1 == "step" { d = $8 - f[$2]; if (d < 0) d = -d; if (d > e) e = d; if (-f[$2] > m) m = -f[$2]; ++n }
    END { print (n == 76 ? e / m : "nothing") }' "$work/$1.csv" "$work/$2.csv"
}
slow=$(far still40 moving40) quick=$(far still0.1 moving0.1)
awk -v a="$slow" -v b="$quick" 'BEGIN { if (a + 0 > 0 && a < 1e-4) print "ok - a slow poke does not feel the mass, to " a; else print "not ok - a slow poke does not feel the mass: " a " vs 1e-4"
  if (b + 0 > 0.1 && b < 1) print "ok - a quick one does, by " b " of its force"; else print "not ok - a quick one does: " b " vs 0.1 .. 1" }' | tee -a "$results"
# what contact and bed do not balance is the mass's: of a slow poke nothing
awk -F, '$1 == "step" { e = $8 + $10; if (e < 0) e = -e; if (FNR == NR) { if (e > slow) slow = e } else if (e > quick) quick = e }
  END { if (slow < 1e-5 && quick > 0.01) print "ok - what contact and bed do not balance is the mass'"'"'s: " quick " N of a quick poke, " slow " of a slow one"
        else print "not ok - what contact and bed do not balance is the mass'"'"'s: " quick " N of a quick poke, " slow " of a slow one vs > 0.01, < 1e-5" }' \
  "$work/moving40.csv" "$work/moving0.1.csv" | tee -a "$results"
cp "$work/still0.1.history" "$work/light.history"
poke light -density 0
refused light $? 2 "-density must be positive" "a density that is not positive is refused"
fi

if group memory; then
branches="-branches 2 -g1 0.45 -tau1 0.5 -g2 0.365 -tau2 50"
script memory.edp "-formulation plane-strain $branches -state uniaxial"
script memory.edp "-formulation plane-strain $branches -state shear"
script memory.edp "-formulation plane-strain $branches -g1_11 0.1 -g2_11 0 -state uniaxial"
script layers.edp "-formulation plane-strain $branches -g1_11 0.1 -g2_11 0"
script layers.edp "-formulation plane-strain $branches -g1_11 0 -g2_11 0.7 -C1_11 700"
script memory.edp "-formulation plane-strain -branches 3 -g1 0.3 -tau1 0.05 -g2 0.25 -tau2 1 -g3 0.2 -tau3 10 -state uniaxial"
relax() { # NAME MORE: a patch of the top follows $work/NAME.history
  name=$1
  shift
  solve "$name" 10 0.01 1 0.05 0.1 0 -1 -formulation plane-strain -indenter patch -history "$work/$name.history" "$@"
}
awk 'BEGIN { for (n = 0; n <= 10; ++n) print n / 100, 0, -n / 1000, n == 10; for (n = 1; n <= 6; ++n) print 0.1 + n * n / 4, 0, -0.01, 0 }' > "$work/hold.history"
cp "$work/hold.history" "$work/elastic.history"
relax hold $branches
relax elastic
solve push 10 0.01 10 0.05 0.1 0 -1 -formulation plane-strain -indenter patch
awk -F, 'FNR == NR { if ($1 == "step" && $2 == 10) { x = $5; y = $6 } else if ($1 == "node" && n < 1e9) node[++n] = $0; next }
  $1 == "step" && $2 == 10 { e = sqrt(($7 - x) ^ 2 + ($8 - y) ^ 2) / sqrt(x * x + y * y); seen = 1 } $1 == "node" { ++nodes }
  END { if (seen && e <= 1e-8 && nodes == 121) print "ok - without branches a history ends where the load path does, to " e
        else print "not ok - without branches a history ends where the load path does: " e ", " nodes + 0 " nodes vs 1e-8, 121" }' \
  "$work/push.csv" "$work/elastic.csv" | tee -a "$results"
awk -F, 'FNR == NR { if ($1 == "step") whole = $8; next } $1 == "step" { share = $8 / whole; if (n++ > 10 && share >= last) bad = 1; last = share }
  END { wanted = 1 - 0.45 * (1 - exp(-9 / 0.5)) - 0.365 * (1 - exp(-9 / 50))
        if (n == 17 && !bad && last > wanted - 0.02 && last < wanted + 0.02) print "ok - held for 9 s a patch relaxes step by step, to " last " of the elastic force"
        else print "not ok - held for 9 s a patch relaxes step by step: " n + 0 " steps, " last " vs about " wanted }' \
  "$work/elastic.csv" "$work/hold.csv" | tee -a "$results"
# half the step, a quarter of the distance; a step that is cut because it fails is one of them
for parts in 6 12 24; do
  awk -v n=$parts 'BEGIN { for (k = 0; k <= n; ++k) { s = k / n; print 0.6 * s, 0.004 * sin(2 * s), -0.008 * s * (1.6 - s), 0 } }' > "$work/wander$parts.history"
  relax wander$parts $branches
done
awk -F, 'FNR == 1 { ++file } $1 == "step" { x[file] = $7; y[file] = $8 }
  END { a = sqrt((x[1] - x[2]) ^ 2 + (y[1] - y[2]) ^ 2); b = sqrt((x[2] - x[3]) ^ 2 + (y[2] - y[3]) ^ 2); rate = (b > 0) ? log(a / b) / log(2) : 0
        if (rate > 1.6 && rate < 2.4) printf "ok - a history converges with the second order of its step, measured %.2f\n", rate
        else printf "not ok - a history converges with the second order of its step: %.2f vs 2\n", rate }' \
  "$work/wander6.csv" "$work/wander12.csv" "$work/wander24.csv" | tee -a "$results"
# a region's own shares: the base's change nothing, others do
awk '/^\$Elements/ { inside = 1 } inside && $2 == 2 && $1 % 2 { $4 = 11 } { print }' "$work/10.msh" > "$work/speckled.msh"
more() { solve $1 speckled 0.01 1 0.05 0.1 0 -1 -formulation plane-strain -indenter patch -history "$work/hold.history" $branches $2; }
push="0.004 2 0.05 0.1 0 -1 -formulation plane-strain -indenter patch"
solve still speckled $push
solve shares speckled $push $branches -g1_11 0.1
same still shares 1e-12 "a push that takes no time is elastic, where a region has its own shares too"
more base; more same "-g1_11 0.45 -g2_11 0.365"; more other "-g1_11 0 -g2_11 0"
awk -F, 'FNR == 1 { ++file } $1 == "step" { for (j = 0; j < 2; ++j) f[file, $2, j] = $(7 + j); if (-$8 > m) m = -$8; last = $2 }
  END { for (n = 0; n <= last; ++n) for (j = 0; j < 2; ++j) { e = f[2, n, j] - f[1, n, j]; if (e < 0) e = -e; if (e > off) off = e }
        lasts = f[3, last, 1] / f[1, last, 1]
        if (last == 16 && m > 0 && off <= 1e-12 * m && lasts > 1.2) print "ok - a region with the shares of the rest relaxes as the rest, to " off / m ", one that does not relax keeps force, " lasts " times"
        else print "not ok - a region with the shares of the rest relaxes as the rest: off by " off / m " vs 1e-12; one that does not relax keeps force: " lasts " vs > 1.2" }' \
  "$work/base.csv" "$work/same.csv" "$work/other.csv" | tee -a "$results"
printf '0 0 0 0\n0.5 0.05 -0.08 0\n' > "$work/leap.history"
relax leap $branches
leap=$?
refused leap $leap 1 "at 0.5 s; the contact (0.05, 0.1) m" "a history that FE cannot follow is refused with its time and place"
printf '0 0 0 0\n0.5 0 -0.001 0\n0.5 0 -0.002 0\n' > "$work/late.history"
relax late $branches
refused late $? 1 "line 3 of the history is not later" "a history that goes back in time is refused"
printf '0.1 0 0 0\n0.5 0 -0.001 0\n' > "$work/early.history"
relax early $branches
refused early $? 1 "does not begin at time 0 and at rest" "a history that begins elsewhere is refused"
relax nowhere $branches
refused nowhere $? 1 "cannot read a history" "a history that is not there is refused"
relax hold -branches 2 -g1 0.6 -tau1 0.5 -g2 0.4 -tau2 50
refused hold $? 2 "sum to less than 1" "shares that leave nothing are refused"
relax hold -branches 1 -g1 0.6 -tau1 -1
refused hold $? 2 "must be positive" "a branch without a time is refused"
solve sheet 10 0.01 1 0.05 0.1 0 -1 $branches
refused sheet $? 2 "needs a solid, or -formulation plane-strain" "branches in plane stress are refused"
fi

# ---- a tool that leaves and lands again, at its contact or at the other
if group touch; then
touch() { # NAME MESH MORE: a tool at (0.03, 0.1) and, across the middle, at (0.07, 0.1) follows $work/NAME.history
  name=$1 cells=$2
  shift 2
  solve "$name" $cells 0.01 1 0.03 0.1 0 -1 -formulation plane-strain -second_x 0.07 -second_y 0.1 -history "$work/$name.history" "$@"
}
# of a branch of 0.5 s: 8 mm in 0.2 s, held 0.8 s, away for 20 of its times, and the same at the same contact, then at the other
awk 'function press(c,   n) { for (n = 1; n <= 8; ++n) print t + n / 40, 0.0005 * n, -0.001 * n, 0, c; for (n = 1; n <= 4; ++n) print t + 0.2 + n / 5, 0.004, -0.008, 0, c; t += 1 }
  function leave(   n) { for (n = 1; n <= 20; ++n) print t + n * n / 40, 0, 0.001, n == 2, 0; t += 10 }
  BEGIN { print 0, 0, 0, 0, 1; press(1); leave(); press(1); leave(); press(2) }' > "$work/again.history"
touch again 20 -indenter patch -branches 1 -g1 0.3 -tau1 0.5
awk -F, '$1 == "step" { d[$2, 0] = $4; d[$2, 1] = $5; c[$2] = $6; f[$2, 0] = $7; f[$2, 1] = $8; if ($6 == 0 && ($4 != 0 || $5 != 0 || $7 != 0 || $8 != 0)) pulls = 1 }
  function size(a) { return a < 0 ? -a : a }
  END { for (n = 1; n <= 12; ++n) {
          if (size(f[n, 1]) > m) m = size(f[n, 1])
          for (j = 0; j < 2; ++j) { e = size(f[n + 32, j] - f[n, j]); if (e > same) same = e }
        }
        if (c[12] == 1 && c[13] == 0 && c[33] == 1 && c[65] == 2 && c[76] == 2 && d[8, 1] == -0.008 && !pulls) print "ok - a tool that is away has no displacement and no force"
        else print "not ok - a tool that is away has no displacement and no force: contacts " c[12] c[13] c[33] c[65] c[76] ", " d[8, 1] " m, pulls " pulls + 0 " vs 10122, -0.008, 0"
        if (m > 0 && same <= 1e-6 * m) print "ok - after 20 relaxation times without it the tool finds what it first found, to " same / m
        else print "not ok - after 20 relaxation times without it the tool finds what it first found: " same " of " m " N vs 1e-6" }' "$work/again.csv" | tee -a "$results"
# the second contact alone, as the first of a run of its own
awk 'BEGIN { print 0, 0, 0, 0, 0; print 0.1, 0, 0, 0, 0; for (n = 1; n <= 8; ++n) print 0.1 + n / 40, 0.0005 * n, -0.001 * n, 0, 2 }' > "$work/other.history"
sed 's/ 2$/ 1/' "$work/other.history" > "$work/alone.history"
touch other 20 -indenter patch -branches 1 -g1 0.3 -tau1 0.5
solve alone 20 0.01 1 0.07 0.1 0 -1 -formulation plane-strain -indenter patch -history "$work/alone.history" -branches 1 -g1 0.3 -tau1 0.5
awk -F, 'FNR == NR { if ($1 == "step") for (j = 0; j < 2; ++j) f[$2, j] = $(7 + j); next } $1 == "step" { for (j = 0; j < 2; ++j) { d = $(7 + j) - f[$2, j]; e += d * d; m += f[$2, j] ^ 2 } ++n }
  END { if (n == 10 && m > 0 && e <= 1e-16 * m) print "ok - the second contact is the first one elsewhere"
        else print "not ok - the second contact is the first one elsewhere: " n + 0 " steps, relative square " e / (m + 1e-300) " vs 10, 1e-16" }' "$work/alone.csv" "$work/other.csv" | tee -a "$results"
# patches between nodes: the second one's ends leave the first one's where they are
printf '0 0 0 0 1\n0.1 0.002 -0.004 0 1\n' > "$work/pinned.history"
cp "$work/pinned.history" "$work/only.history"
for name in only pinned; do
  solve $name 20 0.01 1 0.043 0.1 0 -1 -formulation plane-strain -indenter patch -history "$work/$name.history" $([ $name = only ] || echo -second_x 0.056 -second_y 0.1)
done
awk -F, '$1 == "step" && $2 == 1 { f = sqrt($7 * $7 + $8 * $8); if (FNR == NR) only = f }
  END { e = f / (only + 1e-300) - 1; if (e < 0) e = -e
        if (f > 0 && e < 2e-3) print "ok - nodes at the ends of a second patch leave those of the first, whose force is the same to " e
        else print "not ok - nodes at the ends of a second patch leave those of the first: its force differs by " e " vs 2e-3" }' "$work/only.csv" "$work/pinned.csv" | tee -a "$results"
# taken up in its imprint: a node that is touched where it is, carries next to nothing, and goes from there to where it is told
awk 'BEGIN { print 0, 0, 0, 0, 1; for (n = 1; n <= 8; ++n) print n / 40, 0.0002 * n, -0.0005 * n, 0, 1; print 2, 0.0016, -0.004, 0, 1; print 2.001, 0, 0, 0, 0; print 2.1, 0, 0, 1, 0
  print 2.1001, 0, 0, 1, 1; for (n = 1; n <= 4; ++n) print 2.1 + n / 40, 0, -0.001 * n, 0, 1 }' > "$work/imprint.history"
touch imprint 10 -indenter point -branches 2 -g1 0.45 -tau1 0.5 -g2 0.365 -tau2 50
awk -F, '$1 == "step" { n = $2; x[n] = $4; y[n] = $5; f[n] = sqrt($7 * $7 + $8 * $8) } $1 == "node" && $2 == 0.03 && $3 == 0.1 { u[n] = $4; v[n] = $5 }
  END { e = sqrt((x[12] - u[11]) ^ 2 + (y[12] - v[11]) ^ 2) / sqrt(u[11] ^ 2 + v[11] ^ 2 + 1e-300)
        half = sqrt((x[14] - u[11] / 2) ^ 2 + (y[14] + 0.002 - v[11] / 2) ^ 2) / 0.002
        if (v[11] < -2e-4 && v[11] > -3e-3 && u[11] > 1e-5 && e < 1e-9 && f[12] < 1e-3 * f[9] && half < 1e-9 && x[16] == 0 && y[16] == -0.004 && f[16] > f[12])
          print "ok - a tool that lands in its imprint takes it as it is, " 1e3 * v[11] " mm deep, and goes on from there"
        else print "not ok - a tool that lands in its imprint takes it as it is and goes on from there: (" u[11] ", " v[11] ") m, off by " e ", " f[12] " of " f[9] " N, halfway off by " half ", ends at (" x[16] ", " y[16] ")" }' \
  "$work/imprint.csv" | tee -a "$results"
# let go of a deep push, from which Newton's method alone goes elsewhere
awk 'BEGIN { for (n = 0; n <= 15; ++n) print n / 100, 0, -n / 1000, 0, 1; print 0.151, 0, 0, 1, 0; print 0.152, 0, 0, 0, 0 }' > "$work/deep.history"
touch deep 10 -indenter patch
awk -F, '$1 == "step" { n = $2; if (n == 15) held = -$8; if (n > 15 && ($8 != 0 || $10 > 1e-9 * held || -$10 > 1e-9 * held)) off = 1 } $1 == "node" { ++nodes; for (i = 4; i <= 5; ++i) if ($i > 1e-9 || $i < -1e-9) ++moved }
  END { if (n == 17 && nodes == 121 && !moved && !off) print "ok - let go of 15 mm at once, elastic tissue is at rest"
        else print "not ok - let go of 15 mm at once, elastic tissue is at rest: " n + 0 " steps, " moved + 0 " of " nodes + 0 " nodes moved, forces off " off + 0 }' "$work/deep.csv" | tee -a "$results"
printf '0 0 0 0 1\n0.1 0 -0.001 0 1\n0.2 0 -0.001 0 2\n' > "$work/jump.history"
touch jump 10 -indenter patch
refused jump $? 1 "line 3 of the history goes to another contact; the tool must be away" "a tool that jumps between contacts is refused"
printf '0 0 0 0 1\n0.1 0 -0.001 0 3\n' > "$work/third.history"
touch third 10 -indenter patch
refused third $? 1 "line 2 of the history has the contact 3, which is not there" "a contact that is not there is refused"
printf '0 0 0 0\n0.1 0 -0.001 0 1\n' > "$work/uneven.history"
touch uneven 10 -indenter patch
refused uneven $? 1 "line 2 of the history has not as many numbers as the first" "lines of several lengths are refused"
printf '0 0 0\n0.1 0 0\n' > "$work/narrow.history"
touch narrow 10 -indenter patch
refused narrow $? 1 "a line of the history has 3 numbers, not 4, or 5 with the contact" "lines that are too short are refused"
solve bare 10 0.01 1 0.03 0.1 0 -1 -formulation plane-strain -indenter patch -second_x 0.07 -second_y 0.1
refused bare $? 2 "a second contact .* needs a -history" "a second contact without a history is refused"
cp "$work/deep.history" "$work/low.history"
solve low 10 0.01 1 0.03 0.1 0 -1 -formulation plane-strain -indenter patch -second_x 0 -second_y 0.012 -history "$work/low.history"
refused low $? 1 "the contact (0, 0.012) m is 12 mm along the surface from the fixed edge" "a second patch too near to the fixed edge is refused"
fi

# ---- refusals
if group refusals; then
solve fold 10 0.015 30 0 0.1 0 -1 -formulation plane-strain
refused fold $? 1 "refused between .* mm of push.*surface passes through itself.*mm" "a self-crossing corner push is refused with its place and load"
solve near 10 0.005 5 0 0.012 1 0 -indenter patch
refused near $? 1 "12 mm along the surface from the fixed edge" "a patch nearer than 15 mm to the fixed edge is refused"
solve narrow 40 0.002 1 0 0.0085 1 0 -indenter patch -patch_half_width 0.003
refused narrow $? 1 "8.5 mm along the surface from the fixed edge; a patch needs 9 mm" "a narrower one nearer than three of its half widths is refused"
if solve small 40 0.002 1 0 0.009 1 0 -indenter patch -patch_half_width 0.003 && grep -q '^end' "$work/small.csv"
then say "ok - a narrower one there is solved"
else say "not ok - a narrower one there is solved: $(head -c 200 "$work/small.err") vs an end line"; fi
solve inside 10 0.005 5 0.03 0.05 1 0 -indenter patch
refused inside $? 1 "not on the free surface" "a contact off the surface is refused"
solve between 10 0.005 5 0 0.053 1 0
refused between $? 1 "no FE node at the contact" "a point contact between nodes is refused"
solve word 10 0.005 5 0 0.05 1 0 -formulation plane
refused word $? 2 "plane-stress or plane-strain" "an unknown formulation is refused"
solve misspelt 10 0.005 5 0 0.05 1 0 -formulatoin plane-strain
refused misspelt $? 2 "argument -formulatoin is not known" "a misspelt argument is refused"
solve far 10 0.005 5 0 0.05 1 0 -C1_99 500
refused far $? 2 "argument -C1_99 is not known" "parameters of a region that the mesh has not are refused"
solve odd 10 0.005 5 0 0.05 1 0 -indenter
refused odd $? 2 "argument -indenter has no value" "an argument without a value is refused"
solve other 10 0.005 5 0 0.05 1 0 -disc_radius 0.007
refused other $? 2 "argument -disc_radius is not known" "an argument of a path in space is refused in the plane"
for word in abc 2e 0x10 1,5 3mm nan 1e999; do
  solve number 40 0.002 1 0 0.012 1 0 -indenter patch -patch_half_width "$word"
  refused number $? 2 "argument -patch_half_width must be a number, got $word" "'$word' for a number is refused"
done
if solve number 40 0.002 1 0 0.012 1 0 -indenter patch -patch_half_width +.3E-2 && grep -q '^end' "$work/number.csv"
then say "ok - a number with a power of ten is taken"
else say "not ok - a number with a power of ten is taken: $(head -c 200 "$work/number.err") vs an end line"; fi
for word in 1.5 one 1e0 99999999999; do
  solve whole 10 0.005 5 0 0.05 1 0 -branches "$word"
  refused whole $? 2 "argument -branches must be a whole number, got $word" "'$word' for a whole number is refused"
done
head -c 3000 "$work/10.msh" > "$work/broken.msh"
solve broken broken 0.005 5 0 0.05 1 0
refused broken $? 1 "cannot read a whole mesh" "a mesh file that breaks off is refused"
sed 's/^\([0-9]* 1 2\) 1 /\1 9 /' "$work/10.msh" > "$work/unnamed.msh"
solve unnamed unnamed 0.005 5 0 0.05 1 0
refused unnamed $? 1 "holds 0 of 21 nodes" "a mesh without the named bottom is refused"
solve long 10 0.005 5 0 0.05 1 1
refused long $? 2 "unit vector" "a direction that is no unit vector is refused"
fi

passed=$(grep -c '^ok' "$results")
failed=$(grep -c '^not ok' "$results")
echo "$passed checks passed, $failed failed"
[ "$failed" = 0 ] && [ "$passed" -gt 0 ]
