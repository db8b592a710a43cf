#include "export/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace tissue {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the bytes below are written as they lie in memory");

template <class Value>
std::string bytes(const std::vector<Value>& values) {
    std::string out(values.size() * sizeof(Value), '\0');
    if (!values.empty()) std::memcpy(out.data(), values.data(), out.size());
    return out;
}

/// UTF-8 to code points. Invalid bytes become U+FFFD.
std::u32string code_points(const std::string& text) {
    std::u32string out;
    for (std::size_t i = 0; i < text.size();) {
        const auto lead = static_cast<unsigned char>(text[i++]);
        const int more = lead < 0x80 ? 0 : lead >> 5 == 6 ? 1 : lead >> 4 == 14 ? 2 : lead >> 3 == 30 ? 3 : -1;
        char32_t point = more == 0 ? lead : more > 0 ? lead & (0x3fu >> more) : 0xfffd;
        for (int k = 0; k < more && i < text.size() && (text[i] & 0xc0) == 0x80; ++k)
            point = point << 6 | (text[i++] & 0x3f);
        out.push_back(point);
    }
    return out;
}

/// The .npy header: magic, version 1.0, header length, and the dictionary, padded so that the data starts at a multiple
/// of 64 bytes.
std::string header(const std::string& type, const std::vector<std::size_t>& shape) {
    std::string tuple;
    for (std::size_t n : shape) tuple += fmt::format("{}, ", n);
    std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, tuple);
    text.resize((text.size() + 10 + 1 + 63) / 64 * 64 - 10, ' ');
    text.back() = '\n';
    const auto length = static_cast<std::uint16_t>(text.size());
    return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(length & 0xff) + static_cast<char>(length >> 8) +
           text;
}

std::string npy_texts(const std::vector<std::string>& texts, const std::vector<std::size_t>& shape) {
    std::vector<std::u32string> rows;
    std::size_t longest = 1;
    for (const std::string& text : texts) {
        rows.push_back(code_points(text));
        longest = std::max(longest, rows.back().size());
    }
    std::vector<char32_t> points(rows.size() * longest, 0);
    for (std::size_t i = 0; i < rows.size(); ++i)
        std::copy(rows[i].begin(), rows[i].end(), points.begin() + static_cast<std::ptrdiff_t>(i * longest));
    return header(fmt::format("<U{}", longest), shape) + bytes(points);
}

}  // namespace

Files npy_files(const Hdf5Reader& in) {
    Files files;
    for (const std::string& name : in.datasets()) {
        const std::vector<std::size_t> shape = in.shape(name);
        std::string content;
        switch (in.kind(name)) {
            case DatasetKind::numbers:
                content = header("<f8", shape) + bytes(in.array(name).values);
                break;
            case DatasetKind::integers:
                content = header("<i4", shape) + bytes(in.integers(name));
                break;
            case DatasetKind::texts:
                content = npy_texts(in.texts(name), shape);
                break;
        }
        files[name.substr(1) + ".npy"] = std::move(content);
    }
    return files;
}

namespace {

/// For springs that are not Hooke's.
Files curve_files(const SpringCurve& curve) {
    if (curve.hookean()) return {};
    return {{"law/spring_curve.npy", header("<f8", {3}) + bytes(std::vector<double>{curve.q(), curve.shorter().stretch, curve.longer().stretch})}};
}

}  // namespace

Files npy_files(const EnergyModelTables& tables) {
    std::vector<int> edges;
    for (std::size_t k = 0; k < tables.edge_area.size(); ++k)
        edges.insert(edges.end(), {tables.edge_area[k], tables.edge_from[k], tables.edge_to[k]});
    const std::vector<double> area_m2(tables.area_m2.begin(), tables.area_m2.end());
    const std::size_t areas = tables.area_kind.size(), nodes = tables.surface_node.size();
    Files files = curve_files(tables.curve);
    files.merge(Files{{"law/area_edges.npy", header("<i4", {tables.edge_area.size(), 3}) + bytes(edges)},
            {"law/area_kind.npy", npy_texts(tables.area_kind, {areas})},
            {"law/area_rest.npy", header("<f8", {areas}) + bytes(area_m2)},
            {"law/surface_node.npy", header("<i4", {nodes}) + bytes(tables.surface_node)},
            {"law/surface_arc.npy", header("<f8", {nodes}) + bytes(tables.surface_arc_m)}});
    return files;
}

Files npy_files(const SolidModelTables& tables, const ContactTable& contact) {
    const std::size_t R = contact.k_N_m.size(), Q = contact.pull_row.size();
    const auto numbers = [](const auto& values) { return std::vector<double>(values.data(), values.data() + values.size()); };
    const std::vector<int> corners(tables.cells.data(), tables.cells.data() + tables.cells.size());
    Files files = curve_files(tables.curve);
    files.merge(Files{{"law/cells.npy", header("<i4", {static_cast<std::size_t>(tables.cells.rows()), static_cast<std::size_t>(tables.cells.cols())}) + bytes(corners)},
            {"law/cell_at.npy", header("<f8", {static_cast<std::size_t>(tables.at.rows()), 3}) + bytes(numbers(tables.at))},
            {"law/cell_rest.npy", header("<f8", {static_cast<std::size_t>(tables.volume_m3.size())}) + bytes(numbers(tables.volume_m3))},
            {"law/contact_case.npy", header("<i4", {R}) + bytes(contact.load_case)},
            {"law/contact_kind.npy", npy_texts(contact.kind, {R})},
            {"law/contact_k.npy", header("<f8", {R}) + bytes(contact.k_N_m)},
            {"law/contact_push.npy", header("<f8", {R, 3}) + bytes(numbers(contact.push))},
            {"law/contact_pull_row.npy", header("<i4", {Q}) + bytes(contact.pull_row)},
            {"law/contact_pull_node.npy", header("<i4", {Q}) + bytes(contact.pull_node)},
            {"law/contact_pull.npy", header("<f8", {Q, 3}) + bytes(numbers(contact.pull))},
            {"law/contact_hardening.npy", header("<f8", {static_cast<std::size_t>(contact.hardening.rows()), 4}) + bytes(numbers(contact.hardening))}});
    return files;
}

}  // namespace tissue
