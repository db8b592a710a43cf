#include "io/hdf5_store.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "error.h"
#include "io/atomic_file.h"
#include "version.h"

namespace tissue {
namespace {

/// An HDF5 handle that closes itself. A negative one is a failed call.
class Handle {
   public:
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Handle() {
        if (id_ >= 0) close_(id_);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    operator hid_t() const { return id_; }
    bool failed() const { return id_ < 0; }

   private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// HDF5 prints a stack of its own on every failed call; our one line says what matters. Nor may it tidy up at exit: it
/// would close again, and crash on, a file that a full disk did not let it close.
void silence() {
    H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::vector<hsize_t> to_hsize(const std::vector<std::size_t>& shape) {
    return {shape.begin(), shape.end()};
}

/// Of one dataset. A file may claim any size, but no file of ours comes near.
constexpr std::size_t most_values = std::size_t{1} << 32;

/// No filter of HDF5 packs tighter; who packed a file of ours anew may read it too.
constexpr std::size_t tightest_packing = 1100;

/// At most most_values + 1, however long the sides are.
std::size_t product(const std::vector<std::size_t>& shape) {
    std::size_t values = 1;
    if (std::find(shape.begin(), shape.end(), std::size_t{0}) != shape.end()) return 0;
    for (const std::size_t side : shape) values = side > most_values / values ? most_values + 1 : values * side;
    return values;
}

/// Texts of `length` bytes, padded with zeros; of any length where it is H5T_VARIABLE, as files before the checksums have them. HDF5 does not
/// take UTF-8 for ASCII: a reader asks for the set that is stored.
hid_t text_type(std::size_t length, H5T_cset_t set = H5T_CSET_UTF8) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, length == H5T_VARIABLE ? length : std::max<std::size_t>(length, 1));
    H5Tset_cset(type, set);
    if (length != H5T_VARIABLE) H5Tset_strpad(type, H5T_STR_NULLPAD);
    return type;
}

/// Of a file that is written or read. Headers and indices of this format have checksums, which those before 1.10 do not.
hid_t file_access() {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    return access;
}

/// A text of any length lies in a heap without checksum: ours have the length that they have, in the object's header.
void write_text_attribute(hid_t object, const std::string& key, const std::string& value,
                          const std::function<void(const char*)>& fail) {
    const Handle type(text_type(value.size()), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle attribute(H5Acreate2(object, key.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (attribute.failed() || H5Awrite(attribute, type, value.c_str()) < 0) fail("cannot write an attribute");
}

/// How a dataset of this shape is stored: in pieces of at most a mebibyte, whole rows of the first dimension, each with its checksum
/// (HDF5 has them for pieces alone).
hid_t checked_storage(const std::vector<std::size_t>& shape, std::size_t bytes_a_value) {
    constexpr std::size_t piece_bytes = std::size_t{1} << 20;
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_obj_track_times(creation, false);
    if (product(shape) == 0) return creation;
    std::vector<hsize_t> piece = to_hsize(shape);
    const std::size_t row_bytes = product(shape) / shape[0] * bytes_a_value;
    piece[0] = std::clamp<hsize_t>(piece_bytes / row_bytes, 1, piece[0]);
    H5Pset_chunk(creation, static_cast<int>(piece.size()), piece.data());
    H5Pset_fletcher32(creation);
    return creation;
}

void write_dataset(hid_t file, const std::string& name, const std::vector<std::size_t>& shape, hid_t memory_type,
                   const void* data, const std::string& units, const std::string& description,
                   const std::function<void(const char*)>& fail) {
    const std::vector<hsize_t> dimensions = to_hsize(shape);
    const Handle space(H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr), H5Sclose);
    const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    H5Pset_create_intermediate_group(links, 1);
    const Handle creation(checked_storage(shape, H5Tget_size(memory_type)), H5Pclose);
    const Handle dataset(H5Dcreate2(file, name.c_str(), memory_type, space, links, creation, H5P_DEFAULT), H5Dclose);
    if (dataset.failed()) fail("cannot make the dataset");
    if (product(shape) > 0 && H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
        fail("cannot write the dataset");
    write_text_attribute(dataset, "units", units, fail);
    write_text_attribute(dataset, "description", description, fail);
}

std::vector<std::size_t> shape_of(hid_t dataset) {
    const Handle space(H5Dget_space(dataset), H5Sclose);
    if (H5Sget_simple_extent_type(space) == H5S_NULL) return {0};
    std::vector<hsize_t> dimensions(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
    H5Sget_simple_extent_dims(space, dimensions.data(), nullptr);
    return {dimensions.begin(), dimensions.end()};
}

/// Integers or floating point of a size that HDF5 reads as it stands: of a larger one it makes a buffer of that size a value.
bool is_number(hid_t type) {
    const H5T_class_t kind = H5Tget_class(type);
    return (kind == H5T_FLOAT || kind == H5T_INTEGER) && H5Tget_size(type) <= sizeof(double);
}

/// One value, not many: reading many into one would write past it.
bool is_single(hid_t attribute) {
    const Handle space(H5Aget_space(attribute), H5Sclose);
    return H5Sget_simple_extent_npoints(space) == 1;
}

bool read_text(hid_t attribute, std::string& value) {
    const Handle stored(H5Aget_type(attribute), H5Tclose);
    constexpr std::size_t longest = std::size_t{1} << 20;
    if (H5Tget_class(stored) != H5T_STRING || H5Tget_size(stored) > longest) return false;
    if (H5Tis_variable_str(stored) > 0) {
        const Handle type(text_type(H5T_VARIABLE, H5Tget_cset(stored)), H5Tclose);
        char* text = nullptr;
        if (H5Aread(attribute, type, &text) < 0 || !text) return false;
        value = text;
        H5free_memory(text);
        return true;
    }
    value.assign(H5Tget_size(stored), '\0');
    const Handle type(text_type(value.size(), H5Tget_cset(stored)), H5Tclose);
    if (H5Aread(attribute, type, value.data()) < 0) return false;
    value.resize(value.find_last_not_of('\0') + 1);
    return true;
}

}  // namespace

// ---- writing

Hdf5Writer::Hdf5Writer(std::string file, const std::string& kind, const Provenance& provenance, int version_of_format)
    : file_(std::move(file)), beside_(file_) {
    silence();
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    const Handle access(file_access(), H5Pclose);
    H5Pset_file_locking(access, false, true);  // beside_ has the lock
    id_ = H5Fcreate(beside_.temporary().c_str(), H5F_ACC_TRUNC, creation, access);
    if (id_ < 0) throw FileError(file_ + ": cannot write: the folder is missing, full or may not be written to");
    attribute("/", "program", "tissuectl");
    attribute("/", "kind", kind);
    attribute("/", "format_version", version_of_format);
    attribute("/", "version", version);
    attribute("/", "command", provenance.command);
    attribute("/", "seed", static_cast<double>(provenance.seed));
    for (const auto& [input, hash] : provenance.inputs) attribute("/", "input:" + input, hash);
}

Hdf5Writer::~Hdf5Writer() {
    if (id_ < 0) return;
    H5Fclose(id_);
}

void Hdf5Writer::write(const std::string& name, const Array& array, const std::string& units,
                       const std::string& description) {
    write_dataset(id_, name, array.shape, H5T_NATIVE_DOUBLE, array.values.data(), units, description,
                  [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, name, why)); });
}

void Hdf5Writer::write(const std::string& name, const Eigen::VectorXd& values, const std::string& units,
                       const std::string& description) {
    write(name, Array{{static_cast<std::size_t>(values.size())}, {values.begin(), values.end()}}, units, description);
}

void Hdf5Writer::write(const std::string& name, const NodeField& values, const std::string& units,
                       const std::string& description) {
    write(name,
          Array{{static_cast<std::size_t>(values.rows()), static_cast<std::size_t>(values.cols())},
                {values.data(), values.data() + values.size()}},
          units, description);
}

void Hdf5Writer::write_integers(const std::string& name, const std::vector<std::size_t>& shape,
                                const std::vector<int>& values, const std::string& description) {
    write_dataset(id_, name, shape, H5T_NATIVE_INT, values.data(), "1", description,
                  [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, name, why)); });
}

void Hdf5Writer::write_texts(const std::string& name, const std::vector<std::string>& values,
                             const std::string& description) {
    std::size_t length = 1;
    for (const std::string& value : values) length = std::max(length, value.size());
    std::string texts(values.size() * length, '\0');
    for (std::size_t i = 0; i < values.size(); ++i) values[i].copy(texts.data() + i * length, length);
    const Handle type(text_type(length), H5Tclose);
    write_dataset(id_, name, {values.size()}, type, texts.data(), "text", description,
                  [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, name, why)); });
}

