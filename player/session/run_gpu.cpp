#include "player/session/run_gpu.hpp"

namespace touchable {

Result<std::shared_ptr<GpuDevice>> RunGpu::open() {
    if (device_ && !device_->lost()) return device_;
    auto opened = GpuDevice::open({.request = request_});
    if (opened.ok()) device_ = *opened;
    return opened;
}

}  // namespace touchable
