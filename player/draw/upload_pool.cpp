#include "player/draw/upload_pool.hpp"

#include <algorithm>

namespace touchable {
namespace {

/// Takes after which a buffer that nobody asked for again goes.
constexpr std::uint64_t idle_takes = 200;

/// The question's own handle is let go after it, which sees what another thread did before it let go of its.
bool is_unused(const GpuBuffer& buffer) {
    return buffer.keep_alive().use_count() <= 2;  // the pool's handle, and this question's
}

}  // namespace

Result<GpuBuffer> UploadPool::take(const std::string& name, std::size_t bytes) {
    ++takes_;
    const std::size_t most = std::max<std::size_t>(4 * bytes, 4096);
    for (Slot& slot : slots_)
        if (slot.buffer.bytes() >= bytes && slot.buffer.bytes() <= most && is_unused(slot.buffer)) {
            slot.taken = takes_;
            return slot.buffer;
        }
    std::erase_if(slots_, [this](const Slot& slot) {
        return takes_ - slot.taken > idle_takes && is_unused(slot.buffer);
    });
    auto made = GpuBuffer::create(*device_, name, bytes,
                                  device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload);
    if (made.ok()) slots_.push_back({*made, takes_});
    return made;
}

}  // namespace touchable
