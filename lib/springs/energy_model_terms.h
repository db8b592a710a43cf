#pragma once

#include <limits>
#include <string>
#include <vector>

#include "springs/contact_patch.h"
#include "springs/tissue_energy.h"

namespace tissue {

/// Constants of an energy model before training, from linear elasticity.
///
/// Springs: Van Gelder's springs (7), k L^2 = E2 area(T_e), store E2 area(T_e) (n.strain n)^2 / 2 each, with the
/// direction n. For evenly distributed directions the mean of (n.strain n)^2 is (tr^2 + 2 strain:strain) / 8. Hence
/// lambda = mu = E2 / 8 sum area(T_e) / area (Cauchy's relation, springs/cell_areas.h). That is E2 / 2 on a lattice
/// with both diagonals and 3/8 E2 on triangles. Incompressible tissue has mu = E / 3. The springs are therefore 2/3, or
/// 8/9, of Van Gelder's, which gives lambda = E2 / 3.
/// Cells provide the rest of lambda:
/// - plane stress: lambda = E2 nu / (1 - nu^2) = 2/3 E2 at nu = 1/2, thus A = E2 / 3, a modulus.
/// - plane strain: lambda is infinite, so A is as large as the time step permits. The cap is this choice and not a
///   modulus: at 12 E2 the fastest mode of a 10 mm lattice stays below 1.9e3 rad/s, under the limit 2 / dt at 1 ms.
///
/// In space E replaces E2, and springs store E V_e (n.strain n)^2 / 2. There the mean of (n.strain n)^2 is (tr^2 + 2
/// strain:strain) / 15: lambda = mu = E / 15 sum V_e / V, scaled here to mu = E / 3. Cells have A up to the cap, as in
/// plane strain.
///
/// A lattice has few directions and is isotropic only if its springs have other shares than those of (7)
/// (springs/isotropic_springs.h). With the shares of (7) a cube is 2.1 times as stiff against shear at 45 degrees to
/// its axes as against shear along them. For squares both sets of shares are equal. Cells too elongated for isotropic
/// shares keep those of (7).
///
/// Supports of a solid in an embedded lattice have 8 E area / spacing. On an elastic bed this is in series with the
/// bed.
///
/// Contact in the plane: between a rigid patch of half width b and the spline on nodes h apart lies the compliance 3 /
/// (2 pi E2) ln(r_spline / (b / 2)), r_spline = 0.43 h. It follows from the logarithmic displacement of a half plane
/// (Johnson, Contact Mechanics, 2.3) with the mean logarithm of both kernels. It is 1 / (4 E2) for b = h / 2. Normal
/// and tangent start at 4 E2. Rotation and stretch, which keep the patch straight, start at a tenth of that.
/// Contact of a disc: springs/disc_rows.h.
struct EnergyModelHeuristic {
    /// plane strain: regions conserve their area too (TissueEnergy), starting at the cells' mean A
    bool incompressible = false;
    /// force curve of the springs; the other members do not depend on it, as curves agree at rest
    SpringCurve curve = {};
    Eigen::VectorXd constants;   ///< of a TissueEnergy (E) [N/m], in space cells in [Pa]
    Eigen::VectorXd cap;         ///< upper bound of the cells' constants (C), same units
    ContactParameters patch;              ///< the same at every place
    /// of a solid with an inclusion or regions: log of E of springs and cells over the base material's (S + C)
    Eigen::VectorXd stiffer = {};
    NodeField ground = {};         ///< the same as points (DiscTables::ground)
    /// in space: radius of the disc, and cube edge of the lattice [m]
    double disc_radius_m = 0, spacing_m = std::numeric_limits<double>::quiet_NaN();
};

/// Stiffness of the supports of an embedded solid on a rigid bed, k = 8 E area / spacing. A cube is far more compliant
/// than its supports. They raise the highest frequency by 2 to 11 %.
constexpr double support_stiffness = 8;

/// modulus_N_m: E2. formulation: "plane-stress" or "plane-strain". area_cap: cap of the cells over E2; in plane strain
/// cells start 5 % below it. The cells of a shape overlap in threes, so each gets a third. Throws MismatchError for
/// another formulation, or a cap that is not above E2 / 3.
EnergyModelHeuristic energy_model_heuristic(const SpringMesh& mesh, double modulus_N_m, const std::string& formulation, double area_cap);

/// In space. spring_modulus_Pa (S), cell_modulus_Pa (C): E of springs and cells; surface_modulus_Pa: E at the surface.
/// volume_cap: cap of the cells over E. radius_m: radius of the disc. support_modulus_Pa (M): moduli at the fixed
/// nodes; empty: the surface's E. Throws MismatchError for a mesh that is not an embedded lattice, or a cap that is not
/// above E / 3.
EnergyModelHeuristic solid_heuristic(const SpringMesh& mesh, const Eigen::VectorXd& spring_modulus_Pa, const Eigen::VectorXd& cell_modulus_Pa,
                             double surface_modulus_Pa, double volume_cap, double radius_m, const Eigen::VectorXd& support_modulus_Pa = {});

/// For a shape whose E2 varies from triangle to triangle (T) [N/m]; the contact starts from the largest. Throws
/// MismatchError as above, and for a lattice.
EnergyModelHeuristic energy_model_heuristic(const SpringMesh& mesh, const Eigen::VectorXd& triangle_modulus_N_m,
                           const std::string& formulation, double area_cap);

/// Part of the cap at which cells start in plane strain and in space. If x is the sum of coefficients times terms, the
/// constant is then bent_factor(x) times its heuristic value.
constexpr double start_below_cap = 0.95;
double bent_factor(double x);

/// Constants of an energy model (E) with other spring stiffnesses springs_N_m (S), no cells and regions, and the same
/// supports.
Eigen::VectorXd springs_alone(const SpringMesh& mesh, const Eigen::VectorXd& constants, const Eigen::VectorXd& springs_N_m);

/// Contact parameters of a disc that is exp(log_times) times as large as own_m [m], on a lattice with cube edge
/// spacing_m. The rows change as their start does (springs/disc_rows.h). Terms with the factor `size` add their
/// coefficients p (P) times log_times.
ContactParameters resized(ContactParameters contact_parameters, const std::vector<std::string>& terms, const Eigen::VectorXd& p, double own_m, double spacing_m, double log_times);
/// Whether a term has the factor `size`.
bool is_size_term(const std::string& term);

/// Curve of a disc's contact: softens or compression where one of these terms occurs, else hardens.
ContactCurve contact_curve(const std::vector<std::string>& terms);

/// An energy model: constants of a TissueEnergy and of its contact from few parameters p (P), each the coefficient of a
/// named term. Terms are functions of the rest mesh.
///   theta_s = heuristic_s exp(sum_t p_t term_t(s)),   k_m(place) = heuristic_m exp(sum_t p_t term_t(place)),
///   A_c = cap / (1 + (cap / heuristic_c - 1) exp(-sum_t p_t term_t(c))): exponential far below the cap, bounded by it.
/// They are positive for every p and do not depend on the tool. A term is WHAT.FACTOR.FACTOR..., the product of its
/// factors:
///   spring, cell    all         1
///                   surface     1 for a segment of the free surface, a cell with such a segment, and the cell around a
///                               node on it; in the plane
///                   layer       exp(-depth / spacing) below the free surface; spacing: mean of the surface's segments
///                   held        1 where some but not all nodes are fixed; in the plane
///                   x2 x4 y y2 y3 y4   powers of the position from the mesh's middle, over its half size
///   spring only     along across    squared cosine to the nearest free surface, and to its normal
///                   upright         squared cosine to the normal of the nearest fixed facet
///                   horizontal vertical diagonal   1 for these springs of a lattice
///   in space        top bottom wall   exp(-distance / spacing) from the highest and lowest point, a block's sides
///                   z z2 z3 z4, and the even powers of x and y; springs only: horizontal vertical face body
///                   nodule      log(E / E_base), E by the element's part in the inclusion or in a shape's regions
///   contact.ROW     ROW: normal tangent rotation stretch; alone or with one of: phase corner edge (ContactParameters)
///   of a disc       ROW: normal tangent imprint_normal imprint_tangent hardening saturation coupling; or softening in
///                   place of hardening and saturation, or compression in place of hardening (ContactSpring); alone or
///                   with one of: curved ground edge (DiscContact), or
///                   size        log(radius / own radius): change with the radius beyond that of resized()
///   support.all     1 for the supports of a solid
///   skin.normal skin.tangent skin.heave skin.radial   of a disc: affect the displayed surface only (springs/skin.h)
class EnergyModelTerms {
   public:
    /// Throws MismatchError for a term that is unknown, does not fit the mesh, is zero everywhere or occurs twice; for
    /// for terms of two contact curves; and for a heuristic of another mesh.
    EnergyModelTerms(const SpringMesh& mesh, const EnergyModelHeuristic& heuristic, const std::vector<std::string>& terms);

