#!/bin/sh
# make install and uninstall: the installed library and programs, and removal without leftovers.
. "$(dirname "$0")/common"
prefix=$scratch/prefix
build=$(dirname "$TISSUECTL")
# the flags that make passes to scripts/install
flags=$(make -n -C "$root" install 2>/dev/null | sed -n "s/.* CXXFLAGS='\([^']*\)' scripts.install.*/\1/p")
place() { # WHAT VARIABLE=VALUE...: calls scripts/install as make does, without building anything
    what=$1
    shift
    run env "$@" PACKAGES="$(sed -n 's/^PACKAGES := //p' "$root/Makefile")" CXXFLAGS="$flags" "$root/scripts/install" "$what"
}
work=$scratch
before=$(umask)
umask 077  # the umask of root on many machines
place "$build" PREFIX="$prefix"
umask "$before"
check "install: exit 0" exited 0
check "install prints nothing" silent
check "installed files are readable by all users, independent of the umask" test -z "$(find "$prefix" ! -perm -o+r -o -type d ! -perm -o+x)"
check "programs, library, headers, pkg-config files, manual pages and completions are installed" exist "$prefix/bin/tissuectl" \
    "$prefix/bin/tissue-haptic" "$prefix/lib/libtissue.a" "$prefix/include/tissue/haptic/device.h" \
    "$prefix/lib/libtissue.so.1" "$prefix/lib/libtissue.so" "$prefix/include/tissue.h" "$prefix/lib/pkgconfig/tissue-c.pc" \
    "$prefix/lib/pkgconfig/tissue.pc" "$prefix/share/man/man1/tissuectl.1" "$prefix/share/man/man1/tissue-haptic.1" \
    "$prefix/share/bash-completion/completions/tissuectl" "$prefix/share/zsh/site-functions/_tissuectl" \
    "$prefix/share/fish/vendor_completions.d/tissue-haptic.fish"
check "the licence and the notices of what is built in are installed" sh -c 'cmp "$1/LICENSE" "$2/LICENSE" && cmp "$1/NOTICE" "$2/NOTICE"' - "$root" "$prefix/share/doc/tissuectl"
check "an installed program runs" "$prefix/bin/tissuectl" --version

# ---- a short program of a user against the library: without the project's macros, warnings are errors
cat >"$scratch/user.cpp" <<'CPP'
#include <iostream>
#include "haptic/device.h"
#include "haptic/simulation.h"
#include "springs/heuristic.h"
#include "springs/spring_law.h"
int main() {
    const tissue::SpringMesh mesh = tissue::make_lattice("grid8", 2, 2, 0.1, 0.1);
    const Eigen::VectorXd theta = tissue::heuristic_stiffness(mesh, 0.75);
    const tissue::NodeField push = tissue::NodeField::Constant(mesh.node_count(), 2, 0.01);
    const auto K = tissue::make_spring_law("axial")->stiffness(mesh, theta, push);
    std::cout << mesh.spring_count() << ' ' << (K * tissue::as_vector(push)).norm() << '\n';
}
CPP
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
built() { # OPTION...
    # shellcheck disable=SC2046  # flags are separate words
    run g++ -std=c++17 -Wall -Wextra -Werror "$@" user.cpp $(pkg-config --cflags --libs tissue) -o user
}
for options in "-O0" "-O2 -DNDEBUG"; do
    # shellcheck disable=SC2086
    built $options
    check "a program builds against the library by pkg-config, $options" exited 0
    run ./user
    check "a program against the library contains no assertion of Eigen, $options" sh -c 'symbols=$(nm -C "$1") && ! echo "$symbols" | grep -q assert_fail' - "$work/user"
    check "a program against the library runs, and forces vanish under a rigid translation, $options" says '^20 [0-9.e-]*-1[0-9]$\|^20 0$'
done
built -O0 -mavx
check "vector instructions that differ from the library's are refused" says 'libtissue was built for other vector instructions'
check "pkg-config prints the version of tissuectl" test "$(pkg-config --modversion tissue)" = "$("$TISSUECTL" --version | cut -d' ' -f2)"

