#pragma once

#include <limits>
#include <string>
#include <vector>

#include "springs/contact_patch.h"
#include "springs/tissue_energy.h"

namespace tissue {

/// Constants before anything is learned: what linear elasticity asks of springs and cells.
///
/// Van Gelder's springs (7), k L^2 = E2 area(T_e), store E2 area(T_e) (n.strain n)^2 / 2 each; where their directions n
/// are spread evenly the mean of (n.strain n)^2 is (tr^2 + 2 strain:strain) / 8, so lambda = mu = E2 / 8 sum area(T_e) /
/// area: Cauchy's relation, springs/cell_areas.h. That is E2 / 2 on a lattice with both diagonals, 3/8 E2 on triangles.
/// Incompressible tissue has mu = E / 3, so springs are 2/3, or 8/9, of Van Gelder's, and leave lambda = E2 / 3. The cells
/// bring the rest:
///   plane stress  lambda = E2 nu / (1 - nu^2) = 2/3 E2 at nu = 1/2: A = E2 / 3, a modulus
///   plane strain  lambda is infinite: A is as large as the time step bears. The cap is that choice, not a modulus:
///                 at 12 E2 the fastest mode of a 10 mm lattice stays below 1.9e3 rad/s, under the 2 / dt of 1 ms
/// In space E takes the place of E2, and springs store E V_e (n.strain n)^2 / 2, of which the mean over directions is (tr^2 + 2
/// strain:strain) / 15: lambda = mu = E / 15 sum V_e / V. Scaled so that mu = E / 3. Cells have A up to the cap, as in plane strain.
/// A lattice has few directions, and is isotropic only with shares of its own (springs/isotropic_springs.h) in place of (7)'s: with those a cube resists a shear at 45
/// degrees to its axes 2.1 times as much as one along them. Squares have them anyway. Cells
/// so oblong that no shares are isotropic keep (7)'s.
/// Supports of a solid in an embedded lattice have 8 E area / spacing, on an elastic bed that and the bed in series.
/// Contact: between a rigid patch of half width b and the spline on nodes h apart lies the compliance
/// 3 / (2 pi E2) ln(r_spline / (b / 2)), r_spline = 0.43 h, of a half plane's logarithmic dent (Johnson, Contact
/// Mechanics, 2.3: both kernels' mean logarithm): 1 / (4 E2) for b = h / 2, the start for normal and tangent; a tenth
/// of it for the rows that keep the patch in line. Of a disc: springs/disc_rows.h.
struct LawHeuristic {
    bool incompressible = false; ///< plane strain: regions keep their area too (TissueEnergy), with the cells' mean A
    SpringCurve curve = {};      ///< of springs; what follows is of all curves, which are alike at rest
    Eigen::VectorXd constants;   ///< of a TissueEnergy [N/m] (E)
    Eigen::VectorXd cap;         ///< that cells stay below [N/m] (C)
    PatchLaw patch;              ///< the same everywhere
    Eigen::VectorXd stiffer = {};  ///< of a solid with a nodule or regions: log of springs' and cells' E over the base material's (S + C)
    NodeField ground = {};         ///< and these as points (springs/disc_contact.h)
    double disc_radius_m = 0, spacing_m = std::numeric_limits<double>::quiet_NaN();  ///< in space: of the disc, and the edge of the lattice's cubes
};

/// Of the supports of an embedded solid on a rigid bed, k = 8 E area / spacing: a cube gives way far more than its supports, which raise the fastest frequency by 2 to 11 %.
constexpr double support_stiffness = 8;

/// formulation: plane-stress or plane-strain. area_cap: of cells, over E2; plane strain starts 5 % below it.
/// Throws MismatchError for another formulation, or a cap that is not above E2 / 3.
/// Cells of a shape, which lie over each other in threes, have a third each.
LawHeuristic law_heuristic(const SpringMesh& mesh, double modulus_N_m, const std::string& formulation, double area_cap);

/// In space: moduli E of springs (S) and cells (C), and of what lies at the surface [Pa]; volume_cap of cells over E; radius of the disc that presses [m]; moduli at
/// the held nodes of an embedded solid (M), where they are not the surface's.
LawHeuristic solid_heuristic(const SpringMesh& mesh, const Eigen::VectorXd& spring_modulus_Pa, const Eigen::VectorXd& cell_modulus_Pa,
                             double surface_modulus_Pa, double volume_cap, double radius_m, const Eigen::VectorXd& support_modulus_Pa = {});

/// Where E2 differs from triangle to triangle (T) [N/m], on a shape; a contact has the largest of them.
LawHeuristic law_heuristic(const SpringMesh& mesh, const Eigen::VectorXd& triangle_modulus_N_m,
                           const std::string& formulation, double area_cap);

/// Where cells start at this part of their cap (plane strain, space), a stiffness is bent_factor(x) times its heuristic for
/// a sum of coefficients and terms x.
constexpr double start_below_cap = 0.95;
double bent_factor(double x);

/// An energy model's constants [N/m] (E) with other springs (S), without what keeps volumes or areas, and with the same supports.
Eigen::VectorXd springs_alone(const SpringMesh& mesh, const Eigen::VectorXd& constants, const Eigen::VectorXd& springs_N_m);

/// The contact of a disc of own_m where the disc is exp(log_times) times as large, on a lattice of that spacing: rows change as their start does (springs/disc_rows.h); terms with the factor size, of p (P), add to that.
PatchLaw resized(PatchLaw law, const std::vector<std::string>& terms, const Eigen::VectorXd& p, double own_m, double spacing_m, double log_times);
/// Whether a term is of a disc's radius.
bool is_size_term(const std::string& term);

/// Whether terms say that a disc's contact softens, and do not harden.
bool softens(const std::vector<std::string>& terms);

/// The constants of a tissue energy from few coefficients p (P), each of a named term of the rest mesh:
///   theta_s = heuristic_s exp(sum_t p_t term_t(s)),  k_m(place) = heuristic_m exp(...) likewise,
///   A_c = cap / (1 + (cap / heuristic_c - 1) exp(-sum_t p_t term_t(c))): the same, bending below the cap.
/// Positive whatever p, the same whatever pushes. A term is WHAT.FACTOR.FACTOR..., the product of its factors:
///   spring, cell    all         1
///                   surface     1 for a segment of the free surface, for a cell that has one, and about a node on it; in the plane
///                   layer       exp(-depth / spacing) below the free surface; spacing: mean of the surface's segments
///                   held        1 where one but not all nodes are held; in the plane
///                   x2 x4 y y2 y3 y4   powers of the place, over the half sizes of the mesh, from its middle
///   spring alone    along across    squared cosine to the nearest free surface, and to its normal
///                   upright         squared cosine to the normal of the nearest held edge
///                   horizontal vertical diagonal   1 for these springs of a lattice
///   in space        top bottom wall   exp(-distance / spacing) from the highest and the lowest place, from a block's sides
///                   z z2 z3 z4, and of x and y the even powers; spring alone horizontal vertical face body
///                   nodule      log(E / E_base), E in proportion to what of it lies in the nodule, or in named regions of a shape
///   contact.normal contact.tangent contact.rotation contact.stretch, alone or with one of: phase corner edge (PatchLaw)
///   of a disc normal tangent imprint_normal imprint_tangent hardening saturation coupling, with one of: curved
///                   ground edge (DiscContact); softening in place of hardening and saturation (ContactSpring);
///                   size        log(radius / disc's own): what a disc of another radius has beyond `resized`
///   support.all     1 for the supports of a solid
///   skin.normal skin.tangent skin.heave skin.radial   of a disc: in no constant, but in what is seen beside it (springs/skin.h)
class EnergyLaw {
   public:
    /// Throws MismatchError for a term that is not known, does not fit the mesh, is zero everywhere or stands twice.
    EnergyLaw(const SpringMesh& mesh, const LawHeuristic& heuristic, const std::vector<std::string>& terms);

