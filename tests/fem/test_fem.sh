#!/bin/sh
# Tests of the FE reference (FreeFEM): one line per check, "ok - sentence" or "not ok - sentence: measured vs wanted".
# Exits 0 if every check passed. Needs FreeFem++-nw and gmsh; takes under a minute.
#
# Sample runs: tests/fem/test_fem.sh           the groups of `make test`
#              tests/fem/test_fem.sh long      those of `make test-fe`: inertia, memory and touch, two minutes
#              tests/fem/test_fem.sh scripts|laws|shapes|orders|mirror|patch|inertia|memory|touch|refusals  one group
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
fem=$here/../../fem
long=" inertia memory touch "
. "$here/groups"

mesh() { gmsh -v 1 -2 -format msh22 -setnumber cells_x "$1" -setnumber cells_y "$1" "$fem/block.geo" -o "$work/$1.msh" > /dev/null; }
# law_of ARGUMENT...: sets `law` to Mooney-Rivlin parameters, or to nothing if the arguments contain -law ogden
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

# A load path that must be refused: the wanted exit status (2 for arguments, else 1), one line on stderr, no end row.
refused() {  # NAME STATUS WANTED-CODE WORDS SENTENCE
  lines=$(wc -l < "$work/$1.err")
  if [ "$2" = "$3" ] && [ "$lines" = 1 ] && grep -q -e "$4" "$work/$1.err" && ! { [ -f "$work/$1.csv" ] && grep -q '^end' "$work/$1.csv"; }
  then say "ok - $5"
  else say "not ok - $5: exit $2, $lines lines, '$(head -c 200 "$work/$1.err")' vs exit $3 and one line with '$4'"; fi
}

# ---- closed forms, derivatives, balance, refusals: checks of the scripts
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

# ---- Ogden's material law, and regions with a material of their own
ogden="-law ogden -terms 2 -mu1 900 -alpha1 3.7 -mu2 -300 -alpha2 -9.3"
# same ONE OTHER TOLERANCE SENTENCE: compares all displacements and forces of two load paths, relative to the largest
# displacement or force
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
  same m o 1e-10 "the load path of Ogden with alpha = 2, -2 is that of Mooney-Rivlin, $f"
  solve o 20 0.006 3 $push -law ogden -terms 1 -mu1 526 -alpha1 2
  FreeFem++-nw -nw -v 0 "$fem/solve_path.edp" -mesh "$work/20.msh" -out "$work/n.csv" -width 0.1 -height 0.1 -thickness 0.001 \
    -C1 263 -C2 0 -cells_x 10 -cells_y 10 -contact_x 0 -contact_y 0.063 -direction_x 0.8 -direction_y -0.6 -depth 0.006 \
    -records 3 -tolerance 1e-11 -max_newton 12 -formulation $f -indenter patch > "$work/n.log" 2>&1
  same n o 1e-10 "the load path of Ogden with alpha = 2 is that of the neo-Hookean solid, $f"
done
script laminate.edp "-formulation plane-strain -C1_11 900 -C2_11 1500"
script laminate.edp "-formulation plane-stress -C1 754 -C2 0 -C1_11 2400 -C2_11 0"
script laminate.edp "-formulation plane-stress -state stretch -C1_11 900 -C2_11 1500"
fi

