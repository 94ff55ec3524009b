#pragma once

#include <memory>

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// The bandwidth of a copy from one buffer of the device to another, bytes read and written, GB/s: the best
/// of a few.
struct CopyBandwidth {
    double by_kernel = 0;   ///< 16 bytes a lane
    double by_command = 0;  ///< vkCmdCopyBuffer
};
/// An error of kind check where the bytes do not arrive.
Result<CopyBandwidth> copy_bandwidth(const std::shared_ptr<GpuDevice>& device);

/// How long the kernel takes that moves so many bytes, half of them read and half written. Its start is in
/// it, and what caches save.
Result<double> kernel_copy_ms(const std::shared_ptr<GpuDevice>& device, double moved_bytes);

/// Bytes that codes of a frame cannot do without: stored values in, codes, validity and bounds out.
double least_bytes(const SurfaceCase& c);

}  // namespace touchable
