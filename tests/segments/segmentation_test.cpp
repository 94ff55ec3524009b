// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "engine/authoring/segmentation.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

/// Things of known outline on a table before a wall, as a camera sees them that looks down at them. Metres
/// from a place on the table: x to the right, y up, z to the camera. The same bits on every machine: + - * /
/// and sqrt.
struct Thing {
    enum class Kind { wall, table, ball, box, can } kind;
    std::array<double, 3> at;    ///< middle of a ball; of a box or can, of what it stands on
    std::array<double, 3> size;  ///< a ball's radius; a box's width, height, depth; a can's radius, height
    std::array<int, 3> colour;
    int stripes = 0;                ///< levels by which its texture is brighter or darker
    std::array<double, 3> speed{};  ///< metres a frame
};

struct GeneratedTable {
    std::vector<Thing> things;  ///< the first is label 1
    int width = 320, height = 240;
    double colour_noise = 3, depth_noise = 0.0015;  ///< levels; metres at a metre, growing with its square
    std::array<double, 3> camera_speed{};

    Camera camera() const { return {0.82 * width, 0.82 * width, (width - 1) / 2.0, (height - 1) / 2.0}; }
    Scene scene() const {
        Scene scene = small_scene(width, height, 16);
        scene.camera = camera();
        scene.metres_per_unit = 1;
        scene.depth = {};
        scene.depth.kind = DepthCodingKind::metric;
        scene.depth.semantics = DepthSemantics::planar;
        scene.depth.scale = 0.001;
        scene.depth.far = 10;
        scene.depth.code_max = 65535;
        scene.depth.invalid_code_count = 1;
        derive_valid_range(scene.depth);
        return scene;
    }
};

struct GeneratedFrame {
    std::vector<std::uint8_t> colour;
    std::vector<std::uint16_t> depth;
    std::vector<std::uint16_t> truth;           ///< the thing of each pixel, from 1
    std::vector<std::array<double, 3>> places;  ///< what of it is seen there
    int width, height;

    RawFrame raw(std::int64_t number = 0) const {
        RawFrame frame;
        frame.number = number;
        frame.depth = {reinterpret_cast<const std::uint8_t*>(depth.data()), 2 * width, width, height, 2, 1};
        frame.colour = {colour.data(), 3 * width, width, height, 1, 3};
        return frame;
    }
};

using Vector = std::array<double, 3>;

/// The camera is at (0, 0.75, 0.9) and looks along (0, -0.6, -0.8).
Vector camera_at(const GeneratedTable& table, int frame) {
    return {table.camera_speed[0] * frame, 0.75 + table.camera_speed[1] * frame,
            0.9 + table.camera_speed[2] * frame};
}

struct Hit {
    double distance = 1e9;
    Vector normal{};
};

void nearer(Hit& hit, double distance, const Vector& normal) {
    if (distance > 1e-6 && distance < hit.distance) hit = {distance, normal};
}

