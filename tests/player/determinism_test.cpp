// SPDX-License-Identifier: Apache-2.0
#include <elf.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <sstream>
#include <utility>

#include "device/hand.hpp"
#include "engine/clip/clip.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/commands/run_options.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"

namespace touchable::test {
namespace {

/// Forces of a run that are known to the bit; words of `make` and of `touch`.
struct KnownRun {
    const char *force_hash, *name, *make, *touch;
    int invalid = -1;  ///< a stored value that stands for no depth in this run
};

void PrintTo(const KnownRun& run, std::ostream* out) {
    *out << run.name;
}

// The same with every compiler, at every level of optimisation, under sanitizers and on every machine. Where
// a change is meant to change forces (of scripted hands: the last four), the failures print the new hashes:
// take them over only when GCC and Clang, -O0 and -O3 agree on them.
const KnownRun known_runs[] = {
    {"6159c4124ce24834", "Globe", "globe --frames 15", "--fingers 5"},
    {"24707e292d727893", "SlipperyGlobe", "globe --plain --frames 2", "--fingers 3"},
    {"2cf2e848c7fd8bca", "Bumps", "bumps --frames 2", "--max-stiffness 0.5"},
    {"e1f87e65462747ce", "MovingLinear", "moving --frames 15", "--interpolation linear"},
    {"c958afe3bcace83c", "MovingHeld", "moving --frames 15", "--interpolation hold"},
    {"501e5ea63f503d21", "Spheres", "spheres --frames 2", "--max-force 3"},
    {"1d67ba68f8e0ebea", "Noise", "noise --frames 2", ""},
    {"708d57c4ac576840", "NoiseFiltered", "noise --frames 2 --bits 10", "--median 5 --fingers 2"},
    {"5f9f4bbf0c944866", "HolesFilled", "cliffs --frames 2", "--fill-holes 2 --median 3", 0},
    {"6a12eb05043d39c5", "TerracesRemoved", "globe --frames 2 --bits 8", "--terraces on --fingers 3"},
    {"08efd1ba909ea1f2", "BumpsInPixels", "bumps --frames 2", "--metric pixel"},
    {"6ab007750606372b", "Wander", "globe --frames 15", "--hand wander --fingers 5 --seconds 0.8"},
    {"28648993aeccfd85", "Stroke", "bumps --frames 2", "--hand stroke:angle=30,speed=0.3 --seconds 1"},
    {"c9ec4247c3a3c24f", "Press", "moving --frames 15", "--hand press:x=0.4,depth=5 --seconds 1"},
    {"9cd66b8cc70bdfa3", "Poke", "spheres --frames 2", "--hand poke:speed=0.5,period=0.6 --seconds 2"}};

std::vector<std::string> split(const std::string& text) {
    std::istringstream in(text);
    return {std::istream_iterator<std::string>(in), std::istream_iterator<std::string>()};
}

class Determinism : public ::testing::TestWithParam<KnownRun> {};

TEST_P(Determinism, ForcesMatchKnownHash) {
    const KnownRun& known = GetParam();
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv", scene = folder / "scene.json";
    auto make = split(known.make), words = split(known.touch);
    const std::string kind = make.front();
    make.erase(make.begin());
    make.insert(make.end(), {"--size", "96x64"});
    make_clip(kind, clip, make);
    words.push_back(clip);
    if (std::find(words.begin(), words.end(), "--hand") == words.end())
        words.insert(words.end(), {"--hand", zigzag_hand(folder / "zigzag.csv")});
    if (known.invalid >= 0) {
        auto description = scene_of(clip);
        description["depth"]["invalid"] = {known.invalid};
        std::ofstream(scene) << description;
        words.insert(words.end(), {"--scene", scene});
    }
    const auto report = touch(words);
    EXPECT_GT(report["finger_contact_pct"], 20) << "hardly a test of forces";
    EXPECT_EQ(report["force_hash"], std::string(known.force_hash));
}

/// Runs what it is given on one core only.
class OnOneCore {
public:
    OnOneCore() {
        sched_getaffinity(0, sizeof before_, &before_);
        cpu_set_t one;
        CPU_ZERO(&one);
        for (int core = 0; core < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++core)
            if (CPU_ISSET(core, &before_)) CPU_SET(core, &one);
        sched_setaffinity(0, sizeof one, &one);
    }
    ~OnOneCore() { sched_setaffinity(0, sizeof before_, &before_); }
    OnOneCore(const OnOneCore&) = delete;
    OnOneCore& operator=(const OnOneCore&) = delete;

private:
    cpu_set_t before_{};
};

/// The forces do not depend on the codec of the clip's pictures nor on the number of decoding threads.
TEST(Archives, GiveSameForces) {
    const TemporaryFolder folder;
    const std::string hand = zigzag_hand(folder / "zigzag.csv");
    std::string known;
    for (const std::string archive : {"fast", "small"}) {
        const std::string clip = folder / (archive + ".mkv");
        make_clip("moving", clip, {"--size", "300x200", "--frames", "16", "--archive", archive});
        const auto words =
            std::vector<std::string>{clip, "--hand", hand, "--fingers", "2", "--seconds", "0.5"};
        const std::string all = touch(words)["force_hash"];
        const OnOneCore alone;
        const std::string one = touch(words)["force_hash"];
        EXPECT_EQ(one, all) << archive;
        if (known.empty()) known = all;
        EXPECT_EQ(all, known) << archive;
    }
}

INSTANTIATE_TEST_SUITE_P(, Determinism, ::testing::ValuesIn(known_runs),
                         [](const auto& run) { return std::string(run.param.name); });

// The room of a run links into any program (touch_a_clip.cpp), which feels what `touchable touch` does.

TEST(LinkedRun, MatchesProgramForces) {
    const TemporaryFolder folder;
    const auto clip = folder / "clip.mkv", report = folder / "report.json", hash = folder / "hash";
    succeed({"make", "bumps", clip, "--frames", "2"});
    succeed({"touch", clip, "--hand", "press", "--builder", "cpu", "--json", report});
    const std::string command =
        std::string("'" TOUCHABLE_LINKED_RUN "' '") + clip.string() + "' > '" + hash.string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    EXPECT_EQ(file_contents(hash), json_in(report).at("force_hash").get<std::string>() + "\n");
}

/// Names that a program tells the loader: a sanitized one has hundreds of megabytes besides.
std::string loaded_names(const char* program) {
    std::ifstream file(program, std::ios::binary);
    Elf64_Ehdr header{};
    file.read(reinterpret_cast<char*>(&header), sizeof header);
    std::string names;
    for (int n = 0; n < header.e_shnum && file; ++n) {
        Elf64_Shdr section{};
        file.seekg(
            static_cast<std::streamoff>(header.e_shoff + static_cast<std::size_t>(n) * sizeof section));
        file.read(reinterpret_cast<char*>(&section), sizeof section);
        if (section.sh_type != SHT_STRTAB || (section.sh_flags & SHF_ALLOC) == 0) continue;
        names.resize(section.sh_size);
        file.seekg(static_cast<std::streamoff>(section.sh_offset));
        file.read(names.data(), static_cast<std::streamsize>(names.size()));
    }
    return names;
}

// A library that a program needs is named in it.
TEST(LinkedRun, NeedsNeitherWindowNorVulkan) {
    const std::string program = loaded_names(TOUCHABLE_LINKED_RUN);
    ASSERT_PRED2(says, program, "libavformat.so");
    for (const char* library :
         {"libvulkan.so", "libglfw.so", "libX11.so", "libasound.so", "libcairo.so", "libusb"})
        EXPECT_EQ(program.find(library), std::string::npos) << library;
}

// A session over a clip during which the GPU is lost.

constexpr std::int64_t frames = 20, ticks = 900;

enum class Doom { lost, hangs };

/// Its device is lost, or hangs, just before a frame.
class DoomedBuilder final : public SurfaceBuilder {
public:
    DoomedBuilder(const Scene& scene, std::shared_ptr<GpuDevice> device, Doom doom, std::int64_t at)
        : device_(std::move(device)), doom_(doom), at_(at) {
        auto made = make_vulkan_builder(scene, device_);
        if (!made) throw std::runtime_error(made.error().message);
        builder_ = std::move(*made);
    }
    std::string_view name() const override { return builder_->name(); }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (raw.number == at_ && doom_ == Doom::lost) device_->lose();
        if (raw.number == at_ && doom_ == Doom::hangs) {
            device_->set_patience(std::chrono::milliseconds(20));
            blockade_.emplace(*device_);
        }
        return builder_->build(raw, out);
    }

private:
    std::shared_ptr<GpuDevice> device_;
    Doom doom_;
    std::int64_t at_;
    std::optional<Blockade> blockade_;  // lifted after the builder has ended
    std::unique_ptr<SurfaceBuilder> builder_;
};

struct Touched {
    std::string force_hash;
    std::int64_t frames = 0, ticks = 0;
};

/// The scene's own filter, but a median of 3x3.
Scene scene_in(const ClipReader& reader) {
    Scene scene = reader.scene();
    scene.filter.median = 3;
    return scene;
}

Touched touched_with(std::unique_ptr<ClipReader> reader, std::unique_ptr<SurfaceBuilder> builder) {
    const Scene scene = scene_in(*reader);
    SurfaceFeed feed(std::move(reader), std::move(builder), scene);
    const auto first = feed.pair_at(0);
    EXPECT_TRUE(first);
    const HeightField field(scene, *first);
    TouchSessionSettings settings;
    settings.fingers = 3;
    settings.ticks = ticks;
    const Workspace workspace = default_workspace(scene.width, scene.camera.fx, scene.depth.near);
    settings.touch.metres_per_scene_unit = workspace.metres_per_scene_unit;
    auto hand = make_hand("wander", settings.fingers, workspace, FieldProbe(field));
    EXPECT_TRUE(hand);
    const auto solver = TouchSolver::create(scene, settings.touch);
    EXPECT_TRUE(solver);
    TouchFigures figures;
    const std::array<TouchSink*, 1> sinks{&figures};
    const auto ran = TouchSession(feed, **hand, *solver, settings).run(sinks);
    EXPECT_TRUE(ran) << ran.error().message;
    EXPECT_GT(figures.to_json()["finger_contact_pct"].get<double>(), 20) << "hardly a test of forces";
    return {figures.force_hash(), feed.frames(), figures.ticks()};
}

TEST(LostGpu, KeepsFramesAndForces) {
    const TemporaryFolder folder;
    // A scene whose depth stands still would ask nothing of the GPU.
    make_clip("moving", folder / "clip.mkv", {"--size", "160x120", "--frames", std::to_string(frames)});
    const auto reader = [&] {
        auto opened = open_clip(folder / "clip.mkv", std::nullopt);
        EXPECT_TRUE(opened);
        return std::move(*opened);
    };
    auto whole = reader();
    const Scene scene = scene_in(*whole);
    const Touched expected = touched_with(std::move(whole), make_cpu_builder(scene));
    EXPECT_EQ(expected.ticks, ticks);

    for (const auto& [doom, lost_at] : {std::pair(Doom::lost, std::int64_t{0}),
                                        {Doom::lost, 7},
                                        {Doom::lost, frames - 1},
                                        {Doom::hangs, 0},
                                        {Doom::hangs, 11}}) {
        auto device = must(GpuDevice::open());
        std::vector<std::string> told;
        const Touched run = touched_with(
            reader(), make_fallback_builder(std::make_unique<DoomedBuilder>(scene, device, doom, lost_at),
                                            make_cpu_builder(scene),
                                            [&](const std::string& line) { told.push_back(line); }));
        EXPECT_EQ(run.force_hash, expected.force_hash) << "lost at frame " << lost_at;
        EXPECT_EQ(run.frames, expected.frames);
        EXPECT_EQ(run.ticks, expected.ticks);
        ASSERT_EQ(told.size(), 1U) << "at frame " << lost_at << (doom == Doom::lost ? ", lost" : ", hangs");
        EXPECT_EQ(told[0].rfind("frame " + std::to_string(lost_at) + ": ", 0), 0U) << told[0];
    }
}

TEST(LostGpu, IsReplacedOnNextOpen) {
    RunGpu gpu("auto");
    const auto first = must(gpu.open());
    EXPECT_EQ(*gpu.open(), first) << "one for all";
    first->lose();
    const auto second = must(gpu.open());
    EXPECT_FALSE(second->lost());
    EXPECT_EQ(*gpu.open(), second);
    EXPECT_EQ(gpu.name(), second->facts().name);
}

TEST(LostGpu, IsNotMeasuredAgain) {
    const TemporaryFolder cache;  // the mark of a lost GPU is kept there for later runs
    const char* const usual = std::getenv("XDG_CACHE_HOME");
    const std::string before = usual ? usual : "";
    setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
    RunGpu gpu("auto");
    int measured = 0;
    const auto measure = [&](const std::shared_ptr<GpuDevice>& device) {
        GpuFacts::Measured& figures = device->vulkan()->facts.measured;
        if (figures.vulkan_ms >= 0) return;
        ++measured;
        figures.vulkan_ms = HUGE_VAL;
        device->lose();
    };
    for (int n = 0; n < 2; ++n) {
        const auto device = must(gpu.open_measured(measure));
        EXPECT_FALSE(device->lost());
        EXPECT_EQ(device->facts().measured.vulkan_ms, HUGE_VAL);
        device->lose();
    }
    setenv("XDG_CACHE_HOME", before.c_str(), 1);  // empty: as if it were not set
    EXPECT_EQ(measured, 1);
}

/// A software GPU still compiles then, on a thread of the program.
TEST(LostGpu, LetsProgramEndNormally) {
    const TemporaryFolder folder;
    make_clip("moving", folder / "clip.mkv", {"--size", "96x64", "--frames", "3"});
    setenv("LD_PRELOAD", TOUCHABLE_IMPATIENT_GPU, 1);
    setenv("MESA_SHADER_CACHE_DISABLE", "1", 1);
    const Outcome run = run_touchable({"touch", folder / "clip.mkv", "--builder", "vulkan", "--median", "5",
                                       "--hand", "wander", "--seconds", "0.001"});
    unsetenv("LD_PRELOAD");
    unsetenv("MESA_SHADER_CACHE_DISABLE");
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_PRED2(says, run.err, "is given up; the cpu builder goes on");
}

/// `spoil` makes a GPU, which the picture was to be drawn on, one that cannot.
void expect_a_picture_by_any_painter(const std::function<void(GpuDevice&)>& spoil) {
    const TemporaryFolder folder;
    make_clip("globe", folder / "clip.mkv", {"--size", "72x48", "--frames", "1"});
    auto reader = must(open_clip(folder / "clip.mkv", std::nullopt));
    const auto raw = reader->next();
    ASSERT_TRUE(raw && *raw);
    const Scene& scene = reader->scene();
    SurfaceFrame surface;
    ASSERT_TRUE(make_cpu_builder(scene)->build(**raw, surface));
    const FramePair still{{0, 0, &surface}, {0, 0, &surface}, 0};
    for (const char* painter : {"auto", "raster"}) {
        RunGpu gpu("auto");
        GpuFacts& facts = must(gpu.open())->vulkan()->facts;
        facts.kind = GpuKind::discrete;  // on a software GPU the CPU draws
        facts.measured.mesh_ms = facts.measured.raster_ms = 1;
        PictureOptions options;
        options.file = folder / (std::string(painter) + ".png");
        options.painter = painter;
        options.size = "96x54";
        auto order = order_picture(options, Existing::keep, {}, gpu);
        ASSERT_TRUE(order && *order);
        EXPECT_FALSE((*order)->painter->gpu_name().empty());
        spoil(**gpu.open());
        const auto drawn = (*order)->deliver(HeightField(scene, still), still, (*raw)->colour, {});
        const bool any = options.painter == "auto";
        EXPECT_EQ(bool(drawn), any);
        EXPECT_EQ(std::filesystem::exists(*options.file), any);
        if (any) {
            EXPECT_EQ((*order)->painter->name(), "cpu");
        } else {
            EXPECT_EQ(drawn.error().kind, ErrorKind::gpu);
        }
    }
}

TEST(LostGpu, FallsBackToCpuPainter) {
    expect_a_picture_by_any_painter([](GpuDevice& gpu) { gpu.lose(); });
}

TEST(SmallGpu, FallsBackToCpuPainter) {
    expect_a_picture_by_any_painter(
        [](GpuDevice& gpu) { gpu.vulkan()->facts.limits.max_texel_buffer_elements = 1; });
}

// touch with --builder vulkan: the forces of the other builders, and what it says where it cannot.

namespace fs = std::filesystem;

/// The environment of a machine without a Vulkan driver, while it lives.
class WithoutDriver {
public:
    WithoutDriver() {
        for (const char* name : names) setenv(name, "/nonexistent/driver.json", 1);
    }
    ~WithoutDriver() {
        for (const char* name : names) unsetenv(name);
    }

private:
    static constexpr const char* names[] = {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"};
};

/// The forces of the CPU and the lazy builder, to the bit, and nothing said by the validation layer.
void expect_the_same_forces(Words words) {
    words.insert(words.end(), {"--fingers", "3", "--seconds", "0.5"});
    const auto with = [&](const Words& more) { return force_hash(plus(words, more)); };
    for (const char* median : {"0", "3", "5"}) {
        const std::string cpu = with({"--median", median, "--builder", "cpu"});
        EXPECT_EQ(with({"--median", median, "--builder", "lazy"}), cpu) << median;
        EXPECT_EQ(with({"--median", median, "--builder", "vulkan"}), cpu) << median;
    }
    const std::string cpu = with({"--median", "3", "--fill-holes", "2", "--builder", "cpu"});
    EXPECT_EQ(with({"--median", "3", "--fill-holes", "2", "--builder", "vulkan"}), cpu);
}

std::string test_name(const ::testing::TestParamInfo<const char*>& test) {
    std::string name = fs::path(test.param).stem();
    std::erase_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
    return name;
}

class VulkanTouchGenerated : public ::testing::TestWithParam<const char*> {};

TEST_P(VulkanTouchGenerated, MatchesOtherBuilders) {
    const TemporaryFolder folder;
    make_clip(GetParam(), folder / "clip.mkv", {"--size", "150x90", "--frames", "9"});
    expect_the_same_forces({folder / "clip.mkv"});
}

INSTANTIATE_TEST_SUITE_P(, VulkanTouchGenerated,
                         ::testing::Values("globe", "bumps", "moving", "noise", "spheres", "cliffs"),
                         test_name);

class VulkanTouchStandIn : public ::testing::TestWithParam<const char*> {};

TEST_P(VulkanTouchStandIn, MatchesOtherBuilders) {
    const TemporaryFolder folder;
    const std::string scene = write_stand_in(folder.path(), stand_in(GetParam()));
    expect_the_same_forces({folder.path(), "--scene", scene});
}

INSTANTIATE_TEST_SUITE_P(, VulkanTouchStandIn,
                         ::testing::Values("castel_sr300", "visp_cube_realsense", "redwood5", "icl_nuim5"),
                         test_name);

class VulkanTouchReal : public ::testing::TestWithParam<const char*> {};

TEST_P(VulkanTouchReal, MatchesOtherBuilders) {
    const std::string clip = real_data(GetParam());
    TOUCHABLE_NEEDS_DATA(clip);
    Words words{clip};
    const std::string scene =
        TOUCHABLE_SOURCE_DIR "/tests/scenes/" + fs::path(GetParam()).filename().string() + ".json";
    if (fs::exists(scene)) words.insert(words.end(), {"--scene", scene});
    expect_the_same_forces(words);
}

INSTANTIATE_TEST_SUITE_P(, VulkanTouchReal,
                         ::testing::Values("castel_sr300", "visp_cube_realsense", "stills/redwood5",
                                           "stills/icl_nuim5", "stills/lensblur/greek-helmet.jpg",
                                           "depthkit_typing/Test.mov"),
                         test_name);

TEST(VulkanTouch, PassesValidationLayer) {
    const TemporaryFolder folder;
    make_clip("noise", folder / "clip.mkv", {"--size", "150x90", "--frames", "9"});
    setenv("TOUCHABLE_VULKAN_VALIDATION", "1", 1);
    const Outcome run = run_touchable({"touch", folder / "clip.mkv", "--builder", "vulkan", "--median", "5",
                                       "--fill-holes", "1", "--seconds", "0.3"});
    unsetenv("TOUCHABLE_VULKAN_VALIDATION");
    EXPECT_EQ(run.code, 0);
    EXPECT_EQ(run.err, "");
}

TEST(VulkanTouch, ReportNamesBuilderDevice) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "clip.mkv", {"--size", "40x30", "--frames", "2"});
    const auto device = must(GpuDevice::open());
    const auto on_gpu = touch({folder / "clip.mkv", "--seconds", "0.1", "--builder", "vulkan"});
    const auto on_cpu = touch({folder / "clip.mkv", "--seconds", "0.1"});
    EXPECT_EQ(on_gpu["device_name"], device->facts().name);
    EXPECT_EQ(on_cpu["device_name"], on_cpu["cpu_name"]);
    EXPECT_EQ(on_gpu["cpu_name"], on_cpu["cpu_name"]);
}

