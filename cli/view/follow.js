// Finite elements' force under the push that goes on, state by state: their force at the mesh's depth is of tissue that has no
// memory; where the model relaxes, it goes through the material's branches. That is true of one lasting contact with tissue that
// remembers nothing; what it still remembers of before is followed too, as a bound.
import { force_of, later, nothing_felt, sum } from "./branches.js";
import { NEAR, SHALLOW, contact_at_rest, fe_curve, on_curve } from "./compare.js";
import { IN, model, samples, state } from "./state.js";
import { add, dot, norm } from "./vectors.js";

const LEFT = 0.02;      // of the largest force of the press: less that is left of before counts as nothing
const FARTHEST = 1.2;   // times the deepest that was solved: so far the last line goes on, for the memory alone
const GAP = 0.2;        // s: whoever has seen no state for longer does not know what was pressed meanwhile

let known = null;   // {of: model, time, rested, pressed, meshes: [{felt, left, unsolved, largest, fe_N, unknown}]}

/** Finite elements' force along a push u at the contact of place k, at once [N]; shown: what was solved, else NaN; felt: what the
 *  memory goes by, null when unknown. */
function at_once(k, u) {
  const place = model.places[k], none = { shown: NaN, felt: null };
  if (!place || !place.curve.length || !(norm(add(place.contact_m, contact_at_rest(), -1)) <= NEAR)) return none;
  const depth = norm(u), shallow = depth < SHALLOW;   // the direction of next to nothing is none
  const curve = shallow ? place.curve : fe_curve(k, u), along = shallow ? Math.max(0, dot(u, place.direction)) : depth;
  if (!curve) return none;
  const shown = on_curve(curve, along), [[d0, f0], [d1, f1]] = curve.slice(-2);
  if (Number.isFinite(shown)) return { shown, felt: shown };
  return { shown: NaN, felt: along <= FARTHEST * d1 ? f0 + (f1 - f0) * (along - d0) / (d1 - d0) : null };
}

const unpressed = left => ({ felt: nothing_felt(model.relaxation), left, unsolved: left.map(() => 0), largest: 0, fe_N: 0, unknown: "" });

/** One mesh from one state to the next. left, unsolved: a bound of what each branch still holds of before this press, and of where this press was that finite elements
 *  were not, N. unknown: "" or the word why their force is none. */
function on(mesh, dt, sample, m) {
  const { share, tau_s } = model.relaxation, faded = parts => parts.map((part, k) => part * Math.exp(-dt / tau_s[k]));
  let left = faded(mesh.left), unsolved = faded(mesh.unsolved);
  if (!sample.pressed) {   // after the first tool lets go its branches still hold a part; while the second presses, an unknown part, bounded by the strongest push
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
  return { felt, left, unsolved, largest, unknown, fe_N: unknown || Number.isNaN(now.shown) ? NaN : Math.max(0, force_of(model.relaxation, felt)) };   // no tool pulls
}

/** After every state: writes into its sample what finite elements say under each mesh's push, fe_N [N], NaN where that is unknown,
 *  and why, where the mesh's tissue remembers too much that they do not know: remembers or unsolved. */
export function follow() {
  if (!state) return;
  const sample = samples[samples.length - 1], rested = state.v[IN.rested];
  const first = !known || known.of !== model || sample.time < known.time, reset = !first && rested !== known.rested;
  const dt = first ? 0 : sample.time - known.time;
  // nobody presses harder than the strongest known push, says who has not looked on
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
