// SPDX-License-Identifier: Apache-2.0
#include "tests/surface/pictures.hpp"

#include <algorithm>
#include <cstring>

#include "engine/surface/surface_builder.hpp"
#include "tests/must.hpp"

namespace touchable::test {
namespace {

std::vector<std::uint16_t> valid_codes(const Scene& scene) {
    std::vector<std::uint16_t> codes;
    for (int code = 0; code < 1 << scene.depth_bits; ++code)
        if (scene.depth.is_valid(static_cast<std::uint16_t>(code)))
            codes.push_back(static_cast<std::uint16_t>(code));
    return codes;
}

/// Some stored value that is not valid; a valid one where every value is.
std::uint16_t invalid_value(const Scene& scene, Random& random) {
    for (int attempt = 0; attempt < 8; ++attempt) {
        const auto value = static_cast<std::uint16_t>(random.below(1 << scene.depth_bits));
        if (!scene.depth.is_valid(value)) return value;
    }
    if (scene.depth_bits > 8 && scene.depth_bits < 16) return 65535;  // garbage above the largest code
    return scene.depth.invalid_code_count > 0 ? scene.depth.invalid_codes[0] : scene.depth.valid_max;
}

std::string at(int x, int y) {
    return " at (" + std::to_string(x) + ", " + std::to_string(y) + ")";
}

std::string pixel_text(const SurfaceFrame& frame, int x, int y) {
    return std::to_string(frame.codes[frame.index(x, y)]) + (frame.is_valid(x, y) ? "" : " invalid");
}

std::string tile_text(const TileBounds& tile) {
    return std::to_string(tile.least) + ".." + std::to_string(tile.greatest) +
           (tile.any_invalid ? " with holes" : "");
}

}  // namespace

StoredPlane store_plane(int width, int height, const std::vector<std::uint16_t>& values,
                        const Layout& layout) {
    const std::size_t bytes = static_cast<std::size_t>(layout.bytes_per_sample);
    const std::size_t stride =
        static_cast<std::size_t>(width) * bytes + static_cast<std::size_t>(layout.padding);
    StoredPlane plane;
    plane.memory.assign(stride * static_cast<std::size_t>(height), 0xA5);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int row = layout.bottom_up ? height - 1 - y : y;
            const std::uint16_t value = values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                               static_cast<std::size_t>(x)];
            std::uint8_t* to = plane.memory.data() + stride * static_cast<std::size_t>(row) +
                               bytes * static_cast<std::size_t>(x);
            if (bytes == 1)
                *to = static_cast<std::uint8_t>(value);
            else
                std::memcpy(to, &value, 2);
        }
    const auto signed_stride = static_cast<std::ptrdiff_t>(stride);
    plane.view = {plane.memory.data(), signed_stride, width, height, layout.bytes_per_sample, 1};
    if (layout.bottom_up) {
        plane.view.data += signed_stride * (height - 1);
        plane.view.stride = -signed_stride;
    }
    return plane;
}

Scene depth_scene(int width, int height, int bits, Marking marking, FilterSettings filter) {
    Scene scene;
    scene.width = width;
    scene.height = height;
    scene.depth_bits = bits;
    scene.filter = filter;
    scene.camera = {width / 2.0, width / 2.0, width / 2.0, height / 2.0};
    DepthCoding& depth = scene.depth;
    depth.code_max = static_cast<std::uint16_t>((1 << bits) - 1);
    depth.near = 500;
    depth.far = 1500;
    switch (marking) {
        case Marking::zero:
            depth.invalid_codes = {0};
            depth.invalid_code_count = 1;
            break;
        case Marking::range_and_few:
            depth.kind = DepthCodingKind::metric;
            depth.scale = 1;
            depth.near = depth.code_max / 8;
            depth.far = depth.code_max - depth.code_max / 16;
            depth.invalid_codes = {static_cast<std::uint16_t>(depth.code_max / 3),
                                   static_cast<std::uint16_t>(depth.code_max / 2),
                                   static_cast<std::uint16_t>(depth.code_max / 2 + 1), 0};
            depth.invalid_code_count = 4;
            break;
        case Marking::largest:
            depth.kind = DepthCodingKind::log;
            depth.shift = -200;
            depth.near_is_high = false;
            depth.invalid_codes = {depth.code_max};
            depth.invalid_code_count = 1;
            break;
        case Marking::none:
            break;
    }
    derive_valid_range(depth);
    return scene;
}

Scene metric_scene(int width, int height, const Camera& camera, double far, double scale) {
    Scene scene;
    scene.width = width;
    scene.height = height;
    scene.camera = camera;
    scene.depth_bits = 16;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = scale;
    scene.depth.far = far;
    scene.depth.code_max = 65535;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    return scene;
}

