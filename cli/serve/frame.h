#pragma once

#include <string>
#include <vector>

#include "scene.h"

namespace tissue::serve {

/// Counts and figures of the server, for the head of a frame.
struct TickSummary {
    double ticks_a_second = 0, p50_us = 0, p99_us = 0;
    long long faults = 0, clients = 0;
    long long ticks = 0, misses = 0, misses_program = 0, clamped = 0;
};

/// One state as all pages get it (cli/view/PROTOCOL.md): a head of numbers, and the positions of all drawn nodes.
struct Frame {
    int dimension = 2;
    /// 32 numbers; in space 40, of which 38 and 39 differ per page; 14 more with two tools, in space 20
    std::vector<double> head;
    std::vector<std::vector<float>> nodes_m;  ///< of each mesh: D numbers per node of Scene::shown()
};

Frame make_frame(const TickState& state, const Scene& scene, const Near& near, const TickSummary& summary);

/// Encodes frames for one page, little-endian. In the plane each frame has every node. In space it has the nodes that
/// are more than 1 um from their last position on that page; the first frame after forget() has all.
class FrameCoder {
   public:
    std::string encode(const Frame& frame);
    void forget() { has_.clear(); }   ///< the page has no nodes: it is new, or its model has changed

   private:
    std::vector<std::vector<float>> has_;   ///< node positions on the page, as Frame::nodes_m
};

}  // namespace tissue::serve
