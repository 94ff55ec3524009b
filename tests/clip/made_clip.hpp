// SPDX-License-Identifier: Apache-2.0
#pragma once

// Clips that are made when they are read: a scene as a network guesses its depth, and one as a depth camera
// sees it.

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/clip/clip.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/must.hpp"

namespace touchable::test {

/// The scene shown to a network: a leaning wall with bumps, and a ball before it. The camera may go ahead.
struct Scenery {
    int columns = 96, rows = 72;
    double ball_near = 0;  ///< how much nearer than the wall, as 1/depth; 0: no ball
    double ball_x = 0.5;   ///< its middle, of the width
    double forward = 0;    ///< how far the camera has gone ahead, of the depth of the middle
    int wall = 0;          ///< which one: another texture, another slope

    bool is_ball(int x, int y) const {
        const double dx = x - ball_x * columns, dy = y - 0.5 * rows, radius = 0.2 * rows;
        return ball_near > 0 && dx * dx + dy * dy < radius * radius;
    }
    /// 1/depth, 0 to about 1.
    double value(int x, int y) const {
        const double lean =
            0.25 + 0.35 * (wall % 2 ? x / static_cast<double>(columns) : y / static_cast<double>(rows));
        const double bump = 0.03 * (((x / 16) + (y / 16)) % 2);
        const double there = lean + bump;
        return there / (1 - forward * there) + (is_ball(x, y) ? ball_near : 0);
    }
    /// Patches of 3x3 pixels, which grow as the camera goes ahead.
    std::uint8_t brightness(int x, int y) const {
        const double zoom = 1 - forward * 0.45;
        const double u = (x - 0.5 * columns) * zoom, v = (y - 0.5 * rows) * zoom;
        const bool ball = is_ball(x, y);
        const auto at = [&](double place) {
            return static_cast<std::uint64_t>(static_cast<int>(place + 3000) / 3);
        };
        const double shift = ball ? ball_x * columns : 0;
        Random numbers(at(u - shift) * 7919 + at(v) * 104729 + static_cast<std::uint64_t>(wall) * 31 +
                       (ball ? 5 : 0));
        return static_cast<std::uint8_t>(40 + numbers.next() % 160);
    }
};

/// Low byte first.
inline void push_16(Image& image, int code) {
    image.samples.push_back(static_cast<std::uint8_t>(code & 255));
    image.samples.push_back(static_cast<std::uint8_t>(code >> 8));
}

/// The depth that it guessed: scale x value + shift, codes of 8 or 16 bits.
struct Guessed {
    double scale = 1, shift = 0;
    int code(double value, int most) const {
        const double code = (scale * value + shift) * most + 0.5;
        return code < 0 ? 0 : code > most ? most : static_cast<int>(code);
    }
};

inline RawFrame guessed_frame(const Scenery& scenery, const Guessed& guessed, int bytes, bool colour,
                              std::int64_t number) {
    RawFrame frame;
    frame.number = number;
    frame.time_ns = 33'000'000 * number;
    Image depth{scenery.columns, scenery.rows, bytes, 1, {}}, rgb{scenery.columns, scenery.rows, 1, 3, {}};
    const int most = bytes == 1 ? 255 : 65534;
    for (int y = 0; y < scenery.rows; ++y)
        for (int x = 0; x < scenery.columns; ++x) {
            const auto code = static_cast<std::uint16_t>(guessed.code(scenery.value(x, y), most));
            depth.samples.push_back(static_cast<std::uint8_t>(code & 255));
            if (bytes == 2) depth.samples.push_back(static_cast<std::uint8_t>(code >> 8));
            const std::uint8_t grey = scenery.brightness(x, y);
            rgb.samples.insert(rgb.samples.end(), {grey, grey, static_cast<std::uint8_t>(255 - grey)});
        }
    add_plane(frame, PlaneRole::depth, plane_from(std::move(depth), 8 * bytes));
    if (colour) add_plane(frame, PlaneRole::colour, plane_from(std::move(rgb)));
    return frame;
}

/// Frames that are made when they are read.
class MadeClip final : public OwnClip {
public:
    using Make = std::function<RawFrame(std::int64_t)>;
    MadeClip(std::int64_t count, int bytes, Make make) : OwnClip({}, count), make_(std::move(make)) {
        const RawFrame first = make_(0);
        scene_ = small_scene(first.depth.width, first.depth.height, 8 * bytes);
        scene_.metres_per_unit = 1;
        scene_.depth.kind = DepthCodingKind::inverse;
        scene_.depth.near = 0.5;
        scene_.depth.far = 1.5;
        scene_.depth.code_max = bytes == 1 ? 255 : 65534;
        derive_valid_range(scene_.depth);
        tracks_ = {{"depth", "made", "gray", scene_.width, scene_.height, true}};
        add_input("made");
    }
    using OwnClip::scene;
    Scene& scene() { return scene_; }
    Result<std::optional<RawFrame>> next() override {
        if (number_ == count_) return std::optional<RawFrame>{};
        return std::optional(make_(number_++));
    }
    Result<void> seek(std::int64_t frame) override {
        number_ = frame;
        return {};
    }

private:
    Make make_;
};

/// A table that leans, a box on it, and a hand that goes over it and up and down, as a depth camera sees
/// them: a shadow without depth beside the hand and beside the box, drop-outs, a millimetre or two of noise;
/// and a hole in the middle of the hand. Metric codes, millimetres; all in whole numbers.
struct StillScene {
    static constexpr int columns = 160, rows = 120;
    static constexpr int radius = 14, shadow = 6, hole_radius = 3;

