// The page of `tissuectl serve`: Fig. 7 of the paper, alive. PROTOCOL.md says what server and page tell each other.
// Inside: metres, newtons, seconds. mm, mN and percent only where people read.
// A script may look on through window.tissue (see the end); nothing there can be changed.
"use strict";
(() => {

// ---- what is known: written by the connection and by the hand, read by everything else

let model = null;        // the last "model" message, with what prepare() adds
let state = null;        // the last state: {v: 32 numbers, nodes: [Float32Array x, y of the learned mesh, of the heuristic]}
let near = null;         // the last "near" message
let control = { holder: "nobody", paused: false, place: -1 };
const samples = [];      // what the plots show, oldest first
let states = 0;          // since the page was opened
const hand = { at: null, down: false, by: null };   // the visitor's, in the plane

const IN = { time: 0, ticks: 1, misses: 2, misses_program: 3, clamped: 4, faults: 5, rate: 6, p50: 7, p99: 8, master: 9,
             proxy: 11, pressed: 13, moved: 14, force: 18, device: 20, place: 22, fe: 23, set: 24, fault: 25, clients: 26 };
const LEARNED = 0, HEURISTIC = 1;   // meshes; the second may be missing (--no-heuristic)
const WINDOW = 10;                // s, of the plot over time
const NEAR = 0.002, ASKEW = 5;    // m and degrees: from here on a contact is another one, in the evaluation too
const BETWEEN = 30;               // degrees: known pushes this close to each other say what is between them
const MOTION = 0.1;               // change of depth within half a second: FE are of tissue at rest
const SHALLOW = 0.001;            // m: less depth makes a percentage of next to nothing

const $ = id => document.getElementById(id);
const still = matchMedia("(prefers-reduced-motion: reduce)");

// ---- small vectors [x, y]

const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1];
const norm = a => Math.hypot(a[0], a[1]);
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
const pair = i => [state.v[i], state.v[i + 1]];
const node = (mesh, i) => [state.nodes[mesh][2 * i], state.nodes[mesh][2 * i + 1]];

// ---- words

const millimetres = m => Number.isFinite(m) ? `${(1e3 * m).toFixed(1)}\u00a0mm` : "–";
const unit_of = force => Math.abs(force) < 0.1 ? { name: "mN", scale: 1e3 } : { name: "N", scale: 1 };
/** In the unit that suits the model: one that does not change from reading to reading. */
function newtons(force, like = model.strongest_N || force) {
  if (!Number.isFinite(force)) return "–";
  const unit = unit_of(like), x = unit.scale * force;
  return `${x.toFixed(Math.abs(x) >= 100 ? 0 : Math.abs(x) >= 10 ? 1 : 2)}\u00a0${unit.name}`;
}
const percent = x => `${100 * x < 9.95 ? (100 * x).toFixed(1) : Math.round(100 * x)}\u00a0%`;
const say = (id, text) => { if ($(id).textContent !== text) $(id).textContent = text; };

// ---- connection

const socket = { at: null, tries: 0, again: null, reason: "" };

function connect() {
  clearTimeout(socket.again);
  const ws = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`);
  ws.binaryType = "arraybuffer";
  socket.at = ws;
  let opened = false;
  ws.onopen = () => {
    opened = true;
    socket.reason = "";
  };
  ws.onmessage = ({ data }) => typeof data === "string" ? heard(JSON.parse(data)) : seen(data);
  ws.onclose = ({ reason }) => {
    if (socket.at !== ws) return;
    if (reason) socket.reason = reason;
    let_go(false);
    const wait = Math.min(0.5 * 2 ** socket.tries++, 8);   // s
    socket.again = setTimeout(connect, 1e3 * wait);
    socket.at = null;
    if (!opened) ask_why();
    show_controls();
  };
}

/** A WebSocket that is not let in learns no reason; a plain request does. */
async function ask_why() {
  try {
    const answer = await fetch("healthz");
    socket.reason = answer.ok ? "no more pages may connect at the moment" : (await answer.text()).trim();
  } catch {
    // nobody there: what was said last still holds
  }
  show_controls();
}
const is_open = () => socket.at !== null && socket.at.readyState === WebSocket.OPEN && model !== null;
function tell(message) {
  if (socket.at !== null && socket.at.readyState === WebSocket.OPEN) socket.at.send(JSON.stringify(message));
}

function heard(message) {
  if (message.type === "model") {
    socket.tries = 0;
    prepare(message);
  } else if (message.type === "control") {
    if (message.holder === "other" && control.holder === "you") let_go(false);
    control = message;
  } else if (message.type === "near") near = message;
  else if (message.type === "bye") socket.reason = message.reason;
  show_controls();
}

function seen(buffer) {
  if (!model) return;
  const lengths = model.meshes.map(mesh => 2 * mesh.nodes_m.length);
  if (buffer.byteLength !== 8 * 32 + 4 * lengths.reduce((a, b) => a + b)) return;   // of the model before
  const nodes = [];
  let from = 8 * 32;
  for (const length of lengths) {
    nodes.push(new Float32Array(buffer, from, length));
    from += 4 * length;
  }
  state = { v: new Float64Array(buffer, 0, 32), nodes };
  states++;
  remember();
}

/** One sample of the plots. Samples are in order of time: a clock that was set back starts them anew. */
function remember() {
  const time = state.v[IN.time], last = samples[samples.length - 1];
  if (last && time < last.time) samples.length = 0;
  else if (last && time === last.time) samples.pop();   // paused
  const pressed = state.v[IN.pressed] >= 0;
  samples.push({ time, pressed, starts: pressed && !(last && last.pressed), force: pair(IN.force),
                 moved: [pair(IN.moved), pair(IN.moved + 2)], place: state.v[IN.place], fe: state.v[IN.fe] });
  while (samples[0].time < time - 2 * WINDOW) samples.shift();
}

// ---- the model: what drawing needs beside what was sent

function prepare(message) {
  model = message;
  state = near = null;
  samples.length = 0;
  hand.at = null;
  for (const mesh of model.meshes) {
    mesh.faces = faces(mesh);
    mesh.is_fixed = new Set(mesh.fixed);
    mesh.curve = null;
  }
  // lines as wide as the root of stiffness; where the median spring is 1 px, sorted into a few widths
  const all = model.meshes.flatMap(mesh => mesh.stiffness_N_m).sort((a, b) => a - b), median = all[all.length >> 1] || 1;
  for (const mesh of model.meshes) {
    mesh.widths = new Map();
    mesh.springs.forEach((spring, s) => {
      const width = clamp(Math.round(4 * Math.sqrt(mesh.stiffness_N_m[s] / median)) / 4, 0.5, 2.5);
      if (!mesh.widths.has(width)) mesh.widths.set(width, []);
      mesh.widths.get(width).push(spring);
    });
  }
  const pushes = model.places.map(place => place.depth_m);
  model.deepest_m = nice(Math.max(0.005, ...pushes) * 1e3).top * 1e-3;
  model.strongest_N = Math.max(0, ...model.places.flatMap(place => place.curve.map(point => point[1])));
  const of = axis => model.meshes[LEARNED].nodes_m.map(p => p[axis]);
  model.box = { low: [Math.min(...of(0)), Math.min(...of(1))], high: [Math.max(...of(0)), Math.max(...of(1))] };
  document.getElementById("spring_set").parentElement.hidden = model.law;
  list_models();
  list_places();
  document.title = `${model.study} – tissuectl`;
  say("about", `Study ${model.study}: ${model.meshes[0].nodes_m.length} nodes and ${model.meshes[0].springs.length} springs a mesh, ` +
      `step ${1e3 * model.dt_s} ms, dynamics ${[...new Set(Object.values(model.dynamics))].join(" and ")}; the hand feels ${model.force_scale === 1 ? "" : `${model.force_scale} times `}` +
      `the tissue's force, ${model.force_max_N} N at most. Line width: stiffness (its root${model.law ? "" : ", mean over spring sets"}). Colour: displacement.`);
  fit();
}

/** Triangles that tile a mesh at rest. Springs that cross a shorter one are left out; what is left is a plane graph, and
 *  its bounded faces, walked with the tissue on the left, are cut into fans. */
function faces(mesh) {
  const at = mesh.nodes_m, cross = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const apart = (a, b, c, d) => Math.sign(cross(at[a], at[b], at[c])) * Math.sign(cross(at[a], at[b], at[d])) < 0;
  const length = ([i, j]) => norm(add(at[j], at[i], -1));
  const kept = [];
  for (const [i, j] of [...mesh.springs].sort((a, b) => length(a) - length(b)))
    if (!kept.some(([k, l]) => apart(i, j, k, l) && apart(k, l, i, j))) kept.push([i, j]);

  const around = at.map(() => []), angle = (i, j) => Math.atan2(at[j][1] - at[i][1], at[j][0] - at[i][0]);
  for (const [i, j] of kept) { around[i].push(j); around[j].push(i); }
  around.forEach((others, i) => others.sort((a, b) => angle(i, a) - angle(i, b)));
  const walked = new Set(), triangles = [];
  for (const start of kept.flatMap(([i, j]) => [[i, j], [j, i]])) {
    const face = [];
    for (let [i, j] = start; !walked.has(i * at.length + j);) {
      walked.add(i * at.length + j);
      face.push(i);
      const others = around[j];   // the next edge clockwise from where we came: the face is on the left
      [i, j] = [j, others[(others.indexOf(i) + others.length - 1) % others.length]];
    }
    const area = face.reduce((sum, n, k) => sum + cross([0, 0], at[n], at[face[(k + 1) % face.length]]), 0);
    if (area > 0) for (let k = 1; k + 1 < face.length; k++) triangles.push([face[0], face[k], face[k + 1]]);
  }
  return triangles;
}

// ---- what the visitor is told

/** FE force at a depth [N], by lines between what was solved, and a twentieth beyond the deepest; else NaN. */
function on_curve(curve, depth) {
  const at = between(curve, depth);
  return at ? at.a + (at.b - at.a) * at.w : NaN;
}

/** The rows [depth, what FE say there] on either side of a depth, what they say as a and b, and how far it is from a to b;
 *  null where nothing was solved. */
function between(rows, depth) {
  for (let k = 1; k < rows.length; k++) {
    const [d0, a] = rows[k - 1], [d1, b] = rows[k], reach = k + 1 === rows.length ? 1.05 * d1 : d1;
    if (depth <= reach && depth >= d0) return { a, b, w: (depth - d0) / (d1 - d0) };
  }
  return null;
}

/** From the learned mesh to mesh m, at rest: both have the same nodes. */
const apart = m => add(model.meshes[m].nodes_m[0], model.meshes[0].nodes_m[0], -1);

/** The contact of now on the learned mesh at rest: the tool is where the pressed mesh's contact has gone. */
function contact_at_rest() {
  const pressed = state.v[IN.pressed];
  return add(add(pair(IN.proxy), pair(IN.moved + 2 * pressed), -1), apart(pressed), -1);
}

/** FE's curve [[depth, force], both along the push] for a push u at the contact of place k: by lines over the angle between
 *  two known pushes, else that of a push at most ASKEW off; null when there is neither. Force along the push turns with
 *  the push: 5 degrees are 3 per cent, which is more than a good mesh is wrong. */
function fe_curve(k, u) {
  const fan = model.fans.get(k), angle = turn(fan.from, u);
  const at = fan.pushes.findIndex(push => push.angle >= angle), [a, b] = [fan.pushes[at - 1], fan.pushes[at]];
  if (a && b && b.angle - a.angle <= BETWEEN) {
    const w = (angle - a.angle) / (b.angle - a.angle), [ca, cb] = [a, b].map(push => model.places[push.place].curve);
    return (ca.length < cb.length ? ca : cb).map(([depth]) => [depth, (1 - w) * on_curve(ca, depth) + w * on_curve(cb, depth)]);
  }
  const close = fan.pushes.find(push => Math.abs(push.angle - angle) <= ASKEW);
  return close ? model.places[close.place].curve : null;
}

/** From direction a to direction b, degrees, counter-clockwise. */
const turn = (a, b) => 180 / Math.PI * Math.atan2(a[0] * b[1] - a[1] * b[0], dot(a, b));

/** Depth and force along the push of one mesh, in a sample. */
const pushed = (sample, mesh) => {
  const u = sample.moved[mesh], depth = norm(u);
  return [depth, depth > 0 ? dot(sample.force, u) / depth : 0];
};

/** FE's surface under the push of now, in the plane, by the nodes of the learned mesh's outline; at the learned mesh's depth, as
 *  their force is. null where the server has none, and where contact or push is another than what was solved. */
function fe_outline() {
  if (!state || state.v[IN.pressed] < 0 || !near || near.place !== state.v[IN.place]) return null;
  const place = model.places[near.place], u = pair(IN.moved);
  if (!place || norm(u) < SHALLOW || norm(add(place.contact_m, contact_at_rest(), -1)) > NEAR) return null;
  const at = Math.abs(turn(place.direction, u)) <= ASKEW ? between(near.outline, dot(u, place.direction)) : null;
  const mesh = model.meshes[LEARNED];
  return at && mesh.outline.map((i, b) => add(add(mesh.nodes_m[i], at.a[b], 1 - at.w), at.b[b], at.w));
}

/** How each mesh compares with FE now: {why} when it cannot be said, else {errors: [learned, heuristic], place, ...}. */
function comparison() {
  if (!state || state.v[IN.pressed] < 0) return { why: "idle" };
  const k = state.v[IN.place], place = model.places[k];
  if (!place) return { why: "No known contact is near, so there is nothing to compare with." };
  const distance = norm(add(place.contact_m, contact_at_rest(), -1)), moved = pair(IN.moved);
  const deep = norm(moved) >= SHALLOW, askew = Math.abs(turn(place.direction, moved));
  const basis = { place: k, distance, askew: deep ? askew : NaN };
  if (!place.curve.length) return { ...basis, why: "This model carries no finite-element curves to compare with." };
  if (!deep) return { ...basis, why: "Press a little deeper: below 1 mm there is nothing to compare." };
  if (!(distance <= NEAR)) return { ...basis, why: `The nearest known contact is ${millimetres(distance)} away: too far to compare with.` };
  if (!fe_curve(k, moved)) return { ...basis, why: `This push is ${Math.round(askew)}° off the nearest known one: too far to compare with.` };
  // over the last half second, so that a ripple is not read as an error
  const now = state.v[IN.time], errors = model.meshes.map(() => 0);
  let n = 0, least = Infinity, most = 0;
  for (let s = samples.length - 1; s >= 0 && samples[s].pressed && samples[s].time > now - 0.5; s--, n++)
    errors.forEach((_, mesh) => {
      const [depth, force] = pushed(samples[s], mesh), curve = fe_curve(k, samples[s].moved[mesh]);
      errors[mesh] += curve ? force / on_curve(curve, depth) - 1 : NaN;
      if (mesh === LEARNED) [least, most] = [Math.min(least, depth), Math.max(most, depth)];
    });
  return { ...basis, errors: errors.map(e => e / n), moves: most - least > MOTION * most };
}

function judge() {
  const c = comparison(), verdict = $("verdict"), words = [];
  const say_words = (...parts) => {
    const key = JSON.stringify(parts);
    if (verdict.dataset.said === key) return;
    verdict.dataset.said = key;
    verdict.replaceChildren(...parts.map(part => {
      if (typeof part === "string") return part;
      const b = document.createElement("b");
      b.className = part[0];
      b.textContent = part[1];
      return b;
    }));
  };
  verdict.classList.toggle("idle", !c.errors || c.moves);
  if (!state) say_words(is_open() ? "Waiting for the tissue." : "No tissue yet.");
  else if (c.why === "idle") say_words("Nothing touches the tissue. Drag into a mesh, or let the demo press.");
  else if (c.why) say_words(c.why);
  else {
    const of = mesh => Number.isFinite(c.errors[mesh])
      ? [["learned", "heuristic"][mesh], `${percent(Math.abs(c.errors[mesh]))} too\u00a0${c.errors[mesh] > 0 ? "stiff" : "soft"}`] : null;
    const [l, h] = [of(LEARNED), of(HEURISTIC)];
    if (c.moves && (l || h)) words.push("In motion: ", ...l ? ["learned ", l] : [], l && h ? ", " : "", ...h ? ["heuristic ", h] : [],
                                        "; finite elements are of tissue at rest.");
    else if (l && model.meshes.length === 1) words.push("Against finite elements the learned mesh is ", l, ".");
    else if (l && h) words.push("Against finite elements the learned mesh is ", l, ", the heuristic one ", h, ".");
    else if (l) words.push("Against finite elements the learned mesh is ", l, "; the heuristic mesh is beyond what they know.");
    else if (h) words.push("Against finite elements the heuristic mesh is ", h, "; the learned mesh is beyond what they know.");
    else words.push("This is deeper than finite elements went.");
    say_words(...words);
  }
  if (c.place === undefined) say("basis", "");
  else {
    const push = Number.isFinite(c.askew) ? `, ${Math.round(c.askew)}° from its direction` : "";
    say("basis", `Nearest known contact: ${title(c.place)}; ${millimetres(c.distance)} away${push}. Per cent: force along the push over FE's at the same depth, less one.`);
  }
  return c;
}

function show_numbers(known) {
  if (!state) return;
  const v = state.v, force = norm(pair(IN.force)), pressed = v[IN.pressed] >= 0, moved = pair(IN.moved);
  const depth = mesh => pressed ? millimetres(norm(pair(IN.moved + 2 * mesh))) : "–";
  const curve = known && pressed && v[IN.place] >= 0 ? fe_curve(v[IN.place], moved) : null;
  say("force", newtons(force));
  say("device_force", newtons(norm(pair(IN.device))));
  say("learned_depth", depth(LEARNED));
  say("heuristic_depth", model.meshes[HEURISTIC] ? depth(HEURISTIC) : "–");
  say("fe_force", curve ? newtons(on_curve(curve, norm(moved))) : "–");
  say("spring_set", pressed && v[IN.set] >= 0 ? `${v[IN.set] + 1}` : "–");
  say("tick_rate", `${Math.round(v[IN.rate])} Hz`);
  say("tick_time", `${v[IN.p50].toFixed(1)} / ${v[IN.p99].toFixed(1)} µs`);
  say("misses", `${v[IN.misses]} / ${v[IN.misses_program]}`);
  say("clamped", `${v[IN.clamped]}`);
  say("faults", `${v[IN.faults]}${v[IN.fault] ? ", one now" : ""}`);
  say("visitors", `${v[IN.clients]}`);
}

/** Every few seconds and only on news: a screen reader is not a 60 Hz display. */
let spoken = "";
function speak(c) {
  if (!state) return;
  const depth = mesh => millimetres(norm(pair(IN.moved + 2 * mesh)));
  const text = state.v[IN.pressed] < 0 ? "Nothing touches the tissue."
    : `Force ${newtons(norm(pair(IN.force)))}: ${model.meshes.map((mesh, m) => `${mesh.name} mesh ${depth(m)} deep` +
      (c.errors && Number.isFinite(c.errors[m]) ? `, ${percent(Math.abs(c.errors[m]))} off finite elements` : "")).join("; ")}.`;
  if (text === spoken) return;
  say("spoken", spoken = text);
  $("depth_plot").setAttribute("aria-label", `Force against depth of both meshes and of finite elements. ${text}`);
}

// ---- controls

const option = (value, text) => {
  const o = document.createElement("option");
  o.value = value;
  o.textContent = text;
  return o;
};

function list_models() {
  $("model").replaceChildren(...model.models.map((name, k) => option(k, name)));
  $("model").value = model.model;
}

/** "top, x 50 mm" and the like: where a place is, on which side of the learned mesh. */
function where(place) {
  const { low, high } = model.box, [x, y] = place.contact_m, close = 1e-6, mm = v => `${+(1e3 * v).toFixed(1)} mm`;
  const [left, right, top] = [x < low[0] + close, x > high[0] - close, y > high[1] - close];
  if (top && (left || right)) return { side: "top", text: left ? "left corner" : "right corner", order: x };
  if (top) return { side: "top", text: `x ${mm(x - low[0])}`, order: x };
  if (left || right) return { side: left ? "left side" : "right side", text: `y ${mm(y - low[1])}`, order: y };
  return { side: "elsewhere", text: `x ${mm(x - low[0])}, y ${mm(y - low[1])}`, order: x };
}

/** "down" or "right, 20° up": a push in words. */
function way_of([x, y]) {
  const words = { right: [1, 0], up: [0, 1], left: [-1, 0], down: [0, -1] };
  const by_size = Object.keys(words).sort((a, b) => dot([x, y], words[b]) - dot([x, y], words[a]));
  const tilt = Math.round(180 / Math.PI * Math.acos(clamp(dot([x, y], words[by_size[0]]), -1, 1)));
  return by_size[0] + (tilt ? `, ${tilt}° ${by_size[1]}` : "");
}
const title = k => `${where(model.places[k]).side}, ${where(model.places[k]).text}, pushed ${way_of(model.places[k].direction)}`;

/** Contacts by side, then the directions in which the chosen one is pushed. */
function list_places() {
  const contacts = new Map();   // label -> {side, order, places}
  model.places.forEach((place, k) => {
    const at = where(place), key = `${at.side}, ${at.text}`;
    if (!contacts.has(key)) contacts.set(key, { ...at, places: [] });
    contacts.get(key).places.push(k);
  });
  model.contacts = [...contacts.values()].sort((a, b) => a.order - b.order);
  const at = model.contacts.map(contact => model.places[contact.places[0]].contact_m);
  model.fans = new Map();   // by place: the pushes at its contact, by angle
  for (const { places } of model.contacts) {
    const sum = places.reduce((all, k) => add(all, model.places[k].direction), [0, 0]);
    const from = norm(sum) > 1e-3 ? sum : model.places[places[0]].direction;
    const pushes = places.map(place => ({ place, angle: turn(from, model.places[place].direction) })).sort((a, b) => a.angle - b.angle);
    for (const k of places) model.fans.set(k, { from, pushes });
  }
  model.apart_m = Math.min(...at.flatMap((p, i) => at.slice(i + 1).map(q => norm(add(p, q, -1)))));   // Infinity for one
  const groups = ["left side", "top", "right side", "elsewhere"].map(side => {
    const group = document.createElement("optgroup");
    group.label = side;
    model.contacts.forEach((contact, k) => { if (contact.side === side) group.append(option(k, `${side}, ${contact.text}`)); });
    return group;
  });
  $("contact").replaceChildren(option(-1, "all, one after another"), ...groups.filter(group => group.children.length));
  list_ways();
}
function list_ways() {
  const contact = model.contacts[Number($("contact").value)], tilt = k => model.places[k].direction;
  const places = contact ? [...contact.places].sort((a, b) => Math.atan2(...tilt(a)) - Math.atan2(...tilt(b))) : [];
  $("way").replaceChildren(...places.length ? places.map(k => option(k, way_of(tilt(k)))) : [option(-1, "each")]);
  // begin with the push that is closest to straight in
  const into = contact && { "left side": [1, 0], "right side": [-1, 0] }[contact.side] || [0, -1];
  if (places.length) $("way").value = places.reduce((best, k) => dot(tilt(k), into) > dot(tilt(best), into) ? k : best);
}

function show_controls() {
  const open = is_open(), other = control.holder === "other";
  const line = $("connection");
  line.dataset.state = open ? "open" : socket.at ? "waiting" : "lost";
  say("connection", open ? "connected" : socket.at ? "connecting" : "no connection");
  for (const id of ["model", "contact", "way", "demo", "pause", "reset"]) $(id).disabled = !open || other;
  $("pause").setAttribute("aria-pressed", String(control.paused));
  say("pause", control.paused ? "Continue" : "Pause");
  $("demo").setAttribute("aria-pressed", String(control.holder === "demo"));
  let kind = "", text = "";
  if (!open && socket.reason) [kind, text] = ["bad", `The server said: ${socket.reason}. Trying again.`];
  else if (!open && socket.tries > 0) [kind, text] = ["bad", "The server does not answer. Trying again."];
  else if (!open) text = "";
  else if (control.paused) text = "Paused: time stands still.";
  else if (other) [kind, text] = ["held", "Another visitor holds the tissue. You are watching; it is yours as soon as they let go."];
  else if (control.holder === "demo")
    text = `Demo${model.places[control.place] ? `: ${title(control.place)}` : ""}. Drag into a mesh to take over.` +
      (calm() ? " Your system asks for little motion, so it is drawn once a second; Play demo shows all of it." : "");
  else if (control.holder === "you") text = "You hold the tissue.";
  $("notice").dataset.kind = kind;
  say("notice", text);
}

/** A demo that nobody asked for, before a visitor who wants little motion. */
let asked = false;
const calm = () => still.matches && control.holder === "demo" && !asked;

$("controls").addEventListener("submit", event => event.preventDefault());
$("model").addEventListener("change", () => tell({ type: "model", model: Number($("model").value) }));
const play = () => {
  asked = true;
  tell({ type: "demo", place: Number($("way").value) });
};
$("contact").addEventListener("change", () => { list_ways(); play(); });
$("way").addEventListener("change", play);
$("demo").addEventListener("click", play);
$("pause").addEventListener("click", () => tell({ type: "pause", on: !control.paused }));
$("reset").addEventListener("click", () => tell({ type: "reset" }));

// ---- the hand: pointer or keyboard, told to the server at most once a frame

const STEP = 0.001, LEAP = 0.005;   // m, of the arrow keys
const ALIVE = 500;                  // ms, between words while the hand rests

function take_hold(p, by) {
  if (!is_open() || hand.down || control.holder === "other") return;
  Object.assign(hand, { at: p, down: true, by, said: null, told: -Infinity });
}

function let_go(tells = true) {
  if (!hand.down) return;
  hand.down = false;
  if (tells) tell({ type: "pointer", x: hand.at[0], y: hand.at[1], down: false });
  if (hand.by !== "keys") hand.at = null;
}

function move_hand(now) {
  if (!hand.down || now - hand.told < (hand.said === hand.at ? ALIVE : 16)) return;
  hand.told = now;
  hand.said = hand.at;
  tell({ type: "pointer", x: hand.at[0], y: hand.at[1], down: true });
}

const stage = $("stage");
const in_plane = event => {
  const box = stage.getBoundingClientRect();
  return to_plane([event.clientX - box.left, event.clientY - box.top]);
};
stage.addEventListener("pointerdown", event => {
  if (!model || event.button !== 0 || hand.down) return;
  stage.setPointerCapture(event.pointerId);
  take_hold(in_plane(event), event.pointerId);
});
stage.addEventListener("pointermove", event => { if (hand.down && hand.by === event.pointerId) hand.at = in_plane(event); });
for (const name of ["pointerup", "pointercancel", "lostpointercapture"])
  stage.addEventListener(name, event => { if (hand.by === event.pointerId) let_go(); });
addEventListener("blur", () => let_go());
document.addEventListener("visibilitychange", () => { if (document.hidden) let_go(); });

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
function ready_hand() {   // where the keyboard begins: before the contact of the demo, outside
  if (!model || hand.at) return;
  const place = model.places[Math.max(0, model.demo)];
  hand.at = place ? add(place.contact_m, place.direction, -0.008) : add(model.low_m, [-0.01, -0.01]);
}
stage.addEventListener("focus", () => { ready_hand(); dirty = true; });
stage.addEventListener("blur", () => { if (hand.by === "keys") let_go(); dirty = true; });
stage.addEventListener("keydown", event => {
  if (!model || event.ctrlKey || event.altKey || event.metaKey) return;
  ready_hand();
  dirty = true;
  const arrow = ARROWS[event.key];
  if (arrow) {
    const to = add(hand.at, arrow, event.shiftKey ? LEAP : STEP);
    hand.at = [clamp(to[0], view.low[0], view.high[0]), clamp(to[1], view.low[1], view.high[1])];
  } else if (event.key === " " || event.key === "Enter") {
    if (event.repeat) { /* one press, one change */ }
    else if (hand.down) let_go();
    else take_hold(hand.at, "keys");
  } else if (event.key === "Escape") let_go();
  else return;
  event.preventDefault();
});

// ---- drawing: colours, canvases, axes

const VIRIDIS = ["#440154", "#481567", "#482677", "#453781", "#404788", "#39568c", "#33638d", "#2d708e", "#287d8e",
                 "#238a8d", "#1f968b", "#20a387", "#29af7f", "#3cbb75", "#55c667", "#73d055", "#95d840", "#b8de29",
                 "#dce319", "#fde725"];   // van der Walt and Smith, matplotlib: even steps, for every colour vision
const SHADES = (() => {
  const rgb = VIRIDIS.map(hex => [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16)));
  return Array.from({ length: 256 }, (_, k) => {
    const x = k / 255 * (rgb.length - 1), i = Math.min(Math.floor(x), rgb.length - 2);
    return `rgb(${rgb[i].map((c, d) => Math.round(c + (rgb[i + 1][d] - c) * (x - i))).join()})`;
  });
})();
const shade = x => SHADES[clamp(Math.round(255 * x), 0, 255)];

