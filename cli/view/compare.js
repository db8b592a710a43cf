// Comparison of the model with FE under the present indentation, for tissue at rest. The force along the displacement
// is compared, for each mesh along its own displacement and at its own depth. The contact must be within NEAR of a
// known one, which has an FE reference; the direction within ASKEW of a known one or between two; the depth from
// SHALLOW to 1.05 times the deepest FE depth.
import { folded } from "./rest.js";
import { model, state, near, samples, relaxes, IN, LEARNED, vector, vector_of, is_solid, pressed_by } from "./state.js";
import { add, angle_between, dot, norm } from "./vectors.js";
import { millimetres } from "./words.js";

// m and degrees: beyond, it is another contact or direction, as in the evaluation
export const NEAR = 0.002, ASKEW = 5;
export const SNAP = 0.003;        // m: an indentation this close to a known contact moves to it
export const FAR = 0.02;                 // m: up to this distance the FE force is shown, as that of another place
// degrees: FE forces are interpolated between known directions this close to each other
export const BETWEEN = 30;
export const SHALLOW = 0.001;            // m: at less depth a relative error has no meaning
const BEYOND = 1.05;                     // times the deepest FE depth
const MOTION = 0.1;                      // relative change of depth within AVERAGED above which tissue is not at rest
const AVERAGED = 0.5;                    // s, so that an oscillation does not count as an error

/** FE force at a depth [N], linear between FE depths and up to 1.05 times the deepest; else NaN. */
export function on_curve(curve, depth) {
  const at = between(curve, depth);
  return at ? at.a + (at.b - at.a) * at.w : NaN;
}

const deepest = curve => curve[curve.length - 1][0];

/** The values a and b of the FE rows [depth, value] on either side of a depth, and the weight w of b; null outside the
 *  FE depths. */
function between(rows, depth) {
  for (let k = 1; k < rows.length; k++) {
    const [d0, a] = rows[k - 1], [d1, b] = rows[k], reach = k + 1 === rows.length ? BEYOND * d1 : d1;
    if (depth <= reach && depth >= d0) return { a, b, w: (depth - d0) / (d1 - d0) };
  }
  return null;
}

/** Offset from the learned mesh to mesh m at rest; both have the same nodes. */
export const apart = m => add(model.meshes[m].nodes_m[0], model.meshes[0].nodes_m[0], -1);

/** The present contact, on the learned mesh at rest. */
export const contact_at_rest = (tool = 0) => vector_of(tool, "contact");

/** FE curve [[depth, force]], both along the displacement u, at the contact of place k: interpolated linearly in the
 *  angle between two known directions, else of a direction within ASKEW; null without either. The force depends on the
 *  direction: 5 degrees change it by 3 per cent, which exceeds the error of a good mesh. In space there is no
 *  interpolation. */
export function fe_curve(k, u) {
  if (is_solid()) return angle_between(model.places[k].direction, u) <= ASKEW ? model.places[k].curve : null;
  const fan = model.fans.get(k), angle = turn(fan.from, u);
  const at = fan.pushes.findIndex(push => push.angle >= angle), [a, b] = [fan.pushes[at - 1], fan.pushes[at]];
  if (a && b && b.angle - a.angle <= BETWEEN) {
    const w = (angle - a.angle) / (b.angle - a.angle), [ca, cb] = [a, b].map(push => model.places[push.place].curve);
    return (deepest(ca) < deepest(cb) ? ca : cb).map(([depth]) => [depth, (1 - w) * on_curve(ca, depth) + w * on_curve(cb, depth)]);
  }
  const close = fan.pushes.find(push => Math.abs(push.angle - angle) <= ASKEW);
  return close ? model.places[close.place].curve : null;
}

/** Angle in the plane from direction a to direction b, degrees, counter-clockwise. */
export const turn = (a, b) => 180 / Math.PI * Math.atan2(a[0] * b[1] - a[1] * b[0], dot(a, b));

/** Depth and force along the displacement of one mesh, in a sample. */
export const pushed = (sample, mesh) => {
  const u = sample.moved[mesh], depth = norm(u);
  return [depth, depth > 0 ? dot(sample.force, u) / depth : 0];
};

/** FE surface under the present indentation, by node of the learned mesh's outline, at the learned mesh's depth as the
 *  FE force. null if the server has none, or if contact or direction have no FE reference. */
export function fe_outline() {
  if (!state || state.v[IN.pressed] < 0 || pressed_by(1) >= 0 || !near || near.place !== state.v[IN.place]) return null;
  const place = model.places[near.place], u = vector(IN.moved);
  if (!place || !(norm(u) >= SHALLOW) || !(norm(add(place.contact_m, contact_at_rest(), -1)) <= NEAR)) return null;
  const at = angle_between(place.direction, u) <= ASKEW ? between(near.outline, dot(u, place.direction)) : null;
  const mesh = model.meshes[LEARNED];
  return at && mesh.outline.map((i, b) => add(add(mesh.nodes_m[i], at.a[b], 1 - at.w), at.b[b], at.w));
}

