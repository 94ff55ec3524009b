// As hostile_calls_test.cpp, of clips: files that are none, framesets of clips that are closed, writers in
// any order.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "tests/capi/hill.hpp"
#include "tests/capi/spoiled_values.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

/// A program that does everything wrong with clips, sometimes.
class HostileReader : SpoiledValues {
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
        const touch_status status =
            touch_clip_open(or_null(path.c_str()), or_null(&settings), or_null(&clip), error());
        if (status == TOUCH_OK) clips_.push_back(clip);
        return status;
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
        const touch_status status = touch_clip_next(one_of(clips_), or_null(&frameset), error());
        if (status == TOUCH_OK) framesets_.push_back(frameset);
        return status;
    }
    /// Whatever became of the clip, every byte of a frameset is there.
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
        settings.struct_size = spoilt(settings.struct_size);
        settings.overwrite = spoilt(settings.overwrite);
        const std::int64_t times[] = {spoilt(std::int64_t{0}), spoilt(std::int64_t{40'000'000})};
        if (rarely()) settings.times_ns = times;
        if (rarely()) settings.times = upto(3);
        const std::string path = folder_ / names[upto(std::size(names))];
        touch_writer writer{};
        const touch_status status =
            touch_writer_create(or_null(path.c_str()), rarely() ? touch_scene{random_()} : scene_,
                                or_null(&settings), or_null(&writer), error());
        if (status == TOUCH_OK) writers_.push_back(writer);
        return status;
    }
    touch_status write() {
        touch_frame frame = hill_.frame();
        frame.struct_size = spoilt(frame.struct_size);
        frame.number = spoilt(frame.number);
        frame.depth.width = spoilt(frame.depth.width);
        frame.depth.stride_bytes = spoilt(frame.depth.stride_bytes);
        frame.depth.sample = spoilt(frame.depth.sample);
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

TEST(HostileClips, EachGivesAStatus) {
    std::array<int, 256> seen{};
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const TemporaryFolder folder;
        HostileReader program(seed, folder);
        for (int k = 0; k < 1000; ++k) {
            const touch_status status = program.call();
            ASSERT_STRNE(touch_status_name(status), "unknown status");
            ASSERT_NE(status, TOUCH_INTERNAL);
            ++seen[static_cast<std::size_t>(status)];
        }
    }
    for (const touch_status status :
         {TOUCH_OK, TOUCH_USAGE, TOUCH_INPUT, TOUCH_STALE, TOUCH_END, TOUCH_INTERRUPTED})
        EXPECT_GT(seen[static_cast<std::size_t>(status)], 10) << touch_status_name(status);
    EXPECT_GT(seen[TOUCH_OK], 500) << "hardly anything was called as it should be";
}

}  // namespace
}  // namespace touchable::test
