// The page of `tissuectl serve`: an interactive Fig. 7 of the paper. This file calls the others, once a frame.
// Scripts can read the state of the page from window.tissue (see the end), which is read-only.
import { colours, read_colours } from "./canvas.js";
import { comparison, fe_outline } from "./compare.js";
import { calm, list_models, list_places, show_controls, still } from "./controls.js";
import { follow } from "./follow.js";
import { let_all_go, let_go, move_hands } from "./hand.js";
import { prepare_learned, take_learned } from "./learned.js";
import { judge, show_numbers, speak } from "./numbers.js";
import { group_places } from "./places.js";
import { draw_stage, fit, prepare_plane, stage, to_screen } from "./plane.js";
import "./plane_hand.js";
import { draw_depth_plot, draw_time_plot } from "./plots.js";
import { farthest } from "./rest.js";
import { lead_plane } from "./snap.js";
import { IN, LEARNED, control, hands, is_solid, look, model, pressed_by, relaxes, samples, state, states, take_control, take_model, take_near, take_state, vector, vector_of, work } from "./state.js";
import { connect, is_open, socket } from "./transport.js";
import { $, relaxing, say } from "./words.js";

function heard(message) {
  if (message.type === "model") {
    socket.tries = 0;
    show_model(message);
  } else if (message.type === "control") {
    for (const hand of hands) if (message.holders[hand.tool] === "other" && control.holders[hand.tool] !== "other") let_go(hand, false);
    take_control(message);
  } else if (message.type === "learned") take_learned(message);
  else if (message.type === "near") take_near(message);
  else if (message.type === "bye") socket.reason = message.reason;
  show_controls();
}

const two_meshes = { title: $("title").textContent, lead: $("lead").textContent };
const without_curves = { ...two_meshes, lead: two_meshes.lead.split(" The thick curve")[0] };
const one_mesh = {
  title: "Force on a trained mesh",
  lead: "Indent the tissue model, which was trained on finite elements. Force, depth and shape are compared where an FE reference exists.",
};
const one_mesh_without_curves = { ...one_mesh, lead: "Indent the tissue model, which was trained on finite elements. This model has no FE force curves." };
const learning = {
  title: "Adaptation to measurements",
  lead: "The tool touches two tissues at once: this model, trained on finite elements, and a target tissue that is not shown. When the hand is still, " +
    "the force of the target tissue is a measurement, to which the model adapts.",
};
const two_tools = {
  title: "Two tools on one tissue",
  lead: "Two tools indent a tissue model that was trained on finite elements under one tool. Each changes the force of the other, more so at small distance. Depth, plots and the text below the tissue are of the first tool.",
};

function show_model(message) {
  let_all_go(false);   // the hands held the previous tissue
  take_model(message);
  group_places();
  prepare_learned();
  const heading = model.learns ? learning : model.tools > 1 ? two_tools : model.meshes.length < 2 ? (model.strongest_N > 0 ? one_mesh : one_mesh_without_curves) : model.strongest_N > 0 ? two_meshes : without_curves;
  for (const id of ["title", "lead"]) say(id, heading[id]);
  $("grasp_row").hidden = !model.grasps;
  if (!model.grasps) $("grasp").checked = false;   // before the range of depths is set
  show_stage();
  $("spring_set").parentElement.hidden = model.law;
  const two = model.tools > 1, both = model.meshes.length > 1;
  for (const id of ["stays_row", "help_second"]) $(id).hidden = !two;
  $("second_force").parentElement.hidden = !two;
  $("heuristic_depth").parentElement.hidden = !both;
  say("force_of", two ? "force of the first tool" : "force on the tissue");
  for (const [id, help] of [["stage", "help"], ["space", "help_space"]]) $(id).setAttribute("aria-describedby", two ? `${help} help_second` : help);
  $("stage").setAttribute("aria-label", both ? "Two tissue meshes, learned on the left, heuristic on the right" : "The learned tissue mesh");
  $("space").setAttribute("aria-label", both ? "Two solids, learned and heuristic, seen from the same side" : "The learned solid");
  list_models();
  list_places();
  document.title = `${model.study} – tissuectl`;
  say("about", `Study ${model.study}: ${model.node_count} nodes and ${model.spring_count} springs per mesh, ` +
      `step ${1e3 * model.dt_s} ms, dynamics ${[...new Set(Object.values(model.dynamics))].join(" and ")}; device force: ${model.force_scale === 1 ? "" : `${model.force_scale} times `}` +
      `the tissue's force, ${model.force_max_N} N at most. ${relaxes() ? `The tissue relaxes: ${relaxing()}. ` : ""}${is_solid() ? "" : `Line width: square root of stiffness${model.law ? "" : " (mean over spring sets)"}. `}Colour: displacement${model.learned ? ", or stiffness adapted from measurements" : ""}.`);
  fit_stage();
}

// ---- the stage: of the plane, or of space, whose files are loaded with the first model in space

let space = null;   // null: not loaded yet

