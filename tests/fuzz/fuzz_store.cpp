// Arbitrary bytes as an HDF5 file, read as model, cases and recording.
#include "adapt/adapted_model.h"
#include "cases/load_path.h"
#include "fuzz_file.h"
#include "haptic/replay_device.h"

using namespace tissue;

FUZZ_TARGET(store)(const std::uint8_t* data, std::size_t size) {
    const FuzzFile file(data, size, "store.h5");
    reads([&] { Hdf5Reader(file, "").describe(); });
    reads([&] { read_model(file); });
    reads([&] { learned_field(file); });
    reads([&] { read_cases(file); });
    reads([&] { ReplayDevice device(file); });
    return 0;
}
