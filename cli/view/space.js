// The stage of a model in space, drawn by WebGL: each mesh in its own window of one canvas, all from one side.
import * as THREE from "./three.module.js";
import { Carried, fetch_carried } from "./carried.js";
import { begin, colours, shade, warmth } from "./canvas.js";
import { apart, contact_at_rest, fe_curve, fe_outline, on_curve } from "./compare.js";
import { error_dots, prepare_errors, shows_errors } from "./errors.js";
import { leading, next_hand } from "./hand.js";
import { shows_learned } from "./learned.js";
import { arrow_scale, draw_legend } from "./legend.js";
import { Nodule, SEEN_THROUGH, shows_nodule } from "./nodule.js";
import { IN, LEARNED, look, model, moved, pressed_by, relaxes, samples, state, vector, vector_of, work } from "./state.js";
import { Surface } from "./surface.js";
import { is_open } from "./transport.js";
import { add, clamp, norm, unit } from "./vectors.js";
import { $, say } from "./words.js";

export const stage = $("space");
const FIELD = 26;                                    // field of view, degrees
// of the colour scale: the FE surface is drawn where its displacement is larger
const SEEN = 0.03;
export const view = { azimuth: -62, elevation: 30, zoom: 1 };
// the point of the surface that the user points at, at rest in the page's space
export const aim = { mesh: 0, at: null, inward: null };

const renderer = new THREE.WebGLRenderer({ canvas: stage, antialias: true, alpha: true });
renderer.autoClear = false;
renderer.setClearColor(0x000000, 0);
const camera = new THREE.PerspectiveCamera(FIELD, 1, 0.001, 10);
camera.up.set(0, 0, 1);
const contrast = matchMedia("(prefers-contrast: more)");
const ray = new THREE.Raycaster();
let windows = [];                                    // one per mesh
let lost = false;

stage.addEventListener("webglcontextlost", event => { event.preventDefault(); lost = true; });
stage.addEventListener("webglcontextrestored", () => { lost = false; look.stale = true; });
contrast.addEventListener("change", () => look.stale = true);

/** The colour scales as a texture, with a row for displacement and one for stiffness. */
const scale = (() => {
  const data = new Uint8Array(2 * 3 * 256);
  for (let k = 0; k < 256; k++)
    [shade(k / 255), warmth(2 * k / 255 - 1)].forEach((rgb, row) => data.set(rgb.match(/\d+/g).map(Number), 3 * (256 * row + k)));
  const texture = new THREE.DataTexture(data, 256, 2, THREE.RGBFormat);
  texture.magFilter = texture.minFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
})();

const lines = (pairs, places, material) => {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6 * pairs.length), 3));
  const drawn = new THREE.LineSegments(geometry, material);
  drawn.frustumCulled = false;
  move_lines(drawn, pairs, places);
  return drawn;
};
function move_lines(drawn, pairs, places) {
  const { array } = drawn.geometry.attributes.position;
  pairs.forEach(([i, j], k) => {
    for (let a = 0; a < 3; a++) {
      array[6 * k + a] = places[3 * i + a];
      array[6 * k + 3 + a] = places[3 * j + a];
    }
  });
  drawn.geometry.attributes.position.needsUpdate = true;
}
const flat = (opacity = 1, more = {}) => new THREE.LineBasicMaterial({ transparent: opacity < 1, opacity, ...more });
const plain = (opacity = 1, more = {}) => new THREE.MeshBasicMaterial({ transparent: opacity < 1, opacity, ...more });

function arrow_of(material) {
  const group = new THREE.Group();
  group.shaft = new THREE.Mesh(new THREE.CylinderBufferGeometry(1, 1, 1, 16), material);
  group.head = new THREE.Mesh(new THREE.ConeBufferGeometry(1, 1, 20), material);
  group.add(group.shaft, group.head);
  group.traverse(part => { part.renderOrder = 5; });
  group.visible = false;
  return group;
}
/** Places an arrow between two points. It is hidden if it is shorter than 0.01 size. */
function set_arrow(arrow, from, to, size) {
  const along = new THREE.Vector3(...add(to, from, -1)), length = along.length();
  arrow.visible = Number.isFinite(length) && length > 0.01 * size;
  if (!arrow.visible) return;
  const head = Math.min(0.09 * size, 0.6 * length);
  arrow.position.set(...from);
  arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.divideScalar(length));
  arrow.shaft.scale.set(0.012 * size, length - head, 0.012 * size);
  arrow.shaft.position.set(0, (length - head) / 2, 0);
  arrow.head.scale.set(0.034 * size, head, 0.034 * size);
  arrow.head.position.set(0, length - head / 2, 0);
}

