// SPDX-License-Identifier: Apache-2.0
// The rules that all live sources share, by a source that has what the test gives it.

#include <chrono>
#include <deque>
#include <functional>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

using std::chrono::steady_clock;

/// A frame that a source counts as `count`, and has so many ns after the test's moment.
struct Given {
    std::uint32_t count = 0;
    std::int64_t after_ns = 0;
};

class GivenSource final : public LiveReader {
public:
    GivenSource() : LiveReader("/dev/given") {}
    /// Waiting ends with this; by default nothing comes any more, which a source says after so many waits.
    std::function<void()> on_wait = [] {};
    std::deque<Given> there;
    std::string end;  ///< why no more will come
    int waits = 0;
    const steady_clock::time_point zero = steady_clock::now();

    using LiveReader::damaged_;

private:
    MaybeTaken poll() override {
        while (has_begun() && there.size() > 1) there.pop_front();
        if (there.empty()) return end.empty() ? MaybeTaken(std::nullopt) : gone(end);
        const Given given = there.front();
        there.pop_front();
        return std::optional(Taken{given.count, steady_ns_of(zero) + given.after_ns, 7});
    }
    void wait() override {
        ++waits;
        on_wait();
    }
    std::optional<Error> nothing_came(Moment) const override {
        return waits < 3 ? std::nullopt : std::optional(input_error("waited in vain"));
    }
    void drain() override {}
};

class LiveSource : public ::testing::Test {
protected:
    /// Number and time of the next frame.
    std::pair<std::int64_t, std::int64_t> next() {
        const auto frame = source.next();
        EXPECT_EQ(message(frame), "");
        return frame && *frame ? std::pair((*frame)->number, (*frame)->time_ns)
                               : std::pair<std::int64_t, std::int64_t>(-1, -1);
    }
    std::pair<std::int64_t, std::int64_t> next(Given given) {
        source.there.push_back(given);
        return next();
    }
    GivenSource source;
};

