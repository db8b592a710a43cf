// What is known: written by what the server says and by the hand, read by everything else. PROTOCOL.md says what server
// and page tell each other. Inside: metres, newtons, seconds. mm, mN and percent only where people read.
import { nice } from "./scale.js";

export let model = null;        // the last "model" message, with what take_model() and others add
export let state = null;        // the last state: {v: 32 numbers, nodes: [Float32Array x, y of the learned mesh, of the heuristic]}
export let near = null;         // the last "near" message
export let control = { holder: "nobody", paused: false, place: -1 };
export const samples = [];      // what the plots show, oldest first
export let states = 0;          // since the page was opened
export const hand = { at: null, down: false, by: null };   // the visitor's, in the plane
export const look = { stale: true };   // something but the state has changed: draw anew

export const IN = { time: 0, ticks: 1, misses: 2, misses_program: 3, clamped: 4, faults: 5, rate: 6, p50: 7, p99: 8, master: 9,
             proxy: 11, pressed: 13, moved: 14, force: 18, device: 20, place: 22, fe: 23, set: 24, fault: 25, clients: 26 };
export const LEARNED = 0, HEURISTIC = 1;   // meshes; the second may be missing (--no-heuristic)
export const WINDOW = 10;                // s, of the plot over time

export const pair = i => [state.v[i], state.v[i + 1]];
export const node = (mesh, i) => [state.nodes[mesh][2 * i], state.nodes[mesh][2 * i + 1]];

/** A state of the server, as bytes. */
export function take_state(buffer) {
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

/** Another model: what was known of the one before is forgotten. */
export function take_model(message) {
  model = message;
  state = near = null;
  samples.length = 0;
  hand.at = null;
  model.deepest_m = nice(Math.max(0.005, ...model.places.map(place => place.depth_m)) * 1e3).top * 1e-3;
  model.strongest_N = Math.max(0, ...model.places.flatMap(place => place.curve.map(point => point[1])));
  const of = axis => model.meshes[LEARNED].nodes_m.map(p => p[axis]);
  model.box = { low: [Math.min(...of(0)), Math.min(...of(1))], high: [Math.max(...of(0)), Math.max(...of(1))] };
}
export const take_near = message => { near = message; };
export const take_control = message => { control = message; };
