#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "field.h"

namespace tissue {

/// Where the tool is over time, in the steps that finite elements take.
struct Course {
    Eigen::VectorXd time_s;    ///< (T), from 0, ascending
    NodeField push_m;          ///< displacement of the tool from where it touches the surface at rest (T x D); 0 while it is away
    std::vector<int> contact;  ///< (T) 0: the tool is away; 1: at its contact; 2: at the second one

    /// Farthest from rest [m].
    double depth_m() const { return push_m.rows() > 0 ? push_m.rowwise().norm().maxCoeff() : 0; }
};

/// How finely finite elements follow a course: what moves is smooth within a step, and tissue that is let swing, at some 5 to 20 Hz,
/// swings in steps that resolve it.
namespace course_steps {
constexpr int least_of_stroke = 40;                ///< steps of a stroke at least,
constexpr double longest_of_stroke_s = 0.020;      ///< and none longer
constexpr double growth = 1.04, longest_s = 0.020; ///< after a stroke the first is as within it, each next so much longer, up to this;
constexpr double swinging_s = 0.004, widest = 1.6; ///< after a quick one, which leaves tissue swinging, up to so many firsts, this at least
constexpr double let_go_s = 0.002;                 ///< the first at most, after the tool has let go at once
constexpr int least_of_period = 60;                ///< steps of a period of a sine at least,
constexpr double longest_of_period_s = 0.010;      ///< and none longer
constexpr double nearest_rows_s = 0.002, longest_of_row_s = 0.010;  ///< of a file: rows nearer to the one before are passed over, others parted,
constexpr double longest_of_file_s = 3600;          ///< and it ends by then: its steps are finite elements' work, and memory
}  // namespace course_steps

/// Part of a stroke that is done after the part s of its time, 10 s^3 - 15 s^4 + 6 s^5: of all ways from rest to rest the one of least
/// jerk (Flash and Hogan 1985, J. Neuroscience 5: 1688-1703).
double minimum_jerk(double s);

/// Ends of the steps of a stroke that takes so long [s].
std::vector<double> stroke_steps(double time_s);

/// Ends of the steps of a time without a stroke [s], the first at most `first_s` long. They are shortened alike so that the last ends with it.
std::vector<double> rest_steps(double first_s, double time_s);

/// Ends of the steps of a sine [s].
std::vector<double> sine_steps(double frequency_Hz, double time_s);

/// Puts a course together, from rest at the contact on.
class CourseMaker {
   public:
    /// D: axes.
    explicit CourseMaker(Eigen::Index D);

    void stroke(const Point& to_m, double time_s);
    void hold(double time_s);
    /// Rises to `deep_m` and comes back, (1 - cos 2 pi f t) / 2 of it. From rest alone.
    void sine(const Point& deep_m, double frequency_Hz, double time_s);
    /// The tool lets go at once, and is away so long.
    void away(double time_s);
    /// It touches the contact again, or the second one, without pushing yet.
    void touch(int contact);

    double time_s() const { return time_s_.back(); }
    Course course() const;

   private:
    void add(double time_s, const Point& push_m);

    std::vector<double> time_s_;
    std::vector<Point> push_m_;
    std::vector<int> contact_;
    int touching_ = 1;
    double step_s_ = 0;  ///< with which a rest begins
};

/// A course of one's own: CSV with the header time_s,x_m,y_m[,z_m]. Throws FileError with file, line and cause: another header, a
/// number that is none, times that do not ascend from 0 or go on for more than an hour, a beginning that is not at rest, no push at all.
Course read_course(const std::string& file, Eigen::Index D);

/// The course as fem/history.idp reads it: a line a step, time, displacement along each axis, 0 (no nodes are wanted), contact. Numbers read
/// back to the same bits.
std::string course_text(const Course& course);

}  // namespace tissue
