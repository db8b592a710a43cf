// In the plane: a press that comes in close to a contact that finite elements have solved is one at it. It goes along the nearest push that
// was solved there unless it is dragged another way, and so does a press farther off whose force is told beside the one at that contact.
// In space a press is straight in unless it is tilted, and only the first is needed.
import { ASKEW, BETWEEN, FAR, NEAR, SNAP, apart, contact_at_rest, turn } from "./compare.js";
import { own_hands } from "./hand.js";
import { IN, control, model, pressed_by, state, vector_of } from "./state.js";
import { add, clamp, dot, largest, norm, smallest, unit } from "./vectors.js";

const FREE = 50;             // degrees off a push that was solved, from where on a push is as the pointer goes; nobody drags straight in
const BEFORE = 0.001;        // m outside the contact, where the tool waits until it is there
const THERE = 0.0015, COMING = 2000;   // m, and ms: it is, or does not come
const PRESS = 0.02;          // m/s into the tissue, as the demo: tissue that is struck swings away, and is touched again beside the contact
const STAYS = 0.03;          // s at rest there: a tool that leaves a press of the demo passes by in 6 ms

// press of a hand: {mesh, contact: where the push begins, null when none is near; known: it is one that was solved; entry, pushes, since,
//                   came: when the tool came there, out, ready}

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

/** Where a press that ends at a point inside mesh m comes in along a push that was solved; null where none of them is near. */
function known_way_in(m, p) {
  let best = null, least = Infinity;
  for (const { contact_m, direction, depth_m } of model.places) {
    const way = add(p, add(contact_m, apart(m)), -1), depth = dot(way, direction), aside = norm(add(way, direction, -depth));
    if (depth < 0 || depth > depth_m || aside > SNAP || norm(way) + aside >= least) continue;
    [best, least] = [add(p, direction, -depth), norm(way) + aside];
  }
  return best;
}

/** Where a press that comes in at this point of mesh m is led: {contact, known, entry, pushes}, contact null when none is near. */
function at_entry(m, entry) {
  let best = null, least = FAR;
  for (const { places } of model.contacts) {
    const contact = add(model.places[places[0]].contact_m, apart(m)), distance = norm(add(contact, entry, -1)), known = distance <= SNAP;
    if (distance <= least) [best, least] = [{ contact: known ? contact : entry, known, pushes: places.map(k => model.places[k].direction) }, distance];
  }
  return { contact: null, known: false, pushes: [], entry, mesh: m, ready: false, out: false, since: null, came: null, ...best };
}

/** Where a pointer would press: what at_entry() says, or null beside the tissue. */
export function would_press(from, p) {
  for (const [m, mesh] of model.meshes.entries()) {
    const entry = from && !inside(mesh, from) ? crossing(mesh, from, p) : inside(mesh, p) ? known_way_in(m, p) || way_in(mesh, p) : null;
    if (entry) return at_entry(m, entry);
  }
  return null;
}

/** A push as it is led: along the nearest that was solved, and from FREE on as it comes; in between it goes over. Between two that were
 *  solved it is free sooner: it is compared there where they are close, and half-way the other one takes over. */
function led(push, pushes) {
  const [nearest, ...others] = pushes.map(known => turn(known, push)).sort((a, b) => Math.abs(a) - Math.abs(b));
  const across = smallest(others.filter(off => off * nearest < 0).map(Math.abs)), gap = Math.abs(nearest) + across;
  const free = Math.min(gap <= BETWEEN ? 2 * ASKEW : FREE, gap / 2);
  if (Math.abs(nearest) >= free) return push;
  const back = Math.PI / 180 * Math.sign(nearest) * Math.min(Math.abs(nearest), free - Math.abs(nearest)), [x, y] = push;
  return [x * Math.cos(back) + y * Math.sin(back), y * Math.cos(back) - x * Math.sin(back)];
}

/** Where the push begins: where the tool has come upon the tissue, which may lie a little beside the known contact. */
function touched({ tool, press }) {
  const here = add(contact_at_rest(tool), apart(press.mesh));
  return norm(add(here, press.contact, -1)) <= NEAR ? here : press.contact;
}

/** Once a frame: from where the pointer of each hand is to where its tool shall be. */
export function lead_plane(now, frame_before) {
  for (const hand of own_hands()) if (hand.down) lead(hand, now, frame_before);
}

function lead(hand, now, frame_before) {
  const p = hand.pointer, touching = pressed_by(hand.tool) >= 0;
  if (hand.press && !touching && !model.meshes.some(mesh => inside(mesh, p))) hand.press = null;   // out again: the next press is another one
  hand.press = hand.press || would_press(hand.before, p);
  hand.before = p;
  const { press } = hand;
  let at = p;
  if (press && press.contact) {
    const push = led(add(p, press.entry, -1), press.pushes), along = norm(push) > 1e-4 ? unit(push) : unit(press.pushes[0]);
    const wait = add(press.contact, along, -BEFORE);
    press.since = press.since ?? now;
    press.out = press.out || state !== null && control.holders[hand.tool] === "you" && !touching;   // until then it is in the tissue where the demo pressed
    const there = press.out && norm(add(vector_of(hand.tool, "master"), wait, -1)) < THERE;
    press.came = there ? press.came ?? state.v[IN.time] : null;
    press.ready = press.ready || press.out && touching || there && state.v[IN.time] - press.came > STAYS || now - press.since > COMING;
    const from = press.out && touching ? touched(hand) : press.contact, goal = press.ready ? add(from, push) : wait, way = add(goal, hand.at, -1);
    const step = press.ready && dot(way, along) > 0 ? PRESS * clamp((now - frame_before) / 1e3, 0, 0.05) : Infinity;
    at = norm(way) > step ? add(hand.at, unit(way), step) : goal;
  }
  if (norm(add(at, hand.at, -1)) > 1e-6) hand.at = at;
}
