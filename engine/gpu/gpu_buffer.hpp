#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// Where a buffer's memory is. All but `device` are mapped for the CPU, coherently.
enum class GpuMemory {
    shared,    ///< both sides work on it: in device memory where that is cached for the CPU, else in host
               ///< memory
    device,    ///< for the GPU alone
    upload,    ///< written by the CPU once and in order, read by the GPU
    readback,  ///< written by the GPU, read by the CPU
};

/// A buffer, usable as storage, as texels (rgba32ui, the whole of it), for copies, and as indirect, vertex
/// and index data. A handle: copies are the same buffer, which lives until the last of them and the last
/// submission that uses it are gone. Its first content is undefined.
class GpuBuffer {
public:
    GpuBuffer() = default;

    /// `bytes` (at least 1) are rounded up to whole texels of 16. Fails (ErrorKind::gpu) where that much
    /// memory of that sort cannot be had; the name says which buffer in errors and debuggers.
    static Result<GpuBuffer> create(const GpuDevice& device, std::string name, std::size_t bytes,
                                    GpuMemory memory);

    explicit operator bool() const { return state_ != nullptr; }
    const std::string& name() const { return state_->name; }
    std::size_t bytes() const { return state_->bytes; }  ///< as asked for
    std::size_t size() const { return state_->size; }    ///< in whole texels: what kernels may touch
    VkBuffer handle() const { return state_->buffer; }
    /// Null where the buffer has more texels than a view may (limits.max_texel_buffer_elements).
    VkBufferView texels() const { return state_->texels; }
    /// Texels of one uint32 each, likewise.
    VkBufferView words() const { return state_->words; }

    /// The buffer as the CPU sees it; empty for GpuMemory::device. Writes before a submission are seen by it,
    /// and what it wrote is seen once it has completed.
    template <class T>
    std::span<T> mapped() const {
        static_assert(std::is_trivially_copyable_v<T>);
        if (!state_->mapped) return {};
        return {reinterpret_cast<T*>(state_->mapped), state_->bytes / sizeof(T)};
    }

    /// Keeps the buffer (and so `mapped`) alive, for those who need not know what it is.
    std::shared_ptr<const void> keep_alive() const { return state_; }

private:
    struct State {
        ~State();

        std::shared_ptr<VulkanDevice> vulkan;
        std::string name;
        std::size_t bytes = 0;
        std::size_t size = 0;  // with what it was rounded up by
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        VkBufferView texels = VK_NULL_HANDLE, words = VK_NULL_HANDLE;
        void* mapped = nullptr;
    };
    static Result<std::shared_ptr<State>> make_state(const GpuDevice& device, std::string name,
                                                     std::size_t bytes);
    static Result<void> bind(State& state, std::uint32_t memory_type, std::size_t bytes);

    std::shared_ptr<const State> state_;
};

}  // namespace touchable
