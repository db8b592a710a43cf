#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "haptic/moving_surface.h"
#include "haptic/realtime_energy_model.h"
#include "mesh/free_surface.h"

namespace tissue {

struct FrictionOptions {
    /// Static friction coefficient. Default: infinite, as in the paper; a contact then keeps its place.
    double stick = std::numeric_limits<double>::infinity();
    std::optional<double> slip = {};  ///< kinetic friction coefficient, at most the static one; empty: equal to it
};

/// Coulomb friction between tool and tissue. A contact keeps its place while the tool's force lies in the cone
/// |f_t| <= mu f_n about the inward normal of the surface there, with the static mu. Outside the cone the place slides
/// along the surface at rest, in the direction of f_t, until the force lies on the cone of the kinetic mu. The contact
/// sticks again when the force is inside that cone.
///
/// A slide is shortened until the energy of the contact does not grow. Allocates nothing.
class Friction {
   public:
    /// Throws MismatchError for a coefficient that is negative or NaN, a kinetic one above the static one, and a
    /// kinetic one beside an infinite static one.
    explicit Friction(const FrictionOptions& options);

    void begin() noexcept { slipping_ = false; }  ///< a new contact begins
    bool slipping() const { return slipping_; }   ///< whether the contact slipped in the last call of slide()
    double dissipated_J() const { return dissipated_J_; }   ///< energy dissipated so far

    /// Slides the contact of an energy model, one of `contacts`, while its tool is in contact. tool_m: position of the tool in the
    /// mesh's own coordinates [m] (D). u: displacement of the nodes [m] (N x D).
    /// where, touched_m, tool: facet and weights of the contact's place, its position at rest [m] (D), and the
    /// contact's energy; a slide changes all three. memory: the contact's Maxwell branches, moved along with it.
    /// beside: the same for this contact on a second mesh; null without one.
    /// Returns the unit direction of the tangential force (D), zero where the contact does not slip.
    Point slide(const FreeSurface& surface, const RealtimeMesh& mesh, const ToolContact& contacts, const NodeColumns& u, const Point& tool_m,
               SurfacePlace& where, Point& touched_m, ToolSpring& tool, ToolMemory& memory, ToolMemory* beside = nullptr) noexcept;

    /// Slides a contact on spring sets, in the plane. coupling_N_m: stiffness k_C of the coupling between the tool
    /// tool_m and the proxy where.position_m. now: the deformed surface, in whose coordinates both positions are. A
    /// slide changes `where`. Returns the same direction as above.
    Point slide(const FreeSurface& surface, const RealtimeMesh& mesh, const MovingSurface& now, double coupling_N_m, const Point& tool_m, SurfacePlace& where) noexcept;

    /// Distance of the contact `tool` of an energy model from the cone, as a vector s along the surface [m] (D). At the
    /// tool displacement push_m - s the force is on the cone. Zero inside the cone.
    Point outside(const Point& push_m, const NodeColumns& u, const ToolSpring& tool, const ToolMemory& memory) const noexcept;

    bool finite() const { return std::isfinite(stick_); }  ///< false: contacts never slide
    /// Adds the work of the force on a contact that slid to dissipated_J().
    void dissipate(double work_J) noexcept { dissipated_J_ += std::max(0.0, work_J); }

    FrictionOptions options() const { return {stick_, has_slip_ ? std::optional<double>(slip_) : std::nullopt}; }
    /// Changes the coefficients; dissipated_J() stays. Throws as the constructor.
    void become(const FrictionOptions& options) {
        const Friction other(options);  // may throw
        stick_ = other.stick_, slip_ = other.slip_, has_slip_ = other.has_slip_;
    }

    void fields(StateBytes& state) noexcept { state(stick_, slip_, has_slip_, slipping_, dissipated_J_); }

   private:
    double cone() const { return slipping_ ? slip_ : stick_; }

    double stick_, slip_;
    bool has_slip_;  ///< FrictionOptions::slip was given
    bool slipping_ = false;
    double dissipated_J_ = 0;
    ToolSpring next_;
    ToolMemory next_memory_;
};

}  // namespace tissue
