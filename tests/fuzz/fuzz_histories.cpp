// Measured histories: CSV of the tool's displacement and force over time.
#include "cases/measured_histories.h"
#include "fuzz_file.h"

using namespace tissue;

FUZZ_TARGET(histories)(const std::uint8_t* data, std::size_t size) {
    static const Study study = read_study("fem/studies/measured-relax.toml");
    const FuzzFile file(data, size, "histories.csv");
    reads([&] {
        for (const History& h : read_measured_histories(study, file)) must(h.time_s.allFinite() && h.push_m.allFinite() && h.force_N.allFinite(), "not finite");
    });
    return 0;
}
