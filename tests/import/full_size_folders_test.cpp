// SPDX-License-Identifier: Apache-2.0
// Colour of a camera of its own, and lenses that bend: brought onto the pixels of one pinhole camera.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/clip/clip_file.hpp"
#include "engine/formats/pinhole_frames.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/limits.hpp"
#include "tests/picture/results.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"

namespace touchable::test {
namespace {

/// A camera of f pixels, codes of millimetres, 0 is none.
Scene metric_scene(int width, int height, double f) {
    Scene scene = small_scene(width, height, 16);
    scene.metres_per_unit = 1;
    scene.camera = {f, f, 0.5 * (width - 1), 0.5 * (height - 1)};
    scene.depth = {};
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 0.001;
    scene.depth.far = 60;
    scene.depth.code_max = 65535;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    return scene;
}

Image words(int width, int height, std::uint16_t value) {
    return even_image(width, height, 2, 1, value);
}
void set_word(Image& image, int x, int y, std::uint16_t value) {
    std::memcpy(image.samples.data() + 2 * (y * image.width + x), &value, 2);
}

/// A square at 1 m before a wall at 2 m; the colour camera is 0.1 m to the right. So the square is 10 pixels
/// to the left for it, the wall 5: it sees 5 pixels of the wall more at the right of the square, and 5 less
/// at its left.
TEST(ColourRegistration, GreysHiddenPixels) {
    constexpr int width = 60, height = 20, left = 30, right = 40;  // columns of the square
    Scene scene = metric_scene(width, height, 100);
    scene.colour_camera.emplace();
    scene.colour_camera->camera = scene.camera;
    scene.colour_camera->width = width;
    scene.colour_camera->height = height;
    scene.colour_camera->from_depth.translation = {-0.1, 0, 0};
    Image depth = words(width, height, 2000);
    for (int y = 0; y < height; ++y)
        for (int x = left; x < right; ++x) set_word(depth, x, y, 1000);
    const Image colour = made_image(width, height, 1, 3, [](int x, int y, int c) {
        const bool is_square = x >= left - 10 && x < right - 10;
        return c == 0 ? (is_square ? 200 : x) : c == 1 ? (is_square ? 10 : 100) : y;
    });
    for (const int x : {33, 34, 35}) set_word(depth, x, 7, 0);  // holes: in the square, and at its edge
    set_word(depth, left, 9, 0);
    ColourRegistration registration(scene);
    const Image made = registration.registered(depth.view(), colour.view());
    int hidden = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int red = made.view().sample(x, y, 0);
            if (x >= left && x < right) {
                ASSERT_EQ(red, 200) << x << ", " << y;
            } else if (x < 5) {
                ASSERT_EQ(red, 128) << "beyond the picture's edge";
            } else if (x < left - 8 || x >= right) {  // up to three pixels of doubt beside the square
                ASSERT_EQ(red, x - 5) << x << ", " << y;
            } else if (red != x - 5 || x >= left - 5) {
                ASSERT_EQ(red, 128) << x << ", " << y;
                ++hidden;
            }
        }
    EXPECT_NEAR(hidden / double{height}, 5 + 1.5, 1.5);
    EXPECT_NEAR(registration.unseen_share(), (5 + 6.5) / 60., 1.5 / 60)
        << "at the picture's edge, and hidden";
    EXPECT_NEAR(registration.grey_share(), (5 + hidden / double{height}) / 60., 1e-9);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < 5; ++x) set_word(depth, x, y, 0);
    registration.look_at(depth.view());
    EXPECT_NEAR(registration.unseen_share(), 6.5 / 55., 1.5 / 55)
        << "of those with depth only what is hidden";
    EXPECT_NEAR(registration.grey_share(), (5 + hidden / double{height}) / 60., 1e-9)
        << "without depth as well";
}

/// A box at 0.6 m before a wall of stripes at 1.2 m, both as a camera `beside` metres to the right of depth's
/// sees them.
struct BoxBeforeStripes {
    static constexpr int width = 160, height = 60;
    static constexpr double box_depth = 0.6, wall_depth = 1.2, stripe = 0.032;  // 4 of depth's pixels
    static bool is_box(double x, double y, double eye) {  // a ray from (eye, 0), its direction at distance 1
        return std::abs(eye + x * box_depth) < 0.1013 && std::abs(y * box_depth) < 0.0613;
    }
    static int stripe_at(double wall_x) {
        return (static_cast<int>(std::floor(wall_x / stripe)) % 3 + 3) % 3;
    }

