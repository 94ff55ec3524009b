#pragma once

#include <memory>
#include <string>

#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// The GPU of a run: opened when it is first needed, one for all who need it, and anew where it was lost.
class RunGpu {
public:
    /// `request` as in choose_gpu.
    explicit RunGpu(std::string request) : request_(std::move(request)) {}
    Result<std::shared_ptr<GpuDevice>> open();
    /// What it calls itself; empty before it is open.
    std::string name() const { return device_ ? device_->facts().name : std::string(); }

private:
    std::string request_;
    std::shared_ptr<GpuDevice> device_;
};

}  // namespace touchable