/** One mesh in one sample: {depth, error (relative), fe_N, force}, or {depth, why: one word}. */
function against_fe(sample, mesh) {
  const [depth, force] = pushed(sample, mesh);
  if (!Number.isFinite(depth) || !Number.isFinite(force)) return { depth: NaN, why: "unknown" };
  if (depth < SHALLOW) return { depth, why: "shallow" };
  const curve = fe_curve(sample.place, sample.moved[mesh]);
  if (!curve) return { depth, why: "askew" };
  if (depth > BEYOND * deepest(curve)) return { depth, why: "deep" };
  if (relaxes() && sample.unknown[mesh]) return { depth, why: sample.unknown[mesh] };
  const fe_N = relaxes() ? sample.fe_N[mesh] : on_curve(curve, depth);
  return fe_N > 0 ? { depth, error: force / fe_N - 1, fe_N, force } : { depth, why: "unknown" };
}

/** The samples of this indentation at this contact within AVERAGED, newest first. */
function recent() {
  const last = samples.length - 1, now = samples[last].time, contact = model.places[samples[last].place].contact_m, all = [];
  for (let s = last; s >= 0 && samples[s].pressed && samples[s].alone && samples[s].time > now - AVERAGED; s--) {
    const place = model.places[samples[s].place];
    if (!place || place.contact_m.some((x, a) => x !== contact[a])) break;
    all.push(samples[s]);
  }
  return all;
}

/** One mesh over these samples: fe_N and force of the newest, and the mean error; or {why: one word} for the newest.
 *  Samples without a number are left out of the mean. */
function judged(recent_samples, mesh) {
  const now = against_fe(recent_samples[0], mesh);
  if (now.why) return now;
  let least = Infinity, most = 0, sum = 0, n = 0;
  for (const sample of recent_samples) {
    const { depth, error } = against_fe(sample, mesh);
    if (Number.isFinite(depth)) [least, most] = [Math.min(least, depth), Math.max(most, depth)];
    if (Number.isFinite(error)) [sum, n] = [sum + error, n + 1];
  }
  return most - least > MOTION * most ? { depth: now.depth, why: "moves" } : { ...now, error: sum / n };
}

/** Comparison of each mesh with FE: {why} if contact or direction of the learned mesh have no FE reference, else
 *  {meshes: [{error} or {why: one word}], errors: one per mesh, NaN without one; absent without any}. If a known
 *  contact is near, also its place, distance and askew. */
export function comparison() {
  if (!state) return { why: "idle" };
  if (pressed_by(1) >= 0) return { why: `${state.v[IN.pressed] < 0 ? "The second tool indents" : "Two tools indent"}: the FE reference is for one tool; no comparison.` };
  if (state.v[IN.pressed] < 0) return { why: "idle" };
  const k = state.v[IN.place], place = model.places[k];
  if (!place) return { why: "No comparison: no known contact is near." };
  const distance = norm(add(place.contact_m, contact_at_rest(), -1)), moved = vector(IN.moved);
  const deep = norm(moved) >= SHALLOW, askew = deep ? angle_between(place.direction, moved) : NaN;
  const basis = { place: k, distance, askew };
  if (!place.curve.length) return { ...basis, why: "No comparison: this model has no FE force curves." };
  if (!moved.every(Number.isFinite) || !Number.isFinite(distance)) return { ...basis, why: "No comparison: the learned mesh has diverged." };
  if (!deep) return { ...basis, why: "No comparison below 1\u00a0mm depth." };
  const meshes = model.meshes.map((_, mesh) => folded(mesh) ? { why: "folded" } : judged(recent(), mesh)), { why, force, fe_N } = meshes[LEARNED];
  if (distance > FAR) return { ...basis, why: `The nearest known contact is ${millimetres(distance)} away: too far to compare.` };
  if (why === "askew") return { ...basis, why: `The direction is ${Math.round(askew)}° from the nearest known one: too far to compare.` };
  if (distance > NEAR) return { ...basis, why: `The nearest known contact is ${millimetres(distance)} away: too far for a relative error.`, there: why ? null : { force, fe_N } };
  if (why === "unsolved")
    return { ...basis, why: "Part of this indentation had no FE reference, and its force has not relaxed: release, wait or press Reset, then indent again." };
  if (why === "remembers")
    return { ...basis, why: "Force of an earlier indentation remains, which the FE reference lacks: wait, or press Reset." };
  const errors = meshes.map(mesh => mesh.error ?? NaN);
  return { ...basis, meshes, ...errors.some(Number.isFinite) ? { errors } : {} };
}
