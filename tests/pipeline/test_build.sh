#!/bin/sh
# What make rebuilds after a change of flags, sources or the page; and two simultaneous makes in one clone. The copy's
# sources are a few lines each, around the real program, so compilation is fast.
. "$(dirname "$0")/common"
make_copy
export REAL_TISSUECTL="$TISSUECTL"
cd "$work" || exit 1
rm -r "$work"/build/release/*
mkdir -p lib/io lib/train lib/haptic cli/serve cli/view
echo 'int file() { return 1; }' >lib/io/file.cpp
echo 'int file(); int train() { return file() + 1; }' >lib/train/train.cpp
echo 'int file(); int collect() { return file() + 2; }' >lib/train/collect.cpp
echo 'int old() { return 4; }' >lib/train/old.cpp
echo 'int tick() { return 5; }' >lib/haptic/tick.cpp
echo '#page { color: black }' >cli/view/page.css
printf '%s\n' '__asm__(".section .rodata\n.globl page\npage: .incbin \"cli/view/page.css\"\n.previous\n");' >cli/serve/page.cpp
echo 'extern const char page[]; int serve() { return page[0]; }' >cli/serve/server.cpp
for command in plan shape rim import eval; do echo "int file(); int add_$command() { return file(); }" >cli/cmd_$command.cpp; done
echo 'int train(); int shared(); int add_train() { return train() + shared(); }' >cli/cmd_train.cpp
echo 'int collect(); int add_collect() { return collect(); }' >cli/cmd_collect.cpp
echo 'int serve(); int tick(); int add_serve() { return serve() + tick(); }' >cli/cmd_serve.cpp
echo 'int shared() { return 6; }' >cli/command.cpp
cat >cli/tissuectl.cpp <<'CPP'
#include <cstdlib>
#include <unistd.h>
int add_plan(), add_shape(), add_rim(), add_import(), add_collect(), add_train(), add_eval(), add_serve();
int main(int, char** argv) {
    if (add_plan() + add_shape() + add_rim() + add_import() + add_collect() + add_train() + add_eval() + add_serve() == 0) return 1;
    return execv(std::getenv("REAL_TISSUECTL"), argv);
}
CPP
names() { grep '^c++' "$said" | sed 's/^c++ *//' | sort | tr '\n' ' ' | sed 's/ $//'; }
compiled_are() { [ "$(names)" = "$1" ] || { cat "$said"; return 1; }; }
program=build/release/tissuectl

# ---- two simultaneous makes, before anything is built
cat >"$scratch/slow" <<'SH'
#!/bin/sh
# slow COMMAND...: runs the command slowly, and notes an output that another command is writing at the same time
out= last=
for word; do
    case $last in -o | -out) out=$word ;; esac
    last=$word
done
[ -n "$out" ] || exec "$@"
mkdir "$out.busy" 2>/dev/null || echo "$out" >>"${0%/*}/mixed"
sleep 0.1
"$@"
status=$?
sleep 0.1
rmdir "$out.busy" 2>/dev/null
exit $status
SH
mkdir "$scratch/bin"
for tool in FreeFem++-nw g++; do
    printf '#!/bin/sh\nexec "%s/slow" %s "$@"\n' "$scratch" "$(command -v $tool)" >"$scratch/bin/$tool"
done
chmod +x "$scratch/slow" "$scratch/bin/FreeFem++-nw" "$scratch/bin/g++"
sed 's/seed = 2008/seed = 2009/' fem/studies/tiny.toml >fem/studies/other.toml
both() { # STUDY STUDY: two simultaneous makes; exit statuses in $one and $two
    PATH="$scratch/bin:$PATH" make PYTHON="$PYTHON" STUDY="$1" all -j2 >"$scratch/one.said" 2>&1 </dev/null &
    PATH="$scratch/bin:$PATH" make PYTHON="$PYTHON" STUDY="$2" all -j2 >"$scratch/two.said" 2>&1 </dev/null
    two=$?
    wait $!
    one=$?
}
both_well() { [ "$one $two" = "0 0" ] || { echo "exit statuses $one $two"; cat "$scratch/one.said" "$scratch/two.said"; return 1; }; }
unmixed() { [ ! -e "$scratch/mixed" ] || { sort "$scratch/mixed" | uniq -c; return 1; }; }
both tiny other
check "simultaneous makes of two studies, before anything is built: both succeed" both_well
check "simultaneous makes of two studies: no file has two writers at once" unmixed
check "simultaneous makes of two studies: no incomplete file is left" no_half_files "$work"
make_tiny all -q
check "simultaneous makes of two studies: make all is up to date" exited 0
cp -pR "$R" "$scratch/first"
rm -rf "$R" results/other
both tiny tiny
check "simultaneous makes of one study: both succeed" both_well
check "simultaneous makes of one study: no file has two writers at once" unmixed
check "simultaneous makes of one study: the results are those of one make" same_contents "$R" "$scratch/first"
check "simultaneous makes of one study: no incomplete file is left" no_half_files "$work"

