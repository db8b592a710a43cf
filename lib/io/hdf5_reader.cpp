#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <numeric>
#include <set>

#include "error.h"
#include "io/hdf5_handle.h"
#include "io/hdf5_store.h"
#include "version.h"

namespace tissue {
namespace {

/// Limit of all packed datasets of one file in memory: a few bytes of gzip may expand a thousandfold.
constexpr std::size_t most_unpacked = std::size_t{256} << 20;

/// Files of this project have far fewer and shorter names.
constexpr std::size_t most_names = std::size_t{1} << 16, longest_name = 1024, deepest_group = 32;

/// Length of the UTF-8 character that begins at i; 0: there is none (Unicode 15, table 3-7).
std::size_t character_at(const std::string& text, std::size_t i) {
    const auto byte = [&](std::size_t k) -> int { return i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0; };
    const auto follow = [&](std::size_t from, std::size_t to) {
        for (std::size_t k = from; k < to; ++k)
            if ((byte(k) & 0xC0) != 0x80) return false;
        return true;
    };
    const int first = byte(0), second = byte(1);
    if (first < 0x80) return 1;
    if (first >= 0xC2 && first <= 0xDF) return follow(1, 2) ? 2 : 0;
    if (first >= 0xE0 && first <= 0xEF) return follow(1, 3) && !(first == 0xE0 && second < 0xA0) && !(first == 0xED && second > 0x9F) ? 3 : 0;
    if (first >= 0xF0 && first <= 0xF4) return follow(1, 4) && !(first == 0xF0 && second < 0x90) && !(first == 0xF4 && second > 0x8F) ? 4 : 0;
    return 0;
}

/// Makes a text one line of valid UTF-8. Names and texts of foreign files may not be, and would break messages and
/// JSON.
std::string one_line(std::string text) {
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = character_at(text, i);
        const auto c = static_cast<unsigned char>(text[i]);
        if (length == 0 || c < ' ' || c == 127) text[i] = '?';
        // C1 controls: terminals obey them, too
        if (length == 2 && c == 0xC2 && static_cast<unsigned char>(text[i + 1]) < 0xA0) text.replace(i, 2, "??");
        i += length == 0 ? 1 : length;
    }
    return text;
}

/// Access property list whose links must stay within the file: a foreign file may link to any file of this machine, or
/// to one that never answers.
hid_t within_file() {
    static const hid_t access = [] {
        const hid_t made = H5Pcreate(H5P_DATASET_ACCESS);  // also applies to links
        H5Pset_elink_cb(made, [](const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) -> herr_t { return -1; }, nullptr);
        return made;
    }();
    return access;
}

/// Whether the values of a dataset are in this file, not in others.
bool holds_values(hid_t dataset) {
    const Hdf5Handle creation(H5Dget_create_plist(dataset), H5Pclose);
    return H5Pget_layout(creation) != H5D_VIRTUAL && H5Pget_external_count(creation) == 0;
}

enum class Packing { none, gzip, other };

/// Checksums and byte shuffling do not pack. Filters other than gzip may be programs that HDF5 loads, or may claim any
/// size.
Packing packing_of(hid_t creation) {
    Packing packing = Packing::none;
    for (int i = 0; i < H5Pget_nfilters(creation); ++i) {
        unsigned flags = 0, settings = 0;
        std::size_t none = 0;
        const H5Z_filter_t filter = H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &none, nullptr, 0, nullptr, &settings);
        if (filter == H5Z_FILTER_DEFLATE)
            packing = Packing::gzip;
        else if (filter != H5Z_FILTER_FLETCHER32 && filter != H5Z_FILTER_SHUFFLE)
            return Packing::other;
    }
    return packing;
}

/// Number of values in the chunks of a dataset, the last of which may reach beyond its shape; without chunks, the
/// number of its values.
std::size_t values_in_pieces(hid_t creation, const std::vector<std::size_t>& shape) {
    if (H5Pget_layout(creation) != H5D_CHUNKED) return product(shape);
    std::vector<hsize_t> piece(shape.size());
    if (H5Pget_chunk(creation, static_cast<int>(piece.size()), piece.data()) != static_cast<int>(piece.size())) return most_values + 1;
    std::vector<std::size_t> whole(shape.size());
    for (std::size_t d = 0; d < shape.size(); ++d) {
        if (piece[d] == 0 || piece[d] > most_values || shape[d] > most_values) return most_values + 1;
        whole[d] = (shape[d] + piece[d] - 1) / piece[d] * piece[d];
    }
    return product(whole);
}

