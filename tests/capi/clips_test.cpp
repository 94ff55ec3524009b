// SPDX-License-Identifier: Apache-2.0
// Clips by the C API: what is read is what lies in them, what is written is read again, and only what may be
// is replaced.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "capi/api_common.hpp"
#include "capi/touchable.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "tests/capi/hill.hpp"
#include "tests/must.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

/// A globe with all planes, as a clip of the program's.
fs::path make_globe(const fs::path& file, int frames = 5, int bits = 16) {
    SceneOptions options;
    options.width = 64;
    options.height = 48;
    options.bits = bits;
    options.properties = true;
    auto made = make_scene("globe", options);
    EXPECT_TRUE(made);
    auto writer = create_clip(file, (*made)->scene());
    EXPECT_TRUE(writer);
    for (int n = 0; n < frames; ++n) EXPECT_TRUE((*writer)->write((*made)->frame(n)));
    EXPECT_TRUE((*writer)->complete());
    EXPECT_TRUE((*writer)->finish());
    return file;
}

std::vector<std::uint8_t> bytes_of(const touch_plane& plane) {
    std::vector<std::uint8_t> bytes;
    const auto row = static_cast<std::size_t>(plane.width) * static_cast<std::size_t>(plane.channels) *
                     static_cast<std::size_t>(plane.sample);
    for (std::int64_t y = 0; plane.data && y < plane.height; ++y) {
        const auto* from = static_cast<const std::uint8_t*>(plane.data) + y * plane.stride_bytes;
        bytes.insert(bytes.end(), from, from + row);
    }
    return bytes;
}

std::vector<std::uint8_t> bytes_of(const PlaneView& view) {
    return bytes_of(capi::plane_for_program(view));
}

void write_hills(const fs::path& clip, int frames) {
    touch::Writer writer(clip.string(), touch::Scene(Hill::camera()));
    for (int n = 0; n < frames; ++n) writer.write(Hill(n).frame());
    writer.finish();
}

touch_status status_of_open(const std::string& path, std::string* line = nullptr,
                            const touch_clip_settings* settings = nullptr) {
    touch_error error = no_error();
    touch_clip clip{};
    const touch_status status = touch_clip_open(path.c_str(), settings, &clip, &error);
    if (line) *line = error.line;
    if (status == TOUCH_OK) touch_clip_close(clip);
    return status;
}

TEST(Clips, MatchProgramsReader) {
    const TemporaryFolder folder;
    const fs::path file = make_globe(folder / "globe.mkv");
    auto expected = must(open_clip(file));
    touch::Clip clip(file.string());
    const touch_clip_facts facts = clip.facts();
    EXPECT_EQ(facts.width, 64);
    EXPECT_EQ(facts.height, 48);
    EXPECT_EQ(facts.frames, 5);
    EXPECT_EQ(facts.depth_sample, TOUCH_U16);
    EXPECT_EQ(facts.depth_channels, 1);
    EXPECT_EQ(facts.has_colour, 1);
    EXPECT_EQ(facts.has_haptic, 1);
    EXPECT_EQ(facts.depth_is_lossless, 1);
    std::vector<touch::Frameset> held;
    for (int n = 0; n < 5; ++n) {
        auto next = clip.next();
        ASSERT_TRUE(next);
        held.push_back(std::move(*next));
    }
    EXPECT_FALSE(clip.next());
    for (const touch::Frameset& frameset : held) {  // long after they were read
        const touch_frame frame = frameset.frame();
        const auto raw = expected->next();
        ASSERT_TRUE(raw && *raw);
        EXPECT_EQ(frame.number, (*raw)->number);
        EXPECT_EQ(frame.time_ns, (*raw)->time_ns);
        EXPECT_EQ(bytes_of(frame.depth), bytes_of((*raw)->depth));
        EXPECT_EQ(bytes_of(frame.colour), bytes_of((*raw)->colour));
        EXPECT_EQ(bytes_of(frame.haptic), bytes_of((*raw)->haptic));
        EXPECT_EQ(bytes_of(frame.height), bytes_of((*raw)->height));
    }
}