TEST(VulkanTouch, ReportsMissingDriver) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "clip.mkv", {"--size", "40x30", "--frames", "2"});
    const WithoutDriver none;
    expect_failure({"touch", folder / "clip.mkv", "--builder", "vulkan"}, 4, "install a driver");
}

TEST(VulkanTouch, AutoFallsBackToCpu) {
    RunGpu none("no such device");
    Scene scene;
    scene.width = 40;
    scene.height = 30;
    const auto asked_for = make_builder({.name = "vulkan"}, scene, none);
    ASSERT_FALSE(asked_for);
    EXPECT_EQ(asked_for.error().kind, ErrorKind::gpu);
    const auto picked = must(make_builder({.name = "vulkan", .gpu_fallback = true}, scene, none));
    EXPECT_EQ(picked->name(), "cpu");
}

TEST(VulkanTouch, AutoRequiresNamedGpu) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "clip.mkv", {"--size", "40x30", "--frames", "2"});
    const Words words{folder / "clip.mkv", "--seconds", "0.1"};
    const auto report = touch(plus(words, {"--gpu", "0"}));
    EXPECT_EQ(report["builder"], "cpu") << "small frames are not worth a GPU";
    EXPECT_EQ(report["force_hash"], force_hash(words));
    for (const char* builder : {"auto", "vulkan"})
        expect_failure({"touch", folder / "clip.mkv", "--builder", builder, "--gpu", "no such device"}, 4,
                       "no such device");
    for (const char* builder : {"cpu", "lazy"})
        expect_failure({"touch", folder / "clip.mkv", "--builder", builder, "--gpu", "0"}, 2);
}