/// Integers or floating point numbers of at most 8 bytes. For larger values HDF5 allocates a buffer of that size per
/// value.
bool is_number(hid_t type) {
    const H5T_class_t kind = H5Tget_class(type);
    return (kind == H5T_FLOAT || kind == H5T_INTEGER) && H5Tget_size(type) <= sizeof(double);
}

/// Whether an attribute has exactly one value: reading more into one variable would write past it.
bool is_single(hid_t attribute) {
    const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
    return H5Sget_simple_extent_npoints(space) == 1;
}

/// Texts of variable length are in a heap that no checksum covers. A damaged or malicious heap makes libhdf5 1.10
/// access memory that is not its own.
constexpr const char* any_length = "of variable length, which no checksum covers: make the file again, or store texts of fixed length";

bool read_text(hid_t attribute, hid_t stored, std::string& value) {
    constexpr std::size_t longest = std::size_t{1} << 20;
    if (H5Tget_class(stored) != H5T_STRING || H5Tget_size(stored) > longest) return false;
    value.assign(H5Tget_size(stored), '\0');
    const Hdf5Handle type(text_type(value.size(), H5Tget_cset(stored)), H5Tclose);
    if (H5Aread(attribute, type, value.data()) < 0) return false;
    value.resize(value.find_last_not_of('\0') + 1);
    return true;
}

/// The cause, after HDF5 has refused to open a file.
std::string why_not_opened(const std::string& file) {
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return fmt::format(": cannot read: {}", std::strerror(errno));
    // HDF5 locks files that it writes
    const bool held = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    ::close(descriptor);
    return held ? ": is open for writing in another program: close it there" : ": is not an HDF5 file, or is truncated";
}

}  // namespace

Hdf5Reader::Hdf5Reader(std::string file, const std::string& kind) : file_(std::move(file)) {
    silence_hdf5();
    std::error_code error;
    if (std::filesystem::is_directory(file_, error)) throw FileError(file_ + ": is a folder; give a file");
    if (!std::filesystem::is_regular_file(file_, error)) throw FileError(file_ + ": there is no such file");
    bytes_ = std::filesystem::file_size(file_, error);
    id_ = H5Fopen(file_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (id_ < 0) throw FileError(file_ + why_not_opened(file_));
    try {
        if (H5Aexists(id_, "program") <= 0 || text_attribute("/", "program") != "tissuectl")
            refuse("/", "was not written by tissuectl");
        const double file_version = number_attribute("/", "format_version");
        if (file_version > last_format_version)
            refuse("/", fmt::format("format version {} is later than this program's {}", file_version, last_format_version));
        if (file_version > energy_model_format_version && file_version < solid_format_version)
            refuse("/", fmt::format("format version {} has another energy for solids under discs and is not supported; make the file again", file_version));
        if (file_version > adapted_format_version && file_version < embedded_format_version)
            refuse("/", fmt::format("format version {} has another contact for solids and is not supported; make the file again", file_version));
        const std::string file_kind = text_attribute("/", "kind");
        if (!kind.empty() && file_kind != kind)
            refuse("/", fmt::format("has kind '{}', must have kind '{}'", file_kind, kind));
    } catch (...) {
        H5Fclose(id_);
        throw;
    }
}

Hdf5Reader::~Hdf5Reader() {
    H5Fclose(id_);
}

void Hdf5Reader::refuse(const std::string& place, const std::string& why) const {
    throw FileError(one_line(fmt::format("{}: {}: {}", file_, place, why)));  // names in a file may contain anything
}

bool Hdf5Reader::has(const std::string& name) const {
    return H5Oexists_by_name(id_, name.c_str(), within_file()) > 0;
}

std::size_t Hdf5Reader::count_of(const std::string& name, long long dataset, std::size_t bytes_a_value) const {
    const Hdf5Handle type(H5Dget_type(dataset), H5Tclose), creation(H5Dget_create_plist(dataset), H5Pclose);
    const std::vector<std::size_t> shape = shape_of(dataset);
    const std::size_t count = product(shape), stored = values_in_pieces(creation, shape);
    if (count == 0) return 0;
    const Packing packing = packing_of(creation);
    if (packing == Packing::other) refuse(name, "is compressed by a filter other than gzip");
    // the file holds at most the storage that HDF5 reports for the values, and no more than its own bytes
    const std::size_t held = std::min<std::size_t>(H5Dget_storage_size(dataset), bytes_);
    if (stored > most_values || held == 0 || (packing == Packing::none && stored * H5Tget_size(type) > held))
        refuse(name, "declares more values than the file can contain");
    if (packing == Packing::none) return count;
    // whole chunks are unpacked in memory
    std::size_t& unpacked = unpacked_[name];
    unpacked = 0;
    const std::size_t others = std::accumulate(unpacked_.begin(), unpacked_.end(), std::size_t{0}, [](std::size_t sum, const auto& one) { return sum + one.second; });
    if (stored > (most_unpacked - others) / std::max(H5Tget_size(type), bytes_a_value))
        refuse(name, fmt::format("is compressed, and the file's datasets exceed {} MiB in memory: decompress it first (h5repack -f NONE)", most_unpacked >> 20));
    unpacked = stored * std::max(H5Tget_size(type), bytes_a_value);
    return count;
}

long long Hdf5Reader::open(const std::string& name) const {
    const hid_t dataset = H5Dopen2(id_, name.c_str(), within_file());
    if (dataset < 0) refuse(name, "is missing");
    if (holds_values(dataset)) return dataset;
    H5Dclose(dataset);
    refuse(name, "has its values in another file");
}

Array Hdf5Reader::array(const std::string& name) const {
    const Hdf5Handle dataset(open(name), H5Dclose);
    const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
    if (!is_number(type)) refuse(name, "cannot be read as numbers");
    Array array;
    array.shape = shape_of(dataset);
    array.values.resize(count_of(name, dataset, sizeof(double)));
    if (!array.values.empty() &&
        H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) < 0)
        refuse(name, "cannot be read as numbers: damaged");
    return array;
}

