#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {

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
inline Vector camera_at(const GeneratedTable& table, int frame) {
    return {table.camera_speed[0] * frame, 0.75 + table.camera_speed[1] * frame,
            0.9 + table.camera_speed[2] * frame};
}

struct Hit {
    double distance = 1e9;
    Vector normal{};
};

inline void nearer(Hit& hit, double distance, const Vector& normal) {
    if (distance > 1e-6 && distance < hit.distance) hit = {distance, normal};
}

inline Hit hit_of(const Thing& thing, const Vector& from, const Vector& ray) {
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

inline GeneratedFrame generate(const GeneratedTable& table, int frame, std::uint64_t seed = 1) {
    const int width = table.width, height = table.height;
    const auto pixels = static_cast<std::size_t>(width * height);
    GeneratedFrame out{std::vector<std::uint8_t>(3 * pixels),
                       std::vector<std::uint16_t>(pixels),
                       std::vector<std::uint16_t>(pixels),
                       std::vector<std::array<double, 3>>(pixels),
                       width,
                       height};
    Numbers numbers(seed * 1000 + static_cast<std::uint64_t>(frame));
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

/// Where what is seen at a pixel of a frame was in the one before: its place in the picture, if it was seen.
inline std::optional<std::size_t> place_before(const GeneratedTable& table, const GeneratedFrame& now,
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
inline double mean_iou(const std::vector<std::uint16_t>& truth, const std::vector<std::uint16_t>& labels) {
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
inline GeneratedTable random_table(std::uint64_t seed, int width = 320, int height = 240) {
    Numbers numbers(seed + 77);
    const auto between = [&](int least, int most) { return least + numbers.below(most - least + 1); };
    constexpr std::array<std::array<int, 3>, 7> colours{{{190, 50, 45},
                                                         {50, 80, 170},
                                                         {60, 140, 70},
                                                         {215, 190, 60},
                                                         {60, 60, 65},
                                                         {225, 225, 220},
                                                         {150, 70, 140}}};
    GeneratedTable table;
    table.width = width;
    table.height = height;
    table.things.push_back({Thing::Kind::wall, {0, 0, -0.75}, {}, {190, 195, 200}, 3});
    table.things.push_back({Thing::Kind::table, {0, 0, 0}, {}, {150, 110, 70}, 8});
    const int first = numbers.below(7);
    for (int k = 0; k < 5; ++k) {
        const double x = (k % 3 - 1) * 0.34 + between(-30, 30) / 1000.0,
                     z = (k < 3 ? -0.3 : 0.08) + between(-30, 30) / 1000.0;
        const std::array<int, 3>& colour = colours[static_cast<std::size_t>((first + k) % 7)];
        const double across = between(80, 130) / 1000.0;
        const double shift = k < 3 ? 0 : 0.17;
        const int stripes = between(0, 10);
        if (k % 3 == 0)
            table.things.push_back(
                {Thing::Kind::box, {x + shift, 0, z}, {1.6 * across, across, across}, colour, stripes});
        else if (k % 3 == 1)
            table.things.push_back(
                {Thing::Kind::ball, {x + shift, across, z}, {across, 0, 0}, colour, stripes});
        else
            table.things.push_back(
                {Thing::Kind::can, {x + shift, 0, z}, {0.6 * across, 2 * across, 0}, colour, stripes});
    }
    return table;
}

}  // namespace touchable::test
