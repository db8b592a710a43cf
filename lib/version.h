#pragma once

namespace tissue {

/// Version of the whole project; CHANGELOG.md lists the changes of each.
inline constexpr const char* version = "0.1.0";

/// Version of the file formats in results/FORMATS.md. The kinds of files below have later versions, so that earlier
/// programs refuse them. Readers refuse a version later than last_format_version.
inline constexpr int format_version = 1;
inline constexpr int energy_model_format_version = 2;    ///< a model whose stiffness is an energy model
inline constexpr int solid_format_version = 4;  ///< cases in space; those of version 3 are refused
inline constexpr int time_format_version = 5;   ///< a model that relaxes; cases with displacement histories
inline constexpr int adapted_format_version = 6;  ///< a model that was adapted to measurements
inline constexpr int embedded_format_version = 9;  ///< a model in space; 7 and 8 had other contacts and are refused
inline constexpr int radii_format_version = 10;   ///< cases with discs of several radii
/// A model trained under discs of several radii: its contact stiffnesses depend on radius and lattice spacing. Version
/// 10 had them depend on the radius alone, and is refused.
inline constexpr int rows_format_version = 11;
inline constexpr int curve_format_version = 12;   ///< a model whose springs are not Hookean
inline constexpr int two_tools_format_version = 13;  ///< cases with two discs at once
inline constexpr int pulled_format_version = 14;     ///< a model whose contact hardens in compression alone
inline constexpr int last_format_version = pulled_format_version;

}  // namespace tissue
