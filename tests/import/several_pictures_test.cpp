// Files and folders that hold several pictures: all are frames, or what is left out is said.
#include <gtest/gtest.h>

#include "engine/formats/formats_read.hpp"
#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/picture/npy_bytes.hpp"
#include "tests/picture/tiff_pages.hpp"

namespace touchable::test {
namespace {

/// The first track of each of these files, with a title or none, in one.
void join_tracks(const std::filesystem::path& file,
                 const std::vector<std::pair<std::filesystem::path, std::string>>& sources) {
    AVFormatContext* out = nullptr;
    ASSERT_GE(avformat_alloc_output_context2(&out, nullptr, nullptr, file.c_str()), 0);
    std::vector<AVFormatContext*> inputs;
    for (const auto& [path, title] : sources) {
        AVFormatContext* in = nullptr;
        ASSERT_GE(avformat_open_input(&in, path.c_str(), nullptr, nullptr), 0);
        inputs.push_back(in);
        AVStream* const stream = avformat_new_stream(out, nullptr);
        ASSERT_GE(avcodec_parameters_copy(stream->codecpar, in->streams[0]->codecpar), 0);
        stream->codecpar->codec_tag = 0;
        stream->time_base = in->streams[0]->time_base;
        stream->avg_frame_rate = in->streams[0]->avg_frame_rate;
        if (!title.empty()) av_dict_set(&stream->metadata, "title", title.c_str(), 0);
    }
    ASSERT_GE(avio_open(&out->pb, file.c_str(), AVIO_FLAG_WRITE), 0);
    ASSERT_GE(avformat_write_header(out, nullptr), 0);
    for (std::size_t k = 0; k < inputs.size(); ++k) {
        const PacketPtr packet(av_packet_alloc());
        while (av_read_frame(inputs[k], packet.get()) >= 0) {
            packet->stream_index = static_cast<int>(k);
            av_packet_rescale_ts(packet.get(), inputs[k]->streams[0]->time_base, out->streams[k]->time_base);
            ASSERT_GE(av_interleaved_write_frame(out, packet.get()), 0);
        }
        avformat_close_input(&inputs[k]);
    }
    ASSERT_GE(av_write_trailer(out), 0);
    avio_closep(&out->pb);
    avformat_free_context(out);
}

class SeveralPictures : public ::testing::Test {
protected:
    void depth(const std::string& name, int code = 1000) const {
        std::filesystem::create_directories((folder / name).parent_path());
        Image image{16, 12, 2, 1, {}};
        for (int k = 0; k < 16 * 12; ++k) {
            image.samples.push_back(static_cast<std::uint8_t>(code & 255));
            image.samples.push_back(static_cast<std::uint8_t>(code >> 8));
        }
        ASSERT_EQ(message(write_png(folder / name, image.view())), "");
    }
    /// Whose frame n is red of 20 n.
    void colour_video(const std::string& name, int frames, int rate = 60) const {
        ForeignVideo video{"png", AV_PIX_FMT_RGB24, 16, 12};
        video.frames = frames;
        video.rate = {rate, 1};
        write_video(folder / name, video, [&](AVFrame& frame, int n) {
            for (int y = 0; y < 12; ++y)
                for (int x = 0; x < 16; ++x)
                    for (int c = 0; c < 3; ++c)
                        frame.data[0][std::ptrdiff_t{frame.linesize[0]} * y + 3 * x + c] =
                            static_cast<std::uint8_t>(c == 0 ? 20 * n : 90);
        });
    }
    void depth_video(const std::string& name) const {
        ForeignVideo video{"ffv1", AV_PIX_FMT_GRAY16LE, 16, 12};
        video.rate = {60, 1};
        write_video(folder / name, video, [&](AVFrame& frame, int n) {
            for (int y = 0; y < 12; ++y)
                for (int x = 0; x < 16; ++x) set_sample(frame, 0, x, y, 1000 + 10 * x + n);
        });
    }
    std::vector<RawFrame> frames_of(ClipReader& clip) const {
        auto read = read_all(clip);
        EXPECT_EQ(message(read), "");
        return read ? *read : std::vector<RawFrame>{};
    }
    TemporaryFolder folder;
};

/// What macOS writes beside each file on disks of others.
TEST_F(SeveralPictures, HiddenFilesAreNoFrames) {
    for (const char* name : {"0000.png", "0001.png", "0002.png"}) {
        depth(std::string("depth/") + name);
        write_bytes(folder / "depth" / (std::string("._") + name), std::string("\0\5\26\7", 4));
        depth(std::string(".cache/depth_") + name);
    }
    auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->frame_count(), 3);
    EXPECT_FALSE(is_noted(**clip, "left out"));
    auto inner = open_clip(folder / "depth");
    ASSERT_EQ(message(inner), "");
    EXPECT_EQ(frames_of(**inner).size(), 3U);
}

TEST_F(SeveralPictures, StarTakesNumbersAlone) {
    for (const char* name : {"0000.png", "0001.png", "0000_mask.png", "ir_0000.png", "ir_0001.png"})
        depth(std::string("depth/") + name, name[0] == '0' && name[4] == '.' ? 1000 : 5);
    auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    const auto frames = frames_of(**clip);
    ASSERT_EQ(frames.size(), 2U);
    for (const RawFrame& frame : frames) EXPECT_EQ(frame.depth.sample(3, 3), 1000);
}

TEST_F(SeveralPictures, LastNumberThatIsAlwaysTheSameTellsNoFrames) {
    for (int n = 1; n < 4; ++n) depth("take7_000" + std::to_string(n) + "_depth16.png", 1000 + n);
    auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    const auto frames = frames_of(**clip);
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(frames[2].depth.sample(3, 3), 1003);
}

TEST_F(SeveralPictures, SparseDepthGivesWayToDense) {
    for (const char* name : {"17.25.png", "17.50.png"}) {
        depth(std::string("sparse_depth/") + name, 5);
        depth(std::string("ground_truth/") + name, 1000);
    }
    auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ(frames_of(**clip).at(1).depth.sample(3, 3), 1000);
    EXPECT_TRUE(is_noted(**clip, "left out: sparse_depth/ (name one of these to open it)"));
    std::filesystem::remove_all(folder / "ground_truth");
    EXPECT_EQ(message(open_clip(folder.path())), "");
}

TEST_F(SeveralPictures, PagesOfTiffAreFrames) {
    for (const char* name : {"depth.tif", "x.tiff"}) {
        write_bytes(folder / name,
                    tiff_pages({even_page(1000), even_page(1500), even_page(3, 2, 2), even_page(2000)}));
        auto clip = open_clip(folder / name);
        ASSERT_EQ(message(clip), "");
        const auto frames = frames_of(**clip);
        ASSERT_EQ(frames.size(), 3U);
        for (int n = 0; n < 3; ++n)
            EXPECT_EQ(frames[static_cast<std::size_t>(n)].depth.sample(2, 2), 1000 + 500 * n);
        EXPECT_TRUE(is_noted(**clip, std::string(name) + ": 1 page is of another size or kind"));
    }
}

TEST_F(SeveralPictures, RowOfTiffsWithPagesSaysWhichAreRead) {
    for (const char* name : {"depth_1.tif", "depth_2.tif"})
        write_bytes(folder / name, tiff_pages({even_page(1000), even_page(2000)}));
    auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->frame_count(), 2);
    EXPECT_TRUE(
        is_noted(**clip, "each file is one frame: of the 2 pictures in depth_1.tif the first is taken"));
}