    const std::vector<std::string>& terms() const { return terms_; }
    TissueEnergy energy(const SpringMesh& mesh) const { return {mesh, heuristic_.incompressible, heuristic_.curve}; }
    const NodeField& ground() const { return heuristic_.ground; }
    bool incompressible() const { return heuristic_.incompressible; }
    const SpringCurve& curve() const { return heuristic_.curve; }
    int size() const { return static_cast<int>(terms_.size()); }

    Eigen::VectorXd constants(const Eigen::VectorXd& p) const;     ///< (E) [N/m], in space cells in [Pa]
    Eigen::MatrixXd constants_by(const Eigen::VectorXd& p) const;  ///< derivative of constants() by p (E x P)
    SkinParameters skin(const Eigen::VectorXd& p) const { return skin_of(terms_, p); }
    /// Contact parameters of a disc that is exp(log_times) times as large as the heuristic's.
    ContactParameters patch(const Eigen::VectorXd& p, double log_times = 0) const;
    /// Derivative by p of ContactParameters::values_at a place with these factors (K x P).
    Eigen::MatrixXd stiffness_by(const Eigen::VectorXd& p, const ContactFactors& factors, double log_scale = 0, double log_times = 0) const;

   private:
    std::vector<std::string> terms_;
    EnergyModelHeuristic heuristic_;
    int springs_;                                ///< number of springs: index of the first cell constant
    Eigen::MatrixXd value_;                      ///< value of each term at each element (E x P)
    std::vector<std::pair<int, int>> on_patch_;  ///< row and factor of ContactParameters for each term, or -1
    ContactCurve curve_;                         ///< of a disc
};

}  // namespace tissue
