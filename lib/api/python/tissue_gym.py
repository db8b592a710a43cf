"""Gymnasium environments over `import tissue`: an agent moves a tool on a tissue and observes the force.

    import gymnasium, tissue_gym
    env = gymnasium.make("tissue/Press-v0", model="results/nodule3/model.h5")
    envs = gymnasium.make_vec("tissue_gym:tissue/Follow-v0", num_envs=8, model="results/nodule3/model.h5")

    tissue/Press-v0     reach a force and keep it
    tissue/Follow-v0    follow a force over time while the tool moves along the surface
    tissue/Palpate-v0   find a stiff inclusion. The model has one (a study with a nodule), or has learned a field of
                        stiffness (tissuectl adapt) that is stiff somewhere.

Frame. An episode starts at the contact of a training load case, drawn with the seed of reset(). All vectors have D
numbers, D = 2 or 3 axes of the model, in a frame with its origin at that contact: first the D - 1 tangents of the
surface, turned about the normal by a drawn angle (in the plane: drawn sign), last the normal into the tissue. A tool
with a last coordinate below 0 is outside. info has the position in the axes of the tissue too.

Action (D): displacement of the tool in one step [m], each number within +-step_max_m (default 0.0005); larger ones are
limited to that. A step takes step_s (default 0.02 s), in which the tool moves evenly, one tick of 1 ms after another.
The tool stays within reach_m of the origin along each tangent, 1 mm outside the tissue, and inside to the depth to
which the contact was trained.

Observation, a dict of float64 arrays:
    force_N (D)         force of the tool on the tissue [N]
    model_error_N (1)   error of that force [N]: the p95 of the model's relative error on the contacts of its test set
                        (closed_loop.held_out.learned.p95 of the eval.json beside the model), times the force. The test
                        is of single indentations in equilibrium: a tool that drags, and one on a target tissue that a
                        model was adapted to, were not part of it. Absent where no error is known: there is no
                        eval.json, or it is of another model (a warning). model_error=0.02 sets it by hand.
    position_m (D)      the tool [m]
    time_s (1)          since reset [s]
    wanted_N (1)        Press: force along the normal to reach [N]; Follow: that at the end of the next step
    wanted_m (D - 1)    Follow: place along the tangents at the end of the next step [m]

Reward of a step, always 0 or less:
    Press     -off_N / wanted_N. Terminates after ten steps with off_N within 2 % of wanted_N
    Follow    -off_N / mean_N - off_m / 0.005, mean_N the mean of the force profile
    Palpate   0, and after the last step -off_m / reach_m, off_m the distance along the tangents from the tool to the
              centre of the inclusion: where the tool is then is the answer
off_N [N] and off_m [m] are in info, as are status (of the last tick), is_success, normal_N (force along the normal),
wanted_N and position_m (D, axes of the tissue). An episode is truncated after `steps`. It terminates where the tissue
has no force to give (folded, diverged, or a refused position), and where the tool displaces the tissue by more than 1.5
times the deepest displacement of the training ("beyond training"), as past an edge; each step that is left then counts
as -1, so that no agent gains by it.

Further arguments: render_mode "rgb_array" draws the section through the tool (needs matplotlib); others are options of
tissue.Simulation by name, as friction (default 0.3 here, so that the tool can slide) or tool. force_max is three times
the largest FE force of the training here, and bounds the force on the tissue.

Errors are tissue.Error, one line. Environments of one file in one process share what is constant.
"""
import functools
import json
import math
import os
from pathlib import Path

import gymnasium
import numpy as np
import tissue
from gymnasium import spaces

CLEARANCE_M = 0.001          # of the start above the surface, so that the session sees the tool outside first
NEAR_NORMAL = math.cos(math.radians(35))  # trained direction within 35 degrees of the normal: the contact was pressed
INCLUSION = 1.2              # least stiffness of a learned field's stiffest place over its median
BEYOND = 1.5                 # largest displacement of the tissue under the tool, over the deepest of the training
SLIDING_M = 0.005            # Follow: an error of place that costs as much as one of force of the mean


