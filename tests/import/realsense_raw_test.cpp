// Snapshots of the RealSense Viewer: codes without a head, and a table of their size and camera.
#include "engine/formats/realsense_raw.hpp"

#include <gtest/gtest.h>

#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

const std::string snapshot_table =
    "Frame Info: \nType,Depth\nFormat,Z16\nFrame Number,141\nTimestamp (ms),1700000000000.00\n"
    "Resolution x,16\nResolution y,12\nBytes per pixel,2\n\nIntrinsic:,\nFx,20.5\nFy,21\nPPx,7.25\nPPy,5.75\n"
    "Distorsion,Brown Conrady\n";

std::string without(std::string text, const std::string& words, const std::string& instead = "") {
    return text.replace(text.find(words), words.size(), instead);
}

class RealsenseRaw : public ::testing::Test {
protected:
    RealsenseRaw() {
        std::string codes;
        for (int k = 0; k < 16 * 12; ++k) {
            const int code = k == 0 ? 0 : 800 + k;
            codes += static_cast<char>(code & 255);
            codes += static_cast<char>(code >> 8);
        }
        write_bytes(folder / "snap_Depth.raw", codes);
        write_bytes(folder / "snap_Depth_metadata.csv", snapshot_table);
        for (const auto& [name, red] : {std::pair{"snap_Color.png", 200}, {"snap_Depth.png", 50}}) {
            Image picture{16, 12, 1, 3, {}};
            for (int k = 0; k < 16 * 12; ++k)
                for (const int sample : {red, 10, k})
                    picture.samples.push_back(static_cast<std::uint8_t>(sample));
            EXPECT_EQ(message(write_png(folder / name, picture.view())), "");
        }
    }
    TemporaryFolder folder;
};

TEST_F(RealsenseRaw, OpensWithItsCameraAndColour) {
    for (const auto& path : {folder / "snap_Depth.raw", folder.path()}) {
        SCOPED_TRACE(path);
        auto reader = open_clip(path);
        ASSERT_EQ(message(reader), "");
        const Scene scene = (*reader)->scene();
        EXPECT_EQ(scene.camera.fx, 20.5);
        EXPECT_EQ(scene.camera.fy, 21);
        EXPECT_EQ(scene.camera.cx, 7.25);
        EXPECT_EQ(scene.camera.cy, 5.75);
        EXPECT_TRUE(is_noted(**reader, "the camera is that of snap_Depth_metadata.csv"));
        const auto frames = read_all(**reader);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 1U);
        const RawFrame& frame = frames->front();
        EXPECT_NEAR(scene.depth.depth(frame.depth.sample(3, 1)) * scene.metres_per_unit, 0.819, 1e-9);
        EXPECT_FALSE(scene.depth.is_valid(frame.depth.sample(0, 0)));
        ASSERT_FALSE(frame.colour.empty());
        EXPECT_EQ(frame.colour.row(1)[0], 200);
        EXPECT_EQ(std::ranges::count((*reader)->inputs(), folder / "snap_Depth_metadata.csv"), 1);
        EXPECT_EQ(message(guess_clip(path, {})), "");
    }
    SourceDescription known;
    known.fov = 60;
    const auto reader = open_clip(folder / "snap_Depth.raw", {}, known);
    ASSERT_EQ(message(reader), "");
    EXPECT_NE((*reader)->scene().camera.fx, 20.5);
}

TEST_F(RealsenseRaw, BesideARecordingIsNotWhatTheFolderIsOf) {
    std::filesystem::create_directory(folder / "depth");
    Image picture{16, 12, 2, 1, std::vector<std::uint8_t>(2 * 16 * 12, 3)};
    for (const char* name : {"depth/1.png", "depth/2.png"})
        EXPECT_EQ(message(write_png(folder / name, picture.view())), "");
    auto reader = open_clip(folder.path());
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), 2);
}

TEST_F(RealsenseRaw, IsRefusedWhereItsTableDoesNotFit) {
    const auto refusal = [&](const std::string& table) {
        write_bytes(folder / "snap_Depth_metadata.csv", table);
        return message(open_clip(folder / "snap_Depth.raw"));
    };
    EXPECT_EQ(refusal(without(snapshot_table, "Fx,20.5", "Fx,20.5\r")), "");
    for (const auto& [table, words] :
         {std::pair{without(snapshot_table, "Z16", "RGB8"),
                    "must have a row \"Format,Z16\", as depth has, not \"RGB8\""},
          {std::string("Type,Depth\n"), "must have a row \"Format,Z16\", as depth has"},
          {without(snapshot_table, "Fx,20.5\n"), "has no row \"Fx,NUMBER\""},
          {without(snapshot_table, "Fx,20.5", "Fx,nan"), "has no row \"Fx,NUMBER\""},
          {without(snapshot_table, "Fx,20.5", "Fx,-1"), "must be above 0"},
          {without(snapshot_table, "x,16", "x,1e300"), "is 1000000x12 pixels: must be"},
          {without(snapshot_table, "x,16", "x,-5"), "is 0x12 pixels: must be"},
          {without(snapshot_table, "x,16", "x,17"),
           "has 384 bytes: must be 408 for the 17x12 pixels of 16 bits that snap_Depth_metadata.csv states"}})
        EXPECT_TRUE(has_words(refusal(table), words));
    std::filesystem::remove(folder / "snap_Depth_metadata.csv");
    EXPECT_TRUE(is_refused(open_clip(folder / "snap_Depth.raw"), "is not a Matroska file"));
}

}  // namespace
}  // namespace touchable::test
