// The state of the page: set by messages of the server and by the hands, read by all other files. PROTOCOL.md defines
// the messages. Units are m, N and s; mm, mN and per cent occur only in texts.
import { nice } from "./scale.js";
import { largest, smallest } from "./vectors.js";

export let model = null;        // the last "model" message, with the additions of take_model() and others
export let state = null;        // the last state: {v: its numbers, nodes: [Float32Array of the learned mesh's nodes, of the heuristic's]}
export let near = null;         // the last "near" message
export let control = { holder: "nobody", holders: ["nobody", "nobody"], paused: false, place: -1 };
export const samples = [];      // samples of the plots, oldest first
export let states = 0;          // received since the page was opened
/** The user's hands, one per tool, in the tissue's space. at: target of the tool; pointer: in the plane the position of
 *  the pointer; press: the present indentation; before: the pointer one frame ago. */
export const hands = [0, 1].map(tool => ({ tool, at: null, pointer: null, down: false, by: null, press: null, before: null, said: null, told: -Infinity }));
export const moved = [true, true];     // in space, whether nodes of a mesh have moved since its last drawing
// nodes received in space since the page was opened; times for the last state
export const work = { nodes: 0, decode_ms: 0, update_ms: 0 };
export const look = { stale: true };   // whether a change other than a new state needs a drawing

export const IN = { time: 0, ticks: 1, misses: 2, misses_program: 3, clamped: 4, faults: 5, rate: 6, p50: 7, p99: 8, master: 9,
             proxy: 11, pressed: 13, moved: 14, force: 18, device: 20, place: 22, fe: 23, set: 24, fault: 25, clients: 26, rested: 27, status: 28, contact: 29 };
export const LEARNED = 0, HEURISTIC = 1;   // meshes; the second may be missing (--no-heuristic)
export const WINDOW = 10;                // s, of the plot over time

const HEAD = [0, 0, 32, 40];         // numbers at the head of a state, by dimension
const SECOND_HEAD = [0, 0, 14, 20];  // of a second tool, behind the first
// indices there; in space z follows
const SECOND = { pressed: 0, status: 1, master: 2, proxy: 4, moved: 6, force: 8, device: 10, contact: 12 };
const MOVED_NODES = 38;              // in space: index of the number of nodes in a state, per mesh
const Z = { 9: 32, 11: 33, 14: 34, 16: 35, 18: 36, 20: 37, 29: 31 };   // in space: index of z by the index of x

/** Whether the model relaxes. */
export const relaxes = () => model !== null && model.relaxation.tau_s.length > 0;
export const is_solid = () => model !== null && model.dimension === 3;
export const vector = i => is_solid() ? [state.v[i], state.v[i + 1], state.v[Z[i]]] : [state.v[i], state.v[i + 1]];
/** A vector of a tool: master, proxy, moved, force, device or contact. */
export const vector_of = (tool, what) => {
  if (tool === 0) return vector(IN[what]);
  const head = HEAD[model.dimension], at = head + SECOND[what];
  return is_solid() ? [state.v[at], state.v[at + 1], state.v[head + SECOND_HEAD[2] + (SECOND[what] - SECOND.master) / 2]] : [state.v[at], state.v[at + 1]];
};
/** The mesh that a tool touches; -1: none. */
export const pressed_by = tool => !state || tool >= model.tools ? -1 : tool === 0 ? state.v[IN.pressed] : state.v[HEAD[model.dimension] + SECOND.pressed];
/** Status of a tool's last tick (PROTOCOL.md). */
export const status_of = tool => tool === 0 ? state.v[IN.status] : state.v[HEAD[model.dimension] + SECOND.status];
/** Whether the last position of any tool was refused. */
export const in_fault = () => state.v[IN.fault] > 0 || model.tools > 1 && status_of(1) === 1;
const head_size = () => HEAD[model.dimension] + (model.tools > 1 ? SECOND_HEAD[model.dimension] : 0);
export function node(mesh, i) {
  const d = model.dimension;
  return Array.from(state.nodes[mesh].subarray(d * i, d * i + d));
}