/** A band below the rim of the fixed facets. It moves with them where they lie on an elastic bed. */
function band_of(surface, size) {
  const out = surface.normals.filter((_, f) => surface.held[f]).reduce((a, n) => add(a, n), [0, 0, 0]);
  const down = (norm(out) > 0 ? unit(out) : [0, 0, -1]).map(x => 0.035 * size * x);
  const geometry = new THREE.BufferGeometry(), places = new Float32Array(18 * surface.rim.length);
  geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
  geometry.lay = position => {
    let at = 0;
    for (const [i, j] of surface.rim)
      for (const [node, below] of [[i, 0], [j, 0], [j, 1], [i, 0], [j, 1], [i, 1]])
        for (let axis = 0; axis < 3; ++axis) places[at++] = position[3 * node + axis] + below * down[axis];
    geometry.attributes.position.needsUpdate = true;
  };
  geometry.lay(surface.rest);
  const rest = places.slice();
  geometry.moved_m = () => rest.reduce((most, at, k) => Math.max(most, Math.abs(places[k] - at)), 0);
  return geometry;
}

function solid_of(surface, middle, size) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(surface.position, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(surface.normal, 3));
  geometry.setAttribute("uv", new THREE.BufferAttribute(surface.shade, 2));
  geometry.setIndex(new THREE.BufferAttribute(surface.corners, 1));
  geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(...middle), 3 * size);
  const solid = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ map: scale, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
  solid.frustumCulled = false;
  return solid;
}

/** Adds the organ's own surface to each window once it is loaded. */
async function take_carried() {
  const of = model;
  $("carried_row").hidden = true;
  if (!of.surface) return;
  const told = await fetch_carried();
  if (of !== model) return;
  for (const w of windows) {
    w.carried = new Carried(told, w.mesh, apart(w.m), model.deepest_m);
    w.fine = solid_of(w.carried, w.middle, w.size);
    w.root.add(w.fine);
    moved[w.m] = true;
  }
  $("carried_row").hidden = false;
  look.stale = true;
}
const update_solid = solid => { for (const name of ["position", "normal", "uv"]) solid.geometry.attributes[name].needsUpdate = true; };

function make_window(mesh, m) {
  const surface = new Surface(mesh, model.deepest_m), scene = new THREE.Scene(), root = new THREE.Group();
  const low = model.box.low, high = model.box.high, middle = add(add(low, high).map(x => x / 2), apart(m));
  const size = norm(add(high, low, -1)) / 2;                 // radius of the drawn mesh
  root.position.set(-middle[0], -middle[1], -middle[2]);
  scene.add(root);
  const sun = new THREE.DirectionalLight(0xffffff, 0.5);
  scene.add(new THREE.AmbientLight(0xffffff, 0.66), sun);

  const solid = solid_of(surface, middle, size);
  const wire = lines(surface.edges, surface.rest, flat(0.2, { color: 0xffffff }));
  const rest_edges = surface.creases.length >= 8 ? surface.creases : surface.edges;
  const rest = lines(rest_edges, surface.rest, new THREE.LineDashedMaterial({ dashSize: 0.03 * size, gapSize: 0.022 * size, transparent: true,
    opacity: rest_edges === surface.edges ? 0.25 : 0.9 }));
  rest.computeLineDistances();
  const held = new THREE.Mesh(band_of(surface, size), plain(1, { side: THREE.DoubleSide }));

  const fe_wire = lines(surface.edges, surface.rest, flat(0.85));   // FE surface

  const marks = new THREE.BufferGeometry();
  marks.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(model.contacts.flatMap(contact => {
    const place = model.places[contact.places[0]];
    return add(add(place.contact_m, apart(m)), place.inward, -0.006 * size);
  })), 3));
  const dots = new THREE.Points(marks, new THREE.PointsMaterial({ size: 4, sizeAttenuation: false, color: 0xffffff }));
  dots.frustumCulled = false;

  const fe_force = arrow_of(plain(0.96, { depthTest: false })), [{ radius_m: radius }] = model.tool;
  const tools = [...Array(model.tools).keys()].map(tool => drawn_tool(tool, size));
  const ring = new THREE.Mesh(new THREE.RingBufferGeometry(0.9 * radius, radius, 40), plain(0.9, { side: THREE.DoubleSide, depthTest: false, color: 0xffffff }));
  ring.renderOrder = 4;
  const nodule = model.nodule ? new Nodule(model.nodule, mesh, m) : null, errors = model.errors && m === LEARNED ? error_dots(size) : null;
  for (const part of [nodule && nodule.drawn, errors]) if (part) root.add(part);
  root.add(solid, wire, rest, held, fe_wire, dots, fe_force, ring, ...tools.flatMap(({ force, body, idle }) => [force, body, idle]));
  return { m, mesh, surface, scene, root, sun, middle, size, solid, wire, rest, held, fe_wire, dots, fe_force, tools,
           ring, nodule, errors, carried: null, fine: null, box: { left: 0, top: 0, width: 1, height: 1 } };
}