TEST(Clips, FramesetsOutliveTheirClip) {
    const TemporaryFolder folder;
    const fs::path file = make_globe(folder / "globe.mkv");
    std::optional<touch::Frameset> last;
    std::vector<std::uint8_t> once;
    {
        touch::Clip clip(file.string());
        clip.seek(4);
        last = clip.next();
        ASSERT_TRUE(last);
        EXPECT_EQ(last->frame().number, 4);
        once = bytes_of(last->frame().depth);
        clip.seek(5);
        EXPECT_FALSE(clip.next());
        EXPECT_THROW(clip.seek(6), touch::Error);
        EXPECT_THROW(clip.seek(-1), touch::Error);
        clip.seek(0);
        EXPECT_EQ(clip.next()->frame().number, 0);
    }
    EXPECT_EQ(bytes_of(last->frame().depth), once);
    touch_frame none = touch::frame();
    EXPECT_EQ(touch_frameset_frame({1}, &none), TOUCH_STALE);
}

TEST(Clips, ChooseProgramsFilters) {
    const TemporaryFolder folder;
    const fs::path file = make_globe(folder / "globe.mkv", 6, 8);
    // Written anew with filters that are not stated.
    auto reader = must(open_clip(file));
    SceneDescription open(reader->scene());
    open.unstated.filters = all_unstated;
    auto writer = must(create_clip(folder / "open.mkv", open));
    DepthEstimator estimator(open.scene);
    for (auto frame = reader->next(); frame && *frame; frame = reader->next()) {
        if (!estimator.enough()) estimator.add(**frame);
        ASSERT_TRUE(writer->write(**frame));
    }
    ASSERT_TRUE(writer->complete());
    ASSERT_TRUE(writer->finish());
    Scene expected = open.scene;
    ASSERT_TRUE(settle_filters(estimator.measured(), all_unstated, expected));
    ASSERT_NE(expected.filter, open.scene.filter) << "nothing was chosen";

    touch::Clip clip((folder / "open.mkv").string());
    for (int n = 0; n < 3; ++n) ASSERT_TRUE(clip.next());
    const touch::Scene stated = clip.scene(TOUCH_FILTERS_STATED), chosen = clip.scene(TOUCH_FILTERS_CHOSEN);
    EXPECT_EQ(stated.facts().unstated_filters, 1);
    EXPECT_EQ(chosen.facts().unstated_filters, 0);
    EXPECT_EQ(chosen.text(), touch::Scene(scene_to_json(expected)).text());
    EXPECT_EQ(clip.next()->frame().number, 3) << "it went on from elsewhere";
}

TEST(Clips, MetresFollowCodes) {
    const touch::Scene scene(Hill::camera());
    const Hill hill;
    std::vector<std::uint16_t> codes = hill.codes();
    codes[0] = 0;     // no surface
    codes[1] = 1001;  // beyond far_m
    touch_plane plane = hill.frame().depth;
    plane.data = codes.data();
    constexpr int wide = Hill::width + 3;
    std::vector<float> metres(wide * Hill::height, -1);
    touch_error error = no_error();
    ASSERT_EQ(touch_scene_metres(scene.get(), &plane, metres.data(), 4 * wide, &error), TOUCH_OK)
        << error.line;
    EXPECT_TRUE(std::isnan(metres[0]));
    EXPECT_TRUE(std::isnan(metres[1]));
    for (std::size_t y = 0; y < Hill::height; ++y)
        for (std::size_t x = y == 0 ? 2 : 0; x < Hill::width; ++x)
            ASSERT_FLOAT_EQ(metres[y * wide + x], static_cast<float>(codes[y * Hill::width + x]) / 1000);
    EXPECT_EQ(metres[Hill::width], -1) << "wrote between the rows";
    EXPECT_EQ(touch_scene_metres(scene.get(), &plane, metres.data(), 4 * Hill::width - 1, &error),
              TOUCH_USAGE);
    plane.width = 5;
    EXPECT_EQ(touch_scene_metres(scene.get(), &plane, metres.data(), 4 * wide, &error), TOUCH_USAGE);
}

TEST(Clips, MetresFollowBytes) {
    const touch::Scene scene(
        std::string(R"({"touchable_scene": 1, "width": 4, "height": 4, "metres_per_unit": 1,
              "camera": {"fx": 3, "fy": 3, "cx": 1.5, "cy": 1.5},
              "depth": {"coding": "metric", "bits": 8, "scale": 0.5}})"));
    std::array<std::uint8_t, 16> codes;
    std::array<float, 16> metres;
    std::iota(codes.begin(), codes.end(), std::uint8_t{1});
    scene.metres({codes.data(), 4, 4, 4, TOUCH_U8, 1}, metres.data());
    for (std::size_t k = 0; k < codes.size(); ++k) EXPECT_EQ(metres[k], 0.5F * static_cast<float>(codes[k]));
}

