#pragma once

#include <hdf5.h>

#include <catch2/catch.hpp>
#include <string>

namespace tissue {

/// Overwrites an attribute of an HDF5 file, as another program would have written it.
inline void set_attribute(const std::string& file, const std::string& object, const std::string& name, double value) {
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), space = H5Screate(H5S_SCALAR);
    // HDF5 cannot overwrite an attribute of an object that has many
    REQUIRE(H5Adelete_by_name(id, object.c_str(), name.c_str(), H5P_DEFAULT) >= 0);
    const hid_t attribute = H5Acreate_by_name(id, object.c_str(), name.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    REQUIRE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value) >= 0);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Fclose(id);
}

inline void set_format_version(const std::string& file, double version_number) { set_attribute(file, "/", "format_version", version_number); }

}  // namespace tissue
