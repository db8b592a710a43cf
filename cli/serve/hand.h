#pragma once

#include <Eigen/Core>
#include <deque>
#include <utility>
#include <vector>

#include "scene.h"

namespace tissue::serve {

/// Where the pointer shall be: led by a person, by the demo, or parked beside the tissue. On its way to a place it goes
/// round the tissue, not through it. One thread's; no clock of its own.
class Hand {
   public:
    using Box = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

    explicit Hand(const Scene& scene);

    /// Another model: the hand stands beside it, led by nobody.
    void show(const Scene& scene);

    /// A person leads it to a point of the plane; the first time it comes from outside, by the nearest side.
    void follow(const Eigen::Vector2d& point_m);

    /// Nobody leads it: it leaves the tissue where it came in.
    void let_go();

    /// The demo leads it: presses place k again and again; -1: one place after another.
    void demonstrate(int place);

    /// Where the pointer shall be after this time [m].
    Eigen::Vector2d step(double elapsed_s);

    const Eigen::Vector2d& at() const { return at_; }
    int place() const { return mode_ == Mode::demo ? place_ : -1; }  ///< that the demo presses

   private:
    enum class Mode { parked, led, demo };
    struct Leg {
        Eigen::Vector2d to_m;
        double speed_m_s;
        double wait_s = 0;   ///< there
    };

    void go_round(const Eigen::Vector2d& to_m);
    void press();
    void remember_way_out();

    const Scene* scene_;
    Mode mode_ = Mode::parked;
    std::deque<Leg> way_;
    Eigen::Vector2d at_, wanted_;
    Eigen::Vector2d entry_;  ///< where it was last outside
    bool inside_ = false;    ///< led straight, whatever is in between: it has arrived where the person is
    bool tour_ = true;
    int place_ = 0;
};

/// p, or the nearest point at least `clearance_m` outside every box.
Eigen::Vector2d outside(const std::vector<Hand::Box>& boxes, const Eigen::Vector2d& p, double clearance_m);

/// Corners to pass on the shortest way between two points outside the boxes that keeps clear of them; the end included.
std::vector<Eigen::Vector2d> way_round(const std::vector<Hand::Box>& boxes, const Eigen::Vector2d& from,
                                       const Eigen::Vector2d& to, double clearance_m);

}  // namespace tissue::serve