/// The far plane's own depth is there again once it was a float.
TEST(Clips, MetresBecomeTheSameCodes) {
    for (const auto& [far_m, step_m] : {std::pair(0.6, 1e-4), {0.7, 1e-3}, {3.3, 1e-3}, {10.0, 1e-3}}) {
        touch_camera camera = Hill::camera();
        camera.far_m = far_m;
        camera.metres_per_code = step_m;
        const auto deepest = static_cast<std::uint16_t>(std::lround(far_m / step_m));
        const TemporaryFolder folder;
        const touch::Scene scene(camera);
        std::vector<std::uint16_t> codes(static_cast<std::size_t>(Hill::width) * Hill::height, deepest);
        for (std::size_t k = 0; k < 500; ++k) codes[k] = static_cast<std::uint16_t>(deepest - k);
        codes[5] = 0;
        touch_frame frame = Hill().frame();
        frame.depth.data = codes.data();
        std::vector<float> metres(codes.size());
        scene.metres(frame.depth, metres.data());
        frame.depth = Hill::plane_of(metres);
        touch::Writer writer((folder / "far.mkv").string(), scene);
        writer.write(frame);
        writer.finish();
        const auto bytes = bytes_of(touch::Clip((folder / "far.mkv").string()).next()->frame().depth);
        EXPECT_EQ(std::memcmp(bytes.data(), codes.data(), bytes.size()), 0)
            << "far plane at " << far_m << " m";
    }
}

/// Integers as they are, floats to half a step of far_m / 65534, and integers after floats alike.
TEST(Clips, OpenStepsFollowFirstFrame) {
    const TemporaryFolder folder;
    const touch::Scene scene(Hill::camera());
    const Hill hill;
    const std::vector<float> metres = hill.metres();
    std::vector<float> between = metres;
    for (float& depth : between) depth += 0.0003F;  // m: no multiple of a millimetre
    touch_frame integers = hill.frame(), floats = integers;
    floats.depth = Hill::plane_of(between);
    for (const char* ending : {".mkv", ".mp4", ""})
        for (const bool has_floats : {false, true}) {
            const std::string name = (folder / (has_floats ? "floats" : "integers")).string() + ending;
            touch::Writer writer(name, scene);
            writer.write(has_floats ? floats : integers);
            writer.write(integers);
            writer.finish();
            touch::Clip clip(name);
            const touch::Scene written = clip.scene(TOUCH_FILTERS_STATED);
            EXPECT_EQ(written.text().find("float_scale"), std::string::npos);
            for (int n = 0; n < 2; ++n) {
                const auto frameset = clip.next();
                std::vector<float> back(metres.size());
                written.metres(frameset->frame().depth, back.data());
                const std::vector<float>& given = has_floats && n == 0 ? between : metres;
                for (std::size_t k = 0; k < metres.size(); ++k)
                    ASSERT_NEAR(back[k], given[k], has_floats ? 0.51 / 65534 : 1e-7) << n;
            }
        }
}

TEST(Clips, ContinueAfterDamagedFrame) {
    const TemporaryFolder folder;
    write_hills(folder / "frames", 3);
    touch::Clip clip((folder / "frames").string());
    std::ofstream(folder / "frames/depth_000001.png") << "no picture any more";
    EXPECT_EQ(clip.scene(TOUCH_FILTERS_CHOSEN).facts().unstated_filters, 0)
        << "chosen by the first frame alone";
    EXPECT_EQ(clip.next()->frame().number, 0);
    touch_frameset none{};
    touch_error error = no_error();
    EXPECT_EQ(touch_clip_next(clip.get(), &none, &error), TOUCH_INPUT);
    EXPECT_NE(std::string(error.line).find("depth_000001.png"), std::string::npos) << error.line;
    clip.seek(2);
    EXPECT_EQ(clip.next()->frame().number, 2);
}

class WrittenClip : public testing::TestWithParam<const char*> {};

