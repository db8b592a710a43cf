"""Agents in the environments of tissue_gym: gym_agents.py MODEL.h5 [press|follow|palpate [EPISODES]]

A random agent and a scripted one on the same seeds. Prints for each the mean over episodes of the return, of the last
errors of force and of place, the part of episodes that end in success, and steps per second with the ratio of simulated
to real time. The scripted agents read observations alone, as a learned one would."""
import sys
import time

import gymnasium
import numpy as np
import tissue
import tissue_gym  # noqa: F401  registers the environments


class Random:
    def __init__(self, env):
        self.space = env.action_space

    def begin(self, seed):
        self.space.seed(seed)

    def act(self, seen):
        return self.space.sample()


class Scripted:
    """Moves in until it feels the tissue, then by the error of force over the stiffness felt so far."""

    def __init__(self, env):
        self.most = env.action_space.high
        self.reach_m = env.observation_space["position_m"].high[:-1]

    def begin(self, seed):
        self.script = self.search()
        next(self.script)

    def act(self, seen):
        return np.clip(self.script.send(seen), -self.most, self.most)

    def normal(self, seen, wanted_N):
        """Displacement along the normal [m] that brings the force a third nearer: the tissue has mass, and a whole one
        would make it swing."""
        depth_m, force_N = seen["position_m"][-1], seen["force_N"][-1]
        if depth_m < 5e-4 or force_N <= 0:
            return self.most[-1]
        return (wanted_N - force_N) * depth_m / force_N / 3

    def search(self):
        seen = yield
        while True:
            aside = seen.get("wanted_m", seen["position_m"][:-1]) - seen["position_m"][:-1]
            seen = yield np.append(aside, self.normal(seen, seen["wanted_N"][0]))


class Palpating(Scripted):
    """At a constant depth, drags along each tangent, the first one twice, and back to the place of the largest force."""

    depth_m = 0.004

    def search(self):
        seen = yield
        for axis in [*range(len(self.reach_m)), 0]:
            for to in (-0.8 * self.reach_m[axis], 0.8 * self.reach_m[axis]):
                felt = []   # places and forces of this way; the last one counts, which is the longer
                while abs(seen["position_m"][axis] - to) > 1e-6:
                    seen = yield self.to(seen, axis, to)
                    if seen["position_m"][-1] < 0.99 * self.depth_m:
                        continue
                    felt.append((seen["position_m"][axis], seen["force_N"][-1]))
                    if felt[-1][1] < 0.3 * np.median(felt, axis=0)[1]:   # over an edge of the tissue: lift, and go back
                        back = seen["position_m"][axis] - np.sign(to) * 0.006
                        while seen["position_m"][-1] > -5e-4:
                            seen = yield self.to(seen, axis, seen["position_m"][axis], -0.001)
                        while abs(seen["position_m"][axis] - back) > 1e-6:
                            seen = yield self.to(seen, axis, back, -0.001)
                        break
            place, force = np.array(felt[5:]).T   # after the turn
            best = place[2:-2][np.argmax(np.convolve(force, np.ones(5) / 5, "valid"))]
            while abs(seen["position_m"][axis] - best) > 1e-6:
                seen = yield self.to(seen, axis, best)
        while True:
            seen = yield np.zeros(len(self.most))

    def to(self, seen, axis, place, depth_m=depth_m):
        move = np.zeros(len(self.most))
        move[axis] = place - seen["position_m"][axis]
        move[-1] = depth_m - seen["position_m"][-1]
        return move


def play(env, agent, episodes):
    """Means over episodes of the scores, and steps per second."""
    scores, steps, begin = [], 0, time.perf_counter()
    for seed in range(episodes):
        seen, info = env.reset(seed=seed)
        agent.begin(seed)
        total, over = 0.0, False
        while not over:
            seen, reward, terminated, truncated, info = env.step(agent.act(seen))
            total, over, steps = total + reward, terminated or truncated, steps + 1
        scores.append((total, info.get("off_N", np.nan), info.get("off_m", np.nan), info["is_success"]))
    return np.mean(scores, axis=0), steps / (time.perf_counter() - begin)


def main():
    if not 2 <= len(sys.argv) <= 4 or sys.argv[2:3] and sys.argv[2] not in ("press", "follow", "palpate") or sys.argv[3:] and not sys.argv[3].isdecimal():
        print(__doc__.split("\n")[0], file=sys.stderr)
        return 2
    task, episodes = (sys.argv[2:] + ["press", "10"][len(sys.argv) - 2:])[:2]
    try:
        env = gymnasium.make(f"tissue/{task.capitalize()}-v0", model=sys.argv[1])
    except tissue.Error as e:
        print(f"gym_agents: {e}", file=sys.stderr)
        return 1
    step_s = env.reset(seed=0)[0]["time_s"][0]
    step_s = env.step(np.zeros(env.action_space.shape))[0]["time_s"][0] - step_s
    print("agent      return   force error   place error   success   steps/s   real time")
    for name, agent in (("random", Random(env)), ("scripted", Palpating(env) if task == "palpate" else Scripted(env))):
        (total, off_N, off_m, success), rate = play(env, agent, max(1, int(episodes)))
        cells = [f"{value:.3g} {unit}" if np.isfinite(value) else "-" for value, unit in ((off_N, "N"), (1e3 * off_m, "mm"))]
        print(f"{name:<9} {total:8.2f}   {cells[0]:>11}   {cells[1]:>11}   {100 * success:5.0f} %   {rate:7.0f}   x {rate * step_s:.3g}")
    return 0


sys.exit(main())
