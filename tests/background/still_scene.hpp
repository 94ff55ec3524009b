#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/clip/clip.hpp"
#include "tests/alignment/pumping_clip.hpp"

namespace touchable::test {

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