let colours = {};
function read_colours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["paper", "ink", "soft", "line", "grid", "learned", "heuristic", "fe"])
    colours[name] = style.getPropertyValue(`--${name}`).trim();
  colours.font = style.getPropertyValue("--sans");
}
const font = (px, weight = "") => `${weight} ${px}px ${colours.font}`;

/** A canvas as sharp as the screen; drawing is in CSS pixels. */
function begin(canvas) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const c = canvas.getContext("2d");
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, width, height);
  c.lineJoin = c.lineCap = "round";
  return { c, width, height };
}

/** About n round steps up to at least `most`. */
function nice(most, n = 4) {
  const raw = Math.max(most, 1e-12) / n, ten = 10 ** Math.floor(Math.log10(raw));
  const step = ten * [1, 2, 2.5, 5, 10].find(s => s * ten >= 0.999 * raw);
  return { step, top: step * Math.ceil(most / step - 1e-9), digits: Math.max(0, -Math.floor(Math.log10(step * 1.0001) - (step / ten === 2.5 ? 1 : 0) + 1e-9)) };
}

// ---- the stage: the plane, both meshes, the diamond, the arrows, the legend

const view = { low: [0, 0], high: [1, 1], scale: 1, left: 0, top: 0, legend: 54, head: 26 };
const to_screen = p => [view.left + view.scale * (p[0] - view.low[0]), view.top + view.scale * (view.high[1] - p[1])];
const to_plane = q => [view.low[0] + (q[0] - view.left) / view.scale, view.high[1] - (q[1] - view.top) / view.scale];