# ---- the block given as a shape: -refine splits its triangles, and its walls are one free surface
shape() {  # NAME MESH DEPTH RECORDS X Y DX DY [more]: as solve, for the mesh of a shape
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
  # The lattices of block and shape have different diagonals, so lumped nodal forces may differ. Contact forces are
  # compared.
  solve b 20 0.006 3 0 0.05 0.8 -0.6 -formulation $f -indenter patch
  shape s box 0.006 3 0 0.05 0.8 -0.6 -refine 2 -formulation $f -indenter patch
  awk -F, -v f=$f 'FNR == NR { if ($1 == "step" && $2 == 3) { x = $5; y = $6 } next }
    $1 == "step" && $2 == 3 { e = ($5 - x) ^ 2 + ($6 - y) ^ 2; l = x * x + y * y; seen = 1 }
    END { if (seen && e <= 1e-16 * l) print "ok - the block given as a shape has the contact force of the block, " f
          else print "not ok - the block given as a shape has the contact force of the block, " f ": relative square " e / (l + 1e-300) " vs 1e-16" }' \
    "$work/b.csv" "$work/s.csv" | tee -a "$results"
  shape t patched 0.006 3 0 0.05 0.8 -0.6 -refine 2 -formulation $f -indenter patch -C1_11 263 -C2_11 491
  if cmp -s "$work/s.csv" "$work/t.csv"; then say "ok - a region of the same material leaves the output file identical, $f"
  else say "not ok - a region of the same material leaves the output file identical, $f: $(cmp "$work/s.csv" "$work/t.csv" 2>&1) vs none"; fi
  shape h patched 0.002 1 0 0.05 0.8 -0.6 -refine 2 -formulation $f -indenter patch -C1_11 526 -C2_11 982
  awk -F, -v f=$f 'FNR == NR { if ($1 == "step" && $2 == 1) soft = $4; next } $1 == "step" && $2 == 1 { ratio = $4 / soft }
    END { if (ratio > 1.05 && ratio < 2) print "ok - twice the stiffness in half of the triangles increases the energy by 5 % to 100 %, " f
          else print "not ok - twice the stiffness in half of the triangles increases the energy by 5 % to 100 %, " f ": energy times " ratio " vs 1.05 to 2" }' \
    "$work/s.csv" "$work/h.csv" | tee -a "$results"
  # A patch that ends between nodes, near a corner: the lumped forces add up to zero, and contact and support forces are
  # opposite.
  shape r box 0.006 3 0.0968 0.1 -0.6 -0.8 -refine 3 -formulation $f -indenter patch
  awk -F, -v f=$f '$1 == "step" { r = $2; cx[r] = $5; cy[r] = $6; sx[r] = $7; sy[r] = $8; x[r] = y[r] = 0 } $1 == "node" { x[r] += $6; y[r] += $7 }
    END { big = cy[3] < 0 ? -cy[3] : cy[3]; e = (x[3] ^ 2 + y[3] ^ 2 + (cx[3] + sx[3]) ^ 2 + (cy[3] + sy[3]) ^ 2) / (big * big + 1e-300)
          if (r == 3 && e <= 1e-16) print "ok - forces of a patch between the nodes of a shape balance, and so do the lumped forces, " f
          else print "not ok - forces of a patch between the nodes of a shape balance, and so do the lumped forces, " f ": record " r + 0 ", relative square " e " vs 1e-16" }' \
    "$work/r.csv" | tee -a "$results"
done
shape loose 10 0.005 5 0 0.05 1 0 -refine 1
refused loose $? 1 "boundary labelled 1 (fixed) beside one labelled 2 (free)" "a mesh without a free surface is refused as a shape"
shape first box 0.002 1 0.1 0.006 -1 0 -refine 2 -indenter patch
refused first $? 1 " 6 mm along the surface from the fixed edge; a patch needs 15 mm" "a patch near the beginning of a shape's free surface is refused"
shape last box 0.002 1 0 0.006 1 0 -refine 2 -indenter patch
refused last $? 1 " 6 mm along the surface from the fixed edge; a patch needs 15 mm" "a patch near the end of a shape's free surface is refused"
shape held box 0.002 1 0.05 0 0 1 -refine 2 -indenter patch
refused held $? 1 "not on the free surface" "a patch on the fixed part of a shape is refused"
fi

# ---- a smooth solution: P2 displacement converges with order 3 in L2 and 2 in H1, P1 pressure with order 2 in L2
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
      if (n < 3) print "not ok - the manufactured solution converges on three meshes, " f ": " n + 0 " vs 3"
      else {
        check("displacement in L2", l2[2], l2[3], 3); check("displacement in H1", h1[2], h1[3], 2)
        if (f == "plane-strain") check("pressure in L2", p[2], p[3], 2)
      }
    }' "$work/orders" | tee -a "$results"
done; fi

# ---- mirrored load paths have mirrored results
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
  mirrored l r "indentations of the left and right side by a point mirror each other, $f"
  solve l 10 0.006 6 0 0.1 0.6 -0.8 -formulation $f -indenter patch;  solve r 10 0.006 6 0.1 0.1 -0.6 -0.8 -formulation $f -indenter patch
  mirrored l r "indentations by patches at the two top corners mirror each other, $f"
  solve l 20 0.006 6 0.037 0.1 0.28 -0.96 -formulation $f -indenter patch;  solve r 20 0.006 6 0.063 0.1 -0.28 -0.96 -formulation $f -indenter patch
  mirrored l r "indentations by patches between nodes of the top mirror each other, $f"
