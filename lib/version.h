#pragma once

namespace tissue {

/// Of the whole project; CHANGELOG.md says what each one brought.
inline constexpr const char* version = "0.1.0";

/// Of every file format in results/FORMATS.md, but of a model.h5 whose stiffness is a law, of whatever is in space, and of cases with histories:
/// earlier programs must refuse them. Readers refuse a later one.
inline constexpr int format_version = 1;
inline constexpr int law_format_version = 2;
inline constexpr int solid_format_version = 4;  ///< of cases in space
inline constexpr int time_format_version = 5;   ///< of a model that relaxes, and of cases with histories
inline constexpr int adapted_format_version = 6;  ///< of a model that has learned from pokes
inline constexpr int embedded_format_version = 9;  ///< of a model in space; earlier ones had other contacts: refused
inline constexpr int radii_format_version = 10;   ///< of cases that discs of several radii press, and of a model that knew such
inline constexpr int rows_format_version = 11;    ///< of a model that knows such: its rows go by radius and spacing
inline constexpr int curve_format_version = 12;   ///< of a model whose springs are not Hooke's
inline constexpr int two_tools_format_version = 13;  ///< of cases that two discs press at once
inline constexpr int last_format_version = two_tools_format_version;

}  // namespace tissue
