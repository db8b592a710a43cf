#pragma once

namespace tissue {

/// Of the whole project; CHANGELOG.md says what each one brought.
inline constexpr const char* version = "0.1.0";

/// Of every file format in results/FORMATS.md. Readers refuse a later one.
inline constexpr int format_version = 1;

}  // namespace tissue