/** A tool as drawn in a window: its body on the tissue (white, the second tool grey), its force, and a mark at its
 *  position without contact. */
function drawn_tool(tool, size) {
  const { shape, radius_m: radius } = model.tool[tool], ball = shape === "ball", thick = (ball ? 2 : 0.5) * radius;
  const colour = tool === 0 ? 0xffffff : 0x8d99a6;
  const body = new THREE.Mesh(ball ? new THREE.SphereBufferGeometry(radius, 40, 24) : new THREE.CylinderBufferGeometry(radius, radius, thick, 40), plain(0.45, { depthWrite: false, color: colour }));
  body.add(new THREE.LineSegments(new THREE.EdgesGeometry(body.geometry, 40), flat(1, { color: colour })));
  body.renderOrder = 4;
  return { tool, body, thick, force: arrow_of(plain(0.96, { depthTest: false })), idle: new THREE.Mesh(new THREE.OctahedronBufferGeometry(0.045 * size), plain(1)), contact: null, inward: null };
}

/** Prepares the drawing of another model. */
export function prepare_space() {
  for (const w of windows)
    w.scene.traverse(part => {
      if (part.geometry) part.geometry.dispose();
      if (part.material) part.material.dispose();
    });
  $("nodule_row").hidden = !model.nodule;
  prepare_errors();
  windows = model.meshes.map(make_window);
  $("space_names").replaceChildren(...model.meshes.map(mesh => {
    const name = document.createElement("span");
    name.className = mesh.name;
    name.textContent = mesh.name;
    return name;
  }));
  Object.assign(view, { azimuth: -62, elevation: 30, zoom: 1 });
  Object.assign(aim, { mesh: 0, at: null, inward: null });
  const of = model;
  take_carried().catch(error => { if (of === model) say("space_fault", error.message); });
}
$("carried_wanted").addEventListener("change", () => { moved.fill(true); look.stale = true; });

export const narrow = () => stage.clientWidth < 520;

/** Arranges the windows side by side, or one below the other on a narrow screen, and sets the canvas's height. */
export function fit_space() {
  const width = stage.parentElement.clientWidth, count = windows.length || 1, stacked = width < 520;
  const each = stacked ? width : width / count;
  const height = Math.round(stacked ? Math.min(0.72 * each, 0.42 * innerHeight) : clamp(0.86 * each, 240, Math.max(260, 0.58 * innerHeight)));
  stage.style.height = `${stacked ? count * height : height}px`;
  windows.forEach((w, k) => { w.box = { left: stacked ? 0 : k * each, top: stacked ? k * height : 0, width: each, height }; });
  [...$("space_names").children].forEach((name, k) => {
    if (!windows[k]) return;
    name.style.left = `${windows[k].box.left + windows[k].box.width / 2}px`;
    name.style.top = `${windows[k].box.top + 4}px`;
  });
  look.stale = true;
}

function look_at(w) {
  const a = view.azimuth * Math.PI / 180, e = view.elevation * Math.PI / 180, aspect = w.box.width / w.box.height;
  const half = Math.atan(Math.tan(FIELD * Math.PI / 360) * Math.min(1, aspect)), distance = 0.95 * w.size / Math.sin(half) / view.zoom;
  camera.aspect = aspect;
  camera.near = Math.max(0.02 * distance, distance - 4 * w.size);
  camera.far = distance + 4 * w.size;
  camera.position.set(distance * Math.cos(e) * Math.cos(a), distance * Math.cos(e) * Math.sin(a), distance * Math.sin(e));
  camera.lookAt(0, 0, 0);
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
  const side = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0), up = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
  w.sun.position.copy(camera.position).normalize().addScaledVector(up, 0.9).addScaledVector(side, -0.6);
}

/** The directions right and up of the screen, in the tissue's space. */
export function screen_axes() {
  look_at(windows[0]);
  return [0, 1].map(k => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, k).toArray());
}

