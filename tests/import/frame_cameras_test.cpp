// Frames with a camera each: brought onto the clip's, beside a plain twin and a plane in the world.
#include "engine/formats/camera_sidecar.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "engine/clip/clip_file.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int wide = 96, high = 72;
constexpr double unit = 0.0001;  // metres a code

struct Lens4 {
    long double fx, fy, cx, cy;
};
constexpr Lens4 of_clip{80, 81, 46.5L, 36.25L};
constexpr Lens4 of_frames[] = {of_clip, {84, 83, 49.8L, 33.55L}, {77, 85, 44, 36.25L}};
/// A tilted plane: a point (x, y, z) of it has a x + b y + c z = 1.
constexpr long double plane_a = 0.21L, plane_b = -0.13L, plane_c = 0.55L;

using DepthAt = std::function<long double(long double, long double)>;  // of a ray (u, v, 1)

long double planar_at(long double u, long double v) {
    return 1 / (plane_a * u + plane_b * v + plane_c);
}
long double range_at(long double u, long double v) {
    return planar_at(u, v) * std::sqrt(u * u + v * v + 1);
}

/// How a lens shows the ray (u, v): k1 and k2 alone.
struct Bent {
    long double k1 = 0, k2 = 0;
    long double radial(long double u, long double v) const {
        const long double r2 = u * u + v * v;
        return 1 + r2 * (k1 + r2 * k2);
    }
};

/// The ray that is shown at (u, v), by trying.
std::pair<long double, long double> ray_shown_at(const Bent& lens, long double u, long double v) {
    long double x = u, y = v;
    for (int k = 0; k < 30; ++k) {
        const long double radial = lens.radial(x, y);
        x = u / radial;
        y = v / radial;
    }
    return {x, y};
}

std::uint16_t code_of(const Lens4& camera, const Bent& lens, const DepthAt& depth, int x, int y) {
    const auto [u, v] = ray_shown_at(lens, (x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
    return static_cast<std::uint16_t>(std::floor(depth(u, v) / unit + 0.5L));
}

std::string camera_json(const Lens4& camera) {
    char text[160];
    std::snprintf(text, sizeof text, R"({"fx": %.17Lg, "fy": %.17Lg, "cx": %.17Lg, "cy": %.17Lg})", camera.fx,
                  camera.fy, camera.cx, camera.cy);
    return text;
}

std::string scene_json(const std::string& camera, const std::string& semantics,
                       const std::string& more = "") {
    return R"({"touchable_scene": 1, "width": 96, "height": 72, "rate": [30, 1], "metres_per_unit": 1,)" +
           (camera.empty() ? std::string() : "\"camera\": " + camera + ",") +
           R"("depth": {"coding": "metric", "scale": 0.0001, "invalid": [0], "near": 0.1, "far": 6, "semantics": ")" +
           semantics + R"("}, "height_map": {"max": 0.01, "units": "world"},
           "folder": {"depth": "d%d.png", "colour": "c%d.png", "haptic": "t%d.png", "height": "h%d.png")" +
           more + "}}";
}

/// Pictures of the plane by the cameras of the frames; of others each pixel says which it is.
void write_plane(const TemporaryFolder& folder, const Bent& lens, const DepthAt& depth) {
    for (int n = 0; n < 3; ++n) {
        Image codes{wide, high, 2, 1, {}}, colour{wide, high, 1, 3, {}}, height{wide, high, 1, 1, {}};
        for (int y = 0; y < high; ++y)
            for (int x = 0; x < wide; ++x) {
                const std::uint16_t code = code_of(of_frames[n], lens, depth, x, y);
                codes.samples.push_back(static_cast<std::uint8_t>(code & 255));
                codes.samples.push_back(static_cast<std::uint8_t>(code >> 8));
                colour.samples.insert(colour.samples.end(),
                                      {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                                       static_cast<std::uint8_t>(200 + n)});
                height.samples.push_back(static_cast<std::uint8_t>((7 * x + 11 * y) & 255));
            }
        const std::string number = std::to_string(n) + ".png";
        for (const auto& [name, image] :
             {std::pair{"d", &codes}, {"c", &colour}, {"t", &colour}, {"h", &height}})
            ASSERT_EQ(message(write_png(folder / (name + number), image->view())), "");
        write_bytes(folder / ("k" + std::to_string(n) + ".json"), camera_json(of_frames[n]));
    }
}

