// In the plane: a press that comes in close to a contact that finite elements have solved is one at it, and a push that is nearly one that
// was solved is that. In space a press is straight in unless it is tilted, and only the first is needed.
import { ASKEW, SNAP, apart, turn } from "./compare.js";
import { IN, hand, model, state, vector } from "./state.js";
import { add, largest, norm, smallest, unit } from "./vectors.js";

const FREE = 2 * ASKEW;      // degrees off a push that was solved, from where on a push is as the pointer goes; in between it goes over
const BEFORE = 0.001;        // m outside the contact, where the tool waits until it is there
const THERE = 0.0015, COMING = 2000;   // m, and ms: it is, or does not come

let press = null;            // {contact: null when none is near, entry, pushes, since, ready}
let before = null;           // where the pointer was, a frame ago

const outline = mesh => mesh.outline.map((i, k) => [mesh.nodes_m[i], mesh.nodes_m[mesh.outline[(k + 1) % mesh.outline.length]]]);
const cross = (a, b) => a[0] * b[1] - a[1] * b[0];

/** Whether a point is inside a mesh at rest. */
const inside = (mesh, p) => outline(mesh).reduce((odd, [a, b]) =>
  (a[1] > p[1]) !== (b[1] > p[1]) && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) ? !odd : odd, false);

/** Where the way from p to q first crosses a mesh's outline at rest; null where it does not. */
function crossing(mesh, p, q) {
  const way = add(q, p, -1);
  let least = Infinity;
  for (const [a, b] of outline(mesh)) {
    const side = add(b, a, -1), to = add(a, p, -1), det = cross(way, side), t = cross(to, side) / det, s = cross(to, way) / det;
    if (t >= 0 && t <= 1 && s >= 0 && s <= 1 && t < least) least = t;
  }
  return least <= 1 ? add(p, way, least) : null;
}

/** Where a tool that is told to be inside comes in, as the server leads it: by the nearest side but the lower. */
function way_in(mesh, p) {
  const far = 0.01, [x, y] = [0, 1].map(axis => mesh.nodes_m.map(at => at[axis])), low = smallest(x), high = largest(x), top = largest(y);
  const sides = [[p[0] - low, [low - far, p[1]]], [high - p[0], [high + far, p[1]]], [top - p[1], [p[0], top + far]]].sort((a, b) => a[0] - b[0]);
  return crossing(mesh, sides[0][1], p);
}

/** Where a press that comes in at this point of mesh m is led: {contact, entry, pushes}, contact null when none is near. */
function at_entry(m, entry) {
  let best = null, least = SNAP;
  for (const { places } of model.contacts) {
    const contact = add(model.places[places[0]].contact_m, apart(m)), distance = norm(add(contact, entry, -1));
    if (distance <= least) [best, least] = [{ contact, pushes: places.map(k => model.places[k].direction) }, distance];
  }
  return { contact: null, pushes: [], entry, ready: false, since: null, ...best };
}

/** Where a pointer would press: what at_entry() says, or null beside the tissue. */
export function would_press(from, p) {
  for (const [m, mesh] of model.meshes.entries()) {
    const entry = from && !inside(mesh, from) ? crossing(mesh, from, p) : inside(mesh, p) ? way_in(mesh, p) : null;
    if (entry) return at_entry(m, entry);
  }
  return null;
}

/** A push as it is led: within ASKEW of one that was solved it is that, beyond FREE it is as it comes. */
function led(push, pushes) {
  let nearest = null, least = FREE;
  for (const known of pushes) {
    const off = Math.abs(turn(known, push));
    if (off < least) [nearest, least] = [known, off];
  }
  if (!nearest) return push;
  const off = Math.sign(turn(nearest, push)) * Math.max(0, 2 * (least - ASKEW)) * Math.PI / 180, [x, y] = unit(nearest), length = norm(push);
  return [length * (x * Math.cos(off) - y * Math.sin(off)), length * (x * Math.sin(off) + y * Math.cos(off))];
}

/** Once a frame: from where the pointer is, hand.pointer, to where the tool shall be. */
export function lead_plane(now) {
  if (!hand.down) {
    press = before = null;
    return;
  }
  const p = hand.pointer, touching = state && state.v[IN.pressed] >= 0;
  if (press && !touching && !model.meshes.some(mesh => inside(mesh, p))) press = null;   // out again: the next press is another one
  press = press || would_press(before, p);
  before = p;
  let at = p;
  if (press && press.contact) {
    const push = led(add(p, press.entry, -1), press.pushes), along = norm(push) > 1e-4 ? unit(push) : unit(press.pushes[0]);
    const wait = add(press.contact, along, -BEFORE);
    press.since = press.since ?? now;
    press.ready = press.ready || touching || now - press.since > COMING || state !== null && norm(add(vector(IN.master), wait, -1)) < THERE;
    at = press.ready ? add(press.contact, push) : wait;
  }
  if (norm(add(at, hand.at, -1)) > 1e-6) hand.at = at;
}
