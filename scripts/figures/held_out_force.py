"""Force against displacement at contacts of the test set, chosen by seed: FE, the trained model, springs of one stiffness."""
import matplotlib.pyplot as plt
import numpy as np

from results import COLOURS, learned_label, nothing, truth_label


def draw(results):
    curves = results.evaluation.get("drawn_curves")
    if not curves:
        return nothing("No contact of the test set has an FE reference")
    contacts = {c["name"]: c for c in results.evaluation["drawn"]["held_out"]}
    columns = min(3, len(curves))
    rows = -(-len(curves) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(3.7 * columns, 3 * rows), squeeze=False, layout="constrained")
    for axis, curve in zip(axes.flat, curves):
        x = np.array(curve["magnitude_m"]) * 1e3
        axis.plot(x, curve["fe_N"], color=COLOURS["fe"], linewidth=2.4, label=truth_label(results))
        axis.plot(x, curve["models_N"]["learned"], "o--", color=COLOURS["learned"], markersize=4, label=learned_label(results))
        if "uniform" in curve["models_N"]:
            axis.plot(x, curve["models_N"]["uniform"], ":", color=COLOURS["uniform"], linewidth=1.8, label="springs of one stiffness")
        contact = contacts[curve["name"]]
        axis.set_title(title_of(results, contact), fontsize=9)
        axis.set_xlim(left=0)
        axis.set_ylim(bottom=0)
        axis.set_xlabel("tool displacement (mm)")
        axis.set_ylabel("force along the displacement (N)")
    for axis in axes.flat[len(curves):]:
        axis.set_visible(False)
    axes[0, 0].legend(frameon=False, fontsize=8)
    figure.suptitle("Force against tool displacement at contacts of the test set")
    return figure


def title_of(results, contact):
    if results.solid:
        x, y, _ = 1e3 * np.array(contact["contact_m"])
        return f"at x = {x:.1f} mm, y = {y:.1f} mm,\n{round(contact['angle_deg'])} degrees from the normal"
    return f"{1e3 * contact['arc_m']:.1f} mm along the surface,\n{round(contact['angle_deg'])} degrees from the normal"
