// Whether untouched tissue is at rest. A mesh can be inverted, or in equilibrium away from rest.
import { HEURISTIC, LEARNED, is_solid, model, relaxes, state } from "./state.js";
import { largest } from "./vectors.js";

const AT_REST = 0.0005;   // m: largest displacement of a node that counts as rest
const STILL = 0.05;       // relative change of displacement between two checks that counts as still
const LOOKS = 3;          // successive checks

let seen = { of: null, far: [], still: 0 };

/** Largest displacement of a node of a mesh, m. */
export function farthest(m) {
  const at = state.nodes[m], d = model.dimension;
  return largest(model.meshes[m].nodes_m.map((p, i) => Math.hypot(...p.map((x, a) => at[d * i + a] - x))), 0);
}

/** In the plane, whether a triangle of a mesh is inverted. */
export function folded(m) {
  const mesh = model.meshes[m], at = state.nodes[m];
  if (is_solid() || !mesh.faces) return false;
  return mesh.faces.some(([i, j, k]) => (at[2 * j] - at[2 * i]) * (at[2 * k + 1] - at[2 * i + 1]) < (at[2 * k] - at[2 * i]) * (at[2 * j + 1] - at[2 * i + 1]));
}

/** Called a few times a second while nothing touches the tissue: "" at rest, else a text about its state. */
export function away_from_rest() {
  const far = model.meshes.map((_, m) => farthest(m));
  const same = seen.of === model && far.every((x, m) => Math.abs(x - seen.far[m]) <= Math.max(STILL * x, AT_REST / 5));
  seen = { of: model, far, still: same ? seen.still + 1 : 0 };
  const away = [LEARNED, HEURISTIC].filter(m => far[m] > AT_REST);
  if (away.length === 0) return "";
  const far_of = m => `${(1e3 * far[m]).toFixed(1)}\u00a0mm from rest`, of = m => `the ${model.meshes[m].name} mesh`;
  const bent = away.filter(folded);
  if (bent.length > 0) return `Nothing touches the tissue, but ${bent.map(m => `${of(m)} is inverted, ${far_of(m)}`).join(", and ")}. Reset puts it to rest.`;
  if (seen.still < LOOKS) return "Nothing touches the tissue; it returns to rest.";
  if (relaxes()) return `Nothing touches the tissue, which relaxes: ${away.map(m => `${of(m)} is still ${far_of(m)}`).join(", ")}. Reset puts it to rest.`;
  return `Nothing touches the tissue, but ${away.map(m => `${of(m)} is in equilibrium ${far_of(m)}`).join(", and ")}. Reset puts it to rest.`;
}