done; fi

# ---- the patch force converges under refinement
if group patch; then for f in plane-stress plane-strain; do
  for where in "0 0.05 1 0" "0.05 0.1 0 -1" "0 0.063 1 0"; do
    set -- $where
    for cells in 10 20 40; do solve p$cells $cells 0.005 5 $1 $2 $3 $4 -formulation $f -indenter patch; done
    awk -F, -v what="patch at ($1, $2), $f" -v dx="$3" -v dy="$4" '
      $1 == "step" && $2 == 5 { n++; force[n] = 1e3 * ($5 * dx + $6 * dy) }
      END {
        a = force[1] - force[2]; b = force[2] - force[3]; if (a < 0) a = -a; if (b < 0) b = -b
        line = sprintf("%.4f %.4f %.4f mN on 10, 5, 2.5 mm elements", force[1], force[2], force[3])
        if (n == 3 && b < a) printf "ok - differences of the contact force decrease under refinement, rate %.2f, %s: %s\n", log(a / b) / log(2), what, line
        else printf "not ok - differences of the contact force decrease under refinement, %s: %s vs decreasing\n", what, line
      }' "$work/p10.csv" "$work/p20.csv" "$work/p40.csv" | tee -a "$results"
  done
done; fi

# ---- tissue with mass: a wave, an oscillation, and displacement histories of a patch
if group inertia; then
script inertia.edp "-formulation plane-strain -density 1040"
for f in plane-stress plane-strain; do script swing.edp "-formulation $f -density 1040 -lasting 1"; done
script swing.edp "-formulation plane-strain -density 1040"
script swing.edp "-formulation plane-strain -density 1040 -branches 1 -g1 0.4 -tau1 0.05"
poke() { # NAME MORE: a patch of the top follows $work/NAME.history
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
# far FROM TO: largest difference of contact forces, relative to the largest force
far() {
  awk -F, 'FNR == NR { if ($1 == "step") f[$2] = $8; next } $1 == "step" { d = $8 - f[$2]; if (d < 0) d = -d; if (d > e) e = d; if (-f[$2] > m) m = -f[$2]; ++n }
    END { print (n == 76 ? e / m : "nothing") }' "$work/$1.csv" "$work/$2.csv"
}
slow=$(far still40 moving40) quick=$(far still0.1 moving0.1)
awk -v a="$slow" -v b="$quick" 'BEGIN { if (a + 0 > 0 && a < 1e-4) print "ok - mass changes the force of a slow indentation by less than 1e-4: " a; else print "not ok - mass changes the force of a slow indentation by less than 1e-4: " a " vs 1e-4"
  if (b + 0 > 0.1 && b < 1) print "ok - mass changes the force of a quick indentation by more than 0.1 of it: " b; else print "not ok - mass changes the force of a quick indentation by more than 0.1 of it: " b " vs 0.1 .. 1" }' | tee -a "$results"
