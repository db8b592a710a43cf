#pragma once

#include <hdf5.h>

#include <algorithm>
#include <vector>

/// Common parts of reading and writing HDF5 (hdf5_store.h); included by nothing else.
namespace tissue {

/// An HDF5 handle that closes itself. A negative handle is a failed call.
class Hdf5Handle {
   public:
    Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Hdf5Handle() {
        if (id_ >= 0) close_(id_);
    }
    Hdf5Handle(const Hdf5Handle&) = delete;
    Hdf5Handle& operator=(const Hdf5Handle&) = delete;
    operator hid_t() const { return id_; }
    bool failed() const { return id_ < 0; }

   private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// Turns off HDF5's error stack, which it prints for every failed call; our messages are one line. Also turns off its
/// cleanup at exit, which would crash on closing again a file that a full disk did not let it close.
inline void silence_hdf5() {
    H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// Per dataset. A file may claim any size; files of this project are far smaller.
constexpr std::size_t most_values = std::size_t{1} << 32;

/// Product of the sides, limited to most_values + 1.
inline std::size_t product(const std::vector<std::size_t>& shape) {
    std::size_t values = 1;
    if (std::find(shape.begin(), shape.end(), std::size_t{0}) != shape.end()) return 0;
    for (const std::size_t side : shape) values = side > most_values / values ? most_values + 1 : values * side;
    return values;
}

/// Type of texts of `length` bytes, padded with zeros. HDF5 does not convert between UTF-8 and ASCII: a reader must use
/// the character set of the file.
inline hid_t text_type(std::size_t length, H5T_cset_t set = H5T_CSET_UTF8) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, std::max<std::size_t>(length, 1));
    H5Tset_cset(type, set);
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    return type;
}

inline std::vector<std::size_t> shape_of(hid_t dataset) {
    const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
    if (H5Sget_simple_extent_type(space) == H5S_NULL) return {0};
    std::vector<hsize_t> dimensions(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
    H5Sget_simple_extent_dims(space, dimensions.data(), nullptr);
    return {dimensions.begin(), dimensions.end()};
}

}  // namespace tissue
