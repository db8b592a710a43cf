#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "field.h"
#include "io/atomic_file.h"
#include "version.h"

namespace tissue {

/// Origin of a file: attributes of the root of every HDF5 file, besides its format.
struct Provenance {
    std::string command;                        ///< as it was typed, with absolute paths shortened to their last part
    unsigned long seed = 0;
    std::map<std::string, std::string> inputs;  ///< file name -> file_hash
};

/// An array with its shape, row-major.
struct Array {
    std::vector<std::size_t> shape;
    std::vector<double> values;
};

/// Type of a dataset's values.
enum class DatasetKind { numbers, integers, texts };

/// Writes one HDF5 file under a temporary name; commit() moves it into place. Every dataset has its units and a
/// description, and HDF5 checksums protect the content. Throws FileError when the disk refuses data.
class Hdf5Writer {
   public:
    /// kind: what the file contains ("cases", "model", ...); readers check it.
    Hdf5Writer(std::string file, const std::string& kind, const Provenance& provenance, int version_of_format = format_version);
    ~Hdf5Writer();
    Hdf5Writer(const Hdf5Writer&) = delete;
    Hdf5Writer& operator=(const Hdf5Writer&) = delete;

    /// Missing groups of the name are made. `units` is "1" for pure numbers.
    void write(const std::string& name, const Array& array, const std::string& units, const std::string& description);
    void write(const std::string& name, const Eigen::VectorXd& values, const std::string& units,
               const std::string& description);
    void write(const std::string& name, const NodeField& values, const std::string& units,
               const std::string& description);
    void write_integers(const std::string& name, const std::vector<std::size_t>& shape, const std::vector<int>& values,
                        const std::string& description);
    void write_texts(const std::string& name, const std::vector<std::string>& values, const std::string& description);

    /// Begins a dataset to which rows are appended: R, or R x columns where columns > 0. Integers when `units` is "".
    void begin_rows(const std::string& name, int columns, const std::string& units, const std::string& description);
    /// Appends whole rows, row-major. Only HDF5 buffers them.
    void append_rows(const std::string& name, const std::vector<double>& values);
    void append_rows(const std::string& name, const std::vector<int>& values);

    /// Writes an attribute of an existing group or dataset ("/" is the root).
    void attribute(const std::string& object, const std::string& key, const std::string& value);
    void attribute(const std::string& object, const std::string& key, double value);

    void commit();

   private:
    void append(const std::string& name, long long type, const void* values, std::size_t count);

    std::string file_;
    NewFile beside_;
    long long id_ = -1;
};

/// Reads one HDF5 file of this project. Throws FileError with file, dataset and cause, for a file or dataset that is
/// - missing, not HDF5, or truncated;
/// - of another kind or program, of a later format version, or of an unexpected shape;
/// - damaged, by its checksum;
/// - claiming more values than the file can hold (checked before memory is allocated);
/// - packed by another filter than gzip, or with more than 256 MiB of packed values in all;
/// - in groups more than 32 deep.
class Hdf5Reader {
   public:
    /// kind: as written; "" accepts any kind (tissuectl info).
    Hdf5Reader(std::string file, const std::string& kind);
    ~Hdf5Reader();
    Hdf5Reader(const Hdf5Reader&) = delete;
    Hdf5Reader& operator=(const Hdf5Reader&) = delete;

    const std::string& file() const { return file_; }

    /// Whether a dataset or group exists: for those that files of earlier programs lack.
    bool has(const std::string& name) const;

    Array array(const std::string& name) const;
    Eigen::VectorXd vector(const std::string& name) const;
    NodeField field(const std::string& name) const;
    std::vector<int> integers(const std::string& name) const;
    std::vector<std::string> texts(const std::string& name) const;
    bool has_attribute(const std::string& object, const std::string& key) const;
    std::string text_attribute(const std::string& object, const std::string& key) const;
    double number_attribute(const std::string& object, const std::string& key) const;

    /// Names of the members of a group, in alphabetical order.
    std::vector<std::string> children(const std::string& group) const;

    /// Full names of all datasets, in alphabetical order of groups and names.
    std::vector<std::string> datasets() const;
    std::vector<std::size_t> shape(const std::string& dataset) const;
    DatasetKind kind(const std::string& dataset) const;

    /// Every dataset as "name  shape  units  description", to be printed.
    std::vector<std::string> describe() const;

    [[noreturn]] void refuse(const std::string& place, const std::string& why) const;

   private:
    /// opens a dataset; refuses one whose name or values lead to another file
    long long open(const std::string& name) const;
    /// Number of its values, each of at most bytes_a_value in memory. Refuses a claim that the file cannot hold.
    std::size_t count_of(const std::string& name, long long dataset, std::size_t bytes_a_value) const;

    std::string file_;
    std::size_t bytes_ = 0;  ///< size of the file
    /// dataset -> bytes in memory, for packed datasets that were read
    mutable std::map<std::string, std::size_t> unpacked_;
    long long id_ = -1;
};

}  // namespace tissue