# The sum of contact and support force is the inertia: almost zero for a slow indentation.
awk -F, '$1 == "step" { e = $8 + $10; if (e < 0) e = -e; if (FNR == NR) { if (e > slow) slow = e } else if (e > quick) quick = e }
  END { if (slow < 1e-5 && quick > 0.01) print "ok - contact and support force differ by the inertia: " quick " N in a quick indentation, " slow " N in a slow one"
        else print "not ok - contact and support force differ by the inertia: " quick " N in a quick indentation, " slow " N in a slow one vs > 0.01, < 1e-5" }' \
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
  END { if (seen && e <= 1e-8 && nodes == 121) print "ok - the contact force of a displacement history without Maxwell branches is the load path'"'"'s, to " e
        else print "not ok - the contact force of a displacement history without Maxwell branches is the load path'"'"'s: " e ", " nodes + 0 " nodes vs 1e-8, 121" }' \
  "$work/push.csv" "$work/elastic.csv" | tee -a "$results"
awk -F, 'FNR == NR { if ($1 == "step") whole = $8; next } $1 == "step" { share = $8 / whole; if (n++ > 10 && share >= last) bad = 1; last = share }
  END { wanted = 1 - 0.45 * (1 - exp(-9 / 0.5)) - 0.365 * (1 - exp(-9 / 50))
        if (n == 17 && !bad && last > wanted - 0.02 && last < wanted + 0.02) print "ok - the force of a patch kept for 9 s decreases in every step, to " last " of the elastic force"
        else print "not ok - the force of a patch kept for 9 s decreases in every step to the Prony series'"'"' value: " n + 0 " steps, " last " vs about " wanted }' \
  "$work/elastic.csv" "$work/hold.csv" | tee -a "$results"
# With half the time step the difference is a quarter.
for parts in 6 12 24; do
  awk -v n=$parts 'BEGIN { for (k = 0; k <= n; ++k) { s = k / n; print 0.6 * s, 0.004 * sin(2 * s), -0.008 * s * (1.6 - s), 0 } }' > "$work/wander$parts.history"
  relax wander$parts $branches
done
awk -F, 'FNR == 1 { ++file } $1 == "step" { x[file] = $7; y[file] = $8 }
  END { a = sqrt((x[1] - x[2]) ^ 2 + (y[1] - y[2]) ^ 2); b = sqrt((x[2] - x[3]) ^ 2 + (y[2] - y[3]) ^ 2); rate = (b > 0) ? log(a / b) / log(2) : 0
        if (rate > 1.6 && rate < 2.4) printf "ok - the force of a displacement history converges with second order in the time step, measured %.2f\n", rate
        else printf "not ok - the force of a displacement history converges with second order in the time step: %.2f vs 2\n", rate }' \
  "$work/wander6.csv" "$work/wander12.csv" "$work/wander24.csv" | tee -a "$results"
# relative moduli of a region: those of the base material change nothing, others do
awk '/^\$Elements/ { inside = 1 } inside && $2 == 2 && $1 % 2 { $4 = 11 } { print }' "$work/10.msh" > "$work/speckled.msh"
more() { solve $1 speckled 0.01 1 0.05 0.1 0 -1 -formulation plane-strain -indenter patch -history "$work/hold.history" $branches $2; }
push="0.004 2 0.05 0.1 0 -1 -formulation plane-strain -indenter patch"
solve still speckled $push
solve shares speckled $push $branches -g1_11 0.1
same still shares 1e-12 "a load path without time is elastic, also if a region has relative moduli of its own"
more base; more same "-g1_11 0.45 -g2_11 0.365"; more other "-g1_11 0 -g2_11 0"
awk -F, 'FNR == 1 { ++file } $1 == "step" { for (j = 0; j < 2; ++j) f[file, $2, j] = $(7 + j); if (-$8 > m) m = -$8; last = $2 }
  END { for (n = 0; n <= last; ++n) for (j = 0; j < 2; ++j) { e = f[2, n, j] - f[1, n, j]; if (e < 0) e = -e; if (e > off) off = e }
        lasts = f[3, last, 1] / f[1, last, 1]
        if (last == 16 && m > 0 && off <= 1e-12 * m && lasts > 1.2) print "ok - a region with the relative moduli of the rest changes no force, to " off / m "; a region without relaxation increases the last force " lasts " times"
        else print "not ok - a region with the relative moduli of the rest changes no force: off by " off / m " vs 1e-12; a region without relaxation increases the last force: " lasts " vs > 1.2" }' \
  "$work/base.csv" "$work/same.csv" "$work/other.csv" | tee -a "$results"
printf '0 0 0 0\n0.5 0.05 -0.08 0\n' > "$work/leap.history"
relax leap $branches
leap=$?
refused leap $leap 1 "at 0.5 s; the contact (0.05, 0.1) m" "a displacement history that FE cannot solve is refused with its time and contact"
printf '0 0 0 0\n0.5 0 -0.001 0\n0.5 0 -0.002 0\n' > "$work/late.history"
relax late $branches
refused late $? 1 "line 3 of the history must be later" "a displacement history with two equal times is refused"
printf '0.1 0 0 0\n0.5 0 -0.001 0\n' > "$work/early.history"
relax early $branches
refused early $? 1 "must begin at time 0 and at rest" "a displacement history that does not begin at time 0 is refused"
relax nowhere $branches
refused nowhere $? 1 "cannot read a history" "a missing history file is refused"
relax hold -branches 2 -g1 0.6 -tau1 0.5 -g2 0.4 -tau2 50
refused hold $? 2 "sum to less than 1" "relative moduli whose sum is 1 are refused"
relax hold -branches 1 -g1 0.6 -tau1 -1
refused hold $? 2 "must be positive" "a Maxwell branch with a negative relaxation time is refused"
solve sheet 10 0.01 1 0.05 0.1 0 -1 $branches
refused sheet $? 2 "needs a solid, or -formulation plane-strain" "Maxwell branches in plane stress are refused"
fi

# ---- a tool that leaves the tissue and touches it again, at the same contact or at the second one
if group touch; then
touch() { # NAME MESH MORE: a tool follows $work/NAME.history, with contacts at (0.03, 0.1) and (0.07, 0.1)
  name=$1 cells=$2
  shift 2
  solve "$name" $cells 0.01 1 0.03 0.1 0 -1 -formulation plane-strain -second_x 0.07 -second_y 0.1 -history "$work/$name.history" "$@"
}
# With a relaxation time of 0.5 s: 8 mm in 0.2 s, kept for 0.8 s, away for 20 relaxation times; then the same again at
# the same contact, and then at the other.
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
        if (m > 0 && same <= 1e-6 * m) print "ok - after 20 relaxation times without contact the tool has the forces of its first indentation, to " same / m
        else print "not ok - after 20 relaxation times without contact the tool has the forces of its first indentation: " same " of " m " N vs 1e-6" }' "$work/again.csv" | tee -a "$results"
# an indentation of the second contact, and the same one as the first contact of another run
awk 'BEGIN { print 0, 0, 0, 0, 0; print 0.1, 0, 0, 0, 0; for (n = 1; n <= 8; ++n) print 0.1 + n / 40, 0.0005 * n, -0.001 * n, 0, 2 }' > "$work/other.history"
sed 's/ 2$/ 1/' "$work/other.history" > "$work/alone.history"
touch other 20 -indenter patch -branches 1 -g1 0.3 -tau1 0.5
solve alone 20 0.01 1 0.07 0.1 0 -1 -formulation plane-strain -indenter patch -history "$work/alone.history" -branches 1 -g1 0.3 -tau1 0.5
awk -F, 'FNR == NR { if ($1 == "step") for (j = 0; j < 2; ++j) f[$2, j] = $(7 + j); next } $1 == "step" { for (j = 0; j < 2; ++j) { d = $(7 + j) - f[$2, j]; e += d * d; m += f[$2, j] ^ 2 } ++n }
  END { if (n == 10 && m > 0 && e <= 1e-16 * m) print "ok - the second contact has the forces of a first contact at that place"
        else print "not ok - the second contact has the forces of a first contact at that place: " n + 0 " steps, relative square " e / (m + 1e-300) " vs 10, 1e-16" }' "$work/alone.csv" "$work/other.csv" | tee -a "$results"
# Patches that end between nodes: nodes moved to the ends of the second patch do not move those of the first.
printf '0 0 0 0 1\n0.1 0.002 -0.004 0 1\n' > "$work/pinned.history"
cp "$work/pinned.history" "$work/only.history"
for name in only pinned; do
  solve $name 20 0.01 1 0.043 0.1 0 -1 -formulation plane-strain -indenter patch -history "$work/$name.history" $([ $name = only ] || echo -second_x 0.056 -second_y 0.1)
done
awk -F, '$1 == "step" && $2 == 1 { f = sqrt($7 * $7 + $8 * $8); if (FNR == NR) only = f }
  END { e = f / (only + 1e-300) - 1; if (e < 0) e = -e
        if (f > 0 && e < 2e-3) print "ok - a second patch does not change the force of the first, to " e
        else print "not ok - a second patch does not change the force of the first: its force differs by " e " vs 2e-3" }' "$work/only.csv" "$work/pinned.csv" | tee -a "$results"
# Contact again within the imprint of a relaxing tissue: the node starts at its current place with almost no force, and
# moves from there to the prescribed displacement.
awk 'BEGIN { print 0, 0, 0, 0, 1; for (n = 1; n <= 8; ++n) print n / 40, 0.0002 * n, -0.0005 * n, 0, 1; print 2, 0.0016, -0.004, 0, 1; print 2.001, 0, 0, 0, 0; print 2.1, 0, 0, 1, 0
  print 2.1001, 0, 0, 1, 1; for (n = 1; n <= 4; ++n) print 2.1 + n / 40, 0, -0.001 * n, 0, 1 }' > "$work/imprint.history"
