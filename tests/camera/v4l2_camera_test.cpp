// SPDX-License-Identifier: Apache-2.0
// A camera that is plugged in, over a fake of the kernel's side. No test depends on a deadline, and none has
// met a camera.

#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/camera/camera.hpp"
#include "engine/camera/v4l2_camera.hpp"
#include "engine/clip/readers.hpp"
#include "engine/picture/image.hpp"
#include "tests/camera/fake_video.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

using std::chrono::steady_clock;

constexpr int w = 20, h = 12;
const std::string node = "/dev/video7";
const SourceDescription millimetres{{}, 60, 0.001, {}, {}, {}};

std::string notes_of(const ClipReader& camera) {
    std::string notes;
    for (const std::string& note : clip_notes(camera)) notes += note + '\n';
    return notes;
}

/// A program leaves nothing open, and does nothing that it may not.
class VideoTest : public ::testing::Test {
protected:
    void TearDown() override {
        EXPECT_EQ(video->misuse(), std::vector<std::string>());
        EXPECT_EQ(video->left_over(), std::vector<std::string>());
    }
    const std::shared_ptr<FakeVideo> video = std::make_shared<FakeVideo>();
};

class V4l2Camera : public VideoTest {
protected:
    FakeNode& add(std::uint32_t code = V4L2_PIX_FMT_Z16) { return add_depth_node(*video, node, w, h, code); }
    Result<std::unique_ptr<ClipReader>> open(const SourceDescription& known = millimetres) const {
        V4l2Choice choice{node};
        choice.system = video;
        return open_v4l2_camera(choice, known);
    }
    /// A camera that gave so many frames.
    std::unique_ptr<ClipReader> opened(int given = 0) const {
        auto camera = must(open());
        expect_numbers(*camera, 0, given);
        return camera;
    }
    static void expect_numbers(ClipReader& camera, int from, int end, int step = 1) {
        for (int n = from; n < end; n += step) EXPECT_EQ(next_of(camera).number, n);
    }
    /// A little ago, so that what is taken now is of the run: drivers count in microseconds.
    static void begin(ClipReader& camera) {
        EXPECT_EQ(message(camera.begin(steady_clock::now() - std::chrono::milliseconds(1))), "");
    }
    /// A running camera that gave frames 0 and 1.
    std::unique_ptr<ClipReader> running() const {
        auto camera = opened(2);
        begin(*camera);
        return camera;
    }
    /// Which picture a frame is, as its first pixel tells; then all others have to.
    static std::uint32_t picture_in(const RawFrame& frame) {
        const std::uint32_t first = frame.depth.sample(0, 0) - 500u;
        std::uint32_t number = 0;
        while (number < 2000 && 7 * number % 2000 != first) ++number;
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x) EXPECT_EQ(frame.depth.sample(x, y), painted_depth(x, y, number));
        return number;
    }
};

TEST_F(V4l2Camera, ReadsEveryFormatExactly) {
    for (const std::uint32_t code : {V4L2_PIX_FMT_Z16, V4L2_PIX_FMT_Y16, V4L2_PIX_FMT_Y16_BE})
        for (const std::uint32_t padding : {0u, 26u}) {
            add(code).row_padding = padding;
            const auto camera = opened();
            EXPECT_TRUE(camera->is_live());
            EXPECT_EQ(camera->scene().width, w);
            EXPECT_EQ(camera->scene().depth_bits, 16);
            EXPECT_EQ(camera->scene().interpolation, FrameInterpolation::hold);
            const std::uint32_t first = picture_in(next_of(*camera));
            EXPECT_EQ(first, 8u) << "behind those that say what depth means";
            begin(*camera);
            for (int n = 1; n < 5; ++n) {
                const RawFrame frame = next_of(*camera);
                EXPECT_EQ(frame.number, n);
                EXPECT_EQ(picture_in(frame), first + static_cast<std::uint32_t>(n));
            }
        }
}