std::vector<std::uint16_t> fill_picture(const Scene& scene, Fill fill, Random& random) {
    const int width = scene.width, height = scene.height;
    const std::vector<std::uint16_t> codes = valid_codes(scene);
    const auto count = static_cast<int>(codes.size());
    const auto any_valid = [&] { return codes[static_cast<std::size_t>(random.below(count))]; };
    const auto share = [&](int percent) { return random.below(100) < percent; };
    const int special_x = random.below(width), special_y = random.below(height);
    const int period = 2 + random.below(4);

    std::vector<std::uint16_t> values;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool special = x == special_x && y == special_y;
            const bool border = x == 0 || y == 0 || x == width - 1 || y == height - 1;
            const int dx = x - special_x, dy = y - special_y;
            std::uint16_t code = any_valid();
            bool hole = false;
            switch (fill) {
                case Fill::all_least:
                    code = codes.front();
                    break;
                case Fill::all_greatest:
                    code = codes.back();
                    break;
                case Fill::random:
                    break;
                case Fill::extremes:
                    code = share(50) ? codes.front() : codes.back();
                    break;
                case Fill::few_values:
                    code = codes[static_cast<std::size_t>(random.below(3) * (count - 1) / 2)];
                    hole = share(20);
                    break;
                case Fill::ramp:
                    code = codes[static_cast<std::size_t>((x * 3 + y * 5) % count)];
                    break;
                case Fill::stripes:
                    hole = x % period == 0;
                    break;
                case Fill::rows:
                    hole = y % period == 0;
                    break;
                case Fill::checkerboard:
                    hole = (x + y) % 2 == 0;
                    break;
                case Fill::all_invalid:
                    hole = true;
                    break;
                case Fill::single_valid:
                    hole = !special;
                    break;
                case Fill::single_invalid:
                    hole = special;
                    break;
                case Fill::invalid_border:
                    hole = border;
                    break;
                case Fill::few_holes:
                    hole = share(4);
                    break;
                case Fill::half_holes:
                    hole = share(50);
                    break;
                case Fill::many_holes:
                    hole = share(85);
                    break;
                case Fill::blob:
                    code = codes[static_cast<std::size_t>((x * 3 + y * 5 + random.below(7)) % count)];
                    hole = 16 * (dx * dx + dy * dy) < width * width + height * height;
                    break;
                case Fill::silhouettes:
                    if (!share(12))
                        code = codes[static_cast<std::size_t>((x / 7 * 5 + y / 6 * 3) % 4) * (count - 1) / 3];
                    hole = share(1);
                    break;
                case Fill::slanted_edges: {
                    const auto at_most = static_cast<int>(count) - 1, wide = 1 + y / 3 % 15;
                    const int along = std::clamp(x % 24 - 4, 0, wide + 1);
                    const int way = x / 24 % 2 == 0 ? along : wide + 1 - along;
                    code = codes[static_cast<std::size_t>(at_most / 8 + at_most * 3 / 4 * way / (wide + 1))];
                    hole = share(1);
                    break;
                }
            }
            values.push_back(hole ? invalid_value(scene, random) : code);
        }
    return values;
}

StoredPlane noisy_plane(const Scene& scene, Fill fill, std::uint64_t seed) {
    Random random(seed);
    return store_plane(scene.width, scene.height, fill_picture(scene, fill, random), {});
}

std::string first_difference(const SurfaceFrame& expected, const SurfaceFrame& actual) {
    if (expected.width != actual.width || expected.height != actual.height) return "sizes differ";
    if (expected.coding != actual.coding) return "codings differ";
    if (expected.codes.size() != actual.codes.size() || expected.validity.size() != actual.validity.size() ||
        expected.tiles.size() != actual.tiles.size())
        return "amounts of codes, validity words or tiles differ";
    for (int y = 0; y < expected.height; ++y)
        for (int x = 0; x < expected.width; ++x)
            if (expected.codes[expected.index(x, y)] != actual.codes[actual.index(x, y)] ||
                expected.is_valid(x, y) != actual.is_valid(x, y))
                return "expected " + pixel_text(expected, x, y) + ", got " + pixel_text(actual, x, y) +
                       at(x, y);
    if (expected.validity != actual.validity) return "validity bits beyond the width differ";
    const TileGrid grid = TileGrid::of(expected.width, expected.height);
    for (std::size_t n = 0; n < expected.tiles.size(); ++n)
        if (!(expected.tiles[n] == actual.tiles[n]))
            return "expected bounds " + tile_text(expected.tiles[n]) + ", got " + tile_text(actual.tiles[n]) +
                   " in tile" + at(static_cast<int>(n) % grid.tiles_x, static_cast<int>(n) / grid.tiles_x);
    return {};
}

std::string reference_difference(const Scene& scene, const RawFrame& raw, const SurfaceFrame& actual) {
    SurfaceFrame reference;
    must(make_reference_builder(scene)->build(raw, reference));
    return first_difference(reference, actual);
}

std::string first_vertex_difference(const SurfaceFrame& expected, const VertexSource& actual) {
    for (int y = 0; y < expected.height; ++y)
        for (int x = 0; x < expected.width; ++x) {
            const DepthSample sample = actual.at(x, y);
            const bool valid = expected.is_valid(x, y);
            if (sample.valid != valid)
                return "expected a " + std::string(valid ? "valid" : "invalid") + " pixel" + at(x, y);
            const double depth = valid ? expected.coding.depth(expected.codes[expected.index(x, y)]) : 0;
            if (valid && sample.depth != depth)
                return "expected depth " + std::to_string(depth) + ", got " + std::to_string(sample.depth) +
                       at(x, y);
        }
    return {};
}

std::string first_tile_not_enclosed(const SurfaceFrame& expected, const VertexSource& actual) {
    const TileGrid grid = TileGrid::of(expected.width, expected.height);
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) {
            const TileDepths bounds = actual.tile(tx, ty);
            for (int y = 16 * ty; y <= std::min(16 * ty + 16, expected.height - 1); ++y)
                for (int x = 16 * tx; x <= std::min(16 * tx + 16, expected.width - 1); ++x) {
                    if (!expected.is_valid(x, y)) {
                        if (!bounds.any_invalid) return "an invalid pixel is not foreseen" + at(x, y);
                        continue;
                    }
                    const double depth = expected.coding.depth(expected.codes[expected.index(x, y)]);
                    if (depth < bounds.nearest || depth > bounds.farthest)
                        return "a depth beyond its tile's bounds" + at(x, y);
                }
        }
    return {};
}

}  // namespace touchable::test
