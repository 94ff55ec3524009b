#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/gpu/gpu_buffer.hpp"

namespace touchable {

/// Buffers that the CPU writes anew for each submission while earlier ones are still being read: as many as
/// are in use at once, then none is made any more.
class UploadPool {
public:
    explicit UploadPool(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}

    /// A mapped buffer of at least `bytes` that nobody uses: neither a handle nor a submission, recorded or
    /// in flight. Its content is undefined. Fails as GpuBuffer::create does.
    Result<GpuBuffer> take(const std::string& name, std::size_t bytes);

private:
    struct Slot {
        GpuBuffer buffer;
        std::uint64_t taken;  // when last, in takes
    };
    std::shared_ptr<GpuDevice> device_;
    std::vector<Slot> slots_;
    std::uint64_t takes_ = 0;
};

}  // namespace touchable