/** Scale of the plane, and the stage's height for it. */
function fit() {
  if (!model) return;
  const margin = 0.022, foot = 0.008;
  view.low = [model.low_m[0] - margin, model.low_m[1] - foot];
  view.high = [model.high_m[0] + margin, model.high_m[1] + margin * 0.7];
  const width = stage.clientWidth, size = add(view.high, view.low, -1);
  view.scale = Math.min(width / size[0], Math.max(240, 0.6 * innerHeight) / size[1]);
  view.left = (width - view.scale * size[0]) / 2;
  view.top = view.head;
  stage.style.height = `${Math.round(view.head + view.scale * size[1] + view.legend)}px`;
  dirty = true;
}

function draw_stage() {
  const { c, width, height } = begin(stage);
  if (!model) return;
  const narrow = width < 520;
  model.meshes.forEach((mesh, m) => draw_mesh(c, mesh, m, narrow));
  const fe = fe_outline();
  if (fe) draw_fe_outline(c, fe.map(to_screen));
  draw_marks(c);
  if (state) draw_forces(c);
  draw_diamond(c);
  draw_legend(c, width, height, narrow, fe !== null);
}

function trace(c, points, closed = true) {
  c.beginPath();
  points.forEach((p, k) => k ? c.lineTo(p[0], p[1]) : c.moveTo(p[0], p[1]));
  if (closed) c.closePath();
}