TEST_F(SeveralPictures, ArraysOfNpzAreFrames) {
    const auto picture = [](float metres) { return npy_bytes("16, 20", std::vector<float>(320, metres)); };
    write_npz(folder / "list.npz", {{"arr_1", picture(2)}, {"arr_0", picture(1)}, {"arr_2", picture(1.5)}});
    auto clip = open_clip(folder / "list.npz");
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ(frames_of(**clip).size(), 3U);
    write_npz(folder / "two.npz", {{"depth", picture(2)}, {"inverse", picture(1)}});
    auto chosen = open_clip(folder / "two.npz");
    ASSERT_EQ(message(chosen), "");
    EXPECT_TRUE(is_noted(**chosen, "two.npz: depth is the array depth; left out: inverse"));
}

/// As Stray Scanner has it.
TEST_F(SeveralPictures, ColourVideoBesidePicturesIsFound) {
    for (const char* n : {"0", "1", "2"}) depth(std::string("depth/00000") + n + ".png");
    for (const char* video : {"rgb.mov", "walk 1.mov"}) {
        colour_video(video, 3);
        auto clip = open_clip(folder.path());
        ASSERT_EQ(message(clip), "");
        EXPECT_TRUE(is_noted(**clip, std::string("depth is depth/*.png, colour is ") + video));
        EXPECT_EQ((*clip)->scene().rate.num, 60) << "that of the video";
        const auto frames = frames_of(**clip);
        ASSERT_EQ(frames.size(), 3U);
        for (int n = 0; n < 3; ++n)
            EXPECT_EQ(frames[static_cast<std::size_t>(n)].colour.sample(5, 5, 0), 20 * n);
        const auto guessed = guess_folder(folder.path(), {});
        ASSERT_EQ(message(guessed), "");
        write_bytes(folder / "scene.json", scene_to_json(*guessed));
        auto described = open_clip(folder.path());
        ASSERT_EQ(message(described), "");
        EXPECT_TRUE(same_frame(frames_of(**described).back(), frames.back()));
        std::filesystem::remove(folder / "scene.json");
        std::filesystem::remove(folder / video);
    }
    colour_video("holiday.mov", 5);
    auto without = open_clip(folder.path());
    ASSERT_EQ(message(without), "");
    EXPECT_TRUE(is_noted(**without, "there is no colour")) << "another length, and no word for colour";
}

