// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "engine/formats/formats_read.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/picture/image.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

std::vector<std::string> names(const PictureFiles& found) {
    std::vector<std::string> all;
    for (std::size_t frame = 0; frame < found.count(); ++frame)
        all.push_back(found.file(frame).filename().string());
    return all;
}

PictureFiles found_in(const TemporaryFolder& folder, const std::string& pattern) {
    return must(found_files(folder.path(), pattern));
}

using Names = std::vector<std::string>;

using FoundFiles = FolderTest;

TEST_F(FoundFiles, SortStarByNumbers) {
    for (const char* name : {"d9.png", "d10.png", "d011.png", "d2.png", "e1.png", "d2.jpg"})
        write_bytes(folder / name, "");
    const PictureFiles found = found_in(folder, "d*.png");
    EXPECT_EQ(names(found), (Names{"d2.png", "d9.png", "d10.png", "d011.png"}));
    EXPECT_EQ(found.keys, (std::vector<double>{2, 9, 10, 11}));
    EXPECT_EQ(rate_of(found), std::nullopt) << "numbers that only count";
    for (const char* name : {"t1.25.png", "t1.3.png", "t1.5.png", "t2.0.png"}) write_bytes(folder / name, "");
    EXPECT_EQ(found_in(folder, "t*.png").keys, (std::vector<double>{1.25, 1.3, 1.5, 2}));
    for (const char* name : {"n1.png", "n01.png", "n001.png"}) write_bytes(folder / name, "");
    EXPECT_EQ(names(found_in(folder, "n*.png")), (Names{"n001.png", "n01.png", "n1.png"}));
    EXPECT_TRUE(is_refused(found_files(folder.path(), "x*.png"), "no file has such a name"));
}

/// Several numbers of each name differ: those of a counter and a time, a time and the device's ticks, which
/// wrap around, a date, a time of day and a counter.
TEST_F(FoundFiles, FindNumberOfFrames) {
    const struct {
        Names files;  // in their order
        const char* pattern;
        std::vector<double> keys;
    } rows[] = {
        {{"0000001-000000033367.png", "0000002-000000066733.png", "0000003-000000100101.png"},
         "*.png",
         {1, 2, 3}},
        {{"frame_00000_1700000000.500.png", "frame_00001_1700000000.600.png"},
         "frame_*.png",
         {1700000000.5, 1700000000.6}},
        {{"d-1294886360.20-4294967200.pgm", "d-1294886360.23-4294967290.pgm", "d-1294886360.26-90.pgm"},
         "d-*.pgm",
         {1294886360.2, 1294886360.23, 1294886360.26}},
        {{"depth_20240501_101112_0000.png", "depth_20240501_101112_0001.png",
          "depth_20240501_101113_0002.png", "depth_20240501_101114_0003.png"},
         "depth_20240501_*.png",
         {0, 1, 2, 3}}};
    for (const auto& row : rows) {
        const TemporaryFolder fresh;
        for (const std::string& name : row.files) write_bytes(fresh / name, "");
        write_bytes(fresh / "note_of_the_day.png", "");
        const auto groups = picture_groups(fresh.path());
        ASSERT_EQ(groups.size(), 2U) << row.pattern;
        EXPECT_EQ(groups.front().pattern, row.pattern);
        EXPECT_EQ(groups.front().count, row.files.size());
        EXPECT_EQ(groups.front().first.filename(), *std::ranges::min_element(row.files));
        const PictureFiles found = found_in(fresh, row.pattern);
        EXPECT_EQ(names(found), row.files);
        EXPECT_EQ(found.keys, row.keys) << row.pattern;
    }
}

