#include <gtest/gtest.h>

#include <algorithm>

#include "engine/formats/formats_read.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/npy_bytes.hpp"

namespace touchable::test {
namespace {

/// Folders as data sets have them, of small pictures.
class GuessedFolder : public ::testing::Test {
protected:
    void depth(const std::string& name, int least = 400) const {
        std::filesystem::create_directories((folder / name).parent_path());
        Image image{16, 12, 2, 1, {}};
        for (int k = 0; k < 16 * 12; ++k) {
            const int code = least + 10 * (k % 16);
            image.samples.push_back(static_cast<std::uint8_t>(code & 255));
            image.samples.push_back(static_cast<std::uint8_t>(code >> 8));
        }
        ASSERT_EQ(message(write_png(folder / name, image.view())), "");
    }
    void colour(const std::string& name, std::uint8_t red = 9) const {
        std::filesystem::create_directories((folder / name).parent_path());
        Image image{16, 12, 1, 3, std::vector<std::uint8_t>(16 * 12 * 3, red)};
        ASSERT_EQ(message(write_png(folder / name, image.view())), "");
    }
    GuessedScene guess(const std::string& preset = "") const {
        SourceDescription known;
        known.preset = preset;
        auto guessed = guess_folder(folder.path(), known);
        EXPECT_EQ(message(guessed), "");
        return guessed ? *guessed : GuessedScene{};
    }
    std::vector<RawFrame> frames() const {
        auto reader = open_clip(folder.path());
        EXPECT_EQ(message(reader), "");
        if (!reader) return {};
        auto read = read_all(**reader);
        EXPECT_EQ(message(read), "");
        return read ? *read : std::vector<RawFrame>{};
    }
    TemporaryFolder folder;
};

TEST_F(GuessedFolder, OfTumIsPairedByItsLists) {
    std::string depths, colours;
    for (int n = 0; n < 4; ++n) {
        const std::string time = "1305031102." + std::to_string(1100 + 33 * n).substr(1);
        depth("depth/" + time + ".png", 4000 + n);
        depths += time + " depth/" + time + ".png\n";
    }
    for (int n = 0; n < 6; ++n) {
        const std::string time = "1305031102." + std::to_string(1095 + 20 * n).substr(1);
        colour("rgb/" + time + ".png", static_cast<std::uint8_t>(n));
        colours += time + " rgb/" + time + ".png\n";
    }
    write_bytes(folder / "depth.txt", "# depth\n" + depths);
    write_bytes(folder / "rgb.txt", colours);
    const GuessedScene guessed = guess("tum");
    EXPECT_EQ(guessed.scene.folder->depth, "depth.txt");
    EXPECT_EQ(guessed.scene.folder->colour, "rgb.txt");
    EXPECT_EQ(guessed.scene.rate.num, 30);
    EXPECT_EQ(guessed.scene.depth.scale, 1.0 / 5000);
    EXPECT_EQ(guess().scene.depth.scale, 1.0 / 5000) << "whoever has such lists has such codes";
    const auto read = frames();
    ASSERT_EQ(read.size(), 4U);
    // 100, 133, 166, 199 ms beside 95, 115, 135, 155, 175, 195.
    const int nearest[] = {0, 2, 4, 5};
    for (std::size_t n = 0; n < 4; ++n) {
        EXPECT_EQ(read[n].depth.sample(0, 0), 4000 + static_cast<int>(n));
        EXPECT_EQ(read[n].colour.row(0)[0], nearest[n]) << n;
    }
}

TEST_F(GuessedFolder, OfSevenScenesIsKnownByItsNames) {
    for (const char* number : {"000000", "000001", "000002"}) {
        depth(std::string("frame-") + number + ".depth.png");
        colour(std::string("frame-") + number + ".color.png");
        write_bytes(folder / (std::string("frame-") + number + ".pose.txt"), "1 0 0 0");
    }
    const GuessedScene guessed = guess("7scenes");
    EXPECT_EQ(guessed.scene.folder->depth, "frame-*.depth.png");
    EXPECT_EQ(guessed.scene.folder->colour, "frame-*.color.png");
    EXPECT_FALSE(guessed.scene.depth.is_valid(65535));
    EXPECT_EQ(frames().size(), 3U);
}

TEST_F(GuessedFolder, WithGapsLosesNoFrame) {
    for (const int n : {3, 4, 7, 100}) {
        depth("depth/" + std::to_string(n) + ".png", 500 + n);
        colour("color/" + std::to_string(n) + ".png", static_cast<std::uint8_t>(n));
    }
    const auto read = frames();
    ASSERT_EQ(read.size(), 4U);
    EXPECT_EQ(read[3].depth.sample(0, 0), 600);
    EXPECT_EQ(read[3].colour.row(0)[0], 100);
}

TEST_F(GuessedFolder, TakesTheCameraThatLiesThere) {
    depth("depth_0.png");
    depth("depth_1.png");
    write_bytes(folder / "camera_info.yaml", "camera_matrix:\n  data: [20, 0, 8.5, 0, 21, 6.5, 0, 0, 1]\n");
    const GuessedScene guessed = guess();
    EXPECT_EQ(guessed.scene.camera.fx, 20);
    EXPECT_EQ(guessed.scene.camera.cy, 6.5);
    const auto& remarks = guessed.scene.remarks;
    EXPECT_TRUE(std::any_of(remarks.begin(), remarks.end(), [](const Remark& remark) {
        return !remark.is_guess && remark.what == "the camera is that of camera_info.yaml" &&
               remark.hints.at(0).setting == Setting::intrinsics;
    }));
}

TEST(UnitDoubt, HasBounds) {
    for (const double plausible : {0.01, 0.5, 30.0, 300.0}) EXPECT_FALSE(unit_doubt(plausible, "", {}));
    const std::pair<double, const char*> cases[] = {
        {0.0002, "0.2 mm"}, {0.0099, "9.9 mm"}, {301, "301 m"}, {1861, "1861 m"}, {1.861e6, "1861 km"}};
    for (const auto& [median, words] : cases) {
        const auto doubt = unit_doubt(median, "", {});
        ASSERT_TRUE(doubt) << median;
        EXPECT_EQ(remark_in_words(*doubt),
                  std::string("the median depth is ") + words + ": the unit may be wrong");
        EXPECT_TRUE(doubts_unit(remark_of_text(remark_text(*doubt)))) << "as a scene file keeps it";
    }
}

TEST_F(GuessedFolder, OpensTheSameFromTheSceneFileThatIsWritten) {
    for (const int n : {0, 1, 2}) {
        depth("depth_" + std::to_string(n) + ".png", 500 + n);
        colour("rgb_" + std::to_string(n) + ".png", static_cast<std::uint8_t>(n));
    }
    const auto guessed = frames();
    const GuessedScene scene = guess();
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const auto described = frames();
    ASSERT_EQ(described.size(), guessed.size());
    for (std::size_t n = 0; n < guessed.size(); ++n) EXPECT_TRUE(same_frame(described[n], guessed[n])) << n;
    SourceDescription known;
    known.fov = 50;
    EXPECT_TRUE(is_refused(open_clip(folder.path(), std::nullopt, known), "describes these pictures"));
}

/// As ARKitScenes has them: each frame has a camera of its own, and cameras of other pictures lie beside.
TEST_F(GuessedFolder, OfArkitScenesHasTheCamerasOfItsFrames) {
    for (const char* within : {"lowres_wide_intrinsics", "a_wide_intrinsics"})
        std::filesystem::create_directory(folder / within);
    for (int n = 0; n < 5; ++n) {
        const std::string time = "41048190_3379." + std::to_string(110 + 33 * n);
        depth("lowres_depth/" + time + ".png", 1000 + n);
        colour("lowres_wide/" + time + ".png", static_cast<std::uint8_t>(n));
        colour("confidence/" + time + ".png", 2);
        const std::string focal = std::to_string(n < 4 ? 20 : 26);
        write_bytes(folder / ("lowres_wide_intrinsics/" + time + ".pincam"),
                    "16 12 " + focal + " " + focal + " 7.5 5.5\n");
        write_bytes(folder / ("a_wide_intrinsics/" + time + ".pincam"), "640 480 800 800 320 240\n");
    }
    const GuessedScene guessed = guess();
    EXPECT_EQ(guessed.scene.folder->depth, "lowres_depth/41048190_*.png");
    EXPECT_EQ(guessed.scene.folder->colour, "lowres_wide/41048190_*.png");
    EXPECT_EQ(guessed.scene.folder->cameras, "lowres_wide_intrinsics/41048190_*.pincam");
    EXPECT_EQ(guessed.scene.camera, (Camera{20, 20, 7.5, 5.5}));
    EXPECT_EQ(guessed.scene.depth.scale, 0.001);
    EXPECT_FALSE(guessed.scene.depth.is_valid(0));
    EXPECT_EQ(guessed.scene.depth.invalid_code_count, 1);
    const auto says = [&](const std::string& part) {
        const auto& remarks = guessed.scene.remarks;
        return std::any_of(remarks.begin(), remarks.end(), [&](const Remark& remark) {
            return remark_in_words(remark).find(part) != std::string::npos;
        });
    };
    EXPECT_TRUE(says("that of lowres_wide_intrinsics/41048190_*.pincam, the median (a scene file says"));
    EXPECT_TRUE(says("depth is as preset arkitscenes has it"));
    const auto read = frames();
    ASSERT_EQ(read.size(), 5U);
    EXPECT_EQ(read[3].depth.sample(0, 5), 1003);
    // 26 / 20 of the way from the centre: columns 0 and 15 are beyond, 1 is 0.95 from column -1.
    EXPECT_EQ(read[4].depth.sample(0, 5), 0);
    EXPECT_EQ(read[4].depth.sample(15, 5), 0);
    EXPECT_EQ(read[4].depth.sample(2, 5), 1004) << "7.5 - 5.5 x 1.3 = 0.35";
    EXPECT_EQ(read[4].depth.sample(12, 5), 1004 + 130) << "7.5 + 4.5 x 1.3 = 13.35";
    write_bytes(folder / "scene.json", scene_to_json(guessed));
    const auto again = frames();
    ASSERT_EQ(again.size(), 5U);
    for (std::size_t n = 0; n < 5; ++n) EXPECT_TRUE(same_frame(again[n], read[n])) << n;
    std::filesystem::remove(folder / "scene.json");
    SourceDescription known;
    known.intrinsics = Intrinsics{30, 30};
    const auto told = guess_folder(folder.path(), known);
    ASSERT_EQ(message(told), "");
    EXPECT_EQ(told->scene.folder->cameras, "") << "somebody said the camera";
    EXPECT_EQ(told->scene.camera.fx, 30);
    write_bytes(folder / "lowres_wide_intrinsics/41048190_3379.143.pincam", "16 12 20\n");
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "41048190_3379.143.pincam: has no camera"));
}