TEST_F(SeveralPictures, ColourVideoOfOtherLengthIsPairedByNumber) {
    for (const char* n : {"0", "2", "4"}) depth(std::string("depth/00000") + n + ".png");
    colour_video("rgb.mov", 6);
    auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip,
                         "colour is a video of 6 frames for depth's 3: each depth has the frame of the "
                         "number in its file's name"));
    EXPECT_EQ(frames_of(**clip).at(2).colour.sample(5, 5, 0), 80);
}

TEST_F(SeveralPictures, ColourVideoBesideStackIsFound) {
    std::vector<float> metres;
    for (int k = 0; k < 3 * 12 * 16; ++k) metres.push_back(1 + 0.001F * static_cast<float>(k));
    write_npz(folder / "walk_depths.npz", {{"depths", npy_bytes("3, 12, 16", metres)}});
    colour_video("walk_src.mov", 3);
    for (const auto& path : {folder / "walk_depths.npz", folder.path()}) {
        auto clip = open_clip(path);
        ASSERT_EQ(message(clip), "") << path;
        EXPECT_EQ((*clip)->scene().rate.num, 60);
        const auto frames = frames_of(**clip);
        ASSERT_EQ(frames.size(), 3U);
        EXPECT_EQ(frames[2].colour.sample(5, 5, 0), 40);
    }
}

/// A file that is a stack has one number for all frames, and a number behind a hyphen is none below zero.
TEST_F(SeveralPictures, ColourVideoOfASceneIsPairedByTime) {
    colour_video("rgb.mov", 10);
    const auto scene = [&](const std::string& depth) {
        write_bytes(folder / "scene.json",
                    R"({"touchable_scene": 1, "width": 16, "height": 12, "rate": [30, 1],
                        "camera": {"fx": 20, "fy": 20, "cx": 8, "cy": 6},
                        "depth": {"coding": "metric", "scale": 1},
                        "folder": {"depth": ")" +
                        depth + R"(", "colour": "rgb.mov"}})");
        auto clip = open_clip(folder.path());
        EXPECT_EQ(message(clip), "");
        if (!clip) return std::vector<RawFrame>{};
        EXPECT_TRUE(is_noted(**clip, "each depth has the frame that is nearest in time")) << depth;
        return frames_of(**clip);
    };
    std::vector<float> metres(5 * 12 * 16, 1500);
    write_bytes(folder / "depth_7.npy", npy_bytes("5, 12, 16", metres));
    auto frames = scene("depth_*.npy");
    ASSERT_EQ(frames.size(), 5U);
    EXPECT_EQ(frames[4].colour.sample(5, 5, 0), 160);
    for (const char* name : {"depth-1.png", "depth-2.png"}) depth(name);
    frames = scene("depth*.png");
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[1].colour.sample(5, 5, 0), 40);
}

/// The video of depth by its name, with its colour beside it.
TEST_F(SeveralPictures, FolderOfAVideoOfDepthIsThat) {
    colour_video("scene.mov", 3);
    depth_video("scene_depth.mkv");
    auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "colour is scene.mov"));
    EXPECT_EQ(frames_of(**clip).at(1).depth.sample(4, 4), 1041);
    EXPECT_EQ(message(guess_clip(folder.path(), {})), "");
    colour_video("another.mov", 3);
    EXPECT_NE(message(open_clip(folder.path()))
                  .find("but videos: touchable play " + (folder / "scene_depth.mkv").string()),
              std::string::npos)
        << "of three";
}

