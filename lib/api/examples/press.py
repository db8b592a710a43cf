"""Indents a tissue and plots the force: press.py MODEL.h5 PICTURE.png

First the force of one indentation and release, tick by tick. Then the force at rest of equal indentations along the
surface. Each step is a notebook cell."""
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import tissue

model_file, picture = sys.argv[1:]

# %% a model and the top of its surface
model = tissue.Model(model_file)
print(model)
low, high = model.nodes.min(axis=0), model.nodes.max(axis=0)
middle = (low + high) / 2
middle[-1] = high[-1]
depth = 0.05 * (high[-1] - low[-1])

# %% indent for half a second, release for half a second: a thousand ticks
t = np.arange(1000) * 1e-3
height = 0.002 - (depth + 0.002) * np.sin(np.pi * t) ** 2   # starts 2 mm above the tissue
positions = np.zeros((len(t), 3))
positions[:, :model.dimension] = middle
positions[:, model.dimension - 1] += height
session = tissue.Simulation(model)
force = session.ticks(positions)
assert force.any()
print(f"largest force {np.linalg.norm(force, axis=1).max():.3g} N, {session.counts['ticks']} ticks")

# %% in equilibrium: the same tool displacement at thirty places along the top
along = np.linspace(low[0] + 0.1 * (high[0] - low[0]), high[0] - 0.1 * (high[0] - low[0]), 30)
contacts = np.tile(middle, (len(along), 1))
contacts[:, 0] = along
pushes = np.zeros_like(contacts)
pushes[:, -1] = -depth
rest, shape, why = model.press(contacts, pushes)
print(f"{sum(reason == '' for reason in why)} of {len(why)} pushes have a rest")

# %% plot
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
left.plot(-1e3 * height, force[:, model.dimension - 1])
left.set(xlabel="depth of the device (mm)", ylabel="force on the hand (N)", title="a press of a second")
right.plot(1e3 * along, -rest[:, -1])
right.set(xlabel="place along the top (mm)", ylabel="force at rest (N)", title=f"a push of {1e3 * depth:.2g} mm", ylim=(0, None))
figure.savefig(picture, dpi=120)
