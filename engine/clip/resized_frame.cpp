#include "engine/clip/resized_frame.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/clip/plane_role.hpp"

namespace touchable {
namespace {

/// Columns of one picture in the other's: column x is a + b x.
struct Columns {
    double a = 0, b = 1;
};
Columns fitted_columns(int from, int to) {
    const std::vector<int> samples = nearest_samples(from, to);
    Columns columns{0, static_cast<double>(from) / to};
    for (int x = 0; x < to; ++x) columns.a += samples[static_cast<std::size_t>(x)] - columns.b * x;
    columns.a /= to;
    return columns;
}

Image nearest(const PlaneView& plane, int width, int height) {
    const auto bytes = static_cast<std::size_t>(plane.bytes_per_sample * plane.channels);
    const std::vector<int> columns = nearest_samples(plane.width, width),
                           rows = nearest_samples(plane.height, height);
    Image image{width, height, plane.bytes_per_sample, plane.channels, {}};
    image.samples.resize(bytes * columns.size() * rows.size());
    std::uint8_t* to = image.samples.data();
    for (const int row : rows)
        for (const int column : columns) {
            std::memcpy(to, plane.row(row) + bytes * static_cast<std::size_t>(column), bytes);
            to += bytes;
        }
    return image;
}

/// Which samples of `from` a sample of `to` covers, and each one's share: whole numbers that sum up to
/// `from`.
struct Covered {
    int first = 0;
    std::vector<std::int64_t> shares;
};
std::vector<Covered> covered_samples(int from, int to) {
    std::vector<Covered> all(static_cast<std::size_t>(to));
    for (std::int64_t k = 0; k < to; ++k) {
        // In units of 1/to samples: [k from, (k + 1) from), sample s being [s to, (s + 1) to).
        const std::int64_t begin = k * from, end = begin + from;
        Covered& one = all[static_cast<std::size_t>(k)];
        one.first = static_cast<int>(begin / to);
        for (std::int64_t s = one.first; s * to < end; ++s)
            one.shares.push_back(std::min(end, (s + 1) * to) - std::max(begin, s * to));
    }
    return all;
}

Image averaged(const PlaneView& plane, int width, int height) {
    const std::vector<Covered> columns = covered_samples(plane.width, width),
                               rows = covered_samples(plane.height, height);
    const std::int64_t whole = std::int64_t{plane.width} * plane.height;
    Image image{width, height, 1, plane.channels, {}};
    image.samples.reserve(columns.size() * rows.size() * static_cast<std::size_t>(plane.channels));
    for (const Covered& row : rows)
        for (const Covered& column : columns)
            for (int channel = 0; channel < plane.channels; ++channel) {
                std::int64_t sum = 0;
                for (std::size_t y = 0; y < row.shares.size(); ++y) {
                    const std::uint8_t* from =
                        plane.row(row.first + static_cast<int>(y)) + column.first * plane.channels + channel;
                    std::int64_t of_row = 0;
                    for (const std::int64_t share : column.shares) {
                        of_row += share * *from;
                        from += plane.channels;
                    }
                    sum += row.shares[y] * of_row;
                }
                image.samples.push_back(static_cast<std::uint8_t>((2 * sum + whole) / (2 * whole)));
            }
    return image;
}

}  // namespace

std::vector<int> nearest_samples(int from, int to) {
    std::vector<int> samples(static_cast<std::size_t>(to));
    for (int k = 0; k < to; ++k)
        samples[static_cast<std::size_t>(k)] =
            static_cast<int>((2 * std::int64_t{k} + 1) * from / (2 * std::int64_t{to}));
    return samples;
}

Scene resized_scene(Scene scene, int width, int height) {
    const Columns x = fitted_columns(scene.width, width), y = fitted_columns(scene.height, height);
    scene.camera.fx /= x.b;
    scene.camera.fy /= y.b;
    scene.camera.cx = (scene.camera.cx - x.a) / x.b;
    scene.camera.cy = (scene.camera.cy - y.a) / y.b;
    scene.width = width;
    scene.height = height;
    return scene;
}

RawFrame resized_frame(const RawFrame& frame, int width, int height) {
    RawFrame out;
    out.number = frame.number;
    out.time_ns = frame.time_ns;
    out.epoch = frame.epoch;
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(frame, role);
        if (plane.empty()) continue;
        add_plane(out, role,
                  plane_from(role == PlaneRole::colour ? averaged(plane, width, height)
                                                       : nearest(plane, width, height)));
    }
    return out;
}

}  // namespace touchable
