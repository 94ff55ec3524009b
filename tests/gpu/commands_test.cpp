// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_recording.hpp"
#include "shaders/mix_words.spv.h"
#include "shaders/spec_group.spv.h"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/gpu/mix_words.h"
#include "tests/gpu/spirv_layout.hpp"
#include "tests/temporary_files.hpp"

namespace {
std::uint32_t driver_updates = 0;
}

/// In Vulkan's place: a driver's version grows by its updates.
extern "C" VKAPI_ATTR void VKAPI_CALL vkGetPhysicalDeviceProperties(VkPhysicalDevice device,
                                                                    VkPhysicalDeviceProperties* properties) {
    static const auto ask = reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(
        dlsym(RTLD_NEXT, "vkGetPhysicalDeviceProperties"));
    ask(device, properties);
    properties->driverVersion += driver_updates;
}

namespace touchable::test {
namespace {

using enum GpuBindingKind;

const GpuLayout right = {sizeof(MixWordsPush),
                         {storage_buffer, uniform_texels, storage_buffer, storage_buffer, storage_buffer},
                         {mix_words_group, 1, 1}};

class Commands : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!gpu) return;
        program = must(GpuProgram::create(*gpu, "mix_words", mix_words_spv, right));
        for (auto [buffer, name] :
             {std::pair(&in, "in"), {&texels_out, "texels out"}, {&out, "out"}, {&seen, "seen"}})
            *buffer = must(GpuBuffer::create(*gpu, name, most * 4, GpuMemory::shared));
        for (std::uint32_t i = 0; i < most; ++i) in.mapped<std::uint32_t>()[i] = i * i + 1;
    }
    void TearDown() override {
        program = {};
        in = texels_out = out = seen = {};
        GpuTest::TearDown();
    }

    static MixWordsPush push(std::uint32_t count, std::uint32_t salt) { return {{1, 2, 3}, 4, count, salt}; }
    void mix(GpuCommands& commands, std::uint32_t count, std::uint32_t salt) {
        commands.dispatch(program, push(count, salt), {in, in, texels_out, out, seen},
                          {groups_for(count, mix_words_group)});
    }
    GpuCommands begin() { return must(GpuCommands::begin(gpu, "test")); }

    static constexpr std::uint32_t most = 4096;
    GpuProgram program;
    GpuBuffer in, texels_out, out, seen;
};

TEST_F(Commands, PassEveryBindingAndConstant) {
    for (const std::uint32_t count : {0U, 1U, 3U, 31U, 32U, 33U, 1000U, most - 1}) {
        for (const GpuBuffer& buffer : {out, texels_out})
            for (std::uint32_t& word : buffer.mapped<std::uint32_t>()) word = 77;
        auto commands = begin();
        mix(commands, count, count + 9);
        run(std::move(commands));

        const auto from = in.mapped<std::uint32_t>(), words = out.mapped<std::uint32_t>();
        const auto texels = texels_out.mapped<std::uint32_t>();
        for (std::uint32_t i = 0; i < most; ++i) {
            ASSERT_EQ(words[i], i < count ? mix_word(from[i], count + 9) : 77U) << i << " of " << count;
            const std::uint32_t mirrored = i / 4 * 4 + 3 - i % 4;
            ASSERT_EQ(texels[i], i / 4 * 4 < count ? from[mirrored] : 77U) << i << " of " << count;
        }
        if (count == 0) continue;
        for (std::size_t i = 0; i < 4; ++i)
            EXPECT_EQ(seen.mapped<float>()[i], static_cast<float>(i + 1)) << "an unpadded vec3, then a float";
    }
}

TEST_F(Commands, TakeGroupCountsFromBuffer) {
    const auto counts = must(GpuBuffer::create(*gpu, "counts", 32, GpuMemory::shared));
    auto commands = begin();
    commands.fill(out, 0);
    commands.fill(counts, 2, 4, 4);
    commands.fill(counts, 1, 8, 8);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    commands.barrier(GpuStage::transfer, GpuStage::indirect);
    commands.dispatch_indirect(program, push(most, 1), {in, in, texels_out, out, seen}, counts, 4);
    run(std::move(commands));
    const auto words = out.mapped<std::uint32_t>(), from = in.mapped<std::uint32_t>();
    for (std::uint32_t i = 0; i < most; ++i)
        ASSERT_EQ(words[i], i < 2 * mix_words_group ? mix_word(from[i], 1) : 0U) << i;
}