TEST_F(LiveSource, CountsEachFrameBeforeIt) {
    source.there = {{5, 0}, {9, 0}, {9, 0}};
    for (std::int64_t n = 0; n < 3; ++n) EXPECT_EQ(next(), std::pair(n, n * ns_before_a_run));
    EXPECT_EQ(source.seek(4).error().kind, ErrorKind::usage);
    ASSERT_EQ(message(source.seek(1)), "");
    EXPECT_EQ(next({9, 0}), std::pair(std::int64_t{1}, ns_before_a_run));
    ASSERT_EQ(message(source.rewind()), "");
    ASSERT_EQ(message(source.begin(source.zero)), "");
    source.on_wait = [&] { source.there.push_back({2, 3'000}); };
    EXPECT_EQ(next({1, -1}), std::pair(std::int64_t{0}, std::int64_t{3'000}))
        << "it was taken before the run";
}

TEST_F(LiveSource, GivesNewestAndCountsGaps) {
    next({100, 0});
    ASSERT_EQ(message(source.begin(source.zero)), "");
    EXPECT_EQ(source.seek(0).error().kind, ErrorKind::usage);
    EXPECT_EQ(next({200, 5'000}), std::pair(std::int64_t{1}, std::int64_t{5'000}))
        << "no gap before its first";
    source.there = {{201, 6'000}, {202, 7'000}, {203, 8'000}};
    EXPECT_EQ(next(), std::pair(std::int64_t{4}, std::int64_t{8'000}));
    EXPECT_EQ(next({203, 9'000}).first, 5) << "a count that stands still";
    EXPECT_EQ(next({3, 10'000}).first, 6) << "a count that begins anew";
    EXPECT_EQ(next({3 + 1'000'000, 11'000}).first, 6 + 1'000'000);
    EXPECT_EQ(next({3 + 2'000'001, 12'000}).first, 7 + 1'000'000) << "another count";
    EXPECT_EQ(next({0xffff'ffff, 13'000}).first, 8 + 1'000'000);
    EXPECT_EQ(next({1, 14'000}).first, 10 + 1'000'000) << "a count of 32 bits";
    EXPECT_EQ(source.taken_before(4), 7);
    EXPECT_EQ(source.taken_before(3), 0);
}

TEST_F(LiveSource, TimesNeverGoBack) {
    ASSERT_EQ(message(source.begin(source.zero)), "");
    source.on_wait = [&] { source.there.push_back({2, 3'000}); };
    EXPECT_EQ(next({1, -1}).second, 3'000) << "it was taken before the run";
    EXPECT_EQ(next({3, 2'000}).second, 3'001);
    EXPECT_EQ(next({4, -9'000}).second, 3'002);
    EXPECT_EQ(next({5, 4'000}).second, 4'000);
}

TEST_F(LiveSource, EndsWithItsSource) {
    source.end = "was unplugged";
    EXPECT_EQ(message(source.next()), "the camera, /dev/given, was unplugged");
    GivenSource other;
    ASSERT_EQ(message(other.begin(other.zero)), "");
    other.end = "was unplugged";
    other.damaged_ = 2;
    for (int again = 0; again < 2; ++again) {
        const auto frame = must(other.next());
        EXPECT_FALSE(frame);
    }
    const auto remarks = other.remarks();
    ASSERT_EQ(remarks.size(), 2U);
    EXPECT_EQ(remarks[0], "2 of the camera's frames were damaged or cut short, and left out");
    EXPECT_TRUE(remarks[1].starts_with("the camera, /dev/given, was unplugged after ")) << remarks[1];
    EXPECT_TRUE(remarks[1].ends_with(" s; its last frame stands still")) << remarks[1];
}

TEST_F(LiveSource, WaitsWhileItRuns) {
    EXPECT_EQ(message(source.next()), "waited in vain");
    EXPECT_EQ(source.waits, 3);
    ASSERT_EQ(message(source.begin(source.zero)), "");
    source.on_wait = [&] {
        if (source.waits == 100) source.there.push_back({1, 5});
    };
    EXPECT_EQ(next().second, 5);
}

TEST_F(LiveSource, StopsAndBeginsAgain) {
    ASSERT_EQ(message(source.begin(source.zero)), "");
    EXPECT_EQ(next({1, 2'000'000}).first, 0);
    std::stop_source given_up;
    source.on_wait = [&] { given_up.request_stop(); };
    for (int again = 0; again < 2; ++again) {
        const auto told = work_until(given_up.get_token(), [&] { return source.next(); });
        EXPECT_TRUE(is_refused(told, "", ErrorKind::interrupted));
        EXPECT_EQ(message(told), "the camera was told to stop before it gave frame 1");
    }
    EXPECT_EQ(source.waits, 1);
    ASSERT_EQ(message(source.begin(source.zero)), "");
    EXPECT_EQ(next({9, 3'000'000}), std::pair(std::int64_t{1}, std::int64_t{3'000'000}))
        << "what came between is no gap";
}

// A recording that behaves like a camera. No test depends on a deadline.

using std::chrono::milliseconds;

constexpr int recorded_frames = 24;
const FrameRate fast{1000, 1};

std::vector<CameraDelivery::Frame> deliveries(const CameraDelivery& settings, int count) {
    std::vector<CameraDelivery::Frame> all;
    CameraDelivery::Frame last;
    for (int k = 0; k < count; ++k) all.push_back(last = settings.after(last, *settings.rate));
    return all;
}

TEST(CameraDeliveries, ArriveInOrderWithinJitter) {
    const CameraDelivery settings{.rate = fast, .jitter_ns = 3'000'000};
    std::int64_t before = 0, late = 0;
    for (const CameraDelivery::Frame& frame : deliveries(settings, 1000)) {
        const std::int64_t after_ns = frame.at_ns - fast.time_ns(frame.number);
        EXPECT_GE(after_ns, 0);
        EXPECT_LE(after_ns, settings.jitter_ns);
        EXPECT_GE(frame.at_ns, before);
        before = frame.at_ns;
        late += after_ns;
    }
    EXPECT_NEAR(static_cast<double>(late), 1000 * 2e6, 1000 * 0.4e6) << "none overtakes, so above 1.5 ms";
}

TEST(CameraDeliveries, DropTheirShare) {
    for (const double drop : {0.0, 0.2, 0.9}) {
        const auto all = deliveries({.rate = fast, .drop = drop}, 2000);
        EXPECT_NEAR(2000.0 / static_cast<double>(all.back().number + 1), 1 - drop, 0.03);
    }
}

/// The same everywhere and every time.
TEST(CameraDeliveries, DependOnFrameNumberAlone) {
    std::vector<std::int64_t> numbers;
    for (const CameraDelivery::Frame& frame : deliveries({.rate = fast, .drop = 0.5}, 8))
        numbers.push_back(frame.number);
    EXPECT_EQ(numbers, (std::vector<std::int64_t>{1, 3, 4, 6, 8, 12, 16, 20}));
    const CameraDelivery settings{.rate = fast, .jitter_ns = 1'000'000, .drop = 0.5};
    const CameraDelivery::Frame alone = settings.after({numbers[4], 0}, fast);
    EXPECT_EQ(alone.number, numbers[5]);
    EXPECT_EQ(alone.at_ns, deliveries(settings, 6)[5].at_ns);
}

TEST(CameraDeliveries, PauseDuringStall) {
    const CameraDelivery pause{.rate = fast, .stall_ns = 5'000'000, .resume_ns = 9'500'000};
    const auto all = deliveries(pause, 12);
    for (const int frame : {0, 4, 10, 11})
        EXPECT_EQ(all[static_cast<std::size_t>(frame)].at_ns, frame * 1'000'000);
    for (std::size_t frame = 5; frame < 10; ++frame) EXPECT_EQ(all[frame].at_ns, 9'500'000);
    const auto ever = deliveries({.rate = fast, .stall_ns = 5'000'000}, 6);
    EXPECT_EQ(ever[4].at_ns, 4'000'000);
    EXPECT_EQ(ever[5].at_ns, CameraDelivery::never);
}

class ReplayCamera : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(message(write_clip(file_, small_scene(16, 12), recorded_frames, all_planes)), "");
        recorded_ = must(read_clip(file_));
    }
    std::unique_ptr<ClipReader> open(const CameraDelivery& delivery) const {
        return make_replay_camera(must(open_clip(file_)), delivery);
    }
    /// The recording's frame of that number, at the camera's time.
    void expect_true(RawFrame frame, const FrameRate& rate) const {
        EXPECT_EQ(frame.time_ns, rate.time_ns(frame.number));
        const RawFrame& recorded = recorded_.at(static_cast<std::size_t>(frame.number));
        frame.time_ns = recorded.time_ns;
        EXPECT_TRUE(same_frame(frame, recorded)) << frame.number;
    }

    const TemporaryFolder folder_;
    const std::filesystem::path file_ = folder_ / "recording.mkv";
    std::vector<RawFrame> recorded_;
};

TEST_F(ReplayCamera, IsClipBeforeItsRun) {
    const FrameRate slow{1, 100};
    const auto camera = open({.rate = slow, .drop = 0.5, .stall_ns = 0});
    EXPECT_TRUE(camera->is_live());
    EXPECT_EQ(camera->scene().rate.num, slow.num);
    EXPECT_EQ(camera->scene().rate.den, slow.den);
    EXPECT_EQ(camera->scene().interpolation, FrameInterpolation::hold);
    const auto frames = must(read_all(*camera));
    ASSERT_EQ(frames.size(), std::size_t{recorded_frames});
    for (const RawFrame& frame : frames) expect_true(frame, slow);
    ASSERT_EQ(message(camera->seek(7)), "");
    EXPECT_EQ((*camera->next())->number, 7);
    EXPECT_EQ(open({})->scene().rate.num, small_scene(16, 12).rate.num) << "the recording's own";
}

TEST_F(ReplayCamera, GivesFramesAtTheirTimes) {
    const CameraDelivery delivery{.rate = fast, .jitter_ns = 2'000'000, .drop = 0.2};
    const auto camera = open(delivery);
    for (int n = 0; n < 3; ++n) ASSERT_EQ((*camera->next())->number, n);
    const auto zero = steady_clock::now();
    ASSERT_EQ(message(camera->begin(zero)), "");
    CameraDelivery::Frame expected{2, 0};
    while (true) {
        const auto frame = camera->next();
        const auto now = steady_clock::now();
        ASSERT_EQ(message(frame), "");
        if (!*frame) break;
        // A slow reader misses some.
        do expected = delivery.after(expected, fast);
        while (expected.number < (*frame)->number);
        EXPECT_EQ(expected.number, (*frame)->number);
        EXPECT_GE(now, zero + std::chrono::nanoseconds(expected.at_ns));
        expect_true(**frame, fast);
    }
    EXPECT_GT(expected.number, 2);
    EXPECT_EQ(camera->seek(0).error().kind, ErrorKind::usage);
}

TEST_F(ReplayCamera, GivesNewestFrameWhenLate) {
    const auto camera = open({.rate = fast});
    ASSERT_EQ((*camera->next())->number, 0);
    ASSERT_EQ(message(camera->begin(steady_clock::now() - std::chrono::hours(1))), "");
    const auto frame = must(camera->next());
    expect_true(*frame, fast);
    EXPECT_EQ(frame->number, recorded_frames - 1);
    EXPECT_FALSE((*camera->next()).has_value());
}

TEST_F(ReplayCamera, StopsDuringStall) {
    for (const auto& delivery : {CameraDelivery{.stall_ns = 0}, CameraDelivery{.rate = FrameRate{1, 1000}}}) {
        const auto camera = open(delivery);
        ASSERT_EQ((*camera->next())->number, 0);
        ASSERT_EQ(message(camera->begin(steady_clock::now())), "");
        steady_clock::time_point told;
        std::stop_source given_up;
        const StopScope until(given_up.get_token());
        std::thread teller([&] {
            std::this_thread::sleep_for(milliseconds(5));
            told = steady_clock::now();
            given_up.request_stop();
        });
        const auto frame = camera->next();
        const auto ended = steady_clock::now();
        teller.join();
        ASSERT_FALSE(frame);
        EXPECT_EQ(frame.error().kind, ErrorKind::interrupted);
        EXPECT_EQ(frame.error().message, "the camera was told to stop before it gave frame 1");
        EXPECT_LT(ended - told, std::chrono::seconds(60))
            << "20 ms where nothing else runs; the frame comes in 1000 s";
        EXPECT_EQ(camera->next().error().kind, ErrorKind::interrupted);
    }
}

// Clips as folders of pictures.

namespace fs = std::filesystem;

std::vector<std::string> names_of(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// Frames of which some planes begin to change with a later frame, or never do.
std::vector<RawFrame> changing_frames(const Scene& scene) {
    std::vector<RawFrame> frames;
    const RawFrame first = test_frame(scene, 0, all_planes), later = test_frame(scene, 9, all_planes);
    for (int n = 0; n < 4; ++n) {
        RawFrame frame = test_frame(scene, n, all_planes);
        frame.haptic = first.haptic;
        frame.height = n < 2 ? first.height : later.height;
        struct Both {
            std::shared_ptr<const void> a, b, c;
        };
        frame.storage = std::make_shared<Both>(Both{frame.storage, first.storage, later.storage});
        frames.push_back(std::move(frame));
    }
    return frames;
}

Result<void> write_pictures(const fs::path& folder, const Scene& scene, const std::vector<RawFrame>& frames,
                            Existing existing = Existing::keep) {
    return write_all(create_image_folder(folder, scene, existing), frames);
}

TEST(ImageFolderWriter, StoresStillsOnce) {
    for (const int bits : {8, 12, 16}) {
        const TemporaryFolder folder;
        Scene scene = small_scene(23, 14, bits);
        scene.rate = {30000, 1001};
        scene.name = "two words";
        const std::vector<RawFrame> frames = changing_frames(scene);
        ASSERT_EQ(message(write_pictures(folder / "clip", scene, frames)), "");
        EXPECT_EQ(names_of(folder.path()), std::vector<std::string>{"clip"});
        EXPECT_EQ(names_of(folder / "clip"),
                  (std::vector<std::string>{"colour_000000.png", "colour_000001.png", "colour_000002.png",
                                            "colour_000003.png", "depth_000000.png", "depth_000001.png",
                                            "depth_000002.png", "depth_000003.png", "haptic.png",
                                            "height_000000.png", "height_000001.png", "height_000002.png",
                                            "height_000003.png", "scene.json"}));
        EXPECT_TRUE(same_frames(must(read_clip(folder / "clip")), frames));
        auto again = must(read_scene_file(folder / "clip/scene.json"));
        EXPECT_EQ(again.scene.folder->count, 4);
        again.scene.folder.reset();
        EXPECT_EQ(scene_to_json(again), scene_to_json(scene));
    }
}

TEST(ImageFolderWriter, LeavesNothingWithoutFinish) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(9, 8);
    {
        auto writer = must(create_image_folder(folder / "clip", scene, Existing::keep));
        ASSERT_EQ(message(writer->write(test_frame(scene, 0, {}))), "");
        const auto place = must(writer->complete());
        const auto frames = must(read_clip(place));
        EXPECT_EQ(frames.size(), 1U);
        EXPECT_FALSE(fs::exists(folder / "clip"));
    }
    EXPECT_TRUE(names_of(folder.path()).empty());
}

TEST(ImageFolderWriter, ReplacesOnlyItsOwnFolders) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(9, 8);
    const std::vector<RawFrame> two{test_frame(scene, 0, {}), test_frame(scene, 1, {})}, one{two.front()};
    fs::create_directory(folder / "clip");  // an empty one is as good as none
    ASSERT_EQ(message(write_pictures(folder / "clip", scene, two)), "");
    EXPECT_NE(message(write_pictures(folder / "clip", scene, one)), "");
    EXPECT_EQ(read_clip(folder / "clip")->size(), 2U);
    EXPECT_TRUE(is_image_folder(folder / "clip"));
    ASSERT_EQ(message(write_pictures(folder / "clip", scene, one, Existing::replace)), "");
    EXPECT_EQ(names_of(folder / "clip"), (std::vector<std::string>{"depth_000000.png", "scene.json"}));
    for (const char* name :
         {"depth_1.png", "notes.txt", "depth_00000x.png", "depth.jpg", "depth_000000.png.bak"}) {
        write_bytes(folder / ("clip/" + std::string(name)), "x");
        EXPECT_FALSE(is_image_folder(folder / "clip")) << name;
        EXPECT_NE(message(write_pictures(folder / "clip", scene, two, Existing::replace)), "");
        fs::remove(folder / ("clip/" + std::string(name)));
    }
    fs::create_directory(folder / "clip/depth.png");
    EXPECT_FALSE(is_image_folder(folder / "clip"));
    fs::remove(folder / "clip/depth.png");
    // By a link, the folder that it leads to.
    fs::create_directory_symlink(folder / "clip", folder / "link");
    ASSERT_EQ(message(write_pictures(folder / "link", scene, two, Existing::replace)), "");
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_EQ(read_clip(folder / "clip")->size(), 2U);
    EXPECT_EQ(names_of(folder.path()), (std::vector<std::string>{"clip", "link"}));
    EXPECT_TRUE(is_refused(write_pictures(folder / "none/clip", scene, one), "there is no folder"));
}

TEST(ImageFolderWriter, IndexesHapticOfFewMaterials) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(40, 30);
    std::vector<RawFrame> frames{test_frame(scene, 0, all_planes), test_frame(scene, 1, all_planes),
                                 test_frame(scene, 2, all_planes)};
    Samples materials(3 * 40 * 30);  // the middle picture has more than 256 colours, these have three
    for (std::size_t k = 0; k < materials.size(); ++k)
        materials[k] = static_cast<std::uint8_t>(k % 3 * 40 + k / 3 / 40 % 3);
    for (const std::size_t n : {std::size_t{0}, std::size_t{2}})
        frames[n].haptic = frames[n].colour = {materials.data(), 3 * 40, 40, 30, 1, 3};
    ASSERT_EQ(message(write_pictures(folder / "clip", scene, frames)), "");
    const auto format = [&](const char* name) {
        const auto stored = read_stored_image(folder / (std::string("clip/") + name));
        return stored ? stored->pixel_format : stored.error().message;
    };
    EXPECT_EQ(format("haptic_000000.png"), "pal8");
    EXPECT_EQ(format("haptic_000001.png"), "rgb24");
    EXPECT_EQ(format("haptic_000002.png"), "pal8");
    EXPECT_EQ(format("colour_000000.png"), "rgb24") << "as every program reads it";
    EXPECT_TRUE(same_frames(must(read_clip(folder / "clip")), frames));
}

TEST(ImageFolderWriter, WritesStillWithSceneFile) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(9, 8, 16);
    const RawFrame frame = test_frame(scene, 0, {false, true, true});
    ASSERT_EQ(message(write_all(create_still(folder / "one.png", scene, Existing::keep), {frame})), "");
    EXPECT_EQ(names_of(folder.path()),
              (std::vector<std::string>{"one.json", "one.png", "one_haptic.png", "one_height.png"}));
    const auto read = must(read_clip(folder / "one.json"));
    EXPECT_TRUE(same_frame(read.front(), frame));
    // Where one of its files has come to be there meanwhile, none of the others stays.
    const TemporaryFolder taken;
    auto second = create_still(taken / "one.png", scene, Existing::keep);
    ASSERT_EQ(message((*second)->write(frame)), "");
    write_bytes(taken / "one_height.png", "another's");
    EXPECT_NE(message((*second)->finish()), "");
    second->reset();
    EXPECT_EQ(names_of(taken.path()), std::vector<std::string>{"one_height.png"});
}

}  // namespace
}  // namespace touchable::test
