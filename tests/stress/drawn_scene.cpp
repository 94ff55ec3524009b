// SPDX-License-Identifier: Apache-2.0
#include "tests/stress/drawn_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "engine/base/same_bits.hpp"

namespace touchable::stress {

namespace {

Camera draw_camera(SplitMix64& random, int width, int height) {
    // From 90 degrees across to 7, as the paper's Fig. 13 was printed.
    const double focal = width * (chance(random, 0.5) ? random.within(0.5, 1.5) : random.within(1.5, 8.0));
    Camera camera{focal, focal, width / 2.0, height / 2.0 - 1.0};
    if (chance(random, 0.3)) camera.fy *= random.within(0.7, 1.4);
    if (chance(random, 0.3)) {
        camera.cx += random.within(-0.4, 0.4) * width;
        camera.cy += random.within(-0.4, 0.4) * height;
    }
    return camera;
}

void draw_heights(SplitMix64& random, Scene& scene) {
    const bool linear = scene.depth.kind == DepthCodingKind::linear;
    scene.height_coding.units = linear && chance(random, 0.5) ? HeightUnits::levels : HeightUnits::world;
    scene.height_coding.code_max = chance(random, 0.5) ? 255 : 1023;
    const double nearest = nearest_depth(scene);
    // Half of the nearest depth is left, and a millionth of the deepest.
    const double possible = std::min(0.5 * nearest, (1 - 1e-9) * nearest - 1e-6 * scene.depth.far);
    const double longest =
        std::max(0.0, std::min(possible, 0.3 * (scene.depth.far - nearest))) * random.unit();
    const bool levels = scene.height_coding.units == HeightUnits::levels;
    scene.height_coding.max_height = levels ? longest / scene.depth.level() : longest;
}

void draw_touch(SplitMix64& random, Scene& scene) {
    scene.device_metres_per_unit = 0.001;
    scene.default_properties = {random.within(100, 3000), 0, 0};
    if (chance(random, 0.5)) {
        scene.default_properties.static_friction = random.within(0.05, 1.2);
        scene.default_properties.dynamic_friction =
            scene.default_properties.static_friction * random.within(0.5, 1.0);
    }
    scene.haptic.stiffness = {0.1, random.within(0.5, 10.0)};
    const double most = chance(random, 0.5) ? 1.0 : 0.0;
    scene.haptic.static_friction = {0, most};
    scene.haptic.dynamic_friction = {0, 0.8 * most};
}

[[noreturn]] void impossible(const Error& error) {
    std::cerr << "a drawn scene is refused: " << error.message << '\n';
    std::abort();
}

/// A position folded back between two walls that it has passed by less than their distance.
double fold(double position, double low, double high) {
    if (position < low) position = 2 * low - position;
    if (position > high) position = 2 * high - position;
    return std::clamp(position, low, high);
}

}  // namespace

void set_planes(Scene& scene, DepthCodingKind kind, double near, double far, int bits) {
    DepthCoding& coding = scene.depth;
    scene.depth_bits = bits;
    coding.kind = kind;
    coding.near = near;
    coding.far = far;
    coding.code_max = static_cast<std::uint16_t>((1 << bits) - 1);
    coding.scale = kind == DepthCodingKind::metric ? 1.1 * far / coding.code_max : 0;
    derive_valid_range(coding);
}

Scene draw_scene(SplitMix64& random, int most_pixels) {
    static constexpr std::array<std::array<double, 2>, 5> planes{
        {{40, 180}, {10, 200}, {980, 1020}, {960, 1040}, {5, 2000}}};
    static constexpr std::array bit_depths{8, 8, 10, 12, 16, 16};
    static constexpr std::array kinds{DepthCodingKind::linear, DepthCodingKind::linear,
                                      DepthCodingKind::inverse, DepthCodingKind::metric};
    Scene scene;
    scene.width = 8 + below(random, most_pixels - 7);
    scene.height = 8 + below(random, most_pixels - 7);
    scene.camera = draw_camera(random, scene.width, scene.height);
    const auto& [near, far] = planes[static_cast<std::size_t>(below(random, planes.size()))];
    const DepthCodingKind kind = kinds[static_cast<std::size_t>(below(random, kinds.size()))];
    const int bits = bit_depths[static_cast<std::size_t>(below(random, bit_depths.size()))];
    scene.depth.semantics = chance(random, 0.5) ? DepthSemantics::range : DepthSemantics::planar;
    scene.depth.near_is_high = kind == DepthCodingKind::metric || chance(random, 0.7);
    set_planes(scene, kind, near, far, bits);
    if (chance(random, 0.4)) {
        // In the middle, at either end, or beside it.
        const int low = scene.depth.valid_min, high = scene.depth.valid_max;
        const std::array codes{low + (high - low) / 3, low, high, high};
        const int which = (scene.width + scene.height) % 4;
        scene.depth.invalid_codes[0] = static_cast<std::uint16_t>(codes[static_cast<std::size_t>(which)]);
        scene.depth.invalid_codes[1] = static_cast<std::uint16_t>(high - 1);
        scene.depth.invalid_code_count = which == 3 ? 2 : 1;
        derive_valid_range(scene.depth);
        // By what is drawn already: the other scenes stay as they are.
        if (scene.width % 2 == 0) scene.hole_stiffness = 0.1 * (scene.height % 5);
    }
    if (chance(random, 0.4)) draw_heights(random, scene);
    draw_touch(random, scene);
    if (chance(random, 0.2)) scene.filter.median = chance(random, 0.5) ? 3 : 5;
    if (chance(random, 0.2)) scene.filter.fill_holes = 1 + below(random, 3);
    scene.interpolation = chance(random, 0.75) ? FrameInterpolation::linear : FrameInterpolation::hold;
    if (const auto valid = validate(scene); !valid) impossible(valid.error());
    return scene;
}

double magnitude(SplitMix64& random, double least, int digits) {
    double value = least * random.within(1, 10);
    for (int n = below(random, digits); n > 0; --n) value *= 10;
    return value;
}

void draw_wide_planes(SplitMix64& random, Scene& scene) {
    scene.height_coding.max_height = 0;
    scene.depth.invalid_code_count = 0;
    scene.depth.near_is_high = true;
    const double far = magnitude(random, 1e-3, 15), near = far / magnitude(random, 1, 6);
    const auto kind = chance(random, 0.5) ? DepthCodingKind::linear : DepthCodingKind::inverse;
    set_planes(scene, kind, std::max(near, 1e-12), far, 16);
    scene.device_metres_per_unit = std::max(1e-12, 0.18 / far);
    if (chance(random, 0.3)) draw_heights(random, scene);
    if (const auto valid = validate(scene); !valid) impossible(valid.error());
}

Scene whole_unit_scene(int side, double near, double far) {
    Scene scene;
    scene.width = scene.height = side;
    const double focal = side - 1;
    scene.camera = {focal, focal, focal / 2, focal / 2};
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.near = near;
    scene.depth.far = far;
    scene.depth.scale = 1;
    scene.depth_bits = 10;
    scene.depth.code_max = 1023;
    derive_valid_range(scene.depth);
    scene.device_metres_per_unit = 0.001;
    scene.default_properties = {1000, 0, 0};
    return scene;
}

double nearest_depth(const Scene& scene) {
    return scene.depth.nearest_depth();
}

std::uint16_t draw_code(const Scene& scene, SplitMix64& random) {
    const DepthCoding& coding = scene.depth;
    while (true) {
        const int code = coding.valid_min + below(random, coding.valid_max - coding.valid_min + 1);
        if (coding.is_valid(static_cast<std::uint16_t>(code))) return static_cast<std::uint16_t>(code);
    }
}

void add_planes(const Scene& scene, SplitMix64& random, DrawnPlanes& planes) {
    const std::size_t pixels = planes.codes.size();
    if (scene.depth.invalid_code_count > 0)
        for (int blob = 0; blob < 4; ++blob) {
            const int side = 1 + below(random, 5);
            const int left = below(random, scene.width), top = below(random, scene.height);
            for (int y = top; y < std::min(top + side, scene.height); ++y)
                for (int x = left; x < std::min(left + side, scene.width); ++x)
                    planes.codes[static_cast<std::size_t>(y * scene.width + x)] =
                        scene.depth.invalid_codes[0];
        }
    if (scene.height_coding.max_height > 0) {
        planes.heights.resize(pixels);
        for (std::uint16_t& height : planes.heights)
            height = static_cast<std::uint16_t>(below(random, scene.height_coding.code_max + 1));
    }
    if (chance(random, 0.4)) {
        planes.haptic.resize(3 * pixels);
        for (std::uint8_t& byte : planes.haptic) byte = static_cast<std::uint8_t>(below(random, 256));
    }
}

DrawnPlanes draw_noise(const Scene& scene, SplitMix64& random) {
    DrawnPlanes planes;
    planes.codes.resize(static_cast<std::size_t>(scene.width * scene.height));
    for (std::uint16_t& code : planes.codes) code = draw_code(scene, random);
    add_planes(scene, random, planes);
    return planes;
}

DrawnPlanes draw_waves(const Scene& scene, SplitMix64& random) {
    struct Wave {
        double by_x, by_y, phase, height;
    };
    std::array<Wave, 3> waves;
    const double near = nearest_depth(scene), far = scene.depth.far;
    // No steeper than the camera sees well: a wave's height goes with its length in the picture.
    for (Wave& wave : waves) {
        const double length = random.within(6, 40), turn = random.within(0, 2 * pi);
        wave = {cosine(turn) / length, sine(turn) / length, random.within(0, 2 * pi),
                random.within(0.02, 0.12)};
    }
    DrawnPlanes planes = shaped(scene, [&](int x, int y) {
        double share = 0.5;
        for (const Wave& wave : waves)
            share += wave.height * sine(2 * pi * (wave.by_x * x + wave.by_y * y) + wave.phase);
        return near + (far - near) * share;
    });
    add_planes(scene, random, planes);
    return planes;
}

DrawnPlanes draw_any(const Scene& scene, SplitMix64& random) {
    return chance(random, 0.5) ? draw_noise(scene, random) : draw_waves(scene, random);
}

Result<void> FrameMaker::build(const DrawnPlanes& planes, int width, int height, SurfaceFrame& out) {
    auto storage = std::make_shared<const DrawnPlanes>(planes);
    auto wide = [&](const std::vector<std::uint16_t>& samples) {
        PlaneView view;
        view.data = reinterpret_cast<const std::uint8_t*>(samples.data());
        view.width = width;
        view.height = height;
        view.bytes_per_sample = 2;
        view.stride = std::ptrdiff_t{width} * 2;
        return view;
    };
    RawFrame raw;
    raw.storage = storage;
    raw.depth = wide(storage->codes);
    if (!storage->heights.empty()) raw.height = wide(storage->heights);
    if (!storage->haptic.empty()) {
        raw.haptic.data = storage->haptic.data();
        raw.haptic.width = width;
        raw.haptic.height = height;
        raw.haptic.channels = 3;
        raw.haptic.stride = std::ptrdiff_t{width} * 3;
    }
    return builder_->build(raw, out);
}

void FrameMaker::build(const DrawnPlanes& planes, SurfaceFrame& out) {
    if (auto built = build(planes, scene_.width, scene_.height, out); !built) impossible(built.error());
}

Walk::Walk(const Scene& scene, std::uint64_t seed, const Reach& reach)
    : camera_(scene.camera),
      low_(-2, -2, 0.9 * nearest_depth(scene)),
      high_(scene.width + 1, scene.height + 1, 1.05 * scene.depth.far),
      reach_(reach.pixels, reach.pixels, reach.depth * (high_.z - low_.z)),
      jumps_(reach.jumps),
      random_(seed) {
    jump();
}

void Walk::jump() {
    for (int axis = 0; axis < 3; ++axis) at_[axis] = random_.within(low_[axis], high_[axis]);
}

glm::dvec3 Walk::next() {
    if (random_.unit() < jumps_)
        jump();
    else
        for (int axis = 0; axis < 3; ++axis)
            at_[axis] =
                fold(at_[axis] + random_.within(-reach_[axis], reach_[axis]), low_[axis], high_[axis]);
    return unproject(camera_, at_.x, at_.y, at_.z);
}

Skim::Skim(const Scene& scene, std::uint64_t seed, const Pace& pace)
    : scene_(scene), pace_(pace), random_(seed), depth_(scene.depth.far) {
    x_ = random_.within(0, scene.width - 1);
    y_ = random_.within(0, scene.height - 1);
    heading_ = random_.within(0, 2 * pi);
}

glm::dvec3 Skim::next(const SurfaceFrame& frame) {
    const double w = scene_.width - 1, h = scene_.height - 1;
    heading_ += random_.within(-0.1, 0.1);
    const double dx = pace_.pixels * cosine(heading_), dy = pace_.pixels * sine(heading_);
    if (x_ + dx < 0 || x_ + dx > w) heading_ = pi - heading_;
    if (y_ + dy < 0 || y_ + dy > h) heading_ = -heading_;
    x_ = fold(x_ + dx, 0, w);
    y_ = fold(y_ + dy, 0, h);

    const DepthSample under =
        frame.vertices->at(static_cast<int>(std::floor(x_ + 0.5)), static_cast<int>(std::floor(y_ + 0.5)));
    if (under.valid) depth_ = under.depth;
    const double phase = 2 * pi * (static_cast<double>(tick_++) / pace_.period);
    const double pressed = pace_.under * (scene_.depth.far - scene_.depth.near) * (0.7 + sine(phase));
    const double depth = std::max(0.01 * depth_, depth_ + pressed);
    return unproject(scene_.camera, x_, y_,
                     planar_depth(scene_.camera, scene_.depth.semantics, x_, y_, depth));
}

}  // namespace touchable::stress