def centre_of(points, triangles):
    """Centre (3) of the volume in a closed surface: points (V, 3), triangles (W, 3)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))  # of the tetrahedra to the origin, times 6
    return (volume[:, None] * (a + b + c)).sum(axis=0) / (4 * volume.sum())


class _Tissue:
    """What is constant of a model's file and options, shared by environments: sessions begin from it."""

    def __init__(self, file, options):
        self.file, self.model = file, tissue.Model(file)
        if not self.model.is_law:
            raise tissue.Error(f"{file}: has spring sets, and an environment needs an energy model: train a study with springs.terms, such as surface-quick")
        self.starts = list(self._starts())
        if not self.starts:
            raise tissue.Error(f"{file}: has no training load case that presses within 35 degrees of the normal, where an episode could start")
        self.depth_m = max(depth for _, _, depth in self.starts)
        largest = float(np.linalg.norm(self.model.fe_force_N, axis=1).max(initial=0))
        options = {"friction": 0.3, "force_max": 3 * largest or 10.0, **options}
        self.session = tissue.Simulation(self.model, **options)   # refuses values that are no numbers
        self.force_max_N = float(options["force_max"]) / float(options.get("force_scale", 1))
        self.dt_s = float(options.get("dt", 1e-3))
        self.press = functools.lru_cache(maxsize=None)(self._press)

    def _starts(self):
        """(contact, normal into the tissue, trained depth) of every contact that was pressed."""
        nodes, facets = self.model.nodes, self.model.facets
        corner = nodes[facets]
        if self.model.dimension == 2:  # the tissue is on the left of a segment
            along = corner[:, 1] - corner[:, 0]
            inward = np.column_stack([-along[:, 1], along[:, 0]])
        else:
            inward = -np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        inward /= np.linalg.norm(inward, axis=1, keepdims=True)
        middle = corner.mean(axis=1)
        for contact in np.unique(self.model.contact_m, axis=0):
            normal = inward[np.argmin(np.linalg.norm(middle - contact, axis=1))]
            here = (self.model.contact_m == contact).all(axis=1) & (self.model.direction @ normal > NEAR_NORMAL)
            if here.any():
                yield contact, normal, float(self.model.magnitude_m[here].max())

    def _press(self, start, part):
        """Force along the normal [N] at this part of the trained depth, in equilibrium; None without one."""
        contact, normal, depth_m = self.starts[start]
        force, _, why = self.model.press([contact], [part * depth_m * normal], threads=1)
        return None if why[0] else float(force[0] @ normal)

    def known_error(self):
        """The model's relative error on its test set, p95 (closed_loop.held_out.learned.p95); None: not known."""
        file = Path(self.file).parent / "eval.json"
        if not file.exists():
            return None
        try:
            told = json.loads(file.read_bytes())
            if told["model_hash"] != tissue.file_hash(self.file):
                gymnasium.logger.warn(f"{file}: is of another model than {self.file}, so observations have no model_error_N: run tissuectl eval again, or pass model_error")
                return None
            p95 = told["closed_loop"]["held_out"]["learned"]["p95"]
            return None if p95 is None else float(p95)
        except (OSError, ValueError, KeyError, TypeError) as e:
            raise tissue.Error(f"{file}: cannot be read as the evaluation of a model ({type(e).__name__}: {e}): run tissuectl eval again, or pass model_error".replace("\n", " ")) from None

    @functools.cached_property
    def inclusion_m(self):
        """Centre of the inclusion at rest [m] (D): of the nodule, else of the stiff part of a learned field."""
        if "nodule" in self.session.surfaces:
            return centre_of(*self.session.surface("nodule"))
        nothing = f"{self.file}: has no inclusion to find"
        adaptation = tissue.Adaptation(self.file)
        if not adaptation.learned:
            raise tissue.Error(f"{nothing}: take a model whose study has a nodule, or one that tissuectl adapt made")
        stiffness = np.log(adaptation.factor)
        if len(stiffness) != len(self.model.nodes):
            raise tissue.Error(f"{nothing}: it has learned other unknowns than a field of stiffness over its nodes")
        stiffness = stiffness - np.median(stiffness)
        if stiffness.max() < math.log(INCLUSION):
            raise tissue.Error(f"{nothing}: the stiffest place of its learned field is {np.exp(stiffness.max()):.3g} times as stiff as the median, less than {INCLUSION}")
        weight = np.clip(stiffness - stiffness.max() / 2, 0, None)
        return weight @ self.model.nodes / weight.sum()


@functools.lru_cache(maxsize=8)
def _opened(file, _written, options):
    return _Tissue(file, dict(options))


def _tissue_of(model, options):
    try:
        file = os.path.realpath(os.fsdecode(model))
        there = os.stat(file)
        written = (there.st_mtime_ns, there.st_size, there.st_ino)
    except OSError:
        written = None  # tissue.Model names the fault
    except TypeError:
        raise tissue.Error(f"model must be the name of a model.h5, not {model!r}") from None
    for name, value in options.items():
        if not isinstance(value, (str, bool, int, float)):
            raise tissue.Error(f"option {name} must be a text, a number or a bool, not {value!r}")
    return _opened(file, written, tuple(sorted(options.items())))