const std::string with_cameras = R"(, "cameras": "k%d.json")";

std::vector<std::string> notes_with(const ClipReader& reader, const std::string& words) {
    std::vector<std::string> found;
    for (const std::string& note : reader.notes())
        if (note.find(words) != std::string::npos) found.push_back(note);
    return found;
}

/// Where the clip's pixel was stored.
std::pair<long double, long double> stored_place(const Lens4& camera, const Bent& lens, int x, int y) {
    const long double u = (x - of_clip.cx) / of_clip.fx, v = (y - of_clip.cy) / of_clip.fy;
    const long double radial = lens.radial(u, v);
    return {camera.fx * u * radial + camera.cx, camera.fy * v * radial + camera.cy};
}

void expect_twin(const std::vector<RawFrame>& frames, const Bent& lens, const DepthAt& depth) {
    int beyond = 0;
    for (int n = 0; n < 3; ++n)
        for (int y = 0; y < high; ++y)
            for (int x = 0; x < wide; ++x) {
                const RawFrame& frame = frames[static_cast<std::size_t>(n)];
                const auto [column, row] = stored_place(of_frames[n], lens, x, y);
                const long double sx = std::floor(column + 0.5L), sy = std::floor(row + 0.5L);
                const auto is_tie = [](long double at) {
                    return std::abs(at + 0.5L - std::round(at + 0.5L)) < 1e-9L;
                };
                if (is_tie(column) || is_tie(row)) continue;
                if (sx < 0 || sy < 0 || sx >= wide || sy >= high) {
                    ++beyond;
                    ASSERT_EQ(frame.depth.sample(x, y), 0) << n << ": " << x << ", " << y;
                    continue;
                }
                const int from_x = static_cast<int>(sx), from_y = static_cast<int>(sy);
                ASSERT_EQ(frame.depth.sample(x, y), code_of(of_frames[n], lens, depth, from_x, from_y))
                    << n << ": " << x << ", " << y;
                for (const PlaneView* plane : {&frame.colour, &frame.haptic}) {
                    ASSERT_EQ(plane->sample(x, y, 0), from_x);
                    ASSERT_EQ(plane->sample(x, y, 1), from_y);
                    ASSERT_EQ(plane->sample(x, y, 2), 200 + n);
                }
                ASSERT_EQ(frame.height.sample(x, y), (7 * from_x + 11 * from_y) & 255);
            }
    EXPECT_GT(beyond, 100) << "a wider view than what was stored";
}

TEST(FrameCameras, AreBroughtOntoTheClipsAsAPlainTwinHasIt) {
    for (const bool is_range : {false, true})
        for (const Bent lens : {Bent{}, Bent{-0.2L, 0.05L}}) {
            const TemporaryFolder folder;
            const DepthAt depth = is_range ? range_at : planar_at;
            write_plane(folder, lens, depth);
            std::string camera = camera_json(of_clip);
            if (lens.k1 != 0) camera.insert(camera.size() - 1, R"(, "distortion": [-0.2, 0.05, 0, 0])");
            write_bytes(folder / "scene.json",
                        scene_json(camera, is_range ? "range" : "planar", with_cameras));
            auto reader = open_clip(folder.path());
            ASSERT_EQ(message(reader), "");
            EXPECT_EQ((*reader)->scene().camera, (Camera{80, 81, 46.5, 36.25}));
            const auto frames = read_all(**reader);
            ASSERT_EQ(message(frames), "");
            ASSERT_EQ(frames->size(), 3U);
            expect_twin(*frames, lens, depth);
            ASSERT_EQ(message((*reader)->seek(1)), "");
            const auto second = (*reader)->next();
            ASSERT_TRUE(second && *second);
            EXPECT_TRUE(same_frame(**second, frames->at(1))) << "whatever frame came before";
        }
}

