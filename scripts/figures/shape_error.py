"""Displacement error against force error at every contact of the test set, for each model."""
import numpy as np

from results import COLOURS, LABELS, learned_label

SHOWN = {"uniform": LABELS["uniform"], "heuristic_a": LABELS["heuristic_a"]}
SHOWN_OF_SOLIDS = {"uniform_patch": "springs of one stiffness alone", "heuristic_a_patch": "Van Gelder's springs alone",
                   "untrained": "untrained model"}


def percent(value):
    return f"{100 * value:.1f} %"


def which_of(shape, contacts):
    """Rank of a contact of drawn_shapes in the test set. A missing answer counts as the largest error."""
    answered = sum(c["shape"].get("learned") is not None for c in contacts.values())
    of = "" if answered == len(contacts) or shape["which"] == "median" else f" of the {answered} of {len(contacts)} that have an answer"
    return f"{shape['which'].capitalize()} displacement error{of}"


def percent_axis(axis, between=True):
    """Percent labels of a logarithmic axis: 10 %, and between the decades 20 % and 50 %, since the data may span only
    one decade."""
    axis.set_major_formatter(lambda v, _: f"{100 * v:g} %")
    axis.set_minor_formatter(lambda v, _: f"{100 * v:g} %" if between and f"{v:.0e}"[0] in "25" else "")


def force_and_shape(errors, results, contacts, shapes):
    """Displacement error against force error at every contact of the test set; a ring marks those of drawn_shapes."""
    if not contacts:
        return errors.set_visible(False)
    models = {**(SHOWN_OF_SOLIDS if results.solid else SHOWN), "learned": learned_label(results)}
    for model, label in models.items():
        both = np.array([(c["error"][model], c["shape"][model]) for c in contacts.values()
                         if c["shape"].get(model) is not None])
        if len(both):
            errors.scatter(*both.T, s=16 if model == "learned" else 8, color=COLOURS[model.removesuffix("_patch")], alpha=0.8, linewidths=0, label=f"{label} ({len(both)} of {results.evaluation['closed_loop']['held_out'][model]['of']})")
    shown = [contacts[shape["name"]] for shape in shapes]
    errors.scatter([c["error"]["learned"] for c in shown], [c["shape"]["learned"] for c in shown], s=70,
                   facecolors="none", edgecolors="black", label="the contacts on the left")
    errors.set_xscale("log")
    errors.set_yscale("log")
    for axis in (errors.xaxis, errors.yaxis):
        percent_axis(axis)
    errors.tick_params(axis="both", which="minor", labelsize=7)
    errors.set_xlabel("indentation error of force")
    errors.set_ylabel("indentation error of displacement: rms of u - u_fe over rms of u_fe")
    errors.grid(color="0.9")
    errors.legend(frameon=False, fontsize=8)
    errors.set_title("All contacts of the test set", fontsize=10)
