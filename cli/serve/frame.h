#pragma once

#include <string>
#include <vector>

#include "scene.h"

namespace tissue::serve {

/// What the server counts and measures, for the head of a frame.
struct TickSummary {
    double ticks_a_second = 0, p50_us = 0, p99_us = 0;
    long long faults = 0, clients = 0;
    long long ticks = 0, misses = 0, misses_program = 0, clamped = 0;
};

/// One state as all pages get it (cli/view/PROTOCOL.md): its numbers, and where every node is that pages draw.
struct Frame {
    int dimension = 2;
    std::vector<double> head;                 ///< 32 numbers, in space 40, of which 38 and 39 are each page's own; of two tools 14 more, in space 20
    std::vector<std::vector<float>> nodes_m;  ///< of each mesh: D numbers a node of Scene::shown()
};

Frame make_frame(const TickState& state, const Scene& scene, const Near& near, const TickSummary& summary);

/// Makes bytes of frames for one page, little-endian. In the plane each has every node. In space each has those that are more
/// than 1 um from where that page has them, and the first after forget() has all.
class FrameCoder {
   public:
    std::string encode(const Frame& frame);
    void forget() { has_.clear(); }   ///< the page knows nothing: it has just come, or its model is another

   private:
    std::vector<std::vector<float>> has_;   ///< where the page has the nodes, as Frame::nodes_m
};

}  // namespace tissue::serve
