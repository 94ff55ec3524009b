// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "engine/clip/clip_file.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/picture/results.hpp"

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

using ImageFolder = FolderTest;

TEST_F(ImageFolder, KeepsEveryPlane) {
    const TemporaryFolder elsewhere;
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
            const auto frames = must(read_all(***reader));
            ASSERT_EQ(frames.size(), 4U);
            for (int n = 0; n < 4; ++n)
                EXPECT_TRUE(same_frame(frames[static_cast<std::size_t>(n)],
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

TEST_F(ImageFolder, ResamplesGreyColourToNearest) {
    FolderSource source = depth_only_source;
    source.colour = "colour_%03d.png";
    write_folder(folder, folder_scene(source), 1, {});
    for (const auto& [w, h] :
         {std::pair{columns * 2, rows * 3}, {columns / 2, rows / 3}, {7, 5}, {columns, rows}}) {
        Samples memory;
        const PlaneView picture = grey(memory, w, h);
        ASSERT_EQ(message(write_png(folder / "colour_000.png", picture)), "");
        auto reader = must(open_clip(folder / "scene.json"));
        const std::string note = "colour is " + std::to_string(w) + "x" + std::to_string(h) + ": resampled";
        const bool noted = reader->notes()[0].find(note) != std::string::npos;
        EXPECT_EQ(noted, w != columns) << reader->notes()[0];
        const auto frame = must(reader->next());
        const PlaneView& colour = frame->colour;
        ASSERT_EQ(colour.width, columns);
        ASSERT_EQ(colour.height, rows);
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x)
                for (int c = 0; c < 3; ++c)  // the sample under the pixel's centre
                    ASSERT_EQ(colour.sample(x, y, c),
                              picture.sample(int((x + 0.5) * w / columns), int((y + 0.5) * h / rows)));
    }
}

TEST_F(ImageFolder, HonoursFirstAndCount) {
    write_folder(folder, folder_scene(depth_only_source), 6, {});
    FolderSource some = depth_only_source;
    some.first = 2;
    some.count = 3;
    const Scene scene = folder_scene(some);
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const auto frames = must(read_clip(folder / "scene.json"));
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(frames.at(0).number, 0);
    EXPECT_EQ(frames.at(0).time_ns, 0);
    EXPECT_TRUE(same_plane(frames.at(0).depth, test_frame(scene, 2, {}).depth));
}

TEST_F(ImageFolder, SeeksAnyFrame) {
    const Scene scene = folder_scene(all_source);
    write_folder(folder, scene, 5, all_planes);
    auto reader = must(open_clip(folder / "scene.json"));
    for (const std::int64_t n : {3, 0, 4, 2}) {
        ASSERT_EQ(message(reader->seek(n)), "");
        EXPECT_TRUE(same_frame(**reader->next(), test_frame(scene, n, all_planes))) << n;
    }
    ASSERT_EQ(message(reader->seek(5)), "");
    EXPECT_FALSE(must(reader->next()));
    EXPECT_TRUE(is_refused(reader->seek(6), "has no frame 6: must be from 0 to 4", ErrorKind::usage));
    EXPECT_TRUE(is_refused(reader->seek(-1), "has no frame -1", ErrorKind::usage));
}

TEST_F(ImageFolder, SkipsUnwantedColour) {
    write_folder(folder, folder_scene(all_source), 3, all_planes);
    auto reader = must(open_clip(folder / "scene.json"));
    reader->leave_out_colour();
    std::filesystem::remove(folder / "colour_001.png");
    const auto frames = must(read_all(*reader));
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_TRUE(frames.at(1).colour.empty());
    EXPECT_FALSE(frames.at(1).haptic.empty());
    EXPECT_EQ(reader->tracks().size(), 4U) << "it is stored all the same";
}

TEST_F(ImageFolder, NotesOrRefusesGaps) {
    write_folder(folder, folder_scene(depth_only_source), 5, {});
    std::filesystem::remove(folder / "depth_002.png");
    auto reader = must(open_clip(folder / "scene.json"));
    EXPECT_EQ(reader->frame_count(), 2);
    EXPECT_EQ(reader->notes().at(0),
              "ends after 2 frames: depth_002.png is missing, though later ones exist up to number 4; "
              "missing numbers: 2");
    std::filesystem::rename(folder / "depth_004.png", folder / "depth_009.png");
    write_bytes(folder / "depth_0011.png", "no number of three digits");
    reader = must(open_clip(folder / "scene.json"));
    EXPECT_TRUE(reader->notes().at(0).ends_with("up to number 9; missing numbers: 2, 4 to 8"))
        << reader->notes().at(0);
    FolderSource counted = depth_only_source;
    counted.count = 5;
    write_bytes(folder / "scene.json", scene_to_json(folder_scene(counted)));
    EXPECT_TRUE(has_words(refusal(folder), "depth_002.png (depth, frame 2): is missing"));
    write_bytes(folder / "scene.json", scene_to_json(folder_scene(depth_only_source)));
    std::filesystem::remove(folder / "depth_000.png");
    EXPECT_TRUE(has_words(refusal(folder),
                          "depth_000.png (depth, frame 0): is missing; the first that is there is "
                          "number 1: give folder.first"));
}

TEST_F(ImageFolder, NamesMissingPlanes) {
    for (const char* role : {"colour", "haptic", "height"}) {
        const TemporaryFolder fresh;
        write_folder(fresh, folder_scene(all_source), 3, {true, true, true});
        const std::string name = std::string(role) + "_001.png";
        std::filesystem::remove(fresh / name);
        EXPECT_TRUE(has_words(refusal(fresh), name + " (" + role + ", frame 1): is missing"));
    }
    const TemporaryFolder empty;
    write_bytes(empty / "scene.json", scene_to_json(folder_scene(depth_only_source)));
    EXPECT_TRUE(has_words(refusal(empty), "depth_000.png (depth, frame 0): is missing"));
}

TEST_F(ImageFolder, TakesNumbersOfEachPlane) {
    const Planes planes{true, true, true};
    write_folder(folder, folder_scene(all_source), 3, planes);
    const auto plain = must(read_clip(folder / "scene.json"));
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
    const auto [reader, frames] = must_read(open_clip(folder.path()));
    ASSERT_EQ(frames.size(), 3U);
    for (std::size_t n = 0; n < 3; ++n) EXPECT_TRUE(same_frame(frames.at(n), plain.at(n))) << n;
    write_frames(create_clip(folder / "packed.mkv", reader->scene(), exact_clip), frames);
    const auto back = must(read_clip(folder / "packed.mkv"));
    for (std::size_t n = 0; n < 3; ++n) EXPECT_TRUE(same_frame(back.at(n), plain.at(n))) << n;
    std::filesystem::remove(folder / "colour_104.png");
    EXPECT_TRUE(has_words(refusal(folder), "colour_104.png (colour, frame 2): is missing"));
}

TEST_F(ImageFolder, NamesMisfitImages) {
    write_folder(folder, folder_scene(all_source), 3, {true, true, true});
    Samples memory;
    const auto refused = [&](const std::string& name, const PlaneView& image) {
        const std::string before = read_bytes(folder / name);
        EXPECT_EQ(message(write_png(folder / name, image)), "");
        const std::string error = refusal(folder);
        EXPECT_TRUE(has_words(error, name));
        write_bytes(folder / name, before);
        return error;
    };
    const std::string size = std::to_string(columns) + "x" + std::to_string(rows);
    EXPECT_TRUE(has_words(refused("depth_001.png", grey(memory, columns + 1, rows, 2)),
                          "(depth, frame 1): is 25x18 gray16be, but frame 0 is " + size));
    EXPECT_TRUE(has_words(refused("depth_000.png", grey(memory, columns + 1, rows, 2)),
                          "(depth, frame 0): is 25x18, but the scene is " + size));
    EXPECT_TRUE(
        has_words(refused("colour_001.png", test_plane(memory, columns + 1, rows, 1, 3, 255, 1, true)),
                  "(colour, frame 1): is 25x18 rgb24, but frame 0 is " + size));
    EXPECT_TRUE(has_words(refused("colour_001.png", grey(memory, columns, rows)),
                          "(colour, frame 1): is " + size + " gray, but frame 0 is " + size + " rgb24"));
    EXPECT_TRUE(has_words(refused("depth_001.png", grey(memory, columns, rows)),
                          "(depth, frame 1): is " + size + " gray, but"));
    EXPECT_TRUE(has_words(refused("depth_000.png", grey(memory, columns, rows)),
                          "is 8-bit grey, but the scene's depth.bits, 16, needs 16-bit grey"));
    EXPECT_TRUE(
        has_words(refused("haptic_000.png", grey(memory, columns, rows, 2)),
                  "(haptic, frame 0): is 16-bit grey; haptic is 8-bit RGB, or grey for stiffness alone"));
    EXPECT_TRUE(has_words(refused("colour_000.png", grey(memory, columns, rows, 2)),
                          "(colour, frame 0): is 16-bit grey; colour is"));
    EXPECT_TRUE(has_words(refused("height_000.png", test_plane(memory, columns, rows, 1, 3, 255, 1, true)),
                          "(height, frame 0): is 8-bit RGB, but"));
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
                   png_chunk("PLTE", is_grey ? "\x20\x20\x20\x41\x41\x41" : "\x20\x20\x20\x41\x72\x41"));
}

TEST_F(ImageFolder, ReadsGreyPalettesOnly) {
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
        EXPECT_TRUE(has_words(refusal(folder), std::string(name) + " (" + std::string(name).substr(0, 5)));
        EXPECT_TRUE(has_words(refusal(folder), "RGB"));
    }
}

