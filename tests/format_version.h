#pragma once

#include <hdf5.h>

#include <catch2/catch.hpp>
#include <string>

namespace tissue {

/// Overwrites the format version of an HDF5 file, as another program would have written it.
inline void set_format_version(const std::string& file, double version_number) {
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), attribute = H5Aopen(id, "format_version", H5P_DEFAULT);
    REQUIRE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &version_number) >= 0);
    H5Aclose(attribute);
    H5Fclose(id);
}

}  // namespace tissue