/// By its driver's clock, from the run's beginning on.
TEST_F(V4l2Camera, StampsFramesWithDriverTime) {
    std::int64_t zero_ns = 0;
    add().stamp = [&](std::uint32_t n) {
        const std::int64_t late_ns = 1'000'000 * static_cast<std::int64_t>(n);
        return zero_ns == 0 ? steady_now_ns() : zero_ns + late_ns;
    };
    const auto camera = opened(2);
    const auto zero = steady_clock::now() - std::chrono::seconds(1);
    zero_ns = steady_ns_of(zero) / 1000 * 1000;
    const std::int64_t rounded_ns = zero_ns - steady_ns_of(zero);
    ASSERT_EQ(message(camera->begin(zero)), "");
    for (int n = 2; n < 6; ++n) EXPECT_EQ(next_of(*camera).time_ns, (n + 8) * 1'000'000 + rounded_ns);
}

TEST_F(V4l2Camera, FallsBackToArrivalTime) {
    add().timestamps = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
    const auto since = steady_clock::now();
    const auto camera = running();
    const std::string notes = notes_of(*camera);
    EXPECT_TRUE(has_words(notes, "count from their arrival"));
    std::int64_t before = 0;
    for (int n = 2; n < 6; ++n) {
        const RawFrame frame = next_of(*camera);
        EXPECT_EQ(frame.number, n);
        EXPECT_GT(frame.time_ns, before);
        before = frame.time_ns;
    }
    const std::chrono::nanoseconds gone_by = steady_clock::now() - since;
    EXPECT_LE(before, gone_by.count() + 1'000'000) << "the run began a millisecond before it was asked for";
}

TEST_F(V4l2Camera, CountsBadFramesAsGaps) {
    add().fate = [](std::uint32_t n) {
        if (n == 12) return Fate::lost;
        if (n == 14) return Fate::damaged;
        if (n == 16) return Fate::cut;
        return n == 18 ? Fate::io_error : Fate::good;
    };
    const auto camera = running();
    for (const std::uint32_t picture : {10u, 11u, 13u, 15u, 17u, 19u, 20u}) {
        const RawFrame frame = next_of(*camera);
        EXPECT_EQ(picture_in(frame), picture);
        EXPECT_EQ(frame.number, picture - 8);
    }
    ASSERT_EQ(camera->remarks().size(), 1u);
    EXPECT_EQ(camera->remarks()[0], "3 of the camera's frames were damaged or cut short, and left out");
}

TEST_F(V4l2Camera, ToleratesOccasionalFaults) {
    add().fate = [](std::uint32_t n) { return n > 10 && n % 2 == 1 ? Fate::io_error : Fate::good; };
    const auto camera = running();
    expect_numbers(*camera, 2, 400, 2);
}

TEST_F(V4l2Camera, EndsAfterHundredFaults) {
    for (const std::uint32_t last : {12u + 98, 12u + 99}) {
        add().fate = [=](std::uint32_t n) { return n >= 12 && n <= last ? Fate::io_error : Fate::good; };
        const auto camera = running();
        expect_numbers(*camera, 2, 4);
        const auto frame = must(camera->next());
        EXPECT_EQ(frame.has_value(), last == 12 + 98);
        std::string remarks;
        for (const std::string& remark : camera->remarks()) remarks += remark + '\n';
        EXPECT_EQ(remarks.find("stopped") != std::string::npos, last == 12 + 99) << remarks;
    }
}

TEST_F(V4l2Camera, GivesNewestFrameWhenLate) {
    add();
    const auto camera = running();
    const std::uint32_t first = picture_in(next_of(*camera));
    video->take(node, 3);
    const RawFrame frame = next_of(*camera);
    EXPECT_EQ(picture_in(frame), first + 3);
    EXPECT_EQ(frame.number, 2 + 3);
}

/// Pictures of before the run may have waited since.
TEST_F(V4l2Camera, DropsWaitingFramesAtBegin) {
    add();
    const auto camera = opened(2);
    video->take(node, 4);
    begin(*camera);
    const RawFrame frame = next_of(*camera);
    EXPECT_EQ(frame.number, 2) << "the next, and no gap";
    EXPECT_EQ(picture_in(frame), 8u + 2 + 4);
    EXPECT_EQ(camera->seek(0).error().kind, ErrorKind::usage);
}

TEST_F(V4l2Camera, StandsStillWhenUnplugged) {
    add().fate = [](std::uint32_t n) { return n == 12 ? Fate::unplugged : Fate::good; };
    const auto camera = running();
    expect_numbers(*camera, 2, 4);
    for (int again = 0; again < 2; ++again) {
        const auto frame = must(camera->next());
        EXPECT_FALSE(frame.has_value());
    }
    ASSERT_EQ(camera->remarks().size(), 1u);
    EXPECT_TRUE(camera->remarks()[0].starts_with("the camera, /dev/video7, was unplugged after 0."));
    EXPECT_TRUE(camera->remarks()[0].ends_with("s; its last frame stands still"));
}

