// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/clip/clip.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

/// The result of a run of Blender.
struct BlenderRun {
    int code = -1;            ///< exit code; -signal where it died of one
    std::string told, error;  ///< lines of `touchable: ...` on standard output, and on standard error
};

std::string lines_of(const fs::path& file, const std::string& beginning) {
    std::ifstream in(file);
    std::string lines;
    for (std::string line; std::getline(in, line);)
        if (line.starts_with(beginning)) (lines += line) += '\n';
    return lines;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    return pointers;
}

/// Whether there is a Blender to run.
bool has_blender() {
    return std::system("blender --version >/dev/null 2>&1") == 0;
}

/// Runs Blender without a window, with Python files one after the other, and words behind "--". `environment`
/// has lines NAME=value. Sends SIGINT once that `is_enough`.
BlenderRun run_blender(const std::vector<fs::path>& scripts, const std::vector<std::string>& words,
                       const std::vector<std::string>& environment,
                       const std::function<bool()>& is_enough = nullptr) {
    const TemporaryFolder streams;
    std::vector<std::string> all{"env"};
    all.insert(all.end(), environment.begin(), environment.end());
    all.insert(all.end(), {"blender", "-b", "--factory-startup", "--python-exit-code", "9"});
    for (const fs::path& script : scripts) all.insert(all.end(), {"-P", script.string()});
    all.emplace_back("--");
    all.insert(all.end(), words.begin(), words.end());
    const std::vector<char*> argv = pointers_to(all);
    const std::string out = streams / "out", err = streams / "err";

    const pid_t child = fork();
    if (child == 0) {
        for (const auto& [file, stream] : {std::pair{&out, STDOUT_FILENO}, std::pair{&err, STDERR_FILENO}})
            dup2(open(file->c_str(), O_WRONLY | O_CREAT, 0600), stream);
        // These tests may run in a shell's background, where it is ignored.
        std::signal(SIGINT, SIG_DFL);
        execvp(argv[0], argv.data());
        _exit(127);
    }
    int status = 0;
    bool asked = false;
    while (waitpid(child, &status, WNOHANG) == 0) {
        if (is_enough && !asked && is_enough()) {
            asked = true;
            kill(child, SIGINT);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), lines_of(out, "touchable: "),
            lines_of(err, "")};
}

/// Exports the scene of test_scenes.py that has this name.
BlenderRun export_scene(const std::string& scene, const std::vector<std::string>& words,
                        const std::function<bool()>& is_enough = nullptr) {
    const fs::path root(TOUCHABLE_SOURCE_DIR);
    return run_blender(
        {root / "tests/content/blender/test_scenes.py", root / "engine/content/blender/export.py"}, words,
        {"SCENE=" + scene, "TOUCHABLE=" TOUCHABLE_PROGRAM}, is_enough);
}

/// A clip that Blender's exporter made, all of its frames in hand.
struct Exported {
    std::unique_ptr<ClipReader> reader;
    std::vector<RawFrame> frames;

    const Scene& scene() const { return reader->scene(); }
    /// Planar depth in metres; nothing: no surface.
    std::optional<double> depth(int x, int y, std::size_t frame = 0) const {
        const std::uint16_t code = frames[frame].depth.sample(x, y);
        if (!scene().depth.is_valid(code)) return std::nullopt;
        return scene().depth.depth(code) * scene().metres_per_unit;
    }
    HapticProperties haptic(int x, int y, std::size_t frame = 0) const {
        const PlaneView& plane = frames[frame].haptic;
        const auto code = [&](int channel) { return static_cast<std::uint8_t>(plane.sample(x, y, channel)); };
        return scene().haptic.at(code(0), code(1), code(2));
    }
    double height(int x, int y) const {  ///< metres
        const HeightCoding& coding = scene().height_coding;
        return coding.max_height * frames[0].height.sample(x, y) / coding.code_max * scene().metres_per_unit;
    }
    /// How far a stored depth is from the code that the true depth has.
    double codes_off(int x, int y, double true_depth) const {
        const DepthCoding& coding = scene().depth;
        return std::abs(frames[0].depth.sample(x, y) - coding.code(true_depth / scene().metres_per_unit));
    }
};

