#!/bin/sh
# The bindings for other programs, as installed: libtissue.so with tissue.h from C, and `import tissue` from Python.
# Both give the same forces to the last bit.
. "$(dirname "$0")/common"
build=$(dirname "$TISSUECTL")
examples=$root/lib/api/examples
prefix=$scratch/prefix
make_copy
data=$work/fem/data/tiny.csv
model=$scratch/model.h5

# A synthetic tissue with 50 N/m along the normal and 30 N/m across it at every contact.
"$PYTHON" - "$data" <<'PY'
import sys
rows = ["contact_x [mm],contact_y [mm],displacement_x [mm],displacement_y [mm],force_x [mN],force_y [mN]"]
for i in range(24):
    x, y, n = [(100, 20 + 10 * i, (-1, 0)), (100 - 10 * (i - 8), 100, (0, -1)), (0, 100 - 10 * (i - 16), (1, 0))][i // 8]
    for across in (-2, 2):
        u = [5 * n[0] - across * n[1], 5 * n[1] + across * n[0]]
        f = [250 * n[0] - 30 * across * n[1], 250 * n[1] + 30 * across * n[0]]
        rows.append(f"{x},{y},{u[0]},{u[1]},{f[0]},{f[1]}")
open(sys.argv[1], "w").write("\n".join(rows) + "\n")
PY
sed -e 's/^cells = .*/cells = [6, 6]/' -e 's/block_measured/tiny/' -e 's/^thickness_m = .*/thickness_m = 0.005/' -e 's/^starts = .*/starts = 1/' \
    "$root/fem/studies/measured.toml" >"$work/fem/studies/tiny.toml"
(cd "$work" && "$TISSUECTL" import "$data" --study fem/studies/tiny.toml --out "$scratch/cases.h5" &&
    "$TISSUECTL" train --study fem/studies/tiny.toml --cases "$scratch/cases.h5" --out "$model") >"$scratch/log" 2>&1 || cat "$scratch/log"
PREFIX=$prefix PACKAGES="$(sed -n 's/^PACKAGES := //p' "$root/Makefile")" PYTHON=$PYTHON "$root/scripts/install" "$build" || exit 1
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig" LD_LIBRARY_PATH="$prefix/lib" PYTHONPATH="$(echo "$prefix"/lib/python3*/dist-packages)"
export MPLCONFIGDIR="$scratch"

# ---- C
check "tissue.h compiles as C99 and as C++11 without a warning" sh -c "
    gcc -std=c99 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -x c '$prefix/include/tissue.h' && g++ -std=c++11 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -x c++ '$prefix/include/tissue.h'"
check "the C example builds by pkg-config" sh -c "gcc -std=c99 -Wall -Wextra -Wpedantic -Werror '$examples/press.c' \$(pkg-config --cflags --libs tissue-c) -o '$scratch/press'"
check "the C example links libtissue.so.1, and not hdf5, stdc++ or nlopt" sh -c "readelf -d '$scratch/press' | grep -q 'NEEDED.*libtissue.so.1' && ! readelf -d '$scratch/press' | grep -q 'NEEDED.*\(hdf5\|stdc++\|nlopt\)'"
check "the library exports the symbols of tissue.h with version TISSUE_1, and no others" sh -c "
    nm -D --defined-only '$prefix/lib/libtissue.so.1' | sed -n 's/.* T //p' | sort >'$scratch/has'
    sed -n 's/^TISSUE_API.*\(tissue_[a-zA-Z_]*\)(.*/\1@@TISSUE_1/p' '$prefix/include/tissue.h' | sort | diff - '$scratch/has'"
"$PYTHON" -c 'import math
for k in range(1000):
    print(0.05 + 0.004 * math.sin(9e-3 * k), "nan" if k == 300 else 0.101 - 0.005 * math.sin(3.14e-3 * k), 0.3)' >"$scratch/way"
check "the C example runs" sh -c "'$scratch/press' '$model' friction 0.3 <'$scratch/way' >'$scratch/c' 2>'$scratch/log'"
check "the C example reports a refused position and continues" sh -c "grep -qx 'press: the position was refused: not finite, too fast or too old' '$scratch/log' && [ \$(wc -l <'$scratch/c') = 1000 ]"
check "the C example with an unknown option prints one line" sh -c "! '$scratch/press' '$model' frction 0.3 </dev/null 2>'$scratch/log' && grep -qx \"press: there is no option 'frction'\" '$scratch/log'"
check "the C example with a file that is not a model prints one line" sh -c "! '$scratch/press' '$data' </dev/null 2>'$scratch/log' && [ \$(wc -l <'$scratch/log') = 1 ] && grep -q 'tiny.csv' '$scratch/log'"
check "ticks of a library opened by dlopen allocate no memory, also when a position is refused" sh -c "
    gcc -std=c11 -Wall -Wextra -Werror -I'$prefix/include' '$root/tests/api/loaded_tick.c' -o '$scratch/loaded_tick' -ldl -lm -pthread && '$scratch/loaded_tick' '$prefix/lib/libtissue.so.1' '$model'"

# ---- Python
check "a thousand ticks in Python give the forces of C to the last bit" "$PYTHON" - "$model" "$scratch/way" "$scratch/c" <<'PY'
import sys

import numpy as np
import tissue
model, way, c = sys.argv[1:]
way = np.loadtxt(way)
there = np.array([[float.fromhex(x) for x in line.split()] for line in open(c)])
once = tissue.Simulation(tissue.Model(model), friction=0.3).ticks(way)
assert once.shape == (1000, 3) and (once == there).all() and np.abs(once).max() > 0.01
step = tissue.Simulation(tissue.Model(model), friction=0.3)
assert all((step.tick(p) == f).all() for p, f in zip(way, there))
PY
check "arrays of model and session are views, and outlive their owner" "$PYTHON" - "$model" <<'PY'
import gc, sys

import numpy as np
import tissue
model = tissue.Model(sys.argv[1])
nodes = model.nodes
assert not nodes.flags.owndata and not nodes.flags.writeable and np.shares_memory(nodes, model.nodes)
copy = nodes.copy()
session = tissue.Simulation(model)
u = session.displacement_m
assert np.shares_memory(u, session.displacement_m) and not u.flags.writeable and (u == 0).all()
session.ticks(np.column_stack([np.full(300, 0.05), np.linspace(0.101, 0.095, 300), np.zeros(300)]))
assert np.abs(u).max() > 1e-7 and session.contact["mesh"] == 0
session.reset()
assert (u == 0).all()
del model, session
gc.collect()
assert (nodes == copy).all() and (u == 0).all()
PY
check "a session can be saved, copied, changed and taken over by another one" "$PYTHON" - "$model" <<'PY'
import sys

import numpy as np
import tissue
model = tissue.Model(sys.argv[1])
session = tissue.Simulation(model, friction=0.3)
down = np.column_stack([np.full(400, 0.05), np.linspace(0.101, 0.096, 400), np.zeros(400)])
session.ticks(down)
state, copy, other = session.state, session.copy(), tissue.Simulation(model, friction=0.3)
assert isinstance(state, bytes) and len(state) > 1000
there = np.tile(down[-1], (300, 1)) + [[0.002, 0, 0]] * np.linspace(0, 1, 300)[:, None]
went_on = session.ticks(there)
other.state = state
assert (copy.ticks(there) == went_on).all() and (other.ticks(there) == went_on).all()
for wrong in (state[:-1], state[:-1] + bytes([state[-1] ^ 1])):
    try:
        other.state = wrong
    except tissue.Error:
        continue
    assert False, wrong
assert session.surfaces == []  # none in the plane
energies = session.energies_J
assert set(energies) == {"given", "observed", "bound", "kinetic", "friction", "stored", "dissipated"} and energies["given"] < 0 < energies["bound"] and energies["friction"] > 0, energies
session.set(force_scale=2, offset=(0, 0))
fresh = session.begin()  # at rest, with the options at the start
assert (fresh.ticks(down) == tissue.Simulation(model, friction=0.3).ticks(down)).all() and fresh.surfaces == session.surfaces
for wrong in ({"dt": 0.002}, {"force_scale": -1}, {"colour": "red"}):
    try:
        session.set(**wrong)
    except tissue.Error:
        continue
    assert False, wrong
at = there[-1]
twice = session.ticks(np.tile(at, (100, 1)))[-1]
assert np.linalg.norm(twice) > 1.8 * np.linalg.norm(went_on[-1]), (twice, went_on[-1])
session.clutch(True)
assert not session.ticks(at + np.outer(np.arange(50), [1e-4, 0, 0]))[-1].any()
session.clutch(False)
following = tissue.Simulation(model)
following.follow(session)
following.take_over(session)
assert following.counts["ticks"] == session.counts["ticks"] and following.tick(at + [49e-4, 0, 0], age_s=0.001).shape == (3,) and following.contact["status"] == "done"
PY
check "a tool that grasps lifts the tissue in Python, and lets go above its limit" "$PYTHON" - "$model" <<'PY'
import sys

import numpy as np
import tissue
model = tissue.Model(sys.argv[1])
session = tissue.Simulation(model)
line = lambda first, last, n: np.column_stack([np.full(n, 0.05), np.linspace(first, last, n), np.zeros(n)])
session.ticks(line(0.101, 0.099, 300))
session.grasp(True)
lifted = session.ticks(line(0.099, 0.103, 400))
assert session.contact["grasped"] and session.contact["mesh"] == 0 and lifted[-1][1] < -1e-3, (session.contact, lifted[-1])
session.set(grasp_max=0.5 * np.linalg.norm(session.contact["force_N"]))
session.tick(line(0.103, 0.103, 1)[0])
after = session.ticks(line(0.103, 0.103, 3))
assert not session.contact["grasped"] and session.counts["let_go"] == 1 and not after[-1].any(), (session.counts, after[-1])
PY
cp "$model" "$scratch/floppy.h5"
check "Model.press of many contacts equals that of each contact, and states the cause of a missing answer" "$PYTHON" - "$model" "$scratch" <<'PY'
import sys

import h5py
import numpy as np
import tissue
model = tissue.Model(sys.argv[1])
contacts = np.array([[0.05, 0.1], [0.03, 0.1],[0.0, 0.06]])
pushes = np.array([[0, -0.004], [0.001, -0.003], [0.002, 0]])
force, u, why = model.press(contacts, pushes)
assert force.shape == (3, 2) and u.shape == (3, *model.nodes.shape) and why == ["", "", ""]
for k in range(3):
    alone, _, _ = model.press(np.asfortranarray(contacts[k:k + 1]), [list(pushes[k])], threads=1)
    assert (alone[0] == force[k]).all()
assert (u[0][model.fixed] == 0).all() and np.linalg.norm(force[0]) > 0.05
with h5py.File(f"{sys.argv[2]}/floppy.h5", "a") as file:
    file["law/constants"][...] = 1e-6 * file["law/constants"][:]
force, u, why = tissue.Model(f"{sys.argv[2]}/floppy.h5").press(contacts[:2], [(0, -0.3), (0, 0)])
assert why[0] and np.isnan(force[0]).all() and np.isnan(u[0]).all() and why[1] == "" and (u[1] == 0).all(), (why, force)
PY
check "Adaptation gives the model of tissuectl adapt, and read_study reads the files of a study" "$PYTHON" - "$TISSUECTL" "$model" "$scratch" <<'PY'
import subprocess, sys

import h5py
import numpy as np
import tissue
program, model, scratch = sys.argv[1:]
pokes = [((0.05, 0.1), (0, -0.005), (0, -0.4)), ((0.0, 0.06), (0.005, 0), (0.3, 0.02)), ((0.1, 0.06), (-0.004, 0), (-0.3, 0.0))]
with open(f"{scratch}/pokes.csv", "w") as out:
    out.write("contact_x [m],contact_y [m],displacement_x [m],displacement_y [m],force_x [N],force_y [N]\n")
    out.writelines(",".join(repr(float(v)) for part in poke for v in part) + "\n" for poke in pokes)
patient = tissue.Adaptation(model)
said = [patient.learn(*poke)["status"] for poke in pokes]
assert said.count("learned") >= 2, said
patient.write(f"{scratch}/python.h5")
subprocess.run([program, "adapt", model, "--data", f"{scratch}/pokes.csv", "--out", f"{scratch}/cli.h5"], check=True, capture_output=True)
with h5py.File(f"{scratch}/python.h5") as a, h5py.File(f"{scratch}/cli.h5") as b:
    assert (a["adaptation/x"][:] == b["adaptation/x"][:]).all() and (a["law/patch_log"][:] == b["law/patch_log"][:]).all()
force, sd, status = patient.expect((0.05, 0.1), (0, -0.005))
assert status == "held" and 0 < sd < 1 and len(patient.next(count=2)) == 2 and patient.learned >= 2
assert patient.learn((0.05, 0.3), (0, -0.005), (0, -0.4))["status"] == "refused"
now, _, _ = patient.model().press([(0.05, 0.1)], [(0, -0.005)])
assert np.allclose(now[0], force, rtol=1e-9)
study = tissue.read_study(scratch)
assert study["model"].is_law and study["eval"] is None and len(study["paths"]) >= 24
path = study["paths"][0]
assert path["role"] == "train" and path["force_N"].shape[1] == 2 and path["displacement_m"].shape[0] == 0
PY
check "invalid arguments raise tissue.Error with a message of one line" "$PYTHON" - "$model" <<'PY'
import sys

import numpy as np
import tissue
model = tissue.Model(sys.argv[1])
for wrong in (lambda: tissue.Model("nowhere.h5"), lambda: tissue.Model("no\nwhere\033[31m.h5"), lambda: tissue.Simulation(model, dynamics="a\nb"), lambda: tissue.Simulation(model, friction_slip=0.2), lambda: tissue.Simulation(model, colour="red"), lambda: tissue.Simulation(model, friction="much"),
              lambda: tissue.Simulation(model, stale=-0.1), lambda: tissue.Simulation(model, energy_book=True), lambda: tissue.Simulation(model, innovation=0.1),
              lambda: tissue.Simulation(model, coupling=5), lambda: tissue.Simulation(model, force_scale=-1), lambda: tissue.Simulation(model, damping=float("inf")),
              lambda: model.press([[0.05, 0.1]], [[0, 0.1, 0]]), lambda: model.press([[np.nan, 0.1]], [[0, -0.01]]), lambda: model.press([[0.05, 0.1]], [[0, -0.01]], ball_m=0.01), lambda: tissue.Simulation(model).ticks(np.zeros((3, 2))),
              *(lambda unknown=unknown: tissue.Simulation(model).ticks(np.zeros((3, 3)), elapsed_s=unknown) for unknown in (-1, np.nan, np.inf)),
              lambda: tissue.Adaptation(sys.argv[1], unknowns="all"), lambda: tissue.Adaptation(sys.argv[1]).learn((0, 0, 0), (0, 0), (0, 0)), lambda: tissue.read_cases(sys.argv[1])):
    try:
        wrong()
    except tissue.Error as e:
        assert str(e).isprintable() and str(e)
    else:
        assert False, wrong
PY
check "a host at 50 Hz gets the force of 1 kHz within 1 %, a late tick is reported, and limits are counted" "$PYTHON" - "$model" <<'PY'
import sys

import numpy as np
import tissue
model = tissue.Model(sys.argv[1])
def press(rate_Hz, **options):
    time = np.arange(0, 3, 1 / rate_Hz)
    session = tissue.Simulation(model, **options)
    return session, session.ticks(np.column_stack([np.full(len(time), 0.05), 0.102 - 0.007 * np.clip(time / 0.5, 0, 1), np.zeros(len(time))]), elapsed_s=1 / rate_Hz)[-1]
session, quick = press(1000)
slow, late = press(50)
assert np.linalg.norm(quick) > 0.05 and np.linalg.norm(late - quick) < 0.01 * np.linalg.norm(quick), (quick, late)
assert slow.limits == dict(clamped=0, slewed=0, damped=0, capped=0, late=0, lost_s=0), slow.limits
assert slow.contact["status"] == "done" and slow.tick([0.05, 0.095, 0], elapsed_s=2).any() and slow.contact["status"] == "late"
assert slow.limits["late"] == 1 and 1.4 < slow.limits["lost_s"] < 1.6, slow.limits
assert press(50, force_max=0.05)[0].limits["clamped"] > 0
try:
    session.ticks(np.zeros((1, 3)), elapsed_s=-1)
except tissue.Error as e:
    assert "elapsed_s" in str(e), e
else:
    assert False
PY
check "programs, C and Python have the options, defaults and values of OPTIONS.md, and refuse values with the same message" \
    "$PYTHON" - "$prefix" "$model" "$scratch/press" <<'PY'
import re, subprocess, sys

import tissue
prefix, file, press = sys.argv[1:]
model, init = tissue.Model(file), tissue.Simulation.__init__.__doc__
def said(status, *words):
    done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert done.returncode == status, words
    return done.stderr.splitlines()[0]
programs = {"tissue-haptic": [f"{prefix}/bin/tissue-haptic"], "serve": [f"{prefix}/bin/tissuectl", "serve"]}
helps = {name: subprocess.run([*words, "--help"], capture_output=True, text=True).stdout for name, words in programs.items()}
manual = {name: open(f"{prefix}/share/man/man1/{words[0].split('/')[-1]}.1").read().replace("\\-", "-") for name, words in programs.items()}
rows = [[cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in open(f"{prefix}/share/doc/tissuectl/OPTIONS.md") if line.startswith("| `")]
assert len(rows) > 15
compared = 0
for name, unit, default, values, where, live, meaning in rows:
    name, where, default, here = name.strip("`"), where.split(", "), default.split("; ")[0], default.split(": ")[-1]
    python = name.replace("-", "_")
    in_c = "C" in where
    assert (f"\n    {python} [{unit}]: " in init) == in_c, name
    if in_c:
        line = init.split(f"\n    {python} [{unit}]: ")[1].split("\n")[0]
        assert line.endswith("; ".join(["", *([values] if values else []), *([f"default {here}"] if here else [])])), line
    wrong = ["x"] if values else []
    if values[:1] in ("(", "["):
        low, high = (float(end) for end in values[1:-1].split(", "))
        inside = lambda v: low < v < high or (v == low and values[0] == "[") or (v == high and values[-1] == "]")
        wrong += [v for v in ("nan", "-inf", "inf", "-1", "0", "2", f"{2 * high}") if not inside(float(v))]
    wrong = ["nan 0", "0 inf", "x 0"] if name == "offset" else ["nan 0 0", "0 0 inf", "x 0 0", "0 0 101"] if name == "rotation" else ["x,x"] if name == "axes" else ["x", "ball", "ball:-1"] if name == "tool" else wrong
    for program, words in programs.items():
        flag = f"--no-{name}" if default == "yes" else f"--{name}"
        assert (f"\n  {flag} " in helps[program]) == (program in where), (program, flag)
        if program not in where: continue
        assert f"\\fB{flag}\\fR" in manual[program], flag
        if unit == "yes|no": continue
        assert re.search(rf"\n  --{name} +{re.escape(default or '-')} +{re.escape(unit)} .*{re.escape(values)}\n", helps[program]), (program, name)
    for value in wrong:
        heard = {}
        if in_c:
            try:
                tissue.Simulation(model, **{python: value})
            except tissue.Error as e:
                heard["python"] = str(e)
            heard["c"] = said(1, press, file, name, value).removeprefix("press: ")
        for program, words in programs.items():
            if program in where and unit != "yes|no":
                heard[program] = said(2, *words, file, f"--{name}", *value.split())
        asked = 2 * in_c + (unit != "yes|no") * sum(program in where for program in programs)
        assert len(heard) == asked and len(set(heard.values())) == min(asked, 1), (name, value, heard)
        compared += len(heard) > 1
assert compared > 40, compared
PY
check "two tools in Python tick together, and queries concern the selected tool" "$PYTHON" - "$model" <<'PY'
import sys

import numpy as np
import tissue
model = tissue.Model(sys.argv[1])
session, alone = tissue.Simulation(model, tools=2), tissue.Simulation(model)
assert (session.tools, alone.tools) == (2, 1)
session.use_tool(1)
session.set(friction=0.2)
for k in range(500):
    at = np.array([[0.03, 0.101 - 1e-5 * k, 0], [0.07 + 1e-5 * k, 0.101 - 8e-6 * k, 0]])
    both, one = session.tick_tools(at), alone.tick(at[0])
assert both.shape == (2, 3) and both[0, 1] > 0.05 and both[1, 1] > 0.05 and one[1] > 0.05, (both, one)
right = session.contact
session.use_tool(0)
left = session.contact
assert left["mesh"] == right["mesh"] == 0 and left["facet"] != right["facet"] and left["force_N"][1] < 0 and right["force_N"][0] > 0
assert np.allclose(left["force_N"][:2], -both[0, :2]) and session.energies_J["friction"] == 0
other = session.copy()
at[1, 0] = np.nan
assert (session.tick_tools(at, age_s=[0, 0])[1] == 0).all() and session.contact["status"] == "done" and session.counts["bad_input"] == 0
session.use_tool(1)
assert session.contact["status"] == "refused" and session.counts["bad_input"] == 1 and session.energies_J["friction"] > 0
at[1, 0] = 0.075
assert other.contact["facet"] == left["facet"] and (other.tick_tools(at)[1] != 0).any()
for wrong in (lambda: session.tick(at[0]), lambda: session.ticks(at), lambda: session.tick_tools(at[:1]), lambda: session.tick_tools(at, age_s=[0]), lambda: session.use_tool(2), lambda: session.use_tool(-1), lambda: alone.tick_tools(at),
              lambda: tissue.Simulation(model, tools=3), lambda: tissue.Simulation(model, tools=2, heuristic=True)):
    try:
        wrong()
    except tissue.Error as e:
        assert "\n" not in str(e), e
    else:
        assert False
PY
check "an indentation off the tissue is refused, and the message names it" "$PYTHON" - "$model" <<'PY'
import sys

import numpy as np
import tissue
model, patient = tissue.Model(sys.argv[1]), tissue.Adaptation(sys.argv[1])
top, down = (0.05, 0.1), (0, -0.004)
for contact, push, why in (((5, 5), down, "off the surface"), ((0.05, 0.06), down, "off the surface"), ((0.05, 0), (0, 0.004), "on a fixed part"), ((0, 0), (0.004, 0), "on a fixed part"),
                           (top, (0, 0.004), "out of the tissue"), ((np.nan, 0.1), down, "no"), ((np.inf, 0.1), down, "no"), (top, (0, np.nan), "no")):
    for act in (lambda: model.press([top, contact], [down, push]), lambda: patient.expect(contact, push)):
        try:
            act()
        except tissue.Error as e:
            assert why in str(e) and "\n" not in str(e), e
        else:
            assert False, (contact, push)
try:
    model.press([top, (5, 5)], [down, down])
except tissue.Error as e:
    assert str(e).startswith("contact 1 is"), e
for depth in (-1, 0, np.nan, np.inf):
    try:
        patient.next(depth_m=depth)
    except tissue.Error:
        continue
    assert False, depth
force, _, _ = model.press([top, (0.05, 0.101)], [down, down])  # a millimetre off is on it
assert (force[0] == force[1]).all() and patient.expect(top, down)[2] == "held"
# a missing answer has no force; zero displacement has zero force
lost = 0
for push in ((0, -0.2), (0, -1), (0, -100)):
    force, _, why = model.press([top], [push])
    expected, _, status = patient.expect(top, push)
    assert bool(why[0]) == bool(np.isnan(force).all()) == (status != "held") == bool(np.isnan(expected).all()), (push, why, force, status, expected)
    lost += bool(why[0])
assert lost > 0
expected, sd, status = patient.expect(top, (0, 0))
assert status == "held" and not expected.any() and 0 < sd < 1, (expected, sd, status)
PY
check "invalid options of Adaptation, damaged eval.json and folders as files are refused" "$PYTHON" - "$model" "$scratch" <<'PY'
import math, pathlib, sys

import tissue
file, scratch = sys.argv[1:]
for wrong in (dict(force_noise=-0.02), dict(force_noise=math.nan), dict(force_noise=2), dict(model_error=0), dict(model_error=-0.1), dict(place_error_m=-1), dict(place_error_m=math.inf)):
    try:
        tissue.Adaptation(file, **wrong)
    except tissue.Error as e:
        assert "must be from" in str(e) and "\n" not in str(e), e
    else:
        assert False, wrong
folder = pathlib.Path(scratch, "read_study")
folder.mkdir()
for name in ("model.h5", "cases.h5"):
    (folder / name).symlink_to(pathlib.Path(scratch, name).resolve())
for content in (b"", b'{"a": ', b"\xff\xfe", None):
    if content is None:
        (folder / "eval.json").unlink()
        (folder / "eval.json").mkdir()
    else:
        (folder / "eval.json").write_bytes(content)
    try:
        tissue.read_study(folder)
    except tissue.Error as e:
        assert "eval.json" in str(e) and "\n" not in str(e), e
    else:
        assert False, content
for what in (lambda: tissue.Model(scratch), lambda: tissue.read_cases(scratch)):
    try:
        what()
    except tissue.Error as e:
        assert str(e).endswith("is a folder; give a file"), e
    else:
        assert False
PY
check "None as any argument raises TypeError or tissue.Error" "$PYTHON" - "$model" "$scratch" <<'PY'
import sys

import tissue
file, scratch = sys.argv[1:]
model = tissue.Model(file)
session, patient = tissue.Simulation(model), tissue.Adaptation(file)
top, down = (0.05, 0.1), (0, -0.004)
calls = {tissue.Model: dict(file=file), tissue.Simulation: dict(model=model, friction=0.3, force_max=3, axes="x,y", offset=[0, 0], heuristic=False), model.press: dict(contacts_m=[top], pushes_m=[down], threads=1),
         session.tick: dict(position_m=(0, 0.2, 0), elapsed_s=0.001), session.tick_tools: dict(positions_m=[(0, 0.2, 0)], elapsed_s=0.001, age_s=[0]), session.ticks: dict(positions_m=[(0, 0.2, 0)], elapsed_s=0.001),
         tissue.Adaptation: dict(model_file=file, unknowns="field", force_noise=0.02, model_error=0.03, place_error_m=0, rival=True),
         patient.learn: dict(contact_m=top, push_m=down, force_N=(0, -0.3)), patient.expect: dict(contact_m=top, push_m=down), patient.next: dict(depth_m=0.006, count=1),
         patient.write: dict(file=scratch + "/none.h5"), tissue.read_study: dict(folder=scratch), tissue.read_cases: dict(file=scratch + "/cases.h5"),
         session.use_tool: dict(tool=0), session.clutch: dict(on=False)}
for call, arguments in calls.items():
    call(**arguments)
    for name in arguments:
        if (call, name) in ((tissue.Adaptation, "rival"), (session.tick_tools, "age_s")): continue  # None is valid: false, and no age
        try:
            call(**{**arguments, name: None})
        except (TypeError, tissue.Error):
            continue
        assert False, (call, name)
PY
check "every use of an object that was never initialised raises TypeError" "$PYTHON" - "$model" <<'PY'
import sys

import tissue
bare = {owner: owner.__new__(owner) for owner in (tissue.Model, tissue.Simulation, tissue.Adaptation)}
top, down = (0.05, 0.1), (0, -0.004)
arguments = {"press": ([top], [down]), "with_tool": (0.005,), "tick": ((0, 0.2, 0),), "ticks": ([(0, 0.2, 0)],), "tick_tools": ([(0, 0.2, 0)],), "learn": (top, down, down), "expect": (top, down), "write": ("/nowhere/none.h5",), "clutch": (True,), "grasp": (True,), "use_tool": (0,), "surface": ("boundary",), "add_surface": ("organ", "/nowhere/none.obj", 1.0), "follow": (tissue.Simulation(tissue.Model(sys.argv[1])),), "take_over": (tissue.Simulation(tissue.Model(sys.argv[1])),)}
asked = 0
for owner, it in bare.items():
    for name in vars(owner):
        if name.startswith("_") and name != "__repr__": continue
        if name == "__repr__" and owner is not tissue.Model: continue
        try:
            got = getattr(it, name)
            got(*arguments.get(name, ()))
        except TypeError as e:
            assert "not initialised" in str(e), (owner, name, e)
            asked += 1
            continue
        assert False, (owner, name)
assert asked > 30, asked
try:
    tissue.Simulation(bare[tissue.Model])
except (TypeError, RuntimeError):
    pass
else:
    assert False
PY
check "files may be given as paths or as text" "$PYTHON" - "$model" "$scratch" <<'PY'
import pathlib, sys

import tissue
model, scratch = (pathlib.Path(a) for a in sys.argv[1:])
assert tissue.Model(model).study == tissue.Model(str(model)).study
patient = tissue.Adaptation(model)
patient.write(scratch / "path.h5")
assert len(tissue.read_cases(scratch / "cases.h5")) == len(tissue.read_study(scratch)["paths"])
PY
check "long calls let other threads run, and Ctrl-C interrupts them" "$PYTHON" - "$model" <<'PY'
import os, signal, sys, threading, time

import numpy as np
import tissue
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may ignore it
model = tissue.Model(sys.argv[1])
session = tissue.Simulation(model)
way = np.tile((0.05, 0.097, 0), (10_000_000, 1))  # minutes
contacts, pushes = np.tile((0.05, 0.1), (300_000, 1)), np.tile((0, -0.004), (300_000, 1))
for act, threads in ((lambda: session.ticks(way), 1), (lambda: model.press(contacts, pushes, threads=1), 1), (lambda: model.press(contacts, pushes, threads=3), 3)):
    beats = []
    def interrupt():
        end = time.monotonic() + 1
        while time.monotonic() < end:
            beats.append(time.monotonic())
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)
    other = threading.Thread(target=interrupt)
    began = time.monotonic()
    other.start()
    try:
        act()
    except KeyboardInterrupt:
        pass
    else:
        assert False
    took = time.monotonic() - began
    other.join()
    assert took < 20 and len(beats) > 20, (took, len(beats))
before = session.counts["ticks"]
assert 0 < before < len(way)
session.ticks(way[:10])
assert session.counts["ticks"] == before + 10
# a signal handler that uses the same object
signal.signal(signal.SIGALRM, lambda *_: session.reset())
signal.setitimer(signal.ITIMER_REAL, 0.2)
session.ticks(way[:200_000])
PY
check "several threads can create the first arrays of a program at once" "$PYTHON" - "$model" "$scratch/cases.h5" <<'PY'
import faulthandler, sys, threading

import tissue
faulthandler.dump_traceback_later(60, exit=True)  # ends a deadlock
wrong = []
def use():
    try:
        tissue.read_cases(sys.argv[2]), tissue.Model(sys.argv[1]).nodes
    except Exception as e:
        wrong.append(e)
threads = [threading.Thread(target=use) for _ in range(6)]
[t.start() for t in threads]
[t.join() for t in threads]
assert not wrong, wrong
PY
check "one object can be used in several threads" "$PYTHON" - "$model" <<'PY'
import sys, threading

import numpy as np
import tissue
patient, session = tissue.Adaptation(sys.argv[1]), tissue.Simulation(tissue.Model(sys.argv[1]))
wrong = []
def use(k):
    try:
        for i in range(20):
            patient.learn((0.02 + 0.01 * k, 0.1), (0, -0.004), (0, -0.2 - 0.001 * i))
            patient.expect((0.05, 0.1), (0, -0.003)), patient.factor, patient.sd, patient.learned
            session.ticks(np.tile((0.05, 0.098, 0), (20, 1))), session.contact, session.counts
            if i % 7 == k: session.reset(), patient.forget()
    except Exception as e:
        wrong.append(e)
threads = [threading.Thread(target=use, args=(k,)) for k in range(4)]
[t.start() for t in threads]
[t.join() for t in threads]
assert not wrong, wrong
assert session.counts["ticks"] == 4 * 20 * 20
PY
check "every public name has a docstring" "$PYTHON" -c 'import tissue
for owner in (tissue, tissue.Model, tissue.Simulation, tissue.Adaptation):
    for name in vars(owner):
        if not name.startswith("_"): assert getattr(owner, name).__doc__, (owner, name)'
check "the Python example runs" "$PYTHON" "$examples/press.py" "$model" "$scratch/press.png"
check "the Python example writes a picture" sh -c "[ \$(wc -c <'$scratch/press.png') -gt 20000 ]"
finish