Hit hit_of(const Thing& thing, const Vector& from, const Vector& ray) {
    Hit hit;
    const auto along = [&](double t, int axis) {
        return from[static_cast<std::size_t>(axis)] + t * ray[static_cast<std::size_t>(axis)];
    };
    const Vector& at = thing.at;
    switch (thing.kind) {
        case Thing::Kind::wall:
            nearer(hit, (at[2] - from[2]) / ray[2], {0, 0, 1});
            break;
        case Thing::Kind::table:
            nearer(hit, (at[1] - from[1]) / ray[1], {0, 1, 0});
            break;
        case Thing::Kind::ball: {
            double a = 0, b = 0, c = -thing.size[0] * thing.size[0];
            for (std::size_t k = 0; k < 3; ++k) {
                a += ray[k] * ray[k];
                b += ray[k] * (from[k] - at[k]);
                c += (from[k] - at[k]) * (from[k] - at[k]);
            }
            if (b * b - a * c < 0) break;
            const double t = (-b - std::sqrt(b * b - a * c)) / a;
            Vector normal{};
            for (std::size_t k = 0; k < 3; ++k) normal[k] = (from[k] + t * ray[k] - at[k]) / thing.size[0];
            nearer(hit, t, normal);
            break;
        }
        case Thing::Kind::box: {
            const Vector least{at[0] - thing.size[0] / 2, at[1], at[2] - thing.size[2] / 2},
                most{at[0] + thing.size[0] / 2, at[1] + thing.size[1], at[2] + thing.size[2] / 2};
            for (int axis = 0; axis < 3; ++axis)
                for (const double side : {-1.0, 1.0}) {
                    const auto k = static_cast<std::size_t>(axis);
                    const double t = ((side < 0 ? least[k] : most[k]) - from[k]) / ray[k];
                    bool inside = true;
                    for (int other = 0; other < 3; ++other)
                        if (other != axis)
                            inside = inside && along(t, other) >= least[static_cast<std::size_t>(other)] &&
                                     along(t, other) <= most[static_cast<std::size_t>(other)];
                    Vector normal{};
                    normal[k] = side;
                    if (inside) nearer(hit, t, normal);
                }
            break;
        }
        case Thing::Kind::can: {
            const double x = from[0] - at[0], z = from[2] - at[2];
            const double a = ray[0] * ray[0] + ray[2] * ray[2], b = x * ray[0] + z * ray[2],
                         c = x * x + z * z - thing.size[0] * thing.size[0];
            if (b * b - a * c < 0) break;
            const double side = (-b - std::sqrt(b * b - a * c)) / a;
            if (along(side, 1) >= at[1] && along(side, 1) <= at[1] + thing.size[1])
                nearer(
                    hit, side,
                    {(along(side, 0) - at[0]) / thing.size[0], 0, (along(side, 2) - at[2]) / thing.size[0]});
            const double top = (at[1] + thing.size[1] - from[1]) / ray[1];
            const double dx = along(top, 0) - at[0], dz = along(top, 2) - at[2];
            if (dx * dx + dz * dz <= thing.size[0] * thing.size[0]) nearer(hit, top, {0, 1, 0});
            break;
        }
    }
    return hit;
}

GeneratedFrame generate(const GeneratedTable& table, int frame, std::uint64_t seed = 1) {
    const int width = table.width, height = table.height;
    const auto pixels = static_cast<std::size_t>(width * height);
    GeneratedFrame out{std::vector<std::uint8_t>(3 * pixels),
                       std::vector<std::uint16_t>(pixels),
                       std::vector<std::uint16_t>(pixels),
                       std::vector<std::array<double, 3>>(pixels),
                       width,
                       height};
    Random numbers(seed * 1000 + static_cast<std::uint64_t>(frame));
    const auto noise = [&] {  // about normal, deviation 1
        double sum = 0;
        for (int k = 0; k < 4; ++k) sum += numbers.below(2001) - 1000;
        return sum / 1155.0;
    };
    std::vector<Thing> things = table.things;
    for (Thing& thing : things)
        for (std::size_t k = 0; k < 3; ++k) thing.at[k] += thing.speed[k] * frame;
    const Camera camera = table.camera();
    const Vector from = camera_at(table, frame);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double u = camera.u(x), v = camera.v(y);
            const Vector ray{u, 0.8 * v - 0.6, -0.6 * v - 0.8};
            const auto at = static_cast<std::size_t>(y * width + x);
            Hit hit;
            for (std::size_t k = 0; k < things.size(); ++k) {
                const Hit one = hit_of(things[k], from, ray);
                if (one.distance >= hit.distance) continue;
                hit = one;
                out.truth[at] = static_cast<std::uint16_t>(k + 1);
            }
            const Thing& thing = things[out.truth[at] - 1U];
            Vector place{};
            for (std::size_t k = 0; k < 3; ++k) place[k] = from[k] + hit.distance * ray[k] - thing.at[k];
            out.places[at] = place;
            const double lit =
                0.55 + 0.45 * std::max(0.0, 0.4 * hit.normal[0] + 0.8 * hit.normal[1] + 0.45 * hit.normal[2]);
            const int stripe = (static_cast<int>(std::floor(place[0] * 60 + place[2] * 7)) +
                                static_cast<int>(std::floor(place[1] * 60))) &
                               1;
            for (std::size_t c = 0; c < 3; ++c) {
                const double level = (thing.colour[c] + (stripe ? thing.stripes : -thing.stripes)) * lit +
                                     table.colour_noise * noise();
                out.colour[3 * at + c] = static_cast<std::uint8_t>(std::clamp(level + 0.5, 0.0, 255.0));
            }
            const double depth = hit.distance + table.depth_noise * hit.distance * hit.distance * noise();
            out.depth[at] = static_cast<std::uint16_t>(std::clamp(depth * 1000 + 0.5, 1.0, 65535.0));
        }
    return out;
}