/// Fails the test, and gives no frames, where it does not open.
Exported open_exported(const std::string& file) {
    Exported exported;
    auto reader = open_clip(file);
    if (!reader) {
        ADD_FAILURE() << reader.error().message;
        return exported;
    }
    exported.reader = std::move(*reader);
    EXPECT_FALSE(exported.reader->unstated_filters().median) << "fine relief would be taken for noise";
    for (;;) {
        auto frame = exported.reader->next();
        if (!frame) ADD_FAILURE() << frame.error().message;
        if (!frame || !*frame) return exported;
        exported.frames.push_back(std::move(**frame));
    }
}

enum class OnTable { table, ball, can, sponge, egg, coaster };

/// The point at which a pixel's ray meets the scene of engine/content/blender/scenes/table.py.
struct TableHit {
    double depth = 1e9;  ///< metres along the axis
    OnTable thing = OnTable::table;
    bool is_plain = true;  ///< not on a round edge, which has no formula here
};

using Vec = glm::dvec3;

// As table.py has them, in metres.
const Vec camera_place(0.0, -0.44, 0.36), camera_target(-0.01, -0.008, 0.018);
const Vec ball_centre(-0.075, 0.035, 0.045), egg_centre(-0.035, -0.062, 0.0235),
    egg_radii(0.032, 0.0235, 0.0235);
const Vec can_foot(0.075, 0.055, 0), sponge_foot(0.068, -0.052, 0), sponge_size(0.105, 0.066, 0.034);
const Vec coaster_foot(-0.14, -0.075, 0);
constexpr double can_radius = 0.034, can_height = 0.085, can_wall = 0.0012, can_lid = 0.082;
constexpr double coaster_radius = 0.042, coaster_height = 0.004, sponge_bevel = 0.004, sponge_turn = -17.0;

/// A ray whose direction is 1 long along the camera's axis.
struct Ray {
    Vec from, along;
    Vec at(double t) const { return from + t * along; }
};

void keep(TableHit& hit, double depth, OnTable thing, bool is_plain = true) {
    if (depth > 0 && depth < hit.depth) hit = {depth, thing, is_plain};
}

/// The nearer of two roots of a t^2 - 2 b t + c.
std::optional<double> nearer_root(double a, double b, double c) {
    const double root = b * b - a * c;
    if (root < 0) return std::nullopt;
    return (b - std::sqrt(root)) / a;
}

void meet_ellipsoid(const Ray& ray, const Vec& centre, const Vec& radii, OnTable thing, TableHit& hit) {
    const Vec from = (ray.from - centre) / radii, along = ray.along / radii;
    if (const auto t = nearer_root(glm::dot(along, along), -glm::dot(from, along), glm::dot(from, from) - 1))
        keep(hit, *t, thing);
}

/// Upright, its side alone.
void meet_side(const Ray& ray, const Vec& foot, double radius, double height, OnTable thing, bool is_plain,
               TableHit& hit) {
    const Vec from = ray.from - foot;
    const double a = ray.along.x * ray.along.x + ray.along.y * ray.along.y;
    const double b = -(from.x * ray.along.x + from.y * ray.along.y);
    const auto t = nearer_root(a, b, from.x * from.x + from.y * from.y - radius * radius);
    if (t && ray.at(*t).z > 0 && ray.at(*t).z < height) keep(hit, *t, thing, is_plain);
}

/// Level, from one radius to another.
void meet_disc(const Ray& ray, const Vec& foot, double least, double most, double height, OnTable thing,
               bool is_plain, TableHit& hit) {
    const double t = (height - ray.from.z) / ray.along.z;
    const Vec at = ray.at(t) - foot;
    const double radius = std::sqrt(at.x * at.x + at.y * at.y);
    if (radius >= least && radius <= most) keep(hit, t, thing, is_plain);
}

void meet_sponge(const Ray& ray, TableHit& hit) {
    const double turn = sponge_turn * 3.14159265358979323846 / 180, c = std::cos(turn), s = std::sin(turn);
    const auto turned = [&](const Vec& v) { return Vec(c * v.x + s * v.y, -s * v.x + c * v.y, v.z); };
    const Vec from = turned(ray.from - sponge_foot), along = turned(ray.along);
    const Vec least(-sponge_size.x / 2, -sponge_size.y / 2, 0),
        most(sponge_size.x / 2, sponge_size.y / 2, sponge_size.z);
    double enter = -1e9, leave = 1e9;
    int face = 0;
    for (int k = 0; k < 3; ++k) {
        const double first = (least[k] - from[k]) / along[k], second = (most[k] - from[k]) / along[k];
        if (std::min(first, second) > enter) enter = std::min(first, second), face = k;
        leave = std::min(leave, std::max(first, second));
    }
    if (enter > leave) return;
    const Vec at = from + enter * along;
    bool is_plain = true;
    for (int k = 0; k < 3; ++k) {
        const double to_edge = k == 2 ? most[2] - at[2] : most[k] - std::abs(at[k]);
        if (k != face && to_edge < sponge_bevel * 1.05) is_plain = false;
    }
    keep(hit, enter, OnTable::sponge, is_plain);
}

