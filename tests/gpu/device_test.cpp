// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/gpu/vulkan_instance.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/gpu/spirv_layout.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

class Device : public GpuTest {};

TEST_F(Device, OpensAndDescribesItself) {
    const GpuFacts& facts = gpu->facts();
    EXPECT_FALSE(facts.name.empty());
    EXPECT_FALSE(facts.driver.empty());
    EXPECT_EQ(facts.api.substr(0, 2), "1.");
    EXPECT_TRUE(facts.usable());
    EXPECT_GE(facts.limits.max_storage_buffer_range, 1U << 27U);
    EXPECT_GE(facts.limits.max_push_constants, 128U);
    EXPECT_GE(facts.limits.max_group_invocations, 128U);
    EXPECT_GT(facts.limits.subgroup_size, 0U);
    EXPECT_GT(facts.limits.min_storage_buffer_alignment, 0U);
}

TEST(Patience, IsLongerForSoftware) {
    const auto gpu = must(GpuDevice::open());
    EXPECT_EQ(gpu->patience(), std::chrono::seconds(gpu->facts().kind == GpuKind::software ? 60 : 10));
}

TEST_F(Device, IsListedUnderItsName) {
    const auto gpus = must(list_gpus());
    const auto chosen = choose_gpu(gpus, "auto");
    ASSERT_TRUE(chosen);
    EXPECT_EQ(gpus[*chosen].name, gpu->facts().name);
    EXPECT_EQ(must(GpuDevice::open({std::to_string(*chosen)}))->facts().name, gpu->facts().name);
}

TEST_F(Device, RejectsUnknownName) {
    expect_error(GpuDevice::open({"the fastest of all"}), ErrorKind::gpu, gpu->facts().name);
}

TEST_F(Device, ValidationSeesMistakes) {
    // The tests of this folder prove little unless the layer really watches: copy where there is a barrier
    // missing.
    const auto buffer = must(GpuBuffer::create(*gpu, "twice written", 64, GpuMemory::device));
    auto commands = must(GpuCommands::begin(gpu, "hazard"));
    commands.fill(buffer, 1);
    commands.fill(buffer, 2);
    run(std::move(commands));
    EXPECT_FALSE(messages->all().empty());
    messages.reset();  // so that the end of this test does not mind
}

TEST_F(Device, TakesNoWorkWhenLost) {
    auto submitted = run(must(GpuCommands::begin(gpu, "before")));
    auto during = must(GpuCommands::begin(gpu, "during"));
    gpu->lose();
    EXPECT_TRUE(gpu->lost());
    expect_error(std::move(during).submit(), ErrorKind::gpu, "lost");
    EXPECT_FALSE(GpuCommands::begin(gpu, "after"));
    EXPECT_FALSE(submitted.wait());
    EXPECT_TRUE(submitted.done()) << "what had completed stays completed";
}

TEST_F(Device, StaysLost) {
    const Error error = gpu->vulkan()->failed("vkQueueSubmit2", VK_ERROR_DEVICE_LOST);
    EXPECT_EQ(error.kind, ErrorKind::gpu);
    EXPECT_NE(error.message.find("vkQueueSubmit2: VK_ERROR_DEVICE_LOST"), std::string::npos) << error.message;
    EXPECT_TRUE(gpu->lost());
}

