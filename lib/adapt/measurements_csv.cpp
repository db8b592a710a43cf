#include "adapt/measurements_csv.h"

#include <fmt/format.h>

#include "error.h"

namespace tissue {
namespace {

std::vector<CsvColumn> columns_of(int D) {
    std::vector<CsvColumn> known;
    for (const char* what : {"contact", "displacement", "force"})
        for (int d = 0; d < D; ++d) known.push_back({fmt::format("{}_{}", what, "xyz"[d]), what[0] == 'f' ? &force_units() : &length_units(), true});
    for (const char* text : {"push", "repeat", "role"}) known.push_back({text, nullptr, false});
    return known;
}

}  // namespace

std::optional<MeasurementLines::Row> MeasurementLines::next() {
    for (;;) try {
            if (!lines_.next()) return std::nullopt;
            if (lines_.is_comment()) continue;
            if (columns_.empty()) {
                columns_ = CsvColumns(lines_, columns_of(D_));
                continue;
            }
            columns_.check(lines_);
            const auto vector = [&](const std::string& what) {
                Point p(D_);
                for (int d = 0; d < D_; ++d) p[d] = columns_.number(lines_, fmt::format("{}_{}", what, "xyz"[d]));
                return p;
            };
            return Row{lines_.number(), {vector("contact"), vector("displacement"), vector("force")}, ""};
        } catch (const FileError& e) {
            // without a header, or in an overlong line, no further row can be read
            if (columns_.empty() || lines_.text().size() > CsvLines::longest_line) throw;
            return Row{lines_.number(), {}, e.what()};
        }
}

std::vector<ForceMeasurement> read_measurements(const std::string& file, int D) {
    MeasurementLines lines(file, D);
    std::vector<ForceMeasurement> pokes;
    while (const auto row = lines.next()) {
        if (!row->fault.empty()) throw FileError(row->fault);
        pokes.push_back(row->poke);
    }
    if (pokes.empty()) throw FileError(fmt::format("{}: has no rows", file));
    return pokes;
}

}  // namespace tissue