std::string remarks_in(const GuessedScene& guessed) {
    std::string text;
    for (const Remark& remark : guessed.scene.remarks) text += remark_in_words(remark) + '\n';
    return text;
}

TEST_F(GuessedFolder, OfSeveralTakesSaysWhichAreLeftOutAndMixesNone) {
    for (const char* take : {"t1/", "t2/", "t3/"})
        for (const char* number : {"1", "2", "3"}) {
            if (*number == '3' && take != std::string("t2/")) continue;
            depth(take + std::string("depth_") + number + ".png");
            if (take != std::string("t2/")) colour(take + std::string("color_") + number + ".png");
        }
    const GuessedScene guessed = guess();
    EXPECT_EQ(guessed.scene.folder->depth, "t2/depth_*.png");
    EXPECT_EQ(guessed.scene.folder->colour, "") << "another take's";
    EXPECT_NE(remarks_in(guessed).find("left out: t1/, t3/ (name one of these to open it)"),
              std::string::npos)
        << remarks_in(guessed);
    colour("rgb/1.png");
    colour("rgb/2.png");
    EXPECT_EQ(guess().scene.folder->colour, "rgb/*.png");
    for (const char* take : {"t1", "t3"}) std::filesystem::remove_all(folder / take);
    EXPECT_EQ(remarks_in(guess()).find("left out"), std::string::npos);
    write_bytes(folder / "depth.txt", "0.1 t2/depth_1.png\n0.2 t2/depth_2.png\n");
    EXPECT_EQ(guess().scene.folder->depth, "depth.txt");
    EXPECT_EQ(remarks_in(guess()).find("left out"), std::string::npos) << "those that it names";
}

