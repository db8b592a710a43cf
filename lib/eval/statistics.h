#pragma once

#include <string>
#include <vector>

namespace tissue {

/// Quantiles of relative errors, and how many of those asked for they are of. One rule for every table, headline, JSON and record:
/// - a model or baseline without an answer (no equilibrium, a contact on fixed nodes, a mesh that diverged) has an infinite error. It
///   counts: a quantile that falls on it, or that is interpolated towards it, is infinite, and so is the maximum;
/// - where the reference has no answer (FE lost the draw, or has no force) no error is defined, for any model. It is in no quantile, but
///   it stays in the number that was asked for.
/// n + missing + no_reference = of(): "n of N" says all of it.
struct Statistics {
    double median, p95, max;  ///< p95 by linear interpolation; infinite as above; NaN where n + missing = 0
    int n;                    ///< errors that are known
    int missing;              ///< answers that are missing: infinity
    int no_reference;         ///< not comparable: the reference is missing

    int of() const { return n + missing + no_reference; }
};

/// sample: an infinite value is a missing answer, NaN one without a reference. no_reference: how many more of those were asked for.
Statistics statistics_of(std::vector<double> sample, int no_reference = 0);

/// "227 of 260", a cell of a table.
std::string n_of_N(const Statistics& s);
/// "18 of 18 contacts"; "227 of 260 contacts, 3 without an answer, 30 without a reference".
std::string n_of_N(const Statistics& s, const std::string& what);

/// "1.2 %" (digits after the point), or "none" where the value is not finite.
std::string percent(double value, int digits = 1);

}  // namespace tissue
