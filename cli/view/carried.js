// The organ's own surface, finer than the model's boundary, which carries it. PROTOCOL.md defines its bytes.
import { Surface } from "./surface.js";

/** Fetches it as arrays: rest, facets, node and weight of each vertex. */
export async function fetch_carried() {
  const answer = await fetch("surface");
  if (!answer.ok) throw new Error(`The segmented organ surface could not be loaded (${answer.status}); the model's surface is drawn.`);
  const bytes = await answer.arrayBuffer(), [V, F] = new Uint32Array(bytes, 0, 2);
  let from = 8;
  const take = (Type, count) => {
    from += 4 * count;
    return new Type(bytes, from - 4 * count, count);
  };
  return { rest: take(Float32Array, 3 * V), facets: take(Uint32Array, 3 * F), node: take(Uint32Array, 3 * V), weight: take(Float32Array, 3 * V) };
}

const threes = numbers => Array.from({ length: numbers.length / 3 }, (_, i) => [...numbers.subarray(3 * i, 3 * i + 3)]);

/** That surface on one of the model's meshes, whose offset from the learned mesh is `apart`. */
export class Carried extends Surface {
  constructor({ rest, facets, node, weight }, mesh, apart, deepest_m) {
    super({ nodes_m: threes(rest).map(p => p.map((x, a) => x + apart[a])), facets: threes(facets), fixed: [] }, deepest_m);
    Object.assign(this, { node, weight, mesh_rest: Float32Array.from(mesh.nodes_m.flat()), places: this.rest.slice() });
  }

  find_edges() {}   // it is drawn without edges

  /** Moves the surface with the mesh. nodes, stiffness: of the mesh, as in Surface.update. */
  follow(nodes, stiffness = null) {
    const { places, rest, node, weight, mesh_rest } = this;
    for (let v = 0; v < rest.length; v += 3)
      for (let a = 0; a < 3; a++) {
        let moved = 0;
        for (let k = v; k < v + 3; k++) moved += weight[k] * (nodes[3 * node[k] + a] - mesh_rest[3 * node[k] + a]);
        places[v + a] = rest[v + a] + moved;
      }
    const own = stiffness && Array.from({ length: rest.length / 3 }, (_, v) => [0, 1, 2].reduce((sum, k) => sum + weight[3 * v + k] * stiffness[node[3 * v + k]], 0));
    this.update(places, own);
  }
}