    explicit BoxBeforeStripes(double beside) : scene(metric_scene(width, height, 150)) {
        ColourCamera& camera = scene.colour_camera.emplace();
        camera.width = 400;
        camera.height = 150;
        camera.camera = {240, 240, 199.5, 74.5};
        camera.from_depth.translation = {-beside, 0, 0};
        depth = words(width, height, 1200);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if (is_box(column(x), row(y), 0)) set_word(depth, x, y, 600);
        colour = made_image(camera.width, camera.height, 1, 3, [&](int x, int y, int) {
            const double u = (x - 199.5) / 240;
            return is_box(u, (y - 74.5) / 240, beside) ? 250 : 20 + 30 * stripe_at(beside + u * wall_depth);
        });
    }
    double column(double x) const { return (x - scene.camera.cx) / scene.camera.fx; }
    double row(double y) const { return (y - scene.camera.cy) / scene.camera.fy; }
    /// The true colour of a pixel, or, at a border, of one that is half a pixel away.
    bool is_true(int x, int y, int red) const {
        for (const double dx : {-0.5, 0.0, 0.5})
            for (const double dy : {-0.5, 0.0, 0.5})
                if (is_box(column(x), row(y), 0)) {
                    const bool box = is_box(column(x + dx), row(y + dy), 0);
                    if (red == 250 || (!box && red < 100)) return true;
                } else if (red == 20 + 30 * stripe_at(column(x + dx) * wall_depth)) {
                    return true;
                }
        return false;
    }

    Scene scene;
    Image depth, colour;
};

TEST(ColourRegistration, GivesTrueColourOrNone) {
    for (const double beside : {0.05, -0.05}) {
        const BoxBeforeStripes seen(beside);
        ColourRegistration registration(seen.scene);
        const Image made = registration.registered(seen.depth.view(), seen.colour.view());
        int grey = 0, box_rows = 0;
        for (int y = 0; y < seen.height; ++y) {
            box_rows += seen.is_box(0, seen.row(y), 0);
            for (int x = 0; x < seen.width; ++x) {
                const int red = made.view().sample(x, y, 0);
                grey += red == 128;
                if (red != 128) {
                    ASSERT_TRUE(seen.is_true(x, y, red)) << x << ", " << y << ": " << red;
                }
            }
        }
        // 6.25 pixels beside the box are hidden, and up to three more are in doubt.
        EXPECT_GT(grey, 6 * box_rows);
        EXPECT_LT(grey, 10 * box_rows);
    }
}

/// Depth cameras miss what is at edges: the box hides the wall there all the same.
TEST(ColourRegistration, HidesBehindWhatHasNoDepth) {
    for (const double beside : {0.05, -0.05}) {
        BoxBeforeStripes seen(beside);
        for (int y = 0; y < seen.height; ++y)
            for (int x = 0; x < seen.width; ++x) {
                const auto is_box = [&](int at) { return seen.is_box(seen.column(at), seen.row(y), 0); };
                if (is_box(x) && (!is_box(x - 4) || !is_box(x + 4))) set_word(seen.depth, x, y, 0);
            }
        ColourRegistration registration(seen.scene);
        const Image made = registration.registered(seen.depth.view(), seen.colour.view());
        for (int y = 0; y < seen.height; ++y)
            for (int x = 0; x < seen.width; ++x) {
                const bool is_wall = !seen.is_box(seen.column(x), seen.row(y), 0);
                ASSERT_FALSE(is_wall && made.view().sample(x, y, 0) == 250)
                    << "the box's colour on the wall at " << x << ", " << y;
            }
        EXPECT_LT(registration.grey_share(), 0.12);
    }
}

TEST(ColourRegistration, FillsOnlyDoubtfulPixels) {
    const BoxBeforeStripes seen(0);
    ColourRegistration registration(seen.scene);
    const Image made = registration.registered(seen.depth.view(), seen.colour.view());
    int grey = 0;
    for (int y = 0; y < seen.height; ++y)
        for (int x = 0; x < seen.width; ++x) {
            const int red = made.view().sample(x, y, 0);
            const bool is_box = seen.is_box(seen.column(x), seen.row(y), 0);
            grey += red == 128;
            ASSERT_TRUE(is_box || red < 100 || red == 128)
                << "the box's colour on the wall at " << x << ", " << y;
        }
    EXPECT_LE(grey, 16) << "at its corners";
}

TEST(ColourRegistration, AllocatesNothingForClaimedSizes) {
    constexpr int side = 16384;
    Scene scene = metric_scene(side, side, 100);
    scene.colour_camera.emplace();
    scene.colour_camera->camera = scene.camera;
    scene.colour_camera->width = scene.colour_camera->height = side;
    const LimitedMemory limited(64);
    EXPECT_NO_THROW(ColourRegistration{scene});
}

