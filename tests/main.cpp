// The library's tests: one folder a folder of lib, one title a sentence of physics. Pipeline tests are shell scripts.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
