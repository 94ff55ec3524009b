#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// The GPU of a run: opened when it is first needed, one for all who need it, and anew where it was lost.
/// Safe from any thread.
class RunGpu {
public:
    /// `request` as in choose_gpu, `window_extensions` as in GpuOptions.
    explicit RunGpu(std::string request, std::vector<std::string> window_extensions = {})
        : request_(std::move(request)), window_extensions_(std::move(window_extensions)) {}
    Result<std::shared_ptr<GpuDevice>> open();
    /// What it calls itself; empty before it is open.
    std::string name() const;

private:
    const std::string request_;
    const std::vector<std::string> window_extensions_;
    mutable std::mutex mutex_;
    std::shared_ptr<GpuDevice> device_;
};

}  // namespace touchable