TEST_F(V4l2Camera, EndsOnNamelessError) {
    add().fate = [](std::uint32_t n) { return n == 12 ? Fate::nameless_error : Fate::good; };
    const auto camera = running();
    for (int n = 2; n < 4; ++n) next_of(*camera);
    EXPECT_FALSE(camera->next()->has_value());
    EXPECT_TRUE(has_words(camera->remarks().at(0), "stopped"));
}

TEST_F(V4l2Camera, StopsDuringStall) {
    add().fate = [](std::uint32_t n) { return n == 12 ? Fate::stalled : Fate::good; };
    const auto camera = running();
    for (int n = 2; n < 4; ++n) next_of(*camera);
    std::stop_source given_up;
    const StopScope until(given_up.get_token());
    std::thread teller([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        given_up.request_stop();
    });
    const auto frame = camera->next();
    teller.join();
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().kind, ErrorKind::interrupted);
    EXPECT_EQ(frame.error().message, "the camera was told to stop before it gave frame 4");
    EXPECT_EQ(camera->next().error().kind, ErrorKind::interrupted);
}

TEST_F(V4l2Camera, SurvivesSignals) {
    add();
    video->set_signals(true);
    const auto camera = running();
    expect_numbers(*camera, 2, 6);
}

TEST_F(V4l2Camera, WorksWithFewerBuffers) {
    for (const std::uint32_t buffers : {1u, 2u, 7u}) {
        add().buffers = buffers;
        const auto camera = running();
        for (int n = 2; n < 6; ++n)
            EXPECT_EQ(picture_in(next_of(*camera)), static_cast<std::uint32_t>(n) + 8);
    }
}

TEST_F(V4l2Camera, SaysWhatWouldHelp) {
    const auto expect = [&](const std::string& fragment) {
        const auto camera = open();
        ASSERT_FALSE(camera) << fragment;
        const std::string& why = camera.error().message;
        EXPECT_TRUE(has_words(why, fragment));
        EXPECT_EQ(why.find('\n'), std::string::npos) << why;
        EXPECT_TRUE(why.starts_with(node)) << why;
        EXPECT_EQ(video->left_over(), std::vector<std::string>());
    };
    expect("does not exist; touchable cameras lists");
    for (const auto& [request, failure, fragment] : std::vector<std::tuple<unsigned long, int, const char*>>{
             {0, EACCES, "use sudo usermod -aG video $USER"},
             {0, ENODEV, "is it plugged in?"},
             {VIDIOC_QUERYCAP, ENOTTY, "is no camera's node"},
             {VIDIOC_S_FMT, EBUSY, "another program has the camera"},
             {VIDIOC_REQBUFS, EBUSY, "another program has the camera"},
             {VIDIOC_STREAMON, ENOSPC, "the USB bus has no room"},
             {VIDIOC_STREAMON, EIO, "cannot be used"},
             {VIDIOC_DQBUF, ENODEV, "was unplugged"}}) {
        FakeNode& camera = add();
        camera.refusals[request] = failure;
        if (request == VIDIOC_DQBUF) {
            EXPECT_TRUE(is_refused(open(), fragment));
            continue;
        }
        expect(fragment);
    }
    add().settles_for = FakeMode{16, 8};
    expect("gives Z16 of 16x8 where Z16 of 20x12 was asked for");
    add().buffer_bytes = 100;
    expect("buffers of 100 bytes; a picture has 480");
    add().formats[0].code = V4L2_PIX_FMT_YUYV;
    expect("gives no depth there (YUYV); what can be touched is Z16 or Y16");
    add().capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
    expect("gives no pictures there");
    add().paint = [](std::uint32_t) { return std::vector<std::uint8_t>(w * h * 2); };
    expect("has no depth: all values are 0");
}

