#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "haptic/device.h"
#include "haptic/device_impedance.h"
#include "haptic/device_map.h"
#include "mesh/spring_mesh.h"
#include "registry.h"

namespace tissue {

/// What a kind of device can be told, as a program offers it: --name VALUE.
struct DeviceOption {
    std::string name, unit, initial, meaning;               ///< unit: m, number, NAME, FILE; initial "": none
    bool needed = false;                                    ///< by this kind
    std::string (*wrong)(const std::string& text) = nullptr;  ///< what is wrong with a value; "" when nothing is
};

/// The session that a device is made for.
struct DeviceContext {
    double seconds = 10;                            ///< 0: no end
    unsigned long seed = 2008;                      ///< of what is drawn
    int tool = 0;                                   ///< of the session, that it moves
    const SpringMesh* rest = nullptr;               ///< the tissue; what it is for must outlive make()
    DeviceMap map;
};

/// Values of options by their names, as text.
using DeviceValues = std::map<std::string, std::string>;

/// A kind of device: its name, what it can be told, how it is made, what it is to a hand. `make` gets every option of its own, none wrong.
struct DeviceKind {
    const char* name;
    std::vector<DeviceOption> options;
    std::unique_ptr<Device> (*make)(const DeviceValues& values, const DeviceContext& context);
    DeviceImpedance impedance = {};
    double seconds = 0;     ///< of a session that is not told how long; 0: until the device ends
    bool several = true;    ///< a session may have more than one of it
    bool scripted = false;  ///< its motion is known before it begins, and no hand feels the force: it needs no clock
};

/// Every kind that a program can be asked for by name, in the order in which messages list them; the first is the
/// default. A new kind is a file of its own and a line in device_kinds.cpp. (PointerDevice is not one of them: it is made
/// by whoever aims it.)
const Registry<const DeviceKind*>& device_kinds();

/// Options that `values` leaves out have their initial value. Throws MismatchError for a name that is not known, an option
/// that is missing or wrong, and what the device throws.
std::unique_ptr<Device> make_device(const std::string& name, DeviceValues values, const DeviceContext& context);

}  // namespace tissue
