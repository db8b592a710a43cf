#!/bin/sh
# What make builds anew, and what it leaves: flags, sources that come and go, the page; and two makes at once in one
# clone. The copy's sources are a few lines each, around the real program, so that compiling costs nothing.
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

# ---- two makes at once, with nothing built
cat >"$scratch/slow" <<'SH'
#!/bin/sh
# slow COMMAND...: takes its time, and says so when another one is at the same output
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
both() { # STUDY STUDY: two makes at once; exit statuses in $one and $two
    PATH="$scratch/bin:$PATH" make PYTHON="$PYTHON" STUDY="$1" all -j2 >"$scratch/one.said" 2>&1 </dev/null &
    PATH="$scratch/bin:$PATH" make PYTHON="$PYTHON" STUDY="$2" all -j2 >"$scratch/two.said" 2>&1 </dev/null
    two=$?
    wait $!
    one=$?
}
both_well() { [ "$one $two" = "0 0" ] || { echo "exit statuses $one $two"; cat "$scratch/one.said" "$scratch/two.said"; return 1; }; }
unmixed() { [ ! -e "$scratch/mixed" ] || { sort "$scratch/mixed" | uniq -c; return 1; }; }
both tiny other
check "two makes of two studies at once, with nothing built: both succeed" both_well
check "two makes of two studies at once: no two writers of one file" unmixed
check "two makes of two studies at once: nothing half-written is left" no_half_files "$work"
make_tiny all -q
check "two makes of two studies at once: nothing is left to do" exited 0
cp -pR "$R" "$scratch/first"
rm -rf "$R" results/other
both tiny tiny
check "two makes of one study at once: both succeed" both_well
check "two makes of one study at once: no two writers of one file" unmixed
check "two makes of one study at once: the contents are those of one make" same_contents "$R" "$scratch/first"
check "two makes of one study at once: nothing half-written is left" no_half_files "$work"

# ---- only what a stage uses is its prerequisite
make_tiny all
make_tiny all -q
check "a second make all has nothing to do" exited 0
snapshot "$R" >"$scratch/before"
cp -p $program "$scratch/program"
again() { # SENTENCE RESULTS COMPILED: make after an edit
    make_tiny eval
    check "$1: exit 0" exited 0
    check "$1: compiles what was edited" compiled_are "$3"
    check "$1: makes anew what uses it, and no more" only_changed "$scratch/before" "$R" "$2"
    make_tiny eval -q
    check "$1: once" exited 0
    snapshot "$R" >"$scratch/before"
}
echo '#page { color: blue }' >cli/view/page.css
again "an edit of the page" "plan.mk" cli/serve/page.cpp
check "an edit of the page is in the program" sh -c '! cmp -s "$0" "$1"' $program "$scratch/program"
echo 'extern const char page[]; int serve() { return page[1]; }' >cli/serve/server.cpp
again "an edit of the page's server" "plan.mk" cli/serve/server.cpp
echo 'int tick() { return 7; }' >lib/haptic/tick.cpp
again "an edit of the tick" "plan.mk" lib/haptic/tick.cpp
sed -i '1s|^|// the same, said better\n|' lib/train/train.cpp
again "a comment in the training" "plan.mk" lib/train/train.cpp
echo 'int file(); int train() { return file() + 8; }' >lib/train/train.cpp
again "an edit of the training" "eval.json model.h5 plan.mk report.md" lib/train/train.cpp
echo 'int shared() { return 9; }' >cli/command.cpp
again "an edit of what commands share" "eval.json model.h5 plan.mk report.md" cli/command.cpp
echo 'int file(); int collect() { return file() + 10; }' >lib/train/collect.cpp
again "an edit of the collecting" "cases.h5 eval.json model.h5 plan.mk report.md" lib/train/collect.cpp
echo 'int file(); int add_eval() { return file() + 11; }' >cli/cmd_eval.cpp
again "an edit of the evaluation" "eval.json plan.mk report.md" cli/cmd_eval.cpp

# ---- sources that come and go
rm lib/train/old.cpp
run make build/release/libtissue.a
check "a source that is deleted leaves the archive, and the others stay" \
    test "$(ar t build/release/libtissue.a | sort | tr '\n' ' ')" = "collect.o file.o tick.o train.o "
echo 'int fresh() { return 1; }' >lib/train/fresh.cpp
run make build/release/libtissue.a
check "a new one is compiled, and it alone" compiled_are lib/train/fresh.cpp
check "it is in the archive" sh -c 'ar t build/release/libtissue.a | grep -qx fresh.o'
echo 'struct Greeting { Greeting(); }; Greeting::Greeting() {} Greeting greeting;' >cli/greeting.cpp
run make $program
rm cli/greeting.cpp
run make -q $program
check "a deleted file of the program itself: there is something to do" exited 1
run make $program
check "a deleted file of the program itself: the program is linked without it" sh -c '! nm -C "$0" | grep -q Greeting' $program
run make -q $program
check "and then there is nothing to do" exited 0

# ---- flags
run make -q $program CXX='ccache g++'
check "through ccache or not is the same program" exited 0
all=$(find lib cli -name '*.cpp' | wc -l)
sed -i 's/^\(CXXFLAGS.*\)-O3/\1-O2/' Makefile
run make -n $program
check "other flags: every object is to be compiled anew" test "$(grep -c '^echo "c++' "$said")" = "$all"
run make $program
check "other flags: so it is" test "$(grep -c '^c++' "$said")" = "$all"
run make -q $program
check "other flags: once" exited 0
sed -i 's/^\(PACKAGES.*\) gsl/\1/' Makefile
run make -q $program
check "another library: there is something to do" exited 1

# ---- the programs under test themselves: what a broken stack or buffer meets
hardened() { # FILE: resolved at its start, stack and buffers guarded, at no fixed address
    readelf -dW "$1" | grep -q 'FLAGS.*NOW' || { echo "$1: symbols are bound late"; return 1; }
    readelf -hW "$1" | grep -q 'Type: *DYN' || { echo "$1: stands at a fixed address"; return 1; }
    readelf -lW "$1" | grep -q 'GNU_RELRO' || { echo "$1: its tables stay writable"; return 1; }
    readelf -W --dyn-syms "$1" | grep -q '__stack_chk_fail' || { echo "$1: no stack protector"; return 1; }
    readelf -W --dyn-syms "$1" | grep -q '_chk@' || { echo "$1: no _FORTIFY_SOURCE"; return 1; }
}
for file in tissuectl tissue-haptic libtissue.so.1 python/tissue.so; do
    built=$(dirname "$TISSUECTL")/$file
    if [ -e "$built" ]; then check "$file is built with stack protector, FORTIFY, RELRO and BIND_NOW" hardened "$built"; fi
done
finish