TEST_F(GuessedFolder, SaysWhereFilesTellThatColourIsElsewhere) {
    depth("depth_1.png");
    depth("depth_2.png");
    colour("color_1.png");
    colour("color_2.png");
    const auto says = [&](const std::string& what) {
        return remarks_in(guess()).find("colour lies on depth's pixels, though " + what) != std::string::npos;
    };
    EXPECT_FALSE(says(""));
    write_bytes(folder / "depth_M_color.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    EXPECT_FALSE(says("")) << "nothing is moved";
    write_bytes(folder / "depth_M_color.txt", "1 0 0 0.02\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    EXPECT_TRUE(
        says("depth_M_color.txt says how its camera stands (a scene file's colour_camera says otherwise)"))
        << remarks_in(guess());
    std::filesystem::remove(folder / "depth_M_color.txt");
    write_bytes(folder / "camera_depth.json", R"({"fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5})");
    write_bytes(folder / "camera_color.json",
                R"({"fx": 40, "fy": 40, "cx": 15.5, "cy": 11.5, "width": 32, "height": 24})");
    EXPECT_FALSE(says("")) << "of larger pictures the same view";
    write_bytes(folder / "camera_color.json", R"({"fx": 40, "fy": 40, "cx": 7.5, "cy": 5.5})");
    EXPECT_TRUE(says("camera_color.json is of another camera than depth's")) << remarks_in(guess());
    for (const char* number : {"1", "2"})
        std::filesystem::remove(folder / (std::string("color_") + number + ".png"));
    EXPECT_FALSE(says("")) << "there is no colour";
}