/// Two cameras or two takes must not become one film.
TEST_F(FoundFiles, KeepCamerasAndTakesApart) {
    const std::vector<Names> rows = {
        {"cam1_0001_17.10.png", "cam2_0001_17.13.png", "cam1_0002_17.20.png", "cam2_0002_17.23.png"},
        {"stream0_0000.png", "stream0_0001.png", "stream1_0000.png", "stream1_0001.png"},
        {"take1_01.png", "take1_02.png", "take1_03.png", "take2_04.png", "take2_05.png", "take2_06.png"}};
    for (const Names& row : rows) {
        const TemporaryFolder fresh;
        for (const std::string& name : row) write_bytes(fresh / name, "");
        for (const PictureGroup& group : picture_groups(fresh.path()))
            EXPECT_LT(group.count, row.size()) << group.pattern;
    }
}

TEST_F(FoundFiles, PairPlanesByNearestTime) {
    for (const char* name :
         {"1305031102.10.png", "1305031102.14.png", "1305031102.20.png", "1305031102.30.png"})
        write_bytes(folder / name, "");
    for (const char* name : {"1305031102.11.jpg", "1305031102.19.jpg", "1305031102.29.jpg"})
        write_bytes(folder / name, "");
    const FolderSource source{.depth = "*.png", .colour = "*.jpg", .haptic = "", .height = ""};
    const auto depth = must(depth_files(folder.path(), source));
    const auto colour = must(files_beside(folder.path(), PlaneRole::colour, source, depth));
    EXPECT_EQ(names(colour),
              (Names{"1305031102.11.jpg", "1305031102.11.jpg", "1305031102.19.jpg", "1305031102.29.jpg"}));
    const auto rate = rate_of(depth);
    ASSERT_TRUE(rate);
    EXPECT_NEAR(rate->per_second(), 15, 1e-5) << "on average";
    const std::int64_t ms[] = {0, 40, 100, 200};
    for (int n = 0; n < 4; ++n)
        EXPECT_NEAR(static_cast<double>(rate->time_ns(n)), static_cast<double>(ms[n]) * 1e6, 1000) << n;
}

TEST_F(FoundFiles, AreFoundTwoFoldersDown) {
    for (const char* name :
         {"depth/Camera_0/depth_1.png", "depth/Camera_0/depth_2.png", "rgb/Camera_0/rgb_1.jpg"}) {
        std::filesystem::create_directories((folder.path() / name).parent_path());
        write_bytes(folder / name, "");
    }
    const auto deep = picture_groups(folder.path());
    ASSERT_EQ(deep.size(), 2U);
    EXPECT_EQ(deep[0].pattern, "depth/Camera_0/depth_*.png");
    EXPECT_EQ(deep[1].pattern, "rgb/Camera_0/rgb_1.jpg");
    EXPECT_EQ(names(found_in(folder, deep[0].pattern)), (Names{"depth_1.png", "depth_2.png"}));
    write_bytes(folder / "depth/near.png", "");
    const auto near = picture_groups(folder.path());
    ASSERT_EQ(near.size(), 1U);
    EXPECT_EQ(near[0].pattern, "depth/near.png");
}

/// A pattern reads % and * as its own: "depth%h/0.png" once ended the program.
TEST_F(FoundFiles, SkipFoldersNamedLikePatterns) {
    Samples memory;
    for (const char* name : {"depth%h", "depth%d", "depth*"}) {
        std::filesystem::create_directory(folder / name);
        for (const char* file : {"0.png", "1.png"})
            ASSERT_EQ(
                message(write_png(folder / name / file, test_plane(memory, 20, 10, 2, 1, 3000, 5, true))),
                "");
    }
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "")) << "no folder's name is read as a pattern";
    EXPECT_EQ(message(open_clip(folder / "depth%h")), "");
}