TEST_P(WrittenClip, HasSameCodes) {
    const TemporaryFolder folder;
    touch::Clip source(make_globe(folder / "globe.mkv").string());
    const touch::Scene scene = source.scene(TOUCH_FILTERS_STATED);
    const fs::path out = folder / GetParam();
    {
        touch::Writer writer(out.string(), scene);
        while (const auto frameset = source.next()) writer.write(frameset->frame());
        EXPECT_FALSE(fs::exists(out)) << "it has its name before it is whole";
        writer.finish();
        EXPECT_THROW(writer.finish(), touch::Error);
    }
    touch::Clip again(out.string());
    EXPECT_EQ(again.scene(TOUCH_FILTERS_STATED).facts().far_units, scene.facts().far_units);
    source.seek(0);
    int frames = 0;
    while (const auto frameset = again.next()) {
        const auto original = source.next();
        ASSERT_TRUE(original);
        EXPECT_EQ(frameset->frame().time_ns, original->frame().time_ns);
        EXPECT_EQ(bytes_of(frameset->frame().depth), bytes_of(original->frame().depth));
        EXPECT_EQ(bytes_of(frameset->frame().haptic), bytes_of(original->frame().haptic));
        ++frames;
    }
    EXPECT_EQ(frames, 5);
}

INSTANTIATE_TEST_SUITE_P(Clips, WrittenClip, testing::Values("copy.mkv", "copy.MP4", "copy"));

constexpr std::int64_t times[] = {0, 40'000'000, 50'000'000};

touch_writer_settings timed() {
    touch_writer_settings settings = touch::writer_settings();
    settings.times_ns = times;
    settings.times = 3;
    return settings;
}

TEST(Writers, KeepTimesAndMetres) {
    const TemporaryFolder folder;
    const touch::Scene scene(Hill::camera());
    const Hill hill;
    std::vector<float> metres = hill.metres();
    metres[7] = std::nanf("");
    touch_frame frame = hill.frame();
    frame.depth = Hill::plane_of(metres);
    const std::string out = (folder / "timed.mkv").string();
    touch::Writer writer(out, scene, timed());
    for (int n = 0; n < 3; ++n) writer.write(frame);
    writer.finish();
    touch::Clip clip(out);
    EXPECT_EQ(clip.facts().has_own_times, 1);
    EXPECT_EQ(clip.time_ns(2), times[2]);
    EXPECT_EQ(clip.scene(TOUCH_FILTERS_STATED).facts().frames_per_second, clip.facts().frames_per_second);
    std::int64_t none = 0;
    EXPECT_EQ(touch_clip_time(clip.get(), -1, &none), TOUCH_USAGE);
    std::vector<std::uint16_t> expected;
    for (const float depth : metres)
        expected.push_back(static_cast<std::uint16_t>(std::isnan(depth) ? 0 : std::lround(depth * 65534.0)));
    for (const std::int64_t time : times) {
        const auto next = clip.next();
        ASSERT_TRUE(next);
        EXPECT_EQ(next->frame().time_ns, time);
        const auto bytes = bytes_of(next->frame().depth);
        EXPECT_EQ(std::memcmp(bytes.data(), expected.data(), bytes.size()), 0);
    }
}

TEST(Writers, LeaveNothingUnfinished) {
    const TemporaryFolder folder;
    const touch::Scene scene(Hill::camera());
    const Hill hill;
    for (const char* name : {"never.mkv", "never.mp4", "never"}) {
        touch::Writer writer((folder / name).string(), scene);
        writer.write(hill.frame());
    }
    {
        touch::Writer empty((folder / "empty.mkv").string(), scene);
        EXPECT_THROW(empty.finish(), touch::Error);
    }
    touch::Writer few((folder / "few.mkv").string(), scene, timed());
    few.write(hill.frame());
    EXPECT_THROW(few.finish(), touch::Error) << "fewer frames than times";
    EXPECT_TRUE(fs::is_empty(folder.path())) << "something is left";
}