/// The place of a pixel's point in the colour picture, by a plain loop with arithmetic of its own.
struct Twin {
    double x, y, depth;
};
Twin twin_of(const Scene& scene, const double (&to_depth)[4][4], double x, double y, double length) {
    const long double p[3] = {(x - scene.camera.cx) / scene.camera.fx * length - to_depth[0][3],
                              (y - scene.camera.cy) / scene.camera.fy * length - to_depth[1][3],
                              length - to_depth[2][3]};
    long double q[3] = {};  // the inverse of a rotation is its transpose
    for (int row = 0; row < 3; ++row)
        for (int k = 0; k < 3; ++k) q[row] += static_cast<long double>(to_depth[k][row]) * p[k];
    const Camera& camera = scene.colour_camera->camera;
    return {static_cast<double>(camera.fx * q[0] / q[2] + camera.cx),
            static_cast<double>(camera.fy * q[1] / q[2] + camera.cy), static_cast<double>(q[2])};
}

constexpr double castle_to_depth[4][4] = {{0.9999922514, -0.003901827615, -0.000573842437, -0.02470519207},
                                          {0.003898504889, 0.9999762774, -0.005681734998, 0.0006583171198},
                                          {0.0005959979608, 0.005679453723, 0.9999836683, -0.003773850389},
                                          {0, 0, 0, 1}};

std::string castle_scene() {
    char exact[1024];
    int at = 0;
    for (const auto& row : castle_to_depth)
        for (const double term : row)
            at += std::snprintf(exact + at, sizeof exact - static_cast<std::size_t>(at), "%s%.17g",
                                at ? "," : "", term);
    return R"({"touchable_scene": 1, "width": 640, "height": 480, "rate": [30, 1], "metres_per_unit": 1,
        "camera": {"fx": 476.0536, "fy": 476.0535, "cx": 311.4846, "cy": 246.2832},
        "colour_camera": {"width": 640, "height": 480, "fx": 615.167, "fy": 615.168, "cx": 312.189,
            "cy": 243.437, "to_depth": [)" +
           std::string(exact) + R"(]},
        "depth": {"coding": "metric", "scale": 0.000124986647, "near": 0.2, "far": 1.5, "invalid": [0]},
        "folder": {"depth": "depth_%04d.png", "colour": "image_%04d.png", "count": 2}})";
}

void expect_colour_where_a_plain_twin_has_it(const std::filesystem::path& castle) {
    const TemporaryFolder folder;
    write_bytes(folder / "castle.json", castle_scene());
    const auto [reader, frames] = must_read(open_clip(castle, folder / "castle.json"));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_FALSE(reader->scene().colour_camera) << "colour has depth's pixels now";
    const auto described = must(parse_scene(castle_scene(), "scene"));
    const Scene* const scene = &described.scene;
    const Image depth = *read_image(castle / "depth_0001.png"), grey = *read_image(castle / "image_0001.png");
    EXPECT_TRUE(same_plane(frames.at(1).depth, depth.view())) << "depth is never resampled";
    const auto twin = [&](int x, int y, int beside = 0) {
        const std::uint16_t code = depth.view().sample(x + beside, y);
        return scene->depth.is_valid(code) ? twin_of(*scene, castle_to_depth, x, y, 0.000124986647 * code)
                                           : Twin{0, 0, 0};
    };
    // A surface may go on into what has no depth for four pixels beside it.
    const auto nearest_twin = [&](int x, int y) {
        Twin nearest = twin(x, y);
        for (int beside = -4; beside <= 4 && !(twin(x, y).depth > 0); ++beside)
            if (const Twin at = twin(x, y, beside);
                at.depth > 0 && (!(nearest.depth > 0) || at.depth < nearest.depth))
                nearest = at;
        return nearest;
    };
    // Seen for certain: nothing that appears within four pixels is nearer by more than 1.5 %.
    int compared = 0;
    for (int y = 6; y < 474; y += 4)
        for (int x = 64; x < 576; x += 4) {
            const Twin at = twin(x, y);
            const double column = std::floor(at.x + 0.5), row = std::floor(at.y + 0.5);
            bool is_certain = at.depth > 0 && at.x > 0 && at.y > 0 && at.x < 639 && at.y < 479 &&
                              std::abs(at.x + 0.5 - std::round(at.x + 0.5)) > 1e-3 &&
                              std::abs(at.y + 0.5 - std::round(at.y + 0.5)) > 1e-3;
            for (int dy = -4; dy <= 4 && is_certain; ++dy)
                for (int dx = -60; dx <= 60; ++dx) {
                    const Twin other = nearest_twin(x + dx, y + dy);
                    if (other.depth > 0 && std::abs(other.x - at.x) < 4 && std::abs(other.y - at.y) < 4 &&
                        other.depth < at.depth * 0.985)
                        is_certain = false;
                }
            if (!is_certain) continue;
            ++compared;
            const int expected = grey.view().sample(static_cast<int>(column), static_cast<int>(row));
            ASSERT_EQ(frames.at(1).colour.sample(x, y, 0), expected) << x << ", " << y;
        }
    EXPECT_GT(compared, 2000);
}