/// The previous place in the picture of the point seen at a pixel, if it was seen in the frame before.
std::optional<std::size_t> place_before(const GeneratedTable& table, const GeneratedFrame& now,
                                        const GeneratedFrame& before, int frame, std::size_t at) {
    const Thing& thing = table.things[now.truth[at] - 1U];
    const Vector from = camera_at(table, frame - 1);
    Vector place{};
    for (std::size_t k = 0; k < 3; ++k)
        place[k] = now.places[at][k] + thing.at[k] + thing.speed[k] * (frame - 1) - from[k];
    const double depth = -0.6 * place[1] - 0.8 * place[2], up = 0.8 * place[1] - 0.6 * place[2];
    const Camera camera = table.camera();
    const int x = static_cast<int>(std::floor(camera.cx + camera.fx * place[0] / depth + 0.5)),
              y = static_cast<int>(std::floor(camera.cy - camera.fy * up / depth + 0.5));
    if (x < 0 || y < 0 || x >= now.width || y >= now.height) return std::nullopt;
    const auto there = static_cast<std::size_t>(y * now.width + x);
    if (before.truth[there] != now.truth[at]) return std::nullopt;
    return there;
}

/// Mean over things of the best segment's intersection over union.
double mean_iou(const std::vector<std::uint16_t>& truth, const std::vector<std::uint16_t>& labels) {
    std::map<std::pair<int, int>, double> both;
    std::map<int, double> true_pixels, label_pixels;
    for (std::size_t k = 0; k < truth.size(); ++k) {
        ++both[{truth[k], labels[k]}];
        ++true_pixels[truth[k]];
        ++label_pixels[labels[k]];
    }
    std::map<int, double> best;
    for (const auto& [pair, pixels] : both)
        if (pair.second != 0)
            best[pair.first] = std::max(
                best[pair.first], pixels / (true_pixels[pair.first] + label_pixels[pair.second] - pixels));
    double sum = 0;
    for (const auto& [thing, pixels] : true_pixels) sum += best[thing];
    return sum / static_cast<double>(true_pixels.size());
}

/// A table with things at random, which do not stand in each other.
GeneratedTable random_table(std::uint64_t seed, int width = 320, int height = 240) {
    Random numbers(seed + 77);
    const auto between = [&](int least, int most) { return least + numbers.below(most - least + 1); };
    constexpr int colours[][3] = {{190, 50, 45}, {50, 80, 170},   {60, 140, 70}, {215, 190, 60},
                                  {60, 60, 65},  {225, 225, 220}, {150, 70, 140}};
    GeneratedTable table;
    table.width = width;
    table.height = height;
    table.things.push_back({Thing::Kind::wall, {0, 0, -0.75}, {}, {190, 195, 200}, 3});
    table.things.push_back({Thing::Kind::table, {0, 0, 0}, {}, {150, 110, 70}, 8});
    const int first = numbers.below(7);
    for (int k = 0; k < 5; ++k) {
        const double x = (k % 3 - 1) * 0.34 + between(-30, 30) / 1000.0,
                     z = (k < 3 ? -0.3 : 0.08) + between(-30, 30) / 1000.0;
        const std::array<int, 3> colour = std::to_array(colours[(first + k) % 7]);
        const double across = between(80, 130) / 1000.0;
        const double shift = k < 3 ? 0 : 0.17;
        const int stripes = between(0, 10);
        Thing thing{Thing::Kind::can, {x + shift, 0, z}, {0.6 * across, 2 * across, 0}, colour, stripes};
        if (k % 3 == 0) thing.kind = Thing::Kind::box, thing.size = {1.6 * across, across, across};
        if (k % 3 == 1) thing.kind = Thing::Kind::ball, thing.at[1] = across, thing.size = {across, 0, 0};
        table.things.push_back(thing);
    }
    return table;
}

