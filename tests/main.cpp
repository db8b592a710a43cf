// The library's tests: one folder a folder of lib, one title a sentence of physics. Pipeline tests are shell scripts.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>

/// libhdf5 does not give back all that it holds of a damaged file it refuses, and tests open hundreds of those; what we leak is reported.
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libhdf5\n";
}
