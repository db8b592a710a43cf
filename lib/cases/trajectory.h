#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "field.h"

namespace tissue {

/// Displacement history of the tool, in the time steps of the finite elements.
struct Trajectory {
    Eigen::VectorXd time_s;    ///< (T), from 0, ascending
    NodeField push_m;          ///< displacement of the tool from its contact at rest (T x D); 0 while it is away
    std::vector<int> contact;  ///< (T) 0: the tool is away; 1: at its contact; 2: at the second one

    /// Largest displacement [m].
    double depth_m() const { return push_m.rows() > 0 ? push_m.rowwise().norm().maxCoeff() : 0; }
};

/// Time steps of the finite elements. The tool moves smoothly within a step, and the steps resolve the free oscillation
/// of the tissue at some 5 to 20 Hz.
namespace trajectory_steps {
constexpr int least_of_stroke = 40;            ///< least number of steps of a ramp
constexpr double longest_of_stroke_s = 0.020;  ///< longest step of a ramp
/// After a ramp the first step is as long as within it. Each next one is longer by the factor `growth`, up to the
/// longest step, which is `longest_s` or less (below).
constexpr double growth = 1.04, longest_s = 0.020;
/// After a quick ramp, which leaves the tissue oscillating, the longest step is `widest` times the first one, but at
/// least `swinging_s`.
constexpr double swinging_s = 0.004, widest = 1.6;
constexpr double let_go_s = 0.002;             ///< largest first step after the tool has released the tissue
constexpr int least_of_period = 60;            ///< least number of steps of a period of a sine
constexpr double longest_of_period_s = 0.010;  ///< longest step of a sine
/// Rows of a file that follow the last one used by less than `nearest_rows_s` are left out; only the last row of the
/// file is always used. Intervals longer than `longest_of_row_s` are divided.
constexpr double nearest_rows_s = 0.002, longest_of_row_s = 0.010;
/// Longest trajectory of a file; it bounds the time and memory of its FE solve.
constexpr double longest_of_file_s = 3600;
}  // namespace trajectory_steps

/// Part of a ramp's displacement reached after the part s of its time: 10 s^3 - 15 s^4 + 6 s^5. It is the motion of
/// least jerk from rest to rest (Flash and Hogan 1985, J. Neuroscience 5: 1688-1703).
double minimum_jerk(double s);

/// Ends of the steps of a ramp that takes time_s [s].
std::vector<double> stroke_steps(double time_s);

/// Ends of the steps of a time without a ramp [s]; the first step is at most `first_s` long. All are shortened by the
/// same factor so that the last one ends at time_s.
std::vector<double> rest_steps(double first_s, double time_s);

/// Ends of the steps of a sine [s].
std::vector<double> sine_steps(double frequency_Hz, double time_s);

/// Builds a displacement history from its parts. It begins at rest at the contact.
class TrajectoryBuilder {
   public:
    /// D: number of axes.
    explicit TrajectoryBuilder(Eigen::Index D);

    /// A ramp from the present displacement to `to_m`.
    void stroke(const Point& to_m, double time_s);
    void hold(double time_s);
    /// Displacement deep_m (1 - cos 2 pi f t) / 2. Only from rest.
    void sine(const Point& deep_m, double frequency_Hz, double time_s);
    /// The tool releases the tissue at once and is away for time_s.
    void away(double time_s);
    /// The tool touches the contact again (1), or the second one (2), at displacement 0.
    void touch(int contact);

    double time_s() const { return time_s_.back(); }
    Trajectory trajectory() const;

   private:
    void add(double time_s, const Point& push_m);

    std::vector<double> time_s_;
    std::vector<Point> push_m_;
    std::vector<int> contact_;
    int touching_ = 1;
    double step_s_ = 0;  ///< largest first step of a following hold or away
};

/// Reads a user's displacement history: CSV with the header time_s,x_m,y_m[,z_m]. Throws FileError with file, line and
/// cause: another header, a field that is no number, times that do not ascend from 0 or exceed an hour, a beginning
/// that is not at rest, no displacement at all.
Trajectory read_trajectory(const std::string& file, Eigen::Index D);

/// The history as fem/history.idp reads it, one line a step: time, displacement along each axis, 0 (no nodes are
/// written), contact. Numbers are written so that they read back to the same bits.
std::string trajectory_text(const Trajectory& trajectory);

}  // namespace tissue
