// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// Bandwidth of a copy between two device buffers, counting bytes read and written, GB/s: the best of a few
/// copies.
struct CopyBandwidth {
    double by_kernel = 0;   ///< 16 bytes a lane
    double by_command = 0;  ///< vkCmdCopyBuffer
};
/// An error of kind check if the bytes do not arrive.
Result<CopyBandwidth> copy_bandwidth(const std::shared_ptr<GpuDevice>& device);

/// Time of a kernel that moves `moved_bytes`, half read and half written. Includes its start and the effect
/// of caches.
Result<double> kernel_copy_ms(const std::shared_ptr<GpuDevice>& device, double moved_bytes);

/// Least traffic for a frame's codes: stored values in; codes, validity and bounds out.
double least_bytes(const SurfaceCase& c);

}  // namespace touchable