# ---- manual pages and completions contain every option of --help
options_of() { "$TISSUECTL" "$1" --help | sed -n 's/^  \(-h,\)*\(--[a-z-]*\) .*/\2/p' | sort; }
for command in train eval export; do
    options_of "$command" >"$scratch/wanted"
    check "the manual page has every option of $command" sh -c '
        sed -n "/^\.SS $1\$/,/^\.S[SH] /p" "$2" | sed "s/\\\\-/-/g" | sed -n "s/^.fB\(-h,\)*\(--[a-z-]*\).*/\2/p" | sort | diff - "$3"' - \
        "$command" "$prefix/share/man/man1/tissuectl.1" "$scratch/wanted"
    check "bash completes every option of $command" bash -c '
        . "$1"; COMP_WORDS=(tissuectl "$2" --); COMP_CWORD=2; _tissuectl; printf "%s\n" "${COMPREPLY[@]}" | sort | diff - "$3"' - \
        "$prefix/share/bash-completion/completions/tissuectl" "$command" "$scratch/wanted"
done
check "bash completes commands" bash -c '
    . "$1"; COMP_WORDS=(tissuectl ex); COMP_CWORD=1; _tissuectl; [ "${COMPREPLY[*]}" = export ]' - \
    "$prefix/share/bash-completion/completions/tissuectl"
check "bash completes files after an option that takes a file" bash -c '
    cd "$2"; . "$1"; COMP_WORDS=(tissuectl train --study us); COMP_CWORD=3; _tissuectl; case " ${COMPREPLY[*]} " in *" user.cpp "*) ;; *) exit 1 ;; esac' - \
    "$prefix/share/bash-completion/completions/tissuectl" "$scratch"

# ---- a second installation, DESTDIR, and removal
echo mine >"$prefix/share/doc/mine"
echo "include/tissue/gone.h" >>"$prefix/share/doc/tissuectl/manifest"
: >"$prefix/include/tissue/gone.h"
place "$build" PREFIX="$prefix"
check "installing again removes files that are no longer part of it" absent "$prefix/include/tissue/gone.h"
left="$prefix/bin/tissuectl.tissue-Ry0WvV6x.tmp"
: >"$left"
place "$build" PREFIX="$prefix"
check "installing again removes leftovers of a killed installation" absent "$left"
mkdir "$scratch/bin"
cat >"$scratch/bin/mktemp" <<SH
#!/bin/sh
name=\$("$(command -v mktemp)" "\$@") || exit 1
case \$name in *.tissue-*) ln -sfT "$scratch/precious" "\$name" ;; esac
printf '%s\n' "\$name"
SH
chmod +x "$scratch/bin/mktemp"
echo precious >"$scratch/precious"
place "$build" PREFIX="$prefix" PATH="$scratch/bin:$PATH"
check "a link that replaces a temporary file: exit 1" exited 1
check "a link that replaces a temporary file: one line states the cause" one_line '^install: cannot write .*another program has taken the name'
check "a link that replaces a temporary file: nothing is written through it" test "$(cat "$scratch/precious")" = precious
check "a link that replaces a temporary file: no temporary file is left" test -z "$(find "$prefix" -name '*.tissue-*')"
sed -i 's|ln -sfT ".*" "\$name"|rm -f "$name"; mkdir "$name"; : >"$name/precious"|' "$scratch/bin/mktemp"
place "$build" PREFIX="$prefix" PATH="$scratch/bin:$PATH"
check "a folder that replaces a temporary file: exit 1" exited 1
check "a folder that replaces a temporary file: one line states the cause" one_line '^install: cannot write .*another program has taken the name'
check "a folder that replaces a temporary file is kept with its content" test -n "$(find "$prefix" -path '*.tissue-*/precious')"
find "$prefix" -name '*.tissue-*' -exec rm -r {} +
place "$build" PREFIX=/opt/tissue DESTDIR="$scratch/stage"
check "DESTDIR is prepended to PREFIX" exist "$scratch/stage/opt/tissue/bin/tissuectl"
check "no installed file contains DESTDIR" sh -c '! grep -rIl "$1" "$1"' - "$scratch/stage"
check "the same files are installed with and without DESTDIR" sh -c '(cd "$1" && find . -type f ! -name mine | sort) >"$3"; (cd "$2" && find . -type f | sort) | diff "$3" -' - \
    "$prefix" "$scratch/stage/opt/tissue" "$scratch/list"
place --remove PREFIX=/opt/tissue DESTDIR="$scratch/stage"
check "uninstall: exit 0" exited 0
check "uninstall leaves no file and no folder named tissue" test -z "$(find "$scratch/stage" ! -type d -o -name '*tissue' ! -path '*/opt/tissue')"
place --remove PREFIX="$prefix"
check "uninstall keeps files of others" test "$(find "$prefix" -type f)" = "$prefix/share/doc/mine"
place --remove PREFIX="$prefix"
check "uninstall without an installation: exit 1" exited 1
check "uninstall without an installation: one line states the cause" one_line '^install: .*nothing is installed there'
odd="$scratch/it's \"a\" place"
place "$build" PREFIX="$odd" DESTDIR=/
check "a PREFIX with blanks and quotes, and DESTDIR=/: exit 0" exited 0
check "a PREFIX with blanks and quotes: program and header are installed" exist "$odd/bin/tissuectl" "$odd/include/tissue/haptic/device.h"
check "a PREFIX with blanks and quotes: the pkg-config file contains it" sh -c 'export PKG_CONFIG_PATH="$1/lib/pkgconfig"
    eval "set -- \"\$1\" $(pkg-config --cflags tissue-c)" && [ "$2" = "-I$1/include" ] || { printf "%s\n" "$@"; exit 1; }' - "$odd"
