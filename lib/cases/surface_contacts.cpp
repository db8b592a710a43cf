#include "cases/surface_contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "error.h"

namespace tissue {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;
// Least difference between a drawn contact and every training contact, in arc length or in angle.
constexpr double least_arc_m = 0.002, least_angle = 5 * degree;
constexpr double tiny_arc_m = 1e-9;
constexpr int most_tries = 10'000;  // for one contact

/// Angles of the training contacts at a place [rad]. At a corner of the outline they are those of both sides, so that
/// sets of neighbours on either side have their own directions there.
std::vector<double> angles_at(const Outline& outline, double arc, const std::vector<double>& angles_deg) {
    const std::vector<double> corners = outline.corners();
    const bool corner = std::any_of(corners.begin(), corners.end(), [&](double c) { return std::abs(c - arc) < tiny_arc_m; });
    const double step = 1e-6;  // [m] to either side
    std::set<long> micro_degrees;
    for (double side : {-step, step}) {
        const double turn = corner ? outline.angle(arc, outline.inward_normal(arc + side)) : 0;
        for (double a : angles_deg) micro_degrees.insert(std::lround((a * degree + turn) / degree * 1e6));
    }
    std::vector<double> angles;
    for (long a : micro_degrees) {  // at a corner, angles within a degree of each other are one
        const double angle = static_cast<double>(a) * 1e-6 * degree;
        if (!corner || angles.empty() || angle - angles.back() > degree) angles.push_back(angle);
    }
    return angles;
}

/// Arc lengths of places along the surface, without repeats.
class Arcs {
   public:
    void add(double arc) {
        if (std::none_of(arcs_.begin(), arcs_.end(), [&](double a) { return std::abs(a - arc) < tiny_arc_m; })) arcs_.push_back(arc);
    }
    std::vector<double> ascending() const {
        std::vector<double> arcs = arcs_;
        std::sort(arcs.begin(), arcs.end());
        return arcs;
    }

   private:
    std::vector<double> arcs_;
};

/// Arc lengths listed in the study. mirrors: with their mirror images.
std::vector<double> listed_arcs(const Outline& outline, const Study::Loads::Sweep& sweep, bool mirrors) {
    Arcs arcs;
    for (double arc : sweep.arcs_m) {
        if (arc < sweep.clearance_m - tiny_arc_m || arc > outline.length() - sweep.clearance_m + tiny_arc_m)
            throw MismatchError(fmt::format("loads.sweep.arcs_m: {:g} must be between clearance_m = {:g} and {:g}, as far from the "
                                            "surface's other end", arc, sweep.clearance_m, outline.length() - sweep.clearance_m));
        arcs.add(arc);
        if (mirrors) arcs.add(outline.length() - arc);
    }
    return arcs.ascending();
}

/// Arc lengths at even spacing from the clearance at one end to that at the other, and of the corners between. mirrors:
/// those of the first half and their images. (Evenly spaced places of the second half are images of the first half's
/// only where the spacing divides the length.)
std::vector<double> spaced_arcs(const Outline& outline, const Study::Loads::Sweep& sweep, bool mirrors) {
    constexpr double most = 10'000;
    const double gaps = std::floor((outline.length() - 2 * sweep.clearance_m) / sweep.spacing_m + 1e-9);
    if (gaps > most) throw MismatchError(fmt::format("loads.sweep.spacing_m: {:g} makes more than {:.0f} contacts", sweep.spacing_m, most));
    if (!(gaps >= 0))
        throw MismatchError(fmt::format("loads.sweep.clearance_m: {:g} m leaves no place on a free surface {:g} mm long; the least clearance is 15 mm, "
                                        "or three half widths of the patch (indenter.half_width_m) if that is less, and one half width at least", sweep.clearance_m, 1e3 * outline.length()));
    Arcs arcs;
    const auto add = [&](double arc) {
        if (mirrors && arc > outline.length() / 2 + tiny_arc_m) return;
        arcs.add(arc);
        if (mirrors) arcs.add(outline.length() - arc);
    };
    for (int i = 0; i <= static_cast<int>(gaps); ++i) add(sweep.clearance_m + i * sweep.spacing_m);
    // every corner within the clearances, because directions jump there
    for (double corner : outline.corners())
        if (corner > sweep.clearance_m - tiny_arc_m && corner < outline.length() - sweep.clearance_m + tiny_arc_m) add(corner);
    return arcs.ascending();
}

}  // namespace

std::vector<SurfaceContact> training_contacts(const Outline& outline, const Study::Loads::Sweep& sweep, bool mirrors) {
    std::vector<SurfaceContact> contacts;
    for (double arc : sweep.arcs_m.empty() ? spaced_arcs(outline, sweep, mirrors) : listed_arcs(outline, sweep, mirrors))
        for (double angle : angles_at(outline, arc, sweep.angles_deg)) contacts.push_back({arc, angle});
    return contacts;
}

ContactDraws::ContactDraws(const Study& study, const Study::Draws& draws, const Outline& outline,
                           const std::vector<SurfaceContact>& trained, const std::string& key)
    : draws_(draws), outline_(outline), trained_(trained), key_(key), clearance_m_(study.loads.sweep->clearance_m),
      rng_(seeded_rng(draws.seed)) {}

double ContactDraws::uniform(double low, double high) {
    return low + (high - low) * gsl_rng_uniform(rng_.get());
}

SurfaceContact ContactDraws::contact() {
    int tries = most_tries;
    return contact_within(tries);
}

SurfaceContact ContactDraws::contact_within(int& tries) {
    while (true) {
        if (--tries < 0)
            throw MismatchError(key_ + ": the free surface has no space for contacts that are 2 mm or 5 degrees from all training contacts");
        SurfaceContact c{};
        c.arc = uniform(clearance_m_, outline_.length() - clearance_m_);
        c.angle = uniform(-draws_.max_angle_deg, draws_.max_angle_deg) * degree;
        if (is_apart(c)) return c;
    }
}

bool ContactDraws::is_apart(const SurfaceContact& c) const {
    const Eigen::Vector2d push = outline_.direction(c.arc, c.angle);
    return std::none_of(trained_.begin(), trained_.end(), [&](const SurfaceContact& t) {
        return std::abs(t.arc - c.arc) < least_arc_m && std::abs(outline_.angle(t.arc, push) - t.angle) < least_angle;
    });
}

std::array<SurfaceContact, 2> ContactDraws::pair(double apart_m) {
    for (int tries = most_tries;;) {
        const SurfaceContact first = contact_within(tries);
        const double sign = uniform(0, 1) < 0.5 ? 1 : -1;
        for (const double way : {sign, -sign}) {
            const SurfaceContact second{first.arc + way * apart_m, first.angle};
            const bool there = second.arc >= clearance_m_ && second.arc <= outline_.length() - clearance_m_;
            if (there && is_apart(second)) return {first, second};
        }
    }
}

}  // namespace tissue