touch imprint 10 -indenter point -branches 2 -g1 0.45 -tau1 0.5 -g2 0.365 -tau2 50
awk -F, '$1 == "step" { n = $2; x[n] = $4; y[n] = $5; f[n] = sqrt($7 * $7 + $8 * $8) } $1 == "node" && $2 == 0.03 && $3 == 0.1 { u[n] = $4; v[n] = $5 }
  END { e = sqrt((x[12] - u[11]) ^ 2 + (y[12] - v[11]) ^ 2) / sqrt(u[11] ^ 2 + v[11] ^ 2 + 1e-300)
        half = sqrt((x[14] - u[11] / 2) ^ 2 + (y[14] + 0.002 - v[11] / 2) ^ 2) / 0.002
        if (v[11] < -2e-4 && v[11] > -3e-3 && u[11] > 1e-5 && e < 1e-9 && f[12] < 1e-3 * f[9] && half < 1e-9 && x[16] == 0 && y[16] == -0.004 && f[16] > f[12])
          print "ok - a tool that touches its imprint again starts from the imprint, " 1e3 * v[11] " mm deep, almost without force"
        else print "not ok - a tool that touches its imprint again starts from the imprint, almost without force: (" u[11] ", " v[11] ") m, off by " e ", " f[12] " of " f[9] " N, halfway off by " half ", ends at (" x[16] ", " y[16] ")" }' \
  "$work/imprint.csv" | tee -a "$results"