/// Whichever of a frame's pictures was looked at first.
TEST_F(ImageFolder, NamesFirstDamagedPlane) {
    write_folder(folder, folder_scene(all_source), 3, {true, true, true});
    const std::string whole = read_bytes(folder / "depth_001.png");
    write_bytes(folder / "depth_001.png", whole.substr(0, whole.size() / 2));
    EXPECT_TRUE(has_words(refusal(folder), "depth_001.png: is cut short (depth, frame 1)"));
    for (const char* plane : {"depth", "colour", "haptic", "height"})
        write_bytes(folder / (std::string(plane) + "_001.png"), "");
    for (const char* plane : {"depth", "colour", "haptic"}) {
        const std::string file = std::string(plane) + "_001.png";
        for (int round = 0; round < 5; ++round)
            EXPECT_TRUE(has_words(refusal(folder), file + ": is empty (" + plane + ", frame 1)"));
        write_bytes(folder / file, read_bytes(folder / (std::string(plane) + "_000.png")));
    }
    write_bytes(folder / "height_001.png", read_bytes(folder / "height_000.png"));
    EXPECT_EQ(refusal(folder), "");
}

TEST_F(ImageFolder, RefusesDepthBeyondBits) {
    write_folder(folder, folder_scene(depth_only_source, 16), 2, {});
    write_bytes(folder / "scene.json", scene_to_json(folder_scene(depth_only_source, 10)));
    EXPECT_TRUE(has_words(refusal(folder), "depth.bits, 10, allows at most 1023"));
}