TEST_F(FoundFiles, TakeTimesOfList) {
    for (const char* name : {"a.png", "b.png", "c.png"}) write_bytes(folder / name, "");
    write_bytes(folder / "depth.txt", "# time name\n\n0.5 b.png\n0.533 a.png # late\n0.566  c.png\n");
    const PictureFiles found = found_in(folder, "depth.txt");
    EXPECT_EQ(names(found), (Names{"b.png", "a.png", "c.png"}));
    EXPECT_EQ(found.keys, (std::vector<double>{0.5, 0.533, 0.566}));
    EXPECT_EQ(rate_of(found)->num, 30);
    const std::pair<const char*, const char*> bad[] = {{"0.5 x.png", "line 1: "},
                                                       {"one a.png", "line 1: must be a time"},
                                                       {"# nothing", "names no picture"},
                                                       {"1 a.png\n0.5 b.png", "backward"}};
    for (const auto& [text, words] : bad) {
        write_bytes(folder / "depth.txt", text);
        EXPECT_TRUE(is_refused(found_files(folder.path(), "depth.txt"), words)) << text;
    }
}

TEST_F(FoundFiles, TakeDecimalTimesAsSeconds) {
    for (const char* name : {"a.png", "b.png", "c.png"}) write_bytes(folder / name, "");
    write_bytes(folder / "depth.txt", "0 a.png\n1 b.png\n3 c.png\n");
    EXPECT_FALSE(rate_of(found_in(folder, "depth.txt"))) << "numbers that only count";
    write_bytes(folder / "depth.txt", "0.0 a.png\n1.0 b.png\n3.0 c.png\n");
    const auto rate = rate_of(found_in(folder, "depth.txt"));
    ASSERT_TRUE(rate && rate->own_times);
    EXPECT_EQ(*rate->own_times, (std::vector<std::int64_t>{0, 1'000'000'000, 3'000'000'000}));
}

TEST_F(FoundFiles, NoteUnusableTimes) {
    for (const char* name : {"a.png", "b.png", "c.png"}) write_bytes(folder / name, "");
    const auto said = [&](const char* list) {
        write_bytes(folder / "depth.txt", list);
        return unusable_times(found_in(folder, "depth.txt"));
    };
    EXPECT_TRUE(
        has_words(said("0 a.png\n33 b.png\n67 c.png\n"), "depth.txt are whole numbers that only count"));
    EXPECT_TRUE(has_words(said("0.0 a.png\n0.0002 b.png\n0.0008 c.png\n"), "are 0.0004 s apart on average"));
    EXPECT_EQ(said("0.5 a.png\n0.6 b.png\n0.8 c.png\n"), "");
    EXPECT_EQ(said("1700000000000 a.png\n1700000000033 b.png\n"), "") << "milliseconds since 1970";
    EXPECT_EQ(said("a.png\nb.png\n"), "") << "has none";
}

TEST_F(FoundFiles, NoteEqualTimes) {
    for (const char* name : {"a.png", "b.png", "c.png", "d.png"}) write_bytes(folder / name, "");
    write_bytes(folder / "depth.txt", "10.0 a.png\n10.0 b.png\n11.0 c.png\n13.0 d.png\n");
    const PictureFiles found = found_in(folder, "depth.txt");
    EXPECT_TRUE(has_words(found.remark, "the times of a.png and b.png are less than 1 ms apart"));
    const auto rate = rate_of(found);
    ASSERT_TRUE(rate);
    EXPECT_EQ(rate->per_second(), 1) << "the mean";
    EXPECT_FALSE(rate->own_times);
    write_bytes(folder / "depth.txt", "10.0 a.png\n11.0 b.png\n");
    EXPECT_EQ(rate_of(found_in(folder, "depth.txt"))->per_second(), 1) << "of two";
}

TEST_F(FoundFiles, CountMissingByStep) {
    for (const char* name : {"d0.png", "d10.png", "d40.png", "d45.png", "d60.png"})
        write_bytes(folder / name, "");
    FolderSource source{.depth = "d%d.png", .colour = "", .haptic = "", .height = ""};
    source.step = 10;
    EXPECT_EQ(depth_files(folder.path(), source)->remark,
              "ends after 2 frames: d20.png is missing, though later ones exist up to number 60; missing "
              "numbers: 20 to 30, 50");
}

