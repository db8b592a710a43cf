// The nodule inside a solid, shown on request in a translucent organ. PROTOCOL.md defines its data.
import * as THREE from "./three.module.js";
import { apart } from "./compare.js";
import { look, model, moved } from "./state.js";
import { add, largest } from "./vectors.js";
import { $ } from "./words.js";

export const SEEN_THROUGH = 0.38;   // opacity of the organ; its shape and colours stay visible

export const shows_nodule = () => Boolean(model.nodule) && $("nodule_wanted").checked;
$("nodule_wanted").addEventListener("change", () => { moved.fill(true); look.stale = true; });

/** The nodule on one of the meshes. A point moves by the weighted sum of the displacements of its four nodes. */
export class Nodule {
  constructor({ points_m, facets, nodes, weights }, mesh, m) {
    this.rest = Float32Array.from(points_m.flatMap(p => add(p, apart(m))));
    Object.assign(this, { nodes, weights, mesh_rest: Float32Array.from(mesh.nodes_m.flat()), position: this.rest.slice() });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.position, 3));
    geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(facets.flat()), 1));
    this.drawn = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial());
    Object.assign(this.drawn, { frustumCulled: false, visible: false });
    this.follow(this.mesh_rest);
  }

  /** nodes: present positions of the mesh's nodes. */
  follow(nodes) {
    const { rest, position, mesh_rest } = this;
    this.nodes.forEach((four, v) => {
      for (let a = 0; a < 3; a++)
        position[3 * v + a] = four.reduce((at, n, k) => at + this.weights[v][k] * (nodes[3 * n + a] - mesh_rest[3 * n + a]), rest[3 * v + a]);
    });
    this.drawn.geometry.attributes.position.needsUpdate = true;
    this.drawn.geometry.computeVertexNormals();
  }

  /** For tests. */
  told() {
    const { rest, position } = this, far = this.nodes.map((_, v) => Math.hypot(...[0, 1, 2].map(a => position[3 * v + a] - rest[3 * v + a])));
    return { points: this.nodes.length, facets: this.drawn.geometry.index.count / 3, shown: this.drawn.visible, farthest_m: largest(far, 0) };
  }
}
