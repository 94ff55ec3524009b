#pragma once

#include <memory>

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// What a copy between two buffers of the device moves, read and written, GB/s: the most of a few.
Result<double> copy_bandwidth(const std::shared_ptr<GpuDevice>& device);

/// Bytes that codes of a frame cannot do without: stored values in, codes, validity and bounds out.
double least_bytes(const SurfaceCase& c);

}  // namespace touchable
