#pragma once

#include <string>
#include <vector>

#include "haptic/device_kinds.h"

namespace tissue {

/// Plays a recorded trajectory: a CSV file, or a recording of tissue-haptic (.h5). The CSV has the header
/// time_s,x_m,y_m[,z_m][,fx_N,fy_N[,fz_N]] and ascending times; it is read by CsvTable, and other columns are refused.
/// Between rows the position is interpolated linearly.
///
/// Forces in the file are the reference: statistics() gives the deviation of the session's forces from them. They are
/// forces on the hand. A force sensor in the tool measures their opposite, which is measured_N of the samples. Where
/// the recorded session was reset, the tissue is put to rest again, since the force of a relaxing tissue depends on its
/// history.
class ReplayDevice final : public Device {
   public:
    static const DeviceKind kind;

    /// tool: 0 or 1, number of the session's tool; of a recording with two tools the data of this one are played.
    /// Throws FileError with file, line and cause, and DeviceError for a file without rows.
    explicit ReplayDevice(const std::string& file, int tool = 0);

    std::string name() const override { return kind.name; }
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override;
    bool finished() const noexcept override { return finished_; }
    std::vector<std::pair<std::string, double>> statistics() const override;

    bool has_z() const { return has_z_; }  ///< false: z is 0
    bool has_fz() const { return has_fz_; }  ///< false: the file has fx_N and fy_N, but no fz_N
    std::size_t size() const { return time_s_.size(); }

   private:
    Eigen::Vector3d reference_now() const noexcept;
    void compare(const Eigen::Vector3d& force_N) noexcept;
    void read_csv(const std::string& file);
    void read_recording(const std::string& file, int tool);

    std::vector<double> time_s_;
    std::vector<Eigen::Vector3d> position_m_, reference_N_;  ///< reference empty where the file has no forces
    std::vector<bool> reset_;  ///< whether a reset precedes each row; empty for a CSV
    std::vector<bool> grasp_;  ///< whether the tool is to grasp from each row on; empty for a CSV
    std::size_t next_ = 1, passed_ = 0;  ///< first row after the present time; number of rows whose reset was reported
    bool has_z_ = true, has_fz_ = true;
    double share_ = 0;       ///< of the way from row next_ - 1 to next_, 0 to 1
    /// answered_: a force has come for the position read last. Only the first write() after a read() is compared, and
    /// so the zero force at a session's end is not
    bool finished_ = false, answered_ = true;
    double squared_error_ = 0, squared_reference_ = 0, largest_error_ = 0;
    long long compared_ = 0;
};

}  // namespace tissue
