// Measured contacts: CSV, and the cases of study `measured` from them.
#include "cases/measured_cases.h"
#include "fuzz_file.h"

using namespace tissue;

FUZZ_TARGET(measured)(const std::uint8_t* data, std::size_t size) {
    static const Study study = read_study("fem/studies/measured.toml");
    const FuzzFile file(data, size, "measured.csv");
    reads([&] { load_cases(measured_cases(study, read_measured_csv(file))); });
    return 0;
}
