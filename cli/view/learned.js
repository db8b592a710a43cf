// What was learned from measurements: by an adapted model, or by one that adapts during the session to a target tissue
// that is not shown.
import { look, model, moved } from "./state.js";
import { largest, smallest } from "./vectors.js";
import { $, newtons, percent, say } from "./words.js";

/** Whether the learned mesh is coloured by its adapted stiffness, not by displacement. */
export const shows_learned = () => Boolean(model.learned) && $("learned_wanted").checked;
$("learned_wanted").addEventListener("change", recolour);

function recolour() {
  moved.fill(true);   // in space colours are updated with the positions of nodes
  look.stale = true;
}

/** Takes a "learned" message, the result of a measurement. */
export function take_learned(message) {
  if (!model) return;
  if (message.ended) Object.assign(model, { ended: message.ended, learned: message.learned ?? model.learned, reading: message.reading ?? model.reading, next: undefined });
  else Object.assign(model, { learned: message.learned, reading: message.reading, next: message.next });
  prepare_learned();
  recolour();
}

/** Sets the colour scale of the adapted stiffness, and the text about it. */
export function prepare_learned() {
  $("learned_row").hidden = !model.learned;
  $("reading_text").hidden = !model.learns;
  if (model.learns) say("reading_text", reading_words());
  if (!model.learned) return;
  const { factor, sd, pokes } = model.learned, least = smallest(factor), most = largest(factor), ring = model.dimension === 2 ? "; rings: standard deviation" : "";
  model.learned.span = Math.max(Math.log(1.5), -Math.log(least), Math.log(most));
  const median = [...sd].sort((a, b) => a - b)[sd.length >> 1], deviation = `standard deviation ${percent(Math.expm1(median))} (median)${ring}`;
  say("learned_text", pokes === 0 ? `no measurement yet: stiffness as trained, ${deviation}`
    : `${pokes} ${pokes === 1 ? "measurement" : "measurements"}: ${least.toFixed(2)} to ${most.toFixed(2)} times the trained stiffness, ${deviation}`);
}

function reading_words() {
  if (model.ended) return `Adaptation has ended: ${model.ended}. The model stays as adapted.`;
  const next = model.next ? " The open arrow shows the most informative next indentation." : "";
  const r = model.reading;
  if (!r) return `Indent and hold still for a second: that is a measurement, unless the force is at its limit of ${newtons(model.force_max_N / model.force_scale)}.${next}`;
  const what = { learned: "The last measurement was used", gated: "The last measurement was gated as improbable", refused: "The last measurement was refused" }[r.status];
  return `${what}${r.why ? `: ${r.why}` : ""}.${r.warning ? ` ${r.warning}.` : ""}${next}`;
}