function draw_mesh(c, mesh, m, narrow) {
  const rest = mesh.nodes_m.map(to_screen);
  const at = state ? mesh.nodes_m.map((_, i) => to_screen(node(m, i))) : rest;
  const moved = at.map((p, i) => Math.hypot(p[0] - rest[i][0], p[1] - rest[i][1]) / view.scale / model.deepest_m);

  // displacement is linear over a triangle, so is its colour along the gradient
  c.lineWidth = 0.7;
  for (const [i, j, k] of mesh.faces) {
    trace(c, [at[i], at[j], at[k]]);
    const low = Math.min(moved[i], moved[j], moved[k]), high = Math.max(moved[i], moved[j], moved[k]);
    let fill = shade((low + high) / 2);
    if (high - low > 0.006) {
      const a = add(at[j], at[i], -1), b = add(at[k], at[i], -1), det = a[0] * b[1] - a[1] * b[0];
      const da = moved[j] - moved[i], db = moved[k] - moved[i];
      const g = [(da * b[1] - db * a[1]) / det, (db * a[0] - da * b[0]) / det], gg = dot(g, g);
      if (Math.abs(det) > 1e-3 && gg > 1e-12) {
        const from = add(at[i], g, (low - moved[i]) / gg), to = add(at[i], g, (high - moved[i]) / gg);
        fill = c.createLinearGradient(from[0], from[1], to[0], to[1]);
        const stops = 1 + Math.ceil(16 * (high - low));
        for (let s = 0; s <= stops; s++) fill.addColorStop(s / stops, shade(low + (high - low) * s / stops));
      }
    }
    c.fillStyle = c.strokeStyle = fill;
    c.fill();
    c.stroke();   // closes the hairline between neighbours
  }

  c.strokeStyle = "rgba(255, 255, 255, 0.5)";
  for (const [width, springs] of mesh.widths) {
    c.lineWidth = width * clamp(view.scale / 2600, 0.45, 1);
    c.beginPath();
    for (const [i, j] of springs) {
      c.moveTo(at[i][0], at[i][1]);
      c.lineTo(at[j][0], at[j][1]);
    }
    c.stroke();
  }

  // rest, dashed; the outline now, in the mesh's own colour
  c.setLineDash([4, 3]);
  c.strokeStyle = colours.soft;
  c.lineWidth = 1;
  trace(c, mesh.outline.map(i => rest[i]));
  c.stroke();
  c.setLineDash([]);
  c.strokeStyle = colours[mesh.name] || colours.ink;
  c.lineWidth = 2.2;
  trace(c, mesh.outline.map(i => at[i]));
  c.stroke();

  // what is held: a bar, hatched on the side away from the tissue
  c.strokeStyle = colours.ink;
  mesh.outline.forEach((i, k) => {
    const j = mesh.outline[(k + 1) % mesh.outline.length];
    if (!mesh.is_fixed.has(i) || !mesh.is_fixed.has(j)) return;
    const a = rest[i], ab = add(rest[j], a, -1), length = norm(ab), t = [ab[0] / length, ab[1] / length];
    const out = [-t[1], t[0]];   // screen y is down, and the outline counter-clockwise in the plane
    c.lineWidth = 2;
    trace(c, [a, rest[j]], false);
    c.stroke();
    c.lineWidth = 1;
    c.beginPath();
    const gap = narrow ? 5 : 7;
    for (let s = gap / 2; s < length; s += gap) {
      const p = add(a, t, s), q = add(add(p, out, gap), t, -gap);
      c.moveTo(p[0], p[1]);
      c.lineTo(q[0], q[1]);
    }
    c.stroke();
  });

  const middle = (Math.min(...rest.map(p => p[0])) + Math.max(...rest.map(p => p[0]))) / 2;
  c.fillStyle = colours[mesh.name] || colours.ink;
  c.textAlign = "center";
  c.textBaseline = "alphabetic";
  c.font = font(narrow ? 14 : 16, "600");
  c.fillText(mesh.name, middle, 17);
}

