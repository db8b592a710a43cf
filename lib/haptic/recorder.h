#pragma once

#include <array>
#include <atomic>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include "haptic/spsc_ring.h"
#include "haptic/tick_hook.h"
#include "io/hdf5_store.h"

namespace tissue {

/// Data of one tick: the record of each tool, and times of the loop.
struct RecordedTick {
    std::array<TickRecord, most_tools> tool;
    double time_s = 0, tick_us = 0, lateness_us = 0;
};

/// Group of a tool's datasets in a recording: "" for the first tool, "/second" for the second.
const char* recorded_tool(int tool);

/// Writes a session to HDF5 (kind `recording`, results/FORMATS.md) in a thread of its own while the session runs.
/// Memory holds the ring and one block of ticks, whatever the length of the session. The tick pushes into the ring and
/// never waits; ticks that do not fit are dropped and counted. Where ticks have no clock they wait for the disk, and
/// none is dropped. Only that thread uses HDF5 until close().
class Recorder final : public TickHook {
   public:
    /// dimension: of the tissue. tools: of the session. ring: ticks that fit while the disk is slow, 8 s at 1 kHz by
    /// default. Throws FileError where the file cannot be written.
    Recorder(const std::string& file, int dimension, const Provenance& provenance, int tools = 1, std::size_t ring = 8192);
    /// Ends the thread. Without close() before, no file appears and no error is reported.
    ~Recorder() override;
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    void after(const Simulation& simulation, const TickStatistics& books) noexcept override;

    /// Called in the tick. waits: whether to wait for room in the ring, for ticks without a clock.
    void push(const RecordedTick& tick, bool waits = false) noexcept;
    long long dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

    /// After the last tick: completes the file and moves it into place. Attributes go to its root, those of a second
    /// tool to that tool's group. Throws FileError, also for an error of the thread before.
    void close(const Simulation& simulation);

   private:
    int columns(int axes) const { return axes < 0 ? dimension_ : axes; }
    template <class Use> void each_dataset(const Use& use) const;
    void drain();
    void write_block();
    void run();

    SpscRing<RecordedTick> ring_;
    int dimension_, tools_;
    std::vector<RecordedTick> block_;     ///< not yet written
    Hdf5Writer out_;
    std::exception_ptr error_;            ///< first error of the thread; later ticks are discarded
    std::atomic<long long> dropped_{0};
    std::atomic<bool> done_{false};
    std::thread thread_;
};

}  // namespace tissue
