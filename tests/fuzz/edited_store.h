#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "io/hdf5_store.h"

namespace tissue {

/// Bytes as choices; after their end every choice is 0.
class Choices {
   public:
    Choices(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}
    bool more() const { return at_ < end_; }
    std::uint8_t byte() { return more() ? *at_++ : std::uint8_t{0}; }
    std::size_t below(std::size_t n);  ///< n > 0
    double number();                   ///< those that break things, and any other
    std::string text();

   private:
    const std::uint8_t *at_, *end_;
};

/// Where a target writes a file that it changes: in FUZZ_KEEP, if that is set, where it stays as a seed for fuzz_store.cpp.
std::string base_file(const std::string& name);

/// An HDF5 file of this project in memory, to be written again with something else in it: bytes of an HDF5 file that are changed at random
/// seldom get past HDF5, values and shapes that are changed do.
class EditedStore {
   public:
    explicit EditedStore(const std::string& file);

    /// One dataset or attribute made another: a value, a shape, a kind, a text, gone, or the content of another.
    void edit(Choices& choices);

    /// Throws FileError where HDF5 does not take it.
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
