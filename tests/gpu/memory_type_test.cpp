#include "engine/gpu/gpu_commands.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

namespace touchable::test {
namespace {

constexpr VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
constexpr VkMemoryPropertyFlags seen =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
constexpr VkMemoryPropertyFlags cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;

VkPhysicalDeviceMemoryProperties memory(std::initializer_list<VkMemoryPropertyFlags> types) {
    VkPhysicalDeviceMemoryProperties properties{};
    for (const VkMemoryPropertyFlags flags : types)
        properties.memoryTypes[properties.memoryTypeCount++].propertyFlags = flags;
    return properties;
}

// As a discrete GPU has them: host, device, device, host cached, a window of device memory.
const auto discrete = memory({0, local, local, seen, seen | cached, local | seen});
constexpr std::uint32_t all = ~0U;

TEST(MemoryType, OnADiscreteGpuEachUseHasItsOwn) {
    EXPECT_EQ(choose_memory_type(discrete, all, GpuMemory::device), 1U);
    EXPECT_EQ(choose_memory_type(discrete, all, GpuMemory::upload), 3U);
    EXPECT_EQ(choose_memory_type(discrete, all, GpuMemory::shared), 4U);
    EXPECT_EQ(choose_memory_type(discrete, all, GpuMemory::readback), 4U);
}

TEST(MemoryType, UnifiedMemoryServesAll) {
    const auto unified = memory({local | seen | cached});
    for (const GpuMemory use : {GpuMemory::device, GpuMemory::upload, GpuMemory::shared, GpuMemory::readback})
        EXPECT_EQ(choose_memory_type(unified, all, use), 0U);
    const auto integrated = memory({local, seen, seen | cached, local | seen | cached});
    EXPECT_EQ(choose_memory_type(integrated, all, GpuMemory::shared), 3U);
}

TEST(MemoryType, TakesOnlyWhatIsAllowedAndOrdinary) {
    EXPECT_EQ(choose_memory_type(discrete, 1U << 5U, GpuMemory::shared), 5U);
    EXPECT_EQ(choose_memory_type(discrete, 1U << 2U, GpuMemory::device), 2U);
    EXPECT_FALSE(choose_memory_type(discrete, 1U << 1U, GpuMemory::upload));
    EXPECT_FALSE(choose_memory_type(discrete, 0, GpuMemory::device));
    const auto strange = memory({local | VK_MEMORY_PROPERTY_PROTECTED_BIT, local});
    EXPECT_EQ(choose_memory_type(strange, all, GpuMemory::device), 1U);
}

}  // namespace
}  // namespace touchable::test
