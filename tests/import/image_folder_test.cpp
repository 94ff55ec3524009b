#include <gtest/gtest.h>

#include <algorithm>

#include "engine/clip/clip_file.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/raw_png.hpp"

namespace touchable::test {
namespace {

constexpr int columns = 24, rows = 18;

Scene folder_scene(const FolderSource& source, int depth_bits = 16) {
    Scene scene = small_scene(columns, rows, depth_bits);
    scene.folder = source;
    return scene;
}

/// Images depth_007.png and so on, as `test_frame` has them, and scene.json.
void write_folder(const TemporaryFolder& folder, const Scene& scene, int frames, const Planes& planes) {
    const FolderSource& source = *scene.folder;
    for (int n = 0; n < frames; ++n) {
        const RawFrame frame = test_frame(scene, n, planes);
        const std::string number = std::to_string(1000 + source.first + n).substr(1);
        const std::pair<const char*, const PlaneView&> images[] = {{"depth_", frame.depth},
                                                                   {"colour_", frame.colour},
                                                                   {"haptic_", frame.haptic},
                                                                   {"height_", frame.height}};
        for (const auto& [name, image] : images) {
            if (image.empty()) continue;
            ASSERT_EQ(message(write_png(folder / (name + number + ".png"), image)), "");
        }
    }
    write_bytes(folder / "scene.json", scene_to_json(scene));
}

PlaneView grey(Samples& memory, int w, int h, int bytes = 1) {
    return test_plane(memory, w, h, bytes, 1, 255, 9, true);
}

std::string refusal(const TemporaryFolder& folder) {
    auto reader = open_clip(folder / "scene.json");
    if (!reader) return reader.error().message;
    return message(read_all(**reader));
}

const FolderSource depth_only_source{"depth_%03d.png", "", "", "", 0, 0};
const FolderSource all_source{
    "depth_%03d.png", "colour_%03d.png", "haptic_%03d.png", "height_%03d.png", 0, 0};

TEST(ImageFolder, EveryPlaneComesBackExactlyFromEitherWayOfNaming) {
    const TemporaryFolder folder, elsewhere;
    FolderSource source = all_source;
    source.first = 7;  // frames are numbered from 0 all the same
    const Scene scene = folder_scene(source);
    write_folder(folder, scene, 4, {true, true, true});
    write_bytes(elsewhere / "scene.json", scene_to_json(scene));
    auto by_scene = open_clip(folder / "scene.json");
    auto by_folder = open_clip(folder.path(), elsewhere / "scene.json");
    for (auto* reader : {&by_scene, &by_folder}) {
        ASSERT_EQ(message(*reader), "");
        EXPECT_EQ((**reader)->frame_count(), 4);
        EXPECT_TRUE((**reader)->notes().empty());
        for (int round = 0; round < 2; ++round) {
            const auto frames = read_all(***reader);
            ASSERT_EQ(message(frames), "");
            ASSERT_EQ(frames->size(), 4U);
            for (int n = 0; n < 4; ++n)
                EXPECT_TRUE(same_frame((*frames)[static_cast<std::size_t>(n)],
                                       test_frame(scene, n, {true, true, true})));
            ASSERT_EQ(message((**reader)->rewind()), "");
        }
    }
    const auto& tracks = (*by_scene)->tracks();
    ASSERT_EQ(tracks.size(), 4U);
    EXPECT_EQ(tracks[0].codec, "png");
    EXPECT_EQ(tracks[0].pixel_format, "gray16be");
    EXPECT_EQ(tracks[1].pixel_format, "rgb24");
}

TEST(ImageFolder, GreyColourOfAnotherSizeIsResampledToTheNearestPixel) {
    const TemporaryFolder folder;
    FolderSource source = depth_only_source;
    source.colour = "colour_%03d.png";
    write_folder(folder, folder_scene(source), 1, {});
    for (const auto& [w, h] :
         {std::pair{columns * 2, rows * 3}, {columns / 2, rows / 3}, {7, 5}, {columns, rows}}) {
        Samples memory;
        const PlaneView picture = grey(memory, w, h);
        ASSERT_EQ(message(write_png(folder / "colour_000.png", picture)), "");
        auto reader = open_clip(folder / "scene.json");
        ASSERT_EQ(message(reader), "");
        const std::string note = "colour is " + std::to_string(w) + "x" + std::to_string(h) + ": resampled";
        const bool noted = (*reader)->notes()[0].find(note) != std::string::npos;
        EXPECT_EQ(noted, w != columns) << (*reader)->notes()[0];
        const auto frame = (*reader)->next();
        ASSERT_EQ(message(frame), "");
        const PlaneView& colour = (*frame)->colour;
        ASSERT_EQ(colour.width, columns);
        ASSERT_EQ(colour.height, rows);
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x)
                for (int c = 0; c < 3; ++c)  // the sample under the pixel's centre
                    ASSERT_EQ(colour.sample(x, y, c),
                              picture.sample(int((x + 0.5) * w / columns), int((y + 0.5) * h / rows)));
    }
}

TEST(ImageFolder, CountLimitsAndFirstStarts) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(depth_only_source), 6, {});
    FolderSource some = depth_only_source;
    some.first = 2;
    some.count = 3;
    const Scene scene = folder_scene(some);
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const auto frames = read_clip(folder / "scene.json");
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    EXPECT_EQ(frames->at(0).number, 0);
    EXPECT_EQ(frames->at(0).time_ns, 0);
    EXPECT_TRUE(same_plane(frames->at(0).depth, test_frame(scene, 2, {}).depth));
}