TEST(Writers, ReplaceOnlyOnRequest) {
    const TemporaryFolder folder;
    const fs::path file = make_globe(folder / "globe.mkv");
    const touch::Scene scene(Hill::camera());
    touch_writer refused{};
    EXPECT_EQ(touch_writer_create(file.c_str(), scene.get(), nullptr, &refused, nullptr), TOUCH_EXISTS);
    EXPECT_THROW(touch::Writer(file.string(), scene), touch::Error);
    touch_writer_settings replaces = touch::writer_settings();
    replaces.overwrite = 1;
    {
        const touch::Clip open(file.string());
        EXPECT_THROW(touch::Writer(file.string(), scene, replaces), touch::Error);
        EXPECT_EQ(touch_writer_create(file.c_str(), scene.get(), nullptr, &refused, nullptr), TOUCH_USAGE)
            << "an open clip is read from it";
        fs::create_symlink(file, folder / "link.mkv");
        EXPECT_THROW(touch::Writer((folder / "link.mkv").string(), scene, replaces), touch::Error)
            << "the same file by another name";
    }
    touch::Writer writer(file.string(), scene, replaces);
    writer.write(Hill().frame());
    writer.finish();
    EXPECT_EQ(touch::Clip(file.string()).facts().frames, 1);
    fs::create_directory(folder / "photos");
    std::ofstream(folder / "photos/holiday.jpg") << "sun";
    EXPECT_THROW(touch::Writer((folder / "photos").string(), scene, replaces), touch::Error);
    EXPECT_TRUE(fs::exists(folder / "photos/holiday.jpg"));
    EXPECT_THROW(touch::Writer((folder / "out.avi").string(), scene), touch::Error);
    EXPECT_THROW(touch::Writer((folder / "no/such/out.mkv").string(), scene), touch::Error);
    touch_writer none{};
    EXPECT_EQ(touch_writer_create((folder / "out.mkv").c_str(), {1}, nullptr, &none, nullptr), TOUCH_STALE);
}

TEST(Clips, OpenErrorsSayWhy) {
    const TemporaryFolder folder;
    std::string line;
    EXPECT_EQ(status_of_open((folder / "none.mkv").string(), &line), TOUCH_INPUT);
    EXPECT_NE(line.find("none.mkv"), std::string::npos) << line;
    std::ofstream(folder / "text.mkv") << "no clip";
    EXPECT_EQ(status_of_open((folder / "text.mkv").string(), &line), TOUCH_INPUT);
    EXPECT_EQ(status_of_open("", &line), TOUCH_USAGE);
    touch_clip_settings settings = touch::clip_settings();
    settings.fov_degrees = 200;
    EXPECT_EQ(status_of_open("any.png", &line, &settings), TOUCH_USAGE);
    EXPECT_NE(line.find("fov_degrees"), std::string::npos) << line;
    settings = touch::clip_settings();
    settings.fx_px = std::nan("");
    EXPECT_EQ(status_of_open("any.png", &line, &settings), TOUCH_USAGE);
    settings = touch::clip_settings();
    settings.preset = "no such camera";
    EXPECT_EQ(status_of_open("any.png", &line, &settings), TOUCH_INPUT) << "the file is looked for first";
}

TEST(Clips, GuessesNameTheMember) {
    const TemporaryFolder folder;
    write_hills(folder / "frames", 1);
    const std::string picture = (folder / "bare.png").string();
    fs::copy_file(folder / "frames/depth_000000.png", picture);
    touch::Clip guessed(picture);
    std::string all;
    for (const std::string& note : guessed.notes()) all += note + '\n';
    EXPECT_NE(all.find("fov_degrees"), std::string::npos) << all;
    touch_clip_settings settings = touch::clip_settings();
    settings.fx_px = settings.fy_px = 60;
    settings.metres_per_code = 0.001;
    settings.preset = "no such camera";
    std::string line;
    EXPECT_EQ(status_of_open(picture, &line, &settings), TOUCH_USAGE) << line;
    settings.preset = nullptr;
    const touch_scene_facts facts = touch::Clip(picture, settings).scene(TOUCH_FILTERS_STATED).facts();
    EXPECT_DOUBLE_EQ(facts.fx_px, 60);
    EXPECT_DOUBLE_EQ(facts.cx_px, (Hill::width - 1) / 2.0);
}