function draw_fe_outline(c, points, closed = true) {
  c.setLineDash([5, 5]);
  c.strokeStyle = colours.fe;
  c.lineWidth = 1.6;
  trace(c, points, closed);
  c.stroke();
  c.setLineDash([]);
}

/** Contacts that FE have solved, as dots on both outlines at rest; the closer they lie, the smaller. */
function draw_marks(c) {
  const gap = model.apart_m * view.scale, radius = clamp(gap / 7, 0.6, 2);
  c.fillStyle = gap < 14 ? colours.soft : colours.ink;
  for (const contact of model.contacts)
    for (const m of model.meshes.keys()) {
      const p = to_screen(add(model.places[contact.places[0]].contact_m, apart(m)));
      c.beginPath();
      c.arc(p[0], p[1], radius, 0, 2 * Math.PI);
      c.fill();
    }
}

/** Where the contact is on each mesh now, in the plane; null without one. */
const contacts = () => state.v[IN.pressed] < 0 ? null
  : model.meshes.map((_, m) => add(add(contact_at_rest(), apart(m)), pair(IN.moved + 2 * m)));

/** Newtons that one metre of arrow stands for: the strongest known push is as long as a quarter of the tissue is high. */
function arrow_scale() {
  const most = model.strongest_N || Math.max(1e-3, ...samples.map(s => norm(s.force)));
  return most / (0.25 * (model.high_m[1] - model.low_m[1]));
}

