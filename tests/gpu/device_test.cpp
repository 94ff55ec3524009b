#include "tests/gpu/gpu_fixture.hpp"

#include <cstdlib>

#include "engine/gpu/gpu_commands.hpp"

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

TEST_F(Device, IsListedUnderItsName) {
    const auto gpus = must(list_gpus());
    const auto chosen = choose_gpu(gpus, "auto");
    ASSERT_TRUE(chosen.ok());
    EXPECT_EQ(gpus[*chosen].name, gpu->facts().name);
    GpuOptions by_index;
    by_index.request = std::to_string(*chosen);
    EXPECT_EQ(must(GpuDevice::open(by_index))->facts().name, gpu->facts().name);
}

TEST_F(Device, OneThatIsNotThereIsRefused) {
    GpuOptions options;
    options.request = "the fastest of all";
    const auto opened = GpuDevice::open(options);
    ASSERT_FALSE(opened.ok());
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
    ASSERT_FALSE(late.ok());
    EXPECT_EQ(late.error().kind, ErrorKind::gpu);
    EXPECT_NE(late.error().message.find("lost"), std::string::npos);
    EXPECT_FALSE(GpuCommands::begin(gpu, "after").ok());
    EXPECT_FALSE(submitted.wait().ok());
    EXPECT_TRUE(submitted.done()) << "what had completed stays completed";
}

TEST_F(Device, AResultOfTheDriverThatSaysLostIsSticky) {
    const Error error = gpu->vulkan()->failed("vkQueueSubmit2", VK_ERROR_DEVICE_LOST);
    EXPECT_EQ(error.kind, ErrorKind::gpu);
    EXPECT_NE(error.message.find("vkQueueSubmit2: VK_ERROR_DEVICE_LOST"), std::string::npos) << error.message;
    EXPECT_TRUE(gpu->lost());
}

TEST(WithoutDrivers, AnEmptyListAndAClearRefusal) {
    const char* before = std::getenv("VK_ICD_FILENAMES");
    const std::string kept = before ? before : "";
    setenv("VK_ICD_FILENAMES", "/nonexistent/driver.json", 1);
    setenv("VK_DRIVER_FILES", "/nonexistent/driver.json", 1);
    const auto gpus = list_gpus();
    const auto opened = GpuDevice::open();
    unsetenv("VK_DRIVER_FILES");
    before ? setenv("VK_ICD_FILENAMES", kept.c_str(), 1) : unsetenv("VK_ICD_FILENAMES");

    ASSERT_TRUE(gpus.ok()) << gpus.error().message;
    EXPECT_TRUE(gpus->empty());
    ASSERT_FALSE(opened.ok());
    EXPECT_EQ(opened.error().kind, ErrorKind::gpu);
    EXPECT_NE(opened.error().message.find("install a driver"), std::string::npos) << opened.error().message;
}

}  // namespace
}  // namespace touchable::test