void Hdf5Writer::begin_rows(const std::string& name, int columns, const std::string& units,
                            const std::string& description) {
    constexpr hsize_t chunk_rows = 1024;
    const int rank = columns > 0 ? 2 : 1;
    const hsize_t width = static_cast<hsize_t>(std::max(columns, 1));
    const hsize_t none[2] = {0, width}, endless[2] = {H5S_UNLIMITED, width}, chunk[2] = {chunk_rows, width};
    const Handle space(H5Screate_simple(rank, none, endless), H5Sclose);
    const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    H5Pset_chunk(creation, rank, chunk);
    H5Pset_fletcher32(creation);
    const Handle dataset(H5Dcreate2(id_, name.c_str(), units.empty() ? H5T_NATIVE_INT : H5T_NATIVE_DOUBLE, space,
                                    H5P_DEFAULT, creation, H5P_DEFAULT),
                         H5Dclose);
    const auto fail = [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, name, why)); };
    if (dataset.failed()) fail("cannot make the dataset");
    write_text_attribute(dataset, "units", units.empty() ? "1" : units, fail);
    write_text_attribute(dataset, "description", description, fail);
}

void Hdf5Writer::append(const std::string& name, long long type, const void* values, std::size_t count) {
    if (count == 0) return;
    const auto fail = [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, name, why)); };
    const Handle dataset(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (dataset.failed()) fail("cannot find the dataset to append to");
    std::vector<hsize_t> shape = to_hsize(shape_of(dataset)), start(shape.size(), 0), rows = shape;
    rows[0] = count / (shape.size() > 1 ? shape[1] : 1);
    start[0] = shape[0];
    shape[0] += rows[0];
    if (H5Dset_extent(dataset, shape.data()) < 0) fail("cannot append to the dataset");
    const Handle all(H5Dget_space(dataset), H5Sclose);
    const Handle memory(H5Screate_simple(static_cast<int>(rows.size()), rows.data(), nullptr), H5Sclose);
    H5Sselect_hyperslab(all, H5S_SELECT_SET, start.data(), nullptr, rows.data(), nullptr);
    if (H5Dwrite(dataset, type, memory, all, H5P_DEFAULT, values) < 0) fail("cannot append to the dataset");
}

