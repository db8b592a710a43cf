#!/bin/sh
# tissue_gym, as installed: Gymnasium's own checker, seeds, vector environments, the agents of the example, refusals.
# Also the module with numpy 2, which this Python has.
. "$(dirname "$0")/common"
agent=${TISSUE_READERS:-$root/build/venv/bin/python}  # a Python with gymnasium (PyPI); one that is named must have it
if [ -z "${TISSUE_READERS-}" ] && ! "$agent" -c 'import gymnasium' 2>/dev/null; then
    skip "environments of tissue_gym" "scripts/venv has not installed gymnasium, and TISSUE_READERS names no Python with it"
    finish
fi
make_copy
make_tiny results/tiny/model.h5
cp "$R/model.h5" "$scratch/sets.h5"   # spring sets
poked_tissue
PREFIX=$scratch/prefix PACKAGES="$(sed -n 's/^PACKAGES := //p' "$root/Makefile")" PYTHON=$PYTHON "$root/scripts/install" "$(dirname "$TISSUECTL")" || exit 1
PYTHONPATH="$(echo "$scratch"/prefix/lib/python3*/dist-packages)"
export PYTHONPATH MPLCONFIGDIR="$scratch" PYTHONDONTWRITEBYTECODE=1
mkdir "$scratch/known" && cp "$model" "$scratch/known/model.h5"
(cd "$work" && "$TISSUECTL" eval --study fem/studies/tiny.toml --model "$scratch/known/model.h5" --cases "$scratch/cases.h5" --out "$scratch/known/eval.json" \
    --report "$scratch/known/report.md") >"$scratch/log" 2>&1 || cat "$scratch/log"
known=$scratch/known/model.h5
# a target tissue that is twice as stiff about the middle of the top
lump=$scratch/lump.h5
"$agent" - "$model" "$lump" <<'PY'
import sys

import numpy as np
import tissue
model, adaptation = tissue.Model(sys.argv[1]), tissue.Adaptation(sys.argv[1])
x = np.random.default_rng(1).permutation(np.arange(0.01, 0.095, 0.005))
contacts, pushes = np.column_stack([x, np.full(len(x), 0.1)]), np.tile([0, -0.004], (len(x), 1))
force, _, _ = model.press(contacts, pushes)
for contact, push, f in zip(contacts, pushes, force * (1 + np.exp(-((x - 0.05) / 0.015) ** 2))[:, None]):
    adaptation.learn(contact, push, f)
adaptation.write(sys.argv[2])
PY

check "ticks with numpy 2 are those with numpy 1, and arguments that are copied arrive" sh -c '
    for python in "$1" "$2"; do "$python" - "$3" <<PY
import sys
import tissue
session, adaptation = tissue.Simulation(tissue.Model(sys.argv[1])), tissue.Adaptation(sys.argv[1])
print([session.tick([0.05, 0.101 - 2e-5 * k, 0]).tolist() for k in range(300)][-1], adaptation.learn([0.05, 0.1], [0, -0.004], [0, -0.3])["expected_N"].tolist())
PY
    done | sort | uniq -c | grep -q "^ *2 \[[-0-9.e]*, [-0-9.e]*, "' - "$PYTHON" "$agent" "$model"
check "this Python has numpy 2" "$agent" -c 'import numpy; assert numpy.__version__ >= "2"'

check "Gymnasium's checker accepts every environment, with and without a known error, without a warning" "$agent" -W error::UserWarning - "$known" "$lump" <<'PY'
import sys

import gymnasium
import tissue_gym
from gymnasium.utils.env_checker import check_env
for name, file in (("Press", sys.argv[1]), ("Follow", sys.argv[1]), ("Press", sys.argv[2]), ("Palpate", sys.argv[2])):
    env = gymnasium.make(f"tissue/{name}-v0", model=file)
    assert ("model_error_N" in env.observation_space.spaces) == (file == sys.argv[1])
    check_env(env.unwrapped)
PY
check "an episode depends on the seed and the actions alone, to the last bit" "$agent" - "$known" "$lump" <<'PY'
import sys

import gymnasium
import numpy as np
import tissue_gym
def played(name, file, seed):
    env = gymnasium.make(f"tissue/{name}-v0", model=file)
    env.action_space.seed(1)
    seen = [env.reset(seed=seed)[0]] + [env.step(np.append(env.action_space.sample()[:-1], 3e-4))[0] for _ in range(40)]
    return np.array([np.concatenate([s[key] for key in sorted(s)]) for s in seen]), seen[-1]["force_N"]
for name, file in (("Press", sys.argv[1]), ("Follow", sys.argv[1]), ("Palpate", sys.argv[2])):
    once, again = ([played(name, file, seed) for seed in (5, 6, 7, 8)] for _ in range(2))
    for (one, force), (two, _) in zip(once, again):
        assert (one == two).all() and force[-1] > 0.05, (name, force)
    assert any((one != once[0][0]).any() for one, _ in once), name
PY
check "vector environments, one after another and in processes, play what single ones play" "$agent" - "$known" <<'PY'
import sys

