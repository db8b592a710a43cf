#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "field.h"
#include "io/atomic_file.h"
#include "version.h"

namespace tissue {

/// Where a file comes from: what every HDF5 file's root says beside its format.
struct Provenance {
    std::string command;                        ///< as it was typed, absolute paths shortened to their last part
    unsigned long seed = 0;
    std::map<std::string, std::string> inputs;  ///< file name -> file_hash
};

/// An array with its shape, row-major.
struct Array {
    std::vector<std::size_t> shape;
    std::vector<double> values;
};

/// What the values of a dataset are.
enum class DatasetKind { numbers, integers, texts };

/// Writes one HDF5 file beside its place; it appears there, whole, at commit(). Every dataset says its units and what
/// it is, and all that is written has a checksum of HDF5's. Throws FileError for whatever the disk refuses.
class Hdf5Writer {
   public:
    /// kind: what the file is ("cases", "model", ...), which readers check.
    Hdf5Writer(std::string file, const std::string& kind, const Provenance& provenance, int version_of_format = format_version);
    ~Hdf5Writer();
    Hdf5Writer(const Hdf5Writer&) = delete;
    Hdf5Writer& operator=(const Hdf5Writer&) = delete;

    /// Groups on the way are made. `units` is "1" for pure numbers.
    void write(const std::string& name, const Array& array, const std::string& units, const std::string& description);
    void write(const std::string& name, const Eigen::VectorXd& values, const std::string& units,
               const std::string& description);
    void write(const std::string& name, const NodeField& values, const std::string& units,
               const std::string& description);
    void write_integers(const std::string& name, const std::vector<std::size_t>& shape, const std::vector<int>& values,
                        const std::string& description);
    void write_texts(const std::string& name, const std::vector<std::string>& values, const std::string& description);

    /// Begins a dataset that grows by rows as they come: R, or R x columns where columns > 0. Integers when `units` is "".
    void begin_rows(const std::string& name, int columns, const std::string& units, const std::string& description);
    /// Whole rows, row-major, to the end of such a dataset. Nothing is held back here but what HDF5 buffers.
    void append_rows(const std::string& name, const std::vector<double>& values);
    void append_rows(const std::string& name, const std::vector<int>& values);

    /// Attribute of a group or dataset that exists ("/" is the root).
    void attribute(const std::string& object, const std::string& key, const std::string& value);
    void attribute(const std::string& object, const std::string& key, double value);

    void commit();

   private:
    void append(const std::string& name, long long type, const void* values, std::size_t count);

    std::string file_;
    NewFile beside_;
    long long id_ = -1;
};

/// Reads one HDF5 file of this project. Throws FileError that names file, dataset and cause: missing, not HDF5 or
/// truncated, of another kind or program, of a later format version, of an unexpected shape; a checksum that does not fit; more values than
/// the file holds, before memory is asked for; another packing than gzip, or more than 256 MiB of packed values in all; groups more than 32 deep.
class Hdf5Reader {
   public:
    /// kind: as written; "" takes any (tissuectl info).
    Hdf5Reader(std::string file, const std::string& kind);
    ~Hdf5Reader();
    Hdf5Reader(const Hdf5Reader&) = delete;
    Hdf5Reader& operator=(const Hdf5Reader&) = delete;

    const std::string& file() const { return file_; }

    /// Whether there is such a dataset or group: for what files of earlier programs do not have.
    bool has(const std::string& name) const;

    Array array(const std::string& name) const;
    Eigen::VectorXd vector(const std::string& name) const;
    NodeField field(const std::string& name) const;
    std::vector<int> integers(const std::string& name) const;
    std::vector<std::string> texts(const std::string& name) const;
    bool has_attribute(const std::string& object, const std::string& key) const;
    std::string text_attribute(const std::string& object, const std::string& key) const;
    double number_attribute(const std::string& object, const std::string& key) const;

    /// Names of what a group holds, in alphabetical order.
    std::vector<std::string> children(const std::string& group) const;

    /// Full names of all datasets, in alphabetical order of their groups and theirs.
    std::vector<std::string> datasets() const;
    std::vector<std::size_t> shape(const std::string& dataset) const;
    DatasetKind kind(const std::string& dataset) const;

    /// Every dataset as "name  shape  units  description", for people.
    std::vector<std::string> describe() const;

    [[noreturn]] void refuse(const std::string& place, const std::string& why) const;

   private:
    long long open(const std::string& name) const;  ///< a dataset whose name and values lead to no other file
    /// Of its values, each of bytes_a_value in memory at most.
    std::size_t count_of(const std::string& name, long long dataset, std::size_t bytes_a_value) const;

    std::string file_;
    std::size_t bytes_ = 0;  ///< of the file
    mutable std::map<std::string, std::size_t> unpacked_;  ///< bytes in memory, of the packed datasets that were read
    long long id_ = -1;
};

}  // namespace tissue