/// As ViSP stores them. Colour's pixels are half as large, and its lens is 20 mm to the right of depth's.
TEST_F(GuessedFolder, BringsColourOfVispOntoDepth) {
    for (const std::string number : {"1", "2"}) {
        depth("depth_" + number + ".png");
        colour("color_" + number + ".png");
    }
    const auto camera = [](double focal_length) {
        std::string text = "<?xml version=\"1.0\"?>\n<conf><camera><u0>7.5</u0><v0>5.5</v0>";
        for (const char* name : {"px", "py"})
            text += "<" + std::string(name) + ">" + std::to_string(focal_length) + "</" + name + ">";
        return text + "</camera></conf>\n";
    };
    write_bytes(folder / "box_depth.xml", camera(20));
    write_bytes(folder / "box.xml", camera(40));
    EXPECT_FALSE(guess().scene.colour_camera);
    write_bytes(folder / "depth_M_color.txt", "1 0 0 0.02\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    const GuessedScene found = guess();
    ASSERT_TRUE(found.scene.colour_camera) << remarks_in(found);
    EXPECT_EQ(found.scene.colour_camera->camera.fx, 40);
    EXPECT_EQ(found.scene.colour_camera->camera.cx, 7.5);
    EXPECT_EQ(found.scene.colour_camera->from_depth.translation, (std::array{-0.02, 0.0, 0.0}));
    EXPECT_NE(remarks_in(found).find("as depth_M_color.txt and box.xml say, by the unit that is guessed"),
              std::string::npos)
        << remarks_in(found);
    // No rotation: colour is left where it is.
    write_bytes(folder / "depth_M_color.txt", "1 0 0 0.02\n0 3 0 0\n0 0 1 0\n0 0 0 1\n");
    EXPECT_FALSE(guess().scene.colour_camera);
    EXPECT_NE(remarks_in(guess()).find("colour lies on depth's pixels, though"), std::string::npos);
}

TEST_F(GuessedFolder, WithoutPicturesSaysWhereTheyAre) {
    const auto refusal = [&] { return message(open_clip(folder.path())); };
    colour("a b/seq/rgb/1.png");
    depth("a b/seq/depth/1.png");
    EXPECT_NE(refusal().find("there are no pictures, but further down than it is looked: touchable play '" +
                             (folder / "a b").string() + "')"),
              std::string::npos)
        << refusal();
    depth("c/d/e/1.png");
    EXPECT_NE(refusal().find("one of 2 such folders"), std::string::npos) << refusal();
    write_bytes(folder / "Test.mov", "");
    EXPECT_NE(refusal().find("but a video: touchable play " + (folder / "Test.mov").string() + ')'),
              std::string::npos)
        << refusal();
    for (const char* name : {"Zoo.mov", "Zoo_depth.mov"}) write_bytes(folder / name, "");
    EXPECT_NE(refusal().find("but videos: touchable play " + (folder / "Zoo_depth.mov").string() + ')'),
              std::string::npos)
        << refusal();
    for (const char* name : {"Zoo.mov", "Zoo_depth.mov"}) std::filesystem::remove(folder / name);
    write_bytes(folder / "Test.Metadata.asset", "{\"_versionMajor\": 0}");
    const std::string asset = message(open_clip(folder / "Test.Metadata.asset"));
    EXPECT_NE(asset.find("touchable play " + (folder / "Test.mov").string()), std::string::npos) << asset;
    std::filesystem::remove(folder / "Test.mov");
    EXPECT_EQ(message(open_clip(folder / "Test.Metadata.asset")).find("touchable play"), std::string::npos);
}

/// A camera's matrix as an array is no picture, in whatever folder.
TEST_F(GuessedFolder, MatricesAreNoPictures) {
    for (const char* place : {"", "depth/", "sub/"}) {
        const std::string matrix = npy_bytes("3, 3", std::vector<float>(9, 1));
        std::filesystem::create_directories(folder / place);
        write_bytes(folder / (place + std::string("camK.npy")), matrix);
        write_npz(folder / (place + std::string("camera.npz")),
                  {{"K", matrix}, {"dist", npy_bytes("5,", std::vector<float>(5, 0))}});
    }
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "no pictures of depth were found"));
    depth("depth/0000.png");
    depth("depth/0001.png");
    const GuessedScene guessed = guess();
    EXPECT_EQ(guessed.scene.folder->depth, "depth/*.png");
    bool is_told = false;
    for (const Remark& remark : guessed.scene.remarks) {
        EXPECT_EQ(remark.what.find("left out"), std::string::npos) << remark.what;
        is_told |=
            remark.what.find("and not used: camK.npy, camera.npz, depth/camK.npy") != std::string::npos;
    }
    EXPECT_TRUE(is_told);
}

