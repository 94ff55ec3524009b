#include "player/session/live_port.hpp"

#include "engine/base/try.hpp"
#include "player/run/device_port.hpp"
#include "player/session/held_port.hpp"

namespace touchable {

namespace {

HapticDevice* device_of(const TouchSetup& setup) {
    return setup.held_device ? setup.held_device.get() : setup.device.get();
}

}  // namespace

Result<std::unique_ptr<HapticPort>> open_port(TouchSetup& setup) {
    if (HapticDevice* device = device_of(setup)) TRY(device->open());
    std::unique_ptr<HapticPort> port;
    if (setup.control)
        port = std::make_unique<HeldPort>(*setup.held_device, *setup.control, setup.device_log.get());
    else if (setup.held_device)
        port = std::make_unique<DevicePort>(*setup.held_device, setup.workspace);
    else if (setup.device)
        port = std::make_unique<SimulatedPort>(*setup.hand, *setup.device, setup.workspace);
    else
        port = std::make_unique<HandPort>(*setup.hand);
    return port;
}

void explain_failure(const TouchSetup& setup, LiveFacts& facts) {
    const HapticDevice* device = device_of(setup);
    if (!facts.loop.port_failed || !device) return;
    if (auto healthy = device->health(); !healthy.ok()) facts.failure = healthy.error();
}

}  // namespace touchable