TEST_F(ImageFolder, FindsMissingFarPlane) {
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
        auto reader = must(open_clip(folder / "scene.json"));
        EXPECT_DOUBLE_EQ(reader->scene().depth.far, 0.25 * deepest * 1.05);
        EXPECT_EQ(reader->scene().depth.valid_max, std::min<int>(65535, int(deepest * 1.05)));
        EXPECT_EQ(message(validate(reader->scene())), "");
        EXPECT_TRUE(has_words(reader->notes().back(), "depth.far is "));
    }
}

TEST_F(ImageFolder, OpensUnnumberedAsOneFrame) {
    write_folder(folder, folder_scene(all_source), 1, {true, true, true});
    const auto numbered = must(read_clip(folder / "scene.json"));
    for (const char* name : {"depth", "colour", "haptic", "height"})
        std::filesystem::rename(folder / (std::string(name) + "_000.png"),
                                folder / (std::string(name) + ".png"));
    const FolderSource still{"depth.png", "colour.png", "haptic.png", "height.png", 0, 0};
    write_bytes(folder / "scene.json", scene_to_json(folder_scene(still)));
    auto reader = open_clip(folder.path());  // a folder with a scene.json describes itself
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), 1);
    const auto frames = must(read_all(**reader));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_TRUE(same_frame(frames.front(), numbered.front()));
    const FolderSource second{"depth.png", "", "", "", 1, 0}, two{"depth.png", "", "", "", 0, 2},
        mixed{"depth.png", "colour_%d.png", "", "", 0, 0};
    for (const FolderSource& wrong : {second, two, mixed}) {
        write_bytes(folder / "scene.json", scene_to_json(folder_scene(wrong)));
        EXPECT_NE(message(open_clip(folder.path())), "");
    }
}