TEST_F(Commands, RunSpecialisedGroups) {
    const std::uint32_t constants[] = {16, 4, 5};
    const auto special = must(
        GpuProgram::create(*gpu, "spec_group", spec_group_spv, {0, {storage_buffer}, {16, 4, 1}}, constants));
    auto commands = begin();
    commands.dispatch(special, {out}, {2, 3});
    run(std::move(commands));
    for (std::uint32_t i = 0; i < 32 * 12; ++i) ASSERT_EQ(out.mapped<std::uint32_t>()[i], 5 * (i % 32)) << i;
}

TEST_F(Commands, RejectNonsenseOnSubmit) {
    const auto wrong = [this](const char* why, const std::function<void(GpuCommands&)>& record) {
        auto commands = begin();
        record(commands);
        mix(commands, 1, 1);  // what comes after does not hide it
        expect_error(std::move(commands).submit(), ErrorKind::internal, why);
    };
    const GpuBuffer none;
    wrong("kernel mix_words: 4 bytes of push constants instead of 24", [&](GpuCommands& c) {
        c.dispatch(program, 1U, {in, in, texels_out, out, seen}, {1});
    });
    wrong("0 bytes of push constants", [&](GpuCommands& c) { c.dispatch(program, {in}, {1}); });
    wrong("4 bindings instead of 5", [&](GpuCommands& c) {
        c.dispatch(program, push(1, 1), {in, in, texels_out, out}, {1});
    });
    wrong("binding 0: there is no buffer", [&](GpuCommands& c) {
        c.dispatch(program, push(1, 1), {none, in, texels_out, out, seen}, {1});
    });
    wrong("does not exist", [&](GpuCommands& c) { c.dispatch(GpuProgram(), {in}, {1}); });
    wrong("no workgroup counts at 16380", [&](GpuCommands& c) {
        c.dispatch_indirect(program, push(1, 1), {in, in, texels_out, out, seen}, in, most * 4 - 4);
    });
    wrong("a copy: 8 bytes from 16380", [&](GpuCommands& c) { c.copy(in, most * 4 - 4, out, 0, 8); });
    wrong("overlaps", [&](GpuCommands& c) { c.copy(in, 0, in, 4, 8); });
    wrong("overlaps", [&](GpuCommands& c) { c.copy(in, 12, in, 8, 8); });
    wrong("a fill: 3 bytes", [&](GpuCommands& c) { c.fill(in, 0, 0, 3); });
    wrong("a fill of no buffer", [&](GpuCommands& c) { c.fill(none, 0); });
    wrong("one too many", [&](GpuCommands& c) {
        for (int i = 0; i < 32; ++i) c.mark("mark " + std::to_string(i));
    });
}

TEST_F(Commands, BlameDeviceForItsLimits) {
    // So that callers that can do without this device do (FallbackBuilder, PictureOrder).
    GpuFacts::Limits& limits = gpu->vulkan()->facts.limits;
    const GpuFacts::Limits its_own = limits;
    const auto too_much = [&](const char* why, GpuCommands::Groups groups) {
        auto commands = begin();
        commands.dispatch(program, push(1, 1), {in, in, texels_out, out, seen}, groups);
        const auto submitted = std::move(commands).submit();
        expect_error(submitted, ErrorKind::gpu, why);
        EXPECT_NE(submitted.error().message.find(gpu->facts().name), std::string::npos);
    };
    too_much("workgroups are too many", {~0U});
    limits.max_storage_buffer_range = most * 4 - 1;
    too_much("at most 16383 in one binding", {1});
    limits = its_own;
    limits.max_texel_buffer_elements = most / 4 - 1;
    in = must(GpuBuffer::create(*gpu, "texels in", most * 4, GpuMemory::shared));
    limits = its_own;
    too_much("buffer 'texels in' has more texels than a view may", {1});
}

TEST_F(Commands, RunInOrder) {
    constexpr std::uint32_t submissions = 200;
    std::vector<GpuCommands::Submission> given;
    for (std::uint32_t i = 1; i <= submissions; ++i) {
        auto commands = begin();
        mix(commands, 1000, i);
        commands.mark("mix");
        given.push_back(must(std::move(commands).submit()));
        EXPECT_EQ(given.back().value(), i);
    }
    must(given.back().wait());
    for (const GpuCommands::Submission& submission : given) EXPECT_TRUE(submission.done());
    for (std::uint32_t i = 0; i < 1000; ++i)
        ASSERT_EQ(out.mapped<std::uint32_t>()[i], mix_word(in.mapped<std::uint32_t>()[i], submissions)) << i;
    EXPECT_EQ(given.front().times().size(), 1U);
    EXPECT_EQ(given.back().times().size(), 1U);
}