    const std::vector<std::string>& terms() const { return terms_; }
    TissueEnergy energy(const SpringMesh& mesh) const { return {mesh, heuristic_.incompressible, heuristic_.curve}; }
    const NodeField& ground() const { return heuristic_.ground; }
    bool incompressible() const { return heuristic_.incompressible; }
    const SpringCurve& curve() const { return heuristic_.curve; }
    int size() const { return static_cast<int>(terms_.size()); }

    Eigen::VectorXd constants(const Eigen::VectorXd& p) const;     ///< [N/m] (E)
    Eigen::MatrixXd constants_by(const Eigen::VectorXd& p) const;  ///< their derivative (E x P)
    SkinLaw skin(const Eigen::VectorXd& p) const { return skin_of(terms_, p); }
    /// Of a disc that is exp(log_times) times as large as the heuristic's.
    PatchLaw patch(const Eigen::VectorXd& p, double log_times = 0) const;
    /// Derivative of PatchLaw::values_at a place of these factors (K x P).
    Eigen::MatrixXd stiffness_by(const Eigen::VectorXd& p, const ContactFactors& factors, double log_scale = 0, double log_times = 0) const;

   private:
    std::vector<std::string> terms_;
    LawHeuristic heuristic_;
    int springs_;                                ///< first constant of the cells
    Eigen::MatrixXd value_;                      ///< of each term at each element (E x P)
    std::vector<std::pair<int, int>> on_patch_;  ///< row and factor of PatchLaw, or -1
    bool softens_ = false;                       ///< of a disc: whether terms say softening, not hardening
};

}  // namespace tissue