/// The driver's manifest that Vulkan's loader finds, and no other, while this lives.
class OnlyDriver {
public:
    explicit OnlyDriver(const std::string& manifest) {
        for (std::size_t k = 0; k < std::size(names); ++k) {
            if (const char* value = std::getenv(names[k])) before_[k] = value;
            setenv(names[k], manifest.c_str(), 1);
        }
    }
    ~OnlyDriver() {
        for (std::size_t k = 0; k < std::size(names); ++k)
            before_[k] ? setenv(names[k], before_[k]->c_str(), 1) : unsetenv(names[k]);
    }
    OnlyDriver(const OnlyDriver&) = delete;
    OnlyDriver& operator=(const OnlyDriver&) = delete;

private:
    static constexpr const char* names[] = {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"};
    std::optional<std::string> before_[std::size(names)];
};

/// Library and version, as the manifest of a driver here says them; nothing where none is found.
std::optional<std::array<std::string, 2>> some_driver() {
    std::vector<std::filesystem::path> manifests;
    if (const char* set = std::getenv("VK_ICD_FILENAMES")) manifests.emplace_back(set);
    for (const char* folder : {"/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"})
        if (std::filesystem::is_directory(folder))
            for (const auto& entry : std::filesystem::directory_iterator(folder))
                manifests.push_back(entry.path());
    std::sort(manifests.begin(), manifests.end(), [](const auto& a, const auto& b) {  // Mesa's lavapipe first
        const auto later = [](const auto& path) { return path.string().find("lvp") == std::string::npos; };
        return std::pair(later(a), a) < std::pair(later(b), b);
    });
    for (const auto& manifest : manifests) {
        std::ifstream in(manifest);
        const auto driver = nlohmann::json::parse(in, nullptr, false);
        if (driver.contains("ICD") && driver["ICD"].contains("library_path") &&
            driver["ICD"].contains("api_version"))
            return std::array<std::string, 2>{driver["ICD"]["library_path"], driver["ICD"]["api_version"]};
    }
    return std::nullopt;
}

TEST(PortabilityDrivers, AreSeen) {
    // A driver that says it is not all of Vulkan, as MoltenVK does, is hidden unless such are asked for.
    const auto driver = some_driver();
    if (!driver) GTEST_SKIP() << "no manifest of a driver is found";
    const TemporaryFolder folder;
    std::ofstream(folder / "driver.json")
        << "{\"file_format_version\": \"1.0.1\", \"ICD\": {\"library_path\": \"" << (*driver)[0]
        << "\", \"api_version\": \"" << (*driver)[1] << "\", \"is_portability_driver\": true}}";
    const OnlyDriver only(folder / "driver.json");
    EXPECT_FALSE(must(list_gpus()).empty());
    EXPECT_TRUE(must(GpuDevice::open({"auto", true}))->messages()->all().empty());
}

TEST(GpuList, IsEmptyWithoutDrivers) {
    const OnlyDriver none("/nonexistent/driver.json");
    const auto gpus = list_gpus();
    const auto opened = GpuDevice::open();

    ASSERT_TRUE(gpus) << gpus.error().message;
    EXPECT_TRUE(gpus->empty());
    expect_error(opened, ErrorKind::gpu, "install a driver");
}

class Buffer : public GpuTest {};

TEST_F(Buffer, CopiesUpAndBack) {
    constexpr std::size_t count = 1001;  // an odd one
    const auto up = must(GpuBuffer::create(*gpu, "up", count * 4, GpuMemory::upload));
    const auto there = must(GpuBuffer::create(*gpu, "there", count * 4, GpuMemory::device));
    const auto back = must(GpuBuffer::create(*gpu, "back", count * 4, GpuMemory::readback));
    EXPECT_TRUE(there.mapped<std::uint32_t>().empty());
    ASSERT_EQ(up.mapped<std::uint32_t>().size(), count);
    std::iota(up.mapped<std::uint32_t>().begin(), up.mapped<std::uint32_t>().end(), 7U);
    std::fill_n(back.mapped<std::uint32_t>().begin(), count, 0U);

    auto commands = must(GpuCommands::begin(gpu, "round trip"));
    commands.copy(up, 0, there, 0, count * 4);
    commands.barrier(GpuStage::transfer, GpuStage::transfer);
    commands.copy(there, 0, back, 0, count * 4);
    run(std::move(commands));
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(back.mapped<std::uint32_t>()[i], i + 7) << i;
}

TEST_F(Buffer, ImportsCpuMemory) {
    ASSERT_GT(gpu->facts().import_alignment, 0U);
    constexpr std::size_t count = 5000;
    const std::shared_ptr<std::uint8_t> memory = take_plane_memory(count * 4);
    auto* const words = reinterpret_cast<std::uint32_t*>(memory.get());
    auto imported = must(GpuBuffer::import(*gpu, "words", plane_block_of(memory.get(), count * 4)));
    EXPECT_TRUE(imported.mapped<std::uint32_t>().empty());
    const auto back = must(GpuBuffer::create(*gpu, "back", count * 4, GpuMemory::readback));
    // Writes after the import count, and commands keep what they read.
    std::iota(words, words + count, 9U);
    auto commands = must(GpuCommands::begin(gpu, "from the CPU's"));
    commands.copy(imported, 0, back, 0, count * 4);
    imported = {};
    run(std::move(commands));
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(back.mapped<std::uint32_t>()[i], i + 9) << i;
}

TEST_F(Buffer, FillsRanges) {
    const auto buffer = must(GpuBuffer::create(*gpu, "filled", 64, GpuMemory::shared));
    auto commands = must(GpuCommands::begin(gpu, "fill"));
    commands.fill(buffer, 0xAAAAAAAAU);
    commands.barrier(GpuStage::transfer, GpuStage::transfer);
    commands.fill(buffer, 5, 8, 12);
    run(std::move(commands));
    const auto words = buffer.mapped<std::uint32_t>();
    for (std::size_t i = 0; i < words.size(); ++i)
        EXPECT_EQ(words[i], i >= 2 && i < 5 ? 5U : 0xAAAAAAAAU) << i;
}

TEST_F(Buffer, RoundsUpToTexels) {
    const auto buffer = must(GpuBuffer::create(*gpu, "odd", 33, GpuMemory::shared));
    EXPECT_EQ(buffer.bytes(), 33U);
    EXPECT_EQ(buffer.size(), 48U);
    EXPECT_EQ(buffer.mapped<std::byte>().size(), 33U);
    EXPECT_NE(buffer.texels(), VkBufferView(VK_NULL_HANDLE));
    EXPECT_FALSE(GpuBuffer());
}

TEST_F(Buffer, OutlivesDeviceHandle) {
    auto buffer = must(GpuBuffer::create(*gpu, "late", 64, GpuMemory::shared));
    auto other = must(GpuDevice::open({"auto", true}));
    const auto its_messages = other->messages();
    buffer = must(GpuBuffer::create(*other, "later", 64, GpuMemory::shared));
    other.reset();
    buffer.mapped<std::uint32_t>()[0] = 3;
    EXPECT_EQ(buffer.mapped<std::uint32_t>()[0], 3U);
    buffer = {};
    EXPECT_TRUE(its_messages->all().empty());
}

TEST_F(Buffer, RejectsImpossibleSizes) {
    for (const std::size_t bytes : {std::size_t{0}, std::size_t{1} << 50U, ~std::size_t{0}})
        for (const GpuMemory memory : {GpuMemory::device, GpuMemory::shared}) {
            expect_error(GpuBuffer::create(*gpu, "too much", bytes, memory), ErrorKind::gpu, "'too much'");
        }
}

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
constexpr std::uint32_t any_type = ~0U;

TEST(MemoryType, DependsOnUseIfDiscrete) {
    EXPECT_EQ(choose_memory_type(discrete, any_type, GpuMemory::device), 1U);
    EXPECT_EQ(choose_memory_type(discrete, any_type, GpuMemory::upload), 3U);
    EXPECT_EQ(choose_memory_type(discrete, any_type, GpuMemory::shared), 4U);
    EXPECT_EQ(choose_memory_type(discrete, any_type, GpuMemory::readback), 4U);
}

TEST(MemoryType, IsOneIfUnified) {
    const auto unified = memory({local | seen | cached});
    for (const GpuMemory use : {GpuMemory::device, GpuMemory::upload, GpuMemory::shared, GpuMemory::readback})
        EXPECT_EQ(choose_memory_type(unified, any_type, use), 0U);
    const auto integrated = memory({local, seen, seen | cached, local | seen | cached});
    EXPECT_EQ(choose_memory_type(integrated, any_type, GpuMemory::shared), 3U);
}

TEST(MemoryType, IsAllowedAndOrdinary) {
    EXPECT_EQ(choose_memory_type(discrete, 1U << 5U, GpuMemory::shared), 5U);
    EXPECT_EQ(choose_memory_type(discrete, 1U << 2U, GpuMemory::device), 2U);
    EXPECT_FALSE(choose_memory_type(discrete, 1U << 1U, GpuMemory::upload));
    EXPECT_FALSE(choose_memory_type(discrete, 0, GpuMemory::device));
    const auto strange = memory({local | VK_MEMORY_PROPERTY_PROTECTED_BIT, local});
    EXPECT_EQ(choose_memory_type(strange, any_type, GpuMemory::device), 1U);
}

GpuFacts gpu(const char* name, GpuKind kind, std::vector<std::string> missing = {}) {
    GpuFacts facts;
    facts.name = name;
    facts.kind = kind;
    facts.missing = std::move(missing);
    return facts;
}

const std::vector<GpuFacts> four = {
    gpu("llvmpipe (LLVM 15)", GpuKind::software),
    gpu("Old Discrete 9000", GpuKind::discrete, {"Vulkan 1.3 (it has 1.1.0)"}),
    gpu("Radeon Graphics", GpuKind::integrated),
    gpu("Radeon Pro", GpuKind::discrete),
};

std::size_t chosen(const std::vector<GpuFacts>& gpus, const char* request) {
    const auto index = choose_gpu(gpus, request);
    EXPECT_TRUE(index) << (index ? "" : index.error().message);
    return index ? *index : gpus.size();
}

void expect_refused(const std::vector<GpuFacts>& gpus, const char* request, const char* why) {
    const auto index = choose_gpu(gpus, request);
    expect_error(index, ErrorKind::gpu, why);
    for (const GpuFacts& facts : gpus) {
        EXPECT_NE(index.error().message.find(facts.name), std::string::npos) << index.error().message;
        for (const std::string& missing : facts.missing)
            EXPECT_NE(index.error().message.find(missing), std::string::npos) << index.error().message;
    }
}

TEST(GpuChoice, PrefersFasterKinds) {
    std::vector<GpuFacts> gpus;
    for (const GpuKind kind :
         {GpuKind::software, GpuKind::virtualised, GpuKind::integrated, GpuKind::discrete}) {
        gpus.push_back(gpu("any", kind));
        EXPECT_EQ(chosen(gpus, "auto"), gpus.size() - 1);
    }
    gpus.push_back(gpu("d too", GpuKind::discrete));
    EXPECT_EQ(chosen(gpus, "auto"), 3U);
}

TEST(GpuChoice, TakesIndexKindOrPartialName) {
    for (const char* name : {"0", "LLVMPIPE", "lavapipe", "Lavapipe", "llvmpipe", "cpu", "CPU", "software"})
        EXPECT_EQ(chosen(four, name), 0U) << name;
    for (const char* name : {"2", "integrated"}) EXPECT_EQ(chosen(four, name), 2U) << name;
    for (const char* name : {"radeon pro", "auto", "discrete"})
        EXPECT_EQ(chosen(four, name), 3U) << "the first discrete one lacks something";
    auto gpus = four;
    gpus[2].missing = {"shaderInt64"};
    EXPECT_EQ(chosen(gpus, "radeon"), 3U);
}

TEST(GpuChoice, SaysWhatIsThereOrLacking) {
    for (const char* request : {"auto", "0", "radeon"}) expect_refused({}, request, "install a driver");
    expect_refused({gpu("One", GpuKind::discrete, {"shaderInt64", "timelineSemaphore"}),
                    gpu("Two", GpuKind::software, {"VK_KHR_push_descriptor"})},
                   "auto", "no usable GPU");
    for (const auto& [request, why] : {std::pair("4", "there is no GPU 4"),
                                       {"99999999999999999999999", "there is no GPU 9"},
                                       {"-1", "no GPU is called '-1'"},
                                       {"geforce", "llvmpipe (LLVM 15) (software, lavapipe)"},
                                       {"radeon", "several GPUs are called 'radeon'"},
                                       {"discrete 9", "no GPU called 'discrete 9' can be used"},
                                       {"1", "GPU 1 Old Discrete 9000 cannot be used"},
                                       {"", "has no name"}})
        expect_refused(four, request, why);
    for (const char* software : {"lavapipe", "cpu"})
        expect_refused({four.begin() + 1, four.end()}, software,
                       ("no GPU is called '" + std::string(software) + "'").c_str());
}

const GpuOffer complete = {VK_API_VERSION_1_3, {"VK_KHR_push_descriptor"}, true};

bool names(const std::vector<std::string>& missing, const char* what) {
    return std::any_of(missing.begin(), missing.end(),
                       [&](const std::string& word) { return word.find(what) != std::string::npos; });
}

TEST(Features, AreNamedIfMissing) {
    const GpuFeatures none;
    GpuFeatures all;
    enable(all, none);
    EXPECT_TRUE(missing_from(complete, all).empty());
    EXPECT_TRUE(names(missing_from({VK_API_VERSION_1_3, {}, true}, all), "VK_KHR_push_descriptor"));
    EXPECT_TRUE(names(missing_from({VK_API_VERSION_1_3, complete.extensions, false}, all), "queue"));
    all.core.features.shaderInt64 = VK_FALSE;
    EXPECT_EQ(missing_from(complete, all), std::vector<std::string>{"shaderInt64"});
    EXPECT_EQ(missing_from({VK_MAKE_API_VERSION(0, 1, 2, 198), {}, true}, none),
              std::vector<std::string>{"Vulkan 1.3 (it has 1.2.198)"});
}

TEST(Features, EnableOptionalOnesIfAvailable) {
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
    // As Vulkan demands where a device has the extension (MoltenVK).
    const auto enabled = extensions_to_enable({"VK_KHR_portability_subset", "VK_KHR_push_descriptor"});
    EXPECT_EQ(enabled.size(), 2U);
    EXPECT_EQ(std::ranges::count(enabled, std::string_view("VK_KHR_portability_subset")), 1);
}

// The features that the engine demands of a device, against those that its built kernels declare.

/// From the SPIR-V specification.
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

TEST(KernelFeatures, AreExactlyTheRequestedOnes) {
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

TEST(KernelFeatures, AreRequiredExceptOnePainters) {
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
TEST(KernelLayouts, AreReadOfEveryKernel) {
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