TEST_F(FoundFiles, NameNumbersMissingFromStar) {
    for (const char* name : {"d0.png", "d2.png", "d4.png", "d8.png", "d10.png", "d16.png", "k1.png", "k4.png",
                             "k9.png", "t1.5.png", "t2.0.png", "t9.0.png"})
        write_bytes(folder / name, "");
    EXPECT_EQ(found_in(folder, "d*.png").remark, "d*.png: missing numbers: 6, 12 to 14");
    EXPECT_EQ(found_in(folder, "k*.png").remark, "") << "chosen frames";
    EXPECT_EQ(found_in(folder, "t*.png").remark, "") << "times";
    ASSERT_EQ(mkfifo((folder / "d6.png").c_str(), 0600), 0);
    EXPECT_EQ(found_in(folder, "d*.png").remark, "d*.png: missing numbers: 6, 12 to 14");
    FolderSource source{.depth = "d6.png", .colour = "", .haptic = "", .height = ""};
    EXPECT_TRUE(is_refused(depth_files(folder.path(), source), "is no regular file"));
}

TEST_F(FoundFiles, NameMissingRanges) {
    const struct {
        std::vector<int> numbers;
        const char* remark;
    } rows[] = {{{0, 1, 2, 3, 8}, "d*.png: missing numbers: 4 to 7"},
                {{0, 1, 2, 3, 9}, "d*.png: missing numbers: 4 to 8"},
                {{1, 2, 20}, "d*.png: missing numbers: 3 to 19"},
                {{0, 1, 2, 10, 11, 12}, "d*.png: missing numbers: 3 to 9"},
                {{0, 5, 10, 15, 20}, ""},
                {{33, 67, 100, 133, 167, 200}, ""}};
    for (const auto& row : rows) {
        const TemporaryFolder fresh;
        for (const int number : row.numbers) write_bytes(fresh / ("d" + std::to_string(number) + ".png"), "");
        EXPECT_EQ(found_in(fresh, "d*.png").remark, row.remark) << row.numbers.back();
    }
    for (const char* name : {"d0.png", "d6.png", "d7.png", "d8.png"}) write_bytes(folder / name, "");
    FolderSource source{.depth = "d*.png", .colour = "", .haptic = "", .height = ""};
    source.first = 1;
    EXPECT_EQ(depth_files(folder.path(), source)->remark, "") << "none of those that are used";
}

TEST_F(FoundFiles, NameNumbersMissingFromPlane) {
    for (const char* name : {"d1.png", "d2.png", "d3.png", "d4.png", "d5.png", "c1.png", "c2.png", "c3.png",
                             "c5.png", "c6.png", "t1.50.png", "t2.00.png", "u1.51.png", "u2.01.png"})
        write_bytes(folder / name, "");
    const auto remark = [&](const char* depth, const char* colour) {
        const FolderSource source{.depth = depth, .colour = colour, .haptic = "", .height = ""};
        const auto beside =
            files_beside(folder.path(), PlaneRole::colour, source, *depth_files(folder.path(), source));
        EXPECT_EQ(message(beside), "");
        return beside ? beside->remark : "";
    };
    EXPECT_EQ(remark("d*.png", "c*.png"),
              "colour: missing numbers that depth has; those frames get the nearest one's: 4");
    EXPECT_EQ(remark("c*.png", "d*.png"),
              "colour: missing numbers that depth has; those frames get the nearest one's: 6");
    EXPECT_EQ(remark("d*.png", "d*.png"), "");
    EXPECT_EQ(remark("t*.png", "u*.png"), "") << "times";
    write_bytes(folder / "one.txt", "13050311019032303616 d1.png\n");  // beyond 64 bits
    EXPECT_EQ(remark("one.txt", "c*.png"),
              "colour: missing numbers that depth has; those frames get the nearest one's: "
              "13050311019032303616");
}

