#include "engine/gpu/gpu_commands.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <vector>

#include "shaders/mix_words.spv.h"
#include "shaders/spec_group.spv.h"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/gpu/mix_words.h"
#include "tests/gpu/spirv_layout.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

using enum GpuBindingKind;

const GpuLayout right = {sizeof(MixWordsPush),
                         {storage_buffer, uniform_texels, storage_texels, storage_buffer, storage_buffer},
                         {mix_words_group, 1, 1}};

TEST(Spirv, SaysHowToTalkToTheKernel) {
    const auto layout = must(read_spirv(mix_words_spv));
    EXPECT_EQ(layout.push_bytes, 24U) << "a vec3 is not padded";
    EXPECT_EQ(layout.group_size, right.group_size);
    ASSERT_EQ(layout.bindings.size(), 5U);
    for (std::uint32_t i = 0; i < 5; ++i) EXPECT_EQ(layout.bindings.at(i), right.bindings[i]) << i;
    EXPECT_FALSE(layout.other_sets);
}

TEST(Spirv, SpecialisationConstantsSetTheGroupSize) {
    const std::uint32_t constants[] = {16, 4, 5};
    const auto plain = must(read_spirv(spec_group_spv));
    EXPECT_EQ(plain.group_size, (std::array<std::uint32_t, 3>{1, 1, 1}));
    EXPECT_EQ(plain.constants.at(2), 3U);
    EXPECT_EQ(must(read_spirv(spec_group_spv, constants)).group_size,
              (std::array<std::uint32_t, 3>{16, 4, 1}));
}

TEST(Spirv, BrokenWordsAreRefusedAndNeverReadBeyond) {
    const std::vector<std::uint32_t> whole(std::begin(mix_words_spv), std::end(mix_words_spv));
    EXPECT_FALSE(read_spirv({}));
    std::size_t refused = 0;
    for (std::size_t length = 0; length < whole.size(); ++length) {
        const std::vector<std::uint32_t> cut(whole.begin(),
                                             whole.begin() + static_cast<std::ptrdiff_t>(length));
        refused += !read_spirv(cut);
    }
    EXPECT_GT(refused, whole.size() / 4);
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (const std::uint32_t word : {0U, 0xFFFFFFFFU, whole[at] + 0x10000U, whole[at] ^ 1U}) {
            auto bent = whole;
            bent[at] = word;
            (void)read_spirv(bent);  // whatever it says, it comes back
        }
}

class Program : public GpuTest {
protected:
    void expect_refused(const GpuLayout& layout, const char* why) {
        const auto program = GpuProgram::create(*gpu, "mix_words", mix_words_spv, layout);
        ASSERT_FALSE(program) << why;
        EXPECT_EQ(program.error().kind, ErrorKind::internal);
        EXPECT_NE(program.error().message.find("kernel mix_words"), std::string::npos);
        EXPECT_NE(program.error().message.find(why), std::string::npos) << program.error().message;
    }
};

TEST_F(Program, TheRightLayoutIsTaken) {
    const auto program = must(GpuProgram::create(*gpu, "mix_words", mix_words_spv, right));
    ASSERT_TRUE(program);
    EXPECT_EQ(program.name(), "mix_words");
}

TEST_F(Program, EveryWrongLayoutIsRefusedByName) {
    const auto wrong = [this](const char* why, const std::function<void(GpuLayout&)>& change) {
        GpuLayout layout = right;
        change(layout);
        expect_refused(layout, why);
    };
    wrong("push constants are 24 bytes, and C++ has 28", [](GpuLayout& l) { l.push_bytes = 28; });
    wrong("push constants are 24 bytes, and C++ has 0", [](GpuLayout& l) { l.push_bytes = 0; });
    wrong("workgroup is 32x1x1, and C++ believes 64x1x1", [](GpuLayout& l) { l.group_size = {64, 1, 1}; });
    wrong("binding 1 is uniform texels, and C++ binds a storage buffer",
          [](GpuLayout& l) { l.bindings[1] = storage_buffer; });
    wrong("binding 2 is storage texels, and C++ binds uniform texels",
          [](GpuLayout& l) { l.bindings[2] = uniform_texels; });
    wrong("binding 4 is a storage buffer, and C++ has no such binding",
          [](GpuLayout& l) { l.bindings.pop_back(); });
    wrong("C++ has a binding 5", [](GpuLayout& l) { l.bindings.push_back(storage_buffer); });
}

