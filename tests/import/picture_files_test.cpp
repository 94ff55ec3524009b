#include "engine/formats/picture_files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

std::vector<std::string> names(const PictureFiles& found) {
    std::vector<std::string> all;
    for (std::size_t frame = 0; frame < found.count(); ++frame)
        all.push_back(found.file(frame).filename().string());
    return all;
}

PictureFiles found_in(const TemporaryFolder& folder, const std::string& pattern) {
    auto found = found_files(folder.path(), pattern);
    EXPECT_EQ(message(found), "");
    return found ? *found : PictureFiles{};
}

using Names = std::vector<std::string>;

TEST(PictureFiles, OfAStarComeInTheOrderOfTheirNumbers) {
    const TemporaryFolder folder;
    for (const char* name : {"d9.png", "d10.png", "d011.png", "d2.png", "e1.png", "d2.jpg"})
        write_bytes(folder / name, "");
    const PictureFiles found = found_in(folder, "d*.png");
    EXPECT_EQ(names(found), (Names{"d2.png", "d9.png", "d10.png", "d011.png"}));
    EXPECT_EQ(found.keys, (std::vector<double>{2, 9, 10, 11}));
    EXPECT_EQ(rate_of(found), std::nullopt) << "numbers that only count";
    for (const char* name : {"t1.25.png", "t1.3.png", "t1.5.png", "t2.0.png"}) write_bytes(folder / name, "");
    EXPECT_EQ(found_in(folder, "t*.png").keys, (std::vector<double>{1.25, 1.3, 1.5, 2}));
    EXPECT_TRUE(is_refused(found_files(folder.path(), "x*.png"), "no file has such a name"));
}

/// Several numbers of each name differ: those of a counter and a time, a time and the device's ticks, which
/// wrap around, a date, a time of day and a counter.
TEST(PictureFiles, OfSeveralNumbersAreAllFrames) {
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
        const TemporaryFolder folder;
        for (const std::string& name : row.files) write_bytes(folder / name, "");
        write_bytes(folder / "note_of_the_day.png", "");
        const auto groups = picture_groups(folder.path());
        ASSERT_EQ(groups.size(), 2U) << row.pattern;
        EXPECT_EQ(groups.front().pattern, row.pattern);
        EXPECT_EQ(groups.front().count, row.files.size());
        EXPECT_EQ(groups.front().first.filename(), *std::ranges::min_element(row.files));
        const PictureFiles found = found_in(folder, row.pattern);
        EXPECT_EQ(names(found), row.files);
        EXPECT_EQ(found.keys, row.keys) << row.pattern;
    }
}

/// One film of two cameras or two takes would be neither.
TEST(PictureFiles, OfSeveralCamerasAreNoRow) {
    const std::vector<Names> rows = {
        {"cam1_0001_17.10.png", "cam2_0001_17.13.png", "cam1_0002_17.20.png", "cam2_0002_17.23.png"},
        {"stream0_0000.png", "stream0_0001.png", "stream1_0000.png", "stream1_0001.png"},
        {"take1_01.png", "take1_02.png", "take1_03.png", "take2_04.png", "take2_05.png", "take2_06.png"}};
    for (const Names& row : rows) {
        const TemporaryFolder folder;
        for (const std::string& name : row) write_bytes(folder / name, "");
        for (const PictureGroup& group : picture_groups(folder.path()))
            EXPECT_LT(group.count, row.size()) << group.pattern;
    }
}

TEST(PictureFiles, OfOtherPlanesAreThoseNearestInTime) {
    const TemporaryFolder folder;
    for (const char* name :
         {"1305031102.10.png", "1305031102.14.png", "1305031102.20.png", "1305031102.30.png"})
        write_bytes(folder / name, "");
    for (const char* name : {"1305031102.11.jpg", "1305031102.19.jpg", "1305031102.29.jpg"})
        write_bytes(folder / name, "");
    const FolderSource source{.depth = "*.png", .colour = "*.jpg", .haptic = "", .height = ""};
    const auto depth = depth_files(folder.path(), source);
    ASSERT_EQ(message(depth), "");
    const auto colour = files_beside(folder.path(), PlaneRole::colour, source, *depth);
    ASSERT_EQ(message(colour), "");
    EXPECT_EQ(names(*colour),
              (Names{"1305031102.11.jpg", "1305031102.11.jpg", "1305031102.19.jpg", "1305031102.29.jpg"}));
    const auto rate = rate_of(*depth);
    ASSERT_TRUE(rate);
    EXPECT_NEAR(rate->per_second(), 15, 1e-5) << "on average";
    const std::int64_t ms[] = {0, 40, 100, 200};
    for (int n = 0; n < 4; ++n)
        EXPECT_NEAR(static_cast<double>(rate->time_ns(n)), static_cast<double>(ms[n]) * 1e6, 1000) << n;
}