TableHit table_hit(const Camera& camera, double x, double y) {
    const Vec forward = glm::normalize(camera_target - camera_place);
    const Vec right = glm::normalize(glm::cross(forward, Vec(0, 0, 1))), up = glm::cross(right, forward);
    const Ray ray{camera_place, forward + camera.u(x) * right + camera.v(y) * up};
    TableHit hit;
    keep(hit, -ray.from.z / ray.along.z, OnTable::table);
    meet_ellipsoid(ray, ball_centre, Vec(ball_centre.z), OnTable::ball, hit);
    meet_ellipsoid(ray, egg_centre, egg_radii, OnTable::egg, hit);
    meet_sponge(ray, hit);
    meet_side(ray, coaster_foot, coaster_radius, coaster_height, OnTable::coaster, false, hit);
    meet_disc(ray, coaster_foot, 0, coaster_radius, coaster_height, OnTable::coaster, true, hit);
    meet_side(ray, can_foot, can_radius, can_height, OnTable::can, true, hit);
    meet_disc(ray, can_foot, can_radius - can_wall, can_radius, can_height, OnTable::can, true, hit);
    // Through its mouth onto the lid, or the wall around that.
    TableHit mouth;
    meet_disc(ray, can_foot, 0, can_radius - can_wall, can_height, OnTable::can, true, mouth);
    if (mouth.depth < hit.depth) {
        TableHit lid{1e9, OnTable::can, true};
        meet_disc(ray, can_foot, 0, can_radius - can_wall, can_lid, OnTable::can, true, lid);
        hit = lid.depth < 1e9 ? lid : TableHit{mouth.depth, OnTable::can, false};
    }
    return hit;
}

// Exported renders of Blender against surfaces in closed form, read like any clip.

class Blender : public ::testing::Test {
protected:
    void SetUp() override {
        if (!has_blender()) GTEST_SKIP() << "needs Blender (Debian: blender)";
    }
    /// The clip of a scene, which must export.
    Exported exported(const std::string& scene, std::vector<std::string> words = {"--no-colour"}) {
        words.insert(words.begin(), file());
        run = export_scene(scene, words);
        EXPECT_EQ(run.code, 0) << run.error;
        return open_exported(file());
    }
    std::string file() const { return folder / "clip.mkv"; }
    void check_in_blender(const std::string& names, const char* script = "checks.py") {
        const BlenderRun checked =
            run_blender({std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/content/blender" / script}, {},
                        {"CHECKS=" + names, "TOUCHABLE=" TOUCHABLE_PROGRAM});
        EXPECT_EQ(checked.code, 0) << checked.error;
    }

    TemporaryFolder folder;
    BlenderRun run;
};

/// The largest and the mean distance between what a clip says and what is true, of many pixels.
struct Errors {
    double codes = 0, millimetres = 0, squares = 0;
    int pixels = 0;

    void add(const Exported& clip, int x, int y, double true_depth) {
        const auto depth = clip.depth(x, y);
        ASSERT_TRUE(depth) << "no surface at " << x << ", " << y;
        codes = std::max(codes, clip.codes_off(x, y, true_depth));
        const double off = 1000 * (*depth - true_depth);
        millimetres = std::max(millimetres, std::abs(off));
        squares += off * off;
        ++pixels;
    }
    void tell(const char* what) const {
        std::printf("%s: %.0f codes and %.4f mm at most, %.4f mm RMS, of %d pixels\n", what, codes,
                    millimetres, std::sqrt(squares / pixels), pixels);
    }
};

TEST_F(Blender, PlaneIsWhereItIs) {
    const Exported clip = exported("plane");
    ASSERT_EQ(clip.frames.size(), 1u);
    const Camera& camera = clip.scene().camera;
    EXPECT_EQ(clip.frames[0].depth.width, 360);
    EXPECT_EQ(clip.frames[0].depth.height, 240);
    EXPECT_NEAR(camera.fx, 50.0 * 240 * 1.25 / 24, 1e-3);
    EXPECT_NEAR(camera.fy, 50.0 * 240 / 24, 1e-3);
    EXPECT_NEAR(camera.cx, 179.5 - 0.11 * 240 * 1.25, 1e-3);
    EXPECT_NEAR(camera.cy, 119.5 - 0.07 * 240, 1e-3);
    Errors errors;
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 360; ++x) errors.add(clip, x, y, 4 / (1 + 0.3 * camera.u(x) + 0.2 * camera.v(y)));
    errors.tell("plane");
    EXPECT_LE(errors.codes, 1);
    EXPECT_NEAR(clip.haptic(20, 20).stiffness, 700, 1e-9);  // and not the window's
}