Eigen::VectorXd Hdf5Reader::vector(const std::string& name) const {
    const Array a = array(name);
    if (a.shape.size() != 1) refuse(name, "must have one dimension");
    return Eigen::Map<const Eigen::VectorXd>(a.values.data(), static_cast<Eigen::Index>(a.values.size()));
}

NodeField Hdf5Reader::field(const std::string& name) const {
    const Array a = array(name);
    if (a.shape.size() != 2) refuse(name, "must have two dimensions");
    return Eigen::Map<const NodeField>(a.values.data(), static_cast<Eigen::Index>(a.shape[0]),
                                       static_cast<Eigen::Index>(a.shape[1]));
}

std::vector<int> Hdf5Reader::integers(const std::string& name) const {
    const Array a = array(name);
    for (const double value : a.values)
        if (!(std::abs(value) <= 2147483647.0) || value != std::floor(value))
            refuse(name, fmt::format("has {}, which is not a whole number", value));
    return {a.values.begin(), a.values.end()};
}

std::vector<std::string> Hdf5Reader::texts(const std::string& name) const {
    const Hdf5Handle dataset(open(name), H5Dclose);
    const Hdf5Handle stored(H5Dget_type(dataset), H5Tclose);
    if (H5Tget_class(stored) != H5T_STRING) refuse(name, "cannot be read as texts");
    if (H5Tis_variable_str(stored) > 0) refuse(name, fmt::format("has texts {}", any_length));
    const std::size_t length = H5Tget_size(stored), count = count_of(name, dataset, length + sizeof(std::string));
    const Hdf5Handle type(text_type(length, H5Tget_cset(stored)), H5Tclose);
    std::string raw(count * length, '\0');
    if (count > 0 && H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, raw.data()) < 0) refuse(name, "cannot be read as texts: damaged");
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < count; ++i) {
        texts.push_back(raw.substr(i * length, length));
        texts.back().resize(texts.back().find_last_not_of('\0') + 1);
        texts.back() = one_line(texts.back());
    }
    return texts;
}

bool Hdf5Reader::has_attribute(const std::string& object, const std::string& key) const {
    return H5Aexists_by_name(id_, object.c_str(), key.c_str(), within_file()) > 0;
}

