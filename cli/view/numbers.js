// What the visitor is told in words and numbers.
import { comparison, fe_curve, on_curve } from "./compare.js";
import { title } from "./places.js";
import { HEURISTIC, IN, LEARNED, is_solid, model, relaxes, samples, vector, state } from "./state.js";
import { is_open } from "./transport.js";
import { norm } from "./vectors.js";
import { $, millimetres, newtons, percent, say } from "./words.js";

export function judge() {
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
  else if (c.why === "idle") say_words(`Nothing touches the tissue. ${is_solid() ? "Press a solid" : "Drag into a mesh"}, or let the demo press.`);
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
    say("basis", `Nearest known contact: ${title(c.place)}; ${millimetres(c.distance)} away${push}. Per cent: force along the push over ${relaxes() ? "that of finite elements without relaxation, through the material's branches," : "FE's"} at the same depth, less one.`);
  }
  return c;
}

export function show_numbers(known) {
  if (!state) return;
  const v = state.v, force = norm(vector(IN.force)), pressed = v[IN.pressed] >= 0, moved = vector(IN.moved);
  const depth = mesh => pressed ? millimetres(norm(vector(IN.moved + 2 * mesh))) : "–";
  const curve = known && pressed && v[IN.place] >= 0 ? fe_curve(v[IN.place], moved) : null;
  say("force", newtons(force));
  say("device_force", newtons(norm(vector(IN.device))));
  say("learned_depth", depth(LEARNED));
  say("heuristic_depth", model.meshes[HEURISTIC] ? depth(HEURISTIC) : "–");
  say("fe_force", !curve ? "–" : newtons(relaxes() ? samples[samples.length - 1].fe_N[LEARNED] : on_curve(curve, norm(moved))));
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
export function speak(c) {
  if (!state) return;
  const depth = mesh => millimetres(norm(vector(IN.moved + 2 * mesh)));
  const text = state.v[IN.pressed] < 0 ? "Nothing touches the tissue."
    : `Force ${newtons(norm(vector(IN.force)))}: ${model.meshes.map((mesh, m) => `${mesh.name} mesh ${depth(m)} deep` +
      (c.errors && Number.isFinite(c.errors[m]) ? `, ${percent(Math.abs(c.errors[m]))} off finite elements` : "")).join("; ")}.`;
  if (text === spoken) return;
  say("spoken", spoken = text);
  $("depth_plot").setAttribute("aria-label", `Force against depth of both meshes and of finite elements. ${text}`);
}
