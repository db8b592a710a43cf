#pragma once

#include <dlfcn.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "../example.h"

namespace tissue {

/// A stand-in for a vendor's library, compiled here from stand_in/NAME.cpp and loaded. A device that loads `library`
/// uses the same copy, so a test can change it by functions that it finds.
class StandIn {
   public:
    explicit StandIn(const std::string& name) : library(folder.file(name + ".so")) {
        const std::string source = (std::filesystem::path(__FILE__).parent_path() / "stand_in" / (name + ".cpp")).string();
        REQUIRE(std::system(("c++ -std=c++17 -O1 -shared -fPIC -pthread -o " + library + " " + source).c_str()) == 0);
        handle_ = dlopen(library.c_str(), RTLD_NOW);
        REQUIRE(handle_);
    }
    ~StandIn() { dlclose(handle_); }
    StandIn(const StandIn&) = delete;
    StandIn& operator=(const StandIn&) = delete;

    const TemporaryFolder folder;
    const std::string library;

   protected:
    template <class Function>
    void find(const char* name, Function& function) {
        function = reinterpret_cast<Function>(dlsym(handle_, name));
        REQUIRE(function);
    }

   private:
    void* handle_ = nullptr;
};

}  // namespace tissue