place --remove PREFIX="$odd" DESTDIR=/
check "a PREFIX with blanks and quotes: uninstall removes all files" test -z "$(find "$odd" ! -type d)"
odd="$scratch/it's a stage"
run make -C "$root" uninstall PREFIX="$odd"
check "make passes on a PREFIX with blanks and quotes" says "^install: $odd/share/doc.*nothing is installed there"
run make -C "$root" uninstall PREFIX=/p DESTDIR="$odd"
check "make passes on a DESTDIR with blanks and quotes" says "^install: $odd/p/share/doc.*nothing is installed there"
odd="$scratch/a\\backslash"
run make -C "$root" uninstall PREFIX="$odd"
check "make passes on a PREFIX with a backslash" grep -qF "install: $odd/share/doc" "$said"
for name in install uninstall; do
    run make -C "$root" $name PREFIX='/opt/a$b'
    check "$name with a single \$ in PREFIX, which make would expand: one line states the remedy" one_line 'PREFIX=/opt/a$b: write $$ for a $ in it'
done
place "$build" PREFIX="$odd"
check "a PREFIX with a backslash: the pkg-config file contains it" sh -c 'export PKG_CONFIG_PATH="$1/lib/pkgconfig"
    eval "set -- \"\$1\" $(pkg-config --cflags tissue-c)" && [ "$2" = "-I$1/include" ] || { printf "%s\n" "$@"; exit 1; }' - "$odd"
run env HOME="$scratch/home" make -C "$root" uninstall PREFIX='$(HOME)/x'
check "make expands variables in PREFIX" says "^install: $scratch/home/x/share/doc/tissuectl/manifest: there is no such file"
run env HOME="$scratch/home" PREFIX="$scratch/of the environment" make -C "$root" uninstall
check "make takes PREFIX from the environment" says "^install: $scratch/of the environment/share"

# ---- links, and foreign manifests
mkdir "$scratch/linked" "$scratch/elsewhere"
ln -s "$scratch/elsewhere" "$scratch/linked/lib"
place "$build" PREFIX="$scratch/linked"
check "a folder that is a link of the same user: exit 0" exited 0
check "a folder that is a link of the same user is followed" exist "$scratch/elsewhere/libtissue.a"
if chown -h 65534 "$scratch/linked/lib" 2>/dev/null; then
    place --remove PREFIX="$scratch/linked"
    check "a folder that is a link of another user: uninstall fails" exited 1
    check "a folder that is a link of another user: one line names it" one_line "'lib' is a link of another user, which is not followed"
    check "a folder that is a link of another user: nothing is removed through it" exist "$scratch/elsewhere/libtissue.a"
    rm "$scratch/elsewhere/libtissue.a"
    place "$build" PREFIX="$scratch/linked"
    check "a folder that is a link of another user: install fails" exited 1
    check "a folder that is a link of another user: nothing is installed through it" absent "$scratch/elsewhere/libtissue.a"
else
    skip "a folder that is a link of another user" "only root can make one"
fi
for line in ../mine /mine lib/../../mine ''; do
    mkdir -p "$scratch/foreign/share/doc/tissuectl" && echo mine >"$scratch/mine"
    printf 'bin/x..y\n%s\n' "$line" >"$scratch/foreign/share/doc/tissuectl/manifest"
    place --remove PREFIX="$scratch/foreign"
    check "a manifest with the line '$line': one line states the cause" one_line '^install: .*manifest is not a list of this installation'
    check "a manifest with the line '$line': nothing is removed" exist "$scratch/mine"
done
place "$build" PREFIX=here
check "a PREFIX that is not absolute is refused" one_line "PREFIX must be an absolute path, not 'here'"
place "$build" PREFIX="$scratch/a\$HOME"
check "a PREFIX with a dollar sign is refused" one_line "PREFIX must not have a dollar sign.*"
check "a PREFIX with a dollar sign: nothing is installed" test ! -e "$scratch/a\$HOME"
finish