/// A map of the ground that is not filmed.
TEST_F(ImageFolder, UsesStillForAllFrames) {
    write_folder(folder, folder_scene(all_source), 3, {true, true, true});
    auto expected = must(read_clip(folder / "scene.json"));
    for (const char* name : {"haptic", "height"})
        std::filesystem::rename(folder / (std::string(name) + "_000.png"),
                                folder / (std::string(name) + ".png"));
    write_bytes(
        folder / "scene.json",
        scene_to_json(folder_scene({"depth_%03d.png", "colour_%03d.png", "haptic.png", "height.png", 0, 0})));
    auto reader = must(open_clip(folder.path()));
    EXPECT_EQ(reader->frame_count(), 3);
    EXPECT_EQ(reader->inputs().size(), 2 * 3U + 2 + 1);
    const auto frames = must(read_all(*reader));
    ASSERT_EQ(frames.size(), 3U);
    for (std::size_t n = 0; n < 3; ++n) {
        expected[n].haptic = expected.front().haptic;
        expected[n].height = expected.front().height;
        EXPECT_TRUE(same_frame(frames[n], expected[n])) << n;
    }
    // The same as a clip: of each frame, from anywhere.
    write_frames(create_clip(folder / "clip.mkv", reader->scene(), exact_clip), frames);
    const auto clip = must(read_clip(folder / "clip.mkv"));
    ASSERT_EQ(clip.size(), 3U);
    EXPECT_TRUE(same_frame(clip[2], frames[2]));
    std::filesystem::remove(folder / "haptic.png");
    EXPECT_TRUE(has_words(refusal(folder), "haptic.png (haptic, frame 0): is missing"));
}

TEST_F(ImageFolder, TakesGreyHapticAsStiffness) {
    Scene scene = folder_scene({"depth_%03d.png", "", "haptic.png", "", 0, 0});
    scene.haptic.stiffness = {0.5, 3};
    scene.default_properties = {700, 0.37, 0.21};
    write_folder(folder, scene, 2, {});
    Samples memory;
    const PlaneView map = grey(memory, columns, rows);
    ASSERT_EQ(message(write_png(folder / "haptic.png", map)), "");
    auto reader = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(
        *reader, "haptic is grey: stiffness alone, 0.5 to 3 N/mm; friction 0.37 static, 0.21 dynamic"));
    const auto frame = must(reader->next());
    const HapticRanges& felt = reader->scene().haptic;
    for (const auto& [x, y] : {std::pair{0, 0}, {columns - 1, rows - 1}, {7, 5}}) {
        const PlaneView& rgb = frame->haptic;
        const HapticProperties properties = felt.at(static_cast<std::uint8_t>(rgb.sample(x, y, 0)),
                                                    static_cast<std::uint8_t>(rgb.sample(x, y, 1)),
                                                    static_cast<std::uint8_t>(rgb.sample(x, y, 2)));
        EXPECT_DOUBLE_EQ(properties.stiffness, 500 + 2500 * map.sample(x, y) / 255.0);
        EXPECT_EQ(properties.static_friction, 0.37);
        EXPECT_EQ(properties.dynamic_friction, 0.21);
    }
}