TEST_F(Commands, KeepUsedBuffersAlive) {
    auto temporary = must(GpuBuffer::create(*gpu, "temporary", most * 4, GpuMemory::shared));
    const std::weak_ptr<const void> alive = temporary.keep_alive();
    auto commands = begin();
    commands.copy(in, 0, temporary, 0, most * 4);
    commands.barrier(GpuStage::transfer, GpuStage::transfer);
    commands.copy(temporary, 0, out, 0, most * 4);
    temporary = {};
    EXPECT_FALSE(alive.expired());
    const auto submission = run(std::move(commands));
    EXPECT_TRUE(alive.expired()) << "and no longer than that";
    for (std::uint32_t i = 0; i < most; ++i)
        ASSERT_EQ(out.mapped<std::uint32_t>()[i], in.mapped<std::uint32_t>()[i]);
}

TEST_F(Commands, TimeMarksInOrder) {
    auto commands = begin();
    mix(commands, most, 1);
    commands.mark("first");
    commands.barrier(GpuStage::compute, GpuStage::compute);
    for (int i = 0; i < 50; ++i) {
        mix(commands, most, 2);
        commands.barrier(GpuStage::compute, GpuStage::compute);
    }
    commands.mark("fifty more");
    const auto submission = run(std::move(commands));
    const auto times = submission.times();
    if (gpu->facts().limits.timestamp_period_ns == 0) GTEST_SKIP() << "the queue has no timestamps";
    ASSERT_EQ(times.size(), 2U);
    EXPECT_EQ(times[0].label, "first");
    EXPECT_EQ(times[1].label, "fifty more");
    EXPECT_GT(times[0].ms, 0);
    EXPECT_GT(times[1].ms, times[0].ms / 50) << "time goes on";
    EXPECT_LT(times[0].ms + times[1].ms, 10'000);
}

TEST(TicksBetween, IgnoresUncountedBits) {
    const std::uint64_t full = std::uint64_t{1} << 36U;
    EXPECT_EQ(ticks_between(10, 30, 64), 20U);
    EXPECT_EQ(ticks_between(~std::uint64_t{0} - 4, 3, 64), 8U);
    EXPECT_EQ(ticks_between(full - 5, 3, 36), 8U) << "it began anew";
    EXPECT_EQ(ticks_between(7 * full + 10, 3 * full + 30, 36), 20U) << "the bits above are undefined";
    EXPECT_EQ(ticks_between(10, 30, 0), 0U);
}

TEST_F(Commands, TimeWithCountedBits) {
    const GpuFacts::Limits& limits = gpu->facts().limits;
    if (limits.timestamp_bits == 0) GTEST_SKIP() << "the queue has no timestamps";
    gpu->vulkan()->facts.limits.timestamp_bits = 3;
    auto commands = begin();
    for (int i = 0; i < 20; ++i) {
        mix(commands, most, 1);
        commands.barrier(GpuStage::compute, GpuStage::compute);
        commands.mark("mix");
    }
    const auto submission = run(std::move(commands));
    const auto times = submission.times();
    ASSERT_EQ(times.size(), 20U);
    for (const GpuDevice::Time& time : times) EXPECT_LT(time.ms, 8 * limits.timestamp_period_ns * 1e-6);
}

TEST_F(Commands, GiveNoTimesWithoutTimestamps) {
    gpu->vulkan()->facts.limits.timestamp_period_ns = 0;
    auto commands = begin();
    mix(commands, most, 1);
    commands.mark("mix");
    const auto submission = run(std::move(commands));
    EXPECT_TRUE(submission.done());
    EXPECT_TRUE(submission.times().empty());
}

TEST_F(Commands, LoseDeviceAfterPatience) {
    gpu->set_patience(std::chrono::milliseconds(5));
    expect_error(gpu->wait(1'000'000), ErrorKind::gpu, "5 ms");
    EXPECT_TRUE(gpu->lost());
    EXPECT_FALSE(GpuCommands::begin(gpu, "after"));
}

TEST_F(Commands, LeaveHungDeviceItsMemory) {
    auto used = must(GpuBuffer::create(*gpu, "used", 64, GpuMemory::shared));
    const std::weak_ptr<const void> alive = used.keep_alive();
    used.mapped<std::uint32_t>()[0] = 1;
    Blockade blockade(*gpu);
    const auto value = [&] {
        auto commands = begin();
        commands.fill(used, 2);
        return must(std::move(commands).submit()).value();
    }();
    const std::span<std::uint32_t> words = used.mapped<std::uint32_t>();
    used = {};
    program = {};
    in = texels_out = out = seen = {};
    gpu->set_patience(std::chrono::milliseconds(20));
    EXPECT_FALSE(gpu->wait(value));
    EXPECT_TRUE(gpu->lost());
    EXPECT_EQ(gpu.use_count(), 1);
    gpu.reset();  // does not hang
    ASSERT_FALSE(alive.expired());
    EXPECT_EQ(words[0], 1U);
    wait_for_given_up_gpus();  // does not hang either
    EXPECT_EQ(words[0], 1U);
    blockade.lift();  // and if it goes on after all, it finds everything where it was
    EXPECT_EQ(words[0], 2U);
    must(GpuDevice::open());
    EXPECT_TRUE(alive.expired());
}

/// Gives a device of this kind up while its queue stands still, asks for it to be waited for, and lets the
/// queue go on after `standstill`; whether the wait saw the end of its work.
bool is_waited_for(GpuKind kind, std::chrono::milliseconds standstill) {
    auto device = must(GpuDevice::open());
    device->vulkan()->facts.kind = kind;
    const auto used = must(GpuBuffer::create(*device, "used", 64, GpuMemory::shared));
    const auto words = used.mapped<std::uint32_t>();
    words[0] = 1;
    Blockade blockade(*device);
    {
        auto commands = must(GpuCommands::begin(device, "given up"));
        commands.fill(used, 2);
        must(std::move(commands).submit());
    }
    device->lose();
    device.reset();
    std::jthread later([&] {
        std::this_thread::sleep_for(standstill);
        blockade.lift();
    });
    wait_for_given_up_gpus();
    return words[0] == 2;
}

TEST(GivenUpGpu, IsAwaitedOnlyIfSoftware) {
    EXPECT_TRUE(is_waited_for(GpuKind::software, std::chrono::milliseconds(50)));
    EXPECT_FALSE(is_waited_for(GpuKind::discrete, std::chrono::seconds(1)));
}

TEST_F(Commands, AreForgottenUnlessSubmitted) {
    {
        auto commands = begin();
        commands.fill(out, 1);
    }
    auto commands = begin();
    commands.fill(out, 2);
    run(std::move(commands));
    EXPECT_EQ(out.mapped<std::uint32_t>()[0], 2U);
    EXPECT_EQ(gpu->completed(), 1U);
}

TEST_F(Commands, AreRecordedBySeveralThreads) {
    std::vector<std::thread> threads;
    std::vector<int> good(4);
    for (std::size_t t = 0; t < good.size(); ++t)
        threads.emplace_back([&, t] {
            const auto mine = GpuBuffer::create(*gpu, "mine", 64, GpuMemory::shared);
            if (!mine) return;
            for (std::uint32_t i = 0; i < 50; ++i) {
                auto commands = GpuCommands::begin(gpu, "thread");
                if (!commands) return;
                commands->fill(mine.value(), i * 10 + static_cast<std::uint32_t>(t));
                const auto submission = std::move(*commands).submit();
                if (!submission || !submission->wait()) return;
                good[t] += mine->mapped<std::uint32_t>()[15] == i * 10 + t;
            }
        });
    for (std::thread& thread : threads) thread.join();
    for (const int count : good) EXPECT_EQ(count, 50);
}

TEST(GroupsFor, CoversWithoutSpare) {
    EXPECT_EQ(groups_for(0, 8), 0U);
    EXPECT_EQ(groups_for(1, 8), 1U);
    EXPECT_EQ(groups_for(8, 8), 1U);
    EXPECT_EQ(groups_for(9, 8), 2U);
    EXPECT_EQ(groups_for(~0U, 2), 1U << 31U);
}

TEST(Spirv, DescribesKernelsLayout) {
    const auto layout = must(read_spirv(mix_words_spv));
    EXPECT_EQ(layout.push_bytes, 24U) << "a vec3 is not padded";
    EXPECT_EQ(layout.group_size, right.group_size);
    ASSERT_EQ(layout.bindings.size(), 5U);
    for (std::uint32_t i = 0; i < 5; ++i) EXPECT_EQ(layout.bindings.at(i), right.bindings[i]) << i;
    EXPECT_FALSE(layout.other_sets);
}

TEST(Spirv, SpecialisesGroupSize) {
    const std::uint32_t constants[] = {16, 4, 5};
    const auto plain = must(read_spirv(spec_group_spv));
    EXPECT_EQ(plain.group_size, (std::array<std::uint32_t, 3>{1, 1, 1}));
    EXPECT_EQ(plain.constants.at(2), 3U);
    EXPECT_EQ(must(read_spirv(spec_group_spv, constants)).group_size,
              (std::array<std::uint32_t, 3>{16, 4, 1}));
}

TEST(Spirv, RejectsBrokenWords) {
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
            (void)read_spirv(bent);  // any answer will do; it returns
        }
}

