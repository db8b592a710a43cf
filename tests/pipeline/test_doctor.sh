#!/bin/sh
# tissuectl doctor: finds installed tools, names missing ones, and lists the packages that scripts/install_deps
# installs.
. "$(dirname "$0")/common"
doctor() { # OPTION...: standard output to $out, standard error to $said
    "$TISSUECTL" doctor "$@" >"$out" 2>"$said" </dev/null
    status=$?
}
out=$scratch/out
export PYTHON

doctor --json
check "all needed tools are installed: exit 0" exited 0
cp "$out" "$scratch/all.json"
check "doctor and install_deps name the same packages" "$PYTHON" -c "
import json, re, sys
text = open(sys.argv[2]).read()
base = set(re.search(r'^packages=\"(.*?)\"', text, re.S | re.M).group(1).split())
tests = {p for group in re.findall(r'packages=\"\\\$packages\n(.*?)\"', text, re.S) for p in group.split()}
tools = json.load(open(sys.argv[1]))['tools']
needed, other = {t['package'] for t in tools if t['needed']}, {t['package'] for t in tools if not t['needed']}
wrong = (base ^ needed) | (tests ^ (other - {'ccache'}))
sys.exit(f'not where the other has them: {wrong}' if wrong else 0)" \
    "$scratch/all.json" "$root/scripts/install_deps"
check "doctor prints the versions that the tools print themselves" "$PYTHON" -c "
import h5py, json, numpy, subprocess, sys
version = {t['name']: t['version'] for t in json.load(open(sys.argv[1]))['tools']}
said = lambda *command: subprocess.run(command, capture_output=True, text=True).stdout.strip()
wanted = {'numpy': numpy.__version__, 'h5py': h5py.__version__, 'g++': said('g++', '-dumpfullversion'),
          'Eigen': said('pkg-config', '--modversion', 'eigen3')}
sys.exit(str([k for k in wanted if wanted[k] != version[k]]) if any(wanted[k] != version[k] for k in wanted) else 0)" "$scratch/all.json"
check "doctor lists SCHED_FIFO, locked memory and realtime kernel of the machine" "$PYTHON" -c "
import json, sys
machine = {a['name']: a['allowed'] for a in json.load(open(sys.argv[1]))['machine']}
sys.exit(0 if machine.keys() == {'SCHED_FIFO', 'locked memory', 'realtime kernel'} else str(machine))" "$scratch/all.json"
(ulimit -l 0 -r 0 2>/dev/null; [ "$(id -u)" != 0 ] || as_nobody="setpriv --reuid=65534 --regid=65534 --clear-groups"
    [ "$(id -u)" != 0 ] || HOME=/ $as_nobody true || exit 0
    cp "$TISSUECTL" "$scratch/tissuectl" && chmod 755 "$scratch" "$scratch/tissuectl"
    HOME=/ ${as_nobody:-} "$scratch/tissuectl" doctor >"$scratch/nobody" 2>&1)
check "without privileges, doctor prints how to get realtime" grep -q "^SCHED_FIFO  *no; to allow it: root, or 'rtprio" "$scratch/nobody"

# ---- missing gmsh and FreeFEM, simulated by programs that exit with 127 ("not found")
mkdir "$scratch/bin"
for name in gmsh FreeFem++-nw; do
    printf '#!/bin/sh\nexit 127\n' >"$scratch/bin/$name"
    chmod +x "$scratch/bin/$name"
done
PATH="$scratch/bin:$PATH" doctor
check "gmsh and FreeFEM missing: exit 1" exited 1
check "gmsh and FreeFEM missing: one line on standard error names them and their packages" one_line \
    '^tissuectl: missing: gmsh, FreeFem++, FreeFem++ plugins; run make deps, or as root: apt-get install gmsh freefem++ libfreefem++$'
check "gmsh and FreeFEM missing: the table marks gmsh as missing" grep -q '^gmsh  *MISSING  *gmsh  *meshes the tissue' "$out"
FF_LOADPATH=$scratch doctor
check "a plugin folder without plugins: exit 1" exited 1
check "a plugin folder without plugins: one line states the cause" one_line '^tissuectl: missing: FreeFem++ plugins;'
finish
