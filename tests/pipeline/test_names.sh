#!/bin/sh
# Names that make or the shell would split or execute are refused with one line, and nothing in a study is executed. The
# folder of the copy has a blank in its name, as in every pipeline test.
. "$(dirname "$0")/common"
make_copy
cp -p "$work/fem/studies/tiny.toml" "$scratch/good.toml"
study=fem/studies/tiny.toml
not_run() { [ -z "$(find "$scratch" -name 'pwned*')" ] || { find "$scratch" -name 'pwned*' -print -delete; return 1; }; }
newline='
'
refused() { # SENTENCE LINE-PATTERN: the last command was refused
    check "$1: refused" failed
    check "$1: one line states the cause" one_line "$2"
    check "$1: nothing is executed" not_run
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
refused "a missing study" '^tissuectl: fem/studies/nowhere.toml: there is no such study'

# ---- files that make finds by a pattern
for name in 'fem/studies/Copy of tiny.toml' 'fem/studies/a;touch pwned .toml' 'fem/studies/$(shell touch pwned).toml' \
    'fem/materials/`touch pwned`.toml' "fem/studies/it's.toml" "fem/studies/a${newline}b.toml" 'fem/a;touch pwned #.idp' \
    'scripts/figures/a: b.py'; do
    cp "$scratch/good.toml" "$work/$name"
    make_tiny eval
    refused "a file '$(echo "$name" | tr '\n' ' ')'" '^Makefile:[0-9]*: \*\*\* .*make cannot carry it'
    rm "$work/$name"
done

# ---- keys of a study: refused by make and by the program
hostile() { # SENTENCE LINE-PATTERN: the current study is refused
    make_tiny eval
    refused "$1" "$2"
    tissuectl plan --study $study --out results/tiny/plan.mk
    refused "$1, planned without make" "$2"
    cp "$scratch/good.toml" "$work/$study"
}
# shape FILE VALUE: makes the study one of an outline in this file, with this value of its key `shape`
shape() {
    cp "$root/fem/organ.geo" "$work/fem/$1"
    awk -v line="shape = $(printf '%s' "$2" | sed 's/\\/&&/g')" '/^shape = / { $0 = line } { print }' "$root/fem/studies/organ.toml" >"$work/$study"
}
for name in 'a b' '$(shell touch pwned)' 'x;touch pwned ' "x'y" 'x"y' 'x`touch pwned`' 'x&touch pwned' 'x:y' 'x%'; do
    shape "$name.geo" "'''../$name.geo'''"
    hostile "a shape in '$name.geo'" "^tissuectl: $study: key 'geometry.shape': .*make does not support this name"
    rm "$work/fem/$name.geo"
done
shape "a${newline}touch pwned.geo" '"../a\ntouch pwned.geo"'
hostile "a shape with a line break in its name" "key 'geometry.shape': .*a.x0atouch pwned.geo'.*make does not support"
rm "$work/fem/a${newline}touch pwned.geo"
for name in 'x;touch pwned' '$(shell touch pwned)' "x'y" 'a b'; do
    cp "$root/fem/data/block_measured.csv" "$work/fem/data/$name.csv"
    sed "s|block_measured|$name|" "$root/fem/studies/measured.toml" >"$work/$study"
    hostile "data in '$name.csv'" "^tissuectl: $study: key 'data.file': .*make does not support this name"
    rm "$work/fem/data/$name.csv"
done
for name in '$(shell touch pwned)' '`touch pwned`' 'x;touch pwned' 'a b' "x'y" '../x' 'x\\ny' 'x\\n$(shell touch pwned)'; do
    sed -i "s|name = \"left\"|name = \"$name\"|" "$work/$study"
    hostile "a load path '$name'" "$study:14: key 'loads.paths\[0\].name': must have only lower-case letters, digits and '-'"
done
hostile_key() { # SENTENCE LINE-PATTERN TOML
    printf '%s\n' "$3" >>"$work/$study"
    hostile "$1" "$2"
}
hostile_key "a formulation with a command" "key 'material.formulation': '.(shell touch pwned)' is not allowed" '[material]
formulation = "$(shell touch pwned)"'
hostile_key "an indenter with a command" "key 'indenter.kind': " '[indenter]
kind = "point;touch pwned"'
hostile_key "a key with a line break" "key 'springs.a.x0ab': is not known" '[springs]
"a\nb" = 1'
hostile_key "a preset with a command" "key 'material.preset': must be the name of a file" '[material]
preset = "$(shell touch pwned)"'
hostile_key "a command as a number" "key 'geometry.thickness_m': must be a number" '[geometry]
thickness_m = "$(shell touch pwned)"'
sed -i '1s/.*/based_on = "x\\n$(shell touch pwned)"/' "$work/$study"
hostile "a base study with a command" 'x.x0a$(shell touch pwned).toml: there is no such study'

# a study's file with a command in its name
mkdir "$scratch/else where"
cp "$work/fem/studies/paper.toml" "$scratch/else where/\$(shell touch pwned).toml"
tissuectl plan --study "$scratch/else where/\$(shell touch pwned).toml" --out results/tiny/plan.mk
refused "a study's file with a command in its name" 'its name: .*make does not support'

# ---- make clean
mkdir -p "$work/results/reference" "$work/results/a;touch pwned" "$work/results/x fem" "$work/build"
touch "$work/build/kept"
cp -pR "$work/build" "$scratch/build"
run make clean
check "make clean removes build and all results but the reference, whatever their names" sh -c 'cd "$1" && [ "$(ls results)" = reference ] && [ ! -e build ]' - "$work"
check "make clean keeps study and Makefile" exist "$work/fem/studies/tiny.toml" "$work/Makefile"
check "make clean executes nothing" not_run
mv "$scratch/build" "$work/build"

make_tiny results/tiny/cases/left.csv
check "a load path of the restored study is solved" exited 0
finish
