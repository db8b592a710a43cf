#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gsl.h"
#include "mesh/free_surface.h"
#include "study/study.h"

namespace tissue {

/// Pushes in space, drawn by a stream of their own, 2 mm or 5 degrees from every training push (cases/solid_sweep.h).
class SolidDraws {
   public:
    /// surface: of a shape; null for a block. key: of the study, which refusals name. What is given must outlive this.
    SolidDraws(const Study& study, const Study::Draws& draws, const std::vector<StudyPath>& trained, const FreeSurface* surface, const std::string& key);

    /// Contact, direction, depth and disc; no name. Throws MismatchError when there is no such contact, as far as ten thousand
    /// tries can tell.
    /// Of draws of pairs the second disc too: its distance from the first uniform over their range, towards any side; its place, push and depth as the first's.
    /// The middles are two radii apart at least when both are pushed.
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
