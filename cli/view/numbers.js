// Texts and numbers about the present state.
import { comparison, fe_curve, on_curve } from "./compare.js";
import { title } from "./places.js";
import { away_from_rest } from "./rest.js";
import { HEURISTIC, IN, LEARNED, in_fault, is_solid, model, pressed_by, relaxes, samples, status_of, vector, vector_of, state } from "./state.js";
import { is_open } from "./transport.js";
import { norm } from "./vectors.js";
import { $, millimetres, newtons, percent, say, signed_percent } from "./words.js";

export function judge() {
  const c = comparison(), verdict = $("verdict");
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
  verdict.classList.toggle("idle", !c.errors || !is_open());
  if (!is_open()) say_words(state ? "No connection: the picture is the last one received." : "No connection, and no data yet.");
  else if (!state) say_words("Waiting for data.");
  else if (c.why === "idle" && without_force()) say_words(without_force());
  else if (c.why === "idle")
    say_words(away_from_rest() || `Nothing touches the tissue. ${is_solid() ? "Press on a solid" : "Drag into a mesh"}, or play the demo.`);
  else if (c.there)
    say_words(`No FE reference here: at the nearest known contact, ${millimetres(c.distance)} away, the FE force is ${newtons(c.there.fe_N)}; `,
              ["learned", "the learned mesh"], ` here has ${newtons(c.there.force)}.`);
  else if (c.why) say_words(c.why);
  else say_words(...verdict_on(c.meshes));
  if (c.place === undefined || !is_open()) say("basis", "");
  else {
    const push = Number.isFinite(c.askew) ? `, ${Math.round(c.askew)}° from its direction` : "";
    say("basis", `Nearest known contact: ${title(c.place)}; ${millimetres(c.distance)} away${push}. Force error: force along the displacement over the FE force ${relaxes() ? "without relaxation, passed through the Maxwell branches, " : ""}at the same depth, less\u00a01.`);
  }
  return c;
}

/** Cause of a missing force, by the status of the tick. */
const no_force = [
  "",
  "No force: the tool's position was refused.",
  "No force until the tool has left the tissue: move it out.",
  "No force: the surface is self-intersecting. Reset puts the tissue to rest.",
  "No force: the mesh diverged and was reset. Move the tool out of the tissue.",
];

/** The cause for the first tool that has one; "" without one. */
function without_force() {
  const tool = [0, 1].find(k => k < model.tools && status_of(k) > 0);
  return tool === undefined ? "" : model.tools > 1 ? no_force[status_of(tool)].replace("No force", `No force on the ${tool === 0 ? "first" : "second"} tool`) : no_force[status_of(tool)];
}

/** Cause of a missing error of a mesh. */
const reasons = {
  deep: "is indented deeper than the FE reference",
  shallow: "is indented less than 1\u00a0mm",
  askew: "is displaced in another direction than the FE reference",
  moves: "is still moving",
  remembers: "has force left from an earlier indentation",
  unsolved: "has force left from a part of this indentation without FE reference",
  folded: "is inverted",
  unknown: "has no force to compare",
};

/** The verdict as texts; errors of meshes are [class, text]. */
function verdict_on(meshes) {
  if (meshes[LEARNED].why === "moves") return ["In motion: the FE reference is in equilibrium; no comparison yet."];
  const of = m => [model.meshes[m].name, signed_percent(meshes[m].error)], measure = "Force error against the FE reference: ";
  const all = [...meshes.keys()], known = all.filter(m => !meshes[m].why), others = all.filter(m => meshes[m].why);
  const words = [];
  if (known.length === 2) words.push(`${measure}learned mesh `, of(LEARNED), ", heuristic mesh ", of(HEURISTIC));
  else if (known.length === 1) words.push(`${measure}${model.meshes[known[0]].name} mesh `, of(known[0]));
  else if (meshes.length === 2 && meshes[LEARNED].why === meshes[HEURISTIC].why) return [`No comparison: each mesh ${reasons[meshes[LEARNED].why]}.`];
  else words.push("No comparison");
  others.forEach((m, k) => words.push(known.length ? "; " : k ? ", " : ": ", `the ${model.meshes[m].name} mesh ${reasons[meshes[m].why]}`));
  return [...words, "."];
}

const NUMBERS = ["force", "second_force", "device_force", "learned_depth", "heuristic_depth", "fe_force", "spring_set", "tick_rate", "tick_time", "misses", "clamped", "faults", "visitors"];

export function show_numbers(known) {
  if (!state || !is_open()) {   // no number is up to date
    for (const id of NUMBERS) say(id, "–");
    return;
  }
  const v = state.v, force = norm(vector(IN.force)), pressed = v[IN.pressed] >= 0, moved = vector(IN.moved);
  const depth = mesh => pressed ? millimetres(norm(vector(IN.moved + 2 * mesh))) : "–";
  const curve = known && pressed && v[IN.place] >= 0 ? fe_curve(v[IN.place], moved) : null;
  say("force", newtons(force));
  say("second_force", model.tools > 1 ? newtons(norm(vector_of(1, "force"))) : "–");
  say("device_force", newtons(norm(vector(IN.device))));
  say("learned_depth", depth(LEARNED));
  say("heuristic_depth", model.meshes[HEURISTIC] ? depth(HEURISTIC) : "–");
  say("fe_force", !curve ? "–" : newtons(relaxes() ? samples[samples.length - 1].fe_N[LEARNED] : on_curve(curve, norm(moved))));
  say("spring_set", pressed && v[IN.set] >= 0 ? `${v[IN.set] + 1}` : "–");
  say("tick_rate", `${Math.round(v[IN.rate])} Hz`);
  say("tick_time", `${v[IN.p50].toFixed(1)} / ${v[IN.p99].toFixed(1)} µs`);
  say("misses", `${v[IN.misses]} / ${v[IN.misses_program]}`);
  say("clamped", `${v[IN.clamped]}`);
  say("faults", `${v[IN.faults]}${in_fault() ? ", one now" : ""}`);
  say("visitors", `${v[IN.clients]}`);
}

/** Updates the text for screen readers, every few seconds and only on a change. */
let spoken = "";
export function speak(c) {
  if (!state || !is_open()) return;
  const depth = mesh => millimetres(norm(vector(IN.moved + 2 * mesh)));
  const first = state.v[IN.pressed] < 0 ? ""
    : `${model.tools > 1 ? "First tool: force" : "Force"} ${newtons(norm(vector(IN.force)))}: ${model.meshes.map((mesh, m) => `${mesh.name} mesh indented ${depth(m)}` +
      (c.errors && Number.isFinite(c.errors[m]) ? `, force ${percent(Math.abs(c.errors[m]))} ${c.errors[m] > 0 ? "above" : "below"} the FE reference` : "")).join("; ")}.`;
  const second = pressed_by(1) < 0 ? "" : `Second tool: force ${newtons(norm(vector_of(1, "force")))}, depth ${millimetres(norm(vector_of(1, "moved")))}.`;
  const text = [first, second].filter(Boolean).join(" ") || without_force() || "Nothing touches the tissue.";
  if (text === spoken) return;
  say("spoken", spoken = text);
  $("depth_plot").setAttribute("aria-label", `Force over depth of each mesh and of the FE reference. ${text}`);
}