class Program : public GpuTest {
protected:
    void expect_refused(const GpuLayout& layout, const char* why) {
        const auto program = GpuProgram::create(*gpu, "mix_words", mix_words_spv, layout);
        expect_error(program, ErrorKind::internal, "kernel mix_words");
        EXPECT_NE(program.error().message.find(why), std::string::npos) << program.error().message;
    }
};

TEST_F(Program, AcceptsRightLayout) {
    const auto program = must(GpuProgram::create(*gpu, "mix_words", mix_words_spv, right));
    ASSERT_TRUE(program);
    EXPECT_EQ(program.name(), "mix_words");
}

TEST_F(Program, NamesWrongLayouts) {
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
    wrong("binding 2 is a storage buffer, and C++ binds uniform texels",
          [](GpuLayout& l) { l.bindings[2] = uniform_texels; });
    wrong("binding 4 is a storage buffer, and C++ has no such binding",
          [](GpuLayout& l) { l.bindings.pop_back(); });
    wrong("C++ has a binding 5", [](GpuLayout& l) { l.bindings.push_back(storage_buffer); });
}

TEST_F(Program, RejectsUnknownConstants) {
    const std::uint32_t constants[] = {1};
    expect_error(GpuProgram::create(*gpu, "mix_words", mix_words_spv, right, constants),
                 "no specialisation constant 0");
}