class _Env(gymnasium.Env):
    """A task's parts are draw(), aim() and judge()."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 50}
    steps, reach_m = 100, 0.02
    wants = ()   # names of further observations

    def __init__(self, model, *, step_s=0.02, step_max_m=0.0005, steps=None, reach_m=None, model_error=None, render_mode=None, **options):
        self._tissue = _tissue_of(model, options)
        self.steps, self.reach_m = self.steps if steps is None else steps, self.reach_m if reach_m is None else reach_m
        if not (isinstance(self.steps, (int, np.integer)) and self.steps >= 2):
            raise tissue.Error(f"steps must be a whole number from 2 on, not {self.steps!r}")
        if not 0 < self.reach_m < math.inf:
            raise tissue.Error(f"reach_m must be a length above 0, not {self.reach_m!r}")
        if not self._tissue.dt_s <= step_s <= 10:
            raise tissue.Error(f"step_s must be from dt, {self._tissue.dt_s:g} s, to 10 s, not {step_s!r}")
        D = self._tissue.model.dimension
        if not 0 < step_max_m * math.sqrt(D) / step_s <= 0.5:
            raise tissue.Error(f"step_max_m must be above 0 and at most {0.5 * step_s / math.sqrt(D):.3g} m, 0.5 m/s for step_s, not {step_max_m!r}")
        if model_error is not None and not 0 <= model_error < math.inf:
            raise tissue.Error(f"model_error must be a relative error, 0 or more, not {model_error!r}")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise tissue.Error(f"render_mode must be None or rgb_array, not {render_mode!r}")
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": max(1, round(1 / step_s))}
        self._ticks = max(1, round(step_s / self._tissue.dt_s))
        self._step_s, self._step_max_m = self._ticks * self._tissue.dt_s, float(step_max_m)
        self._error = self._tissue.known_error() if model_error is None else float(model_error)
        self._session = None

        def box(low, high, size):
            return spaces.Box(np.full(size, low), np.full(size, high), dtype=np.float64)
        force_N = 1.001 * self._tissue.force_max_N   # rounding
        tool = box(-self.reach_m, self.reach_m, D)
        tool.low[-1], tool.high[-1] = -CLEARANCE_M, self._tissue.depth_m
        self.action_space = box(-self._step_max_m, self._step_max_m, D)
        seen = {"force_N": box(-force_N, force_N, D), "position_m": spaces.Box(tool.low, tool.high, dtype=np.float64),
                "time_s": box(0, self._step_s * self.steps * (1 + 1e-9), 1)}
        if self._error is not None:
            seen["model_error_N"] = box(0, max(self._error, 1e-300) * force_N, 1)
        if "wanted_N" in self.wants:
            seen["wanted_N"] = box(0, force_N, 1)
        if "wanted_m" in self.wants:
            seen["wanted_m"] = box(-self.reach_m, self.reach_m, D - 1)
        self.observation_space = spaces.Dict(seen)

    def draw(self):
        """The start of this episode: an index of starts, and a wanted direction of the first tangent, or None."""
        return int(self.np_random.integers(len(self._tissue.starts))), None

    def aim(self):
        """Sets what is wanted at the end of the next step."""

    def judge(self, off_N):
        """Reward of the step that has ended, whether the episode terminates, is_success, and further info."""
        raise NotImplementedError

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self._start, along = self.draw()
        self._contact, normal, self._depth_m = self._tissue.starts[self._start]
        self._axes = self._frame(normal, along)
        self._session = self._tissue.session.begin()
        self._count = self._kept = 0
        self._over = False
        self._wanted_N, self._wanted_m = 0.0, np.zeros(len(normal) - 1)
        self._place = np.zeros(len(normal))
        self._place[-1] = -CLEARANCE_M
        self._session.tick(self._device(self._place))
        self._read()
        self.begin()
        self.aim()
        return self._observed(), self._info()

    def begin(self):
        """Draws what the task needs, once the frame and the start are known."""

    def _frame(self, normal, along):
        """Rows: tangents, then the normal."""
        if len(normal) == 2:
            tangent = np.array([-normal[1], normal[0]])
            sign = self.np_random.choice([-1.0, 1.0]) if along is None else (1.0 if tangent @ along >= 0 else -1.0)
            return np.array([sign * tangent, normal])
        first = np.eye(3)[np.argmin(np.abs(normal))] if along is None else along
        first = first - (first @ normal) * normal
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        if along is None:
            angle = self.np_random.uniform(0, 2 * np.pi)
            first, second = np.cos(angle) * first + np.sin(angle) * second, np.cos(angle) * second - np.sin(angle) * first
        return np.array([first, second, normal])

    def _device(self, place):
        """The device's position of a place in the frame: three numbers."""
        at = np.zeros((*place.shape[:-1], 3))
        at[..., :place.shape[-1]] = self._contact + place @ self._axes
        return at

    def _read(self):
        contact = self._session.contact
        self._status = contact["status"]
        touches = contact["mesh"] >= 0
        if touches and np.linalg.norm(contact["displacement_m"]) > BEYOND * self._tissue.depth_m:
            self._status = "beyond training"
        force = self._axes @ contact["force_N"] if touches else np.zeros(len(self._axes))
        self._force_N = np.clip(force, -self._tissue.force_max_N, self._tissue.force_max_N)

    def _observed(self):
        seen = {"force_N": self._force_N.copy(), "position_m": self._place.copy(), "time_s": np.array([self._count * self._step_s])}
        if self._error is not None:
            seen["model_error_N"] = np.minimum([self._error * np.linalg.norm(self._force_N)], self.observation_space["model_error_N"].high)
        if "wanted_N" in self.wants:
            seen["wanted_N"] = np.array([self._wanted_N])
        if "wanted_m" in self.wants:
            seen["wanted_m"] = self._wanted_m.copy()
        return seen

    def _info(self, **more):
        info = {"status": self._status, "is_success": False, "normal_N": float(self._force_N[-1]), "position_m": self._device(self._place)[:len(self._axes)], **more}
        if "wanted_N" in self.wants:
            info["wanted_N"] = self._wanted_N
        return info

    def step(self, action):
        if self._session is None or self._over:
            raise tissue.Error("step() after the end of an episode or before the first: call reset()")
        action = np.asarray(action, dtype=np.float64)
        if action.shape != self.action_space.shape or not np.isfinite(action).all():
            raise tissue.Error(f"an action must be {len(self._axes)} finite numbers, displacements in m, not {action.tolist()}")
        low, high = np.full(len(action), -self.reach_m), np.full(len(action), self.reach_m)
        low[-1], high[-1] = -CLEARANCE_M, self._depth_m
        to = np.clip(self._place + np.clip(action, self.action_space.low, self.action_space.high), low, high)
        part = np.arange(1, self._ticks + 1)[:, None] / self._ticks
        self._session.ticks(self._device(self._place + part * (to - self._place)))
        self._place = to
        self._count += 1
        self._read()
        off_N = abs(self._force_N[-1] - self._wanted_N)
        reward, terminated, success, more = self.judge(off_N)
        if self._status not in ("done", "late", "overrun"):
            reward, terminated, success = -1.0 - (self.steps - self._count), True, False
        truncated = not terminated and self._count >= self.steps
        info = self._info(**more)   # of the step that has ended
        info["is_success"] = bool(success)
        self._over = terminated or truncated
        self.aim()
        return self._observed(), float(reward), terminated, truncated, info

    def render(self):
        """(400 x 500 x 3) uint8: surface near the section through the tool, along the first tangent and the normal, mm."""
        if self.render_mode is None:
            gymnasium.logger.warn("render() without render_mode: pass render_mode='rgb_array' to make()")
            return None
        if self._session is None:
            raise tissue.Error("render() before the first episode: call reset()")
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import LineCollection
        from matplotlib.figure import Figure
        figure = Figure(figsize=(5, 4), dpi=100, layout="constrained")
        canvas, plot = FigureCanvasAgg(figure), figure.add_subplot()
        model = self._tissue.model
        corner = 1e3 * ((model.nodes + self._session.seen_m)[model.facets] - self._contact) @ self._axes.T
        if model.dimension == 3:
            size = np.linalg.norm(corner[:, 1] - corner[:, 0], axis=1).max()
            corner = corner[np.abs(corner[:, :, 1] - 1e3 * self._place[1]).min(axis=1) < size]
        loops = corner[:, [*range(model.dimension), 0]] if model.dimension == 3 else corner
        plot.add_collection(LineCollection(loops[:, :, [0, -1]], colors="0.4", linewidths=0.8))
        at = 1e3 * self._place[[0, -1]]
        plot.plot(*at, "o", color="#0072B2")
        push = self._force_N[[0, -1]] / self._tissue.force_max_N * 30
        plot.annotate("", at + push, at, arrowprops={"arrowstyle": "->", "color": "#D55E00"})
        side = 1.5e3 * self.reach_m
        plot.set(xlim=(-side, side), ylim=(1.2 * side, -0.4 * side), aspect="equal", xlabel="along the surface (mm)", ylabel="into the tissue (mm)",
                 title=f"{self._count * self._step_s:.2f} s, {np.linalg.norm(self._force_N):.3g} N")
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()

    def close(self):
        self._session = None


