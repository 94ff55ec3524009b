#include "player/session/run_gpu.hpp"

namespace touchable {

Result<std::shared_ptr<GpuDevice>> RunGpu::open() {
    const std::lock_guard lock(mutex_);
    if (device_ && !device_->lost()) return device_;
    auto opened = GpuDevice::open({.request = request_, .window_extensions = window_extensions_});
    if (opened.ok()) device_ = *opened;
    return opened;
}

std::string RunGpu::name() const {
    const std::lock_guard lock(mutex_);
    return device_ ? device_->facts().name : std::string();
}

}  // namespace touchable
