// What has been learned from pokes: by the model that came, or while it plays from a tissue that the tool touches unseen.
import { look, model, moved } from "./state.js";
import { largest, smallest } from "./vectors.js";
import { $, newtons, percent, say } from "./words.js";

/** Whether the learned mesh is coloured by what it has learned from pokes, not by displacement. */
export const shows_learned = () => Boolean(model.learned) && $("learned_wanted").checked;
$("learned_wanted").addEventListener("change", recolour);

function recolour() {
  moved.fill(true);   // in space colours go with the places of nodes
  look.stale = true;
}

/** A "learned" message: another reading. */
export function take_learned(message) {
  if (!model) return;
  if (message.ended) Object.assign(model, { ended: message.ended, learned: message.learned ?? model.learned, reading: message.reading ?? model.reading, next: undefined });
  else Object.assign(model, { learned: message.learned, reading: message.reading, next: message.next });
  prepare_learned();
  recolour();
}

/** The scale of its colours, and the line of words about it. */
export function prepare_learned() {
  $("learned_row").hidden = !model.learned;
  $("reading_text").hidden = !model.learns;
  if (model.learns) say("reading_text", reading_words());
  if (!model.learned) return;
  const { factor, sd, pokes } = model.learned, least = smallest(factor), most = largest(factor), ring = model.dimension === 2 ? "; a ring is as wide as that is unsure" : "";
  model.learned.span = Math.max(Math.log(1.5), -Math.log(least), Math.log(most));
  const unsure = [...sd].sort((a, b) => a - b)[sd.length >> 1];
  say("learned_text", pokes === 0 ? `nothing found out yet: as stiff as trained, unsure by ${percent(Math.expm1(unsure))} in the median${ring}`
    : `what ${pokes} ${pokes === 1 ? "poke has" : "pokes have"} found: ${least.toFixed(2)} to ${most.toFixed(2)} times as stiff as trained, unsure by ${percent(Math.expm1(unsure))} in the median${ring}`);
}

function reading_words() {
  if (model.ended) return `Learning has ended, and the tissue stays as it has become: ${model.ended}.`;
  const next = model.next ? " The open arrow shows where a push would tell most." : "";
  const r = model.reading;
  if (!r) return `Press, and hold still for a second: that is a reading, unless the force is at its limit of ${newtons(model.force_max_N / model.force_scale)}.${next}`;
  const what = { learned: "The last reading was learned", gated: "The last reading was not believed", refused: "The last reading was of no use" }[r.status];
  return `${what}${r.why ? `: ${r.why}` : ""}.${r.warning ? ` ${r.warning}.` : ""}${next}`;
}
