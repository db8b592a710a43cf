#pragma once

namespace tissue::kernel {

/// Inner loops over the cells of an energy model in the tick (haptic/realtime_energy_model.h). Each loop goes over n cells in
/// consecutive rows, and the pointers point to the first cell. The caller owns all arrays. g receives the forces of the
/// cells before they are added to the nodes; it consists of several arrays, a fixed number of doubles apart.
constexpr int cells_at_once = 256;  ///< squares: their forces stay in the first-level cache
constexpr int cubes_at_once = 64;   ///< cubes, which have 24 arrays of forces

void add(int n, const double* __restrict g, double* __restrict f);  ///< f += g
/// f_i -= g, f_j += g; f_i and f_j may overlap.
void add_pair(int n, const double* __restrict g, double* f_i, double* f_j);
/// g[k] *= gain[k] y[k] in each of `arrays` arrays of g, which begin `apart` doubles after each other.
void times(int n, const double* __restrict gain, const double* __restrict y, int arrays, int apart, double* __restrict g);

/// Forces of squares whose energy depends on their area. With P, Q the diagonals at rest and p, q their changes [m],
/// the area has grown by half of
///   P x q + p x Q + p x q,
/// which is free of cancellation. px, py, qx, qy: P and Q. gain: A / (4 a) [N/m3], with a the area at rest and the
/// energy A (growth of the area)^2 / (2 a). a, b, c, d: displacement of the corners [m].
/// g: dW/du at the third corner [N]; the first corner gets -g. h: the same at the fourth corner; the second gets -h.
/// Each is the other diagonal turned by 90 degrees, times gain and twice the growth.
void squares(int n, const double* __restrict px, const double* __restrict py, const double* __restrict qx, const double* __restrict qy,
             const double* __restrict gain,
             const double* __restrict ax, const double* __restrict ay, const double* __restrict bx, const double* __restrict by, const double* __restrict cx,
             const double* __restrict cy, const double* __restrict dx, const double* __restrict dy, double* __restrict gx, double* __restrict gy, double* __restrict hx,
             double* __restrict hy);
/// The same in two parts, for squares that relax. `grown` receives twice the growth of each area [m2]. g and h receive
/// the other diagonal in the deformed state, turned by 90 degrees. times() then scales g and h to forces.
void squares_grown(int n, const double* __restrict px, const double* __restrict py, const double* __restrict qx, const double* __restrict qy,
                   const double* __restrict ax, const double* __restrict ay, const double* __restrict bx, const double* __restrict by, const double* __restrict cx,
                   const double* __restrict cy, const double* __restrict dx, const double* __restrict dy, double* __restrict gx, double* __restrict gy,
                   double* __restrict hx, double* __restrict hy, double* __restrict grown);

/// Forces of cubes, which may be only partly tissue. The energy of a cube is A V (J - 1)^2 / 2, with J at the centroid
/// of its tissue. There the displacement gradient along an axis is the bilinear mean of the differences along the four
/// edges of that axis.
/// per_m: 1 / edge [1/m]. cx, cy, cz: the centroid from corner 0, in edge lengths. gain: A V [N m].
/// ux, uy, uz: displacement of corner 0 [m]. up, in, far: rows from corner 0 to corners 2, 4 and 6. Corners 1, 3, 5 and
/// 7 lie one row after corners 0, 2, 4 and 6. g: dW/du at the corners [N], in array 8 * axis + corner; the arrays are
/// cubes_at_once apart.
/// cubes_grown writes J - 1 to `grown`, and to g the forces for gain (J - 1) = 1. times() then scales g.
void cubes(int n, double per_m, const double* __restrict cx, const double* __restrict cy, const double* __restrict cz, const double* __restrict gain,
           const double* __restrict ux, const double* __restrict uy, const double* __restrict uz, int up, int in, int far, double* __restrict g);
void cubes_grown(int n, double per_m, const double* __restrict cx, const double* __restrict cy, const double* __restrict cz, const double* __restrict ux,
                 const double* __restrict uy, const double* __restrict uz, int up, int in, int far, double* __restrict g, double* __restrict grown);

}  // namespace tissue::kernel