    bool has_colour = true;
    bool hand_has_colour_of_table = false;
    int colour_shift = 0;  ///< pixels that colour lies to the right of its depth: it is not registered
    bool hand_has_sleeve = false;  ///< its right half has no depth
    int pan = 0;    ///< sixteenths of a pixel that the camera goes to the right from frame to frame
    int rise = 0;   ///< sixteenths of a millimetre that it goes up, too
    int table = 0;  ///< which one: another texture, another depth
    std::int64_t rests_from = 1000;  ///< the frame from which the hand lies on the table, 12 mm thick

    enum class Thing { table, box, hand };
    struct Seen {
        Thing thing = Thing::table;
        int depth = 0;         ///< without noise; of a hole that of the thing
        bool is_hole = false;  ///< of any kind
        bool is_shadow = false;
    };

    static std::uint64_t chance(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        return Random(a * 7919 + b * 104'729 + c * 1'299'709 + 17).next() >> 20;
    }
    int hand_x(std::int64_t frame) const {
        return frame >= rests_from ? 60 : 10 + static_cast<int>(frame * 5 % 140);
    }
    bool is_hand(int x, int y, std::int64_t frame, int wide) const {
        const int dx = x - hand_x(frame), dy = y - 50;
        return dx * dx + dy * dy < wide * wide;
    }
    bool is_hole_of_hand(int x, int y, std::int64_t frame) const {
        return is_hand(x, y, frame, hole_radius) || (hand_has_sleeve && x > hand_x(frame));
    }
    int shift(std::int64_t frame) const { return static_cast<int>(pan * frame / 16); }
    int table_depth(int y) const { return 1000 + 150 * table + 2 * y; }
    int hand_depth(int y, std::int64_t frame) const {
        return frame >= rests_from ? table_depth(y) - 12 : 780 + static_cast<int>(frame * 7 % 60);
    }
    bool is_box(int x, int y) const { return x >= 90 && x < 120 && y >= 70 && y < 100; }

    Seen at(int x, int y, std::int64_t frame) const {
        const int there = x + shift(frame), up = static_cast<int>(rise * frame / 16);
        Seen seen{Thing::table, table_depth(y) + up, false, false};
        if (is_box(there, y)) seen = {Thing::box, table_depth(y) - 60 + up, false, false};
        const bool beside_box = seen.thing == Thing::table && is_box(there + 3, y);
        if (is_hand(x, y, frame, radius)) {
            seen = {Thing::hand, hand_depth(y, frame), is_hole_of_hand(x, y, frame), false};
        } else if (is_hand(x + shadow, y, frame, radius)) {
            seen.is_shadow = seen.is_hole = true;
        }
        if (beside_box || chance(x, y, static_cast<std::uint64_t>(frame)) % 40 == 0) seen.is_hole = true;
        return seen;
    }
    /// Patches of 3x3 pixels, and a little noise.
    std::array<std::uint8_t, 3> colour(int x, int y, std::int64_t frame) const {
        const Thing thing = at(x, y, frame).thing;
        const bool is_dark = thing == Thing::hand && !hand_has_colour_of_table;
        const auto column = static_cast<std::uint64_t>(x + shift(frame)) / 3;
        const auto noise = chance(x + 1000, y, static_cast<std::uint64_t>(frame)) % 5;
        const auto patch = hand_has_colour_of_table ? 100 : chance(column, y / 3, table + 50) % 120;
        const auto level = static_cast<std::uint8_t>((is_dark ? 30 : 60 + patch) + noise);
        return {level, level, static_cast<std::uint8_t>(thing == Thing::box ? 250 : 255 - level)};
    }
    RawFrame frame(std::int64_t number) const {
        RawFrame frame;
        frame.number = number;
        frame.time_ns = 33'000'000 * number;
        Image depth{columns, rows, 2, 1, {}}, rgb{columns, rows, 1, 3, {}};
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) {
                const Seen seen = at(x, y, number);
                const auto noise =
                    static_cast<int>(chance(x, y, static_cast<std::uint64_t>(number) + 500) % 5) - 2;
                const int code = seen.is_hole ? 0 : seen.depth + noise;
                push_16(depth, code);
                const auto pixel = colour(x - colour_shift, y, number);
                rgb.samples.insert(rgb.samples.end(), pixel.begin(), pixel.end());
            }
        add_plane(frame, PlaneRole::depth, plane_from(std::move(depth), 16));
        if (has_colour) add_plane(frame, PlaneRole::colour, plane_from(std::move(rgb)));
        return frame;
    }
};

/// Whether `filled` says so.
inline bool is_marked(const RawFrame& frame, int x, int y) {
    const std::size_t words = (static_cast<std::size_t>(frame.depth.width) + 31) / 32;
    return frame.filled &&
           ((*frame.filled)[static_cast<std::size_t>(y) * words + static_cast<std::size_t>(x) / 32] >>
                (x % 32) &
            1U) != 0;
}

/// Codes are millimetres, 0 is no depth.
inline DepthCoding millimetres() {
    DepthCoding depth;
    depth.kind = DepthCodingKind::metric;
    depth.near = 0;
    depth.far = 4000;
    depth.scale = 1;
    depth.code_max = 65535;
    depth.invalid_code_count = 1;
    derive_valid_range(depth);
    return depth;
}

inline std::unique_ptr<MadeClip> clip_of(std::int64_t count, MadeClip::Make make) {
    auto clip = std::make_unique<MadeClip>(count, 2, std::move(make));
    clip->scene().metres_per_unit = 0.001;
    clip->scene().depth = millimetres();
    return clip;
}

/// Frames that are made when they are first read, and kept: they are read three times and more.
inline MadeClip::Make frames_of(std::function<StillScene(std::int64_t)> scene) {
    auto made = std::make_shared<std::map<std::int64_t, RawFrame>>();
    return [=](std::int64_t n) {
        auto known = made->find(n);
        if (known == made->end()) known = made->emplace(n, scene(n).frame(n)).first;
        return known->second;
    };
}
inline std::unique_ptr<MadeClip> clip_of(const StillScene& scene, std::int64_t count) {
    return clip_of(count, frames_of([scene](std::int64_t) { return scene; }));
}

inline std::unique_ptr<ClipReader> filled(std::unique_ptr<ClipReader> clip) {
    return must(with_filled_holes(std::move(clip)));
}

}  // namespace touchable::test
