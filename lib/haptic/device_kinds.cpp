#include "haptic/device_kinds.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "error.h"
#include "haptic/openhaptics_device.h"
#include "haptic/remote_device.h"
#include "haptic/replay_device.h"
#include "haptic/virtual_device.h"

namespace tissue {

const std::vector<const DeviceKind*>& device_kinds() {
    static const std::vector<const DeviceKind*> kinds = {
        &VirtualDevice::kind,
        &ReplayDevice::kind,
        &RemoteDevice::kind,
        &OpenHapticsDevice::kind,
    };
    return kinds;
}

std::vector<std::string> device_names() {
    std::vector<std::string> names;
    for (const DeviceKind* kind : device_kinds()) names.push_back(kind->name);
    return names;
}

const DeviceKind& device_kind(const std::string& name) {
    for (const DeviceKind* kind : device_kinds())
        if (name == kind->name) return *kind;
    throw MismatchError(fmt::format("device '{}' is not known; allowed: {}", name, fmt::join(device_names(), ", ")));
}

std::unique_ptr<Device> make_device(const std::string& name, DeviceValues values, const DeviceContext& context) {
    const DeviceKind& kind = device_kind(name);
    for (const DeviceOption& option : kind.options) {
        const std::string& value = values.emplace(option.name, option.initial).first->second;
        if (option.needed && value.empty())
            throw MismatchError(fmt::format("device {} needs --{} {}", name, option.name, option.unit));
        const std::string wrong = option.wrong ? option.wrong(value) : "";
        if (!wrong.empty()) throw MismatchError(fmt::format("device {}: --{}: {}", name, option.name, wrong));
    }
    return kind.make(values, context);
}

}  // namespace tissue