TEST(PictureFiles, AreLookedForTwoFoldersDownWhereNoneAreAbove) {
    const TemporaryFolder folder;
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

TEST(PictureFiles, OfAListHaveItsTimes) {
    const TemporaryFolder folder;
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

TEST(PictureFiles, OfAListAreSecondsApartWhereItHasAPoint) {
    const TemporaryFolder folder;
    for (const char* name : {"a.png", "b.png", "c.png"}) write_bytes(folder / name, "");
    write_bytes(folder / "depth.txt", "0 a.png\n1 b.png\n3 c.png\n");
    EXPECT_FALSE(rate_of(found_in(folder, "depth.txt"))) << "numbers that only count";
    write_bytes(folder / "depth.txt", "0.0 a.png\n1.0 b.png\n3.0 c.png\n");
    const auto rate = rate_of(found_in(folder, "depth.txt"));
    ASSERT_TRUE(rate && rate->own_times);
    EXPECT_EQ(*rate->own_times, (std::vector<std::int64_t>{0, 1'000'000'000, 3'000'000'000}));
}

TEST(PictureFiles, TimesOfAListThatAreOfNoUseAreSaidToBe) {
    const TemporaryFolder folder;
    for (const char* name : {"a.png", "b.png", "c.png"}) write_bytes(folder / name, "");
    const auto said = [&](const char* list) {
        write_bytes(folder / "depth.txt", list);
        return unusable_times(found_in(folder, "depth.txt"));
    };
    EXPECT_NE(said("0 a.png\n33 b.png\n67 c.png\n").find("depth.txt are whole numbers that only count"),
              std::string::npos);
    EXPECT_NE(said("0.0 a.png\n0.0002 b.png\n0.0008 c.png\n").find("are 0.0004 s apart on average"),
              std::string::npos);
    EXPECT_EQ(said("0.5 a.png\n0.6 b.png\n0.8 c.png\n"), "");
    EXPECT_EQ(said("1700000000000 a.png\n1700000000033 b.png\n"), "") << "milliseconds since 1970";
    EXPECT_EQ(said("a.png\nb.png\n"), "") << "has none";
}

TEST(PictureFiles, OfAListThatAreOneTimeAreSaidToBe) {
    const TemporaryFolder folder;
    for (const char* name : {"a.png", "b.png", "c.png", "d.png"}) write_bytes(folder / name, "");
    write_bytes(folder / "depth.txt", "10.0 a.png\n10.0 b.png\n11.0 c.png\n13.0 d.png\n");
    const PictureFiles found = found_in(folder, "depth.txt");
    EXPECT_NE(found.remark.find("the times of a.png and b.png are less than 1 ms apart"), std::string::npos);
    const auto rate = rate_of(found);
    ASSERT_TRUE(rate);
    EXPECT_EQ(rate->per_second(), 1) << "the mean";
    EXPECT_FALSE(rate->own_times);
    write_bytes(folder / "depth.txt", "10.0 a.png\n11.0 b.png\n");
    EXPECT_EQ(rate_of(found_in(folder, "depth.txt"))->per_second(), 1) << "of two";
}

TEST(PictureFiles, OneOfMaterialsServesAllFrames) {
    const TemporaryFolder folder;
    for (const char* name : {"d0.png", "d1.png", "map.png"}) write_bytes(folder / name, "");
    const FolderSource source{.depth = "d%d.png", .colour = "", .haptic = "map.png", .height = ""};
    const auto depth = depth_files(folder.path(), source);
    ASSERT_EQ(message(depth), "");
    const auto haptic = files_beside(folder.path(), PlaneRole::haptic, source, *depth);
    ASSERT_EQ(message(haptic), "");
    EXPECT_EQ(names(*haptic), (Names{"map.png", "map.png"}));
}

TEST(PictureFiles, OfAPlaneHaveNumbersOfTheirOwn) {
    const TemporaryFolder folder;
    for (const char* name : {"d3.png", "d5.png", "d7.png", "c100.png", "c104.png", "c108.png", "h3.png",
                             "h5.png", "h7.png", "t9.png", "t11.png", "t13.png"})
        write_bytes(folder / name, "");
    FolderSource source{.depth = "d%d.png", .colour = "c%d.png", .haptic = "t%d.png", .height = "h%d.png"};
    source.first = 3;
    source.step = 2;
    source.colour_numbers = {100, 4};
    source.haptic_numbers.first = 9;
    const auto depth = depth_files(folder.path(), source);
    ASSERT_EQ(message(depth), "");
    EXPECT_EQ(names(*depth), (Names{"d3.png", "d5.png", "d7.png"}));
    EXPECT_EQ(depth->remark, "");
    const auto beside = [&](PlaneRole role) { return files_beside(folder.path(), role, source, *depth); };
    ASSERT_EQ(message(beside(PlaneRole::colour)), "");
    EXPECT_EQ(names(*beside(PlaneRole::colour)), (Names{"c100.png", "c104.png", "c108.png"}));
    EXPECT_EQ(names(*beside(PlaneRole::haptic)), (Names{"t9.png", "t11.png", "t13.png"})) << "depth's step";
    EXPECT_EQ(names(*beside(PlaneRole::height)), (Names{"h3.png", "h5.png", "h7.png"})) << "depth's numbers";
    std::filesystem::remove(folder / "c104.png");
    EXPECT_TRUE(is_refused(beside(PlaneRole::colour), "c104.png (colour, frame 1): is missing"));
    source.count = 2;
    EXPECT_EQ(depth_files(folder.path(), source)->count(), 2U);
}

TEST(PictureFiles, ThatAreMissingFromARowAreCountedByItsStep) {
    const TemporaryFolder folder;
    for (const char* name : {"d0.png", "d10.png", "d40.png", "d45.png", "d60.png"})
        write_bytes(folder / name, "");
    FolderSource source{.depth = "d%d.png", .colour = "", .haptic = "", .height = ""};
    source.step = 10;
    EXPECT_EQ(depth_files(folder.path(), source)->remark,
              "ends after 2 frames: d20.png is missing, though later ones exist up to number 60; missing "
              "numbers: 20 to 30, 50");
}

TEST(PictureFiles, OfAStarSayWhichNumbersAreMissing) {
    const TemporaryFolder folder;
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

TEST(PictureFiles, OfAStarSayWhichNumbersAreMissingHoweverMany) {
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
        const TemporaryFolder folder;
        for (const int number : row.numbers)
            write_bytes(folder / ("d" + std::to_string(number) + ".png"), "");
        EXPECT_EQ(found_in(folder, "d*.png").remark, row.remark) << row.numbers.back();
    }
    const TemporaryFolder folder;
    for (const char* name : {"d0.png", "d6.png", "d7.png", "d8.png"}) write_bytes(folder / name, "");
    FolderSource source{.depth = "d*.png", .colour = "", .haptic = "", .height = ""};
    source.first = 1;
    EXPECT_EQ(depth_files(folder.path(), source)->remark, "") << "none of those that are used";
}

TEST(PictureFiles, OfAnotherPlaneSayWhichOfDepthsNumbersAreMissing) {
    const TemporaryFolder folder;
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

TEST(PictureFiles, StampsTellTheirUnitByTheirSize) {
    for (const double unit : {1.0, 1e3, 1e6, 1e9}) {
        PictureFiles found;
        for (int n = 0; n < 9; ++n) {
            found.files.emplace_back("x");
            found.keys.push_back((1.6e9 + 0.04 * n) * unit);
        }
        if (unit == 1.0) found.keys[0] += 0.001;
        ASSERT_TRUE(rate_of(found)) << unit;
        EXPECT_EQ(rate_of(found)->num, 25) << unit;
        EXPECT_EQ(rate_of(found)->den, 1);
    }
}

}  // namespace
}  // namespace touchable::test