/// As far off the plane as half a stored pixel across and down is.
TEST(FrameCameras, LeaveTheSurfaceWhereItIsToHalfAPixel) {
    for (const bool is_range : {false, true}) {
        const TemporaryFolder folder;
        const DepthAt depth = is_range ? range_at : planar_at;
        write_plane(folder, {}, depth);
        write_bytes(folder / "scene.json",
                    scene_json(camera_json(of_clip), is_range ? "range" : "planar", with_cameras));
        const auto frames = read_clip(folder.path());
        ASSERT_EQ(message(frames), "");
        const auto u_of = [](const Lens4& camera, long double x) { return (x - camera.cx) / camera.fx; };
        const auto v_of = [](const Lens4& camera, long double y) { return (y - camera.cy) / camera.fy; };
        long double worst = 0, worst_unmoved = 0;
        for (int n = 1; n < 3; ++n)
            for (int y = 0; y < high; ++y)
                for (int x = 0; x < wide; ++x) {
                    const int code = frames->at(static_cast<std::size_t>(n)).depth.sample(x, y);
                    if (code == 0) continue;
                    const long double truth = depth(u_of(of_clip, x), v_of(of_clip, y));
                    const auto [column, row] = stored_place(of_frames[n], {}, x, y);
                    long double allowed = 0.5L * unit + 1e-9L;
                    for (const long double dx : {-0.5L, 0.5L})
                        for (const long double dy : {-0.5L, 0.5L})
                            allowed = std::max(allowed, 0.5L * unit + 1e-6L +
                                                            std::abs(depth(u_of(of_frames[n], column + dx),
                                                                           v_of(of_frames[n], row + dy)) -
                                                                     truth));
                    ASSERT_LE(std::abs(unit * code - truth), allowed) << n << ": " << x << ", " << y;
                    worst = std::max(worst, std::abs(unit * code - truth));
                    const long double stored = depth(u_of(of_frames[n], x), v_of(of_frames[n], y));
                    worst_unmoved = std::max(worst_unmoved, std::abs(stored - truth));
                }
        EXPECT_LT(4 * worst, worst_unmoved) << "it is worth it";
    }
}

TEST(FrameCameras, ThatAreTheClipsChangeNoBit) {
    const TemporaryFolder folder;
    write_plane(folder, {}, planar_at);
    write_bytes(folder / "scene.json", scene_json(camera_json(of_clip), "planar"));
    const auto plain = read_clip(folder / "scene.json");
    ASSERT_EQ(message(plain), "");
    for (int n = 0; n < 3; ++n)
        write_bytes(folder / ("k" + std::to_string(n) + ".json"), camera_json(of_clip));
    for (const std::string& camera : {camera_json(of_clip), std::string()}) {
        write_bytes(folder / "scene.json", scene_json(camera, "planar", with_cameras));
        auto reader = open_clip(folder.path());
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ((*reader)->scene().camera, (Camera{80, 81, 46.5, 36.25}));
        EXPECT_TRUE(notes_with(**reader, "cameras differ").empty());
        const auto frames = read_all(**reader);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), plain->size());
        for (std::size_t n = 0; n < frames->size(); ++n)
            EXPECT_TRUE(same_frame(frames->at(n), plain->at(n))) << n;
        const auto& inputs = (*reader)->inputs();
        EXPECT_NE(std::find(inputs.begin(), inputs.end(), folder / "k2.json"), inputs.end())
            << "nobody may write there";
    }
}

