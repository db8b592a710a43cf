#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "io/hdf5_store.h"

namespace tissue {

/// Reads choices from bytes. After the last byte every choice is 0.
class Choices {
   public:
    Choices(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}
    bool more() const { return at_ < end_; }
    std::uint8_t byte() { return more() ? *at_++ : std::uint8_t{0}; }
    std::size_t below(std::size_t n);  ///< n > 0
    double number();                   ///< a special value (0, nan, inf, limits), a byte, or any other number
    std::string text();

   private:
    const std::uint8_t *at_, *end_;
};

/// Name of the file that a target edits: in the folder FUZZ_KEEP, if that is set, where it is kept as a seed for
/// fuzz_store.cpp.
std::string base_file(const std::string& name);

/// An HDF5 file of this project in memory, edited and written again. HDF5 refuses most files with random changes of
/// bytes. Files with changed values and shapes reach the project's readers.
class EditedStore {
   public:
    explicit EditedStore(const std::string& file);

    /// Edits one dataset or attribute: changes a value, shape, kind or text, copies the content of another, or removes
    /// it.
    void edit(Choices& choices);

    /// Throws FileError if HDF5 refuses the content.
    void write(const std::string& file) const;

   private:
    struct Dataset {
        std::string name;
        DatasetKind kind;
        Array array;
        std::vector<std::string> texts;
    };
    struct Attribute {
        std::string object, key;
        std::variant<double, std::string> value;
    };
    void read_attributes(const std::string& file);

    std::vector<Dataset> datasets_;
    std::vector<Attribute> attributes_;
    std::string kind_;
    double version_;
};

}  // namespace tissue