# ---- the prerequisites of a stage are only the sources that it uses
make_tiny all
make_tiny all -q
check "make all is up to date after make all" exited 0
snapshot "$R" >"$scratch/before"
cp -p $program "$scratch/program"
again() { # SENTENCE RESULTS COMPILED: make eval after an edit
    make_tiny eval
    check "$1: exit 0" exited 0
    check "$1: only the edited file is compiled" compiled_are "$3"
    check "$1: only results that depend on it are made again" only_changed "$scratch/before" "$R" "$2"
    make_tiny eval -q
    check "$1: make eval is then up to date" exited 0
    snapshot "$R" >"$scratch/before"
}
echo '#page { color: blue }' >cli/view/page.css
again "an edit of the page" "plan.mk" cli/serve/page.cpp
check "an edit of the page changes the program" sh -c '! cmp -s "$0" "$1"' $program "$scratch/program"
echo 'extern const char page[]; int serve() { return page[1]; }' >cli/serve/server.cpp
again "an edit of the page's server" "plan.mk" cli/serve/server.cpp
echo 'int tick() { return 7; }' >lib/haptic/tick.cpp
again "an edit of the haptic tick" "plan.mk" lib/haptic/tick.cpp
sed -i '1s|^|// the same, said better\n|' lib/train/train.cpp
again "a comment in the training" "plan.mk" lib/train/train.cpp
echo 'int file(); int train() { return file() + 8; }' >lib/train/train.cpp
again "an edit of the training" "eval.json model.h5 plan.mk report.md" lib/train/train.cpp
echo 'int shared() { return 9; }' >cli/command.cpp
again "an edit of code that all commands use" "eval.json model.h5 plan.mk report.md" cli/command.cpp
echo 'int file(); int collect() { return file() + 10; }' >lib/train/collect.cpp
again "an edit of collect" "cases.h5 eval.json model.h5 plan.mk report.md" lib/train/collect.cpp
echo 'int file(); int add_eval() { return file() + 11; }' >cli/cmd_eval.cpp
again "an edit of the evaluation" "eval.json plan.mk report.md" cli/cmd_eval.cpp

# ---- sources that are added and deleted
rm lib/train/old.cpp
run make build/release/libtissue.a
check "a deleted source is removed from the archive, and no other" \
    test "$(ar t build/release/libtissue.a | sort | tr '\n' ' ')" = "collect.o file.o tick.o train.o "
echo 'int fresh() { return 1; }' >lib/train/fresh.cpp
run make build/release/libtissue.a
check "a new source is compiled, and no other" compiled_are lib/train/fresh.cpp
check "a new source is in the archive" sh -c 'ar t build/release/libtissue.a | grep -qx fresh.o'
echo 'struct Greeting { Greeting(); }; Greeting::Greeting() {} Greeting greeting;' >cli/greeting.cpp
run make $program
rm cli/greeting.cpp
run make -q $program
check "a deleted source of the program: make has work to do" exited 1
run make $program
check "a deleted source of the program: the program is linked without it" sh -c '! nm -C "$0" | grep -q Greeting' $program
run make -q $program
check "a deleted source of the program: make is then up to date" exited 0

# ---- flags
run make -q $program CXX='ccache g++'
check "a program built without ccache is up to date with ccache" exited 0
all=$(find lib cli -name '*.cpp' | wc -l)
sed -i 's/^\(CXXFLAGS.*\)-O3/\1-O2/' Makefile
run make -n $program
check "other flags: make -n compiles every object" test "$(grep -c '^echo "c++' "$said")" = "$all"
run make $program
check "other flags: make compiles every object" test "$(grep -c '^c++' "$said")" = "$all"
run make -q $program
check "other flags: make is then up to date" exited 0
sed -i 's/^\(PACKAGES.*\) gsl/\1/' Makefile
run make -q $program
check "another list of libraries: make has work to do" exited 1

# ---- hardening of the programs under test
hardened() { # FILE: BIND_NOW, position independent, RELRO, stack protector, _FORTIFY_SOURCE
    readelf -dW "$1" | grep -q 'FLAGS.*NOW' || { echo "$1: symbols are bound late"; return 1; }
    readelf -hW "$1" | grep -q 'Type: *DYN' || { echo "$1: is not position independent"; return 1; }
    readelf -lW "$1" | grep -q 'GNU_RELRO' || { echo "$1: no RELRO"; return 1; }
    readelf -W --dyn-syms "$1" | grep -q '__stack_chk_fail' || { echo "$1: no stack protector"; return 1; }
    readelf -W --dyn-syms "$1" | grep -q '_chk@' || { echo "$1: no _FORTIFY_SOURCE"; return 1; }
}
for file in tissuectl tissue-haptic libtissue.so.1 python/tissue.so; do
    built=$(dirname "$TISSUECTL")/$file
    if [ -e "$built" ]; then check "$file is built with stack protector, FORTIFY, RELRO and BIND_NOW" hardened "$built"; fi
done
finish
