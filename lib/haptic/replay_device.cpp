#include "haptic/replay_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptic/device_error.h"
#include "haptic/recorder.h"
#include "io/csv_columns.h"
#include "io/csv_table.h"
#include "io/hdf5_store.h"
#include "io/one_line.h"

namespace tissue {

const DeviceKind ReplayDevice::kind = {
    "replay",
    {{"trajectory", "FILE", "", "for replay: CSV or a recording", true}},
    [](const DeviceValues& v, const DeviceContext& c) -> std::unique_ptr<Device> {
        auto device = std::make_unique<ReplayDevice>(v.at("trajectory"), c.tool);
        if (c.rest && c.rest->is_solid() && !device->has_z()) throw DeviceError(v.at("trajectory") + ": has no column z_m, and the tissue is in space");
        if (c.rest && c.rest->is_solid() && !device->has_fz()) throw DeviceError(v.at("trajectory") + ": has fx_N and fy_N but no fz_N: a tissue in space needs all three");
        return device;
    },
    {}, 0, true, true};

ReplayDevice::ReplayDevice(const std::string& file, int tool) {
    const bool recording = file.size() > 3 && file.compare(file.size() - 3, 3, ".h5") == 0;
    recording ? read_recording(file, tool) : read_csv(file);
    if (time_s_.empty()) throw DeviceError(file + ": has no trajectory");
}

void ReplayDevice::read_csv(const std::string& file) {
    CsvTable line(file);
    if (!line.next_row()) throw FileError(file + ": is empty");
    static const std::vector<std::string> known = {"time_s", "x_m", "y_m", "z_m", "fx_N", "fy_N", "fz_N"};
    const std::string wanted = "must have the columns time_s,x_m,y_m and may have z_m,fx_N,fy_N,fz_N";
    std::vector<int> column(known.size(), -1);
    const std::size_t columns = line.size();
    for (std::size_t h = 0; h < columns; ++h) {
        const auto k = std::find(known.begin(), known.end(), trimmed(line.field(h)));
        if (k == known.end()) line.refuse(fmt::format("column '{}' is not known; {}", one_line(line.field(h)), wanted));
        int& at = column[static_cast<std::size_t>(k - known.begin())];
        if (at >= 0) line.refuse(fmt::format("column '{}' is present twice", *k));
        at = static_cast<int>(h);
    }
    if (column[0] < 0 || column[1] < 0 || column[2] < 0) line.refuse(wanted);
    if ((column[4] < 0) != (column[5] < 0) || (column[6] >= 0 && column[4] < 0)) line.refuse("forces need the columns fx_N and fy_N, in space also fz_N");
    const bool reference = column[4] >= 0;
    while (line.next_row()) {
        if (line.size() != columns) line.refuse(fmt::format("has {} fields, the header has {}", line.size(), columns));
        double value[7] = {};
        for (std::size_t k = 0; k < known.size(); ++k)
            if (column[k] >= 0) value[k] = line.number(static_cast<std::size_t>(column[k]), known[k]);
        if (!time_s_.empty() && !(value[0] > time_s_.back())) line.refuse("times must ascend");
        time_s_.push_back(value[0]);
        position_m_.push_back({value[1], value[2], value[3]});
        if (reference) reference_N_.push_back({value[4], value[5], value[6]});
    }
    has_z_ = column[3] >= 0;
    has_fz_ = !reference || column[6] >= 0;
}

void ReplayDevice::read_recording(const std::string& file, int tool) {
    const Hdf5Reader in(file, "recording");
    const std::string of_tool = tool > 0 && in.has(recorded_tool(tool)) ? recorded_tool(tool) : "", places = of_tool + "/device_position", forces = of_tool + "/device_force";
    const Eigen::VectorXd time = in.vector("/time");
    const NodeField position = in.field(places), force = in.field(forces);
    if (position.rows() != time.size() || force.rows() != time.size() || position.cols() != 3 || force.cols() != 3)
        in.refuse(places, "does not have one row per tick");
    // recordings of earlier programs have none
    const std::vector<int> reset = in.has("/reset") ? in.integers("/reset") : std::vector<int>(static_cast<std::size_t>(time.size()), 0);
    if (reset.size() != static_cast<std::size_t>(time.size())) in.refuse("/reset", "does not have one row per tick");
    const std::string grasps = of_tool + "/grasp";
    const std::vector<int> grasp = in.has(grasps) ? in.integers(grasps) : std::vector<int>(reset.size(), 0);
    if (grasp.size() != reset.size()) in.refuse(grasps, "does not have one row per tick");
    for (Eigen::Index k = 0; k < time.size(); ++k) {
        if (k > 0 && !(time[k] > time[k - 1])) in.refuse("/time", "must ascend");
        time_s_.push_back(time[k]);
        position_m_.push_back(position.row(k));
        reference_N_.push_back(force.row(k));
        reset_.push_back(reset[static_cast<std::size_t>(k)] != 0);
        grasp_.push_back(grasp[static_cast<std::size_t>(k)] != 0);
    }
}

DeviceSample ReplayDevice::read(double time_s) noexcept {
    const double time = time_s_.front() + time_s;
    constexpr double same_s = 1e-7;  // rounding: times of ticks and of rows are different sums
    while (next_ < time_s_.size() && time_s_[next_] <= time + same_s) ++next_;
    DeviceSample sample;
    sample.position_m = position_m_[next_ - 1];
    sample.grasp = next_ <= grasp_.size() && grasp_[next_ - 1];
    for (; passed_ < next_; ++passed_) sample.reset = sample.reset || (passed_ < reset_.size() && reset_[passed_]);
    share_ = 0;
    if (next_ < time_s_.size()) {
        share_ = (time - time_s_[next_ - 1]) / (time_s_[next_] - time_s_[next_ - 1]);
        if (share_ * (time_s_[next_] - time_s_[next_ - 1]) < same_s) share_ = 0;
        sample.position_m += share_ * (position_m_[next_] - position_m_[next_ - 1]);
    }
    if (!reference_N_.empty()) sample.measured_N = -reference_now();
    finished_ = next_ == time_s_.size();
    answered_ = false;
    return sample;
}

Eigen::Vector3d ReplayDevice::reference_now() const noexcept {
    Eigen::Vector3d reference = reference_N_[next_ - 1];
    if (share_ > 0) reference += share_ * (reference_N_[next_] - reference);
    return reference;
}

void ReplayDevice::write(const Eigen::Vector3d& force_N) noexcept {
    if (!std::exchange(answered_, true) && !reference_N_.empty()) compare(force_N);
}

void ReplayDevice::compare(const Eigen::Vector3d& force_N) noexcept {
    const Eigen::Vector3d reference = reference_now();
    const double error = (force_N - reference).norm();
    squared_error_ += error * error;
    squared_reference_ += reference.squaredNorm();
    largest_error_ = std::max(largest_error_, error);
    ++compared_;
}

std::vector<std::pair<std::string, double>> ReplayDevice::statistics() const {
    if (compared_ == 0) return {};
    const auto n = static_cast<double>(compared_);
    return {{"reference_rms_N", std::sqrt(squared_reference_ / n)},
            {"reference_error_rms_N", std::sqrt(squared_error_ / n)},
            {"reference_error_max_N", largest_error_}};
}

}  // namespace tissue