/// The depth at which a ray meets the sphere of `sphere`; nothing beside it, or near its silhouette.
std::optional<double> sphere_depth(double u, double v) {
    // |d (u, v, -1) - (0, 0, -5)| = 1
    const double a = u * u + v * v + 1, root = 25 - a * 24;
    if (root < 0.1) return std::nullopt;
    return (5 - std::sqrt(root)) / a;
}

TEST_F(Blender, MakesRoundSpheres) {
    const Exported clip = exported("sphere");
    ASSERT_EQ(clip.frames.size(), 1u);
    const Camera& camera = clip.scene().camera;
    Errors errors, wall;
    for (int y = 0; y < 480; ++y)
        for (int x = 0; x < 720; ++x) {
            const double u = camera.u(x), v = camera.v(y);
            if (const auto depth = sphere_depth(u, v)) errors.add(clip, x, y, *depth);
            if (25 - (u * u + v * v + 1) * 24 < -0.1) wall.add(clip, x, y, 8);
        }
    errors.tell("sphere");
    wall.tell("wall behind it");
    EXPECT_GT(errors.pixels, 50000);
    EXPECT_LE(errors.codes, 1);
    EXPECT_LE(wall.codes, 1);

    // A hand that goes round and about on its front.
    const std::string forces = folder / "forces.csv";
    const Outcome touched =
        run_touchable({"touch", file(), "--hand", "wander:extent=0.45,depth=1,seed=3,speed=0.05", "--seconds",
                       "6", "--forces", forces});
    ASSERT_EQ(touched.code, 0) << touched.err;
    double squares = 0, worst = 0;
    int ticks = 0;
    for (const ForcesRow& row : read_forces(forces)) {
        const auto force = row.vector("force"), proxy = row.vector("proxy");
        const glm::dvec3 f(force[0], force[1], force[2]), p(proxy[0], proxy[1], proxy[2]);
        const glm::dvec3 outward = p * clip.scene().metres_per_unit - glm::dvec3(0, 0, -5);
        if (row["contact"] == 0 || glm::length(f) < 0.05 || std::abs(glm::length(outward) - 1) > 0.01)
            continue;
        const double cosine = glm::dot(glm::normalize(f), glm::normalize(outward));
        const double degrees = std::acos(std::min(1.0, cosine)) * 180 / 3.14159265358979;
        squares += degrees * degrees;
        worst = std::max(worst, degrees);
        ++ticks;
    }
    ASSERT_GT(ticks, 3000);
    std::printf("force on the sphere: %.3f degrees RMS, %.2f at most, of %d ticks\n",
                std::sqrt(squares / ticks), worst, ticks);
    EXPECT_LT(std::sqrt(squares / ticks), 2);
}

// The texel that a share of the way falls on, and the mean of neighbours as Blender has it.
double ramp_height(double u) {
    static constexpr double texels[8] = {0, 51, 102, 153, 204, 255, 51, 0};
    const double at = u * 8 - 0.5;
    const int left = static_cast<int>(std::floor(at));
    const double share = at - left;
    return (texels[(left + 8) % 8] * (1 - share) + texels[(left + 1) % 8] * share) / 255;
}

