#include "frame.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace tissue::serve {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the page reads little-endian");

constexpr float still_m = 1e-6F;                  ///< a node that has moved by less is not sent
constexpr std::size_t in_plane = 32, in_space = 40;
constexpr std::size_t second_in_plane = 14, second_in_space = 20;
constexpr std::size_t contact_at = 29;            ///< index of the first tool's contact at rest; z after y
constexpr std::size_t moved_nodes = 38;           ///< index of the number of nodes in a frame, one per mesh

double number(long long n) {
    return static_cast<double>(n);
}

template <class Number>
void append(std::string& bytes, const std::vector<Number>& numbers) {
    bytes.append(reinterpret_cast<const char*>(numbers.data()), sizeof(Number) * numbers.size());
}

bool far(const float* a, const float* b) {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return !(x * x + y * y + z * z <= still_m * still_m);   // also true where not finite
}

}  // namespace

Frame make_frame(const TickState& s, const Scene& scene, const Near& near, const TickSummary& sum) {
    const HapticModel& model = scene.model();
    const TickRecord& r = s.record;
    Frame frame;
    frame.dimension = model.dimension();
    const std::size_t own = model.is_solid() ? in_space : in_plane;
    frame.head.assign(own + (model.options.tools < 2 ? 0 : model.is_solid() ? second_in_space : second_in_plane), 0);
    std::vector<double>& head = frame.head;
    // x and y are adjacent; in space the z values of all points follow later
    std::size_t z = in_plane;
    const auto put = [&](std::size_t at, const Point& p) {
        head[at] = p[0];
        head[at + 1] = p[1];
        if (model.is_solid()) head[z++] = p[2];
    };
    const Point nothing = Point::Zero(model.dimension());
    const auto contact_of = [&](const TickRecord& of) { return of.mesh < 0 ? nothing : model.meshes[0]->springs.rest_place(of.facet, of.weight); };
    head[0] = r.time_s;
    head[1] = number(sum.ticks);
    head[2] = number(sum.misses);
    head[3] = number(sum.misses_program);
    head[4] = number(sum.clamped);
    head[5] = number(sum.faults);
    head[6] = sum.ticks_a_second;
    head[7] = sum.p50_us;
    head[8] = sum.p99_us;
    put(9, r.master_m);
    put(11, s.proxy_m);
    head[13] = number(r.mesh);
    put(14, s.contact_displacement_m[0]);
    put(16, s.contact_displacement_m.size() > 1 ? s.contact_displacement_m[1] : nothing);
    put(18, -r.coupling_N);
    put(20, model.options.map.force_to_tissue(r.device_N));
    head[22] = number(near.place);
    head[23] = near.force_N;
    head[24] = number(r.set);
    head[25] = r.fault() ? 1 : 0;
    head[26] = number(sum.clients);
    head[27] = s.rested_s;
    head[28] = static_cast<double>(r.status);
    const Point contact = contact_of(r);
    std::copy(contact.begin(), contact.end(), head.begin() + contact_at);
    if (model.options.tools > 1) {
        const ToolTick& second = s.second;
        head[own] = number(second.record.mesh);
        head[own + 1] = static_cast<double>(second.record.status);
        z = own + second_in_plane;
        put(own + 2, second.record.master_m);
        put(own + 4, second.proxy_m);
        put(own + 6, second.contact_displacement_m[0]);
        put(own + 8, -second.record.coupling_N);
        put(own + 10, model.options.map.force_to_tissue(second.record.device_N));
        put(own + 12, contact_of(second.record));
    }

    const auto d = static_cast<std::size_t>(frame.dimension);
    const float* first = s.nodes_m.data();
    for (const auto& mesh : model.meshes) {
        std::vector<float> nodes;
        nodes.reserve(d * scene.shown().size());
        for (int n : scene.shown()) nodes.insert(nodes.end(), first + d * static_cast<std::size_t>(n), first + d * static_cast<std::size_t>(n + 1));
        frame.nodes_m.push_back(std::move(nodes));
        first += d * static_cast<std::size_t>(mesh->springs.node_count());
    }
    return frame;
}

std::string FrameCoder::encode(const Frame& frame) {
    std::string bytes;
    append(bytes, frame.head);
    if (frame.dimension == 2) {
        for (const std::vector<float>& nodes : frame.nodes_m) append(bytes, nodes);
        return bytes;
    }
    bool all = has_.size() != frame.nodes_m.size();
    for (std::size_t m = 0; m < has_.size() && !all; ++m) all = has_[m].size() != frame.nodes_m[m].size();
    if (all) has_ = frame.nodes_m;
    for (std::size_t m = 0; m < frame.nodes_m.size(); ++m) {
        const std::vector<float>& nodes = frame.nodes_m[m];
        std::vector<std::uint32_t> moved;
        std::vector<float> places;
        for (std::size_t k = 0; k < nodes.size(); k += 3) {
            if (!all && !far(&nodes[k], &has_[m][k])) continue;
            moved.push_back(static_cast<std::uint32_t>(k / 3));
            places.insert(places.end(), &nodes[k], &nodes[k] + 3);
            std::copy_n(&nodes[k], 3, &has_[m][k]);
        }
        const auto count = static_cast<double>(moved.size());
        std::memcpy(bytes.data() + sizeof(double) * (moved_nodes + m), &count, sizeof count);
        append(bytes, moved);
        append(bytes, places);
    }
    return bytes;
}

}  // namespace tissue::serve
