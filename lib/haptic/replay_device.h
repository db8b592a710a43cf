#pragma once

#include <string>
#include <vector>

#include "haptic/device_kinds.h"

namespace tissue {

/// Plays a recorded trajectory: a CSV with the header time_s,x_m,y_m[,z_m][,fx_N,fy_N[,fz_N]], ascending times, read as CsvTable (another column is refused), or a
/// recording of tissue-haptic (.h5). Between rows the hand moves on a straight line. Where the file has forces they
/// are the reference: statistics() says how far ours are from them. They are what went to the hand, so that the tool's own, which a sensor
/// would have read, are their opposite. Where a recording was reset, the tissue is put to rest again: what relaxes remembers what it did
/// then.
class ReplayDevice final : public Device {
   public:
    static const DeviceKind kind;

    /// tool: of a session, 0 or 1; it is played what a recording of two tools has of it. Throws FileError with file, line and cause, DeviceError when there is nothing in it.
    explicit ReplayDevice(const std::string& file, int tool = 0);

    std::string name() const override { return kind.name; }
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override;
    bool finished() const noexcept override { return finished_; }
    std::vector<std::pair<std::string, double>> statistics() const override;

    bool has_z() const { return has_z_; }  ///< else z is 0
    bool has_fz() const { return has_fz_; }  ///< or there are no forces
    std::size_t size() const { return time_s_.size(); }

   private:
    Eigen::Vector3d reference_now() const noexcept;
    void compare(const Eigen::Vector3d& force_N) noexcept;
    void read_csv(const std::string& file);
    void read_recording(const std::string& file, int tool);

    std::vector<double> time_s_;
    std::vector<Eigen::Vector3d> position_m_, reference_N_;  ///< reference empty when the file has none
    std::vector<bool> reset_;  ///< before a row; empty when the file does not say
    std::size_t next_ = 1, passed_ = 0;  ///< row ahead, and rows whose reset has been told
    bool has_z_ = true, has_fz_ = true;
    double share_ = 0;       ///< between next_ - 1 and next_
    bool finished_ = false, answered_ = true;  ///< a force has come for the position read last: write() after read() is compared once, the zero at a session's end is not
    double squared_error_ = 0, squared_reference_ = 0, largest_error_ = 0;
    long long compared_ = 0;
};

}  // namespace tissue
