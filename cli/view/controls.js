// The row of controls, and the line below it.
import { let_all_go, own_hands } from "./hand.js";
import { title, way_of } from "./places.js";
import { control, is_solid, model, relaxes } from "./state.js";
import { is_open, socket, tell } from "./transport.js";
import { dot } from "./vectors.js";
import { $, say } from "./words.js";

export const still = matchMedia("(prefers-reduced-motion: reduce)");

const option = (value, text) => {
  const o = document.createElement("option");
  o.value = value;
  o.textContent = text;
  return o;
};

export function list_models() {
  $("model").replaceChildren(...model.models.map((name, k) => option(k, name)));
  $("model").value = model.model;
}

/** Lists the contacts by side, and the directions of the chosen one. */
export function list_places() {
  const groups = (is_solid() ? ["top", "left side", "right side", "front", "back", "elsewhere"] : ["left side", "top", "right side", "elsewhere"]).map(side => {
    const group = document.createElement("optgroup");
    group.label = side;
    model.contacts.forEach((contact, k) => { if (contact.side === side) group.append(option(k, `${side}, ${contact.text}`)); });
    return group;
  });
  $("contact").replaceChildren(option(-1, "all, one after another"), ...groups.filter(group => group.children.length));
  list_ways();
}
const straight = k => dot(model.places[k].direction, model.places[k].inward);
function list_ways() {
  const contact = model.contacts[Number($("contact").value)], tilt = k => model.places[k].direction;
  const by_angle = is_solid() ? (a, b) => straight(b) - straight(a) : (a, b) => Math.atan2(...tilt(a)) - Math.atan2(...tilt(b));
  const places = contact ? [...contact.places].sort(by_angle) : [];
  $("way").replaceChildren(...places.length ? places.map(k => option(k, way_of(model.places[k]))) : [option(-1, "each")]);
  // select the direction that is closest to straight in
  if (is_solid()) return;   // it is the first one
  const into = contact && { "left side": [1, 0], "right side": [-1, 0] }[contact.side] || [0, -1];
  if (places.length) $("way").value = places.reduce((best, k) => dot(tilt(k), into) > dot(tilt(best), into) ? k : best);
}

export function show_controls() {
  const open = is_open(), other = control.holders.includes("other"), own = control.holders.includes("you");
  const line = $("connection");
  line.dataset.state = open ? "open" : socket.at ? "waiting" : "lost";
  document.body.dataset.connection = open ? "open" : socket.tries > 0 ? "lost" : "waiting";
  say("connection", open ? "connected" : socket.at ? "connecting" : "no connection");
  for (const id of ["model", "contact", "way", "demo", "pause", "reset"]) $(id).disabled = !open || other;
  $("pause").setAttribute("aria-pressed", String(control.paused));
  say("pause", control.paused ? "Continue" : "Pause");
  $("demo").setAttribute("aria-pressed", String(control.holder === "demo"));
  let kind = "", text = "";
  if (!open && socket.reason) [kind, text] = ["bad", `Server: ${socket.reason}. Trying again.`];
  else if (!open && socket.tries > 0) [kind, text] = ["bad", "The server does not answer. Trying again."];
  else if (!open) text = "";
  else if (control.paused) text = "Paused.";
  else if (other && own) [kind, text] = ["held", "You hold one tool, another user the other. The buttons are disabled until the other user releases it."];
  else if (other && control.holders.includes("nobody")) [kind, text] = ["held", "Another user indents with one tool. You can indent with the other one."];
  else if (other) [kind, text] = ["held", "Another user holds the tool. You can take it once it is released."];
  else if (control.holder === "demo")
    text = `Demo${model.places[control.place] ? `: ${title(control.place)}` : ""}. ${is_solid() ? "Press on a solid" : "Drag into a mesh"} to take over.` +
      (relaxes() ? " The tissue is reset before each indentation." : "") +
      (calm() ? " Your system prefers reduced motion, so it is drawn once a second; Play demo shows it in full." : "");
  else if (control.holder === "you") text = control.holders.every(holder => holder === "you") && model.tools > 1 ? "You hold both tools." : "You hold the tool.";
  $("notice").dataset.kind = kind;
  say("notice", text);
}

/** Whether the demo runs without a request while the user prefers reduced motion. */
let asked = false;
export const calm = () => still.matches && control.holder === "demo" && !asked;

$("controls").addEventListener("submit", event => event.preventDefault());
$("model").addEventListener("change", () => tell({ type: "model", model: Number($("model").value) }));
const play = () => {
  let_all_go();
  asked = true;
  tell({ type: "demo", place: Number($("way").value) });
};
/** Starts the demo at the chosen contact, unless this page has a tool in the tissue: then the lists only choose the
 *  next contact of the keyboard. */
const show_it = () => { if (!own_hands().some(hand => hand.down)) play(); };
$("contact").addEventListener("change", () => { list_ways(); show_it(); });
$("way").addEventListener("change", show_it);
$("demo").addEventListener("click", play);
$("pause").addEventListener("click", () => tell({ type: "pause", on: !control.paused }));
$("reset").addEventListener("click", () => tell({ type: "reset" }));
