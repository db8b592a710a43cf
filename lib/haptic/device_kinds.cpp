#include "haptic/device_kinds.h"

#include <fmt/format.h>

#include "error.h"
#include "haptic/force_dimension_device.h"
#include "haptic/haply_device.h"
#include "haptic/openhaptics_device.h"
#include "haptic/remote_device.h"
#include "haptic/replay_device.h"
#include "haptic/virtual_device.h"

namespace tissue {

const Registry<const DeviceKind*>& device_kinds() {
    static const Registry<const DeviceKind*> kinds("device",
                                                   {
                                                       &VirtualDevice::kind,
                                                       &ReplayDevice::kind,
                                                       &RemoteDevice::kind,
                                                       &OpenHapticsDevice::kind,
                                                       &ForceDimensionDevice::kind,
                                                       &HaplyDevice::kind,
                                                   },
                                                   [](const DeviceKind* kind) { return kind->name; });
    return kinds;
}

std::unique_ptr<Device> make_device(const std::string& name, DeviceValues values, const DeviceContext& context) {
    const DeviceKind& kind = *device_kinds().at(name);
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
