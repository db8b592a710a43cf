// The closed surface of a mesh in space as drawn. Nodes are split at creases; shading is smooth elsewhere.
import { clamp, cross, dot, norm } from "./vectors.js";

const CREASE = Math.cos(40 * Math.PI / 180);   // facets at a larger angle do not share a normal

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

export class Surface {
  /** mesh: nodes_m [[x, y, z]] at rest, facets [[i, j, k]] with outward normals, fixed [node]. */
  constructor(mesh, deepest_m) {
    this.deepest_m = deepest_m;
    this.rest = Float32Array.from(mesh.nodes_m.flat());
    this.facets = mesh.facets;
    const fixed = new Set(mesh.fixed), at = mesh.nodes_m;
    this.normals = mesh.facets.map(([i, j, k]) => {
      const n = cross(minus(at[j], at[i]), minus(at[k], at[i])), length = norm(n) || 1;
      return n.map(x => x / length);
    });
    this.held = mesh.facets.map(facet => facet.every(i => fixed.has(i)));
    this.part_nodes();
    this.find_edges();
    this.position = new Float32Array(3 * this.node_of.length);
    this.normal = new Float32Array(3 * this.node_of.length);
    // position on the colour scale, as texture coordinates u, v
    this.shade = new Float32Array(2 * this.node_of.length);
    this.update(this.rest);
  }

  /** Sets node_of, the node of each drawn point, and corners, three points per facet. */
  part_nodes() {
    const around = Array.from({ length: this.rest.length / 3 }, () => []);
    this.facets.forEach((facet, f) => facet.forEach(i => around[i].push(f)));
    this.node_of = [];
    this.corners = new Uint32Array(3 * this.facets.length);
    around.forEach((here, i) => {
      const left = new Set(here);
      while (left.size) {
        const group = [left.values().next().value];
        left.delete(group[0]);
        for (const f of group)
          for (const g of left)
            if (dot(this.normals[f], this.normals[g]) > CREASE) { group.push(g); left.delete(g); }
        for (const f of group) this.corners[3 * f + this.facets[f].indexOf(i)] = this.node_of.length;
        this.node_of.push(i);
      }
    });
  }

  /** Sets node pairs: edges, all sides of facets; creases; rim, those around the fixed facets. */
  find_edges() {
    const sides = new Map();
    this.facets.forEach((facet, f) => facet.forEach((i, k) => {
      const j = facet[(k + 1) % 3], key = i < j ? `${i} ${j}` : `${j} ${i}`;
      if (!sides.has(key)) sides.set(key, { pair: [i, j], facets: [] });
      sides.get(key).facets.push(f);
    }));
    const all = [...sides.values()];
    this.edges = all.map(side => side.pair);
    this.creases = all.filter(({ facets: [f, g] }) => g === undefined || dot(this.normals[f], this.normals[g]) < CREASE).map(side => side.pair);
    this.rim = all.filter(({ facets: [f, g] }) => g !== undefined && this.held[f] !== this.held[g]).map(side => side.pair);
  }

  /** Updates points, normals and colours. nodes: present x, y, z of every node. Colours are of displacement, the lower
   * row of the scale; or of stiffness, from -1 to 1 per node, the upper row. */
  update(nodes, stiffness = null) {
    const { position, normal, shade, node_of, corners, rest } = this;
    for (let p = 0; p < node_of.length; p++) {
      const i = 3 * node_of[p], x = nodes[i], y = nodes[i + 1], z = nodes[i + 2];
      position[3 * p] = x;
      position[3 * p + 1] = y;
      position[3 * p + 2] = z;
      shade[2 * p] = clamp(Math.hypot(x - rest[i], y - rest[i + 1], z - rest[i + 2]) / this.deepest_m, 0.002, 0.998);
      shade[2 * p + 1] = 0.25;
      if (stiffness) [shade[2 * p], shade[2 * p + 1]] = [clamp((1 + stiffness[node_of[p]]) / 2, 0.002, 0.998), 0.75];
    }
    normal.fill(0);
    for (let c = 0; c < corners.length; c += 3) {
      const i = 3 * corners[c], j = 3 * corners[c + 1], k = 3 * corners[c + 2];
      const ax = position[j] - position[i], ay = position[j + 1] - position[i + 1], az = position[j + 2] - position[i + 2];
      const bx = position[k] - position[i], by = position[k + 1] - position[i + 1], bz = position[k + 2] - position[i + 2];
      // its length is twice the area of the facet
      const nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
      for (const p of [i, j, k]) {
        normal[p] += nx;
        normal[p + 1] += ny;
        normal[p + 2] += nz;
      }
    }
    for (let p = 0; p < normal.length; p += 3) {
      const length = Math.hypot(normal[p], normal[p + 1], normal[p + 2]) || 1;
      normal[p] /= length;
      normal[p + 1] /= length;
      normal[p + 2] /= length;
    }
  }

  /** Largest displacement of a point, m. */
  farthest_m() {
    return this.node_of.reduce((most, i, p) => Math.max(most, Math.hypot(...[0, 1, 2].map(a => this.position[3 * p + a] - this.rest[3 * i + a]))), 0);
  }

  /** Unit normal into the tissue at a point of the surface, both at rest: that of the nearest free facet. */
  inward_at(point) {
    let best = Infinity, inward = [0, 0, -1];
    this.facets.forEach(([i, j, k], f) => {
      if (this.held[f]) return;
      const at = a => (this.rest[3 * i + a] + this.rest[3 * j + a] + this.rest[3 * k + a]) / 3 - point[a];
      const n = this.normals[f], off = at(0) * n[0] + at(1) * n[1] + at(2) * n[2];
      // distance from the facet's plane counts more
      const distance = at(0) ** 2 + at(1) ** 2 + at(2) ** 2 + 8 * off ** 2;
      if (distance < best) [best, inward] = [distance, n.map(x => -x)];
    });
    return inward;
  }
}