import gymnasium
import numpy as np
import tissue_gym
def main():
    actions = np.random.default_rng(3).uniform(-3e-4, 5e-4, (30, 3, 2))
    singles = []
    for k in range(3):
        env = gymnasium.make("tissue_gym:tissue/Follow-v0", model=sys.argv[1])
        env.reset(seed=7 + k)
        singles.append([env.step(action)[:2] for action in actions[:, k]])
    for mode in ("sync", "async"):
        envs = gymnasium.make_vec("tissue_gym:tissue/Follow-v0", num_envs=3, vectorization_mode=mode, model=sys.argv[1])
        envs.reset(seed=7)
        for step, action in enumerate(actions):
            seen, reward, _, _, _ = envs.step(action)
            for k in range(3):
                assert reward[k] == singles[k][step][1], (mode, step, k)
                for key, value in singles[k][step][0].items():
                    assert (seen[key][k] == value).all(), (mode, step, k, key)
        assert seen["force_N"][:, -1].max() > 0.05
        envs.close()
main()
PY
check "force, position, time and error of an observation are those of the tissue" "$agent" - "$known" <<'PY'
import json, pathlib, sys

import gymnasium
import numpy as np
import tissue
import tissue_gym
env = gymnasium.make("tissue/Press-v0", model=sys.argv[1], friction="inf", steps=200).unwrapped
p95 = json.loads((pathlib.Path(sys.argv[1]).parent / "eval.json").read_text())["closed_loop"]["held_out"]["learned"]["p95"]
seen, info = env.reset(seed=1)
start, normal = info["position_m"], env._axes[-1]
assert seen["position_m"].tolist() == [0, -0.001] and not seen["force_N"].any() and seen["time_s"] == 0
for k in range(150):
    seen, _, _, _, info = env.step([0, 5e-4 if k < 8 else 0])
assert np.allclose(seen["position_m"], [0, 0.003], atol=1e-12) and np.allclose(info["position_m"], start + 0.004 * normal, atol=1e-12)
assert np.isclose(seen["time_s"][0], 3.0) and np.isclose(seen["model_error_N"][0], p95 * np.linalg.norm(seen["force_N"]))
rest, _, why = tissue.Model(sys.argv[1]).press([start + 0.001 * normal], [0.003 * normal])
assert why == [""] and np.allclose(env._axes @ rest[0], seen["force_N"], rtol=0.01, atol=0.01 * np.linalg.norm(rest)), (rest, seen)
wanted = seen["wanted_N"][0]
_, reward, _, _, info = env.step([0, 0])
assert np.isclose(reward, -abs(info["normal_N"] - wanted) / wanted) and np.isclose(info["off_N"], abs(info["normal_N"] - wanted))
for action, ends_at in (([1, -1], [0.02, -0.001]), ([0, 1], [0, env._depth_m])):   # limited to step_max_m a step, to reach_m, and to the trained depth
    env.reset(seed=1)
    assert np.allclose(env.step(action)[0]["position_m"], np.clip(action, -1, 1) * [5e-4, 5e-4 if action[1] > 0 else 0] + [0, -0.001])
    assert np.allclose([env.step(action) for _ in range(60)][-1][0]["position_m"], ends_at)
env.reset(seed=1)   # a tool that sticks and is dragged far
[env.step([0, 5e-4]) for _ in range(8)]
ends = [env.step([5e-4, 0]) for _ in range(12)] + [None]
while ends[-1] is None or not ends[-1][2]:
    ends[-1] = env.step([5e-4, 0])
assert ends[-1][4]["status"] == "beyond training" and ends[-1][1] == -1 - (200 - env._count) and 20 < env._count < 40, (ends[-1], env._count)
assert gymnasium.make("tissue/Press-v0", model=sys.argv[1], model_error=0.5).unwrapped._error == 0.5
frame = gymnasium.make("tissue/Press-v0", model=sys.argv[1], render_mode="rgb_array").unwrapped
frame.reset(seed=1)
first = frame.render()
[frame.step([0, 5e-4]) for _ in range(10)]
assert first.shape == (400, 500, 3) and first.dtype == np.uint8 and (frame.render() != first).any()
PY
check "an episode ends after its steps, on success, or with -1 for each step left where the tissue has no force" "$agent" - "$known" <<'PY'
import sys

import gymnasium
import tissue
import tissue_gym
env = gymnasium.make("tissue/Press-v0", model=sys.argv[1], steps=20).unwrapped
env.reset(seed=1)
ends = [env.step([0, 0])[2:4] for _ in range(20)]
assert ends == [(False, False)] * 19 + [(False, True)], ends
class Folded:
    contact = {"mesh": -1, "status": "folded"}
    def ticks(self, positions_m):
        pass
env.reset(seed=1)
[env.step([0, 0]) for _ in range(5)]
env._session = Folded()
_, reward, terminated, truncated, info = env.step([0, 0])
assert (reward, terminated, truncated, info["status"]) == (-15, True, False, "folded"), (reward, terminated, info)
try:
    env.step([0, 0])
except tissue.Error as e:
    assert "call reset()" in str(e)
else:
    assert False