TEST_F(V4l2Camera, ChoosesWishedMode) {
    FakeNode& made = add();
    made.paint = nullptr;
    made.formats = {{V4L2_PIX_FMT_YUYV, {{1920, 1080}}},
                    {V4L2_PIX_FMT_Y16, {{640, 480}}},
                    {V4L2_PIX_FMT_Z16,
                     {{480, 270, {{1, 90}, {1, 30}}},
                      {848, 480, {{1, 30}, {1, 6}}},
                      {1280, 720, {{1, 6}}},
                      {1920, 1080}}}};
    const NodeFacts facts = *look_at_node(*video, node);
    ASSERT_EQ(facts.formats.size(), 3u);
    const NodeFormat& depth = facts.formats[2];
    const auto chosen = [&](const ModeWish& wish) {
        const auto mode = choose_mode(depth, wish);
        return mode ? mode_text(*mode) : mode.error().message;
    };
    EXPECT_EQ(chosen({}), "848x480 at 30 frames/s") << "the largest at 30, not larger than 1280x720";
    EXPECT_EQ(chosen({1280, 720}), "1280x720 at 6 frames/s");
    EXPECT_EQ(chosen({480, 270, 60.0}), "480x270 at 90 frames/s") << "or 30: as far away";
    EXPECT_EQ(chosen({480, 270}), "480x270 at 30 frames/s");
    EXPECT_EQ(chosen({0, 0, 90.0}), "480x270 at 90 frames/s");
    EXPECT_EQ(chosen({640, 480}),
              "offers no Z16 of 640x480 (size=); there are 480x270, 848x480, 1280x720, 1920x1080");
    EXPECT_EQ(format_text(V4L2_PIX_FMT_Y16_BE), "Y16 (big-endian)");
}

TEST_F(V4l2Camera, NotesItsAssumptions) {
    add().card = "Intel(R) RealSense(TM) Depth Ca";
    const auto camera = must(open(SourceDescription{}));
    const Scene& scene = camera->scene();
    EXPECT_EQ(scene.depth.scale, 0.001);
    EXPECT_EQ(scene.metres_per_unit, 1);
    EXPECT_NEAR(scene.camera.fx, 0.5 * w / std::tan(79.0 / 2 / 180 * 3.14159265358979), 1e-9);
    // The last thousandth of 8 pictures of 20x12 pixels is one pixel and a part: the second deepest.
    EXPECT_NEAR(scene.depth.far, 2 * 0.001 * (500 + (w - 1) + 3 * (h - 1) + 7 * 7 - 1), 1e-9);
    const std::string notes = notes_of(*camera);
    for (const char* fragment : {"RealSense(TM) Depth Ca: Z16, 20x12 at 30 frames/s",
                                 "as preset realsense has it", "79 degrees", "deeper than 1.2 m is no depth"})
        EXPECT_TRUE(has_words(notes, fragment)) << fragment << " is not in\n" << notes;
}

// docs/streaming.md: a code of Z16 is a millimetre by default, even where codes are as large
// as those of 1/5000 m, which pictures of files would be taken for.
TEST_F(V4l2Camera, AssumesUnitByFormat) {
    for (const auto& [code, preset, scale] :
         std::vector<std::tuple<std::uint32_t, std::string, double>>{{V4L2_PIX_FMT_Z16, "", 0.001},
                                                                     {V4L2_PIX_FMT_Z16, "tum", 1.0 / 5000},
                                                                     {V4L2_PIX_FMT_Y16, "", 1.0 / 5000}}) {
        add(code).paint = [](std::uint32_t) {
            std::vector<std::uint8_t> codes;
            for (int k = 0; k < w * h; ++k) codes.insert(codes.end(), {0x20, 0x4e});  // 20000
            return codes;
        };
        const auto camera = must(open(stated(&SourceDescription::preset, preset)));
        EXPECT_EQ(camera->scene().depth.scale, scale);
        const std::string notes = notes_of(*camera);
        EXPECT_EQ(notes.find("a code is 1 mm, as most cameras of Z16 have it") != std::string::npos,
                  scale == 0.001)
            << notes;
        EXPECT_EQ(notes.find("Y16 is grey of 16 bits") != std::string::npos, code == V4L2_PIX_FMT_Y16);
    }
}