TEST_F(GuessedFolder, WithoutDepthSaysWhatIsThere) {
    colour("holiday/1.png");
    colour("holiday/2.png");
    EXPECT_TRUE(is_refused(open_clip(folder.path()),
                           "no pictures of depth were found (there are 2 x holiday/*.png)"));
    const TemporaryFolder empty;
    EXPECT_TRUE(is_refused(open_clip(empty.path()), "there are no pictures"));
}

/// As Depth Anything leaves them: under the names of the pictures that it was given.
TEST_F(GuessedFolder, GreyPicturesAreDepthWhereSomebodySaysSo) {
    const auto grey = [&](const std::string& name) {
        std::filesystem::create_directories((folder / name).parent_path());
        Image image{16, 12, 1, 1, {}};
        for (int k = 0; k < 16 * 12; ++k) image.samples.push_back(static_cast<std::uint8_t>(k));
        ASSERT_EQ(message(write_png(folder / name, image.view())), "");
    };
    for (const char* n : {"0", "1", "2"}) grey("vis_depth/frame_" + std::string(n) + ".png");
    EXPECT_EQ(message(open_clip(folder / "vis_depth")), "");
    std::filesystem::rename(folder / "vis_depth", folder / "out");
    for (const char* n : {"0", "1", "2"}) colour("out/rgb/frame_" + std::string(n) + ".png");
    const auto refused = guess_folder(folder / "out", {});
    EXPECT_TRUE(is_refused(refused, "a preset says so"));
    SourceDescription known;
    known.preset = "relative-inverse";
    const auto guessed = guess_folder(folder / "out", known);
    ASSERT_EQ(message(guessed), "");
    EXPECT_EQ(guessed->scene.folder->depth, "frame_*.png");
    EXPECT_EQ(guessed->scene.folder->colour, "rgb/frame_*.png");
    EXPECT_EQ(guessed->scene.stored.kind, StoredDepth::Kind::relative);
}