TEST(FrameCameras, SayHowManyFramesAndHowFar) {
    const TemporaryFolder folder;
    write_plane(folder, {}, planar_at);
    write_bytes(folder / "k1.json", camera_json({80, 81, 46.5L + 3, 36.25L - 4}));
    write_bytes(folder / "k2.json", camera_json({80, 81, 46.5L + 0.3L, 36.25L}));
    write_bytes(folder / "scene.json", scene_json(camera_json(of_clip), "planar", with_cameras));
    auto reader = open_clip(folder.path());
    ASSERT_EQ(message(reader), "");
    const auto said = notes_with(**reader, "cameras differ");
    ASSERT_EQ(said.size(), 1U);
    EXPECT_NE(said.front().find("1 of 3 frames are brought onto the clip's camera, by up to 5 pixels"),
              std::string::npos)
        << said.front();
    write_bytes(folder / "k1.json", camera_json(of_clip));
    reader = open_clip(folder.path());
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ(notes_with(**reader, "cameras differ").at(0),
              "cameras differ by at most 0.3 pixels: every pixel stays where it is");
}

TEST(FrameCameras, GiveTheirMedianWhereTheSceneHasNoCamera) {
    const TemporaryFolder folder;
    write_plane(folder, {}, planar_at);
    write_bytes(folder / "scene.json", scene_json("", "planar", with_cameras));
    auto reader = open_clip(folder.path());
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->scene().camera, (Camera{80, 83, 46.5, 36.25})) << "of each number alone";
    const std::vector<Camera> two{{1, 8, 3, 4}, {5, 6, 7, 2}};
    EXPECT_EQ(median_camera(two), (Camera{1, 6, 3, 2})) << "the lower";
}

TEST(FrameCameras, AreInWhatIsConverted) {
    const TemporaryFolder folder;
    write_plane(folder, {}, planar_at);
    write_bytes(folder / "scene.json", scene_json(camera_json(of_clip), "planar", with_cameras));
    auto reader = open_clip(folder.path());
    ASSERT_EQ(message(reader), "");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    const Scene& scene = (*reader)->scene();
    auto packed = create_clip(folder / "packed.mkv", scene, exact_clip);
    auto unpacked = create_image_folder(folder / "unpacked", scene, Existing::keep);
    ASSERT_EQ(message(packed) + message(unpacked), "");
    for (const RawFrame& frame : *frames) {
        ASSERT_EQ(message((*packed)->write(frame)), "");
        ASSERT_EQ(message((*unpacked)->write(frame)), "");
    }
    ASSERT_EQ(message((*packed)->finish()) + message((*unpacked)->finish()), "");
    for (const char* name : {"packed.mkv", "unpacked"}) {
        auto again = open_clip(folder / name);
        ASSERT_EQ(message(again), "");
        EXPECT_TRUE(notes_with(**again, "cameras").empty()) << name;
        const auto back = read_all(**again);
        ASSERT_EQ(message(back), "");
        ASSERT_EQ(back->size(), 3U);
        for (std::size_t n = 0; n < 3; ++n) EXPECT_TRUE(same_frame(back->at(n), frames->at(n))) << name << n;
    }
}

