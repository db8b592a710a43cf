#pragma once

#include <Eigen/Core>
#include <deque>
#include <utility>
#include <vector>

#include "scene.h"

namespace tissue::serve {

/// Where the pointer shall be: led by a person, by the demo, or parked beside the tissue. On its way to a place it goes
/// round the tissue, not through it; in space over it, for the tissue stands on something. One thread's; no clock of its own.
class Hand {
   public:
    using Box = Scene::Box;

    /// tool: which one it leads; they stand side by side.
    explicit Hand(const Scene& scene, int tool = 0);

    /// Another model: the hand stands beside it, led by nobody.
    void show(const Scene& scene);

    /// A person leads it to a point (D). The first time it comes from outside: in the plane by the nearest side; in space, where the
    /// point is at the tissue, along the inward normal of the surface there.
    void follow(const Point& point_m);

    /// Nobody leads it: it leaves the tissue where it came in.
    void let_go();

    /// The demo leads it: presses place k again and again; -1: one place after another.
    void demonstrate(int place);

    /// Where the pointer shall be after this time [m].
    Point step(double elapsed_s);

    const Point& at() const { return at_; }
    bool begins_press() const { return begins_press_; }      ///< in the last step the demo came to where it presses from, outside the tissue
    int place() const { return mode_ == Mode::demo ? place_ : -1; }  ///< that the demo presses

   private:
    enum class Mode { parked, led, demo };
    struct Leg {
        Point to_m;
        double speed_m_s;
        double wait_s = 0;   ///< there
        bool begins_press = false;
    };

    void come_in();
    void approach();
    void go_round(const Point& to_m);
    void press();
    void remember_way_out();

    const Scene* scene_;
    int tool_;
    Mode mode_ = Mode::parked;
    std::deque<Leg> way_;
    Point at_, wanted_;
    Point touch_;            ///< of the surface that it comes to along the normal, in the plane outside it; empty: to none
    Point entry_;            ///< where it was last outside
    bool inside_ = false;    ///< led straight, whatever is in between: it has arrived where the person is
    bool tour_ = true;
    bool begins_press_ = false;
    int place_ = 0;
};

/// p, or the nearest point at least `clearance_m` outside every box; under it only where p is under it.
Point outside(const std::vector<Hand::Box>& boxes, const Point& p, double clearance_m);

/// Points to pass on the shortest way between two points outside the boxes that keeps clear of them; the end included. In the plane
/// round corners, in space up, across and down.
std::vector<Point> way_round(const std::vector<Hand::Box>& boxes, const Point& from, const Point& to, double clearance_m);

}  // namespace tissue::serve
