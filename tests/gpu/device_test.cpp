#include "tests/gpu/gpu_fixture.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

class Device : public GpuTest {};

TEST_F(Device, OpensAndSaysWhatItIs) {
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

TEST(Patience, IsAMinuteWithASoftwareGpu) {
    const auto gpu = must(GpuDevice::open());
    EXPECT_EQ(gpu->patience(), std::chrono::seconds(gpu->facts().kind == GpuKind::software ? 60 : 10));
}

TEST_F(Device, IsListedUnderItsName) {
    const auto gpus = must(list_gpus());
    const auto chosen = choose_gpu(gpus, "auto");
    ASSERT_TRUE(chosen);
    EXPECT_EQ(gpus[*chosen].name, gpu->facts().name);
    GpuOptions by_index;
    by_index.request = std::to_string(*chosen);
    EXPECT_EQ(must(GpuDevice::open(by_index))->facts().name, gpu->facts().name);
}

TEST_F(Device, OneThatIsNotThereIsRefused) {
    GpuOptions options;
    options.request = "the fastest of all";
    const auto opened = GpuDevice::open(options);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().kind, ErrorKind::gpu);
    EXPECT_NE(opened.error().message.find(gpu->facts().name), std::string::npos) << opened.error().message;
}

TEST_F(Device, ValidationSeesMistakes) {
    // The tests of this folder prove little unless the layer really watches: copy where there is a barrier
    // missing.
    const auto buffer = must(GpuBuffer::create(*gpu, "twice written", 64, GpuMemory::device));
    auto commands = must(GpuCommands::begin(gpu, "hazard"));
    commands.fill(buffer, 1);
    commands.fill(buffer, 2);
    must(must(std::move(commands).submit()).wait());
    EXPECT_FALSE(messages->all().empty());
    messages.reset();  // so that the end of this test does not mind
}

TEST_F(Device, ALostOneTakesNoMoreWork) {
    auto before = must(GpuCommands::begin(gpu, "before"));
    auto submitted = must(std::move(before).submit());
    must(submitted.wait());
    auto during = must(GpuCommands::begin(gpu, "during"));
    gpu->lose();
    EXPECT_TRUE(gpu->lost());
    const auto late = std::move(during).submit();
    ASSERT_FALSE(late);
    EXPECT_EQ(late.error().kind, ErrorKind::gpu);
    EXPECT_NE(late.error().message.find("lost"), std::string::npos);
    EXPECT_FALSE(GpuCommands::begin(gpu, "after"));
    EXPECT_FALSE(submitted.wait());
    EXPECT_TRUE(submitted.done()) << "what had completed stays completed";
}

TEST_F(Device, AResultOfTheDriverThatSaysLostIsSticky) {
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
    // A driver that says it is not all of Vulkan, as MoltenVK does, is hidden from who does not ask for such.
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

TEST(WithoutDrivers, AnEmptyListAndAClearRefusal) {
    const OnlyDriver none("/nonexistent/driver.json");
    const auto gpus = list_gpus();
    const auto opened = GpuDevice::open();

    ASSERT_TRUE(gpus) << gpus.error().message;
    EXPECT_TRUE(gpus->empty());
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().kind, ErrorKind::gpu);
    EXPECT_NE(opened.error().message.find("install a driver"), std::string::npos) << opened.error().message;
}

}  // namespace
}  // namespace touchable::test
