// Triangulation of a plane mesh from its springs.
import { add, norm } from "./vectors.js";

/** Triangles that tile a mesh at rest. Springs that cross a shorter one are left out. The others form a plane graph,
 *  whose bounded faces are traversed counter-clockwise and cut into fans. */
export function faces(mesh) {
  const at = mesh.nodes_m, cross = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const apart = (a, b, c, d) => Math.sign(cross(at[a], at[b], at[c])) * Math.sign(cross(at[a], at[b], at[d])) < 0;
  const length = ([i, j]) => norm(add(at[j], at[i], -1));
  const kept = [];
  for (const [i, j] of [...mesh.springs].sort((a, b) => length(a) - length(b)))
    if (!kept.some(([k, l]) => apart(i, j, k, l) && apart(k, l, i, j))) kept.push([i, j]);

  const around = at.map(() => []), angle = (i, j) => Math.atan2(at[j][1] - at[i][1], at[j][0] - at[i][0]);
  for (const [i, j] of kept) { around[i].push(j); around[j].push(i); }
  around.forEach((others, i) => others.sort((a, b) => angle(i, a) - angle(i, b)));
  const walked = new Set(), triangles = [];
  for (const start of kept.flatMap(([i, j]) => [[i, j], [j, i]])) {
    const face = [];
    for (let [i, j] = start; !walked.has(i * at.length + j);) {
      walked.add(i * at.length + j);
      face.push(i);
      const others = around[j];   // the next edge clockwise from the last one: the face is on the left
      [i, j] = [j, others[(others.indexOf(i) + others.length - 1) % others.length]];
    }
    const area = face.reduce((sum, n, k) => sum + cross([0, 0], at[n], at[face[(k + 1) % face.length]]), 0);
    if (area > 0) for (let k = 1; k + 1 < face.length; k++) triangles.push([face[0], face[k], face[k + 1]]);
  }
  return triangles;
}