function arrow(c, from, to, colour) {
  const d = add(to, from, -1), length = norm(d);
  if (length < 2) return;
  const t = [d[0] / length, d[1] / length], n = [-t[1], t[0]], head = Math.min(11, 0.6 * length);
  const neck = add(to, t, -head);
  for (const [width, stroke] of [[6, colours.paper], [2.6, colour]]) {
    c.strokeStyle = c.fillStyle = stroke;
    c.lineWidth = width;
    trace(c, [from, neck], false);
    c.stroke();
    trace(c, [to, add(neck, n, head * 0.42), add(neck, n, -head * 0.42)]);
    c.fill();
    if (width > 3) { c.lineWidth = 3.4; c.stroke(); }
  }
}

function draw_forces(c) {
  const at = contacts(), force = pair(IN.force);
  if (!at || !Number.isFinite(norm(force))) return;
  at.forEach((p, m) => {
    const back = m === state.v[IN.pressed] ? 10 / view.scale / norm(force) : 0;   // its head stops at the diamond
    arrow(c, to_screen(add(p, force, -1 / arrow_scale() - back)), to_screen(add(p, force, -back)), colours.ink);
  });
}

function draw_diamond(c) {
  const pressed = state && state.v[IN.pressed] >= 0;
  const diamond = (p, size, filled) => {
    const [x, y] = to_screen(p);
    trace(c, [[x, y - size], [x + size, y], [x, y + size], [x - size, y]]);
    c.lineWidth = 4.5;
    c.strokeStyle = colours.paper;
    c.stroke();
    c.fillStyle = filled ? colours.ink : colours.paper;
    c.fill();
    c.lineWidth = 1.8;
    c.strokeStyle = colours.ink;
    c.stroke();
  };
  if (state) {
    const master = pair(IN.master), proxy = pressed ? pair(IN.proxy) : master;
    if (pressed) {   // the hand, a little deeper than the tool: the spring between them is the force
      const [a, b] = [to_screen(proxy), to_screen(master)];
      c.strokeStyle = "#ffffff";
      c.lineWidth = 1.5;
      trace(c, [a, b], false);
      c.stroke();
      c.beginPath();
      c.arc(b[0], b[1], 2, 0, 2 * Math.PI);
      c.fillStyle = "#ffffff";
      c.fill();
    }
    if (proxy.every(Number.isFinite)) diamond(proxy, 7, pressed);
  }
  if (document.activeElement === stage && hand.at && !hand.down && stage.matches(":focus-visible")) diamond(hand.at, 5.5, false);
}