TEST(ImageFolder, IsReadFromAnyFrame) {
    const TemporaryFolder folder;
    const Scene scene = folder_scene(all_source);
    write_folder(folder, scene, 5, all_planes);
    auto reader = open_clip(folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    for (const std::int64_t n : {3, 0, 4, 2}) {
        ASSERT_EQ(message((*reader)->seek(n)), "");
        EXPECT_TRUE(same_frame(**(*reader)->next(), test_frame(scene, n, all_planes))) << n;
    }
    EXPECT_TRUE(is_refused((*reader)->seek(6), "has no frame 6: must be from 0 to 4"));
    EXPECT_TRUE(is_refused((*reader)->seek(-1), "has no frame -1"));
}

TEST(ImageFolder, ColourThatNobodyLooksAtIsNotRead) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(all_source), 3, all_planes);
    auto reader = open_clip(folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    (*reader)->leave_out_colour();
    std::filesystem::remove(folder / "colour_001.png");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    EXPECT_TRUE(frames->at(1).colour.empty());
    EXPECT_FALSE(frames->at(1).haptic.empty());
}

TEST(ImageFolder, AGapIsAnErrorWhereACountIsGivenAndANoteElsewhere) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(depth_only_source), 5, {});
    std::filesystem::remove(folder / "depth_002.png");
    auto reader = open_clip(folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), 2);
    EXPECT_EQ((*reader)->notes().at(0),
              "ends after 2 frames: depth_002.png is missing, though later ones exist up to number 4; "
              "missing numbers: 2");
    std::filesystem::rename(folder / "depth_004.png", folder / "depth_009.png");
    write_bytes(folder / "depth_0011.png", "no number of three digits");
    reader = open_clip(folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    EXPECT_TRUE((*reader)->notes().at(0).ends_with("up to number 9; missing numbers: 2, 4 to 8"))
        << (*reader)->notes().at(0);
    FolderSource counted = depth_only_source;
    counted.count = 5;
    write_bytes(folder / "scene.json", scene_to_json(folder_scene(counted)));
    EXPECT_NE(refusal(folder).find("depth_002.png (depth, frame 2): is missing"), std::string::npos)
        << refusal(folder);
    write_bytes(folder / "scene.json", scene_to_json(folder_scene(depth_only_source)));
    std::filesystem::remove(folder / "depth_000.png");
    EXPECT_NE(refusal(folder).find("depth_000.png (depth, frame 0): is missing; the first that is there is "
                                   "number 1: give folder.first"),
              std::string::npos)
        << refusal(folder);
}

