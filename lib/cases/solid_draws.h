#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gsl.h"
#include "mesh/free_surface.h"
#include "study/study.h"

namespace tissue {

/// Draws indentations in space from a random stream of their own, 2 mm or 5 degrees from every training indentation
/// (cases/solid_sweep.h).
class SolidDraws {
   public:
    /// surface: of a shape; null for a block. key: the study's key in messages. All references must outlive this
    /// object.
    SolidDraws(const Study& study, const Study::Draws& draws, const std::vector<StudyPath>& trained, const FreeSurface* surface, const std::string& key);

    /// Draws contact, direction, depth and disc; the name is empty. Draws of pairs have a second disc: its distance
    /// from the first is uniform over the range of the draws, towards any side; its place, direction and depth follow
    /// the same rules. At full depth the centres are at least two radii apart.
    /// Throws MismatchError where ten thousand tries find no such contact.
    StudyPath push();

    double uniform(double low, double high) { return low + (high - low) * gsl_rng_uniform(rng_.get()); }

   private:
    Point place(int& tries);
    Point place_on_surface(int& tries);
    void count_down(int& tries) const;
    Point direction(const Point& place);
    bool may_be(const Point& top_m) const;
    std::optional<SecondTool> second(const StudyPath& first, double apart_m);
    bool is_apart(const StudyPath& push) const;

    const Study& study_;
    const Study::Draws& draws_;
    const std::vector<StudyPath>& trained_;
    const FreeSurface* surface_;
    std::string key_;
    Rng rng_;
    std::size_t drawn_ = 0;
};

}  // namespace tissue