// Segments of generated clips, of which it is known what every pixel shows.

const bool short_sweeps = sweep_step() > 1;

TEST(Segmenter, FindsThingsOnATable) {
    double sum = 0, least = 1;
    constexpr int scenes = 8;
    std::size_t most_segments = 0;
    for (int seed = 0; seed < scenes; ++seed) {
        const GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        const SegmentFrames segmenter = follow_segments(table.scene());
        const GeneratedFrame frame = generate(table, 0);
        const Segmentation& found = segmenter(frame.raw(), false);
        const double iou = mean_iou(frame.truth, found.labels);
        std::printf("scene %d: mean IoU %.3f, %zu segments\n", seed, iou, found.segments.size());
        sum += iou;
        least = std::min(least, iou);
        most_segments = std::max(most_segments, found.segments.size());
    }
    std::printf("mean of %d scenes: %.3f\n", scenes, sum / scenes);
    EXPECT_GE(sum / scenes, 0.8);
    EXPECT_GE(least, 0.7);
    EXPECT_LE(most_segments, 40U);
}

/// As good at the sizes of other cameras. What a frame takes is printed: 640x480 has to be 5 a second.
TEST(Segmenter, FindsThingsAtAnySize) {
    for (const auto& [width, height] : {std::pair{640, 480}, {1920, 1080}}) {
        if (short_sweeps && width > 640) continue;
        const GeneratedTable table = random_table(3, width, height);
        const SegmentFrames segmenter = follow_segments(table.scene());
        const GeneratedFrame first = generate(table, 0), second = generate(table, 1);
        double iou = mean_iou(first.truth, segmenter(first.raw(0), false).labels);
        const auto wall = std::chrono::steady_clock::now();
        const std::clock_t cpu = std::clock();
        iou = std::min(iou, mean_iou(second.truth, segmenter(second.raw(1), true).labels));
        const double all_ms = 1000.0 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
        const double ms =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count();
        std::printf("%dx%d: mean IoU %.3f, a frame takes %.0f ms, %.0f ms of CPU\n", width, height, iou, ms,
                    all_ms);
        EXPECT_GE(iou, 0.8);
    }
}

/// Per cent of the pixels seen in both frames whose label is another than it was, in the mean and at most.
struct Changes {
    double mean = 0, most = 0;
};
Changes changes_of(const GeneratedTable& table, int frames, int from) {
    const SegmentFrames segmenter = follow_segments(table.scene());
    GeneratedFrame before;
    std::vector<std::uint16_t> labels;
    Changes changes;
    std::set<std::uint16_t> all;
    for (int n = 0; n < frames; ++n) {
        GeneratedFrame now = generate(table, n);
        const Segmentation& found = segmenter(now.raw(n), n > 0);
        for (const Segment& segment : found.segments) all.insert(segment.label);
        if (n >= from) {
            double seen = 0, changed = 0;
            for (std::size_t k = 0; k < now.truth.size(); ++k) {
                const auto there = place_before(table, now, before, n, k);
                if (!there) continue;
                ++seen;
                changed += labels[*there] != found.labels[k] ? 1 : 0;
            }
            const double share = 100 * changed / seen;
            changes.mean += share / (frames - from);
            changes.most = std::max(changes.most, share);
        }
        labels = found.labels;
        before = std::move(now);
    }
    std::printf("%zu labels in %d frames; %.3f %% change, at most %.3f %%\n", all.size(), frames,
                changes.mean, changes.most);
    return changes;
}

TEST(Segmenter, IsSteadyForStillCamera) {
    for (const int seed : short_sweeps ? std::vector{0, 2} : std::vector{0, 1, 2}) {
        GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        table.colour_noise = 5;
        const Changes changes = changes_of(table, short_sweeps ? 8 : 16, 1);
        EXPECT_LE(changes.mean, 0.5);
    }
}

TEST(Segmenter, FollowsMotion) {
    for (const int seed : short_sweeps ? std::vector{0, 2} : std::vector{0, 1, 2}) {
        GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        if (seed != 1) table.things[3].speed = {0.008, 0, 0};
        if (seed != 1) table.things[5].speed = {-0.004, 0, 0.003};
        if (seed != 0) table.camera_speed = {0.01, 0, -0.003};
        const Changes changes = changes_of(table, short_sweeps ? 8 : 20, 1);
        EXPECT_LE(changes.mean, 3);
    }
}

