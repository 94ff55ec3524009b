// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/base/try.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/gpu/vulkan_builder.hpp"

namespace touchable {

/// One device and its kernels for all cases of a suite, opened on first use.
class KernelShelf {
public:
    Result<std::shared_ptr<SurfaceKernels>> take() {
        if (!kernels_) {
            TRY_ASSIGN(auto device, GpuDevice::open());
            measure_builders(device);
            kernels_ = std::make_shared<SurfaceKernels>(device);
        }
        return kernels_;
    }

private:
    std::shared_ptr<SurfaceKernels> kernels_;
};

}  // namespace touchable