void Hdf5Writer::append_rows(const std::string& name, const std::vector<double>& values) {
    append(name, H5T_NATIVE_DOUBLE, values.data(), values.size());
}

void Hdf5Writer::append_rows(const std::string& name, const std::vector<int>& values) {
    append(name, H5T_NATIVE_INT, values.data(), values.size());
}

void Hdf5Writer::attribute(const std::string& object, const std::string& key, const std::string& value) {
    const Handle place(H5Oopen(id_, object.c_str(), H5P_DEFAULT), H5Oclose);
    write_text_attribute(place, key, value,
                         [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, object, why)); });
}

void Hdf5Writer::attribute(const std::string& object, const std::string& key, double value) {
    const Handle place(H5Oopen(id_, object.c_str(), H5P_DEFAULT), H5Oclose), space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle attribute(H5Acreate2(place, key.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose);
    if (attribute.failed() || H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value) < 0)
        throw FileError(fmt::format("{}: {}: cannot write an attribute", file_, object));
}

void Hdf5Writer::commit() {
    // a full disk shows itself here at the latest, when HDF5 flushes what it held back
    const bool flushed = H5Fflush(id_, H5F_SCOPE_LOCAL) >= 0;
    const bool closed = H5Fclose(id_) >= 0;
    id_ = -1;
    if (!flushed || !closed) throw FileError(file_ + ": cannot write: the disk is full or refused the data");
    beside_.move_into_place();
}

