#include "cases/trajectory.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "error.h"
#include "../example.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// Lengths of the steps with these ends; the first step begins at 0.
std::vector<double> lengths(const std::vector<double>& ends) {
    std::vector<double> steps;
    double before = 0;
    for (const double end : ends) {
        steps.push_back(end - before);
        before = end;
    }
    return steps;
}

double longest(const std::vector<double>& ends) {
    const std::vector<double> steps = lengths(ends);
    return *std::max_element(steps.begin(), steps.end());
}

constexpr double a_little = 1 + 1e-9;  // factor for the rounding of a step length

std::string said(const std::string& text) {
    const TemporaryFolder folder;
    return refusal<FileError>([&] { read_trajectory(folder.file("hand.csv", text), 2); });
}

Trajectory read(const std::string& text) {
    const TemporaryFolder folder;
    return read_trajectory(folder.file("hand.csv", text), 2);
}

}  // namespace

TEST_CASE("a displacement history file may have a byte order mark and comments and quotes and semicolons", "[histories]") {
    const std::string plain = "time_s,x_m,y_m\n0,0,0\n0.1,0,-0.003\n0.2,0,-0.004\n";
    const Trajectory trajectory = read(plain);
    for (const std::string& text : {std::string("\xef\xbb\xbf") + plain, std::string("# by hand\n\"time_s\"; x_m ;y_m\r\n0;0;0\r\n\r\n0.1;0; -0.003 \r\n0.2;+0;-0.004\r\n\r\n")}) {
        const Trajectory other = read(text);
        CHECK(other.time_s == trajectory.time_s);
        CHECK(other.push_m == trajectory.push_m);
    }
    CHECK_THAT(said("time_s,x_m\n0,0\n"), Contains("hand.csv:1: must begin with the header time_s,x_m,y_m"));
}

TEST_CASE("a ramp starts and ends with zero velocity and acceleration and is monotonic", "[histories]") {
    CHECK(minimum_jerk(0) == 0);
    CHECK(minimum_jerk(1) == Approx(1).epsilon(tolerance::rounding));
    CHECK(minimum_jerk(0.5) == Approx(0.5).epsilon(tolerance::rounding));
    for (const double h : {1e-2, 1e-3}) {  // 10 h^3 remains if both vanish
        CHECK(minimum_jerk(h) < 10 * h * h * h);
        CHECK(1 - minimum_jerk(1 - h) < 10 * h * h * h * a_little);
    }
    for (int k = 0; k < 100; ++k) CHECK(minimum_jerk((k + 1) / 100.0) > minimum_jerk(k / 100.0));
}

TEST_CASE("a ramp has at least 40 steps of at most 20 ms and ends at its time", "[histories]") {
    CHECK(stroke_steps(0.01).size() == 40);
    CHECK(stroke_steps(0.8).size() == 40);
    CHECK(stroke_steps(1).size() == 50);
    CHECK(stroke_steps(1.003).size() == 51);
    for (const double time : {0.05, 0.3, 1.7}) {
        CHECK(stroke_steps(time).back() == time);
        CHECK(longest(stroke_steps(time)) <= 0.020 * a_little);
    }
}

TEST_CASE("steps of a hold start as in the ramp and grow by 1.04 up to their limit", "[histories]") {
    for (const double first : {0.001, 0.004, 0.010})
        for (const double time : {0.0005, 0.05, 0.3, 2.0}) {
            const std::vector<double> ends = rest_steps(first, time), steps = lengths(ends);
            CHECK(ends.back() == time);
            CHECK(steps.front() <= first * a_little);
            CHECK(longest(ends) <= std::max(0.004, 1.6 * first) * a_little);
            for (std::size_t k = 1; k < steps.size(); ++k) {
                CHECK(steps[k] <= steps[k - 1] * 1.04 * a_little);
                CHECK(steps[k] >= steps[k - 1] / a_little / a_little);
            }
        }
    CHECK(rest_steps(0.01, 2.0).size() < 2.0 / 0.01);  // steps have grown
    CHECK(longest(rest_steps(0.05, 2.0)) <= 0.020 * a_little);
    CHECK(rest_steps(0.01, 0).empty());
}

TEST_CASE("a sine has at least 60 steps a period of at most 10 ms each", "[histories]") {
    CHECK(sine_steps(2, 0.5).size() == 60);
    CHECK(sine_steps(2, 1.5).size() == 180);
    CHECK(sine_steps(0.5, 2).size() == 200);
    CHECK(sine_steps(3, 0.9).back() == 0.9);
    CHECK(longest(sine_steps(0.7, 1.234)) <= 0.010 * a_little);
}

