// The stage of a plane model: both meshes, the diamond, the arrows, the legend.
import { arrow, begin, colours, font, shade, trace, warmth } from "./canvas.js";
import { apart, contact_at_rest, fe_outline } from "./compare.js";
import { faces } from "./faces.js";
import { arrow_scale, draw_fe_outline, draw_legend } from "./legend.js";
import { shows_learned } from "./learned.js";
import { leading, led_by, next_hand, own_hands } from "./hand.js";
import { LEARNED, IN, look, model, node, pressed_by, state, vector, vector_of } from "./state.js";
import { is_open } from "./transport.js";
import { add, clamp, dot, largest, norm, smallest } from "./vectors.js";
import { $ } from "./words.js";

export const stage = $("stage");
export const view = { low: [0, 0], high: [1, 1], scale: 1, left: 0, top: 0, legend: 54, head: 26 };
export const to_screen = p => [view.left + view.scale * (p[0] - view.low[0]), view.top + view.scale * (view.high[1] - p[1])];
export const to_plane = q => [view.low[0] + (q[0] - view.left) / view.scale, view.high[1] - (q[1] - view.top) / view.scale];

export const aimed = { at: null };   // the known contact that an indentation at the pointer would have

/** Sets the scale of the plane, and the stage's height for it. */
export function fit() {
  if (!model) return;
  const margin = 0.022, foot = 0.008;
  view.low = [model.low_m[0] - margin, model.low_m[1] - foot];
  view.high = [model.high_m[0] + margin, model.high_m[1] + margin * 0.7];
  const width = stage.clientWidth, size = add(view.high, view.low, -1);
  view.scale = Math.min(width / size[0], Math.max(240, 0.6 * innerHeight) / size[1]);
  view.left = (width - view.scale * size[0]) / 2;
  view.top = view.head;
  stage.style.height = `${Math.round(view.head + view.scale * size[1] + view.legend)}px`;
  look.stale = true;
}

/** Derives from the model message what drawing needs. */
export function prepare_plane() {
  for (const mesh of model.meshes) {
    mesh.faces = faces(mesh);
    mesh.is_fixed = new Set(mesh.fixed);
  }
  // line widths: root of stiffness over the median, in px, rounded to a few widths
  const all = model.meshes.flatMap(mesh => mesh.stiffness_N_m).sort((a, b) => a - b), median = all[all.length >> 1] || 1;
  for (const mesh of model.meshes) {
    mesh.widths = new Map();
    mesh.springs.forEach((spring, s) => {
      const width = clamp(Math.round(4 * Math.sqrt(mesh.stiffness_N_m[s] / median)) / 4, 0.5, 2.5);
      if (!mesh.widths.has(width)) mesh.widths.set(width, []);
      mesh.widths.get(width).push(spring);
    });
  }
}

export function draw_stage() {
  const { c, width, height } = begin(stage);
  if (!model) return;
  const narrow = width < 520;
  model.meshes.forEach((mesh, m) => draw_mesh(c, mesh, m, narrow));
  const fe = fe_outline();
  if (fe) draw_fe_outline(c, fe.map(to_screen));
  draw_marks(c);
  draw_aimed(c);
  draw_next(c);
  for (const { tool } of own_hands()) {
    if (state) draw_forces(c, tool);
    draw_diamond(c, tool);
  }
  draw_legend(c, width, height, view.scale, { surface: fe !== null }, { stiffest: shows_learned() ? Math.exp(model.learned.span) : 0 });
}

/** Draws the stiffness factor at each place. The radius of a node's ring is the standard deviation of the factor's
 *  logarithm in thirds of a spacing, 1 at most. */
function draw_learned(c, mesh, at) {
  const { factor, sd, span } = model.learned;
  for (const [i, j, k] of mesh.faces) {
    trace(c, [at[i], at[j], at[k]]);
    c.fillStyle = c.strokeStyle = warmth(Math.log(factor[i] * factor[j] * factor[k]) / 3 / span);
    c.fill();
    c.stroke();
  }
  const spring = mesh.springs[0], spacing = norm(add(at[spring[1]], at[spring[0]], -1));
  c.strokeStyle = colours.ink;
  at.forEach((p, i) => {
    c.beginPath();
    c.arc(p[0], p[1], Math.min(1, sd[i]) * spacing / 3, 0, 2 * Math.PI);
    c.stroke();
  });
}