TEST(ImageFolder, EveryPlaneHasEveryFrame) {
    for (const char* role : {"colour", "haptic", "height"}) {
        const TemporaryFolder folder;
        write_folder(folder, folder_scene(all_source), 3, {true, true, true});
        const std::string name = std::string(role) + "_001.png";
        std::filesystem::remove(folder / name);
        EXPECT_NE(refusal(folder).find(name + " (" + role + ", frame 1): is missing"), std::string::npos);
    }
    const TemporaryFolder empty;
    write_bytes(empty / "scene.json", scene_to_json(folder_scene(depth_only_source)));
    EXPECT_NE(refusal(empty).find("depth_000.png (depth, frame 0): is missing"), std::string::npos);
}

TEST(ImageFolder, PlanesWithNumbersOfTheirOwnAreTheSameClip) {
    const TemporaryFolder folder;
    const Planes planes{true, true, true};
    write_folder(folder, folder_scene(all_source), 3, planes);
    const auto plain = read_clip(folder / "scene.json");
    ASSERT_EQ(message(plain), "");
    const auto renumber = [&](const std::string& role, int first, int step) {
        for (int n = 2; n >= 0; --n)
            std::filesystem::rename(
                folder / (role + "_00" + std::to_string(n) + ".png"),
                folder / (role + "_" + std::to_string(1000 + first + step * n).substr(1) + ".png"));
    };
    renumber("depth", 5, 3);
    renumber("colour", 100, 2);
    renumber("haptic", 5, 3);
    renumber("height", 1, 3);
    FolderSource source = all_source;
    source.first = 5;
    source.step = 3;
    source.colour_numbers = {100, 2};
    source.height_numbers.first = 1;
    const Scene scene = folder_scene(source);
    write_bytes(folder / "scene.json", scene_to_json(scene));
    auto reader = open_clip(folder.path());
    ASSERT_EQ(message(reader), "");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    auto packed = create_clip(folder / "packed.mkv", (*reader)->scene(), exact_clip);
    ASSERT_EQ(message(packed), "");
    for (std::size_t n = 0; n < 3; ++n) {
        EXPECT_TRUE(same_frame(frames->at(n), plain->at(n))) << n;
        ASSERT_EQ(message((*packed)->write(frames->at(n))), "");
    }
    ASSERT_EQ(message((*packed)->finish()), "");
    const auto back = read_clip(folder / "packed.mkv");
    ASSERT_EQ(message(back), "");
    for (std::size_t n = 0; n < 3; ++n) EXPECT_TRUE(same_frame(back->at(n), plain->at(n))) << n;
    std::filesystem::remove(folder / "colour_104.png");
    EXPECT_NE(refusal(folder).find("colour_104.png (colour, frame 2): is missing"), std::string::npos)
        << refusal(folder);
}