/// No name tells, and the first track is colour.
TEST_F(SeveralPictures, TrackOfDepthIsTheGreyOne) {
    std::filesystem::create_directories(folder / "parts");
    colour_video("parts/c.mkv", 3);
    depth_video("parts/d.mkv");
    for (const bool depth_first : {false, true}) {
        std::vector<std::pair<std::filesystem::path, std::string>> tracks = {{folder / "parts/c.mkv", ""},
                                                                             {folder / "parts/d.mkv", ""}};
        if (depth_first) std::swap(tracks[0], tracks[1]);
        join_tracks(folder / "two.mkv", tracks);
        auto clip = open_clip(folder / "two.mkv");
        ASSERT_EQ(message(clip), "");
        EXPECT_TRUE(is_noted(**clip, depth_first
                                         ? "none is named depth: stream 0 is read"
                                         : "none is named depth: stream 1 is read, as it is grey of more"));
        EXPECT_TRUE(is_noted(**clip, "colour is another track of the file"));
        const auto frames = frames_of(**clip);
        ASSERT_EQ(frames.size(), 3U);
        EXPECT_EQ(frames[2].depth.sample(4, 4), 1042);
        EXPECT_EQ(frames[2].colour.sample(5, 5, 0), 40);
    }
}

/// As Zivid's and Blender's exports have them: colour, then depth.
TEST_F(SeveralPictures, PageOfDepthMayFollowOneInColour) {
    auto colour = even_page(0, 24, 12, 8);
    colour.photometric = 2;
    const auto write = [&](const std::string& name) {
        write_bytes(folder / name, tiff_pages({colour, even_page(1200, 16, 12)}));
    };
    write("rgbd.tiff");
    auto clip = open_clip(folder / "rgbd.tiff");
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "depth is page 1, as page 0 is in colour; 1 page is left out"));
    EXPECT_EQ(frames_of(**clip).at(0).depth.sample(4, 4), 1200);
    for (const char* name : {"row/depth_1.tiff", "row/depth_2.tiff"}) {
        std::filesystem::create_directories(folder / "row");
        write(name);
    }
    auto row = open_clip(folder / "row");
    ASSERT_EQ(message(row), "");
    EXPECT_EQ(frames_of(**row).at(1).depth.sample(4, 4), 1200);
}

TEST_F(SeveralPictures, WhatIsLeftOutIsNamedAsItOpens) {
    for (const char* name : {"a_depth_1.png", "a_depth_2.png", "a_depth_3.png", "b_depth_1.png",
                             "b_depth_2.png", "old/depth_1.png", "old/depth_2.png", "last_depth.png"})
        depth(name);
    std::filesystem::create_directories(folder / "empty");
    depth("empty/depth.png", 0);
    auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "left out: old/, last_depth.png (name one of these to open it)"));
    EXPECT_TRUE(is_noted(
        **clip, "left out: b_depth_*.png (a scene file's folder.depth names one of these to open it)"));
    for (const char* name : {"old", "last_depth.png"})
        EXPECT_EQ(message(open_clip(folder / name)), "") << name;
}

TEST_F(SeveralPictures, TrackOfDepthIsFoundByItsTitle) {
    std::filesystem::create_directories(folder / "parts");
    colour_video("parts/c.mkv", 3);
    depth_video("parts/d.mkv");
    join_tracks(folder / "both.mkv", {{folder / "parts/c.mkv", ""}, {folder / "parts/d.mkv", "Depth map"}});
    auto clip = open_clip(folder / "both.mkv");
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "colour is another track of the file"));
    const auto frames = frames_of(**clip);
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(frames[2].depth.sample(4, 4), 1042);
    EXPECT_EQ(frames[2].colour.sample(5, 5, 0), 40);
    join_tracks(folder / "untold.mkv", {{folder / "parts/d.mkv", ""}, {folder / "parts/d.mkv", ""}});
    auto first = open_clip(folder / "untold.mkv");
    ASSERT_EQ(message(first), "");
    EXPECT_TRUE(is_noted(**first, "has 2 tracks of pictures, and none is named depth: stream 0 is read"));
}

TEST_F(SeveralPictures, ColourVideoIsFoundByAnyWordForColour) {
    for (const auto& [of_depth, of_colour] : {std::pair{"V00P00A00C00_depth.mkv", "V00P00A00C00_rgb.avi"},
                                              {"Depth-7.mkv", "Color-7.mov"},
                                              {"cam0 depth take.mkv", "cam0 image take.mov"}}) {
        depth_video(of_depth);
        colour_video(of_colour, 3);
        colour_video("rgb of another.mov", 3);
        auto clip = open_clip(folder / of_depth);
        ASSERT_EQ(message(clip), "");
        EXPECT_TRUE(is_noted(**clip, std::string("colour is ") + of_colour)) << of_depth;
        EXPECT_EQ(frames_of(**clip).at(2).colour.sample(5, 5, 0), 40);
    }
}

}  // namespace
}  // namespace touchable::test
