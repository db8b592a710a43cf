"""Presses a tissue where its model was trained and plots the force: press.py MODEL.h5 PICTURE.png

A block or an organ, in the plane or in space. First the force of one indentation and release, tick by tick. Then the
force in equilibrium at the training contacts, with that of finite elements. Each step is a notebook cell."""
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import tissue

model_file, picture = sys.argv[1:]

# %% a model, and the load case with the largest tool displacement
model = tissue.Model(model_file)
print(model)
case = int(np.argmax(model.magnitude_m))
contact, direction, depth = model.contact_m[case], model.direction[case], model.magnitude_m[case]

# %% indent for half a second, release for half a second: a thousand ticks
t = np.arange(1000) * 1e-3
travel = (depth + 0.002) * np.sin(np.pi * t) ** 2 - 0.002   # starts 2 mm outside the tissue
positions = np.zeros((len(t), 3))
positions[:, :model.dimension] = contact + travel[:, None] * direction
session = tissue.Simulation(model, force_max=100)   # no device: only the tissue limits the force
force = session.ticks(positions)
assert force.any()
along = -force[:, :model.dimension] @ direction
print(f"largest force {np.linalg.norm(force, axis=1).max():.3g} N at {1e3 * depth:.3g} mm, {session.counts['ticks']} ticks")

# %% in equilibrium, at thirty of the training contacts: how much of the force of finite elements
cases = np.unique(np.linspace(0, len(model.magnitude_m) - 1, 30).astype(int))
pressed, rest = [], []
for case in cases:
    try:
        one, shape, why = model.press([model.contact_m[case]], [model.magnitude_m[case] * model.direction[case]])
    except tissue.Error:   # at an edge a tool displacement may point out of the tissue on its other side
        continue
    if not why[0]:
        pressed.append(case)
        rest.append(one[0])
print(f"{len(pressed)} of {len(cases)} tool displacements have an equilibrium")
rest, fe = np.array(rest), model.fe_force_N
fe = fe[pressed] if len(fe) else np.full_like(rest, np.nan)   # a file may have none
error = np.linalg.norm(rest - fe, axis=1) / np.linalg.norm(fe, axis=1)
if np.isfinite(error).any():
    print(f"error of force on training contacts, median {100 * np.nanmedian(error):.2g} %")

# %% plot
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
left.plot(1e3 * travel, along)
left.set(xlabel="tool displacement (mm)", ylabel="force along it (N)", title="an indentation of a second")
right.plot(np.linalg.norm(fe, axis=1), np.linalg.norm(rest, axis=1), ".")
right.axline((0, 0), slope=1, color="0.7", lw=1)
right.set(xlabel="force of finite elements (N)", ylabel="force of the model (N)", title="training contacts in equilibrium")
figure.savefig(picture, dpi=120)
