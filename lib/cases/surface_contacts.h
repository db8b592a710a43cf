#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "gsl.h"
#include "mesh/outline.h"
#include "study/study.h"

namespace tissue {

/// Contact and direction of an indentation in the plane: arc length along the free surface [m], and angle from its
/// inward normal [rad], counter-clockwise positive.
struct SurfaceContact {
    double arc, angle;
};

/// Training contacts of a sweep, corners among them, all at least `clearance_m` from both ends of the surface.
/// mirrors: the tissue is symmetric; then the mirror image of each contact is a contact too.
/// Throws MismatchError for a listed place nearer to an end, a clearance that leaves no place, and a spacing that makes
/// more than 10,000 contacts.
std::vector<SurfaceContact> training_contacts(const Outline& outline, const Study::Loads::Sweep& sweep, bool mirrors);

/// Draws contacts in the plane from a random stream of their own: uniform in angle and along the surface, at least the
/// sweep's `clearance_m` from both ends, and 2 mm or 5 degrees from every training contact.
class ContactDraws {
   public:
    /// key: the study's key in messages. All references must outlive this object.
    ContactDraws(const Study& study, const Study::Draws& draws, const Outline& outline, const std::vector<SurfaceContact>& trained,
                 const std::string& key);

    /// Throws MismatchError where ten thousand tries find no such contact.
    SurfaceContact contact();

    /// Two contacts apart_m [m] from each other along the surface, each at the same angle from its own normal; the
    /// second is on either side of the first. Throws as contact().
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
