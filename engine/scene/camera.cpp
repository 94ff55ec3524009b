// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <utility>

#include "engine/base/words.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

Camera camera_from_focal_length(double focal_length, double pixel_width, int width, int height) {
    const double focal_pixels = focal_length / pixel_width;
    return {focal_pixels, focal_pixels, width / 2.0, height / 2.0 - 1.0};
}

double planar_depth(const Camera& camera, DepthSemantics semantics, double x, double y, double depth) {
    return semantics == DepthSemantics::range ? depth / camera.ray_length(x, y) : depth;
}

double depth_of(DepthSemantics semantics, const glm::dvec3& point) {
    return semantics == DepthSemantics::range ? glm::length(point) : -point.z;
}

glm::dvec3 unproject(const Camera& camera, double x, double y, double planar_depth) {
    return {planar_depth * camera.u(x), planar_depth * camera.v(y), -planar_depth};
}

std::optional<Camera::ImagePoint> project(const Camera& camera, const glm::dvec3& point) {
    if (!(point.z < 0.0)) return std::nullopt;
    const double planar_depth = -point.z;
    return Camera::ImagePoint{camera.cx + camera.fx * (point.x / planar_depth),
                              camera.cy - camera.fy * (point.y / planar_depth), planar_depth};
}

namespace {

double radial(const std::array<double, 8>& terms, double r2) {
    const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = terms;
    return (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
}

__extension__ using Wide = __int128;

std::int64_t even_time(const FrameRate& rate, std::int64_t frame) {
    const Wide numerator = Wide{frame} * rate.den * 1'000'000'000;
    Wide quotient = numerator / rate.num;
    if (numerator % rate.num < 0) --quotient;  // division truncates; a time before 0 is floored too
    constexpr Wide most = std::numeric_limits<std::int64_t>::max();
    return static_cast<std::int64_t>(std::clamp(quotient, -most, most));
}

// The largest n with floor(n 1e9 den / num) <= time, which is n 1e9 den < (time + 1) num.
std::int64_t even_frame(const FrameRate& rate, std::int64_t time_ns) {
    const Wide numerator = (Wide{time_ns} + 1) * rate.num - 1, unit = Wide{rate.den} * 1'000'000'000;
    Wide quotient = numerator / unit;
    if (numerator % unit < 0) --quotient;
    return static_cast<std::int64_t>(quotient);
}

/// Returns the numbers of a line, which spaces or commas separate; nullopt if there are more than `most`, or
/// anything else.
std::optional<std::vector<double>> numbers_of_line(std::string_view line, std::size_t most) {
    std::vector<double> numbers;
    constexpr std::string_view between = " \t\r,";
    while (numbers.size() <= most) {
        line = line.substr(std::min(line.find_first_not_of(between), line.size()));
        if (line.empty()) return numbers;
        const std::string_view word = line.substr(0, line.find_first_of(between));
        const auto number = parsed_number(word);
        if (!number) return {};
        numbers.push_back(*number);
        line.remove_prefix(word.size());
    }
    return {};
}

/// x, y, z, w of a rotation; w is not negative.
std::array<double, 4> quaternion_of(const std::array<double, 9>& r) {
    // The largest of the four is found from the diagonal, and the others from it.
    const double squares[4] = {1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8], 1 - r[0] - r[4] + r[8],
                               1 + r[0] + r[4] + r[8]};
    const auto k = static_cast<std::size_t>(std::max_element(squares, squares + 4) - squares);
    const double xy = r[1] + r[3], xz = r[2] + r[6], yz = r[5] + r[7], xw = r[7] - r[5], yw = r[2] - r[6],
                 zw = r[3] - r[1];
    const std::array<double, 4> rows[4] = {{squares[0], xy, xz, xw},
                                           {xy, squares[1], yz, yw},
                                           {xz, yz, squares[2], zw},
                                           {xw, yw, zw, squares[3]}};
    std::array<double, 4> q = rows[k];
    double length = 0;
    for (const double term : q) length += term * term;
    length = std::sqrt(length) * (q[3] < 0 ? -1 : 1);
    for (double& term : q) term /= length;
    return q;
}

}  // namespace