/// As the program's --depth, --near, --far, --channel and --dataset.
TEST(Clips, SettingsReachTheReader) {
    const TemporaryFolder folder;
    const std::string shares = (folder / "shares.pgm").string();
    std::ofstream(shares) << "P2 2 2 255 10 200 100 50";
    touch_clip_settings settings = touch::clip_settings();
    settings.near_m = 0.25;
    settings.far_m = 3;
    settings.depth_kind = TOUCH_RANGE;
    const touch_scene_facts facts = touch::Clip(shares, settings).scene(TOUCH_FILTERS_STATED).facts();
    EXPECT_EQ(facts.near_units, 0.25);
    EXPECT_EQ(facts.far_units, 3);
    EXPECT_EQ(facts.depth_kind, TOUCH_RANGE);
    const auto refuses = [&](auto member, auto value, const std::string& word) {
        touch_clip_settings wrong = touch::clip_settings();
        wrong.*member = value;
        std::string line;
        EXPECT_NE(status_of_open(shares, &line, &wrong), TOUCH_OK) << word;
        EXPECT_NE(line.find(word), std::string::npos) << line;
    };
    refuses(&touch_clip_settings::near_m, 0.5, "near_m");
    refuses(&touch_clip_settings::far_m, -1.0, "far_m");
    refuses(&touch_clip_settings::depth_kind, 2, "depth_kind");
    refuses(&touch_clip_settings::channel, "Z", "channel");
    refuses(&touch_clip_settings::dataset, "depth", "dataset");
}

TEST(Clips, StayInterrupted) {
    const TemporaryFolder folder;
    touch::Clip clip(make_globe(folder / "globe.mkv").string());
    ASSERT_TRUE(clip.next());
    clip.interrupt();
    touch_frameset none{};
    EXPECT_EQ(touch_clip_next(clip.get(), &none, nullptr), TOUCH_INTERRUPTED);
    EXPECT_EQ(touch_clip_seek(clip.get(), 0, nullptr), TOUCH_INTERRUPTED);
}

// As hostile_calls_test.cpp, of clips: files that are none, framesets of clips that are closed, writers in
// any order.

/// A program that does everything wrong with clips, sometimes.
class HostileReader : public SpoiledValues {
public:
    HostileReader(unsigned seed, const TemporaryFolder& folder) : SpoiledValues(seed), folder_(folder) {
        const touch_camera camera = Hill::camera();
        EXPECT_EQ(touch_scene_from_camera(&camera, &scene_, nullptr), TOUCH_OK);
        touch_writer writer{};
        EXPECT_EQ(touch_writer_create((folder / "hill.mkv").c_str(), scene_, &replacing(), &writer, nullptr),
                  TOUCH_OK);
        const touch_frame frame = hill_.frame();
        for (int n = 0; n < 3; ++n) EXPECT_EQ(touch_writer_write(writer, &frame, nullptr), TOUCH_OK);
        EXPECT_EQ(touch_writer_finish(writer, nullptr), TOUCH_OK);
    }
    ~HostileReader() {
        for (const touch_frameset frameset : framesets_) touch_frameset_release(frameset);
        for (const touch_writer writer : writers_) touch_writer_abandon(writer);
        for (const touch_clip clip : clips_) touch_clip_close(clip);
        touch_scene_destroy(scene_);
    }

    touch_status call() {
        using Call = touch_status (HostileReader::*)();
        static constexpr std::array<Call, 14> calls{
            &HostileReader::open,  &HostileReader::describe,     &HostileReader::note,
            &HostileReader::scene, &HostileReader::next,         &HostileReader::next,
            &HostileReader::next,  &HostileReader::frame,        &HostileReader::frame,
            &HostileReader::seek,  &HostileReader::create,       &HostileReader::write,
            &HostileReader::write, &HostileReader::end_something};
        return (this->*calls[upto(calls.size())])();
    }

private:
    static touch_writer_settings& replacing() {
        static touch_writer_settings settings = [] {
            touch_writer_settings made;
            touch_writer_settings_defaults(&made, sizeof made);
            made.overwrite = 1;
            return made;
        }();
        return settings;
    }