// By the first that sees most, 8 of them; two see as much. The remark names the median that was found.
TEST_F(V4l2Camera, IsJudgedByFullestPicture) {
    add().paint = [](std::uint32_t n) {
        const auto code = static_cast<std::uint8_t>(n + 10);
        std::vector<std::uint8_t> codes;
        for (int k = 0; k < w * h; ++k) {
            const bool seen = n == 4 || n == 5 || (n > 0 && k % 4 != 0);  // the first is dark
            codes.insert(codes.end(), {seen ? code : std::uint8_t{0}, 0});
        }
        return codes;
    };
    SourceDescription known = millimetres;
    known.metres_per_code = 100;
    const auto camera = must(open(known));
    const std::string notes = notes_of(*camera);
    EXPECT_TRUE(has_words(notes, "the median depth is 1500 m")) << "picture 5\n" << notes;
}

TEST_F(V4l2Camera, KeepsMemoryConstant) {
    add();
    const auto camera = running();
    for (int k = 0; k < 50; ++k) next_of(*camera);
    const auto before = mallinfo2().uordblks;
    for (int k = 0; k < 500; ++k) next_of(*camera);
    EXPECT_LE(mallinfo2().uordblks, before + 4096);
}

// The colour camera beside one of depth.

constexpr int cw = 16, ch = 8;
const std::string depth_node = "/dev/video0", colour_node = "/dev/video2";

using Bytes = std::vector<std::uint8_t>;

/// Red tells the number of the picture, green and blue the place.
Bytes rgb_of(std::uint32_t number, bool bgr) {
    Bytes bytes;
    for (int y = 0; y < ch; ++y)
        for (int x = 0; x < cw; ++x) {
            const std::uint8_t rgb[] = {static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(10 * x),
                                        static_cast<std::uint8_t>(20 * y)};
            for (int k = 0; k < 3; ++k) bytes.push_back(rgb[bgr ? 2 - k : k]);
        }
    return bytes;
}

/// Grey of 16 + 219/255 of this, as cameras write it, without colour.
constexpr int grey = 100;
constexpr auto luma = static_cast<std::uint8_t>(16 + (grey * 219 + 127) / 255);

class CameraColour : public VideoTest {
protected:
    CameraColour() { add_depth_node(*video, depth_node, cw, ch); }
    FakeNode& add(std::uint32_t code, std::function<Bytes(std::uint32_t)> paint) {
        FakeNode& made = video->add(colour_node);
        made.formats = {{code, {{64, 48}, {cw, ch}}}};
        made.paint = std::move(paint);
        return made;
    }
    Result<std::unique_ptr<ClipReader>> open() const {
        V4l2Choice choice{depth_node};
        choice.colour = colour_node;
        choice.system = video;
        return open_v4l2_camera(choice, SourceDescription{{}, 60, 0.001, {}, {}, {}});
    }
};

TEST_F(CameraColour, ComesInEveryFormat) {
    const auto uniform = [](Bytes pair, std::size_t bytes) {
        Bytes all;
        while (all.size() < bytes) all.insert(all.end(), pair.begin(), pair.end());
        return [all](std::uint32_t) { return all; };
    };
    const TemporaryFolder folder;
    Bytes nv12(cw * ch, luma);
    nv12.resize(cw * ch * 3 / 2, 128);
    struct Case {
        std::uint32_t code;
        std::function<Bytes(std::uint32_t)> paint;
        bool is_exact;
    };
    for (const Case& each : {Case{V4L2_PIX_FMT_RGB24, [](std::uint32_t n) { return rgb_of(n, false); }, true},
                             Case{V4L2_PIX_FMT_BGR24, [](std::uint32_t n) { return rgb_of(n, true); }, true},
                             Case{V4L2_PIX_FMT_YUYV, uniform({luma, 128}, cw * ch * 2), false},
                             Case{V4L2_PIX_FMT_UYVY, uniform({128, luma}, cw * ch * 2), false},
                             Case{V4L2_PIX_FMT_NV12, [&](std::uint32_t) { return nv12; }, false}}) {
        add(each.code, each.paint).row_padding = 5;
        const auto camera = must(open());
        EXPECT_EQ(camera->tracks().size(), 2u);
        const RawFrame frame = next_of(*camera);
        const PlaneView& colour = frame.colour;
        ASSERT_EQ(colour.width, cw) << "the size of the depth, where it is offered";
        ASSERT_EQ(colour.channels, 3);
        for (int y = 0; y < ch; ++y)
            for (int x = 0; x < cw; ++x) {
                if (each.is_exact) {
                    EXPECT_EQ(colour.sample(x, y, 1), 10 * x);
                    EXPECT_EQ(colour.sample(x, y, 2), 20 * y);
                    continue;
                }
                for (int c = 0; c < 3; ++c) EXPECT_NEAR(colour.sample(x, y, c), grey, 1);
            }
    }
}

