#include "cases/solid_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "cases/study_mesh.h"
#include "error.h"
#include "io/one_line.h"
#include "study/solid_push.h"

namespace tissue {
namespace {

constexpr double tiny_m = 1e-9;
constexpr double golden_angle_deg = 137.50776405003785;

[[noreturn]] void refuse(const Study& study, const std::string& key, const std::string& why) {
    throw StudyError(one_line(fmt::format("{}: key '{}': {}", study.file, key, why)));
}

std::string at(const Point& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", p[0], p[1], p[2]); }

struct Contact {
    FreeSurface::Place place;
    Study::Loads::Pushes pushes_deg;
    double depth_m, radius_m;
};

std::vector<Contact> listed_contacts(const Study& study, const FreeSurface& surface) {
    std::vector<Contact> contacts;
    for (const Study::Loads::Contact& c : study.loads.contacts) {
        const std::string key = fmt::format("loads.contacts[{}].at_m", contacts.size());
        const FreeSurface::Place place = surface.nearest(c.at_m);
        if (place.distance_m > surface.spacing_m())
            refuse(study, key, fmt::format("{} is {:.3g} mm from the free surface, whose nodes are {:.3g} mm apart", at(c.at_m), 1e3 * place.distance_m,
                                           1e3 * surface.spacing_m()));
        const double clearance_m = surface.clearance_m(place.point_m);
        if (clearance_m < study.indenter.clearance_m(c.radius_m) - tiny_m)
            refuse(study, key, fmt::format("{} is {:.3g} mm from where the free surface ends or turns; a disc of radius {:g} mm needs {:g} mm",
                                           at(place.point_m), 1e3 * clearance_m, 1e3 * c.radius_m, 1e3 * study.indenter.clearance_m(c.radius_m)));
        contacts.push_back({place, c.pushes_deg, c.depth_m, c.radius_m});
    }
    return contacts;
}

std::vector<Contact> spread_contacts(const Study& study, const FreeSurface& surface) {
    const Study::Loads::Spread& spread = *study.loads.spread;
    std::vector<Point> candidates;
    std::vector<double> rank;  // for the first contact its clearance, then the distance from those chosen
    for (const Point& p : surface.points(4)) {
        const double clearance_m = surface.clearance_m(p);
        if (clearance_m < spread.clearance_m) continue;
        candidates.push_back(p);
        rank.push_back(clearance_m);
    }
    const auto count = static_cast<std::size_t>(spread.count);
    if (candidates.size() < count)
        refuse(study, "loads.spread", fmt::format("the free surface has {} places {:g} mm from where it ends or turns, and {} contacts are requested; on a small "
                                                  "tissue make indenter.radius_m smaller, and clearance_m with it (at least radius_m + 5 mm)",
                                                  candidates.size(), 1e3 * spread.clearance_m, count));
    std::vector<Contact> contacts;
    while (contacts.size() < count) {
        const auto best = static_cast<std::size_t>(std::max_element(rank.begin(), rank.end()) - rank.begin());
        if (contacts.empty()) std::fill(rank.begin(), rank.end(), std::numeric_limits<double>::infinity());
        for (std::size_t c = 0; c < candidates.size(); ++c) rank[c] = std::min(rank[c], (candidates[c] - candidates[best]).norm());
        const double turn_deg = golden_angle_deg * static_cast<double>(contacts.size());
        const std::vector<double> radii_m = spread.radii_m.empty() ? std::vector{study.indenter.radius_m} : spread.radii_m;
        const std::size_t discs = radii_m.size();
        const double radius_m = radii_m[contacts.size() % discs];
        // shifts the directions after each round of discs, so that every disc gets all of them
        const std::size_t round = discs > 1 ? contacts.size() / discs : 0;
        Contact contact{surface.nearest(candidates[best]), {}, study.indenter.times(radius_m) * study.loads.depth_m(), radius_m};
        for (int k = 0; k < spread.pushes_each; ++k) {
            const auto [tilt, azimuth] = spread.pushes_deg[(contacts.size() * static_cast<std::size_t>(spread.pushes_each) + static_cast<std::size_t>(k) + round) % spread.pushes_deg.size()];
            contact.pushes_deg.push_back({tilt, std::fmod(azimuth + turn_deg + 360, 360)});
        }
        contacts.push_back(contact);
    }
    return contacts;
}

/// The paths of all contacts. A name is "c03-t30-a137": number of the contact, tilt and azimuth in degrees, with as
/// many decimals as make all names different.
std::vector<StudyPath> paths_of(const std::vector<Contact>& contacts) {
    constexpr int most_decimals = 9;
    for (int decimals = 0; decimals <= most_decimals; ++decimals) {
        const double scale = std::pow(10, decimals);
        std::vector<StudyPath> paths;
        std::set<std::string> names;
        for (std::size_t c = 0; c < contacts.size(); ++c)
            for (const auto& [tilt, azimuth] : contacts[c].pushes_deg) {
                const double around = tilt == 0 ? 0 : azimuth < 0 ? azimuth + 360 : azimuth;
                paths.push_back({fmt::format("c{:02}-t{:0{}.0f}-a{:0{}.0f}", c + 1, scale * tilt, 2 + decimals, scale * around, 3 + decimals),
                                 contacts[c].place.point_m, surface_push(contacts[c].place.inward, tilt, azimuth), contacts[c].depth_m, contacts[c].radius_m});
                names.insert(paths.back().name);
            }
        if (names.size() == paths.size()) return paths;
    }
    throw MismatchError("loads.contacts: two directions at one contact are the same");
}

}  // namespace

FreeSurface study_surface(const Study& study, const std::optional<Shape>& shape) {
    return FreeSurface(study_mesh(study, shape, study.springs.topology));
}

std::vector<StudyPath> solid_training(const Study& study, const std::optional<Shape>& shape) {
    if (study.geometry.is_block()) return study.loads.paths;
    const FreeSurface surface = study_surface(study, shape);
    return paths_of(study.loads.spread ? spread_contacts(study, surface) : listed_contacts(study, surface));
}

}  // namespace tissue