class Press(_Env):
    """Reach the force wanted_N [N] along the normal and keep it; see the module."""

    wants = ("wanted_N",)

    def begin(self):
        part = self.np_random.uniform(0.3, 0.9)
        # in equilibrium at nine tenths of the trained depth: what is wanted below it is always possible
        most_N = self._tissue.press(self._start, 0.9)
        if not most_N or most_N <= 0:
            raise tissue.Error(f"{self._tissue.file}: the model has no equilibrium at its trained contact {self._contact.tolist()}")
        self._wanted_N = min(part / 0.9 * most_N, self._tissue.force_max_N)

    def judge(self, off_N):
        near = off_N <= 0.02 * self._wanted_N
        self._kept = self._kept + 1 if near else 0
        return -off_N / self._wanted_N, self._kept >= 10, self._kept >= 10, {"off_N": float(off_N)}


class Follow(_Env):
    """Follow wanted_N(t) [N] along the normal while wanted_m(t) moves at 5 mm/s to the middle of the tissue.

    wanted_N(t) = mean_N min(1, t / 0.5 s) (1 + 0.3 sin(2 pi 0.5 Hz t + phase)), phase drawn; mean_N is the force at half
    of the trained depth."""

    wants = ("wanted_N", "wanted_m")
    steps = 150

    def draw(self):
        start = int(self.np_random.integers(len(self._tissue.starts)))
        contact, normal, _ = self._tissue.starts[start]
        along = np.mean([c for c, n, _ in self._tissue.starts if n @ normal > NEAR_NORMAL], axis=0) - contact
        along = along - (along @ normal) * normal
        return start, along if np.linalg.norm(along) > 1e-6 else None

    def begin(self):
        self._mean_N = self._tissue.press(self._start, 0.5)
        if not self._mean_N or self._mean_N <= 0:
            raise tissue.Error(f"{self._tissue.file}: the model has no equilibrium at its trained contact {self._contact.tolist()}")
        self._phase = self.np_random.uniform(0, 2 * np.pi)

    def aim(self):
        time = (self._count + 1) * self._step_s
        swing = 1 + 0.3 * math.sin(math.pi * time + self._phase)
        self._wanted_N = min(self._mean_N * min(1.0, time / 0.5) * swing, self._tissue.force_max_N)
        self._wanted_m = np.zeros(len(self._axes) - 1)
        self._wanted_m[0] = min(0.005 * time, self.reach_m)

    def judge(self, off_N):
        off_m = float(np.linalg.norm(self._place[:-1] - self._wanted_m))
        return -off_N / self._mean_N - off_m / SLIDING_M, False, off_N <= 0.1 * self._mean_N and off_m <= 0.001, {"off_N": float(off_N), "off_m": off_m}


