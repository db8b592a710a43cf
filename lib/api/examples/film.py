"""Films an indentation: film.py MODEL.h5 FILM [SECONDS]

FILM ends in .gif or .webp, which Pillow writes, or in .mp4, for which ffmpeg must be installed. The tool presses the
contact of the load case with the largest displacement, and comes back. Nodes are drawn with their displacement in mm;
the title has time and force. 25 frames a second, 40 ticks each."""
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import tissue
from matplotlib import animation
from matplotlib.collections import LineCollection
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

model_file, film = sys.argv[1:3]
seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 2.0
writer = "ffmpeg" if Path(film).suffix == ".mp4" else "pillow"
if Path(film).suffix not in (".gif", ".webp", ".mp4") or not animation.writers.is_available(writer):
    sys.exit(f"film: {film}: name a .gif or .webp, or install ffmpeg and name an .mp4")

model = tissue.Model(model_file)
session = tissue.Simulation(model, force_max=100)   # no device: only the tissue limits the force
case = int(np.argmax(model.magnitude_m))
t = np.arange(round(seconds * 25) * 40) * 1e-3
travel = (model.magnitude_m[case] + 0.002) * np.sin(np.pi * t / seconds) ** 2 - 0.002
way = np.zeros((len(t), 3))
way[:, :model.dimension] = model.contact_m[case] + travel[:, None] * model.direction[case]

figure = plt.figure(figsize=(5, 4.2), layout="constrained")
colours = dict(cmap="viridis", norm=plt.Normalize(0, 1e3 * model.magnitude_m[case]))
if model.dimension == 3:
    axes = figure.add_subplot(projection="3d")
    drawn = axes.add_collection3d(Poly3DCollection(1e3 * model.nodes[model.facets], edgecolor="0.4", lw=0.2, **colours))
    axes.set_box_aspect(np.ptp(model.nodes[model.facets], axis=(0, 1)))
    pieces = model.facets
else:
    axes = figure.add_subplot(aspect="equal")
    drawn = axes.add_collection(LineCollection(1e3 * model.nodes[model.springs], **colours))
    pieces = model.springs
low, high = (1e3 * f(model.nodes[model.facets], axis=(0, 1)) for f in (np.min, np.max))
limits = dict(zip(("xlim", "ylim", "zlim"), np.transpose([low - 5, high + 5])))
axes.set(xlabel="x (mm)", ylabel="y (mm)", **limits)
tool, = axes.plot(*[[x] for x in 1e3 * way[0, :model.dimension]], "o", color="tab:red")
figure.colorbar(drawn, label="displacement (mm)", shrink=0.7)
largest = 0.0


def frame(number):
    global largest
    force = session.ticks(way[40 * number:40 * (number + 1)])[-1]
    largest = max(largest, np.linalg.norm(force))
    place = 1e3 * (model.nodes + session.seen_m)
    (drawn.set_verts if model.dimension == 3 else drawn.set_segments)(place[pieces])
    drawn.set_array(1e3 * np.linalg.norm(session.seen_m, axis=1)[pieces].mean(axis=1))
    tool.set_data(*[[x] for x in 1e3 * way[40 * number, :2]])
    if model.dimension == 3:
        tool.set_3d_properties([1e3 * way[40 * number, 2]])
    axes.set_title(f"{model.study}: {0.04 * number:.2f} s, {np.linalg.norm(force):.3f} N")


# matplotlib draws the first frame once more before it writes: it must not tick
frames = animation.FuncAnimation(figure, frame, frames=len(t) // 40, init_func=lambda: None)
frames.save(film, writer=writer, fps=25, dpi=80)
print(f"{film}: {len(t) // 40} frames, {session.counts['ticks']} ticks, largest force {largest:.3g} N")