LensDistortion::Point LensDistortion::distorted(Point point) const {
    const double x = point.x, y = point.y, r2 = x * x + y * y, stretch = radial(terms, r2);
    const double p1 = terms[2], p2 = terms[3];
    return {x * stretch + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * stretch + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

double LensDistortion::reach() const {
    constexpr double farthest = 10, step = 0.005;
    double before = 0;
    for (double r = step; r < farthest; r += step) {
        const double shown = r * radial(terms, r * r);
        if (!(shown > before)) return r - step;
        before = shown;
    }
    return farthest;
}

CameraPose CameraPose::inverse() const {
    CameraPose back;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column) {
            back.rotation[3 * row + column] = rotation[3 * column + row];
            back.translation[row] -= rotation[3 * column + row] * translation[column];
        }
    }
    return back;
}

CameraPose CameraPose::after(const CameraPose& first) const {
    CameraPose both;
    both.rotation = {};
    both.translation = translation;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t k = 0; k < 3; ++k) {
            const double turn = rotation[3 * row + k];
            both.translation[row] += turn * first.translation[k];
            for (std::size_t column = 0; column < 3; ++column)
                both.rotation[3 * row + column] += turn * first.rotation[3 * k + column];
        }
    return both;
}

std::int64_t FrameRate::time_ns(std::int64_t frame) const {
    if (!own_times || frame < 0) return even_time(*this, frame);
    const auto last = static_cast<std::int64_t>(own_times->size()) - 1;
    if (frame <= last) return (*own_times)[static_cast<std::size_t>(frame)];
    const Wide time = Wide{own_times->back()} + even_time(*this, frame - last);
    return static_cast<std::int64_t>(std::min(time, Wide{std::numeric_limits<std::int64_t>::max()}));
}

std::int64_t FrameRate::frame_at(std::int64_t time_ns) const {
    if (!own_times || time_ns < 0) return even_frame(*this, time_ns);
    if (time_ns >= own_times->back())
        return static_cast<std::int64_t>(own_times->size()) - 1 +
               even_frame(*this, time_ns - own_times->back());
    return std::ranges::upper_bound(*own_times, time_ns) - own_times->begin() - 1;
}

std::int64_t FrameRate::nearest(std::int64_t time) const {
    const std::int64_t before = frame_at(time);
    return time_ns(before + 1) - time < time - time_ns(before) ? before + 1 : before;
}

std::optional<FrameRate> rate_of_own_times(std::vector<std::int64_t> times_ns) {
    constexpr std::int64_t latest_ns = 4'000'000'000'000'000'000;
    if (times_ns.size() < 2) return {};
    const std::int64_t first_ns = times_ns.front();
    for (std::size_t n = 1; n < times_ns.size(); ++n)
        if (Wide{times_ns[n]} - times_ns[n - 1] < shortest_frame_ns) return {};
    if (Wide{times_ns.back()} - first_ns > latest_ns) return {};
    for (std::int64_t& time_ns : times_ns) time_ns -= first_ns;
    const double mean = static_cast<double>(times_ns.size() - 1) * 1e9 / static_cast<double>(times_ns.back());
    const std::int64_t den = mean < 1 ? 1'000'000'000 : 1'000'000;
    const std::int64_t num = std::max<std::int64_t>(std::llround(mean * static_cast<double>(den)), 1);
    const std::int64_t common = std::gcd(num, den);
    FrameRate rate{num / common, den / common};
    rate.own_times = std::make_shared<const std::vector<std::int64_t>>(std::move(times_ns));
    return rate;
}

std::size_t CameraPath::known() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(poses, [](const auto& pose) { return pose.has_value(); }));
}

double CameraPath::length() const {
    double length = 0;
    const CameraPose* before = nullptr;
    for (const auto& pose : poses) {
        if (!pose) continue;
        double squares = 0;
        for (std::size_t k = 0; before && k < 3; ++k)
            squares += (pose->translation[k] - before->translation[k]) *
                       (pose->translation[k] - before->translation[k]);
        length += std::sqrt(squares);
        before = &*pose;
    }
    return length;
}

CameraPath CameraPath::part(std::int64_t first, std::optional<std::int64_t> last, std::int64_t every) const {
    CameraPath part;
    const std::int64_t all = std::ssize(poses), end = last ? std::min(all, *last + 1) : all;
    for (std::int64_t frame = first; frame < end; frame += every)
        part.poses.push_back(poses[static_cast<std::size_t>(frame)]);
    return part;
}