TEST_F(ImageFolder, RefusesInvalidDescriptions) {
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

/// Folders as data sets have them, of small pictures.
class GuessedFolder : public ::testing::Test {
protected:
    void depth(const std::string& name, int least = 400) const {
        write_in_folder(folder / name,
                        made_image(16, 12, 2, 1, [&](int x, int, int) { return least + 10 * x; }));
    }
    void colour(const std::string& name, std::uint8_t red = 9) const {
        write_in_folder(folder / name, even_image(16, 12, 1, 3, red));
    }
    GuessedScene guess(const std::string& preset = "") const {
        auto guessed = must(guess_folder(folder.path(), stated(&SourceDescription::preset, preset)));
        EXPECT_EQ(lost_kinds(guessed.scene.remarks), "");
        return guessed;
    }
    std::vector<RawFrame> frames() const { return must(read_clip(folder.path())); }
    TemporaryFolder folder;
};

TEST_F(GuessedFolder, PairsTumByLists) {
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
    EXPECT_EQ(guess().scene.depth.scale, 1.0 / 5000) << "such lists come with such codes";
    const auto read = frames();
    ASSERT_EQ(read.size(), 4U);
    // 100, 133, 166, 199 ms beside 95, 115, 135, 155, 175, 195.
    const int nearest[] = {0, 2, 4, 5};
    for (std::size_t n = 0; n < 4; ++n) {
        EXPECT_EQ(read[n].depth.sample(0, 0), 4000 + static_cast<int>(n));
        EXPECT_EQ(read[n].colour.row(0)[0], nearest[n]) << n;
    }
}

TEST_F(GuessedFolder, KeepsFramesAroundGaps) {
    for (const int n : {3, 4, 7, 100}) {
        depth("depth/" + std::to_string(n) + ".png", 500 + n);
        colour("color/" + std::to_string(n) + ".png", static_cast<std::uint8_t>(n));
    }
    const auto read = frames();
    ASSERT_EQ(read.size(), 4U);
    EXPECT_EQ(read[3].depth.sample(0, 0), 600);
    EXPECT_EQ(read[3].colour.row(0)[0], 100);
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
        EXPECT_EQ(doubt->kind, RemarkKind::unit_doubt);
        EXPECT_EQ(lost_kinds({*doubt}), "");
    }
}

TEST_F(GuessedFolder, HasOneDescription) {
    depth("depth.png");
    write_bytes(folder / "scene.json", scene_to_json(guess()));
    EXPECT_TRUE(is_refused(open_clip(folder.path(), std::nullopt, stated(&SourceDescription::fov, 50)),
                           "describes these pictures"));
}

/// As ARKitScenes has them: each frame has a camera of its own, and cameras of other pictures lie beside.
TEST_F(GuessedFolder, TakesArkitFrameCameras) {
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
    EXPECT_TRUE(has_remark(
        guessed.scene, "that of lowres_wide_intrinsics/41048190_*.pincam, the median (a scene file says"));
    EXPECT_TRUE(has_remark(guessed.scene, "depth is as preset arkitscenes has it"));
    const auto read = frames();
    ASSERT_EQ(read.size(), 5U);
    EXPECT_EQ(read[3].depth.sample(0, 5), 1003);
    // 26 / 20 of the way from the centre: columns 0 and 15 are beyond, 1 is 0.95 from column -1.
    EXPECT_EQ(read[4].depth.sample(0, 5), 0);
    EXPECT_EQ(read[4].depth.sample(15, 5), 0);
    EXPECT_EQ(read[4].depth.sample(2, 5), 1004) << "7.5 - 5.5 x 1.3 = 0.35";
    EXPECT_EQ(read[4].depth.sample(12, 5), 1004 + 130) << "7.5 + 4.5 x 1.3 = 13.35";
    const auto told =
        must(guess_folder(folder.path(), stated(&SourceDescription::intrinsics, Intrinsics{30, 30})));
    EXPECT_EQ(told.scene.folder->cameras, "") << "the camera is stated";
    EXPECT_EQ(told.scene.camera.fx, 30);
    write_bytes(folder / "lowres_wide_intrinsics/41048190_3379.143.pincam", "16 12 20\n");
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "41048190_3379.143.pincam: has no camera"));
}

std::string remarks_in(const GuessedScene& guessed) {
    std::string text;
    for (const Remark& remark : guessed.scene.remarks) text += remark_in_words(remark) + '\n';
    return text;
}

