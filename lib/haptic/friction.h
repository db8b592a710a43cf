#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "haptic/moving_surface.h"
#include "haptic/realtime_law.h"
#include "mesh/free_surface.h"

namespace tissue {

struct FrictionOptions {
    double stick = std::numeric_limits<double>::infinity();  ///< static mu; without end, as the paper has it: a contact keeps its place
    std::optional<double> slip = {};                         ///< kinetic mu, at most the static one; nothing: the same
};

/// Coulomb's friction between tool and tissue. A contact keeps its place while the tool's force lies in the cone
/// |f_t| <= mu f_n about the surface's inward normal there; outside, the place goes along the surface at rest, the way that the tool
/// drags, as far as brings the force back onto the cone of the kinetic mu. It sticks again when the force is inside that.
///
/// The place goes only as far as the contact's energy falls. Allocates nothing.
class Friction {
   public:
    /// Throws MismatchError for a mu that is negative or not a number, or a kinetic one above the static.
    explicit Friction(const FrictionOptions& options);

    void begin() noexcept { slipping_ = false; }  ///< of a contact
    bool slipping() const { return slipping_; }   ///< in the last call
    double dissipated_J() const { return dissipated_J_; }   ///< so far

    /// A law's contact, while the tool presses. tool_m: in the mesh's own coordinates. where, touched_m, tool: its place, that place
    /// at rest and its energy there; they change as it slips. memory: of the contact; it goes along, and so does that
    /// of a mesh beside, if there is one, which has the same contact. Returns the direction in which the force drags it, zero where it does not slip.
    Point slide(const FreeSurface& surface, const RealtimeMesh& mesh, const RealtimeLaw& law, const NodeColumns& u, const Point& tool_m,
               SurfacePlace& where, Point& touched_m, ToolSpring& tool, ToolMemory& memory, ToolMemory* beside = nullptr) noexcept;

    /// A contact of springs, with a coupling between the tool and the proxy where.position_m on the surface as it stands. All places
    /// as the surface has them. Returns the same.
    Point slide(const FreeSurface& surface, const RealtimeMesh& mesh, const MovingSurface& now, double coupling_N_m, const Point& tool_m, SurfacePlace& where) noexcept;

    /// How far a law's contact at a push is outside the cone, along the surface [m] (D): at the push less that it would be on the cone. Zero within it.
    Point outside(const Point& push_m, const NodeColumns& u, const ToolSpring& tool, const ToolMemory& memory) const noexcept;

    bool finite() const { return std::isfinite(stick_); }
    /// Work that the force did on a place that slid.
    void dissipate(double work_J) noexcept { dissipated_J_ += std::max(0.0, work_J); }

    FrictionOptions options() const { return {stick_, has_slip_ ? std::optional<double>(slip_) : std::nullopt}; }
    /// Other friction from now on; what was dissipated stays.
    void become(const FrictionOptions& options) {
        const Friction other(options);  // or it throws
        stick_ = other.stick_, slip_ = other.slip_, has_slip_ = other.has_slip_;
    }

    void fields(StateBytes& state) noexcept { state(stick_, slip_, has_slip_, slipping_, dissipated_J_); }

   private:
    double cone() const { return slipping_ ? slip_ : stick_; }

    double stick_, slip_;
    bool has_slip_;  ///< of its own, even if it is the static one
    bool slipping_ = false;
    double dissipated_J_ = 0;
    ToolSpring next_;
    ToolMemory next_memory_;
};

}  // namespace tissue
