#include <gtest/gtest.h>

#include <algorithm>

#include "engine/gpu/vulkan_instance.hpp"

namespace touchable::test {
namespace {

const GpuOffer complete = {VK_API_VERSION_1_3, {"VK_KHR_push_descriptor"}, true};

bool names(const std::vector<std::string>& missing, const char* what) {
    return std::any_of(missing.begin(), missing.end(),
                       [&](const std::string& word) { return word.find(what) != std::string::npos; });
}

TEST(Features, NothingIsMissingWhereAllIsThere) {
    GpuFeatures none, all;
    enable(all, none);
    EXPECT_TRUE(missing_from(complete, all).empty());
}

TEST(Features, EachOneMissingIsNamed) {
    const GpuFeatures none;
    const auto missing = missing_from(complete, none);
    for (const char* feature :
         {"shaderInt64", "timelineSemaphore", "synchronization2", "maintenance4", "dynamicRendering"})
        EXPECT_TRUE(names(missing, feature)) << feature;
    GpuFeatures all;
    enable(all, none);
    all.core.features.shaderInt64 = VK_FALSE;
    EXPECT_EQ(missing_from(complete, all), std::vector<std::string>{"shaderInt64"});
}

TEST(Features, ExtensionsAndQueuesAreMissedToo) {
    GpuFeatures none, all;
    enable(all, none);
    EXPECT_TRUE(names(missing_from({VK_API_VERSION_1_3, {}, true}, all), "VK_KHR_push_descriptor"));
    EXPECT_TRUE(names(missing_from({VK_API_VERSION_1_3, complete.extensions, false}, all), "queue"));
}

TEST(Features, AnOldVulkanIsRefusedForItsAge) {
    const GpuFeatures none;
    EXPECT_EQ(missing_from({VK_MAKE_API_VERSION(0, 1, 2, 198), {}, true}, none),
              std::vector<std::string>{"Vulkan 1.3 (it has 1.2.198)"});
}

TEST(Features, OptionalOnesAreEnabledOnlyWhereTheyAre) {
    GpuFeatures here, wanted;
    enable(wanted, here);
    EXPECT_FALSE(wanted.v12.shaderBufferInt64Atomics);
    here.v12.shaderBufferInt64Atomics = VK_TRUE;
    enable(wanted, here);
    EXPECT_TRUE(wanted.v12.shaderBufferInt64Atomics);
    EXPECT_EQ(extensions_to_enable(complete.extensions).size(), 1U);
    EXPECT_EQ(extensions_to_enable({"VK_KHR_push_descriptor", "VK_EXT_external_memory_host"}).size(), 2U);
    EXPECT_EQ(extensions_to_enable({"VK_KHR_push_descriptor", "VK_EXT_mesh_shader"}).size(), 1U)
        << "one that is not used";
}

TEST(Features, ADeviceThatIsNotAllOfVulkanIsToldThatThisIsKnown) {
    // As Vulkan demands where a device has the extension (MoltenVK).
    const auto enabled = extensions_to_enable({"VK_KHR_portability_subset", "VK_KHR_push_descriptor"});
    EXPECT_EQ(enabled.size(), 2U);
    EXPECT_TRUE(std::any_of(enabled.begin(), enabled.end(), [](std::string_view extension) {
        return extension == "VK_KHR_portability_subset";
    }));
}

}  // namespace
}  // namespace touchable::test
