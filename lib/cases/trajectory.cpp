#include "cases/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/csv_columns.h"
#include "io/csv_table.h"

namespace tissue {
namespace {

constexpr double two_pi = 2 * 3.14159265358979323846;
constexpr double tiny = 1e-9;  // of a step: a remainder from rounding makes no step of its own

int steps_of(double time_s, double longest_s) {
    return std::max(1, static_cast<int>(std::ceil(time_s / longest_s - tiny)));
}

std::vector<double> even_steps(double time_s, int count) {
    std::vector<double> ends;
    for (int k = 1; k < count; ++k) ends.push_back(time_s * k / count);
    ends.push_back(time_s);
    return ends;
}

}  // namespace

double minimum_jerk(double s) {
    return s * s * s * (10 - s * (15 - 6 * s));
}

std::vector<double> stroke_steps(double time_s) {
    return even_steps(time_s, std::max(trajectory_steps::least_of_stroke, steps_of(time_s, trajectory_steps::longest_of_stroke_s)));
}

std::vector<double> rest_steps(double first_s, double time_s) {
    std::vector<double> ends;
    if (!(time_s > 0)) return ends;
    const double longest_s = std::clamp(trajectory_steps::widest * first_s, trajectory_steps::swinging_s, trajectory_steps::longest_s);
    double step_s = std::min(first_s, longest_s), end_s = 0;
    while (end_s < time_s * (1 - tiny)) {
        ends.push_back(end_s += step_s);
        step_s = std::min(step_s * trajectory_steps::growth, longest_s);
    }
    for (double& end : ends) end *= std::min(1.0, time_s / end_s);
    ends.back() = time_s;
    return ends;
}

std::vector<double> sine_steps(double frequency_Hz, double time_s) {
    const int of_period = std::max(trajectory_steps::least_of_period, steps_of(1 / frequency_Hz, trajectory_steps::longest_of_period_s));
    return even_steps(time_s, steps_of(time_s, 1 / (frequency_Hz * of_period)));
}

TrajectoryBuilder::TrajectoryBuilder(Eigen::Index D) : time_s_{0}, push_m_{Point(Point::Zero(D))}, contact_{1} {}

void TrajectoryBuilder::add(double time_s, const Point& push_m) {
    time_s_.push_back(time_s);
    push_m_.push_back(push_m);
    contact_.push_back(touching_);
}

void TrajectoryBuilder::stroke(const Point& to_m, double time_s) {
    const double begin_s = time_s_.back();
    const Point from_m = push_m_.back();
    const std::vector<double> ends = stroke_steps(time_s);
    for (const double end : ends) add(begin_s + end, from_m + minimum_jerk(end / time_s) * (to_m - from_m));
    push_m_.back() = to_m;
    step_s_ = time_s / static_cast<double>(ends.size());
}

void TrajectoryBuilder::hold(double time_s) {
    const double begin_s = time_s_.back();
    const Point at_m = push_m_.back();
    for (const double end : rest_steps(step_s_, time_s)) add(begin_s + end, at_m);
}

void TrajectoryBuilder::sine(const Point& deep_m, double frequency_Hz, double time_s) {
    const double begin_s = time_s_.back();
    for (const double end : sine_steps(frequency_Hz, time_s)) add(begin_s + end, (1 - std::cos(two_pi * frequency_Hz * end)) / 2 * deep_m);
}

void TrajectoryBuilder::away(double time_s) {
    const double begin_s = time_s_.back();
    const Point at_rest_m = Point::Zero(push_m_.back().size());
    touching_ = 0;
    for (const double end : rest_steps(std::min(step_s_, trajectory_steps::let_go_s), time_s)) add(begin_s + end, at_rest_m);
}

void TrajectoryBuilder::touch(int contact) {
    touching_ = contact;
    push_m_.back().setZero();
}

Trajectory TrajectoryBuilder::trajectory() const {
    Trajectory trajectory;
    trajectory.time_s = Eigen::Map<const Eigen::VectorXd>(time_s_.data(), static_cast<Eigen::Index>(time_s_.size()));
    trajectory.push_m.resize(trajectory.time_s.size(), push_m_.front().size());
    for (Eigen::Index t = 0; t < trajectory.time_s.size(); ++t) trajectory.push_m.row(t) = push_m_[static_cast<std::size_t>(t)].transpose();
    trajectory.contact = contact_;
    return trajectory;
}

Trajectory read_trajectory(const std::string& file, Eigen::Index D) {
    CsvTable line(file);
    const std::vector<std::string> names = {"time_s", "x_m", "y_m", "z_m"};
    const auto columns = static_cast<std::size_t>(1 + D);
    bool headed = line.next_row() && line.size() == columns;
    for (std::size_t k = 0; headed && k < columns; ++k) headed = trimmed(line.field(k)) == names[k];
    if (!headed) line.refuse(std::string("must begin with the header ") + (D == 3 ? "time_s,x_m,y_m,z_m" : "time_s,x_m,y_m"));
    std::vector<double> times;
    std::vector<Eigen::VectorXd> pushes;  // displacements of the rows used
    double before_s = 0;
    bool passed_over = false;
    const auto take = [&](double time_s, const Eigen::VectorXd& push_m) {
        if (!times.empty()) {  // divides the interval since the row before
            const double from_s = times.back();
            const Eigen::VectorXd from_m = pushes.back();
            const int count = steps_of(time_s - from_s, trajectory_steps::longest_of_row_s);
            for (int k = 1; k < count; ++k) {
                const double part = static_cast<double>(k) / count;
                times.push_back(from_s + part * (time_s - from_s));
                pushes.emplace_back(from_m + part * (push_m - from_m));
            }
        }
        times.push_back(time_s);
        pushes.push_back(push_m);
    };
    Eigen::VectorXd last_m;
    while (line.next_row()) {
        if (line.size() != columns) line.refuse(fmt::format("has {} fields, the header has {}", line.size(), columns));
        const double time_s = line.number(0, "time_s");
        Eigen::VectorXd push_m(D);
        for (Eigen::Index d = 0; d < D; ++d) push_m[d] = line.number(static_cast<std::size_t>(1 + d));
        if (times.empty() && (time_s != 0 || push_m.norm() != 0)) line.refuse("the displacement history must begin at time 0 and at rest, 0 along each axis");
        if (!times.empty() && !(time_s > before_s)) line.refuse(fmt::format("time_s = {:g} is not later than the row before, {:g}", time_s, before_s));
        if (time_s > trajectory_steps::longest_of_file_s) line.refuse(fmt::format("time_s = {:g}: a displacement history lasts at most {:g} s", time_s, trajectory_steps::longest_of_file_s));
        before_s = time_s;
        last_m = push_m;
        passed_over = !times.empty() && time_s - times.back() < trajectory_steps::nearest_rows_s * (1 - tiny);
        if (!passed_over) take(time_s, push_m);
    }
    if (passed_over) take(before_s, last_m);
    if (times.size() < 2) line.refuse("must have at least two rows");
    Trajectory trajectory;
    trajectory.time_s = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
    trajectory.push_m.resize(trajectory.time_s.size(), D);
    for (Eigen::Index t = 0; t < trajectory.time_s.size(); ++t) trajectory.push_m.row(t) = pushes[static_cast<std::size_t>(t)].transpose();
    trajectory.contact.assign(times.size(), 1);
    if (!(trajectory.depth_m() > 0)) line.refuse("the tool never moves");
    return trajectory;
}

std::string trajectory_text(const Trajectory& trajectory) {
    std::string text;
    for (Eigen::Index t = 0; t < trajectory.time_s.size(); ++t) {
        text += fmt::format("{}", trajectory.time_s[t]);
        for (Eigen::Index d = 0; d < trajectory.push_m.cols(); ++d) text += fmt::format(" {}", trajectory.push_m(t, d));
        text += fmt::format(" 0 {}\n", trajectory.contact[static_cast<std::size_t>(t)]);
    }
    return text;
}

}  // namespace tissue