using PinholeFrames = FolderTest;

TEST_F(PinholeFrames, MatchTwinOfCastle) {
    const auto castle = real_data("castel_sr300");
    TOUCHABLE_NEEDS_DATA(castle);
    expect_colour_where_a_plain_twin_has_it(castle);
}

/// The depth of the castle's stand-in, as large as the castle's.
StandIn large_castle(int frames) {
    StandIn what = stand_in("castel_sr300");
    what.frames = frames;
    what.width = 640;
    what.height = 480;
    return what;
}

TEST_F(PinholeFrames, MatchTwinOfStandIn) {
    write_stand_in(folder.path(), large_castle(2));
    expect_colour_where_a_plain_twin_has_it(folder.path());
}

/// As `info` opens a clip.
TEST_F(PinholeFrames, NoteUnseenPixelsWithoutColour) {
    write_stand_in(folder.path(), large_castle(2));
    write_bytes(folder / "castle.json", castle_scene());
    std::string with_colour;
    for (const Colour colour : {Colour::wanted, Colour::left_out}) {
        const auto reader = must(open_clip(folder.path(), folder / "castle.json", {}, colour));
        const auto& notes = reader->notes();
        const auto note = std::find_if(notes.begin(), notes.end(), [](const std::string& each) {
            return each.find("its camera does not see ") != std::string::npos;
        });
        ASSERT_NE(note, notes.end());
        EXPECT_EQ(note->find("not see 0 %"), std::string::npos) << *note;
        if (colour == Colour::wanted)
            with_colour = *note;
        else
            EXPECT_EQ(*note, with_colour);
    }
}

TEST_F(PinholeFrames, KeepColourCameraInScene) {
    auto described = must(parse_scene(castle_scene(), "scene"));
    Scene& scene = described.scene;
    scene.lens.terms = {0.1, -0.2, 0.003, 0.004, 0.05, 0.06, 0.07, 0.08};
    scene.colour_camera->lens.terms = {0.01, 0.02};
    const auto again = must(parse_scene(scene_to_json(described), "again"));
    EXPECT_EQ(again.scene.lens, scene.lens);
    EXPECT_EQ(again.scene.colour_camera->lens, scene.colour_camera->lens);
    EXPECT_EQ(again.scene.colour_camera->from_depth, scene.colour_camera->from_depth);
    std::string skewed = castle_scene();
    skewed.replace(skewed.find("0.99999225"), 5, "0.5555");
    EXPECT_TRUE(is_refused(parse_scene(skewed, "scene"), "does not begin with a rotation"));
    std::string both = castle_scene();
    both.insert(both.find("\"to_depth\""), "\"from_depth\": [], ");
    EXPECT_TRUE(is_refused(parse_scene(both, "scene"), "left out where from_depth is given"));
}

/// The wall z = 2 m as a lens shows it, and a step of depth that is a straight line in the world.
TEST_F(PinholeFrames, StraightenEdges) {
    constexpr int width = 160, height = 120;
    Scene scene = metric_scene(width, height, 100);
    scene.lens.terms = {-0.25, 0.06, 0.002, -0.001};
    Image bent = words(width, height, 0);
    // For each stored pixel, the ray that the lens bends there: found by trying.
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double sx = (x - scene.camera.cx) / 100, sy = (y - scene.camera.cy) / 100;
            double px = sx, py = sy;
            for (int k = 0; k < 60; ++k) {
                const double r2 = px * px + py * py, radial = 1 - 0.25 * r2 + 0.06 * r2 * r2;
                px = (sx - 2 * 0.002 * px * py + 0.001 * (r2 + 2 * px * px)) / radial;
                py = (sy - 0.002 * (r2 + 2 * py * py) + 2 * 0.001 * px * py) / radial;
            }
            set_word(bent, x, y, px < 0.4 ? 2000 : 1000);
        }
    scene.folder.emplace().depth = "bent.png";
    ASSERT_EQ(message(write_png(folder / "bent.png", bent.view())), "");
    write_bytes(folder / "bent.json", scene_to_json(scene));
    auto reader = must(open_clip(folder / "bent.json"));
    EXPECT_FALSE(reader->scene().lens.any());
    const auto frames = must(read_all(*reader));
    for (int y = 10; y < height - 10; ++y) {
        int edge = width - 1;
        while (edge > 0 && frames.at(0).depth.sample(edge - 1, y) == 1000) --edge;
        while (frames.at(0).depth.sample(edge, y) != 1000) --edge;
        int first = edge;
        while (frames.at(0).depth.sample(first - 1, y) == 1000) --first;
        EXPECT_NEAR(first - 0.5, scene.camera.cx + 0.4 * 100, 1.2)
            << y;  // half a stored pixel, half of one here
    }
}

}  // namespace
}  // namespace touchable::test