/// Depth is taken each 40 ms of a virtual clock, and with each a colour picture, so long after it. What is
/// nearest to a depth picture is the colour of a few before it then, of the four that are kept.
TEST_F(CameraColour, HasNearestTime) {
    constexpr std::int64_t ms = 1'000'000, frame = 40 * ms;
    // In the machine's past, of which ten seconds are believed: the virtual clock runs for one.
    const std::int64_t begun = steady_now_ns() - 5000 * ms;
    struct Case {
        std::int64_t late;
        int before;
    };
    for (const Case& each : {Case{0, 0}, Case{-50 * ms, 0}, Case{15 * ms, 0}, Case{25 * ms, 1},
                             Case{70 * ms, 2}, Case{110 * ms, 3}, Case{300 * ms, 3}}) {
        std::int64_t depth_at = begun;
        int newest = -1;  // colour picture
        FakeNode& depth = add_depth_node(*video, depth_node, cw, ch);
        depth.stamp = [&](std::uint32_t n) { return depth_at = begun + n * frame; };
        FakeNode& colour = add(V4L2_PIX_FMT_RGB24, [](std::uint32_t n) { return rgb_of(n, false); });
        colour.stamp = [&](std::uint32_t n) {
            newest = static_cast<int>(n);
            return depth_at + each.late;
        };
        const auto camera = must(open());
        for (int k = 0; k < 8; ++k) {
            const auto taken = must(camera->next());
            if (k < 3) continue;  // until four are there
            EXPECT_EQ(taken->colour.sample(0, 0, 0), newest - each.before) << each.late / ms << " ms late";
        }
    }
}

TEST_F(CameraColour, ClosesWhenLeftOut) {
    add(V4L2_PIX_FMT_RGB24, [](std::uint32_t n) { return rgb_of(n, false); });
    const auto camera = must(open());
    camera->leave_out_colour();
    EXPECT_EQ(video->left_over().size(), 6u) << "depth's node, its stream and four buffers";
    EXPECT_TRUE(next_of(*camera).colour.empty());
}

TEST_F(CameraColour, UnpluggingLeavesDepthAlone) {
    add(V4L2_PIX_FMT_RGB24, [](std::uint32_t n) { return rgb_of(n, false); });
    const auto camera = must(open());
    ASSERT_EQ(message(camera->begin(std::chrono::steady_clock::now() - std::chrono::milliseconds(1))), "");
    ASSERT_EQ(message(camera->next()), "");
    video->unplug(colour_node);
    for (int k = 0; k < 3; ++k) {
        EXPECT_FALSE(next_of(*camera).depth.empty());
    }
    ASSERT_EQ(camera->remarks().size(), 1u);
    EXPECT_EQ(camera->remarks()[0], "the camera of colour, /dev/video2, was unplugged");
}

TEST_F(CameraColour, RejectsNodeWithoutColour) {
    add(V4L2_PIX_FMT_Y16, nullptr);
    EXPECT_EQ(message(open()), colour_node +
                                   ": gives no colour that can be shown (Y16); colour= takes a "
                                   "node of RGB3, BGR3, YUYV, UYVY, NV12 or MJPG");
    add(V4L2_PIX_FMT_RGB24, nullptr).refusals[VIDIOC_S_FMT] = EBUSY;
    EXPECT_TRUE(is_refused(open(), colour_node + ": another program has the camera"));
}

// The text of `touchable cameras`.

std::string how_to_touch(const std::string& camera, const std::string& with_colour) {
    return "    touch " + camera + " or " + with_colour + '\n';
}

TEST(CameraList, AdvisesWithoutCamera) {
    FakeVideo video;
    const std::string words = cameras_in_words(video, how_to_touch);
    EXPECT_EQ(words,
              "No camera is there (no /dev/video*): plug one in. If one is plugged in, load its driver: "
              "sudo modprobe uvcvideo (USB cameras)\n");
}