TEST(ImageFolder, ImagesThatDoNotFitAreNamed) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(all_source), 3, {true, true, true});
    Samples memory;
    const auto refused = [&](const std::string& name, const PlaneView& image) {
        const std::string before = read_bytes(folder / name);
        EXPECT_EQ(message(write_png(folder / name, image)), "");
        const std::string error = refusal(folder);
        EXPECT_NE(error.find(name), std::string::npos);
        write_bytes(folder / name, before);
        return error;
    };
    const auto says = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    const std::string size = std::to_string(columns) + "x" + std::to_string(rows);
    EXPECT_PRED2(says, refused("depth_001.png", grey(memory, columns + 1, rows, 2)),
                 "(depth, frame 1): is 25x18 gray16be, but frame 0 is " + size);
    EXPECT_PRED2(says, refused("depth_000.png", grey(memory, columns + 1, rows, 2)),
                 "(depth, frame 0): is 25x18, but the scene is " + size);
    EXPECT_PRED2(says, refused("depth_001.png", grey(memory, columns, rows)),
                 "(depth, frame 1): is " + size + " gray, but");
    EXPECT_PRED2(says, refused("depth_000.png", grey(memory, columns, rows)),
                 "is 8-bit grey, but the scene's depth.bits, 16, needs 16-bit grey");
    EXPECT_PRED2(says, refused("haptic_000.png", grey(memory, columns, rows, 2)),
                 "(haptic, frame 0): is 16-bit grey; haptic is 8-bit RGB, or grey for stiffness alone");
    EXPECT_PRED2(says, refused("colour_000.png", grey(memory, columns, rows, 2)),
                 "(colour, frame 0): is 16-bit grey; colour is");
    EXPECT_PRED2(says, refused("height_000.png", test_plane(memory, columns, rows, 1, 3, 255, 1, true)),
                 "(height, frame 0): is 8-bit RGB, but");
    EXPECT_EQ(refusal(folder), "");
}

/// A picture of 24x18 whose indices are 0 and 1, in colours or in grey.
std::string indexed_picture(bool is_grey) {
    std::string pixels;
    for (int y = 0; y < rows; ++y) {
        pixels += '\0';
        for (int x = 0; x < columns; ++x) pixels += static_cast<char>((x + y) % 2);
    }
    return raw_png({columns, rows, 8, 3}, pixels, true,
                   png_chunk("PLTE", is_grey ? "\x20\x20\x20\x41\x41\x41" : "\x20\x20\x20\x41\x42\x41"));
}

TEST(ImageFolder, IndexedDepthAndHeightAreReadWhereTheyAreGreyAndRefusedOtherwise) {
    const TemporaryFolder folder;
    const FolderSource source{"depth_%03d.png", "", "", "height_%03d.png", 0, 0};
    write_folder(folder, folder_scene(source, 8), 1, {false, false, true});
    ASSERT_EQ(refusal(folder), "");
    for (const char* name : {"depth_000.png", "height_000.png"}) {
        write_bytes(folder / name, indexed_picture(true));
        ASSERT_EQ(refusal(folder), "") << name;
    }
    const auto frames = read_clip(folder / "scene.json");
    EXPECT_EQ(frames->front().depth.sample(2, 1), 0x41);
    EXPECT_EQ(frames->front().height.sample(2, 2), 0x20);
    for (const char* name : {"height_000.png", "depth_000.png"}) {
        write_bytes(folder / name, indexed_picture(false));
        EXPECT_NE(refusal(folder).find(std::string(name) + " (" + std::string(name).substr(0, 5)),
                  std::string::npos)
            << refusal(folder);
        EXPECT_NE(refusal(folder).find("RGB"), std::string::npos) << refusal(folder);
    }
}

TEST(ImageFolder, DamagedImagesAreNamedWithTheirFrame) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(depth_only_source), 3, {});
    const std::string whole = read_bytes(folder / "depth_001.png");
    write_bytes(folder / "depth_001.png", whole.substr(0, whole.size() / 2));
    EXPECT_NE(refusal(folder).find("depth_001.png: is cut short (depth, frame 1)"), std::string::npos)
        << refusal(folder);
    write_bytes(folder / "depth_001.png", "");
    EXPECT_NE(refusal(folder).find("depth_001.png: is empty (depth, frame 1)"), std::string::npos);
}

/// Whichever of a frame's pictures was looked at first.
TEST(ImageFolder, OfSeveralDamagedPicturesTheFirstPlanesIsNamed) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(all_source), 3, {true, true, true});
    for (const char* plane : {"depth", "colour", "haptic", "height"})
        write_bytes(folder / (std::string(plane) + "_001.png"), "");
    for (const char* plane : {"depth", "colour", "haptic"}) {
        const std::string file = std::string(plane) + "_001.png";
        for (int round = 0; round < 5; ++round)
            EXPECT_NE(refusal(folder).find(file + ": is empty (" + plane + ", frame 1)"), std::string::npos)
                << refusal(folder);
        write_bytes(folder / file, read_bytes(folder / (std::string(plane) + "_000.png")));
    }
    write_bytes(folder / "height_001.png", read_bytes(folder / "height_000.png"));
    EXPECT_EQ(refusal(folder), "");
}

