#pragma once

#include <Eigen/Core>
#include <deque>
#include <utility>
#include <vector>

#include "scene.h"

namespace tissue::serve {

/// Target position of the pointer: led by a client, led by the demo, or parked beside the tissue. It moves around the
/// tissue, not through it; in space over it, because the tissue lies on a support. Not thread-safe; without a clock of
/// its own.
class Hand {
   public:
    using Box = Scene::Box;

    /// tool: index of the tool that the hand leads; parked tools are side by side.
    explicit Hand(const Scene& scene, int tool = 0);

    /// Changes to another model: the hand is parked beside it.
    void show(const Scene& scene);

    /// A client leads the hand to a point (D). The first approach is from outside: in the plane from the nearest side;
    /// in space, where the point is at the tissue, along the inward normal of the surface.
    void follow(const Point& point_m);

    /// The client stops leading: the hand leaves the tissue where it entered.
    void let_go();

    /// The demo leads the hand: it indents place `place` again and again; -1: one place after another.
    void demonstrate(int place);

    /// Position of the pointer after this time [m].
    Point step(double elapsed_s);

    const Point& at() const { return at_; }
    /// in the last step the demo reached the start of an indentation, outside the tissue
    bool begins_press() const { return begins_press_; }
    int place() const { return mode_ == Mode::demo ? place_ : -1; }  ///< the place that the demo indents; -1: no demo

   private:
    enum class Mode { parked, led, demo };
    struct Leg {
        Point to_m;
        double speed_m_s;
        double wait_s = 0;   ///< waiting time there
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
    /// target on the surface of an approach along the normal, in the plane outside it; empty: no approach
    Point touch_;
    Point entry_;            ///< last position outside the tissue
    bool inside_ = false;    ///< the hand has reached the client's position, and follows it directly
    bool tour_ = true;
    bool begins_press_ = false;
    int place_ = 0;
};

/// p, or the nearest point at least `clearance_m` outside every box. The result is below a box only if p is.
Point outside(const std::vector<Hand::Box>& boxes, const Point& p, double clearance_m);

/// Points of the shortest path between two points outside the boxes that keeps `clearance_m` from them, including the
/// end. In the plane the path turns at corners; in space it goes up, across and down.
std::vector<Point> way_round(const std::vector<Hand::Box>& boxes, const Point& from, const Point& to, double clearance_m);

}  // namespace tissue::serve