function draw_legend(c, width, height, narrow, with_fe) {
  const y = height - 34, bar = Math.min(narrow ? 150 : 240, 0.42 * width), x = width - bar - (narrow ? 22 : 24), deepest = 1e3 * model.deepest_m;
  for (let k = 0; k < bar; k++) {
    c.fillStyle = shade(k / (bar - 1));
    c.fillRect(x + k, y, 1.5, 10);
  }
  c.font = font(12);
  c.fillStyle = colours.soft;
  c.textBaseline = "alphabetic";
  const { step } = nice(deepest, narrow ? 3 : 5);
  c.textAlign = "center";
  for (let mm = 0; mm <= deepest + 1e-9; mm += step) {
    const at = x + bar * mm / deepest;
    c.fillRect(at - 0.5, y + 10, 1, 4);
    c.fillText(`${+mm.toFixed(1)}${mm + step > deepest + 1e-9 ? " mm" : ""}`, at, y + 27);
  }
  c.textAlign = "right";
  c.fillText(narrow ? "displaced" : "displacement", x - 8, y + 10);

  // a force of round size as an arrow
  const per_m = arrow_scale(), round = nice(per_m * 0.02, 1), length = round.top / per_m * view.scale;
  const left = narrow ? 12 : 20;
  arrow(c, [left, y + 5], [left + length, y + 5], colours.ink);
  c.textAlign = "left";
  c.fillStyle = colours.soft;
  const unit = unit_of(round.top);
  c.fillText(`${+(round.top * unit.scale).toPrecision(2)} ${unit.name}${narrow ? "" : ", force of the tool"}`, left + length + 9, y + 10);
  if (!with_fe) return;
  draw_fe_outline(c, [[left, y + 23], [left + 25, y + 23]], false);
  c.fillText("FE", left + 34, y + 27);
}

// ---- plots

/** Frame, grid, ticks and labels; returns the map of a plot's units to pixels. */
function axes(c, width, height, x, y) {
  const box = { left: 46, top: 20, right: width - 12, bottom: height - 36 };
  const X = v => box.left + (box.right - box.left) * (v - x.low) / (x.high - x.low);
  const Y = v => box.bottom - (box.bottom - box.top) * v / y.high;
  c.font = font(12);
  c.lineWidth = 1;
  c.textBaseline = "middle";
  for (let v = 0; v <= y.high * 1.0001; v += y.step) {
    const at = Math.round(Y(v)) + 0.5;
    c.strokeStyle = v === 0 ? colours.soft : colours.grid;
    trace(c, [[box.left, at], [box.right, at]], false);
    c.stroke();
    c.fillStyle = colours.soft;
    c.textAlign = "right";
    c.fillText((v * y.scale).toFixed(y.digits), box.left - 7, at);
  }
  c.textAlign = "center";
  c.textBaseline = "top";
  for (let v = x.low; v <= x.high * 1.0001 + 1e-12; v += x.step) {
    const at = Math.round(X(v)) + 0.5;
    c.strokeStyle = v === x.low ? colours.soft : colours.grid;
    trace(c, [[at, box.top], [at, box.bottom]], false);
    c.stroke();
    c.fillStyle = colours.soft;
    c.fillText(String(+(v * x.scale).toFixed(2)).replace("-", "−"), at, box.bottom + 5);
  }
  c.textAlign = "right";
  c.fillText(x.label, box.right, box.bottom + 20);
  c.textAlign = "left";
  c.textBaseline = "alphabetic";
  c.fillText(y.label, 2, box.top - 8);
  return { X, Y, box };
}

const force_axis = most => {
  const unit = unit_of(most), ticks = nice(most * unit.scale);
  return { high: ticks.top / unit.scale, step: ticks.step / unit.scale, scale: unit.scale, digits: ticks.digits, label: unit.name };
};

function line(c, points) {
  c.beginPath();
  let pen = false;
  for (const [x, y] of points) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) pen = false;
    else if (pen) c.lineTo(x, y);
    else { c.moveTo(x, y); pen = true; }
  }
  c.stroke();
}

/** The samples of the press that goes on, or of the last one. */
function last_press() {
  let to = samples.length;
  while (to > 0 && !samples[to - 1].pressed) to--;
  let from = to;
  while (from > 0 && samples[from - 1].pressed) from--;
  return samples.slice(from, to);
}