/// All that is found of some frames of a clip that moves, of which some are left out.
class HashedClip {
public:
    HashedClip() {
        table_.things[3].speed = {0.01, 0, 0};
        table_.camera_speed = {-0.006, 0, 0};
        for (const int n : {0, 1, 2, 3, 9, 10}) frames_.push_back(generate(table_, n));
    }
    std::uint64_t hash(int threads) const {
        const SegmentFrames segmenter = follow_segments(table_.scene(), threads);
        ByteHash hash;
        for (std::size_t n = 0; n < frames_.size(); ++n) {
            const bool follows = n != 0 && n != 4;
            const Segmentation& found = segmenter(frames_[n].raw(), follows);
            hash.add(found.labels.data(), 2 * found.labels.size());
            for (const Segment& segment : found.segments) {
                const std::array<std::int32_t, 8> figures{
                    segment.label,    segment.pixels,    segment.x,         segment.y,
                    segment.contrast, segment.colour[0], segment.colour[1], segment.colour[2]};
                hash.add(figures.data(), sizeof figures);
            }
        }
        return hash.value();
    }

private:
    GeneratedTable table_ = random_table(11);
    std::vector<GeneratedFrame> frames_;
};

/// By GCC and Clang, with and without optimisation, and with any number of threads.
TEST(Segmenter, HasSameBitsEverywhere) {
    const HashedClip clip;
    for (const int threads : {1, 2, 4}) EXPECT_EQ(clip.hash(threads), 14712688257145656365U) << threads;
}

void expect_mostly_equal(const std::vector<std::uint16_t>& before, const std::vector<std::uint16_t>& after) {
    std::size_t same = 0;
    for (std::size_t k = 0; k < before.size(); ++k) same += before[k] == after[k] ? 1U : 0U;
    EXPECT_GE(same * 100, before.size() * 97);
}

/// After a cut things that are where they were, and look as they did, have the labels that they had.
TEST(Segmenter, RecognisesThingsAfterCut) {
    GeneratedTable table = random_table(3), other = random_table(4);
    const SegmentFrames segmenter = follow_segments(table.scene());
    const GeneratedFrame frame = generate(table, 0), later = generate(table, 1), cut = generate(other, 0);
    const std::vector<std::uint16_t> before = segmenter(frame.raw(), false).labels;
    segmenter(cut.raw(), false);
    const std::vector<std::uint16_t>& after = segmenter(later.raw(), false).labels;
    expect_mostly_equal(before, after);
}

/// Curtains are drawn: things look different, but are where they were.
TEST(Segmenter, KeepsLabelsWhenLightChanges) {
    const GeneratedTable table = random_table(3);
    const SegmentFrames segmenter = follow_segments(table.scene());
    GeneratedFrame frame = generate(table, 0);
    const std::vector<std::uint16_t> before = segmenter(frame.raw(0), false).labels;
    for (std::uint8_t& sample : frame.colour) sample = static_cast<std::uint8_t>(sample / 2);
    const std::vector<std::uint16_t>& after = segmenter(frame.raw(1), true).labels;
    expect_mostly_equal(before, after);
}

// Segments of pictures of any size, without colour, without depth, and with holes.

/// A frame by functions of column and row.
class SegmentedPictures : public ::testing::Test {
protected:
    template <class Code>
    RawFrame depth_of(int width, int height, Code&& code) {
        depth_.clear();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) depth_.push_back(static_cast<std::uint16_t>(code(x, y)));
        RawFrame frame;
        frame.depth = {reinterpret_cast<const std::uint8_t*>(depth_.data()), 2 * width, width, height, 2, 1};
        return frame;
    }
    template <class Grey>
    void paint(RawFrame& frame, int width, int height, Grey&& grey) {
        colour_.clear();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int k = 0; k < 3; ++k) colour_.push_back(static_cast<std::uint8_t>(grey(x, y)));
        frame.colour = {colour_.data(), 3 * width, width, height, 1, 3};
    }
    static Scene scene_of(int width, int height) {
        GeneratedTable table;
        table.width = width;
        table.height = height;
        return table.scene();
    }
    /// Its figures agree with its labels.
    static void check(const Segmentation& found) {
        std::map<std::uint16_t, std::int32_t> pixels;
        for (const std::uint16_t label : found.labels) ++pixels[label];
        pixels.erase(0);
        ASSERT_EQ(pixels.size(), found.segments.size());
        std::uint16_t before = 0;
        for (const Segment& segment : found.segments) {
            EXPECT_GT(segment.label, before);
            before = segment.label;
            EXPECT_EQ(segment.pixels, pixels[segment.label]);
            EXPECT_EQ(found.labels[static_cast<std::size_t>(segment.y * found.width + segment.x)],
                      segment.label);
        }
    }

    std::vector<std::uint16_t> depth_;
    std::vector<std::uint8_t> colour_;
};