TEST_F(Program, RejectsTooLargeGroups) {
    const std::uint32_t wide[] = {1U << 20U, 1, 3};
    expect_error(GpuProgram::create(*gpu, "spec_group", spec_group_spv,
                                    {0, {storage_buffer}, {1U << 20U, 1, 1}}, wide),
                 ErrorKind::gpu, "kernel spec_group");
}

TEST_F(Program, RejectsTooManyBuffers) {
    gpu->vulkan()->facts.limits.max_storage_buffers = 2;
    expect_error(GpuProgram::create(*gpu, "mix_words", mix_words_spv, right), ErrorKind::gpu,
                 "4 storage buffers, at most 2");
}

/// The file that a device with this cache folder leaves when it is closed.
std::string programs_kept_in(const std::filesystem::path& folder) {
    const auto gpu = must(GpuDevice::open({.cache_folder = folder}));
    must(GpuProgram::create(*gpu, "mix_words", mix_words_spv, right));
    const std::filesystem::path file = gpu->vulkan()->programs_file;
    if (const auto programs = gpu->vulkan()->take_new_programs()) (void)programs->keep();
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

TEST(KeptPrograms, AreFilesInNewFolder) {
    const TemporaryFolder folder;
    const std::string kept = programs_kept_in(folder.path() / "not" / "yet");
    EXPECT_GT(kept.size(), 64U);
    EXPECT_EQ(only_file_in(folder.path() / "not" / "yet").extension(), ".programs");
}

TEST(KeptPrograms, EndWithDriverVersion) {
    const TemporaryFolder folder;
    const auto open = [&] { return must(GpuDevice::open({.cache_folder = folder.path()})); };
    open()->vulkan()->facts.measured.cpu_ms = 5;
    EXPECT_EQ(open()->facts().measured.cpu_ms, 5);
    driver_updates = 1;
    EXPECT_LT(open()->facts().measured.cpu_ms, 0);
    driver_updates = 0;
}

TEST(KeptPrograms, AreRemadeAfterDamage) {
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

TEST(KeptPrograms, AreNotWrittenAgain) {
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
