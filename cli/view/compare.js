// Model against finite elements, under the push of now. Compared is force along the push: at a place at most NEAR from a contact that
// was solved, of each mesh along its own push, which is one that was solved to ASKEW degrees or lies between two of them, and at
// its own depth, from SHALLOW to a twentieth beyond the deepest that was solved; of tissue at rest.
import { folded } from "./rest.js";
import { model, state, near, samples, relaxes, IN, LEARNED, vector, vector_of, is_solid, pressed_by } from "./state.js";
import { add, angle_between, dot, norm } from "./vectors.js";
import { millimetres } from "./words.js";

export const NEAR = 0.002, ASKEW = 5;    // m and degrees: from here on a contact is another one, in the evaluation too
export const SNAP = 0.003;        // m: a press this close to a contact that FE have solved is one at it
export const FAR = 0.02;                 // m: so far away finite elements' force is still told, as that of another place
export const BETWEEN = 30;               // degrees: known pushes this close to each other say what is between them
export const SHALLOW = 0.001;            // m: less depth makes a percentage of next to nothing
const BEYOND = 1.05;                     // times the deepest that was solved
const MOTION = 0.1;                      // change of depth within AVERAGED: FE are of tissue at rest
const AVERAGED = 0.5;                    // s, so that a ripple is not read as an error

/** FE force at a depth [N], by lines between what was solved, and a twentieth beyond the deepest; else NaN. */
export function on_curve(curve, depth) {
  const at = between(curve, depth);
  return at ? at.a + (at.b - at.a) * at.w : NaN;
}

const deepest = curve => curve[curve.length - 1][0];

/** The rows [depth, what FE say there] on either side of a depth, what they say as a and b, and how far it is from a to b;
 *  null where nothing was solved. */
function between(rows, depth) {
  for (let k = 1; k < rows.length; k++) {
    const [d0, a] = rows[k - 1], [d1, b] = rows[k], reach = k + 1 === rows.length ? BEYOND * d1 : d1;
    if (depth <= reach && depth >= d0) return { a, b, w: (depth - d0) / (d1 - d0) };
  }
  return null;
}

/** From the learned mesh to mesh m, at rest: both have the same nodes. */
export const apart = m => add(model.meshes[m].nodes_m[0], model.meshes[0].nodes_m[0], -1);

/** The contact of now, on the learned mesh at rest. */
export const contact_at_rest = (tool = 0) => vector_of(tool, "contact");

/** FE's curve [[depth, force], both along the push] for a push u at the contact of place k: by lines over the angle between
 *  two known pushes, else that of a push at most ASKEW off; null when there is neither. Force along the push turns with
 *  the push: 5 degrees are 3 per cent, which is more than a good mesh is wrong. In space nothing is drawn between pushes. */
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

/** In the plane, from direction a to direction b, degrees, counter-clockwise. */
export const turn = (a, b) => 180 / Math.PI * Math.atan2(a[0] * b[1] - a[1] * b[0], dot(a, b));

/** Depth and force along the push of one mesh, in a sample. */
export const pushed = (sample, mesh) => {
  const u = sample.moved[mesh], depth = norm(u);
  return [depth, depth > 0 ? dot(sample.force, u) / depth : 0];
};

/** FE's surface under the push of now, in the plane, by the nodes of the learned mesh's outline; at the learned mesh's depth, as
 *  their force is. null where the server has none, and where contact or push is another than what was solved. */
export function fe_outline() {
  if (!state || state.v[IN.pressed] < 0 || pressed_by(1) >= 0 || !near || near.place !== state.v[IN.place]) return null;
  const place = model.places[near.place], u = vector(IN.moved);
  if (!place || !(norm(u) >= SHALLOW) || !(norm(add(place.contact_m, contact_at_rest(), -1)) <= NEAR)) return null;
  const at = angle_between(place.direction, u) <= ASKEW ? between(near.outline, dot(u, place.direction)) : null;
  const mesh = model.meshes[LEARNED];
  return at && mesh.outline.map((i, b) => add(add(mesh.nodes_m[i], at.a[b], 1 - at.w), at.b[b], at.w));
}

/** One mesh in one sample: {depth, error, fe_N, force}, the error relative, or {depth, why: one word}. */
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

/** The samples of this press at this contact over the time that is averaged, newest first. */
function recent() {
  const last = samples.length - 1, now = samples[last].time, contact = model.places[samples[last].place].contact_m, all = [];
  for (let s = last; s >= 0 && samples[s].pressed && samples[s].alone && samples[s].time > now - AVERAGED; s--) {
    const place = model.places[samples[s].place];
    if (!place || place.contact_m.some((x, a) => x !== contact[a])) break;
    all.push(samples[s]);
  }
  return all;
}

/** One mesh over these samples: {error, fe_N, force} of now, the error as a mean, or {why: one word} that is true of now. A sample without
 *  a number is no part of the mean. */
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

/** How each mesh compares with FE now: {why} when place or push of the learned mesh are none that FE have solved, else
 *  {meshes: [{error} or {why: one word}], errors: of the meshes, NaN where there is none; absent where there is none at all}.
 *  place, distance and askew, of the nearest known contact, in both. */
export function comparison() {
  if (!state) return { why: "idle" };
  if (pressed_by(1) >= 0) return { why: `${state.v[IN.pressed] < 0 ? "The second tool presses" : "Two tools press"}: finite elements were solved under one tool, so nothing is compared.` };
  if (state.v[IN.pressed] < 0) return { why: "idle" };
  const k = state.v[IN.place], place = model.places[k];
  if (!place) return { why: "No known contact is near, so there is nothing to compare with." };
  const distance = norm(add(place.contact_m, contact_at_rest(), -1)), moved = vector(IN.moved);
  const deep = norm(moved) >= SHALLOW, askew = deep ? angle_between(place.direction, moved) : NaN;
  const basis = { place: k, distance, askew };
  if (!place.curve.length) return { ...basis, why: "This model carries no finite-element curves to compare with." };
  if (!moved.every(Number.isFinite) || !Number.isFinite(distance)) return { ...basis, why: "The learned mesh has no finite place: there is nothing to compare." };
  if (!deep) return { ...basis, why: "Press a little deeper: below 1 mm there is nothing to compare." };
  const meshes = model.meshes.map((_, mesh) => folded(mesh) ? { why: "folded" } : judged(recent(), mesh)), { why, force, fe_N } = meshes[LEARNED];
  if (distance > FAR) return { ...basis, why: `The nearest known contact is ${millimetres(distance)} away: too far to compare with.` };
  if (why === "askew") return { ...basis, why: `This push is ${Math.round(askew)}° off the nearest known one: too far to compare with.` };
  if (distance > NEAR) return { ...basis, why: `The nearest known contact is ${millimetres(distance)} away: too far for per cent.`, there: why ? null : { force, fe_N } };
  if (why === "unsolved")
    return { ...basis, why: "Earlier in this press the tool was where no finite elements were solved, and tissue that relaxes remembers it: let go, wait or press Reset, and press again." };
  if (why === "remembers")
    return { ...basis, why: "The tissue still remembers an earlier press, and finite elements do not: wait a while, or press Reset." };
  const errors = meshes.map(mesh => mesh.error ?? NaN);
  return { ...basis, meshes, ...errors.some(Number.isFinite) ? { errors } : {} };
}