TEST_F(SegmentedPictures, MayBeTiny) {
    for (const auto& [width, height] : {std::pair{1, 1}, {2, 2}, {1, 50}, {50, 1}, {5, 3}}) {
        const SegmentFrames segmenter = follow_segments(scene_of(width, height));
        RawFrame frame = depth_of(width, height, [](int, int) { return 1000; });
        for (int n = 0; n < 3; ++n) {
            const Segmentation& found = segmenter(frame, n > 0);
            check(found);
            EXPECT_EQ(found.labels, std::vector<std::uint16_t>(depth_.size(), 1)) << width << "x" << height;
        }
        frame = depth_of(width, height, [](int, int) { return 0; });
        EXPECT_TRUE(segmenter(frame, true).segments.empty());
    }
}

TEST_F(SegmentedPictures, HaveNoSegmentsInHoles) {
    const SegmentFrames segmenter = follow_segments(scene_of(64, 48));
    RawFrame frame = depth_of(64, 48, [](int, int) { return 0; });
    paint(frame, 64, 48, [](int x, int) { return x; });
    for (int n = 0; n < 2; ++n) {
        const Segmentation& found = segmenter(frame, n > 0);
        EXPECT_TRUE(found.segments.empty());
        EXPECT_EQ(*std::max_element(found.labels.begin(), found.labels.end()), 0);
    }
    // And where surfaces come and go again, they have the label that they had.
    const auto surface = [](int x, int) { return x < 32 ? 1000 : 2000; };
    RawFrame seen = depth_of(64, 48, surface);
    const std::vector<std::uint16_t> labels = segmenter(seen, true).labels;
    segmenter(depth_of(64, 48, [](int, int) { return 0; }), true);
    EXPECT_EQ(segmenter(depth_of(64, 48, surface), true).labels, labels);
}

TEST_F(SegmentedPictures, SplitAtDepthSteps) {
    for (const bool with_colour : {false, true}) {
        const SegmentFrames segmenter = follow_segments(scene_of(160, 120));
        const auto is_near = [](int x, int y) { return x > 50 && x < 110 && y > 30 && y < 90; };
        RawFrame frame = depth_of(160, 120, [&](int x, int y) { return is_near(x, y) ? 1000 : 1200; });
        if (with_colour) paint(frame, 160, 120, [](int, int) { return 90; });  // one colour
        const Segmentation& found = segmenter(frame, false);
        check(found);
        ASSERT_EQ(found.segments.size(), 2U);
        int wrong = 0;
        for (int y = 0; y < 120; ++y)
            for (int x = 0; x < 160; ++x)
                wrong +=
                    (found.labels[static_cast<std::size_t>(y * 160 + x)] == found.labels[0]) == is_near(x, y);
        EXPECT_EQ(wrong, 0);
        for (const Segment& segment : found.segments) {
            EXPECT_EQ(segment.contrast, 0);
            EXPECT_EQ(segment.colour[1], with_colour ? 90 : 0);
        }
    }
}

/// Neither the slope of a slanted floor nor a gap in it is a step.
TEST_F(SegmentedPictures, JoinFloorAcrossGap) {
    const SegmentFrames segmenter = follow_segments(scene_of(160, 120));
    const RawFrame frame = depth_of(160, 120, [](int x, int y) {
        const double down = 0.2 + y / 120.0;  // of a floor depth is 1 over it
        return x == 80 || x == 81 ? 0 : static_cast<int>(1000 / down);
    });
    const Segmentation& found = segmenter(frame, false);
    check(found);
    EXPECT_EQ(found.segments.size(), 1U);
}

