// A static MPEG-4 scene in one MP4 file, as it is written.
#include "engine/formats/formats_written.hpp"

#include <gtest/gtest.h>

#include "tests/clip/clip_fixture.hpp"
#include "tests/video/mp4_boxes.hpp"

namespace touchable::test {
namespace {

std::string write_stills(const std::filesystem::path& file, const Scene& scene, const Planes& planes,
                         Existing existing = Existing::keep) {
    auto writer = create_mp4_stills(file, scene, existing);
    if (!writer) return writer.error().message;
    if (auto written = (*writer)->write(test_frame(scene, 0, planes)); !written)
        return written.error().message;
    return message((*writer)->finish());
}

/// A track of pictures says by object type 0x6D that they are PNG, and is auxiliary to the first.
TEST(Mp4StillsWriter, EachPlaneIsATrackOfOnePng) {
    const TemporaryFolder folder;
    for (const bool has_colour : {true, false}) {
        const std::filesystem::path file = folder / (has_colour ? "all.mp4" : "some.mp4");
        const Scene scene = small_scene(24, 16, 16);
        const Planes planes{has_colour, true, has_colour};
        ASSERT_EQ(write_stills(file, scene, planes), "");
        const std::string bytes = read_bytes(file);
        const auto tracks = tracks_in(bytes);
        const std::size_t pictures = has_colour ? 4 : 2;
        ASSERT_EQ(tracks.size(), pictures + 2);
        for (std::size_t k = 0; k < pictures; ++k) {
            EXPECT_EQ(handler_of(bytes, tracks[k]), k == 0 ? "vide" : "auxv");
            EXPECT_EQ(id_of(bytes, tracks[k]), k + 1);
            const std::string track = bytes_in(bytes, tracks[k]);
            const std::size_t config = track.find("esds");
            ASSERT_NE(config, std::string::npos);
            const std::size_t png = track.find('\x6d', config), visual = track.find('\x11', config);
            EXPECT_EQ(visual, png + 1) << "a visual stream, of PNG";
            EXPECT_EQ(track.find("vdep") == std::string::npos, k == 0);
        }
        EXPECT_EQ(handler_of(bytes, tracks[pictures]), "sdsm");
        EXPECT_EQ(handler_of(bytes, tracks[pictures + 1]), "odsm");
        const auto frames = read_clip(file);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 1U);
        EXPECT_TRUE(same_frame(frames->front(), test_frame(scene, 0, planes)));
    }
}

TEST(Mp4StillsWriter, IsOfOneFrameAndReplacesNothingUnasked) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(24, 16);
    ASSERT_EQ(write_stills(folder / "a.mp4", scene, {}), "");
    ASSERT_EQ(write_stills(folder / "b.mp4", scene, {}), "");
    const std::string bytes = read_bytes(folder / "a.mp4");
    EXPECT_EQ(bytes, read_bytes(folder / "b.mp4"));
    EXPECT_NE(write_stills(folder / "a.mp4", scene, all_planes), "");
    EXPECT_EQ(read_bytes(folder / "a.mp4"), bytes);
    EXPECT_EQ(write_stills(folder / "a.mp4", scene, all_planes, Existing::replace), "");
    EXPECT_NE(read_bytes(folder / "a.mp4"), bytes);
    auto writer = create_mp4_stills(folder / "none.mp4", scene, Existing::keep);
    ASSERT_EQ(message(writer), "");
    EXPECT_TRUE(is_refused((*writer)->finish(), "no frame was given"));
    ASSERT_EQ(message((*writer)->write(test_frame(scene, 0, {}))), "");
    EXPECT_NE(message((*writer)->write(test_frame(scene, 1, {}))), "");
    writer->reset();
    EXPECT_FALSE(std::filesystem::exists(folder / "none.mp4"));
}

}  // namespace
}  // namespace touchable::test