TEST(ImageFolder, DepthBeyondItsBitsIsAnError) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(depth_only_source, 16), 2, {});
    write_bytes(folder / "scene.json", scene_to_json(folder_scene(depth_only_source, 10)));
    EXPECT_NE(refusal(folder).find("depth.bits, 10, allows at most 1023"), std::string::npos)
        << refusal(folder);
}

TEST(ImageFolder, FarPlaneMissingFromTheSceneIsFoundInAllFrames) {
    const TemporaryFolder folder;
    Scene scene = folder_scene(depth_only_source);
    scene.depth = DepthCoding{};
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 0.25;
    scene.depth.code_max = 65535;
    scene.depth.invalid_code_count = 1;  // 0
    SceneDescription without_far(scene);
    without_far.unstated.far = true;
    for (const int deepest : {4000, 65535}) {
        for (int n = 0; n < 3; ++n) {
            Samples memory;
            const PlaneView depth = test_plane(memory, columns, rows, 2, 1, n == 2 ? deepest : 1000, 4, true);
            const auto code = static_cast<std::uint16_t>(deepest);
            if (n == 2) std::memcpy(memory.data() + 6, &code, 2);
            ASSERT_EQ(message(write_png(folder / ("depth_00" + std::to_string(n) + ".png"), depth)), "");
        }
        write_bytes(folder / "scene.json", scene_to_json(without_far));
        auto reader = open_clip(folder / "scene.json");
        ASSERT_EQ(message(reader), "");
        EXPECT_DOUBLE_EQ((*reader)->scene().depth.far, 0.25 * deepest * 1.05);
        EXPECT_EQ((*reader)->scene().depth.valid_max, std::min<int>(65535, int(deepest * 1.05)));
        EXPECT_EQ(message(validate((*reader)->scene())), "");
        EXPECT_NE((*reader)->notes().back().find("depth.far is "), std::string::npos);
    }
}

TEST(ImageFolder, PicturesWithoutANumberAreAClipOfOneFrame) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(all_source), 1, {true, true, true});
    const auto numbered = read_clip(folder / "scene.json");
    ASSERT_EQ(message(numbered), "");
    for (const char* name : {"depth", "colour", "haptic", "height"})
        std::filesystem::rename(folder / (std::string(name) + "_000.png"),
                                folder / (std::string(name) + ".png"));
    const FolderSource still{"depth.png", "colour.png", "haptic.png", "height.png", 0, 0};
    write_bytes(folder / "scene.json", scene_to_json(folder_scene(still)));
    auto reader = open_clip(folder.path());  // a folder with a scene.json describes itself
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), 1);
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 1U);
    EXPECT_TRUE(same_frame(frames->front(), numbered->front()));
    const FolderSource second{"depth.png", "", "", "", 1, 0}, two{"depth.png", "", "", "", 0, 2},
        mixed{"depth.png", "colour_%d.png", "", "", 0, 0};
    for (const FolderSource& wrong : {second, two, mixed}) {
        write_bytes(folder / "scene.json", scene_to_json(folder_scene(wrong)));
        EXPECT_NE(message(open_clip(folder.path())), "");
    }
}

