#include "journal.h"

#include <fmt/format.h>

#include "error.h"

namespace tissue::cli {

Journal::Journal(const std::string& file, int dimension) : file_(file) {
    if (file.empty()) return;
    out_.open(file, std::ios::trunc);
    for (const char* what : {"contact", "displacement", "force"})
        for (int d = 0; d < dimension; ++d) out_ << fmt::format("{}{}_{} [{}]", d == 0 && what[0] == 'c' ? "" : ",", what, "xyz"[d], what[0] == 'f' ? "N" : "m");
    out_ << std::endl;
    if (!out_) throw FileError(file + ": cannot be written");
}

void Journal::add(const Learner::Line& line) {
    if (!out_.is_open()) return;
    std::string row;
    for (const Point& p : {line.poke.contact_m, line.poke.push_m, line.poke.force_N})
        for (double v : p) row += fmt::format("{}{}", row.empty() ? "" : ",", v);  // reads back to the same bits
    out_ << row << std::endl;
}

void Journal::close() {
    if (!out_.is_open()) return;
    out_.close();
    if (!out_) throw FileError(file_ + ": could not be written to its end: readings are missing from it");
}

}  // namespace tissue::cli