function draw_mesh(c, mesh, m, narrow) {
  const rest = mesh.nodes_m.map(to_screen);
  const at = state ? mesh.nodes_m.map((_, i) => to_screen(node(m, i))) : rest;
  const moved = at.map((p, i) => Math.hypot(p[0] - rest[i][0], p[1] - rest[i][1]) / view.scale / model.deepest_m);

  // displacement is linear over a triangle, so its colour varies along the gradient
  c.lineWidth = 0.7;
  if (m === LEARNED && shows_learned()) draw_learned(c, mesh, at);
  else for (const [i, j, k] of mesh.faces) {
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

  // the outline at rest, dashed; the present outline in the mesh's own colour
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

  // fixed sides: a bar, hatched on the side away from the tissue
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

  const middle = (smallest(rest.map(p => p[0])) + largest(rest.map(p => p[0]))) / 2;
  c.fillStyle = colours[mesh.name] || colours.ink;
  c.textAlign = "center";
  c.textBaseline = "alphabetic";
  c.font = font(narrow ? 14 : 16, "600");
  c.fillText(mesh.name, middle, 17);
}

/** Draws the known contacts as dots on both outlines at rest; dots are smaller where contacts are closer. */
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

/** Marks the contact that an indentation would have. */
function draw_aimed(c) {
  if (!aimed.at || leading() || !is_open()) return;
  const [x, y] = to_screen(aimed.at);
  for (const [width, stroke] of [[4.5, colours.paper], [1.8, colours.ink]]) {
    c.beginPath();
    c.arc(x, y, 6.5, 0, 2 * Math.PI);
    c.lineWidth = width;
    c.strokeStyle = stroke;
    c.stroke();
  }
}

/** Draws the most informative next indentation, for a model that learns, as an open arrow onto its surface. */
function draw_next(c) {
  if (!model.next || !shows_learned()) return;
  const { contact_m, push_m } = model.next, tip = to_screen(add(contact_m, apart(LEARNED))), back = norm(push_m);
  const along = [push_m[0] / back, -push_m[1] / back], across = [-along[1], along[0]];
  const at = (t, s) => [tip[0] + t * along[0] + s * across[0], tip[1] + t * along[1] + s * across[1]];
  trace(c, [at(-2, 0), at(-12, 8), at(-12, 3), at(-26, 3), at(-26, -3), at(-12, -3), at(-12, -8)]);
  c.fillStyle = colours.paper;
  c.fill();
  c.lineWidth = 1.8;
  c.strokeStyle = colours.learned;
  c.stroke();
}

/** Present positions of a tool's contact on each mesh. A second tool has only the learned mesh. */
const contacts = tool => model.meshes.map((_, m) => add(add(contact_at_rest(tool), apart(m)), tool === 0 ? vector(IN.moved + 2 * m) : vector_of(tool, "moved")));

function draw_forces(c, tool) {
  const pressed = pressed_by(tool), force = vector_of(tool, "force");
  if (pressed < 0 || !Number.isFinite(norm(force))) return;
  contacts(tool).forEach((p, m) => {
    const back = m === pressed ? 10 / view.scale / norm(force) : 0;   // its head stops at the diamond
    arrow(c, to_screen(add(p, force, -1 / arrow_scale() - back)), to_screen(add(p, force, -back)), colours[model.meshes[m].name] || colours.ink);
  });
}

/** Draws the number of a tool beside its diamond. */
function number(c, k, [x, y]) {
  c.font = font(13, "600");
  c.textAlign = "left";
  c.textBaseline = "middle";
  c.lineWidth = 4;
  c.strokeStyle = colours.paper;
  c.strokeText(`${k}`, x + 11, y);
  c.fillStyle = colours.ink;
  c.fillText(`${k}`, x + 11, y);
}

function draw_diamond(c, tool) {
  const pressed = pressed_by(tool) >= 0;
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
    const master = vector_of(tool, "master"), proxy = pressed ? vector_of(tool, "proxy") : master;
    if (pressed) {   // the hand is a little deeper than the tool; the spring between them gives the force
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
    if (proxy.every(Number.isFinite)) {
      diamond(proxy, 7, pressed);
      if (model.tools > 1) number(c, tool + 1, to_screen(proxy));
    }
  }
  const keyed = !led_by("keys") && next_hand();
  if (keyed && keyed.tool === tool && is_open() && document.activeElement === stage && keyed.at && !keyed.down && stage.matches(":focus-visible")) diamond(keyed.at, 5.5, false);
}
