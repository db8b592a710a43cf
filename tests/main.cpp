// Tests of the library. A folder of tests belongs to a folder of lib; a test's name is a sentence of physics or
// behaviour. Pipeline tests are shell scripts.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