// A clip in MP4, or as a glTF scene, is felt as the same clip in Matroska, to the bit.

class Mp4Touch : public ::testing::TestWithParam<int> {};

TEST_P(Mp4Touch, MatchesMatroskaForces) {
    const TemporaryFolder folder;
    const auto at = [&](const char* name) { return std::string(folder / name); };
    const std::string hand = zigzag_hand(at("zigzag.csv"));
    const auto forces = [&](const char* name) {
        return force_hash({at(name), "--hand", hand, "--fingers", "2", "--seconds", "0.25"});
    };
    for (const char* name : {"made.mkv", "made.mp4"})
        make_clip("globe", at(name),
                  {"--size", "320x240", "--frames", "6", "--bits", std::to_string(GetParam())});
    const std::string known = forces("made.mkv");
    EXPECT_EQ(forces("made.mp4"), known);
    for (const auto& [from, to] : {std::pair{"made.mkv", "converted.mp4"},
                                   {"converted.mp4", "scene.gltf"},
                                   {"scene.gltf", "back.mkv"}}) {
        succeed({"convert", at(from), at(to)});
        EXPECT_EQ(forces(to), known) << to;
    }
}

INSTANTIATE_TEST_SUITE_P(Bits, Mp4Touch, ::testing::Values(8, 10, 12, 16));

