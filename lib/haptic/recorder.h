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

/// What is kept of one tick: of each tool, and of the loop.
struct RecordedTick {
    std::array<TickRecord, most_tools> tool;
    double time_s = 0, tick_us = 0, lateness_us = 0;
};

/// The group of a tool's datasets in a recording: "" of the first, "/second" of the second.
const char* recorded_tool(int tool);

/// Writes a session to HDF5 (kind `recording`, results/FORMATS.md) from a thread of its own, as it goes: memory holds the
/// ring and one block of ticks, however long the session. The tick pushes into the ring and never waits; what does not
/// fit is dropped and counted. Where ticks have no clock they wait for the disk, and nothing is dropped. HDF5 belongs to that thread until close().
class Recorder final : public TickHook {
   public:
    /// dimension: of the tissue; tools: of the session. Throws FileError when the file cannot be written. ring: ticks that fit while the disk is slow.
    Recorder(const std::string& file, int dimension, const Provenance& provenance, int tools = 1, std::size_t ring = 8192);
    /// Closes without an error message; call close() to hear of one.
    ~Recorder() override;
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    void after(const Simulation& simulation, const TickBooks& books) noexcept override;

    /// From the tick. waits: for room, where no clock asks for the next tick.
    void push(const RecordedTick& tick, bool waits = false) noexcept;
    long long dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

    /// After the last tick: the file appears, whole. Attributes go to its root, and what differs of a second tool to its group. Throws FileError, also for what the disk
    /// refused on the way.
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
    std::exception_ptr error_;            ///< of the thread; from then on ticks are let go
    std::atomic<long long> dropped_{0};
    std::atomic<bool> done_{false};
    std::thread thread_;
};

}  // namespace tissue
