#pragma once

#include <string>
#include <vector>

namespace tissue {

/// Quantiles of relative errors over N cases. Every table, headline, JSON file and record uses the same rule:
/// - A model or baseline without an answer (no equilibrium, a contact on fixed nodes, a mesh that diverged) has an
///   infinite error, which counts. A quantile that falls on it, or is interpolated towards it, is infinite, and so is
///   the maximum.
/// - Where the reference is missing (FE has no solution, or no force), no error is defined for any model. Such a case
///   is in no quantile, but it is counted in N.
/// N = of() = n + missing + no_reference.
struct Statistics {
    double median, p95, max;  ///< p95 by linear interpolation; infinite as above; NaN where n + missing = 0
    int n;                    ///< finite errors
    int missing;              ///< infinite errors: the model has no answer
    int no_reference;         ///< cases without a reference

    int of() const { return n + missing + no_reference; }
};

/// sample: relative errors; infinity: the model has no answer; NaN: no reference. no_reference: further cases without a
/// reference that are not in the sample.
Statistics statistics_of(std::vector<double> sample, int no_reference = 0);

/// "227 of 260", for a cell of a table.
std::string n_of_N(const Statistics& s);
/// "18 of 18 contacts"; "227 of 260 contacts, 3 without an answer, 30 without a reference".
std::string n_of_N(const Statistics& s, const std::string& what);

/// 0.012 as "1.2 %", with `digits` digits after the point; "none" where the value is not finite.
std::string percent(double value, int digits = 1);

}  // namespace tissue