// ---- reading

Hdf5Reader::Hdf5Reader(std::string file, const std::string& kind) : file_(std::move(file)) {
    silence();
    std::error_code error;
    if (!std::filesystem::is_regular_file(file_, error)) throw FileError(file_ + ": there is no such file");
    bytes_ = std::filesystem::file_size(file_, error);
    id_ = H5Fopen(file_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (id_ < 0) throw FileError(file_ + ": is not an HDF5 file, or is truncated");
    try {
        if (H5Aexists(id_, "program") <= 0 || text_attribute("/", "program") != "tissuectl")
            refuse("/", "was not written by tissuectl");
        const double file_version = number_attribute("/", "format_version");
        if (file_version > adapted_format_version)
            refuse("/", fmt::format("format version {} is later than this program's {}", file_version, adapted_format_version));
        if (file_version > law_format_version && file_version < solid_format_version)
            refuse("/", fmt::format("format version {} was of solids under discs with another energy; make it anew", file_version));
        const std::string file_kind = text_attribute("/", "kind");
        if (!kind.empty() && file_kind != kind)
            refuse("/", fmt::format("holds '{}', wanted '{}'", file_kind, kind));
    } catch (...) {
        H5Fclose(id_);
        throw;
    }
}

Hdf5Reader::~Hdf5Reader() {
    H5Fclose(id_);
}

void Hdf5Reader::refuse(const std::string& place, const std::string& why) const {
    throw FileError(fmt::format("{}: {}: {}", file_, place, why));
}

bool Hdf5Reader::has(const std::string& name) const {
    return H5Oexists_by_name(id_, name.c_str(), H5P_DEFAULT) > 0;
}

std::size_t Hdf5Reader::count_of(const std::string& name, long long dataset) const {
    const Handle type(H5Dget_type(dataset), H5Tclose);
    const std::size_t count = product(shape_of(dataset));
    if (count > most_values || count * H5Tget_size(type) > bytes_ * tightest_packing) refuse(name, "claims more values than the file can hold");
    return count;
}

Array Hdf5Reader::array(const std::string& name) const {
    const Handle dataset(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (dataset.failed()) refuse(name, "is missing");
    const Handle type(H5Dget_type(dataset), H5Tclose);
    if (!is_number(type)) refuse(name, "cannot be read as numbers");
    Array array;
    array.shape = shape_of(dataset);
    array.values.resize(count_of(name, dataset));
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
            refuse(name, fmt::format("holds {}, which is not a whole number", value));
    return {a.values.begin(), a.values.end()};
}

std::vector<std::string> Hdf5Reader::texts(const std::string& name) const {
    const Handle dataset(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (dataset.failed()) refuse(name, "is missing");
    const Handle stored(H5Dget_type(dataset), H5Tclose);
    if (H5Tget_class(stored) != H5T_STRING) refuse(name, "cannot be read as texts");
    const bool any_length = H5Tis_variable_str(stored) > 0;
    const std::size_t length = any_length ? H5T_VARIABLE : H5Tget_size(stored);
    const std::size_t count = count_of(name, dataset);
    const Handle type(text_type(length, H5Tget_cset(stored)), H5Tclose);
    const auto read = [&](void* values) {
        if (count > 0 && H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) refuse(name, "cannot be read as texts: damaged");
    };
    std::vector<std::string> texts;
    if (any_length) {
        std::vector<char*> raw(count, nullptr);
        read(raw.data());
        for (char* text : raw) {
            texts.emplace_back(text ? text : "");
            H5free_memory(text);
        }
    } else {
        std::string raw(count * length, '\0');
        read(raw.data());
        for (std::size_t i = 0; i < count; ++i) {
            texts.push_back(raw.substr(i * length, length));
            texts.back().resize(texts.back().find_last_not_of('\0') + 1);
        }
    }
    return texts;
}

bool Hdf5Reader::has_attribute(const std::string& object, const std::string& key) const {
    return H5Aexists_by_name(id_, object.c_str(), key.c_str(), H5P_DEFAULT) > 0;
}

std::string Hdf5Reader::text_attribute(const std::string& object, const std::string& key) const {
    const Handle attribute(H5Aopen_by_name(id_, object.c_str(), key.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    std::string value;
    if (attribute.failed() || !is_single(attribute) || !read_text(attribute, value)) refuse(object, "attribute '" + key + "' is missing");
    return value;
}

double Hdf5Reader::number_attribute(const std::string& object, const std::string& key) const {
    const Handle attribute(H5Aopen_by_name(id_, object.c_str(), key.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    const Handle type(attribute.failed() ? -1 : H5Aget_type(attribute), H5Tclose);
    double value = 0;
    if (attribute.failed() || !is_single(attribute) || !is_number(type) || H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0)
        refuse(object, "attribute '" + key + "' is missing");
    return value;
}

std::vector<std::string> Hdf5Reader::children(const std::string& group) const {
    const Handle place(H5Gopen2(id_, group.c_str(), H5P_DEFAULT), H5Gclose);
    if (place.failed()) refuse(group, "is missing");
    std::vector<std::string> names;
    const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->emplace_back(name);
        return 0;
    };
    H5Literate(place, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names);
    return names;
}

std::vector<std::string> Hdf5Reader::datasets() const {
    std::vector<std::string> names;
    const std::function<void(const std::string&)> walk = [&](const std::string& group) {
        for (const std::string& child : children(group)) {
            const std::string name = group == "/" ? "/" + child : group + "/" + child;
            const Handle object(H5Oopen(id_, name.c_str(), H5P_DEFAULT), H5Oclose);
            if (H5Iget_type(object) == H5I_GROUP)
                walk(name);
            else
                names.push_back(name);
        }
    };
    walk("/");
    return names;
}

std::vector<std::size_t> Hdf5Reader::shape(const std::string& dataset) const {
    const Handle object(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
    if (object.failed()) refuse(dataset, "is missing");
    return shape_of(object);
}

DatasetKind Hdf5Reader::kind(const std::string& dataset) const {
    const Handle object(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
    if (object.failed()) refuse(dataset, "is missing");
    const Handle type(H5Dget_type(object), H5Tclose);
    switch (H5Tget_class(type)) {
        case H5T_FLOAT: return DatasetKind::numbers;
        case H5T_INTEGER: return DatasetKind::integers;
        case H5T_STRING: return DatasetKind::texts;
        default: refuse(dataset, "holds neither numbers nor texts");
    }
}

std::vector<std::string> Hdf5Reader::describe() const {
    std::vector<std::string> lines;
    for (const std::string& name : datasets())
        lines.push_back(fmt::format("{:<40} {:<14} {:<6} {}", name, fmt::format("{}", fmt::join(shape(name), " x ")),
                                    text_attribute(name, "units"), text_attribute(name, "description")));
    return lines;
}

}  // namespace tissue