/** Updates the drawing from the nodes. */
function follow_tissue(w) {
  if (!moved[w.m]) return;
  moved[w.m] = false;
  const { factor, span } = model.learned || {}, nodes = state ? state.nodes[w.m] : w.surface.rest;
  const stiffness = w.m === LEARNED && shows_learned() ? factor.map(f => Math.log(f) / span) : null;
  w.surface.update(nodes, stiffness);   // needed for touches even if the other surface is drawn
  w.held.geometry.lay(nodes);
  if (w.nodule && shows_nodule()) w.nodule.follow(nodes);
  const fine = w.fine !== null && $("carried_wanted").checked;
  // the material, not the object: three.js casts no rays at invisible objects
  w.solid.material.visible = w.wire.visible = !fine;
  if (w.fine) w.fine.visible = fine;
  if (fine) {
    w.carried.follow(nodes, stiffness);
    update_solid(w.fine);
    return;
  }
  update_solid(w.solid);
  move_lines(w.wire, w.surface.edges, nodes);
}

/** Shows nodule and error map on request. The organ is translucent around the nodule. Under the dots of the error map
 *  it is grey, so that only the dots use the colour scale. */
function show_requested(w) {
  const through = shows_nodule(), errors = shows_errors();
  if (w.nodule) w.nodule.drawn.visible = through;
  if (w.errors) w.errors.visible = errors;
  w.dots.visible = !(errors && w.errors);
  for (const { material } of [w.solid, w.fine].filter(Boolean)) {
    Object.assign(material, { transparent: through, opacity: through ? SEEN_THROUGH : 1, depthWrite: !through });
    if ((material.map === null) === errors) continue;
    material.map = errors ? null : scale;
    material.color.set(errors ? 0xb4b6ba : 0xffffff);
    material.needsUpdate = true;
  }
}

function place_tool(w, t) {
  const pressed = pressed_by(t.tool), here = pressed === w.m;
  t.body.visible = here;
  const master = state ? vector_of(t.tool, "master") : null;
  const nearest = master && windows.reduce((best, o) => norm(add(master, o.middle, -1)) < norm(add(master, best.middle, -1)) ? o : best) === w;
  t.idle.visible = pressed < 0 && nearest && master.every(Number.isFinite);
  if (t.idle.visible) t.idle.position.set(...master);
  if (!here) return;
  const contact = add(contact_at_rest(t.tool), apart(w.m));
  if (!t.contact || norm(add(contact, t.contact, -1)) > 1e-4) Object.assign(t, { contact, inward: w.surface.inward_at(contact) });
  t.body.position.set(...add(vector_of(t.tool, "proxy"), t.inward, -t.thick / 2));
  t.body.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...t.inward));
}

function place_ring(w) {
  w.ring.visible = is_open() && !leading() && next_hand() !== undefined && pressed_by(next_hand().tool) < 0 && aim.at !== null && aim.mesh === w.m;
  if (!w.ring.visible) return;
  w.ring.position.set(...aim.at);
  w.ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, -1), new THREE.Vector3(...aim.inward));
}

/** Draws a tool's force on each mesh; for the first tool also the FE force, beside that on the learned mesh. */
function place_forces(w, t, comparable) {
  t.force.visible = false;
  if (t.tool === 0) w.fe_force.visible = false;
  if (pressed_by(t.tool) < 0) return;
  const force = vector_of(t.tool, "force"), u = t.tool === 0 ? vector(IN.moved + 2 * w.m) : vector_of(t.tool, "moved"), at = add(add(contact_at_rest(t.tool), apart(w.m)), u);
  if (!force.every(Number.isFinite) || !at.every(Number.isFinite)) return;
  set_arrow(t.force, add(at, force, -1 / arrow_scale()), at, w.size);
  const curve = comparable && t.tool === 0 && w.m === LEARNED && norm(u) > 0 ? fe_curve(state.v[IN.place], u) : null;
  const known = !curve ? NaN : relaxes() ? samples[samples.length - 1].fe_N[LEARNED] : on_curve(curve, norm(u));
  if (!Number.isFinite(known)) return;
  const beside = add(at, screen_axes()[0], 0.13 * w.size);
  set_arrow(w.fe_force, add(beside, unit(u), -known / arrow_scale()), beside, w.size);
}

function place_fe(w, points) {
  w.fe_wire.visible = points !== null;
  if (!points) return;
  const seen = points.map((p, i) => norm(add(p, w.mesh.nodes_m[i], -1)) > SEEN * model.deepest_m);
  move_lines(w.fe_wire, w.surface.edges.map(([i, j]) => seen[i] || seen[j] ? [i, j] : [i, i]), points.flat());
}