# release of a deep indentation, from which Newton's method alone converges to another state
awk 'BEGIN { for (n = 0; n <= 15; ++n) print n / 100, 0, -n / 1000, 0, 1; print 0.151, 0, 0, 1, 0; print 0.152, 0, 0, 0, 0 }' > "$work/deep.history"
touch deep 10 -indenter patch
awk -F, '$1 == "step" { n = $2; if (n == 15) held = -$8; if (n > 15 && ($8 != 0 || $10 > 1e-9 * held || -$10 > 1e-9 * held)) off = 1 } $1 == "node" { ++nodes; for (i = 4; i <= 5; ++i) if ($i > 1e-9 || $i < -1e-9) ++moved }
  END { if (n == 17 && nodes == 121 && !moved && !off) print "ok - elastic tissue that is released from 15 mm in one step is at rest"
        else print "not ok - elastic tissue that is released from 15 mm in one step is at rest: " n + 0 " steps, " moved + 0 " of " nodes + 0 " nodes moved, forces off " off + 0 }' "$work/deep.csv" | tee -a "$results"
printf '0 0 0 0 1\n0.1 0 -0.001 0 1\n0.2 0 -0.001 0 2\n' > "$work/jump.history"
touch jump 10 -indenter patch
refused jump $? 1 "line 3 of the history changes to another contact; the tool must be away" "a change of contact without leaving the tissue is refused"
printf '0 0 0 0 1\n0.1 0 -0.001 0 3\n' > "$work/third.history"
touch third 10 -indenter patch
refused third $? 1 "line 2 of the history has the contact 3, which does not exist" "a contact number without a contact is refused"
printf '0 0 0 0\n0.1 0 -0.001 0 1\n' > "$work/uneven.history"
touch uneven 10 -indenter patch
refused uneven $? 1 "line 2 of the history must have as many numbers as the first" "history lines with different numbers of fields are refused"
printf '0 0 0\n0.1 0 0\n' > "$work/narrow.history"
touch narrow 10 -indenter patch
refused narrow $? 1 "a line of the history has 3 numbers, not 4, or 5 with the contact" "history lines with too few numbers are refused"
solve bare 10 0.01 1 0.03 0.1 0 -1 -formulation plane-strain -indenter patch -second_x 0.07 -second_y 0.1
refused bare $? 2 "a second contact .* needs a -history" "a second contact without a displacement history is refused"
cp "$work/deep.history" "$work/low.history"
solve low 10 0.01 1 0.03 0.1 0 -1 -formulation plane-strain -indenter patch -second_x 0 -second_y 0.012 -history "$work/low.history"
refused low $? 1 "the contact (0, 0.012) m is 12 mm along the surface from the fixed edge" "a second patch too near to the fixed edge is refused"
fi

