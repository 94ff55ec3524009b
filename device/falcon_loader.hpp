#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "device/device_driver.hpp"
#include "device/ftdi_transport.hpp"

namespace touchable {

/// How long it is waited for an answer, at each step.
struct FalconPatience {
    std::chrono::milliseconds greeting{60};
    std::chrono::milliseconds echo{500};
    std::chrono::milliseconds question{20};
};

/// The Falcon's firmware, of a file that the person names: its makers' licence lets nobody else pass it on.
/// Error (ErrorKind::input): no such file, or none of a size that firmware has.
Result<std::vector<std::byte>> read_falcon_firmware(const std::string& path);

/// Loads firmware into a Falcon, which has none when its power comes. About two seconds. What it sends back
/// is compared byte by byte. Error (device): at which step it did not answer, or differently. (interrupted):
/// given up.
Result<void> load_falcon_firmware(FtdiTransport& transport, std::span<const std::byte> firmware,
                                  const FalconPatience& patience, const GivenUp& given_up);

/// Sets the serial line as firmware that runs expects it.
Result<void> begin_falcon_run(FtdiTransport& transport);

}  // namespace touchable