TEST_F(Program, ConstantsThatTheKernelHasNotAreRefused) {
    const std::uint32_t constants[] = {1};
    const auto program = GpuProgram::create(*gpu, "mix_words", mix_words_spv, right, constants);
    ASSERT_FALSE(program);
    EXPECT_NE(program.error().message.find("no specialisation constant 0"), std::string::npos);
}

TEST_F(Program, GroupsLargerThanTheDevicesAreRefused) {
    const std::uint32_t wide[] = {1U << 20U, 1, 3};
    const auto program = GpuProgram::create(*gpu, "spec_group", spec_group_spv,
                                            {0, {storage_buffer}, {1U << 20U, 1, 1}}, wide);
    ASSERT_FALSE(program);
    EXPECT_EQ(program.error().kind, ErrorKind::gpu);
    EXPECT_NE(program.error().message.find("kernel spec_group"), std::string::npos)
        << program.error().message;
}

TEST_F(Program, MoreBuffersThanTheDevicesAreRefused) {
    gpu->vulkan()->facts.limits.max_storage_buffers = 2;
    const auto program = GpuProgram::create(*gpu, "mix_words", mix_words_spv, right);
    ASSERT_FALSE(program);
    EXPECT_EQ(program.error().kind, ErrorKind::gpu);
    EXPECT_NE(program.error().message.find("3 storage buffers, at most 2"), std::string::npos)
        << program.error().message;
}

/// What a device that was opened there has left when it is closed.
std::string programs_kept_in(const std::filesystem::path& folder) {
    GpuOptions options;
    options.cache_folder = folder;
    const auto gpu = must(GpuDevice::open(options));
    must(GpuProgram::create(*gpu, "mix_words", mix_words_spv, right));
    const std::filesystem::path file = gpu->vulkan()->programs_file;
    if (const auto programs = gpu->vulkan()->take_new_programs()) (void)keep_programs(*programs);
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::filesystem::path only_file_in(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
    if (files.size() != 1) throw std::runtime_error("not one file in " + folder.string());
    return files.front();
}

void write_whole(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

TEST(KeptPrograms, AreAFileOfTheDeviceInAFolderThatIsMade) {
    const TemporaryFolder folder;
    const std::string kept = programs_kept_in(folder.path() / "not" / "yet");
    EXPECT_GT(kept.size(), 64U);
    EXPECT_EQ(only_file_in(folder.path() / "not" / "yet").extension(), ".programs");
}

TEST(KeptPrograms, OfADamagedFileOrAnotherDriverAreMadeAnew) {
    const TemporaryFolder folder;
    const std::string kept = programs_kept_in(folder.path());
    const std::filesystem::path file = only_file_in(folder.path());
    std::vector<std::string> bad = {"",
                                    "touchable",
                                    kept.substr(0, 63),
                                    kept.substr(0, kept.size() - 1),
                                    kept + "x",
                                    std::string(kept.size(), '\xFF')};
    // Each field of the head, and what comes after it.
    for (std::size_t at = 0; at < kept.size(); at += at < 128 ? 7 : 1 + kept.size() / 8) {
        bad.push_back(kept);
        bad.back()[at] = static_cast<char>(bad.back()[at] ^ 1);
    }
    for (const std::string& bytes : bad) {
        write_whole(file, bytes);
        EXPECT_EQ(programs_kept_in(folder.path()), kept);
    }
}

TEST(KeptPrograms, ThatAreReadAreNotWrittenAgain) {
    const TemporaryFolder folder;
    programs_kept_in(folder.path());
    const std::filesystem::path file = only_file_in(folder.path());
    const auto then = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1);
    std::filesystem::last_write_time(file, then);
    const auto before = std::filesystem::last_write_time(file);
    programs_kept_in(folder.path());
    EXPECT_EQ(std::filesystem::last_write_time(file), before);
}

TEST(KeptPrograms, MayBeKeptNowhere) {
    const TemporaryFolder folder;
    write_whole(folder.path() / "file", "no folder");
    EXPECT_EQ(programs_kept_in(folder.path() / "file"), "");
    EXPECT_EQ(programs_kept_in({}), "");
}

}  // namespace
}  // namespace touchable::test
