#!/bin/sh
# Names that make or the shell would take apart, or run: refused with one line, and nothing in a study is ever executed.
# The copy's own folder has a blank in its name, as in every pipeline test.
. "$(dirname "$0")/common"
make_copy
cp -p "$work/fem/studies/tiny.toml" "$scratch/good.toml"
study=fem/studies/tiny.toml
not_run() { [ -z "$(find "$scratch" -name 'pwned*')" ] || { find "$scratch" -name 'pwned*' -print -delete; return 1; }; }
newline='
'
refused() { # SENTENCE LINE-PATTERN: the last command
    check "$1: refused" failed
    check "$1: one line says so" one_line "$2"
    check "$1: nothing was run" not_run
}

# ---- STUDY, on the command line and in the environment
for name in 'x;touch pwned' '$(shell touch pwned)' '`touch pwned`' '$$(touch pwned)' 'a b' "it's" '"x"' '../tiny' -n .. 'x|touch pwned' \
    "tiny${newline}touch pwned" "tiny${newline}\$(shell touch pwned)" 'tiny#' 'tiny:' 'ti%y' ''; do
    run make PYTHON="$PYTHON" STUDY="$name" eval
    refused "STUDY='$(echo "$name" | tr '\n' ' ')'" '^Makefile:[0-9]*: \*\*\* STUDY='
done
STUDY='$(shell touch pwned)' run make PYTHON="$PYTHON" eval
refused "STUDY from the environment" '^Makefile:[0-9]*: \*\*\* STUDY='
run make STUDY=tiny R='results/a b;touch pwned' eval
refused "a results folder with a blank" '^Makefile:[0-9]*: \*\*\* R='
run make STUDY=nowhere eval
refused "a study that is not there" '^tissuectl: fem/studies/nowhere.toml: there is no such study'

# ---- files that make looks for by a pattern
for name in 'fem/studies/Copy of tiny.toml' 'fem/studies/a;touch pwned .toml' 'fem/studies/$(shell touch pwned).toml' \
    'fem/materials/`touch pwned`.toml' "fem/studies/it's.toml" "fem/studies/a${newline}b.toml" 'fem/a;touch pwned #.idp' \
    'scripts/figures/a: b.py'; do
    cp "$scratch/good.toml" "$work/$name"
    make_tiny eval
    refused "a file '$(echo "$name" | tr '\n' ' ')'" '^Makefile:[0-9]*: \*\*\* .*make cannot carry it'
    rm "$work/$name"
done

# ---- keys of a study: by make, and by the program alone
hostile() { # SENTENCE LINE-PATTERN: the study as it is now
    make_tiny eval
    refused "$1" "$2"
    tissuectl plan --study $study --out results/tiny/plan.mk
    refused "$1, planned by hand" "$2"
    cp "$scratch/good.toml" "$work/$study"
}
# shape FILE: the study as one of an outline, in a file of this name
shape() {
    cp "$root/fem/organ.geo" "$work/fem/$1"
    awk -v line="shape = $(printf '%s' "$2" | sed 's/\\/&&/g')" '/^shape = / { $0 = line } { print }' "$root/fem/studies/organ.toml" >"$work/$study"
}
for name in 'a b' '$(shell touch pwned)' 'x;touch pwned ' "x'y" 'x"y' 'x`touch pwned`' 'x&touch pwned' 'x:y' 'x%'; do
    shape "$name.geo" "'''../$name.geo'''"
    hostile "a shape in '$name.geo'" "^tissuectl: $study: key 'geometry.shape': .*make cannot carry this name"
    rm "$work/fem/$name.geo"
done
shape "a${newline}touch pwned.geo" '"../a\ntouch pwned.geo"'
hostile "a shape with a line break in its name" "key 'geometry.shape': .*a.x0atouch pwned.geo'.*make cannot carry"
rm "$work/fem/a${newline}touch pwned.geo"
for name in 'x;touch pwned' '$(shell touch pwned)' "x'y" 'a b'; do
    cp "$root/fem/data/block_measured.csv" "$work/fem/data/$name.csv"
    sed "s|block_measured|$name|" "$root/fem/studies/measured.toml" >"$work/$study"
    hostile "data in '$name.csv'" "^tissuectl: $study: key 'data.file': .*make cannot carry this name"
    rm "$work/fem/data/$name.csv"
done
for name in '$(shell touch pwned)' '`touch pwned`' 'x;touch pwned' 'a b' "x'y" '../x' 'x\\ny' 'x\\n$(shell touch pwned)'; do
    sed -i "s|name = \"left\"|name = \"$name\"|" "$work/$study"
    hostile "a load path '$name'" "$study:14: key 'loads.paths\[0\].name': must be of lower-case letters, digits and '-'"
done
hostile_key() { # SENTENCE LINE-PATTERN TOML
    printf '%s\n' "$3" >>"$work/$study"
    hostile "$1" "$2"
}
hostile_key "a formulation to run" "key 'material.formulation': '.(shell touch pwned)' is not allowed" '[material]
formulation = "$(shell touch pwned)"'
hostile_key "an indenter to run" "key 'indenter.kind': " '[indenter]
kind = "point;touch pwned"'
hostile_key "a key with a line break" "key 'springs.a.x0ab': is not known" '[springs]
"a\nb" = 1'
hostile_key "a preset to run" "key 'material.preset': must be the name of a file" '[material]
preset = "$(shell touch pwned)"'
hostile_key "a number to run" "key 'geometry.thickness_m': must be a number" '[geometry]
thickness_m = "$(shell touch pwned)"'
sed -i '1s/.*/based_on = "x\\n$(shell touch pwned)"/' "$work/$study"
hostile "a base study to run" 'x.x0a$(shell touch pwned).toml: there is no such study'

# a study file is what the program makes it, whatever its name
mkdir "$scratch/else where"
cp "$work/fem/studies/paper.toml" "$scratch/else where/\$(shell touch pwned).toml"
tissuectl plan --study "$scratch/else where/\$(shell touch pwned).toml" --out results/tiny/plan.mk
refused "a study's file by a name to run" 'its name: .*make cannot carry'

# ---- make clean
mkdir -p "$work/results/reference" "$work/results/a;touch pwned" "$work/results/x fem" "$work/build"
touch "$work/build/kept"
cp -pR "$work/build" "$scratch/build"
run make clean
check "make clean takes away results by whatever name, and runs none" sh -c 'cd "$1" && [ "$(ls results)" = reference ] && [ ! -e build ]' - "$work"
check "make clean: nothing else is gone" exist "$work/fem/studies/tiny.toml" "$work/Makefile"
check "make clean: nothing was run" not_run
mv "$scratch/build" "$work/build"

make_tiny results/tiny/cases/left.csv
check "and the study that all this was done to is solved" exited 0
finish
