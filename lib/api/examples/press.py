"""Presses a tissue, and draws what it feels like: press.py MODEL.h5 PICTURE.png

The force of a press that comes and goes, tick by tick; and the force of one and the same push all along the surface. Every step is a cell of a notebook."""
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import tissue

model_file, picture = sys.argv[1:]

# %% a model, and where its surface's top is
model = tissue.Model(model_file)
print(model)
low, high = model.nodes.min(axis=0), model.nodes.max(axis=0)
middle = (low + high) / 2
middle[-1] = high[-1]
depth = 0.05 * (high[-1] - low[-1])

# %% half a second down, half a second up: a thousand ticks
t = np.arange(1000) * 1e-3
height = 0.002 - (depth + 0.002) * np.sin(np.pi * t) ** 2   # from 2 mm above the tissue
positions = np.zeros((len(t), 3))
positions[:, :model.dimension] = middle
positions[:, model.dimension - 1] += height
session = tissue.Simulation(model)
force = session.ticks(positions)
assert force.any()
print(f"largest force {np.linalg.norm(force, axis=1).max():.3g} N, {session.counts['ticks']} ticks")

# %% at rest: the same push at thirty places along the top
along = np.linspace(low[0] + 0.1 * (high[0] - low[0]), high[0] - 0.1 * (high[0] - low[0]), 30)
contacts = np.tile(middle, (len(along), 1))
contacts[:, 0] = along
pushes = np.zeros_like(contacts)
pushes[:, -1] = -depth
rest, shape, why = model.press(contacts, pushes)
print(f"{sum(reason == '' for reason in why)} of {len(why)} pushes have a rest")

# %% a picture
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
left.plot(-1e3 * height, force[:, model.dimension - 1])
left.set(xlabel="depth of the device (mm)", ylabel="force on the hand (N)", title="a press of a second")
right.plot(1e3 * along, -rest[:, -1])
right.set(xlabel="place along the top (mm)", ylabel="force at rest (N)", title=f"a push of {1e3 * depth:.2g} mm", ylim=(0, None))
figure.savefig(picture, dpi=120)