/** Takes a state of the server in bytes. */
export function take_state(buffer) {
  if (!model) return;
  const began = performance.now(), nodes = is_solid() ? nodes_in_space(buffer) : nodes_in_plane(buffer);
  if (!nodes) return;   // a state of the previous model
  const v = new Float64Array(buffer, 0, head_size());
  if (!Number.isFinite(v[IN.time])) return;
  state = { v, nodes };
  states++;
  remember();
  work.decode_ms = performance.now() - began;
}

function nodes_in_plane(buffer) {
  const lengths = model.meshes.map(mesh => 2 * mesh.nodes_m.length);
  if (buffer.byteLength !== 8 * head_size() + 4 * lengths.reduce((a, b) => a + b)) return null;
  const nodes = [];
  let from = 8 * head_size();
  for (const length of lengths) {
    nodes.push(new Float32Array(buffer, from, length));
    from += 4 * length;
  }
  return nodes;
}

/** A state has only nodes that have moved; the others keep their positions. */
function nodes_in_space(buffer) {
  if (buffer.byteLength < 8 * head_size()) return null;
  const counts = [...new Float64Array(buffer, 8 * MOVED_NODES, 2)].slice(0, model.meshes.length);
  if (buffer.byteLength !== 8 * head_size() + 16 * counts.reduce((a, b) => a + b)) return null;
  const nodes = state ? state.nodes : model.meshes.map(mesh => Float32Array.from(mesh.nodes_m.flat()));
  let from = 8 * head_size();
  counts.forEach((count, m) => {
    const which = new Uint32Array(buffer, from, count), places = new Float32Array(buffer, from + 4 * count, 3 * count), to = nodes[m];
    for (let k = 0; k < count; k++) {
      to[3 * which[k]] = places[3 * k];
      to[3 * which[k] + 1] = places[3 * k + 1];
      to[3 * which[k] + 2] = places[3 * k + 2];
    }
    if (count > 0) moved[m] = true;
    work.nodes += count;
    from += 16 * count;
  });
  return nodes;
}

/** Adds one sample of the plots; follow.js adds the FE forces. Samples are in order of time; they restart if it
 *  goes back. */
function remember() {
  const time = state.v[IN.time], last = samples[samples.length - 1];
  if (last && time < last.time) samples.length = 0;
  else if (last && time === last.time) samples.pop();   // paused
  const pressed = state.v[IN.pressed] >= 0;
  samples.push({ time, pressed, alone: pressed_by(1) < 0, starts: pressed && !(last && last.pressed), force: vector(IN.force),
                 moved: [vector(IN.moved), vector(IN.moved + 2)], place: state.v[IN.place], fe: state.v[IN.fe] });
  while (samples[0].time < time - 2 * WINDOW) samples.shift();
}

/** Takes another model and discards the data of the previous one. */
export function take_model(message) {
  model = message;
  state = near = null;
  samples.length = 0;
  for (const hand of hands) hand.at = hand.pointer = null;
  model.relaxation ??= { tau_s: [], share: [] };
  model.deepest_m = nice(largest(model.places.map(place => place.depth_m), 0.005) * 1e3).top * 1e-3;
  model.strongest_N = largest(model.places.flatMap(place => place.curve.map(point => point[1])), 0);
  const of = axis => model.meshes[LEARNED].nodes_m.map(p => p[axis]);
  const axes = [...Array(model.dimension).keys()];
  model.box = { low: axes.map(axis => smallest(of(axis))), high: axes.map(axis => largest(of(axis))) };
  // nodes of the FE displacements
  if (is_solid()) for (const mesh of model.meshes) mesh.outline = mesh.nodes_m.map((_, i) => i);
  moved.fill(true);
}
export const take_near = message => { near = message; };
export const take_control = message => { control = message; };
