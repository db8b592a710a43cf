// Measurements: CSV as a file and as a stream, and a model that learns from them.
#include <sstream>

#include "../haptic/haptic_example.h"
#include "adapt/adaptation.h"
#include "adapt/measurements_csv.h"
#include "fuzz_file.h"

using namespace tissue;

FUZZ_TARGET(pokes)(const std::uint8_t* data, std::size_t size) {
    static const TissueModel model = energy_model_example(make_lattice("grid8", 2, 2, 0.1, 0.1));
    static Adaptation adaptation(model);
    const FuzzFile file(data, size, "pokes.csv");
    for (const int D : {2, 3})
        reads([&] {
            const std::vector<ForceMeasurement> pokes = read_measurements(file, D);
            if (D != 2) return;
            adaptation.forget();
            for (std::size_t k = 0; k < pokes.size() && k < 4; ++k) adaptation.learn(pokes[k]);
            must(adaptation.energy_model().constants.allFinite() && adaptation.energy_model().constants.minCoeff() > 0, "a constant of the energy model is not finite or not positive");
        });
    reads([&] {
        std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
        MeasurementLines lines(in, "standard input", 3);
        while (lines.next()) {}
    });
    return 0;
}