TEST(FrameCameras, OfAStarOrAListGoWithTheNearestTime) {
    const TemporaryFolder folder;
    write_plane(folder, {}, planar_at);
    for (const auto& [from, to] :
         {std::pair{"d0.png", "d1.10.png"}, {"d1.png", "d1.20.png"}, {"d2.png", "d1.30.png"}})
        std::filesystem::rename(folder / from, folder / to);
    std::filesystem::create_directory(folder / "k");
    for (int n = 0; n < 3; ++n)
        write_bytes(folder / ("k/x1." + std::to_string(11 + 10 * n) + ".pincam"),
                    "96 72 " + std::to_string(80 + n) + " 81 46.5 36.25\n");
    write_bytes(folder / "k/x1.16.pincam", "96 72 500 500 46.5 36.25\n");
    write_bytes(folder / "cameras.txt", "1.11 k/x1.11.pincam\n1.21 k/x1.21.pincam\n1.31 k/x1.31.pincam\n");
    for (const char* cameras : {"k/x*.pincam", "cameras.txt"}) {
        write_bytes(folder / "scene.json",
                    R"({"touchable_scene": 1, "width": 96, "height": 72, "metres_per_unit": 1,
                        "depth": {"coding": "metric", "scale": 0.0001, "invalid": [0]},
                        "folder": {"depth": "d*.png", "cameras": ")" +
                        std::string(cameras) + "\"}}");
        auto reader = open_clip(folder.path());
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ((*reader)->scene().camera, (Camera{81, 81, 46.5, 36.25})) << "500 is of no frame's time";
    }
}

TEST(FrameCameras, ThatCannotBeAreRefusedInOneLine) {
    const TemporaryFolder folder;
    write_plane(folder, {}, planar_at);
    const auto refused = [&](const std::string& json) {
        write_bytes(folder / "scene.json", json);
        const std::string words = message(open_clip(folder.path()));
        EXPECT_EQ(words.find('\n'), std::string::npos) << words;
        return words;
    };
    const auto says = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    const std::string camera = camera_json(of_clip);
    const auto with = [&](const std::string& cameras) {
        return scene_json(camera, "planar", R"(, "cameras": )" + cameras);
    };
    EXPECT_PRED2(says, refused(with(R"("k0.json")")),
                 "folder.cameras is \"k0.json\": must be a file for each");
    EXPECT_PRED2(says, refused(with(R"({"files": "k%d.json", "first": 1})")),
                 "k3.json (cameras, frame 2): is missing");
    EXPECT_PRED2(says, refused(with(R"({"files": "k*.json", "step": 2})")), "folder.cameras.step is 2");
    EXPECT_PRED2(says, refused(with("3")), "folder.cameras is 3: must be a string");
    EXPECT_PRED2(says, refused(scene_json("", "planar")), "camera is missing");
    std::string full = with(R"("k%d.json")");
    full.replace(full.find(R"("invalid": [0], "near": 0.1, "far": 6)"), 37,
                 R"("near_is": "high", "near": 1, "far": 6)");
    full.replace(full.find(R"("metric", "scale": 0.0001)"), 25, R"("linear", "bits": 16)");
    EXPECT_PRED2(says, refused(full), "depth.invalid is []: must have a code that means no depth");
    write_bytes(folder / "k1.json", R"({"fx": "much"})");
    EXPECT_PRED2(says, refused(with(R"("k%d.json")")), "k1.json: has no camera");
    EXPECT_PRED2(says, refused(with(R"("k%d.json")")), "(camera, frame 1)");
    write_bytes(folder / "k1.json", R"({"fx": 90, "fy": 90, "cx": 1e9, "cy": 3})");
    EXPECT_PRED2(says, refused(with(R"("k%d.json")")), "k1.json (camera, frame 1): its cx and cy");
    write_bytes(folder / "alone.json", scene_json("", "planar", with_cameras));
    EXPECT_PRED2(says, message(open_clip(folder / "d0.png", folder / "alone.json")), "camera is missing");
}

TEST(FrameCameras, DoNotGoWithDisparities) {
    const auto scene = parse_scene(R"({"touchable_scene": 1, "width": 8, "height": 6,
        "camera": {"fx": 9, "fy": 9, "cx": 3, "cy": 2}, "depth": {"coding": "disparity", "baseline": 1},
        "folder": {"depth": "d%d.png", "cameras": "k%d.json"}})",
                                   "scene");
    EXPECT_TRUE(is_refused(scene, "must be left out, because depth.coding is disparity"));
}

TEST(FrameCameras, AreReadAsTheyAreWritten) {
    auto scene =
        parse_scene(scene_json("", "range", R"(, "cameras": {"files": "k%d.json", "first": 5})"), "scene");
    ASSERT_EQ(message(scene), "");
    EXPECT_TRUE(scene->unstated.camera);
    const auto again = parse_scene(scene_to_json(*scene), "again");
    ASSERT_EQ(message(again), "");
    EXPECT_TRUE(again->unstated.camera);
    EXPECT_EQ(again->scene.folder->cameras, "k%d.json");
    EXPECT_EQ(again->scene.folder->camera_numbers, (PictureNumbers{5, {}}));
}

}  // namespace
}  // namespace touchable::test