TEST_F(Blender, BakesHeightAndHapticTextures) {
    const Exported clip = exported("textures");
    ASSERT_EQ(clip.frames.size(), 1u);
    ASSERT_EQ(clip.scene().height_coding.code_max, 65535);
    const Camera& camera = clip.scene().camera;
    static constexpr double factors[4][3] = {{255, 0, 255}, {0, 255, 51}, {102, 153, 204}, {255, 255, 255}};
    double height_off = 0;
    int on_wall = 0, on_leaf = 0;
    for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 256; ++x) {
            const double leaf_x = 1.5 * camera.u(x), leaf_y = 1.5 * camera.v(y);
            const double wall_x = (2 * camera.u(x) + 0.64) / 1.28, wall_y = (2 * camera.v(y) + 0.64) / 1.28;
            const double edge = std::min(
                {std::abs(leaf_x), std::abs(leaf_x + 0.4), std::abs(leaf_y), std::abs(leaf_y + 0.4)});
            const bool is_leaf = leaf_x > -0.4 && leaf_x < 0 && leaf_y > -0.4 && leaf_y < 0;
            const double row = wall_y * 4;
            if (edge < 0.01 || std::abs(row - std::round(row)) < 0.02 || wall_x < 0 || wall_x >= 1 ||
                wall_y < 0 || wall_y >= 1)
                continue;
            const HapticProperties felt = clip.haptic(x, y);
            const auto& ranges = clip.scene().haptic;
            const double half_codes[3] = {(ranges.stiffness.max - ranges.stiffness.min) / 510,
                                          (ranges.static_friction.max - ranges.static_friction.min) / 510,
                                          (ranges.dynamic_friction.max - ranges.dynamic_friction.min) / 510};
            if (is_leaf) {
                ++on_leaf;
                EXPECT_NEAR(*clip.depth(x, y), 1.5, 2e-5);
                EXPECT_NEAR(clip.height(x, y), 0.005 * 102 / 255, 1e-7);
                EXPECT_NEAR(felt.stiffness / 1000, 0.3, half_codes[0]);
                continue;
            }
            ++on_wall;
            EXPECT_NEAR(*clip.depth(x, y), 2, 2e-5) << x << ", " << y;
            height_off = std::max(height_off, std::abs(clip.height(x, y) - 0.01 * ramp_height(wall_x)));
            const auto& factor = factors[static_cast<int>(row)];
            EXPECT_NEAR(felt.stiffness / 1000, 2 * factor[0] / 255, half_codes[0] * 1.001) << x << ", " << y;
            EXPECT_NEAR(felt.static_friction, 0.8 * factor[1] / 255, half_codes[1] * 1.001) << x << ", " << y;
            EXPECT_NEAR(felt.dynamic_friction, 0.4 * factor[2] / 255, half_codes[2] * 1.001)
                << x << ", " << y;
        }
    std::printf("heights: %.3f micrometres off at most, %.2f codes\n", 1e6 * height_off,
                height_off / (0.01 / 65535));
    EXPECT_GT(on_wall, 15000);
    EXPECT_GT(on_leaf, 3000);
    EXPECT_LT(height_off, 0.01 / 65535);
}

TEST_F(Blender, ExportsThingsOnTable) {
    const Exported clip = exported("table");
    ASSERT_EQ(clip.frames.size(), 1u);
    const std::array<std::array<double, 3>, 6> felt{{{1.6, 0.45, 0.35},
                                                     {0.5, 0.95, 0.85},
                                                     {2, 0.15, 0.1},
                                                     {0.2, 0.8, 0.7},
                                                     {1.8, 0.25, 0.18},
                                                     {0.35, 0.7, 0.55}}};
    std::array<Errors, 6> errors;
    std::vector<TableHit> hits;
    for (int y = 0; y < 480; ++y)
        for (int x = 0; x < 720; ++x) hits.push_back(table_hit(clip.scene().camera, x, y));
    for (int y = 1; y + 1 < 480; ++y)
        for (int x = 1; x + 1 < 720; ++x) {
            const auto at = static_cast<std::size_t>(y * 720 + x);
            const TableHit& hit = hits[at];
            bool is_plain = true;
            for (const std::size_t beside :
                 {at - 721, at - 720, at - 719, at - 1, at, at + 1, at + 719, at + 720, at + 721})
                is_plain = is_plain && hits[beside].is_plain && hits[beside].thing == hit.thing &&
                           std::abs(hits[beside].depth - hit.depth) < 0.0015;
            if (!is_plain) continue;
            const auto thing = static_cast<std::size_t>(hit.thing);
            errors[thing].add(clip, x, y, hit.depth);
            const HapticProperties there = clip.haptic(x, y);
            ASSERT_NEAR(there.stiffness / 1000, felt[thing][0], 1e-9) << x << ", " << y;
            ASSERT_NEAR(there.static_friction, felt[thing][1], 1e-9) << x << ", " << y;
            ASSERT_NEAR(there.dynamic_friction, felt[thing][2], 1e-9) << x << ", " << y;
        }
    const char* names[] = {"table", "ball", "can", "sponge", "egg", "coaster"};
    for (std::size_t k = 0; k < errors.size(); ++k) {
        errors[k].tell(names[k]);
        EXPECT_LE(errors[k].codes, 1) << names[k];
        EXPECT_GT(errors[k].pixels, 5000) << names[k];
    }
}