TEST(CameraList, DescribesEachNode) {
    FakeVideo video;
    FakeNode& depth = video.add("/dev/video0");
    depth.card = "Intel(R) RealSense(TM)";
    depth.formats = {{V4L2_PIX_FMT_Z16, {{640, 480, {{1, 30}, {1, 60}}}, {848, 480}}}};
    FakeNode& metadata = video.add("/dev/video1");
    metadata.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
    FakeNode& colour = video.add("/dev/video2");
    colour.formats = {{V4L2_PIX_FMT_YUYV, {{640, 480}}}, {V4L2_PIX_FMT_MJPEG, {}}};
    video.add("/dev/video3").refusals[0] = EACCES;
    EXPECT_EQ(cameras_in_words(video, how_to_touch),
              "/dev/video0  Intel(R) RealSense(TM) (fake, usb-1)\n"
              "    Z16     640x480 at 60, 30 frames/s; 848x480 at 30 frames/s\n"
              "    touch v4l2:/dev/video0 or v4l2:/dev/video0,colour=/dev/video2\n"
              "/dev/video1  A camera (fake, usb-1)\n"
              "    gives no pictures: a node of metadata or of another kind\n"
              "/dev/video2  A camera (fake, usb-1)\n"
              "    YUYV    640x480 at 30 frames/s\n"
              "    MJPG    its driver does not say which sizes\n"
              "    colour alone: there is nothing to touch\n"
              "/dev/video3: may not be opened by this user; use sudo usermod -aG video $USER, then "
              "log in again\n");
    const auto json = nlohmann::json::parse(cameras_in_json(video), nullptr, false);
    ASSERT_EQ(json["cameras"].size(), 4U) << json;
    const auto &of_depth = json["cameras"][0], &metadata_node = json["cameras"][1],
               &of_colour = json["cameras"][2], &closed_node = json["cameras"][3];
    EXPECT_EQ(of_depth["formats"], nlohmann::json::parse(R"([{"code": "Z16", "is_depth": true,
                  "modes": ["640x480 at 60, 30 frames/s", "848x480 at 30 frames/s"]}])"));
    EXPECT_TRUE(metadata_node["formats"].is_array() && metadata_node["formats"].empty()) << metadata_node;
    EXPECT_EQ(of_colour["formats"][1],
              nlohmann::json::parse(R"({"code": "MJPG", "is_depth": false, "modes": []})"));
    EXPECT_TRUE(has_words(closed_node["why_not"].get<std::string>(), "may not be opened")) << closed_node;
    EXPECT_EQ(video.misuse(), std::vector<std::string>());
    EXPECT_EQ(video.left_over(), std::vector<std::string>()) << "it only looks";
}

TEST(CameraList, OffersSizesBetweenLimits) {
    for (const auto& [least, most] : {std::pair<FakeMode, FakeMode>{{32, 16}, {640, 960}},
                                      {{32, 16}, {960, 480}},
                                      {{640, 16}, {960, 960}},
                                      {{32, 480}, {960, 960}}}) {
        FakeVideo video;
        video.add("/dev/video0").formats = {{V4L2_PIX_FMT_Z16, {least, most}, true}};
        EXPECT_TRUE(has_words(cameras_in_words(video, how_to_touch), " frames/s; 640x480 at 30 frames/s; "));
        const NodeFormat format = look_at_node(video, "/dev/video0")->formats.at(0);
        EXPECT_EQ(mode_text(must(choose_mode(format, {800, 500}))), "800x500 at 30 frames/s");
    }
    FakeVideo video;
    video.add("/dev/video0").formats = {{V4L2_PIX_FMT_Z16, {{640, 480}, {960, 960}}, true}};
    EXPECT_EQ(look_at_node(video, "/dev/video0")->formats.at(0).modes.size(), 2U) << "each size once";
}

TEST(CameraList, NamesMissingDepthNode) {
    FakeVideo video;
    FakeNode& colour = video.add("/dev/video0");
    colour.card = "Intel(R) RealSense(TM)";
    colour.formats = {{V4L2_PIX_FMT_YUYV, {{640, 480}}}};
    const std::string words = cameras_in_words(video, how_to_touch);
    EXPECT_TRUE(has_words(words, "has no node of depth (Z16)"));
    EXPECT_TRUE(has_words(words, "None of them gives depth"));
}

