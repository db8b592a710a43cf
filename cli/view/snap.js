// Snapping in the plane. An indentation that enters close to a known contact, which has an FE reference, moves to that
// contact. It follows the nearest known direction there unless it is dragged to another one. So does an indentation
// farther away, whose force is shown beside the FE force at that contact. In space only the first is needed, because an
// indentation is straight in unless it is tilted.
import { ASKEW, BETWEEN, FAR, NEAR, SNAP, apart, contact_at_rest, turn } from "./compare.js";
import { own_hands } from "./hand.js";
import { IN, control, model, pressed_by, state, vector_of } from "./state.js";
import { add, clamp, dot, largest, norm, smallest, unit } from "./vectors.js";

// degrees from a known direction, from which on the pointer is followed; a drag is rarely straight in
const FREE = 50;
const BEFORE = 0.001;        // m outside the contact: there the page waits for the tool
const THERE = 0.0015, COMING = 2000;   // m within which the tool has arrived; ms after which the wait ends
// m/s into the tissue, as the demo; after an impact tissue oscillates and is touched beside the contact
const PRESS = 0.02;
const STAYS = 0.03;          // s at rest there; a tool that leaves an indentation of the demo passes within 6 ms

// press of a hand: {mesh, contact: start of the displacement, null if none is near; known: whether that is known;
// entry; pushes: known directions; since; came: time of the tool's arrival; out; ready}

const outline = mesh => mesh.outline.map((i, k) => [mesh.nodes_m[i], mesh.nodes_m[mesh.outline[(k + 1) % mesh.outline.length]]]);
const cross = (a, b) => a[0] * b[1] - a[1] * b[0];

/** Whether a point is inside a mesh at rest. */
const inside = (mesh, p) => outline(mesh).reduce((odd, [a, b]) =>
  (a[1] > p[1]) !== (b[1] > p[1]) && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) ? !odd : odd, false);

/** The first crossing of the segment from p to q with a mesh's outline at rest; null without one. */
function crossing(mesh, p, q) {
  const way = add(q, p, -1);
  let least = Infinity;
  for (const [a, b] of outline(mesh)) {
    const side = add(b, a, -1), to = add(a, p, -1), det = cross(way, side), t = cross(to, side) / det, s = cross(to, way) / det;
    if (t >= 0 && t <= 1 && s >= 0 && s <= 1 && t < least) least = t;
  }
  return least <= 1 ? add(p, way, least) : null;
}

/** The point where the server leads a tool into a mesh to a point inside: on the nearest side except the lower one. */
function way_in(mesh, p) {
  const far = 0.01, [x, y] = [0, 1].map(axis => mesh.nodes_m.map(at => at[axis])), low = smallest(x), high = largest(x), top = largest(y);
  const sides = [[p[0] - low, [low - far, p[1]]], [high - p[0], [high + far, p[1]]], [top - p[1], [p[0], top + far]]].sort((a, b) => a[0] - b[0]);
  return crossing(mesh, sides[0][1], p);
}

/** Entry point of an indentation along a known direction to a point inside mesh m; null if none is near. */
function known_way_in(m, p) {
  let best = null, least = Infinity;
  for (const { contact_m, direction, depth_m } of model.places) {
    const way = add(p, add(contact_m, apart(m)), -1), depth = dot(way, direction), aside = norm(add(way, direction, -depth));
    if (depth < 0 || depth > depth_m || aside > SNAP || norm(way) + aside >= least) continue;
    [best, least] = [add(p, direction, -depth), norm(way) + aside];
  }
  return best;
}

/** The indentation that enters mesh m at this point, as a press of a hand; its contact is null if none is near. */
function at_entry(m, entry) {
  let best = null, least = FAR;
  for (const { places } of model.contacts) {
    const contact = add(model.places[places[0]].contact_m, apart(m)), distance = norm(add(contact, entry, -1)), known = distance <= SNAP;
    if (distance <= least) [best, least] = [{ contact: known ? contact : entry, known, pushes: places.map(k => model.places[k].direction) }, distance];
  }
  return { contact: null, known: false, pushes: [], entry, mesh: m, ready: false, out: false, since: null, came: null, ...best };
}

/** The indentation that a pointer would start, as in at_entry(); null beside the tissue. */
export function would_press(from, p) {
  for (const [m, mesh] of model.meshes.entries()) {
    const entry = from && !inside(mesh, from) ? crossing(mesh, from, p) : inside(mesh, p) ? known_way_in(m, p) || way_in(mesh, p) : null;
    if (entry) return at_entry(m, entry);
  }
  return null;
}

/** The displacement of the tool for one of the pointer. Up to half an angle `free` from the nearest known direction it
 *  follows that direction, from `free` on the pointer, with a linear transition. `free` is FREE, and less between two
 *  known directions: half their gap at most, and 2 ASKEW at most where FE forces are interpolated between them. */
function led(push, pushes) {
  const [nearest, ...others] = pushes.map(known => turn(known, push)).sort((a, b) => Math.abs(a) - Math.abs(b));
  const across = smallest(others.filter(off => off * nearest < 0).map(Math.abs)), gap = Math.abs(nearest) + across;
  const free = Math.min(gap <= BETWEEN ? 2 * ASKEW : FREE, gap / 2);
  if (Math.abs(nearest) >= free) return push;
  const back = Math.PI / 180 * Math.sign(nearest) * Math.min(Math.abs(nearest), free - Math.abs(nearest)), [x, y] = push;
  return [x * Math.cos(back) + y * Math.sin(back), y * Math.cos(back) - x * Math.sin(back)];
}

/** Start of the displacement: the tool's contact if that is within NEAR of the wanted one, else the wanted one. */
function touched({ tool, press }) {
  const here = add(contact_at_rest(tool), apart(press.mesh));
  return norm(add(here, press.contact, -1)) <= NEAR ? here : press.contact;
}

/** Once a frame: sets the target of each tool from the pointer of its hand. */
export function lead_plane(now, frame_before) {
  for (const hand of own_hands()) if (hand.down) lead(hand, now, frame_before);
}

function lead(hand, now, frame_before) {
  const p = hand.pointer, touching = pressed_by(hand.tool) >= 0;
  // outside again: the next indentation is a new one
  if (hand.press && !touching && !model.meshes.some(mesh => inside(mesh, p))) hand.press = null;
  hand.press = hand.press || would_press(hand.before, p);
  hand.before = p;
  const { press } = hand;
  let at = p;
  if (press && press.contact) {
    const push = led(add(p, press.entry, -1), press.pushes), along = norm(push) > 1e-4 ? unit(push) : unit(press.pushes[0]);
    const wait = add(press.contact, along, -BEFORE);
    press.since = press.since ?? now;
    // until then the tool is in the indentation of the demo
    press.out = press.out || state !== null && control.holders[hand.tool] === "you" && !touching;
    const there = press.out && norm(add(vector_of(hand.tool, "master"), wait, -1)) < THERE;
    press.came = there ? press.came ?? state.v[IN.time] : null;
    press.ready = press.ready || press.out && touching || there && state.v[IN.time] - press.came > STAYS || now - press.since > COMING;
    const from = press.out && touching ? touched(hand) : press.contact, goal = press.ready ? add(from, push) : wait, way = add(goal, hand.at, -1);
    const step = press.ready && dot(way, along) > 0 ? PRESS * clamp((now - frame_before) / 1e3, 0, 0.05) : Infinity;
    at = norm(way) > step ? add(hand.at, unit(way), step) : goal;
  }
  if (norm(add(at, hand.at, -1)) > 1e-6) hand.at = at;
}