TEST_F(FoundFiles, TellUnitOfStamps) {
    // Of ticks, the years 1 and 1601 begin these.
    for (const auto& [unit, begin] : {std::pair{1.0, 0.0},
                                      {1e3, 0.0},
                                      {1e6, 0.0},
                                      {1e9, 0.0},
                                      {1e7, 62'135'596'800.0},
                                      {1e7, 11'644'473'600.0}}) {
        PictureFiles found;
        for (int n = 0; n < 9; ++n) {
            found.files.emplace_back("x");
            found.keys.push_back((begin + 1.6e9 + 0.04 * n) * unit);
        }
        if (unit == 1.0) found.keys[0] += 0.001;
        ASSERT_TRUE(rate_of(found)) << unit;
        EXPECT_EQ(rate_of(found)->num, 25) << unit;
        EXPECT_EQ(rate_of(found)->den, 1);
    }
}

// Files and folders that hold several pictures: all are frames, or what is left out is said.

class SeveralPictures : public ::testing::Test {
protected:
    void depth(const std::string& name, int code = 1000) const {
        write_in_folder(folder / name, even_image(16, 12, 2, 1, code));
    }
    /// Frame n has red 20 n.
    void colour_video(const std::string& name, int frames, int rate = 60) const {
        ForeignVideo video{"png", AV_PIX_FMT_RGB24, 16, 12};
        video.frames = frames;
        video.rate = {rate, 1};
        write_video(folder / name, video, [&](AVFrame& frame, int n) {
            fill_rgb(frame, [&](int, int) { return std::array{20 * n, 90, 90}; });
        });
    }
    void depth_video(const std::string& name) const {
        ForeignVideo video{"ffv1", AV_PIX_FMT_GRAY16LE, 16, 12};
        video.rate = {60, 1};
        write_video(folder / name, video, [&](AVFrame& frame, int n) {
            fill_plane(frame, 0, [&](int x, int) { return 1000 + 10 * x + n; });
        });
    }
    static std::vector<RawFrame> frames_of(ClipReader& clip) { return must(read_all(clip)); }
    TemporaryFolder folder;
};

/// macOS writes hidden files beside each file on foreign disks.
TEST_F(SeveralPictures, SkipHiddenFiles) {
    for (const char* name : {"0000.png", "0001.png", "0002.png"}) {
        depth(std::string("depth/") + name);
        write_bytes(folder / "depth" / (std::string("._") + name), std::string("\0\5\26\7", 4));
        depth(std::string(".cache/depth_") + name);
    }
    auto clip = must(open_clip(folder.path()));
    EXPECT_EQ(clip->frame_count(), 3);
    EXPECT_FALSE(is_noted(*clip, "left out"));
    auto inner = must(open_clip(folder / "depth"));
    EXPECT_EQ(frames_of(*inner).size(), 3U);
}

TEST_F(SeveralPictures, MatchNumbersAlone) {
    for (const char* name : {"0000.png", "0001.png", "0000_mask.png", "ir_0000.png", "ir_0001.png"})
        depth(std::string("depth/") + name, name[0] == '0' && name[4] == '.' ? 1000 : 5);
    auto clip = must(open_clip(folder.path()));
    const auto frames = frames_of(*clip);
    ASSERT_EQ(frames.size(), 2U);
    for (const RawFrame& frame : frames) EXPECT_EQ(frame.depth.sample(3, 3), 1000);
}

TEST_F(SeveralPictures, IgnoreConstantNumber) {
    for (int n = 1; n < 4; ++n) depth("take7_000" + std::to_string(n) + "_depth16.png", 1000 + n);
    auto clip = must(open_clip(folder.path()));
    const auto frames = frames_of(*clip);
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(frames[2].depth.sample(3, 3), 1003);
}

TEST_F(SeveralPictures, PreferDenseDepth) {
    for (const char* name : {"17.25.png", "17.50.png"}) {
        depth(std::string("sparse_depth/") + name, 5);
        depth(std::string("ground_truth/") + name, 1000);
    }
    auto clip = must(open_clip(folder.path()));
    EXPECT_EQ(frames_of(*clip).at(1).depth.sample(3, 3), 1000);
    EXPECT_TRUE(is_noted(*clip, "left out: sparse_depth/ (name one of these to open it)"));
    std::filesystem::remove_all(folder / "ground_truth");
    EXPECT_EQ(message(open_clip(folder.path())), "");
}

TEST_F(SeveralPictures, OpenTiffPagesAsFrames) {
    for (const char* name : {"depth.tif", "x.tiff"}) {
        write_bytes(folder / name,
                    tiff_pages({even_page(1000), even_page(1500), even_page(3, 2, 2), even_page(2000)}));
        auto clip = must(open_clip(folder / name));
        const auto frames = frames_of(*clip);
        ASSERT_EQ(frames.size(), 3U);
        for (int n = 0; n < 3; ++n)
            EXPECT_EQ(frames[static_cast<std::size_t>(n)].depth.sample(2, 2), 1000 + 500 * n);
        EXPECT_TRUE(is_noted(*clip, std::string(name) + ": 1 page is of another size or kind"));
    }
}

TEST_F(SeveralPictures, TakeFirstPageWithNote) {
    for (const char* name : {"depth_1.tif", "depth_2.tif"})
        write_bytes(folder / name, tiff_pages({even_page(1000), even_page(2000)}));
    auto clip = must(open_clip(folder.path()));
    EXPECT_EQ(clip->frame_count(), 2);
    EXPECT_TRUE(
        is_noted(*clip, "each file is one frame: of the 2 pictures in depth_1.tif the first is taken"));
}

/// As Stray Scanner has it.
TEST_F(SeveralPictures, FindColourVideoBesidePictures) {
    for (const char* n : {"0", "1", "2"}) depth(std::string("depth/00000") + n + ".png");
    for (const char* video : {"rgb.mov", "walk 1.mov"}) {
        colour_video(video, 3);
        auto clip = must(open_clip(folder.path()));
        EXPECT_TRUE(is_noted(*clip, std::string("depth is depth/*.png, colour is ") + video));
        EXPECT_EQ(clip->scene().rate.num, 60) << "that of the video";
        const auto frames = frames_of(*clip);
        ASSERT_EQ(frames.size(), 3U);
        for (int n = 0; n < 3; ++n)
            EXPECT_EQ(frames[static_cast<std::size_t>(n)].colour.sample(5, 5, 0), 20 * n);
        std::filesystem::remove(folder / video);
    }
    colour_video("holiday.mov", 5);
    auto without = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(*without, "there is no colour")) << "another length, and no word for colour";
}

TEST_F(SeveralPictures, PairColourVideoByNumber) {
    for (const char* n : {"0", "2", "4"}) depth(std::string("depth/00000") + n + ".png");
    colour_video("rgb.mov", 6);
    auto clip = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(*clip,
                         "colour is a video of 6 frames for depth's 3: each depth has the frame of the "
                         "number in its file's name"));
    EXPECT_EQ(frames_of(*clip).at(2).colour.sample(5, 5, 0), 80);
}

TEST_F(SeveralPictures, FindColourVideoBesideStack) {
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
TEST_F(SeveralPictures, PairColourVideoByTime) {
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
TEST_F(SeveralPictures, OpenVideoByItsFolder) {
    colour_video("scene.mov", 3);
    depth_video("scene_depth.mkv");
    auto clip = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(*clip, "colour is scene.mov"));
    EXPECT_EQ(frames_of(*clip).at(1).depth.sample(4, 4), 1041);
    EXPECT_EQ(message(guess_clip(folder.path(), {})), "");
    colour_video("another.mov", 3);
    EXPECT_TRUE(is_refused(open_clip(folder.path()),
                           "but videos: touchable play " + (folder / "scene_depth.mkv").string()))
        << "of three";
}

/// By its title, or as the grey one.
TEST_F(SeveralPictures, FindDepthTrack) {
    std::filesystem::create_directories(folder / "parts");
    colour_video("parts/c.mkv", 3);
    depth_video("parts/d.mkv");
    const TitledFile colour{folder / "parts/c.mkv", ""}, depth{folder / "parts/d.mkv", ""},
        titled{depth.first, "Depth map"};
    const std::pair<std::vector<TitledFile>, const char*> files[] = {
        {{colour, depth}, "none is named depth: stream 1 is read, as it is grey of more"},
        {{depth, colour}, "none is named depth: stream 0 is read"},
        {{colour, titled}, ""}};
    for (const auto& [tracks, note] : files) {
        join_tracks(tracks, folder / "two.mkv");
        auto clip = must(open_clip(folder / "two.mkv"));
        EXPECT_TRUE(is_noted(*clip, note)) << note;
        EXPECT_EQ(is_noted(*clip, "none is named depth"), *note != 0);
        EXPECT_TRUE(is_noted(*clip, "colour is another track of the file"));
        const auto frames = frames_of(*clip);
        ASSERT_EQ(frames.size(), 3U);
        EXPECT_EQ(frames[2].depth.sample(4, 4), 1042);
        EXPECT_EQ(frames[2].colour.sample(5, 5, 0), 40);
    }
    join_tracks({depth, depth}, folder / "untold.mkv");
    auto first = must(open_clip(folder / "untold.mkv"));
    EXPECT_TRUE(is_noted(*first, "has 2 tracks of pictures, and none is named depth: stream 0 is read"));
}

/// As Zivid's and Blender's exports have them: colour, then depth.
TEST_F(SeveralPictures, SkipColourPageBeforeDepth) {
    auto colour = even_page(0, 24, 12, 8);
    colour.photometric = 2;
    const auto write = [&](const std::string& name) {
        write_bytes(folder / name, tiff_pages({colour, even_page(1200, 16, 12)}));
    };
    write("rgbd.tiff");
    auto clip = must(open_clip(folder / "rgbd.tiff"));
    EXPECT_TRUE(is_noted(*clip, "depth is page 1, as page 0 is in colour; 1 page is left out"));
    EXPECT_EQ(frames_of(*clip).at(0).depth.sample(4, 4), 1200);
    for (const char* name : {"row/depth_1.tiff", "row/depth_2.tiff"}) {
        std::filesystem::create_directories(folder / "row");
        write(name);
    }
    auto row = must(open_clip(folder / "row"));
    EXPECT_EQ(frames_of(*row).at(1).depth.sample(4, 4), 1200);
}

TEST_F(SeveralPictures, NameWhatIsLeftOut) {
    for (const char* name : {"a_depth_1.png", "a_depth_2.png", "a_depth_3.png", "b_depth_1.png",
                             "b_depth_2.png", "old/depth_1.png", "old/depth_2.png", "last_depth.png"})
        depth(name);
    std::filesystem::create_directories(folder / "empty");
    depth("empty/depth.png", 0);
    auto clip = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(*clip, "left out: old/, last_depth.png (name one of these to open it)"));
    EXPECT_TRUE(is_noted(
        *clip, "left out: b_depth_*.png (a scene file's folder.depth names one of these to open it)"));
    for (const char* name : {"old", "last_depth.png"})
        EXPECT_EQ(message(open_clip(folder / name)), "") << name;
}

TEST_F(SeveralPictures, FindColourVideoByWord) {
    for (const auto& [of_depth, of_colour] : {std::pair{"V00P00A00C00_depth.mkv", "V00P00A00C00_rgb.avi"},
                                              {"Depth-7.mkv", "Color-7.mov"},
                                              {"cam0 depth take.mkv", "cam0 image take.mov"}}) {
        depth_video(of_depth);
        colour_video(of_colour, 3);
        colour_video("rgb of another.mov", 3);
        auto clip = must(open_clip(folder / of_depth));
        EXPECT_TRUE(is_noted(*clip, std::string("colour is ") + of_colour)) << of_depth;
        EXPECT_EQ(frames_of(*clip).at(2).colour.sample(5, 5, 0), 40);
    }
}

}  // namespace
}  // namespace touchable::test
