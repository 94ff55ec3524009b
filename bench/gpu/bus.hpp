#pragma once

#include <memory>

#include "bench/suite.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// Measures the bandwidth of the device's memory (bandwidth.hpp) and the time of an empty submission.
Result<void> measure_device_memory(const std::shared_ptr<GpuDevice>& device, Figures& figures);

/// Between the host and the device: a frame of 3840x2160 and 16 bits from each kind of host memory, and back.
/// An error of kind check where it does not come back as it was.
Result<void> measure_bus(const std::shared_ptr<GpuDevice>& device, Figures& figures);

}  // namespace touchable