TEST_CASE("ramps and holds follow each other without gaps and displacement is zero while the tool is away", "[histories]") {
    TrajectoryBuilder maker(2);
    const Point deep = Eigen::Vector2d(0.003, -0.004);
    maker.stroke(deep, 0.1);
    maker.hold(0.2);
    maker.away(0.1);
    maker.touch(2);
    maker.stroke(Eigen::Vector2d(0, -0.005), 0.1);
    maker.hold(0.05);
    const Trajectory trajectory = maker.trajectory();
    const Eigen::Index T = trajectory.time_s.size();
    REQUIRE(trajectory.push_m.rows() == T);
    REQUIRE(trajectory.contact.size() == static_cast<std::size_t>(T));
    CHECK(trajectory.time_s[0] == 0);
    CHECK(trajectory.push_m.row(0).norm() == 0);
    CHECK(trajectory.time_s[T - 1] == Approx(0.55).epsilon(tolerance::rounding));
    CHECK(trajectory.depth_m() == Approx(0.005).epsilon(tolerance::rounding));
    double first_away = 0;
    for (Eigen::Index t = 1; t < T; ++t) {
        const double at = trajectory.time_s[t], step = at - trajectory.time_s[t - 1];
        const int contact = trajectory.contact[static_cast<std::size_t>(t)];
        INFO(at);
        CHECK(step > 0);
        CHECK(contact == (at < 0.3 + 1e-9 ? 1 : at < 0.4 + 1e-9 ? 0 : 2));
        if (contact == 0) CHECK(trajectory.push_m.row(t).norm() == 0);
        if (contact == 0 && first_away == 0) first_away = step;
        if (contact == 1 && at > 0.1 - 1e-9) CHECK(trajectory.push_m.row(t).transpose() == deep);
        if (contact == 2) CHECK(trajectory.push_m(t, 0) == 0);
    }
    CHECK(first_away <= 0.002 * a_little);
    CHECK(trajectory.push_m(T - 1, 1) == -0.005);
}

TEST_CASE("a sine moves from rest to its depth and back once a period", "[histories]") {
    TrajectoryBuilder maker(2);
    maker.sine(Eigen::Vector2d(0, -0.004), 2, 1);
    const Trajectory trajectory = maker.trajectory();
    for (Eigen::Index t = 0; t < trajectory.time_s.size(); ++t) {
        const double part = (1 - std::cos(4 * 3.14159265358979323846 * trajectory.time_s[t])) / 2;
        CHECK(trajectory.push_m(t, 1) == Approx(-0.004 * part).margin(tolerance::rounding));
    }
    CHECK(trajectory.depth_m() == Approx(0.004).epsilon(tolerance::rounding));
}

TEST_CASE("a displacement history file is linear between its rows and steps are at most 10 ms", "[histories]") {
    const Trajectory trajectory = read("time_s,x_m,y_m\n0,0,0\n0.0004,0,-0.0001\n0.0042,0,-0.001\n0.0342,0.003,-0.001\n0.0344,0.003,-0.001\n");
    const Eigen::Index T = trajectory.time_s.size();
    CHECK(trajectory.time_s[0] == 0);
    CHECK(trajectory.time_s[1] == 0.0042);  // a row within 2 ms of the last one used is left out
    CHECK(trajectory.time_s[T - 1] == 0.0344);  // the last row is always used
    CHECK(T == 6);
    CHECK(trajectory.time_s[2] == Approx(0.0142).epsilon(tolerance::rounding));
    CHECK(trajectory.push_m(2, 0) == Approx(0.001).epsilon(tolerance::rounding));
    CHECK(trajectory.push_m(2, 1) == Approx(-0.001).epsilon(tolerance::rounding));
    CHECK(trajectory.contact == std::vector<int>(6, 1));
}

TEST_CASE("an invalid displacement history file is refused with its line and cause", "[histories]") {
    CHECK_THAT(said(""), Contains("hand.csv:") && Contains("time_s,x_m,y_m"));
    CHECK_THAT(said("time_s,x_m,y_m,z_m\n0,0,0,0\n"), Contains("hand.csv:1: ") && Contains("header"));
    CHECK_THAT(said("time_s,x_m,y_m\n0,0\n"), Contains("hand.csv:2: has 2 fields"));
    CHECK_THAT(said("time_s,x_m,y_m\n0,0,0\n0.1,nan,0\n"), Contains("hand.csv:3: field 2"));
    CHECK_THAT(said("time_s,x_m,y_m\n0.1,0,0\n0.2,0,0.001\n"), Contains("hand.csv:2: ") && Contains("begin at time 0"));
    CHECK_THAT(said("time_s,x_m,y_m\n0,0,0.001\n0.2,0,0.001\n"), Contains("hand.csv:2: ") && Contains("at rest"));
    CHECK_THAT(said("time_s,x_m,y_m\n0,0,0\n0.1,0,0.001\n0.1,0,0\n"), Contains("hand.csv:4: ") && Contains("not later"));
    CHECK_THAT(said("time_s,x_m,y_m\n0,0,0\n0.1,0,0.001\n0.05,0,0\n"), Contains("hand.csv:4: ") && Contains("not later"));
    CHECK_THAT(said("time_s,x_m,y_m\n0,0,0\n"), Contains("two rows"));
    CHECK_THAT(said("time_s,x_m,y_m\n0,0,0\n1,0,0\n"), Contains("never moves"));
}

TEST_CASE("the text of a displacement history has one line per step and gives the same bits", "[histories]") {
    TrajectoryBuilder maker(3);
    maker.stroke(Eigen::Vector3d(0.001, 1.0 / 3e3, -0.004), 1.0 / 7);
    maker.away(0.01);
    const Trajectory trajectory = maker.trajectory();
    std::istringstream text(trajectory_text(trajectory));
    std::string line;
    for (Eigen::Index t = 0; t < trajectory.time_s.size(); ++t) {
        REQUIRE(std::getline(text, line));
        std::istringstream words(line);
        double time = 0, x = 0, y = 0, z = 0;
        int wanted = -1, contact = -1;
        words >> time >> x >> y >> z >> wanted >> contact;
        CHECK(time == trajectory.time_s[t]);
        CHECK(Eigen::RowVector3d(x, y, z) == Eigen::RowVector3d(trajectory.push_m.row(t)));
        CHECK(wanted == 0);
        CHECK(contact == trajectory.contact[static_cast<std::size_t>(t)]);
        CHECK_FALSE(words >> time);
    }
    CHECK_FALSE(std::getline(text, line));
}