    touch_status open() {
        static constexpr const char* names[] = {"hill.mkv", "hill.mkv", "hill.mkv", "none.mkv", ""};
        touch_clip_settings settings;
        touch_clip_settings_defaults(&settings, sizeof settings);
        settings.struct_size = spoilt(settings.struct_size);
        settings.fx_px = rarely() ? spoilt(60.0) : 0;
        settings.fov_degrees = rarely() ? spoilt(60.0) : 0;
        settings.metres_per_code = rarely() ? spoilt(0.001) : 0;
        settings.preset = rarely() ? "kinect" : nullptr;
        const std::string path = folder_ / names[upto(std::size(names))];
        touch_clip clip{};
        return kept(touch_clip_open(or_null(path.c_str()), or_null(&settings), or_null(&clip), error()), clip,
                    clips_);
    }
    touch_status describe() {
        touch_clip_facts facts;
        facts.struct_size = spoilt(std::uint32_t{sizeof facts});
        std::int64_t time;
        if (rarely()) return touch_clip_time(one_of(clips_), spoilt(std::int64_t{2}), or_null(&time));
        return touch_clip_describe(one_of(clips_), or_null(&facts));
    }
    touch_status note() {
        std::array<char, 40> text;
        std::size_t length;
        return touch_clip_note(one_of(clips_), spoilt(static_cast<std::int32_t>(upto(3))),
                               or_null(text.data()), upto(41), or_null(&length));
    }
    touch_status scene() {
        touch_scene scene{};
        const touch_status status = touch_clip_scene(
            one_of(clips_), spoilt(static_cast<std::int32_t>(upto(2))), or_null(&scene), error());
        if (status == TOUCH_OK) touch_scene_destroy(scene);
        return status;
    }
    touch_status next() {
        touch_frameset frameset{};
        return kept(touch_clip_next(one_of(clips_), or_null(&frameset), error()), frameset, framesets_);
    }
    /// Every byte of a frameset is there, also when its clip has ended.
    touch_status frame() {
        touch_frame frame;
        touch_frame_defaults(&frame, sizeof frame);
        frame.struct_size = spoilt(frame.struct_size);
        const touch_status status = touch_frameset_frame(one_of(framesets_), or_null(&frame));
        if (status != TOUCH_OK) return status;
        std::array<float, Hill::width * Hill::height> metres;
        touch_scene_metres(rarely() ? touch_scene{random_()} : scene_, or_null(&frame.depth),
                           or_null(metres.data()),
                           spoilt(std::int64_t{4 * Hill::width}) % (4 * Hill::width + 1), error());
        return status;
    }
    touch_status seek() {
        return touch_clip_seek(one_of(clips_), spoilt(static_cast<std::int64_t>(upto(4))), error());
    }
    touch_status create() {
        static constexpr const char* names[] = {"hill.mkv", "out.mkv", "out.mp4", "out", "out.xyz", ""};
        touch_writer_settings settings = replacing();
        spoil(settings.struct_size, settings.overwrite);
        const std::int64_t instants[] = {spoilt(std::int64_t{0}), spoilt(std::int64_t{40'000'000})};
        if (rarely()) settings.times_ns = instants;
        if (rarely()) settings.times = upto(3);
        const std::string path = folder_ / names[upto(std::size(names))];
        touch_writer writer{};
        return kept(touch_writer_create(or_null(path.c_str()), rarely() ? touch_scene{random_()} : scene_,
                                        or_null(&settings), or_null(&writer), error()),
                    writer, writers_);
    }
    touch_status write() {
        touch_frame frame = hill_.frame();
        spoil(frame.struct_size, frame.number, frame.depth.width, frame.depth.stride_bytes,
              frame.depth.sample);
        if (rarely()) frame.height = frame.depth;
        return touch_writer_write(one_of(writers_), or_null(&frame), error());
    }
    /// The handle stays in the list, so that calls come to what has ended.
    touch_status end_something() {
        switch (upto(5)) {
            case 0:
                return touch_clip_close(one_of(clips_));
            case 1:
                return touch_frameset_release(one_of(framesets_));
            case 2:
                return touch_writer_finish(one_of(writers_), error());
            case 3:
                return touch_writer_abandon(one_of(writers_));
            default:
                return rarely() ? touch_clip_interrupt(one_of(clips_)) : touch_clip_close(one_of(clips_));
        }
    }

    const TemporaryFolder& folder_;
    const Hill hill_;
    touch_scene scene_{};
    std::vector<touch_clip> clips_;
    std::vector<touch_frameset> framesets_;
    std::vector<touch_writer> writers_;
};

TEST(HostileClips, EachCallGivesStatus) {
    HostileReader::Statuses seen{};
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const TemporaryFolder folder;
        HostileReader program(seed, folder);
        ASSERT_NO_FATAL_FAILURE(HostileReader::count_statuses(program, seen));
    }
    HostileReader::expect_seen(
        seen, {TOUCH_OK, TOUCH_USAGE, TOUCH_INPUT, TOUCH_STALE, TOUCH_END, TOUCH_INTERRUPTED}, 500);
}

}  // namespace
}  // namespace touchable::test