class FragmentedTouch : public ::testing::TestWithParam<int> {};

TEST_P(FragmentedTouch, MatchesClipForces) {
    const TemporaryFolder folder;
    const auto at = [&](const char* name) { return std::string(folder / name); };
    const std::string hand = zigzag_hand(at("zigzag.csv"));
    const auto forces = [&](const char* name) {
        return force_hash({at(name), "--hand", hand, "--fingers", "2", "--seconds", "0.25"});
    };
    const auto make = [&](const char* name, std::vector<std::string> options) {
        options.insert(options.end(),
                       {"--size", "320x240", "--frames", "20", "--bits", std::to_string(GetParam())});
        make_clip("globe", at(name), options);
    };
    make("made.mkv", {});
    make("made.mp4", {"--fragmented"});
    const std::string known = forces("made.mkv");
    EXPECT_EQ(forces("made.mp4"), known);
    for (const std::vector<std::string>& step :
         {std::vector<std::string>{at("made.mkv"), at("converted.mp4"), "--fragmented"},
          {at("converted.mp4"), at("back.mkv")}}) {
        const Outcome run = succeed(plus({"convert"}, step));
        EXPECT_EQ(run.out.find("has no MPEG-4 scene in fragments") != std::string::npos, step.size() > 2);
    }
    EXPECT_EQ(forces("converted.mp4"), known);
    EXPECT_EQ(forces("back.mkv"), known);
    // Without its last fragment 15 frames are there, which is more than is touched.
    const std::string whole = file_contents(at("made.mp4"));
    std::ofstream(at("cut.mp4"), std::ios::binary) << whole.substr(0, whole.size() * 9 / 10);
    EXPECT_EQ(forces("cut.mp4"), known);
    const Outcome told = run_touchable({"info", at("cut.mp4")});
    EXPECT_PRED2(says, told.out, "the file is cut: its first 15 frames are whole");
}