TEST_F(GuessedFolder, NamesOtherTakes) {
    for (const char* take : {"t1/", "t2/", "t3/"})
        for (const char* number : {"1", "2", "3"}) {
            if (*number == '3' && take != std::string("t2/")) continue;
            depth(take + std::string("depth_") + number + ".png");
            if (take != std::string("t2/")) colour(take + std::string("color_") + number + ".png");
        }
    const GuessedScene guessed = guess();
    EXPECT_EQ(guessed.scene.folder->depth, "t2/depth_*.png");
    EXPECT_EQ(guessed.scene.folder->colour, "") << "another take's";
    EXPECT_TRUE(has_words(remarks_in(guessed), "left out: t1/, t3/ (name one of these to open it)"));
    colour("rgb/1.png");
    colour("rgb/2.png");
    EXPECT_EQ(guess().scene.folder->colour, "rgb/*.png");
    for (const char* take : {"t1", "t3"}) std::filesystem::remove_all(folder / take);
    EXPECT_EQ(remarks_in(guess()).find("left out"), std::string::npos);
    write_bytes(folder / "depth.txt", "0.1 t2/depth_1.png\n0.2 t2/depth_2.png\n");
    EXPECT_EQ(guess().scene.folder->depth, "depth.txt");
    EXPECT_EQ(remarks_in(guess()).find("left out"), std::string::npos) << "those that it names";
}

TEST_F(GuessedFolder, NotesColourOfAnotherCamera) {
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
    std::filesystem::remove(folder / "camera_color.json");
    for (const char* name : {"color_1.png", "color_2.png"})
        write_in_folder(folder / name,
                        made_image(32, 18, 1, 3, [](int x, int y, int c) { return x + y + 50 * c; }));
    EXPECT_TRUE(says("it is stretched to their shape from 32x18")) << remarks_in(guess());
    for (const char* number : {"1", "2"})
        std::filesystem::remove(folder / (std::string("color_") + number + ".png"));
    EXPECT_FALSE(says("")) << "there is no colour";
}

/// As ViSP stores them. Colour's pixels are half as large, and its lens is 20 mm to the right of depth's.
TEST_F(GuessedFolder, RegistersColourOfVisp) {
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
    EXPECT_TRUE(
        has_words(remarks_in(found), "as depth_M_color.txt and box.xml say, by the unit that is guessed"));
    // No rotation: colour is left where it is.
    write_bytes(folder / "depth_M_color.txt", "1 0 0 0.02\n0 3 0 0\n0 0 1 0\n0 0 0 1\n");
    EXPECT_FALSE(guess().scene.colour_camera);
    EXPECT_TRUE(has_words(remarks_in(guess()), "colour lies on depth's pixels, though"));
}

TEST_F(GuessedFolder, PointsToPicturesElsewhere) {
    const auto refusal = [&] { return message(open_clip(folder.path())); };
    colour("a b/seq/rgb/1.png");
    depth("a b/seq/depth/1.png");
    EXPECT_TRUE(has_words(refusal(), "a folder further down has pictures: touchable play '" +
                                         (folder / "a b").string() + "')"));
    depth("c/d/e/1.png");
    EXPECT_TRUE(has_words(refusal(), "one of 2 such folders"));
    write_bytes(folder / "Test.mov", "");
    EXPECT_TRUE(has_words(refusal(), "but a video: touchable play " + (folder / "Test.mov").string() + ')'));
    for (const char* name : {"Zoo.mov", "Zoo_depth.mov"}) write_bytes(folder / name, "");
    EXPECT_TRUE(
        has_words(refusal(), "but videos: touchable play " + (folder / "Zoo_depth.mov").string() + ')'));
    for (const char* name : {"Zoo.mov", "Zoo_depth.mov"}) std::filesystem::remove(folder / name);
    write_bytes(folder / "Test.Metadata.asset", "{\"_versionMajor\": 0}");
    const std::string asset = message(open_clip(folder / "Test.Metadata.asset"));
    EXPECT_TRUE(has_words(asset, "touchable play " + (folder / "Test.mov").string()));
    std::filesystem::remove(folder / "Test.mov");
    EXPECT_EQ(message(open_clip(folder / "Test.Metadata.asset")).find("touchable play"), std::string::npos);
}

