#include "engine/gpu/memory_type.hpp"

namespace touchable {
namespace {

constexpr VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
constexpr VkMemoryPropertyFlags visible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
constexpr VkMemoryPropertyFlags coherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
constexpr VkMemoryPropertyFlags cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;

/// How well memory with these properties serves; negative: not at all.
int worth(VkMemoryPropertyFlags flags, GpuMemory use) {
    if (flags & ~(local | visible | coherent | cached)) return -1;  // protected, lazy: not ordinary memory
    const auto has = [flags](VkMemoryPropertyFlags wanted) { return (flags & wanted) == wanted; };
    if (use == GpuMemory::device) return 2 * has(local) + !has(visible);
    if (!has(visible | coherent)) return -1;
    switch (use) {
        // Reading uncached memory is so slow that where it is comes second.
        case GpuMemory::shared:
            return has(cached) ? 2 + has(local) : !has(local);
        case GpuMemory::readback:
            return 2 * has(cached) + !has(local);
        default:
            return !has(local);  // upload: what the CPU may see of device memory can be small
    }
}

}  // namespace

std::optional<std::uint32_t> choose_memory_type(const VkPhysicalDeviceMemoryProperties& memory,
                                                std::uint32_t allowed, GpuMemory use) {
    std::optional<std::uint32_t> best;
    int most = -1;
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
        const int value = allowed >> i & 1U ? worth(memory.memoryTypes[i].propertyFlags, use) : -1;
        if (value <= most) continue;  // drivers list the faster of two alike first
        most = value;
        best = i;
    }
    return best;
}

}  // namespace touchable