function draw_depth_plot(comparable) {
  const { c, width, height } = begin($("depth_plot"));
  if (!model) return;
  const press = last_press(), now = state && state.v[IN.pressed] >= 0;
  const k = press.length ? press[press.length - 1].place : -1, place = model.places[k];
  const curve = place ? place.curve.length && fe_curve(k, press[press.length - 1].moved[LEARNED]) || place.curve : [];
  const meshes = model.meshes.map((_, m) => press.map(s => pushed(s, m)));
  const deepest = Math.max(model.deepest_m, ...meshes.flat().map(p => p[0]));
  const most = Math.max(...curve.map(p => p[1]), ...meshes[0].map(p => p[1]), curve.length ? 0 : model.strongest_N, 1e-4);
  const mm = nice(1e3 * deepest, 5);
  const { X, Y, box } = axes(c, width, height, { low: 0, high: mm.top * 1e-3, step: mm.step * 1e-3, scale: 1e3, label: "depth along the push (mm)" },
                             force_axis(most * 1.04));
  c.save();
  c.beginPath();
  c.rect(box.left - 5, box.top - 5, box.right - box.left + 10, box.bottom - box.top + 10);
  c.clip();
  // FE: what was solved as dots; faint while the contact is not the one that was solved
  c.globalAlpha = comparable ? 1 : 0.3;
  c.strokeStyle = c.fillStyle = colours.fe;
  c.lineWidth = 3;
  line(c, curve.map(([d, f]) => [X(d), Y(f)]));
  for (const [d, f] of curve) {
    c.beginPath();
    c.arc(X(d), Y(f), 3.4, 0, 2 * Math.PI);
    c.fill();
  }
  c.globalAlpha = 1;
  const mark = (m, x, y, size) => {
    c.fillStyle = m === LEARNED ? colours.learned : colours.heuristic;
    c.beginPath();
    if (m === LEARNED) c.arc(x, y, size, 0, 2 * Math.PI);
    else c.rect(x - 0.86 * size, y - 0.86 * size, 1.72 * size, 1.72 * size);
    c.fill();
  };
  c.globalAlpha = 0.7;   // the way here, with the tissue's ripples
  meshes.forEach((points, m) => {
    c.strokeStyle = m === LEARNED ? colours.learned : colours.heuristic;
    c.lineWidth = 1.4;
    line(c, points.map(([d, f]) => [X(d), Y(f)]));
  });
  c.globalAlpha = 1;
  if (now && press.length) {
    const ends = meshes.map(points => points[points.length - 1]);
    c.strokeStyle = colours.soft;   // one force, two depths
    c.lineWidth = 1;
    c.setLineDash([2, 3]);
    trace(c, ends.map(([d, f]) => [X(d), Y(f)]), false);
    c.stroke();
    c.setLineDash([]);
    ends.forEach(([d, f], m) => {
      c.strokeStyle = colours.paper;
      c.lineWidth = 3;
      mark(m, X(d), Y(f), 6);
      c.stroke();
      c.fill();
    });
  }
  c.restore();
  // key
  const names = [...model.meshes.map(mesh => mesh.name), "finite elements"];
  c.font = font(12);
  c.textAlign = "left";
  c.textBaseline = "middle";
  let x = box.right - names.reduce((sum, name) => sum + 36 + c.measureText(name).width, -14);
  names.forEach((name, m) => {
    const is_mesh = m < model.meshes.length;
    c.strokeStyle = is_mesh ? colours[name] : colours.fe;
    c.lineWidth = is_mesh ? 1.4 : 3;
    trace(c, [[x, 8], [x + 17, 8]], false);
    c.stroke();
    if (is_mesh) mark(m, x + 8.5, 8, 4);
    c.fillStyle = colours.ink;
    c.fillText(name, x + 22, 8.5);
    x += 36 + c.measureText(name).width;
  });
}

function draw_time_plot() {
  const { c, width, height } = begin($("time_plot"));
  if (!model) return;
  const now = state ? state.v[IN.time] : 0, shown = samples.filter(s => s.time >= now - WINDOW);
  const most = Math.max(0.3 * model.strongest_N, 1e-4, ...shown.map(s => norm(s.force)));
  const { X, Y } = axes(c, width, height, { low: -WINDOW, high: 0, step: 2, scale: 1, label: "time (s)" }, force_axis(most * 1.04));
  c.strokeStyle = colours.ink;
  c.lineWidth = 1.8;
  line(c, shown.map(s => [X(s.time - now), Y(norm(s.force))]));
}

// ---- once a frame

let dirty = true, drawn = -1, drawings = 0, words = 0, talk = 0, calmly = 0;

function frame(now) {
  requestAnimationFrame(frame);
  move_hand(now);
  if (now - words > 200) {   // five times a second: numbers that can be read
    words = now;
    const c = judge();
    if (comparable !== Boolean(c.errors) && !calm()) dirty = true;
    comparable = Boolean(c.errors);
    show_numbers(comparable);
    if (now - talk > 4000) {
      talk = now;
      speak(c);
    }
  }
  const fresh = states !== drawn && (!calm() || now - calmly > 1000);
  if (!fresh && !dirty) return;
  [dirty, drawn, calmly] = [false, states, fresh ? now : calmly];
  draw_stage();
  drawings++;
  draw_depth_plot(comparable);
  draw_time_plot();
}
let comparable = false;

const restyle = () => { read_colours(); fit(); dirty = true; };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", restyle);
still.addEventListener("change", show_controls);
addEventListener("resize", restyle);
restyle();
connect();
requestAnimationFrame(frame);

/** For tests and the curious, in SI units; every look is a copy. */
Object.defineProperty(window, "tissue", { value: Object.freeze({
  get connected() { return is_open(); },
  get study() { return model && model.study; },
  get places() { return model ? model.places.map(place => place.name) : []; },
  get control() { return { ...control }; },
  get states() { return states; },                            // received since the page was opened
  get time_s() { return state ? state.v[IN.time] : NaN; },
  get force_N() { return state ? pair(IN.force) : null; },    // of the tool on the tissue
  get pressed() { return state ? state.v[IN.pressed] : -1; },
  get contact_moved_m() { return state ? [pair(IN.moved), pair(IN.moved + 2)] : null; },
  get largest_displacement_m() {                              // of any node, a mesh
    return state ? model.meshes.map((mesh, m) => Math.max(...mesh.nodes_m.map((p, i) => norm(add(node(m, i), p, -1))))) : null;
  },
  get tick_rate_Hz() { return state ? state.v[IN.rate] : NaN; },
  get nearest() { return state ? state.v[IN.place] : -1; },   // known contact, index of places
  get distance_m() { return state && state.v[IN.place] >= 0 ? comparison().distance : NaN; },   // to it
  get fe_N() { return state ? state.v[IN.fe] : NaN; },        // FE force at the learned mesh's depth, the server's
  get fe_outline_m() { return fe_outline(); },                // FE's surface as it is drawn, in the plane; null without
  get outline() { return model ? [...model.meshes[LEARNED].outline] : []; },   // its nodes
  get springs() { return model ? model.meshes[LEARNED].springs.length : 0; },
  get hand_m() { return hand.at && [...hand.at]; },
  get drawn() { return drawings; },                           // times the stage was drawn
  get colours() { return { ...colours }; },
  get off_FE() { return comparison().errors || null; },       // learned, heuristic; relative
  on_screen(p) {                                              // of a point of the plane: CSS pixels in the window
    const box = stage.getBoundingClientRect(), q = to_screen(p);
    return [box.left + q[0], box.top + q[1]];
  },
  place(k) { return model ? structuredClone(model.places[k]) : null; },
}) });
})();
