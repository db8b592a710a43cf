// FE force under the present indentation, state by state. The FE force at a mesh's depth is instantaneous. If the model
// relaxes, that force is passed through the Maxwell branches, which is valid for one lasting contact with fully relaxed
// tissue. Forces that remain from earlier indentations are followed as a bound.
import { force_of, later, nothing_felt, sum } from "./branches.js";
import { NEAR, SHALLOW, contact_at_rest, fe_curve, on_curve } from "./compare.js";
import { IN, model, samples, state } from "./state.js";
import { add, dot, norm } from "./vectors.js";

const LEFT = 0.02;      // of the largest force of the indentation: a smaller remaining force counts as 0
const FARTHEST = 1.2;   // times the deepest FE depth: extrapolation up to there, for the branches only
const GAP = 0.2;        // s: after a longer time without states, unseen indentations are possible

let known = null;   // {of: model, time, rested, pressed, meshes: [{felt, left, unsolved, largest, fe_N, unknown}]}

/** Instantaneous FE force along a displacement u at the contact of place k [N]. shown: within the FE depths, else NaN;
 *  felt: input of the branches, null if unknown. */
function at_once(k, u) {
  const place = model.places[k], none = { shown: NaN, felt: null };
  if (!place || !place.curve.length || !(norm(add(place.contact_m, contact_at_rest(), -1)) <= NEAR)) return none;
  const depth = norm(u), shallow = depth < SHALLOW;   // a very small displacement has no definite direction
  const curve = shallow ? place.curve : fe_curve(k, u), along = shallow ? Math.max(0, dot(u, place.direction)) : depth;
  if (!curve) return none;
  const shown = on_curve(curve, along), [[d0, f0], [d1, f1]] = curve.slice(-2);
  if (Number.isFinite(shown)) return { shown, felt: shown };
  return { shown: NaN, felt: along <= FARTHEST * d1 ? f0 + (f1 - f0) * (along - d0) / (d1 - d0) : null };
}

const unpressed = left => ({ felt: nothing_felt(model.relaxation), left, unsolved: left.map(() => 0), largest: 0, fe_N: 0, unknown: "" });

/** Advances one mesh to the next state. left, unsolved: bounds of the force in each branch [N] that remains from before
 *  this indentation, and from its parts without FE reference. unknown: "" or the word for a missing FE force. */
function on(mesh, dt, sample, m) {
  const { share, tau_s } = model.relaxation, faded = parts => parts.map((part, k) => part * Math.exp(-dt / tau_s[k]));
  let left = faded(mesh.left), unsolved = faded(mesh.unsolved);
  // after release a part stays in the branches; under the second tool, an unknown part, at most of the strongest force
  if (!sample.pressed) {
    const parts = later(model.relaxation, mesh.felt, dt, 0).parts;
    return unpressed(left.map((part, k) => Math.max(part + unsolved[k] + Math.abs(parts[k]), sample.alone ? 0 : share[k] * model.strongest_N)));
  }
  const now = sample.alone ? at_once(sample.place, sample.moved[m]) : { shown: NaN, felt: null }, force = norm(sample.force);
  const strength = Math.max(mesh.largest, Number.isFinite(force) ? force : model.strongest_N);
  const felt = later(model.relaxation, mesh.felt, dt, now.felt === null ? mesh.felt.at_once : now.felt);
  if (!sample.alone) left = left.map((part, k) => Math.max(part, share[k] * strength));
  else if (now.felt === null) unsolved = unsolved.map((part, k) => Math.max(part, share[k] * strength));
  const largest = Math.max(mesh.largest, Math.abs(felt.at_once));
  const unknown = sum(left) > LEFT * largest ? "remembers" : sum(left) + sum(unsolved) > LEFT * largest ? "unsolved" : "";
  // a tool cannot pull
  return { felt, left, unsolved, largest, unknown, fe_N: unknown || Number.isNaN(now.shown) ? NaN : Math.max(0, force_of(model.relaxation, felt)) };
}

/** After every state: writes the FE force under each mesh's displacement into its sample, fe_N [N], NaN if unknown; and
 *  the cause, if too large a force remains: "remembers" from an earlier indentation, "unsolved" from parts without FE
 *  reference. */
export function follow() {
  if (!state) return;
  const sample = samples[samples.length - 1], rested = state.v[IN.rested];
  const first = !known || known.of !== model || sample.time < known.time, reset = !first && rested !== known.rested;
  const dt = first ? 0 : sample.time - known.time;
  // for unseen times the strongest known force is taken as a bound
  const unseen = first && sample.time - rested > GAP || dt > GAP && !reset;
  const bound = model.relaxation.share.map(share => unseen ? share * model.strongest_N : 0);
  const meshes = model.meshes.map((_, m) => {
    if (!first && !reset && dt === 0) return known.meshes[m];   // paused
    const before = first || reset ? unpressed(bound) : known.meshes[m];
    return on(unseen ? { ...before, left: before.left.map((part, k) => Math.max(part, bound[k])) } : before, dt, sample, m);
  });
  known = { of: model, time: sample.time, rested, pressed: sample.pressed, meshes };
  sample.fe_N = meshes.map(mesh => mesh.fe_N);
  sample.unknown = meshes.map(mesh => mesh.unknown);
}