function colour(w) {
  const strong = contrast.matches, of = name => new THREE.Color(colours[name]);
  w.wire.material.opacity = strong ? 0.45 : w.fe_wire.visible ? 0.12 : 0.2;
  w.rest.material.color = of(strong ? "ink" : "soft");
  for (const part of [w.held, ...w.tools.map(t => t.idle)]) part.material.color = of("ink");
  if (w.nodule) w.nodule.drawn.material.color = of("nodule");
  w.fe_wire.material.color = of("fe_surface");
  for (const part of w.tools.flatMap(t => t.force.children)) part.material.color = of(w.mesh.name in colours ? w.mesh.name : "ink");
  w.fe_force.children.forEach(part => { part.material.color = of("fe"); });
}

let fe_drawn = null;
/** The FE surface as drawn, in the page's space; null without one, or if the user has switched it off. */
export const fe_shown = () => fe_drawn;

export function draw_space(comparable) {
  if (lost || windows.length === 0) return;
  const ratio = Math.min(devicePixelRatio || 1, 2), width = stage.clientWidth, height = stage.clientHeight;
  if (width === 0) return;
  if (stage.width !== Math.floor(width * ratio) || stage.height !== Math.floor(height * ratio)) {
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
  }
  const began = performance.now();
  fe_drawn = $("fe_wanted").checked ? fe_outline() : null;
  for (const w of windows) {
    follow_tissue(w);
    show_requested(w);
    for (const t of w.tools) {
      place_tool(w, t);
      place_forces(w, t, comparable);
    }
    place_ring(w);
    place_fe(w, w.m === LEARNED ? fe_drawn : null);
    colour(w);
  }
  work.update_ms = performance.now() - began;
  renderer.setScissorTest(false);
  renderer.clear();
  renderer.setScissorTest(true);
  for (const w of windows) {
    const bottom = height - w.box.top - w.box.height;
    renderer.setViewport(w.box.left, bottom, w.box.width, w.box.height);
    renderer.setScissor(w.box.left, bottom, w.box.width, w.box.height);
    look_at(w);
    renderer.render(w.scene, camera);
  }
  const { c, width: wide, height: high } = begin($("space_legend"));
  draw_legend(c, wide, high + 0, pixels_a_metre(), { surface: fe_drawn !== null, force: windows.some(w => w.fe_force.visible) },
    { stiffest: shows_learned() ? Math.exp(model.learned.span) : 0, worst: shows_errors() ? model.worst_error : 0 });
}

const pixels_a_metre = () => windows[0].box.height / (1.9 * windows[0].size) * view.zoom;

const window_at = (x, y) => windows.find(({ box }) => x >= box.left && x < box.left + box.width && y >= box.top && y < box.top + box.height);
const in_window = ({ box }, x, y) => new THREE.Vector2(2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height);

/** The point of a solid under the pointer: {mesh, at: on the surface at rest, inward}, in the page's space; null beside
 *  the solids and on fixed facets. */
export function touched(x, y) {
  const w = window_at(x, y);
  if (!w) return null;
  look_at(w);
  w.root.updateMatrixWorld(true);
  ray.setFromCamera(in_window(w, x, y), camera);
  const hit = ray.intersectObject(w.solid)[0];
  if (!hit || w.surface.held[hit.faceIndex]) return null;
  const p = new THREE.Vector3(...add(hit.point.toArray(), w.middle)), weight = new THREE.Vector3();
  const nodes = [hit.face.a, hit.face.b, hit.face.c], corner = k => new THREE.Vector3().fromArray(w.surface.position, 3 * nodes[k]);
  new THREE.Triangle(corner(0), corner(1), corner(2)).getBarycoord(p, weight);
  const rest = nodes.map(n => [...w.surface.rest.subarray(3 * w.surface.node_of[n], 3 * w.surface.node_of[n] + 3)]);
  const at = weight.toArray().reduce((sum, share, k) => add(sum, rest[k], share), [0, 0, 0]);
  return { mesh: w.m, at, inward: w.surface.normals[hit.faceIndex].map(x => -x) };
}

/** Pixels in the canvas of a point near one of the meshes. */
export function space_to_screen(point) {
  const w = windows.reduce((best, o) => norm(add(point, o.middle, -1)) < norm(add(point, best.middle, -1)) ? o : best);
  look_at(w);
  const p = new THREE.Vector3(...add(point, w.middle, -1)).project(camera);
  return [w.box.left + (p.x + 1) / 2 * w.box.width, w.box.top + (1 - p.y) / 2 * w.box.height];
}

export const drawn_points = m => {
  if (!windows[m]) return null;
  const w = windows[m], shown = w.fine && w.fine.visible ? w.carried : w.surface;
  return { points: shown.node_of.length, facets: shown.facets.length, band_moved_m: w.held.geometry.moved_m(),
           farthest_m: shown.farthest_m(), nodule: w.nodule && w.nodule.told() };
};
