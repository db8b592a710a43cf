// What the visitor is told in words and numbers.
import { comparison, fe_curve, on_curve } from "./compare.js";
import { title } from "./places.js";
import { away_from_rest } from "./rest.js";
import { HEURISTIC, IN, LEARNED, in_fault, is_solid, model, pressed_by, relaxes, samples, status_of, vector, vector_of, state } from "./state.js";
import { is_open } from "./transport.js";
import { norm } from "./vectors.js";
import { $, millimetres, newtons, percent, say } from "./words.js";

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
  if (!is_open()) say_words(state ? "No connection: the picture is the last that came." : "No connection, and no tissue yet.");
  else if (!state) say_words("Waiting for the tissue.");
  else if (c.why === "idle" && without_force()) say_words(without_force());
  else if (c.why === "idle")
    say_words(away_from_rest() || `Nothing touches the tissue. ${is_solid() ? "Press a solid" : "Drag into a mesh"}, or let the demo press.`);
  else if (c.there)
    say_words(`Not solved here: at the nearest known contact, ${millimetres(c.distance)} away, finite elements take ${newtons(c.there.fe_N)} for this push; `,
              ["learned", "the learned mesh"], ` takes ${newtons(c.there.force)} here.`);
  else if (c.why) say_words(c.why);
  else say_words(...verdict_on(c.meshes));
  if (c.place === undefined || !is_open()) say("basis", "");
  else {
    const push = Number.isFinite(c.askew) ? `, ${Math.round(c.askew)}° from its direction` : "";
    say("basis", `Nearest known contact: ${title(c.place)}; ${millimetres(c.distance)} away${push}. Per cent: force along the push over ${relaxes() ? "that of finite elements without relaxation, through the material's branches," : "FE's"} at the same depth, less one.`);
  }
  return c;
}

/** Why the tool has no force, by what its tick came to. */
const no_force = [
  "",
  "No force: the tool's position was refused.",
  "No force until the tool has been outside the tissue: lead it out.",
  "No force: the tissue is folded. Reset puts it to rest.",
  "No force: the tissue came apart and was put to rest. Lead the tool out.",
];

/** The same of the first tool that has a reason; "" where none has. */
function without_force() {
  const tool = [0, 1].find(k => k < model.tools && status_of(k) > 0);
  return tool === undefined ? "" : model.tools > 1 ? no_force[status_of(tool)].replace("No force", `No force on the ${tool === 0 ? "first" : "second"} tool`) : no_force[status_of(tool)];
}

/** Why there is no number for a mesh: what is true of it. */
const reasons = {
  deep: "is deeper than finite elements went",
  shallow: "is less than 1\u00a0mm deep",
  askew: "is pushed another way than finite elements were",
  moves: "is still moving",
  remembers: "still remembers an earlier press",
  unsolved: "remembers a part of this press that no finite elements were solved for",
  folded: "is folded",
  unknown: "has no number to compare",
};

/** The verdict in words, names of meshes as [class, text]. */
function verdict_on(meshes) {
  if (meshes[LEARNED].why === "moves") return ["In motion: finite elements are of tissue at rest, so nothing is compared yet."];
  const of = ({ error }) => `${percent(Math.abs(error))} too\u00a0${error > 0 ? "stiff" : "soft"}`;
  const all = [...meshes.keys()], known = all.filter(m => !meshes[m].why), others = all.filter(m => meshes[m].why);
  const words = [];
  if (known.length === 2) words.push("Against finite elements the learned mesh is ", ["learned", of(meshes[LEARNED])], ", the heuristic one ", ["heuristic", of(meshes[HEURISTIC])]);
  else if (known.length === 1) words.push(`Against finite elements the ${model.meshes[known[0]].name} mesh is `, [model.meshes[known[0]].name, of(meshes[known[0]])]);
  else if (meshes.length === 2 && meshes[LEARNED].why === meshes[HEURISTIC].why) return [`Nothing to compare: each mesh ${reasons[meshes[LEARNED].why]}.`];
  else words.push("Nothing to compare");
  others.forEach((m, k) => words.push(known.length ? "; " : k ? ", " : ": ", `the ${model.meshes[m].name} mesh ${reasons[meshes[m].why]}`));
  return [...words, "."];
}

const NUMBERS = ["force", "second_force", "device_force", "learned_depth", "heuristic_depth", "fe_force", "spring_set", "tick_rate", "tick_time", "misses", "clamped", "faults", "visitors"];

export function show_numbers(known) {
  if (!state || !is_open()) {   // none that is true now
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

/** Every few seconds and only on news: a screen reader is not a 60 Hz display. */
let spoken = "";
export function speak(c) {
  if (!state || !is_open()) return;
  const depth = mesh => millimetres(norm(vector(IN.moved + 2 * mesh)));
  const first = state.v[IN.pressed] < 0 ? ""
    : `${model.tools > 1 ? "First tool: force" : "Force"} ${newtons(norm(vector(IN.force)))}: ${model.meshes.map((mesh, m) => `${mesh.name} mesh ${depth(m)} deep` +
      (c.errors && Number.isFinite(c.errors[m]) ? `, ${percent(Math.abs(c.errors[m]))} off finite elements` : "")).join("; ")}.`;
  const second = pressed_by(1) < 0 ? "" : `Second tool: force ${newtons(norm(vector_of(1, "force")))}, ${millimetres(norm(vector_of(1, "moved")))} deep.`;
  const text = [first, second].filter(Boolean).join(" ") || without_force() || "Nothing touches the tissue.";
  if (text === spoken) return;
  say("spoken", spoken = text);
  $("depth_plot").setAttribute("aria-label", `Force against depth of both meshes and of finite elements. ${text}`);
}