TEST_F(SegmentedPictures, ScaleLargerColour) {
    const auto found_with = [&](int times) {
        const SegmentFrames segmenter = follow_segments(scene_of(160, 120));
        RawFrame frame = depth_of(160, 120, [](int, int) { return 1000; });
        paint(frame, 160 * times, 120 * times, [&](int x, int) { return x < 80 * times ? 40 : 220; });
        const Segmentation& found = segmenter(frame, false);
        check(found);
        return found;
    };
    const Segmentation plain = found_with(1), larger = found_with(3);
    ASSERT_EQ(plain.segments.size(), 2U);
    EXPECT_EQ(plain.segments[0].colour[0], 40);
    EXPECT_EQ(plain.segments[1].colour[0], 220);
    EXPECT_EQ(larger.labels, plain.labels);
    EXPECT_EQ(larger.segments, plain.segments);
}

/// Every coding of depth, and depth along the ray.
TEST_F(SegmentedPictures, ReadAnyDepthCoding) {
    for (const DepthCodingKind kind : {DepthCodingKind::linear, DepthCodingKind::inverse})
        for (const DepthSemantics semantics : {DepthSemantics::range, DepthSemantics::planar}) {
            Scene scene = small_scene(160, 120, 16);
            scene.camera = {130, 130, 79.5, 59.5};
            scene.depth.kind = kind;
            scene.depth.semantics = semantics;
            derive_valid_range(scene.depth);
            const RawFrame frame = depth_of(160, 120, [&](int x, int y) {
                const double ray = semantics == DepthSemantics::range ? scene.camera.ray_length(x, y) : 1.0;
                return scene.depth.code((x < 80 ? 60 : 70) * ray);
            });
            const SegmentFrames segmenter = follow_segments(scene);
            const Segmentation& found = segmenter(frame, false);
            EXPECT_EQ(found.segments.size(), 2U);
            EXPECT_NE(found.labels[79], found.labels[80]);
        }
}

TEST_F(SegmentedPictures, MeasureTexture) {
    const auto contrast_of = [&](auto&& grey) {
        const SegmentFrames segmenter = follow_segments(scene_of(160, 120));
        RawFrame frame = depth_of(160, 120, [](int, int) { return 1000; });
        paint(frame, 160, 120, grey);
        const Segmentation& found = segmenter(frame, false);
        EXPECT_EQ(found.segments.size(), 1U);
        return found.segments[0].contrast;
    };
    EXPECT_EQ(contrast_of([](int, int) { return 100; }), 0);
    EXPECT_LE(contrast_of([](int x, int) { return 80 + x / 8; }), 8);  // light that falls off
    EXPECT_NEAR(contrast_of([](int x, int y) { return (x + y) % 2 ? 110 : 90; }), 160, 4);  // 10 levels
}

/// Depth of 8 bits is a staircase: its steps are no edges.
TEST_F(SegmentedPictures, IgnoreEightBitSteps) {
    double sum = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        GeneratedTable table = random_table(seed);
        table.depth_noise = 0;
        Scene scene = table.scene();
        scene.depth.kind = DepthCodingKind::inverse;
        scene.depth.near = 0.4;
        scene.depth.far = 8;
        scene.depth.code_max = 255;
        scene.depth.invalid_code_count = 0;
        derive_valid_range(scene.depth);
        GeneratedFrame frame = generate(table, 0);
        for (std::uint16_t& code : frame.depth) code = scene.depth.code(code * 0.001);
        const SegmentFrames segmenter = follow_segments(scene);
        const Segmentation& found = segmenter(frame.raw(), false);
        check(found);
        std::printf("8 bits, scene %d: %zu segments, mean IoU %.3f\n", static_cast<int>(seed),
                    found.segments.size(), mean_iou(frame.truth, found.labels));
        sum += mean_iou(frame.truth, found.labels);
        EXPECT_LE(found.segments.size(), 20U);
    }
    EXPECT_GE(sum / 4, 0.92);
}

}  // namespace
}  // namespace touchable::test
