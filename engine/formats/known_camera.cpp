#include "engine/formats/known_camera.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/trigonometry.hpp"

namespace touchable {
namespace {

constexpr std::string_view camera_mark = "the camera sees ", doubt_mark = "the median depth is ";

/// For a person: "1861 km", "0.5 m", "0.2 mm".
std::string length_in_words(double metres) {
    if (metres >= 10'000) return short_number(metres / 1000) + " km";
    return metres < 0.1 ? short_number(metres * 1000) + " mm" : short_number(metres) + " m";
}

}  // namespace

Camera scaled_camera(const Intrinsics& intrinsics, int width, int height) {
    Camera camera{intrinsics.fx, intrinsics.fy, 0.5 * (width - 1), 0.5 * (height - 1)};
    const bool has_size = intrinsics.width > 0 && intrinsics.height > 0;
    double x = has_size ? static_cast<double>(width) / intrinsics.width : 1,
           y = has_size ? static_cast<double>(height) / intrinsics.height : 1;
    // Of another shape: cameras cut off what is too much, and stretch nothing.
    if (std::abs(x - y) > 0.01 * x) x = y = std::max(x, y);
    camera.fx *= x;
    camera.fy *= y;
    const auto centre = [](double at, int from, double scale, int to) {
        return (at - 0.5 * (from - 1)) * scale + 0.5 * (to - 1);
    };
    if (intrinsics.cx)
        camera.cx = has_size ? centre(*intrinsics.cx, intrinsics.width, x, width) : *intrinsics.cx;
    if (intrinsics.cy)
        camera.cy = has_size ? centre(*intrinsics.cy, intrinsics.height, y, height) : *intrinsics.cy;
    return camera;
}

Camera camera_of_fov(double degrees, int width, int height) {
    const double half = degrees * pi / 360, f = 0.5 * width * cosine(half) / sine(half);
    return {f, f, 0.5 * (width - 1), 0.5 * (height - 1)};
}

std::string guessed_field_of_view(double degrees) {
    constexpr double more = 10;  // degrees
    const auto width = [](double whole) { return sine(whole * pi / 360) / cosine(whole * pi / 360); };
    const double other = std::min(degrees + more, 175.0);
    return std::string(camera_mark) + short_number(degrees) + " degrees from left to right; if it sees " +
           short_number(other) + ", all shapes are " +
           short_number(100 * (1 - width(degrees) / width(other)), 2) + " % too narrow";
}

std::optional<Remark> unit_doubt(double median_m, std::string otherwise, Hints hints) {
    // From an endoscope's to a lidar's: a unit that is wrong by a thousand leaves this for what a hand
    // reaches.
    constexpr double nearest = 0.01, farthest = 300;  // metres
    if (median_m >= nearest && median_m <= farthest) return std::nullopt;
    return Remark{std::string(doubt_mark) + length_in_words(median_m) + ": the unit may be wrong", false,
                  std::move(otherwise), std::move(hints)};
}

bool guesses_camera(const Remark& remark) {
    return remark.is_guess && remark.what.starts_with(camera_mark);
}

bool doubts_unit(const Remark& remark) {
    return remark.what.starts_with(doubt_mark);
}

}  // namespace touchable