TEST_F(Blender, FollowsMovingCamera) {
    const Exported clip = exported("moving");
    ASSERT_EQ(clip.frames.size(), 3u);
    EXPECT_EQ(clip.frames[1].time_ns, 2 * 1001000000LL / 30);
    for (std::size_t k = 0; k < 3; ++k) {
        const double frame = 3 + 2.0 * static_cast<double>(k);
        EXPECT_NEAR(*clip.depth(20, 30, k), 3 + 0.25 * frame, 2e-5);
        EXPECT_NEAR(clip.haptic(20, 30, k).stiffness, 100 * frame, 1e-9);
    }
}

TEST_F(Blender, ClipsAtStatedPlanes) {
    const Exported clip = exported("moving", {"--no-colour", "--near", "3.9", "--far", "4.4"});
    ASSERT_EQ(clip.frames.size(), 3u);
    EXPECT_FALSE(clip.depth(20, 30, 0));
    EXPECT_NEAR(clip.depth(20, 30, 1).value_or(0), 4.25, 2e-5);
    EXPECT_FALSE(clip.depth(20, 30, 2));
}

TEST_F(Blender, GuessesOrdinaryScenes) {
    const Exported clip = exported("ordinary", {});
    ASSERT_EQ(clip.frames.size(), 1u) << "nothing moves";
    EXPECT_NE(run.told.find("nothing moves"), std::string::npos) << run.told;
    EXPECT_NE(run.told.find("guessed: "), std::string::npos) << run.told;
    EXPECT_NE(run.told.find("no material (0.6 N/mm"), std::string::npos) << run.told;
    EXPECT_NE(run.told.find("Material (0.8 N/mm"), std::string::npos) << run.told;
    EXPECT_NE(run.told.find("Chrome (1.6 N/mm"), std::string::npos) << run.told;
    EXPECT_FALSE(clip.frames[0].colour.empty());
    ASSERT_FALSE(clip.scene().remarks.empty());
    EXPECT_NE(clip.scene().remarks.back().what.find("what these materials feel like"), std::string::npos);
    EXPECT_GT(touch({file(), "--hand", "press", "--seconds", "1"}).at("contact_ticks").get<int>(), 100);
}

TEST_F(Blender, WritesFolderWithoutTheProgram) {
    const std::string out = folder / "pictures", later = folder / "later.mkv";
    const BlenderRun folder_run = export_scene("moving", {out, "--no-colour"});
    ASSERT_EQ(folder_run.code, 0) << folder_run.error;
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"pictures"});
    ASSERT_EQ(run_touchable({"convert", out, later}).code, 0);
    const Exported clip = exported("moving"), converted = open_exported(later);
    ASSERT_EQ(converted.frames.size(), clip.frames.size());
    for (std::size_t k = 0; k < clip.frames.size(); ++k)
        EXPECT_TRUE(same_touch_planes(clip.frames[k], converted.frames[k]));
}

TEST_F(Blender, LeavesNothingAtCtrlC) {
    const auto has_begun = [&] {
        for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
            if (std::filesystem::exists(entry.path() / "metres_000000.npy")) return true;
        return false;
    };
    EXPECT_EQ(export_scene("moving", {file(), "--no-colour", "--frames", "1-300"}, has_begun).code, 130);
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{});
}

TEST_F(Blender, MatchesBlendersCamera) {
    check_in_blender("cameras ranges guesses relief bumps opacity what_moves");
}

TEST_F(Blender, ExportsFromItsWindow) {
    check_in_blender("addon");
}

TEST_F(Blender, ExportsAnimatedRelief) {
    check_in_blender("whole_picture animated no_numbers broken_textures short_files");
}

TEST_F(Blender, ReplacesOutputAtomically) {
    check_in_blender("replaces becomes signals", "output_checks.py");
}

TEST_F(Blender, RestrictsItsChild) {
    check_in_blender("cancels scripts", "output_checks.py");
}

TEST_F(Blender, RejectsWhatClipsCannotHold) {
    check_in_blender("refusals");
}

}  // namespace
}  // namespace touchable::test