TEST(PluggedStream, RefusesMeaningOfDepth) {
    const StreamSource stream{.url = must(read_stream_url("tcp://127.0.0.1:1"))};
    EXPECT_TRUE(is_refused(open_plugged_camera(stream, millimetres), "is a stream, which has its scene in it",
                           ErrorKind::usage));
    EXPECT_TRUE(is_refused(open_plugged_camera(stream, SourceDescription()), "127.0.0.1:1"));
}

// A camera that stays open from run to run.

using std::chrono::milliseconds;

TEST(SharedCamera, ContinuesAcrossRuns) {
    const auto video = std::make_shared<FakeVideo>();
    add_depth_node(*video, "/dev/video0", 16, 8).period_ns = 2'000'000;
    V4l2Choice choice{"/dev/video0"};
    choice.system = video;
    const SourceDescription known{{}, 60, 0.001, {}, {}, {}};
    {
        const auto shared = std::make_shared<SharedCamera>();
        auto before = shared->open(choice, known);
        ASSERT_EQ(message(before), "");
        for (int n = 0; n < 2; ++n) EXPECT_EQ((*(*before)->next())->number, n);
        std::int64_t number = 0;  // of the newest frame of the run that is made ready
        for (int change = 0; change < 3; ++change) {
            ASSERT_EQ(message((*before)->begin(steady_clock::now() - milliseconds(1))), "");
            Result<std::optional<RawFrame>> last = std::optional<RawFrame>();
            std::stop_source over;
            std::thread reader([&] {
                const StopScope until(over.get_token());
                do last = (*before)->next();
                while (last);
            });
            // While that runs, another is made ready with frames of it.
            auto next = shared->open(choice, known);
            EXPECT_EQ(message(next), "");
            const auto first = (*next)->next();
            EXPECT_EQ(message(first), "");
            EXPECT_EQ((*first)->number, 0);
            auto second = (*next)->next();
            // The same once more, where the reader takes none in 100 ms.
            for (number = 1; number < 600 && (*second)->storage == (*first)->storage; ++number)
                second = (*next)->next();
            EXPECT_EQ((*second)->number, number);
            EXPECT_LT((*first)->time_ns, (*second)->time_ns);
            EXPECT_NE((*first)->storage, (*second)->storage);
            over.request_stop();
            reader.join();
            EXPECT_EQ(last.error().kind, ErrorKind::interrupted);
            before = std::move(next);
        }
        ASSERT_EQ(message((*before)->begin(steady_clock::now() - milliseconds(1))), "");
        const auto frame = must((*before)->next());
        EXPECT_EQ(frame->number, number + 1) << "what was taken between two runs is no gap";
        EXPECT_GT(frame->time_ns, ns_before_a_run);
        EXPECT_EQ(video->left_over().size(), 6u) << "one stream: the node, that it streams, four buffers";
    }
    EXPECT_EQ(video->left_over(), std::vector<std::string>());
    EXPECT_EQ(video->misuse(), std::vector<std::string>());
}

// The kernel's own cameras, where it has some that need no hardware (vivid, v4l2loopback).

TEST(RealNode, Streams) {
    const auto video = system_video();
    for (const std::string& path : video->nodes()) {
        const auto facts = look_at_node(*video, path);
        if (!facts || facts->driver != "vivid" || facts->formats.empty()) continue;
        for (const NodeFormat& format : facts->formats) {
            if (!is_depth_format(format.code) && !is_colour_format(format.code)) continue;
            auto stream = must(V4l2Stream::open(video, *facts, format, {640, 360}));
            for (int pictures = 0; pictures < 3;) {
                pollfd waited{stream->descriptor(), POLLIN, 0};
                ASSERT_GT(video->poll({&waited, 1}, 5000), 0);
                const auto picture = must(stream->take(V4l2Stream::Which::oldest));
                pictures += picture.has_value();
            }
        }
        return;
    }
    GTEST_SKIP() << "the kernel has no vivid (sudo modprobe vivid)";
}

/// Here this very program, whose descriptors it may see.
TEST(RealNode, NamesProcessesThatUseIt) {
    const int descriptor = ::open("/dev/null", O_RDONLY);
    ASSERT_GE(descriptor, 0);
    const std::string self = "(process " + std::to_string(::getpid()) + ")";
    EXPECT_TRUE(has_words(users_of_node("/dev/null"), self));
    ::close(descriptor);
    EXPECT_EQ(users_of_node("/no/such/node"), "");
}

}  // namespace
}  // namespace touchable::test