/// A map of the ground that is not filmed.
TEST(ImageFolder, AStillOfAnotherPlaneServesAWholeVideo) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(all_source), 3, {true, true, true});
    auto expected = read_clip(folder / "scene.json");
    ASSERT_EQ(message(expected), "");
    for (const char* name : {"haptic", "height"})
        std::filesystem::rename(folder / (std::string(name) + "_000.png"),
                                folder / (std::string(name) + ".png"));
    write_bytes(
        folder / "scene.json",
        scene_to_json(folder_scene({"depth_%03d.png", "colour_%03d.png", "haptic.png", "height.png", 0, 0})));
    auto reader = open_clip(folder.path());
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), 3);
    EXPECT_EQ((*reader)->inputs().size(), 2 * 3U + 2 + 1);
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    for (std::size_t n = 0; n < 3; ++n) {
        (*expected)[n].haptic = expected->front().haptic;
        (*expected)[n].height = expected->front().height;
        EXPECT_TRUE(same_frame((*frames)[n], (*expected)[n])) << n;
    }
    // The same as a clip: of each frame, from anywhere.
    auto writer = create_clip(folder / "clip.mkv", (*reader)->scene(), exact_clip);
    ASSERT_EQ(message(writer), "");
    for (const RawFrame& frame : *frames) ASSERT_EQ(message((*writer)->write(frame)), "");
    ASSERT_EQ(message((*writer)->finish()), "");
    const auto clip = read_clip(folder / "clip.mkv");
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(clip->size(), 3U);
    EXPECT_TRUE(same_frame((*clip)[2], (*frames)[2]));
    std::filesystem::remove(folder / "haptic.png");
    EXPECT_NE(refusal(folder).find("haptic.png (haptic, frame 0): is missing"), std::string::npos);
}

TEST(ImageFolder, GreyHapticIsStiffnessAlone) {
    const TemporaryFolder folder;
    Scene scene = folder_scene({"depth_%03d.png", "", "haptic.png", "", 0, 0});
    scene.haptic.stiffness = {0.5, 3};
    scene.default_properties = {700, 0.37, 0.21};
    write_folder(folder, scene, 2, {});
    Samples memory;
    const PlaneView map = grey(memory, columns, rows);
    ASSERT_EQ(message(write_png(folder / "haptic.png", map)), "");
    auto reader = open_clip(folder.path());
    ASSERT_EQ(message(reader), "");
    const auto& notes = (*reader)->notes();
    EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
        return note.find(
                   "haptic is grey: stiffness alone, 0.5 to 3 N/mm; friction 0.37 static, 0.21 dynamic") == 0;
    }));
    const auto frame = (*reader)->next();
    ASSERT_EQ(message(frame), "");
    const HapticRanges& felt = (*reader)->scene().haptic;
    for (const auto& [x, y] : {std::pair{0, 0}, {columns - 1, rows - 1}, {7, 5}}) {
        const PlaneView& rgb = (*frame)->haptic;
        const HapticProperties properties = felt.at(static_cast<std::uint8_t>(rgb.sample(x, y, 0)),
                                                    static_cast<std::uint8_t>(rgb.sample(x, y, 1)),
                                                    static_cast<std::uint8_t>(rgb.sample(x, y, 2)));
        EXPECT_DOUBLE_EQ(properties.stiffness, 500 + 2500 * map.sample(x, y) / 255.0);
        EXPECT_EQ(properties.static_friction, 0.37);
        EXPECT_EQ(properties.dynamic_friction, 0.21);
    }
}

TEST(ImageFolder, WhatIsAskedForMustMakeSense) {
    const TemporaryFolder folder;
    write_folder(folder, folder_scene(depth_only_source), 2, {});
    const TemporaryFolder bare;
    EXPECT_TRUE(is_refused(open_clip(bare.path()), "describe them with a scene file"));
    const auto twice = open_clip(folder / "scene.json", folder / "scene.json");
    ASSERT_FALSE(twice);
    EXPECT_EQ(twice.error().kind, ErrorKind::usage);
    write_bytes(folder / "plain.json", scene_to_json(small_scene(columns, rows)));
    EXPECT_TRUE(message(open_clip(folder / "plain.json"))
                    .starts_with((folder / "plain.json").string() + ": has no member \"folder\""));
}

}  // namespace
}  // namespace touchable::test
