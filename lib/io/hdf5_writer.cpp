#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "error.h"
#include "io/hdf5_handle.h"
#include "io/hdf5_store.h"

namespace tissue {
namespace {

std::vector<hsize_t> to_hsize(const std::vector<std::size_t>& shape) {
    return {shape.begin(), shape.end()};
}

/// Writes a text of fixed length, which is stored in the object's header. Texts of variable length are in a heap
/// without a checksum.
void write_text_attribute(hid_t object, const std::string& key, const std::string& value,
                          const std::function<void(const char*)>& fail) {
    const Hdf5Handle type(text_type(value.size()), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle attribute(H5Acreate2(object, key.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (attribute.failed() || H5Awrite(attribute, type, value.c_str()) < 0) fail("cannot write an attribute");
}

/// Storage of a dataset of this shape: chunks of whole rows of the first dimension, at most 1 MiB unless one row is
/// larger, each with a checksum. HDF5 supports checksums only for chunks, and a scalar has no chunks.
hid_t checked_storage(const std::vector<std::size_t>& shape, std::size_t bytes_a_value) {
    constexpr std::size_t piece_bytes = std::size_t{1} << 20;
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_obj_track_times(creation, false);
    if (shape.empty() || product(shape) == 0) return creation;
    std::vector<hsize_t> piece = to_hsize(shape);
    const std::size_t row_bytes = product(shape) / shape[0] * bytes_a_value;
    piece[0] = std::clamp<hsize_t>(piece_bytes / row_bytes, 1, piece[0]);
    H5Pset_chunk(creation, static_cast<int>(piece.size()), piece.data());
    H5Pset_fletcher32(creation);
    return creation;
}

/// Makes missing groups of a dataset's name.
hid_t with_groups() {
    const hid_t links = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(links, 1);
    return links;
}

void write_dataset(hid_t file, const std::string& name, const std::vector<std::size_t>& shape, hid_t memory_type,
                   const void* data, const std::string& units, const std::string& description,
                   const std::function<void(const char*)>& fail) {
    const std::vector<hsize_t> dimensions = to_hsize(shape);
    const Hdf5Handle space(H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr), H5Sclose);
    const Hdf5Handle links(with_groups(), H5Pclose);
    const Hdf5Handle creation(checked_storage(shape, H5Tget_size(memory_type)), H5Pclose);
    const Hdf5Handle dataset(H5Dcreate2(file, name.c_str(), memory_type, space, links, creation, H5P_DEFAULT), H5Dclose);
    if (dataset.failed()) fail("cannot make the dataset");
    if (product(shape) > 0 && H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
        fail("cannot write the dataset");
    write_text_attribute(dataset, "units", units, fail);
    write_text_attribute(dataset, "description", description, fail);
}

}  // namespace

Hdf5Writer::Hdf5Writer(std::string file, const std::string& kind, const Provenance& provenance, int version_of_format)
    : file_(std::move(file)), beside_(file_) {
    silence_hdf5();
    const Hdf5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // headers and indices have checksums only since 1.10
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    H5Pset_file_locking(access, false, true);  // beside_ holds the lock
    // by its descriptor, so that a link that replaces its name meanwhile is not followed
    id_ = H5Fcreate(fmt::format("/proc/self/fd/{}", beside_.descriptor()).c_str(), H5F_ACC_TRUNC, creation, access);
    if (id_ < 0) throw FileError(file_ + ": cannot write: the folder is missing, full or not writable");
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
    silence_hdf5();
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
    const Hdf5Handle type(text_type(length), H5Tclose);
    write_dataset(id_, name, {values.size()}, type, texts.data(), "text", description,
                  [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, name, why)); });
}

void Hdf5Writer::begin_rows(const std::string& name, int columns, const std::string& units,
                            const std::string& description) {
    constexpr hsize_t chunk_rows = 1024;
    const int rank = columns > 0 ? 2 : 1;
    const hsize_t width = static_cast<hsize_t>(std::max(columns, 1));
    const hsize_t none[2] = {0, width}, endless[2] = {H5S_UNLIMITED, width}, chunk[2] = {chunk_rows, width};
    const Hdf5Handle space(H5Screate_simple(rank, none, endless), H5Sclose);
    const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    H5Pset_chunk(creation, rank, chunk);
    H5Pset_fletcher32(creation);
    const Hdf5Handle links(with_groups(), H5Pclose);
    const Hdf5Handle dataset(H5Dcreate2(id_, name.c_str(), units.empty() ? H5T_NATIVE_INT : H5T_NATIVE_DOUBLE, space,
                                    links, creation, H5P_DEFAULT),
                         H5Dclose);
    const auto fail = [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, name, why)); };
    if (dataset.failed()) fail("cannot make the dataset");
    write_text_attribute(dataset, "units", units.empty() ? "1" : units, fail);
    write_text_attribute(dataset, "description", description, fail);
}

void Hdf5Writer::append(const std::string& name, long long type, const void* values, std::size_t count) {
    if (count == 0) return;
    // the setting is per thread, and a recording is written by another thread than the one that opened it
    silence_hdf5();
    const auto fail = [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, name, why)); };
    const Hdf5Handle dataset(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (dataset.failed()) fail("cannot find the dataset to append to");
    std::vector<hsize_t> shape = to_hsize(shape_of(dataset)), start(shape.size(), 0), rows = shape;
    rows[0] = count / (shape.size() > 1 ? shape[1] : 1);
    start[0] = shape[0];
    shape[0] += rows[0];
    if (H5Dset_extent(dataset, shape.data()) < 0) fail("cannot append to the dataset");
    const Hdf5Handle all(H5Dget_space(dataset), H5Sclose);
    const Hdf5Handle memory(H5Screate_simple(static_cast<int>(rows.size()), rows.data(), nullptr), H5Sclose);
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
    const Hdf5Handle place(H5Oopen(id_, object.c_str(), H5P_DEFAULT), H5Oclose);
    write_text_attribute(place, key, value,
                         [&](const char* why) { throw FileError(fmt::format("{}: {}: {}", file_, object, why)); });
}

void Hdf5Writer::attribute(const std::string& object, const std::string& key, double value) {
    const Hdf5Handle place(H5Oopen(id_, object.c_str(), H5P_DEFAULT), H5Oclose), space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle attribute(H5Acreate2(place, key.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose);
    if (attribute.failed() || H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value) < 0)
        throw FileError(fmt::format("{}: {}: cannot write an attribute", file_, object));
}

void Hdf5Writer::commit() {
    silence_hdf5();
    // a full disk is reported here at the latest, when HDF5 flushes its buffers
    const bool flushed = H5Fflush(id_, H5F_SCOPE_LOCAL) >= 0;
    const bool closed = H5Fclose(id_) >= 0;
    id_ = -1;
    if (!flushed || !closed) throw FileError(file_ + ": cannot write: the disk is full or refused the data");
    beside_.move_into_place();
}

}  // namespace tissue