/// As MiDaS writes them: PFM has its lowest row first, and what is near has large values.
TEST_F(GuessedFolder, FloatsThatAreLargeBelowAreDoubtedAsLengths) {
    const auto pfm = [&](bool is_large_below) {
        std::string bytes = "Pf\n16 12\n-1\n";
        for (int k = 0; k < 16 * 12; ++k) {
            const int row = k / 16;
            const float value = 200.0F + 10.0F * static_cast<float>(is_large_below ? 11 - row : row);
            bytes.append(reinterpret_cast<const char*>(&value), 4);
        }
        write_bytes(folder / "depth_0.pfm", bytes);
        write_bytes(folder / "depth_1.pfm", bytes);
    };
    const auto is_doubted = [&](const GuessedScene& guessed) {
        return std::ranges::any_of(guessed.scene.remarks, [](const Remark& remark) {
            return remark.what.find("as 1/depth of networks is") != std::string::npos;
        });
    };
    pfm(true);
    EXPECT_TRUE(is_doubted(guess()));
    EXPECT_FALSE(is_doubted(guess("relative-inverse")));
    EXPECT_EQ(guess("relative-inverse").scene.stored.kind, StoredDepth::Kind::relative);
    pfm(false);
    EXPECT_FALSE(is_doubted(guess()));
}

/// As Marigold guesses it: from 0, the nearest, to 1. Others guess 1/depth, 1 the nearest.
TEST_F(GuessedFolder, SharesThatGrowWithDepthAreDepthAndOthersOneOverIt) {
    for (const bool is_near_high : {false, true}) {
        std::string bytes = "Pf\n16 12\n-1\n";  // from the lowest row on
        for (int k = 0; k < 16 * 12; ++k) {
            const float share = static_cast<float>(k) / 191;
            const float value = is_near_high ? 1 - share : share;
            bytes.append(reinterpret_cast<const char*>(&value), 4);
        }
        write_bytes(folder / "depth_0.pfm", bytes);
        write_bytes(folder / "depth_1.pfm", bytes);
        const GuessedScene guessed = guess();
        EXPECT_EQ(guessed.scene.stored.kind, StoredDepth::Kind::relative);
        EXPECT_EQ(guessed.scene.depth.near_is_high, is_near_high);
        EXPECT_EQ(guessed.scene.depth.kind,
                  is_near_high ? DepthCodingKind::inverse : DepthCodingKind::linear);
    }
}

}  // namespace
}  // namespace touchable::test
