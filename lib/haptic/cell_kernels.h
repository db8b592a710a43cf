#pragma once

namespace tissue::kernel {

/// Inner loops of a law's cells in the tick (haptic/realtime_law.h), over n of them that lie one row apart. Pointers stand at the first one's. All arrays are
/// of the caller, and g is where pulls go before they are added up: several arrays, a fixed number of doubles apart.
constexpr int cells_at_once = 256;  ///< squares: their pulls stay in the first-level cache
constexpr int cubes_at_once = 64;

void add(int n, const double* __restrict g, double* __restrict f);  ///< f += g
void add_pair(int n, const double* __restrict g, double* f_i, double* f_j);  ///< f_i -= g, f_j += g, which may overlap
/// Multiplies each of the arrays of g by gain y; arrays begin `apart` doubles after each other.
void times(int n, const double* __restrict gain, const double* __restrict y, int arrays, int apart, double* __restrict g);

/// With P, Q the diagonals at rest and p, q what has been added to them, a square has grown by half of
///   P x q + p x Q + p x q,
/// in which nothing cancels. g is the pull at the ends of the first diagonal, h at those of the second; each is along the other diagonal, turned by
/// 90 degrees. a, b, c, d: displacement of the corners.
void squares(int n, const double* __restrict px, const double* __restrict py, const double* __restrict qx, const double* __restrict qy,
             const double* __restrict gain,
             const double* __restrict ax, const double* __restrict ay, const double* __restrict bx, const double* __restrict by, const double* __restrict cx,
             const double* __restrict cy, const double* __restrict dx, const double* __restrict dy, double* __restrict gx, double* __restrict gy, double* __restrict hx,
             double* __restrict hy);
/// The same in two parts, for squares that relax: twice what each has grown by, with both diagonals as they are now; then times() pulls.
void squares_grown(int n, const double* __restrict px, const double* __restrict py, const double* __restrict qx, const double* __restrict qy,
                   const double* __restrict ax, const double* __restrict ay, const double* __restrict bx, const double* __restrict by, const double* __restrict cx,
                   const double* __restrict cy, const double* __restrict dx, const double* __restrict dy, double* __restrict gx, double* __restrict gy,
                   double* __restrict hx, double* __restrict hy, double* __restrict grown);

/// Cubes of which a part may be tissue. cx, cy, cz: its centroid, from corner 0 in edge lengths; the displacement's gradient along an axis there is the bilinear mean of
/// the differences along the four edges. g gets what pulls at the corners, 8 * axis + corner, cubes_at_once apart. per_m: 1 / edge. ux, uy, uz: displacement of corner 0; up, in,
/// far: rows from corner 0 to 2, 4 and 6; 1, 3, 5 and 7 lie one behind 0, 2, 4 and 6. cubes_grown writes J - 1 to grown, and its g is for a pull of 1; times() scales it.
void cubes(int n, double per_m, const double* __restrict cx, const double* __restrict cy, const double* __restrict cz, const double* __restrict gain,
           const double* __restrict ux, const double* __restrict uy, const double* __restrict uz, int up, int in, int far, double* __restrict g);
void cubes_grown(int n, double per_m, const double* __restrict cx, const double* __restrict cy, const double* __restrict cz, const double* __restrict ux,
                 const double* __restrict uy, const double* __restrict uz, int up, int in, int far, double* __restrict g, double* __restrict grown);

}  // namespace tissue::kernel