# ---- refusals
if group refusals; then
solve fold 10 0.015 30 0 0.1 0 -1 -formulation plane-strain
refused fold $? 1 "refused between .* mm of tool displacement.*surface crosses itself.*mm" "a self-intersecting indentation of a corner is refused with its place and load"
solve near 10 0.005 5 0 0.012 1 0 -indenter patch
refused near $? 1 "12 mm along the surface from the fixed edge" "a patch nearer than 15 mm to the fixed edge is refused"
solve narrow 40 0.002 1 0 0.0085 1 0 -indenter patch -patch_half_width 0.003
refused narrow $? 1 "8.5 mm along the surface from the fixed edge; a patch needs 9 mm" "a narrower patch nearer than three half-widths to the fixed edge is refused"
if solve small 40 0.002 1 0 0.009 1 0 -indenter patch -patch_half_width 0.003 && grep -q '^end' "$work/small.csv"
then say "ok - a narrower patch at three half-widths from the fixed edge is solved"
else say "not ok - a narrower patch at three half-widths from the fixed edge is solved: $(head -c 200 "$work/small.err") vs an end line"; fi
solve inside 10 0.005 5 0.03 0.05 1 0 -indenter patch
refused inside $? 1 "not on the free surface" "a contact off the surface is refused"
solve between 10 0.005 5 0 0.053 1 0
refused between $? 1 "no FE node at the contact" "a point contact between nodes is refused"
solve word 10 0.005 5 0 0.05 1 0 -formulation plane
refused word $? 2 "plane-stress or plane-strain" "an unknown formulation is refused"
solve misspelt 10 0.005 5 0 0.05 1 0 -formulatoin plane-strain
refused misspelt $? 2 "argument -formulatoin is not known" "a misspelt argument is refused"
solve far 10 0.005 5 0 0.05 1 0 -C1_99 500
refused far $? 2 "argument -C1_99 is not known" "parameters of a region that is not in the mesh are refused"
solve odd 10 0.005 5 0 0.05 1 0 -indenter
refused odd $? 2 "argument -indenter has no value" "an argument without a value is refused"
solve other 10 0.005 5 0 0.05 1 0 -disc_radius 0.007
refused other $? 2 "argument -disc_radius is not known" "an argument of a load path in space is refused in the plane"
for word in abc 2e 0x10 1,5 3mm nan 1e999; do
  solve number 40 0.002 1 0 0.012 1 0 -indenter patch -patch_half_width "$word"
  refused number $? 2 "argument -patch_half_width must be a number, got $word" "'$word' as a number is refused"
done
if solve number 40 0.002 1 0 0.012 1 0 -indenter patch -patch_half_width +.3E-2 && grep -q '^end' "$work/number.csv"
then say "ok - a number with a power of ten is accepted"
else say "not ok - a number with a power of ten is accepted: $(head -c 200 "$work/number.err") vs an end line"; fi
for word in 1.5 one 1e0 99999999999; do
  solve whole 10 0.005 5 0 0.05 1 0 -branches "$word"
  refused whole $? 2 "argument -branches must be a whole number, got $word" "'$word' as a whole number is refused"
done
head -c 3000 "$work/10.msh" > "$work/broken.msh"
solve broken broken 0.005 5 0 0.05 1 0
refused broken $? 1 "cannot read a whole mesh" "a truncated mesh file is refused"
sed 's/^\([0-9]* 1 2\) 1 /\1 9 /' "$work/10.msh" > "$work/unnamed.msh"
solve unnamed unnamed 0.005 5 0 0.05 1 0
refused unnamed $? 1 "has 0 of 21 nodes" "a mesh without the named bottom is refused"
solve long 10 0.005 5 0 0.05 1 1
refused long $? 2 "unit vector" "a direction that is not a unit vector is refused"
fi

finish
