#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "gsl.h"
#include "mesh/outline.h"
#include "study/study.h"

namespace tissue {

/// A push in the plane: where along the free surface [m], and off its inward normal [rad].
struct SurfaceContact {
    double arc, angle;
};

/// Training contacts of a sweep, all `clearance_m` and more from both ends of the surface, corners too. mirrors: the tissue is the same in
/// the mirror, and so are its contacts: each has its image among them.
/// Throws MismatchError for a listed place that is nearer, a clearance that leaves no place, and a spacing that makes more than 10,000.
std::vector<SurfaceContact> training_contacts(const Outline& outline, const Study::Loads::Sweep& sweep, bool mirrors);

/// Contacts in the plane, drawn by a stream of their own: uniform along the surface, `clearance_m` of the sweep from both ends, and in
/// angle; 2 mm or 5 degrees from every training contact.
class ContactDraws {
   public:
    /// key: of the study, which refusals name. What is given must outlive this.
    ContactDraws(const Study& study, const Study::Draws& draws, const Outline& outline, const std::vector<SurfaceContact>& trained,
                 const std::string& key);

    /// Throws MismatchError when there is no such contact, as far as ten thousand tries can tell.
    SurfaceContact contact();

    /// Two that far apart along the surface, at one angle off the normal of each, the second to either side. Throws as contact().
    std::array<SurfaceContact, 2> pair(double apart_m);

    double uniform(double low, double high);

   private:
    SurfaceContact contact_within(int& tries);
    bool is_apart(const SurfaceContact& c) const;

    const Study::Draws& draws_;
    const Outline& outline_;
    const std::vector<SurfaceContact>& trained_;
    std::string key_;
    double clearance_m_;
    Rng rng_;
};

}  // namespace tissue
