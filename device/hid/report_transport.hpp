#pragma once

#include "device/transport.hpp"

namespace touchable {

/// Carries HID reports. One that is sent begins with its report's number, 0 where the device does not number
/// them; one that comes begins with it only where it does.
class ReportTransport : public Transport {
public:
    /// Another descriptor of the same device, for whoever speaks last; written as `send` sends. -1: none.
    virtual int spare_descriptor() const { return -1; }
};

}  // namespace touchable
