#!/usr/bin/env python3
"""MuJoCo's flex on the lattice of a solid block, or on an organ's own tetrahedra: the peer of a tick and of an
indentation in scripts/peers_study.py and peers_organ.py.

Equations: Saint Venant-Kirchhoff tetrahedra on the same nodes, five per box of a block; the study's Young's modulus and
           Poisson's ratio 0.45, because the solver reports no convergence nearer to 1/2. The bottom, or the fixed
           nodes, are pinned.
Contact:   a rigid cylinder of the disc's radius has the same displacement, within 0.15 s, and then rests. Friction is
           3, and contacts are as stiff as time steps of 1 ms allow. The cylinder also touches points between nodes, and
           so loads all nodes of a facet. Its force is the sum of MuJoCo's contact forces, averaged over the last 50 ms.
Method:    integrator `discrete`, MuJoCo's implicit one for flex; conjugate gradients; time steps of 1 ms, as a tick.

Reads {"size_m" and "counts" of a block, or "nodes", "tetrahedra", "held" (fixed nodes) and "outward" (unit normal of
each indentation), "modulus_Pa", "radius_m", "mass_kg", "pushes": [[contact], [displacement]], "seconds"} from standard
input; prints {"version", "step_us": [...], "force_N": [[x, y, z], ...]} as one line of JSON, for tetrahedra also
"displacement_m" of their nodes; null for an indentation that became unstable.
Sample run: scripts/peers_study.py calls it.
"""
import json
import sys
import time

import mujoco
import numpy as np

STEP_S, APPROACH_M, PUSH_S, HALF_HEIGHT_M, NODE_RADIUS_M = 1e-3, 5e-4, 0.15, 0.005, 5e-4

XML = """<mujoco>
 <option timestep="{step}" gravity="0 0 0" integrator="discrete" solver="CG" iterations="50" tolerance="1e-8"/>
 <size memory="200M"/>
 <worldbody>
  <flexcomp name="tissue" dim="3" {mesh} mass="{mass}" radius="{node}">
   <elasticity young="{young}" poisson="0.45" damping="0.01"/>
   <contact selfcollide="none" condim="4" friction="3" solref="0.002 1" solimp="0.99 0.9999 0.0001"/>
   <pin {pinned}/>
  </flexcomp>
  <body name="tool" mocap="true" pos="0 0 1"><geom type="cylinder" size="{radius} {half}" friction="3" solref="0.002 1" solimp="0.99 0.9999 0.0001"/></body>
 </worldbody>
</mujoco>"""


def words(values):
    return " ".join(f"{v:.9g}" for v in np.ravel(values))


def meshed(asked):
    """Attributes of flexcomp for the mesh, and of its pinned nodes."""
    if "nodes" in asked:
        return (f'type="direct" point="{words(asked["nodes"])}" element="{words(asked["tetrahedra"])}"', f'id="{words(asked["held"])}"')
    size, counts = np.array(asked["size_m"]), asked["counts"]
    return (f'type="grid" count="{words(counts)}" spacing="{words(size / (np.array(counts) - 1))}" pos="{words(size / 2)}"',
            f'gridrange="0 0 0 {counts[0] - 1} {counts[1] - 1} 0"')


def turned(outward):
    """Quaternion that rotates z to `outward`."""
    w = 1 + outward[2]
    quaternion = np.array([w, -outward[1], outward[0], 0]) if w > 1e-6 else np.array([0, 1, 0, 0])
    return quaternion / np.linalg.norm(quaternion)


def main():
    asked = json.load(sys.stdin)
    mesh, pinned = meshed(asked)
    model = mujoco.MjModel.from_xml_string(XML.format(step=STEP_S, mesh=mesh, pinned=pinned, mass=asked["mass_kg"], young=asked["modulus_Pa"],
                                                      radius=asked["radius_m"], half=HALF_HEIGHT_M, node=NODE_RADIUS_M))
    times, forces, displacements = [], [], []
    for i, (contact, push) in enumerate(asked["pushes"]):
        outward = np.array(asked["outward"][i] if "nodes" in asked else [0, 0, 1])
        data, force = mujoco.MjData(model), []
        for k in range(round(asked["seconds"] / STEP_S)):
            way = min(1, k * STEP_S / PUSH_S)
            data.mocap_pos[0] = np.array(contact) + way * np.array(push) + (HALF_HEIGHT_M + NODE_RADIUS_M + APPROACH_M * (1 - way)) * outward
            data.mocap_quat[0] = turned(outward)
            begin = time.perf_counter()
            mujoco.mj_step(model, data)
            times.append(1e6 * (time.perf_counter() - begin))
            total, one = np.zeros(3), np.zeros(6)
            for c in range(data.ncon):
                mujoco.mj_contactForce(model, data, c, one)
                total += data.contact[c].frame.reshape(3, 3).T @ one[:3]
            force.append(total)
        mean = np.mean(force[-50:], axis=0)
        # MuJoCo resets and continues if a position, velocity or acceleration is not finite
        lost = any(data.warning[kind].number > 0 for kind in (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC))
        forces.append(None if lost else (mean if mean @ np.array(push) > 0 else -mean).tolist())
        if "nodes" in asked:
            displacements.append(None if lost else (data.flexvert_xpos - asked["nodes"]).tolist())
    print(json.dumps({"version": mujoco.__version__, "step_us": times, "force_N": forces, "displacement_m": displacements}))


if __name__ == "__main__":
    main()
