#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

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
class MadeClip final : public ClipReader {
public:
    using Make = std::function<RawFrame(std::int64_t)>;
    MadeClip(std::int64_t count, int bytes, Make make) : count_(count), make_(std::move(make)) {
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
    const Scene& scene() const override { return scene_; }
    Scene& scene() { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return count_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override {
        if (at_ == count_) return std::optional<RawFrame>{};
        return std::optional(make_(at_++));
    }
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override {
        at_ = frame;
        return {};
    }

private:
    std::int64_t count_, at_ = 0;
    Make make_;
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
};

}  // namespace touchable::test