function show_stage() {
  for (const [id, wanted] of [["stage", !is_solid()], ["help", !is_solid()], ["space_stage", is_solid()], ["help_space", is_solid()]])
    $(id).hidden = !wanted;
  say("space_fault", "");
  if (!is_solid()) prepare_plane();
  else if (space) prepare();
  else fetch_space();
}
async function fetch_space() {
  try {
    space = { ...await import("./space.js"), ...await import("./space_hand.js"), ...await import("./errors.js") };
  } catch (error) {
    return say("space_fault", `This browser cannot draw solids: ${error.message}`);
  }
  if (!is_solid()) return;
  prepare();
  fit_stage();
}
function prepare() {
  space.prepare_space();
  space.show_depth();
}
function fit_stage() {
  if (!is_solid()) fit();
  else if (space) space.fit_space();
}
function draw() {
  if (!is_solid()) draw_stage();
  else if (space) space.draw_space(comparable);
}

// ---- once a frame

let drawn = -1, drawings = 0, words = 0, talk = 0, calmly = 0, comparable = false, before = 0;

function frame(now) {
  requestAnimationFrame(frame);
  if (space && is_solid()) space.lead(now, before);
  else if (!is_solid()) lead_plane(now, before);
  before = now;
  move_hands(now);
  if (now - words > 200) {   // five times a second, so that the numbers are legible
    words = now;
    const c = judge();
    if (comparable !== Boolean(c.errors) && !calm()) look.stale = true;
    comparable = Boolean(c.errors);
    show_numbers(comparable);
    if (now - talk > 4000) {
      talk = now;
      speak(c);
    }
  }
  const fresh = states !== drawn && (!calm() || now - calmly > 1000);
  if (!fresh && !look.stale) return;
  [look.stale, drawn, calmly] = [false, states, fresh ? now : calmly];
  draw();
  drawings++;
  draw_depth_plot(comparable);
  draw_time_plot();
}

const restyle = () => { read_colours(); fit_stage(); look.stale = true; };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", restyle);
still.addEventListener("change", show_controls);
addEventListener("resize", restyle);
restyle();
connect({
  text: heard,
  state(buffer) {
    take_state(buffer);
    follow();
  },
  lost() {
    let_all_go(false);
    take_control({ holder: "nobody", holders: ["nobody", "nobody"], paused: false, place: -1 });
    look.stale = true;
  },
  changed: show_controls,
});
requestAnimationFrame(frame);

/** For tests and other scripts, in SI units. Every value is a copy. */
Object.defineProperty(window, "tissue", { value: Object.freeze({
  get connected() { return is_open(); },
  get study() { return model && model.study; },
  get places() { return model ? model.places.map(place => place.name) : []; },
  get control() { return { ...control }; },
  get states() { return states; },                            // received since the page was opened
  get time_s() { return state ? state.v[IN.time] : NaN; },
  get force_N() { return state ? vector(IN.force) : null; },    // of the tool on the tissue
  get pressed() { return state ? state.v[IN.pressed] : -1; },
  get contact_moved_m() { return state ? [vector(IN.moved), vector(IN.moved + 2)] : null; },
  get largest_displacement_m() {                              // of any node, per mesh
    return state ? model.meshes.map((_, m) => farthest(m)) : null;
  },
  get tick_rate_Hz() { return state ? state.v[IN.rate] : NaN; },
  get nearest() { return state ? state.v[IN.place] : -1; },   // known contact, index of places
  // to the nearest known contact
  get distance_m() { return state && state.v[IN.place] >= 0 ? comparison().distance : NaN; },
  get fe_N() { return state ? state.v[IN.fe] : NaN; },        // FE force at the learned mesh's depth, from the server
  // FE force at each mesh's depth, through the Maxwell branches
  get fe_felt_N() { return samples.length ? [...samples[samples.length - 1].fe_N] : null; },
  // the most informative next indentation, for a model that learns
  get next() { return model && model.next ? structuredClone(model.next) : null; },
  get relaxation() { return model && structuredClone(model.relaxation); },
  // FE surface under the present indentation; null without one
  get fe_outline_m() { return fe_outline(); },
  get outline() { return model ? [...model.meshes[LEARNED].outline] : []; },   // its nodes in the learned mesh
  get springs() { return model ? model.spring_count : 0; },
  get dimension() { return model ? model.dimension : 0; },
  // nodes received in space; times to decode the last state and to update the drawing
  get work() { return { ...work }; },
  get solids() { return space && is_solid() ? model.meshes.map((_, m) => space.drawn_points(m)) : null; },   // null: not drawn yet
  get error_map() { return space && is_solid() && space.error_map(); },   // null: none is drawn
  get view() { return space && { ...space.view }; },          // degrees; zoom
  get pressing() { return space && space.pressing() || null; },       // the user's indentation in space
  get fe_shown_m() { return space && space.fe_shown(); },     // FE surface as drawn in space
  get hand_m() { return hands[0].at && [...hands[0].at]; },
  get tools() { return model ? model.tools : 0; },
  get second() { return state && model.tools > 1 ? { pressed: pressed_by(1), force_N: vector_of(1, "force"), tool_m: vector_of(1, "master") } : null; },
  get drawn() { return drawings; },                           // number of drawings of the stage
  get colours() { return { ...colours }; },
  get off_FE() { return comparison().errors || null; },       // relative errors, learned and heuristic
  on_screen(p) {                                              // CSS pixels of a point in the window
    const box = (is_solid() ? space.stage : stage).getBoundingClientRect(), q = is_solid() ? space.space_to_screen(p) : to_screen(p);
    return [box.left + q[0], box.top + q[1]];
  },
  place(k) { return model ? structuredClone(model.places[k]) : null; },
}) });
