#pragma once

#include "device/transport.hpp"

namespace touchable {

/// Carries HID reports. One that is sent begins with its report's number, 0 where the device does not number
/// them; one that comes begins with it only where it does.
class ReportTransport : public Transport {
public:
    /// Another descriptor of the same device, through which the watchdog's process sends zero force; what is
    /// written to it has the form that `send` takes. -1: none.
    virtual int spare_descriptor() const { return -1; }
};

}  // namespace touchable