std::string Hdf5Reader::text_attribute(const std::string& object, const std::string& key) const {
    const Hdf5Handle attribute(H5Aopen_by_name(id_, object.c_str(), key.c_str(), H5P_DEFAULT, within_file()), H5Aclose);
    const Hdf5Handle stored(attribute.failed() ? -1 : H5Aget_type(attribute), H5Tclose);
    if (H5Tis_variable_str(stored) > 0) refuse(object, fmt::format("attribute '{}' has texts {}", key, any_length));
    std::string value;
    if (attribute.failed() || !is_single(attribute) || !read_text(attribute, stored, value)) refuse(object, "attribute '" + key + "' is missing");
    return one_line(value);
}

double Hdf5Reader::number_attribute(const std::string& object, const std::string& key) const {
    const Hdf5Handle attribute(H5Aopen_by_name(id_, object.c_str(), key.c_str(), H5P_DEFAULT, within_file()), H5Aclose);
    const Hdf5Handle type(attribute.failed() ? -1 : H5Aget_type(attribute), H5Tclose);
    double value = 0;
    if (attribute.failed() || !is_single(attribute) || !is_number(type) || H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0)
        refuse(object, "attribute '" + key + "' is missing");
    return value;
}

std::vector<std::string> Hdf5Reader::children(const std::string& group) const {
    const Hdf5Handle place(H5Oopen(id_, group.c_str(), within_file()), H5Oclose);
    if (H5Iget_type(place) != H5I_GROUP) refuse(group, "is missing");
    std::vector<std::string> names;
    const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
        auto& all = *static_cast<std::vector<std::string>*>(out);
        all.emplace_back(name, ::strnlen(name, longest_name + 1));
        return all.size() > most_names || all.back().size() > longest_name ? 1 : 0;
    };
    // in native order: to sort many names libhdf5 1.10 makes a table, and where the file is damaged it frees the part
    // of the table that it has not filled
    const herr_t ended = H5Literate(place, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, collect, &names);
    if (ended < 0) refuse(group, "cannot be listed: damaged");
    if (ended > 0) refuse(group, fmt::format("has more than {} names, or one of more than {} bytes", most_names, longest_name));
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::string> Hdf5Reader::datasets() const {
    std::vector<std::string> names;
    std::set<hobj_ref_t> seen;
    const std::function<void(const std::string&, std::size_t)> walk = [&](const std::string& group, std::size_t depth) {
        if (depth > deepest_group) refuse(group, fmt::format("is nested in more than {} groups", deepest_group));
        for (const std::string& child : children(group)) {
            const std::string name = group == "/" ? "/" + child : group + "/" + child;
            const Hdf5Handle object(H5Oopen(id_, name.c_str(), within_file()), H5Oclose);
            if (H5Iget_type(object) == H5I_GROUP) {
                hobj_ref_t address = 0;
                if (H5Rcreate(&address, object, ".", H5R_OBJECT, -1) < 0 || !seen.insert(address).second) refuse(name, "is a group that also has another name");
                walk(name, depth + 1);
            } else if (names.size() == most_names)
                refuse(name, fmt::format("exceeds the limit of {} datasets", most_names));
            else
                names.push_back(name);
        }
    };
    walk("/", 0);
    return names;
}

std::vector<std::size_t> Hdf5Reader::shape(const std::string& dataset) const {
    const Hdf5Handle object(open(dataset), H5Dclose);
    return shape_of(object);
}

DatasetKind Hdf5Reader::kind(const std::string& dataset) const {
    const Hdf5Handle object(open(dataset), H5Dclose);
    const Hdf5Handle type(H5Dget_type(object), H5Tclose);
    switch (H5Tget_class(type)) {
        case H5T_FLOAT: return DatasetKind::numbers;
        case H5T_INTEGER: return DatasetKind::integers;
        case H5T_STRING: return DatasetKind::texts;
        default: refuse(dataset, "has neither numbers nor texts");
    }
}

std::vector<std::string> Hdf5Reader::describe() const {
    std::vector<std::string> lines;
    for (const std::string& name : datasets())
        lines.push_back(fmt::format("{:<40} {:<14} {:<6} {}", one_line(name), fmt::format("{}", fmt::join(shape(name), " x ")),
                                    text_attribute(name, "units"), text_attribute(name, "description")));
    return lines;
}

}  // namespace tissue
