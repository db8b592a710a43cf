#include <catch2/catch.hpp>
#include <set>

#include "../refusal.h"
#include "error.h"
#include "haptic/device_error.h"
#include "haptic/device_kinds.h"
#include "haptic/virtual_device.h"

using namespace tissue;

TEST_CASE("every kind of device has a unique name and unique options with valid initial values", "[device]") {
    std::set<std::string> names, options;
    for (const DeviceKind* kind : device_kinds().kinds()) {
        CHECK(names.insert(kind->name).second);
        CHECK(device_kinds().at(kind->name) == kind);
        for (const DeviceOption& option : kind->options) {
            INFO(kind->name << " --" << option.name);
            CHECK(options.insert(option.name).second);
            CHECK_FALSE(option.meaning.empty());
            if (option.wrong) CHECK(option.wrong(option.initial).empty());
            if (option.wrong) CHECK_FALSE(option.wrong("nonsense").empty());
        }
    }
    CHECK(device_kinds().names() == std::vector<std::string>{"virtual", "replay", "remote", "openhaptics", "force-dimension", "haply"});
}

TEST_CASE("a device is made from its name with initial values for options that are not given", "[device]") {
    const SpringMesh block = make_lattice("grid8", 10, 10, 0.1, 0.1);
    DeviceContext context;
    context.rest = &block;
    const auto device = make_device("virtual", {}, context), again = make_device("virtual", {{"motion", "press"}, {"depth", "0.01"}}, context);
    CHECK(device->name() == "virtual");
    for (double t : {0.0, 0.3, 0.9, 2.0}) CHECK(device->read(t).position_m == again->read(t).position_m);
    CHECK(make_device("remote", {{"port", "0"}}, context)->name() == "remote");
    CHECK(make_device("haply", {{"haply-url", "ws://[::1]:99/"}, {"haply-events-port", "0"}}, context)->name() == "haply");
    CHECK(refusal<MismatchError>([&] { make_device("mouse", {}, context); }).find("virtual, replay, remote, openhaptics, force-dimension, haply") != std::string::npos);
    CHECK(refusal<MismatchError>([&] { make_device("replay", {}, context); }).find("--trajectory FILE") != std::string::npos);
    CHECK(refusal<MismatchError>([&] { make_device("virtual", {{"motion", "stab"}}, context); }).find("press, slide, poke, probe, sine") != std::string::npos);
    for (const char* depth : {"", "0", "-1", "nan", "inf", "1 mm"}) refusal<MismatchError>([&] { make_device("virtual", {{"depth", depth}}, context); });
    for (const char* id : {"", "-1", "32", "first"}) refusal<MismatchError>([&] { make_device("force-dimension", {{"device-id", id}}, context); });
    for (const char* home : {"", "1", "YES"}) refusal<MismatchError>([&] { make_device("force-dimension", {{"home", home}}, context); });
    CHECK(refusal<DeviceError>([&] { make_device("force-dimension", {{"drd-library", "libdrd_none.so"}, {"home", "yes"}}, context); }).find("libdrd_none.so") != std::string::npos);
    for (const char* port : {"", "-1", "65536", "http"}) refusal<MismatchError>([&] { make_device("remote", {{"port", port}}, context); });
    for (const char* url : {"", "localhost:10001", "http://localhost:10001", "ws://", "ws://192.168.1.2:10001", "ws://0.0.0.0", "ws://localhost.example.org", "ws://localhost:0", "ws://localhost:65536",
                            "ws://localhost:", "ws://localhost:1x", "ws://127.0.0.1@example.org", "ws://127.0.0.12", "ws://[::1", "ws://localhost/path"})
        CHECK(refusal<MismatchError>([&] { make_device("haply", {{"haply-url", url}}, context); }).find("localhost, 127.0.0.1 or [::1]") != std::string::npos);
    for (const char* port : {"", "-1", "65536", "http"}) refusal<MismatchError>([&] { make_device("haply", {{"haply-events-port", port}}, context); });
    for (const char* id : {"04 9D", "\"", "049D\n", "\xff"}) {
        refusal<MismatchError>([&] { make_device("haply", {{"haply-device-id", id}}, context); });
        refusal<MismatchError>([&] { make_device("haply", {{"haply-grip-id", id}}, context); });
    }
}