std::optional<std::array<double, 9>> rotation_of(double x, double y, double z, double w) {
    const double length = std::sqrt(x * x + y * y + z * z + w * w);
    if (!(std::abs(length - 1) < 0.01)) return {};
    x /= length, y /= length, z /= length, w /= length;
    return std::array<double, 9>{1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                                 2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                                 2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
}

std::optional<CameraPose> pose_at(const std::array<double, 9>& rotation, const std::array<double, 3>& metres,
                                  double metres_per_unit) {
    CameraPose pose{rotation, metres};
    for (double& length : pose.translation) {
        if (!(std::abs(length) < 1e9)) return {};
        length /= metres_per_unit;
    }
    return pose;
}

bool is_rotation(const std::array<double, 9>& m) {
    constexpr double rounded_off = 1e-3;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) {
            double product = 0;
            for (std::size_t k = 0; k < 3; ++k) product += m[3 * a + k] * m[3 * b + k];
            if (!(std::abs(product - (a == b ? 1 : 0)) < rounded_off)) return false;
        }
    const double volume = m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
                          m[2] * (m[3] * m[7] - m[4] * m[6]);
    return volume > 0;
}

Result<std::vector<CameraPath::TimedPose>> parse_timed_poses(std::string_view text, const std::string& name,
                                                             double metres_per_unit) {
    std::vector<CameraPath::TimedPose> poses;
    for (int number = 1; !text.empty(); ++number) {
        std::string_view whole = cut_line(text);
        const std::string_view line = cut_part(whole, '#');
        const auto numbers = numbers_of_line(line, 8);
        if (numbers && numbers->empty()) continue;
        const auto refuse = [&](const std::string& what) {
            return input_error(name + ", line " + std::to_string(number) + ": " + what);
        };
        if (!numbers || numbers->size() != 8)
            return refuse("is " + in_quotes(line) +
                          ": must be a time and a camera's pose, tx ty tz qx qy qz qw");
        const std::vector<double>& n = *numbers;
        const auto rotation = rotation_of(n[4], n[5], n[6], n[7]);
        if (!rotation) return refuse("its qx qy qz qw must be a rotation, a quaternion of length 1");
        if (!poses.empty() && n[0] < poses.back().seconds)
            return refuse("its time must not be before that of the pose before");
        if (poses.size() >= most_timed_poses) return refuse("is beyond the 2000000 poses that can be read");
        const auto pose = pose_at(*rotation, {n[1], n[2], n[3]}, metres_per_unit);
        if (!pose) return refuse("its tx ty tz must be metres, below 1e9");
        poses.push_back({n[0], *pose});
    }
    return poses;
}

std::string timed_poses_text(const CameraPath& path, const FrameRate& rate, double metres_per_unit) {
    constexpr std::int64_t ns_a_second = 1'000'000'000;
    std::string text = "# time tx ty tz qx qy qz qw\n";
    for (std::size_t frame = 0; frame < path.poses.size(); ++frame) {
        if (!path.poses[frame]) continue;
        const std::int64_t ns = rate.time_ns(static_cast<std::int64_t>(frame));
        text += formatted("%lld.%09lld", static_cast<long long>(ns / ns_a_second),
                          static_cast<long long>(ns % ns_a_second));
        const auto add = [&](double number) { text += ' ' + exact_number(number); };
        for (const double length : path.poses[frame]->translation) add(length * metres_per_unit);
        for (const double term : quaternion_of(path.poses[frame]->rotation)) add(term);
        text += '\n';
    }
    return text;
}

CameraPath path_of_timed_poses(const std::vector<CameraPath::TimedPose>& poses, const FrameRate& rate) {
    constexpr double latest_seconds = 4e9;
    CameraPath path;
    for (const CameraPath::TimedPose& pose : poses) {
        if (!(pose.seconds >= 0 && pose.seconds < latest_seconds)) continue;
        const std::int64_t ns = std::llround(pose.seconds * 1e9), frame = rate.nearest(ns);
        if (frame < 0 || frame >= static_cast<std::int64_t>(most_path_frames)) continue;
        if (std::abs(rate.time_ns(frame) - ns) > shortest_frame_ns / 2) continue;
        const auto index = static_cast<std::size_t>(frame);
        if (path.poses.size() <= index) path.poses.resize(index + 1);
        path.poses[index] = pose.pose;
    }
    return path;
}

}  // namespace touchable