PY
check "the centre of a closed surface is that of its volume" "$agent" - <<'PY'
import numpy as np
import tissue_gym
points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]) * 0.02 + [0.05, 0.03, 0.04]   # one corner: more points there would not count
centre = tissue_gym.centre_of(points, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
assert np.allclose(centre, points.mean(axis=0)), centre
PY
for task in press:"$known" follow:"$known" palpate:"$lump"; do
    run "$agent" "$root/lib/api/examples/gym_agents.py" "${task#*:}" "${task%%:*}" 8
    check "the scripted agent of ${task%%:*} is better than the random one" "$agent" - "$said" "${task%%:*}" <<'PY'
import sys
lines = [line.split() for line in open(sys.argv[1])]
print(lines)
random, scripted = (dict(total=float(l[1]), off=float(l[2 if sys.argv[2] != "palpate" else 3]), rate=float(l[-3])) for l in lines[1:])
assert scripted["total"] > random["total"] and scripted["off"] < 0.3 * random["off"] and min(random["rate"], scripted["rate"]) > 0
PY
done

# ---- refusals, each one line
refused() { # SENTENCE PATTERN MAKE [AFTER]: make("tissue/...", ...), and what follows, raises a tissue.Error of one line
    check "$1 is refused, and the message names it" "$agent" - "$2" "$3" "${4:-}" <<'PY'
import re, sys

import gymnasium
import tissue
import tissue_gym
pattern, made, after = sys.argv[1:]
try:
    env = eval(f"gymnasium.make({made})").unwrapped
    assert after, "made"
    env.reset(seed=1)
    exec(after)
except tissue.Error as e:
    assert re.search(pattern, str(e)) and str(e).isprintable(), e
else:
    assert False, "no error"
PY
}
press="'tissue/Press-v0', model='$known'"
refused "a model of spring sets" 'sets.h5: has spring sets, and an environment needs an energy model' "'tissue/Press-v0', model='$scratch/sets.h5'"
refused "a file that is no model" 'tiny.csv' "'tissue/Press-v0', model='$data'"
refused "a file that does not exist" 'nowhere.h5' "'tissue/Press-v0', model='nowhere.h5'"
refused "a model that is no name of a file" 'model must be the name of a model.h5, not 3.5' "'tissue/Press-v0', model=3.5"
refused "a model without an inclusion" 'model.h5: has no inclusion to find: take a model whose study has a nodule, or one that tissuectl adapt made' "'tissue/Palpate-v0', model='$known'"
refused "an inclusion without a contact near it" 'lump.h5: no contact of the training is from 0.2 to 0.7 times reach_m, 0.001 m, beside the inclusion at \[0.0' "'tissue/Palpate-v0', model='$lump', reach_m=0.001"
for wrong in steps:1 steps:2.5 reach_m:0 step_s:0 step_s:20 step_max_m:0 step_max_m:0.1 model_error:-1 render_mode:"'ansi'" friction:"'much'" colour:"'red'" force_max:"'x'" tool:"[1]"; do
    refused "$(echo "${wrong%%:*} ${wrong#*:}" | tr -d "'")" "${wrong%%:*}|$(echo "${wrong%%:*}" | tr _ -)" "$press, disable_env_checker=True, ${wrong%%:*}=${wrong#*:}"
done
refused "an action of three numbers in the plane" 'must be 2 finite numbers' "$press" 'env.step([0, 0, 0])'
refused "an action that is no number" 'must be 2 finite numbers' "$press" 'env.step([0, float("nan")])'
refused "a step before the first episode" 'call reset' "$press" 'env._session = None; env.step([0, 0])'
refused "a picture before the first episode" 'call reset' "$press, render_mode='rgb_array'" 'env._session = None; env.render()'
printf '{"a": ' >"$scratch/broken.json"
mkdir "$scratch/other"
cp "$model" "$scratch/other/model.h5"
for content in "$scratch/broken.json" "$data"; do
    cp "$content" "$scratch/other/eval.json"
    refused "an eval.json that is none (${content##*/})" 'other/eval.json: cannot be read as the evaluation of a model .*run tissuectl eval' "'tissue/Press-v0', model='$scratch/other/model.h5'"
done
cp "$scratch/known/eval.json" "$scratch/other/eval.json"
cp "$lump" "$scratch/other/model.h5"
check "the error of another model is not used, and a warning says why" "$agent" - "$scratch/other/model.h5" <<'PY'
import sys, warnings

import gymnasium
import tissue_gym
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    env = gymnasium.make("tissue/Press-v0", model=sys.argv[1])
assert "model_error_N" not in env.observation_space.spaces
assert any("eval.json: is of another model than" in str(w.message) for w in caught), [str(w.message) for w in caught]
PY
run "$agent" "$root/lib/api/examples/gym_agents.py" "$scratch/sets.h5"
check "the example with a model of spring sets prints one line" one_line '^gym_agents: .*sets.h5: has spring sets'
check "the example with a model of spring sets: exit 1" exited 1
run "$agent" "$root/lib/api/examples/gym_agents.py" "$known" cut
check "the example with an unknown task prints its usage and exits with 2" sh -c '[ "$1" = 2 ] && grep -q "press|follow|palpate" "$2"' - "$status" "$said"
finish
