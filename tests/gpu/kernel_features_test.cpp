#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "engine/gpu/vulkan_instance.hpp"
#include "tests/gpu/spirv_layout.hpp"

// What the engine demands of a device against what its kernels, as built, declare.
namespace touchable::test {
namespace {

/// Of the SPIR-V specification.
enum Op : std::uint32_t { op_source_extension = 4, op_capability = 17, op_execution_mode_id = 331 };
constexpr std::uint32_t mode_local_size_id = 38;

/// A feature of Vulkan that a kernel may need, by the capability that stands for it, and where it is.
struct KernelFeature {
    const char* name;
    std::uint32_t capability;  // 0: none, see declared_by
    VkBool32& (*of)(GpuFeatures&);
};
#define TOUCHABLE_KERNEL_FEATURE(name, capability, part)                            \
    {                                                                               \
#name, capability, [](GpuFeatures & f) -> VkBool32& { return f.part.name; } \
    }
const KernelFeature kernel_features[] = {
    TOUCHABLE_KERNEL_FEATURE(shaderFloat64, 10, core.features),
    TOUCHABLE_KERNEL_FEATURE(shaderInt64, 11, core.features),
    TOUCHABLE_KERNEL_FEATURE(shaderInt16, 22, core.features),
    TOUCHABLE_KERNEL_FEATURE(shaderFloat16, 9, v12),
    TOUCHABLE_KERNEL_FEATURE(shaderInt8, 39, v12),
    TOUCHABLE_KERNEL_FEATURE(shaderBufferInt64Atomics, 12, v12),
    TOUCHABLE_KERNEL_FEATURE(storageBuffer16BitAccess, 4433, v11),
    TOUCHABLE_KERNEL_FEATURE(storageBuffer8BitAccess, 4448, v12),
    TOUCHABLE_KERNEL_FEATURE(scalarBlockLayout, 0, v12),
    TOUCHABLE_KERNEL_FEATURE(maintenance4, 0, v13),
};
#undef TOUCHABLE_KERNEL_FEATURE

/// Shader, SampledBuffer, ImageBuffer, ImageQuery: every Vulkan has them.
const std::set<std::uint32_t> capabilities_of_all = {1, 46, 47, 50};

/// Not of kernels, but of what C++ calls.
const std::set<std::string> called = {"timelineSemaphore", "synchronization2", "dynamicRendering"};

std::vector<std::string> kernel_files() {
    std::vector<std::string> names;
    std::stringstream list(TOUCHABLE_KERNELS);
    for (std::string name; std::getline(list, name, ',');) names.push_back(name);
    return names;
}

std::vector<std::uint32_t> words_of(const std::string& kernel) {
    std::ifstream in(std::filesystem::path(TOUCHABLE_KERNEL_FOLDER) / kernel, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), 4 * words.size());
    return words;
}

/// The features that a kernel declares; what this test has no name for by its number.
std::set<std::string> declared_by(const std::string& kernel) {
    const auto words = words_of(kernel);
    EXPECT_GT(words.size(), 5U) << kernel;
    std::set<std::string> names;
    for (std::size_t at = 5; at < words.size() && words[at] >> 16U > 0; at += words[at] >> 16U) {
        const std::uint32_t op = words[at] & 0xFFFFU;
        if (op == op_source_extension &&
            std::strcmp(reinterpret_cast<const char*>(&words[at + 1]), "GL_EXT_scalar_block_layout") == 0)
            names.insert("scalarBlockLayout");
        if (op == op_execution_mode_id && words[at + 2] == mode_local_size_id) names.insert("maintenance4");
        if (op != op_capability || capabilities_of_all.contains(words[at + 1])) continue;
        std::string name = "capability " + std::to_string(words[at + 1]);
        for (const KernelFeature& feature : kernel_features)
            if (feature.capability == words[at + 1]) name = feature.name;
        names.insert(name);
    }
    return names;
}

/// Whether the engine asks for a feature where a device has it.
bool asks_for(const KernelFeature& feature) {
    GpuFeatures here, wanted;
    feature.of(here) = VK_TRUE;
    enable(wanted, here);
    return feature.of(wanted) == VK_TRUE;
}

TEST(KernelFeatures, WhatKernelsDeclareIsAskedForAndNothingElse) {
    std::map<std::string, std::string> declared;  // by whom
    for (const std::string& kernel : kernel_files())
        for (const std::string& name : declared_by(kernel)) declared[name] += " " + kernel;
    for (const KernelFeature& feature : kernel_features) {
        EXPECT_EQ(asks_for(feature), declared.contains(feature.name))
            << feature.name << " is declared by:" << declared[feature.name];
        declared.erase(feature.name);
    }
    for (const auto& [name, kernels] : declared)
        ADD_FAILURE() << name << " is of no feature in this table, and declared by" << kernels;
}

TEST(KernelFeatures, ADeviceMayLackOnlyWhatOnePainterNeeds) {
    const GpuFeatures none;
    const auto demanded = missing_from({VK_API_VERSION_1_3, {"VK_KHR_push_descriptor"}, true}, none);
    const std::set<std::string> names(demanded.begin(), demanded.end());
    EXPECT_EQ(names.size(), demanded.size());
    std::set<std::string> expected = called;
    for (const std::string& kernel : kernel_files()) {
        std::set<std::string> declared = declared_by(kernel);
        // SurfaceRaster refuses a device without; there are other painters.
        if (kernel.rfind("raster", 0) == 0) declared.erase("shaderBufferInt64Atomics");
        expected.merge(declared);
    }
    EXPECT_EQ(names, expected);
}

/// So that every test can hold those that it creates against what C++ believes (layout_fault).
TEST(KernelLayouts, AreReadOfEveryComputeKernelAndOfWhatGpuProgramBinds) {
    int kernels = 0;
    for (const std::string& kernel : kernel_files()) {
        if (kernel.find(".vert.") != std::string::npos || kernel.find(".frag.") != std::string::npos)
            continue;
        ++kernels;
        const auto layout = read_spirv(words_of(kernel));
        ASSERT_TRUE(layout) << kernel << ": " << layout.error().message;
        EXPECT_FALSE(layout->other_sets) << kernel;
        std::uint32_t next = 0;
        for (const auto& [number, kind] : layout->bindings) {
            EXPECT_EQ(number, next++) << kernel;
            EXPECT_TRUE(kind) << kernel << ", binding " << number;
        }
    }
    EXPECT_GT(kernels, 15);
}

}  // namespace
}  // namespace touchable::test