class Palpate(_Env):
    """Find the inclusion: end with the tool above its centre; see the module. is_success: within a quarter of reach_m."""

    steps, reach_m = 600, 0.03

    def __init__(self, model, **arguments):
        super().__init__(model, **arguments)
        beside = {k: float((self._tissue.inclusion_m - contact) @ normal) for k, (contact, normal, _) in enumerate(self._tissue.starts)
                  if 0.2 * self.reach_m <= self._aside(contact, normal) <= 0.7 * self.reach_m}
        # of several sides of the tissue that on which it is nearest, where its depth is given to 5 mm at best
        self._near = [k for k, depth_m in beside.items() if depth_m <= 1.5 * max(min(beside.values()), 0.005)]
        if not self._near:
            raise tissue.Error(f"{self._tissue.file}: no contact of the training is from 0.2 to 0.7 times reach_m, {self.reach_m:g} m, beside the inclusion at {self._tissue.inclusion_m.round(4).tolist()}")

    def _aside(self, contact, normal):
        away = self._tissue.inclusion_m - contact
        return float(np.linalg.norm(away - (away @ normal) * normal))

    def draw(self):
        return int(self.np_random.choice(self._near)), None

    def judge(self, off_N):
        off_m = self._aside(self._contact + self._place @ self._axes, self._axes[-1])
        return -off_m / self.reach_m if self._count >= self.steps else 0.0, False, off_m <= self.reach_m / 4, {"off_m": off_m}


for _task in (Press, Follow, Palpate):
    gymnasium.register(f"tissue/{_task.__name__}-v0", entry_point=f"{__name__}:{_task.__name__}")