INSTANTIATE_TEST_SUITE_P(Bits, FragmentedTouch, ::testing::Values(8, 16));

TEST(FragmentedClip, RequiresMp4Name) {
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
    make_clip("globe", clip, {"--size", "64x48", "--frames", "2"});
    for (const char* out : {"out.mkv", "out/", "out.png"}) {
        expect_failure({"convert", clip, folder / out, "--fragmented"}, 2, "--fragmented is for NAME.mp4");
    }
    expect_failure({"make", "globe", folder / "out.mkv", "--fragmented"}, 2, "--fragmented is for NAME.mp4");
}

TEST(FragmentedClip, ReportsLostSound) {
    if (std::system("command -v ffmpeg >/dev/null") != 0)
        GTEST_SKIP() << "there is no program ffmpeg here (Debian: ffmpeg)";
    const TemporaryFolder folder;
    make_clip("globe", folder / "clip.mkv", {"--size", "64x48", "--frames", "20"});
    for (const auto& [codec, words] : {std::pair{"aac", "kept as it is (aac)"},
                                       {"ac3", "LOST: ac3, which an MP4 file in fragments cannot hold"}}) {
        const std::string sounding = std::string(folder / codec) + ".mkv", out = sounding + ".mp4";
        ASSERT_EQ(
            std::system(("ffmpeg -loglevel error -i '" + std::string(folder / "clip.mkv") +
                         "' -f lavfi -i sine=d=1 -map 0 -map 1 -c copy -c:a " + codec + " '" + sounding + "'")
                            .c_str()),
            0);
        const Outcome run = succeed({"convert", sounding, out, "--fragmented"});
        EXPECT_PRED2(says, run.out, words);
    }
}

}  // namespace
}  // namespace touchable::test
