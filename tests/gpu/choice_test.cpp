#include <gtest/gtest.h>

#include <vector>

#include "engine/gpu/gpu_device.hpp"

namespace touchable::test {
namespace {

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
    ASSERT_FALSE(index) << *index;
    EXPECT_EQ(index.error().kind, ErrorKind::gpu);
    EXPECT_NE(index.error().message.find(why), std::string::npos) << index.error().message;
    for (const GpuFacts& facts : gpus) {
        EXPECT_NE(index.error().message.find(facts.name), std::string::npos) << index.error().message;
        for (const std::string& missing : facts.missing)
            EXPECT_NE(index.error().message.find(missing), std::string::npos) << index.error().message;
    }
}

TEST(ChooseGpu, AutoPrefersDiscreteThenIntegratedThenVirtualThenSoftware) {
    std::vector<GpuFacts> gpus = {gpu("s", GpuKind::software)};
    EXPECT_EQ(chosen(gpus, "auto"), 0U);
    gpus.push_back(gpu("v", GpuKind::virtualised));
    EXPECT_EQ(chosen(gpus, "auto"), 1U);
    gpus.push_back(gpu("i", GpuKind::integrated));
    EXPECT_EQ(chosen(gpus, "auto"), 2U);
    gpus.push_back(gpu("d", GpuKind::discrete));
    gpus.push_back(gpu("d too", GpuKind::discrete));
    EXPECT_EQ(chosen(gpus, "auto"), 3U);
}

TEST(ChooseGpu, AutoPassesByWhatLacksSomething) {
    EXPECT_EQ(chosen(four, "auto"), 3U);
}

TEST(ChooseGpu, TakesAnIndexOrAPartOfAName) {
    EXPECT_EQ(chosen(four, "0"), 0U);
    EXPECT_EQ(chosen(four, "2"), 2U);
    EXPECT_EQ(chosen(four, "LLVMPIPE"), 0U);
    EXPECT_EQ(chosen(four, "radeon pro"), 3U);
}

TEST(ChooseGpu, TakesTheNamesThatPeopleKnow) {
    for (const char* name : {"lavapipe", "Lavapipe", "llvmpipe", "cpu", "CPU", "software"})
        EXPECT_EQ(chosen(four, name), 0U) << name;
    EXPECT_EQ(chosen(four, "integrated"), 2U);
    EXPECT_EQ(chosen(four, "discrete"), 3U) << "the other one lacks something";
    expect_refused({four.begin() + 1, four.end()}, "lavapipe", "no GPU is called 'lavapipe'");
    expect_refused({four.begin() + 1, four.end()}, "cpu", "no GPU is called 'cpu'");
    expect_refused(four, "geforce", "llvmpipe (LLVM 15) (software, lavapipe)");
}

TEST(ChooseGpu, OfANameOnlyTheUsableOnesCount) {
    auto gpus = four;
    gpus[2].missing = {"shaderInt64"};
    EXPECT_EQ(chosen(gpus, "radeon"), 3U);
}

TEST(ChooseGpu, NothingThereIsSaidWithWhatWouldHelp) {
    expect_refused({}, "auto", "install a driver");
    expect_refused({}, "0", "install a driver");
    expect_refused({}, "radeon", "install a driver");
}

TEST(ChooseGpu, AllLackingNamesWhatEachLacks) {
    expect_refused({gpu("One", GpuKind::discrete, {"shaderInt64", "timelineSemaphore"}),
                    gpu("Two", GpuKind::software, {"VK_KHR_push_descriptor"})},
                   "auto", "no usable GPU");
}

TEST(ChooseGpu, RefusesWhatIsNotThereNotUsableOrNotClear) {
    expect_refused(four, "4", "there is no GPU 4");
    expect_refused(four, "99999999999999999999999", "there is no GPU 9");
    expect_refused(four, "-1", "no GPU is called '-1'");
    expect_refused(four, "geforce", "no GPU is called 'geforce'");
    expect_refused(four, "radeon", "several GPUs are called 'radeon'");
    expect_refused(four, "discrete 9", "no GPU called 'discrete 9' can be used");
    expect_refused(four, "1", "GPU 1 Old Discrete 9000 cannot be used");
    expect_refused(four, "", "has no name");
}

}  // namespace
}  // namespace touchable::test
