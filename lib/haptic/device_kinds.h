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

/// An option of a kind of device, which programs offer as --name VALUE.
struct DeviceOption {
    std::string name, unit, initial, meaning;               ///< unit: m, number, NAME, FILE; initial "": no default
    bool needed = false;                                    ///< this kind requires a value
    /// Checks a value: returns the error as text, "" for a valid value. Null: every value is valid.
    std::string (*wrong)(const std::string& text) = nullptr;
};

/// The session that a device is made for.
struct DeviceContext {
    double seconds = 10;                            ///< length of the session [s]; 0: no end
    unsigned long seed = 2008;                      ///< of random motions
    int tool = 0;                                   ///< index of the session's tool that the device moves
    const SpringMesh* rest = nullptr;               ///< mesh of the tissue at rest; it must outlive make()
    DeviceMap map;
    bool realtime = true;                           ///< a device may request SCHED_FIFO for a thread of its own
};

/// Values of options by their names, as text.
using DeviceValues = std::map<std::string, std::string>;

/// A kind of device: its name, its options, the function that makes one, and its impedance. `make` gets a valid value
/// of every option of this kind.
struct DeviceKind {
    const char* name;
    std::vector<DeviceOption> options;
    std::unique_ptr<Device> (*make)(const DeviceValues& values, const DeviceContext& context);
    DeviceImpedance impedance = {};
    double seconds = 0;     ///< default length of a session [s]; 0: until the device ends
    bool several = true;    ///< a session may have more than one device of this kind
    bool scripted = false;  ///< the motion is fixed in advance and no hand gets the force: ticks need no clock
};

/// All kinds of device that programs select by name, in the order of messages. The first is the default. A new kind
/// needs a file of its own and a line in device_kinds.cpp. PointerDevice is not in the list: the code that aims it
/// makes it.
const Registry<const DeviceKind*>& device_kinds();

/// Makes a device of the kind `name`. Options that `values` leaves out have their initial value. Throws MismatchError
/// for an unknown kind and for an option that is missing or wrong, and whatever the kind's `make` throws.
std::unique_ptr<Device> make_device(const std::string& name, DeviceValues values, const DeviceContext& context);

}  // namespace tissue