/// A camera's matrix as an array is no picture, in whatever folder.
TEST_F(GuessedFolder, SkipsMatrices) {
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
    EXPECT_FALSE(has_remark(guessed.scene, "left out"));
    EXPECT_TRUE(has_remark(guessed.scene, "and not used: camK.npy, camera.npz, depth/camK.npy"));
}

TEST_F(GuessedFolder, NamesPicturesWithoutDepth) {
    colour("holiday/1.png");
    colour("holiday/2.png");
    EXPECT_TRUE(is_refused(open_clip(folder.path()),
                           "no pictures of depth were found (there are 2 x holiday/*.png)"));
    // Deep, but by their names of other things; depth beside them, or in a folder so named, is depth.
    for (const char* name : {"1.instance.png", "2.instance.png", "semantic/1.png", "semantic/2.png"})
        depth(name);
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "no pictures of depth were found"));
    for (const char* name : {"instances/depth_1.png", "instances/depth_2.png"}) depth(name);
    for (const char* name : {"instances/rgb_1.png", "instances/rgb_2.png"}) colour(name);
    EXPECT_EQ(guess().scene.folder->depth, "instances/depth_*.png");
    EXPECT_EQ(guess().scene.folder->colour, "instances/rgb_*.png");
    const TemporaryFolder empty;
    EXPECT_TRUE(is_refused(open_clip(empty.path()), "there are no pictures"));
}

/// As Depth Anything leaves them: under the names of the pictures that it was given.
TEST_F(GuessedFolder, TakesGreyByPreset) {
    const auto grey = [&](const std::string& name) {
        write_in_folder(folder / name,
                        made_image(16, 12, 1, 1, [](int x, int y, int) { return 16 * y + x; }));
    };
    for (const char* n : {"0", "1", "2"}) grey("vis_depth/frame_" + std::string(n) + ".png");
    EXPECT_EQ(message(open_clip(folder / "vis_depth")), "");
    std::filesystem::rename(folder / "vis_depth", folder / "out");
    for (const char* n : {"0", "1", "2"}) colour("out/rgb/frame_" + std::string(n) + ".png");
    const auto refused = guess_folder(folder / "out", {});
    EXPECT_TRUE(is_refused(refused, "a preset says so"));
    const auto guessed =
        must(guess_folder(folder / "out", stated(&SourceDescription::preset, "relative-inverse")));
    EXPECT_EQ(guessed.scene.folder->depth, "frame_*.png");
    EXPECT_EQ(guessed.scene.folder->colour, "rgb/frame_*.png");
    EXPECT_EQ(guessed.scene.stored.kind, StoredDepth::Kind::relative);
}

/// As MiDaS writes them: PFM has its lowest row first, and what is near has large values.
TEST_F(GuessedFolder, DoubtsFloatsLargeBelow) {
    const auto pfm = [&](bool is_large_below) {
        const std::string bytes =
            pfm_of(16, 12, [&](int, int y) { return 200 + 10 * (is_large_below ? y : 11 - y); });
        write_bytes(folder / "depth_0.pfm", bytes);
        write_bytes(folder / "depth_1.pfm", bytes);
    };
    const auto is_doubted = [&](const GuessedScene& guessed) {
        return has_remark(guessed.scene, "as 1/depth of networks is");
    };
    pfm(true);
    EXPECT_TRUE(is_doubted(guess()));
    EXPECT_FALSE(is_doubted(guess("relative-inverse")));
    EXPECT_EQ(guess("relative-inverse").scene.stored.kind, StoredDepth::Kind::relative);
    pfm(false);
    EXPECT_FALSE(is_doubted(guess()));
}

/// As Marigold guesses it: from 0, the nearest, to 1. Others guess 1/depth, 1 the nearest.
TEST_F(GuessedFolder, TellsDepthFromInverseDepth) {
    for (const bool is_near_high : {false, true}) {
        const std::string bytes = pfm_of(16, 12, [&](int x, int y) {
            const double share = (16 * (11 - y) + x) / 191.0;
            return is_near_high ? 1 - share : share;
        });
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
