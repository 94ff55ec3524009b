// SPDX-License-Identifier: Apache-2.0
#include "bench/real/sensor_models.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "bench/touch/noisy_scene.hpp"
#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

/// Neighbouring depths that differ by more than this share form a silhouette.
constexpr double silhouette_share = 0.02;

bool is_silhouette(double a, double b) {
    return std::fabs(a - b) > silhouette_share * std::min(a, b);
}

/// Near a silhouette the depth of a random pixel nearby; elsewhere the pixel's own.
double seen_aside(const SensorModel& model, const DepthMap& truth, int x, int y, SplitMix64& random) {
    const double own = truth.at(x, y);
    const auto aside = [&] { return static_cast<int>(std::floor(model.lateral_px * normal(random) + 0.5)); };
    const int dx = aside(), dy = aside();
    const double other = truth.at(x + dx, y + dy);
    return is_silhouette(own, other) ? other : own;
}

/// At a silhouette sometimes a random depth between its sides; elsewhere `depth`.
double mixed(const SensorModel& model, const DepthMap& truth, int x, int y, double depth,
             SplitMix64& random) {
    double nearest = truth.at(x, y), farthest = nearest;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            nearest = std::min(nearest, truth.at(x + dx, y + dy));
            farthest = std::max(farthest, truth.at(x + dx, y + dy));
        }
    if (!is_silhouette(nearest, farthest) || random.unit() >= model.mixed_share) return depth;
    return random.within(nearest, farthest);
}

/// The level nearest to a depth.
double levelled(const SensorModel& model, double depth) {
    if (model.half_floats) {
        const double step = 1000 * std::exp2(std::ilogb(depth / 1000) - 10);
        return step * std::floor(depth / step + 0.5);
    }
    if (model.disparity_step == 0) return depth;
    return 1 / (model.disparity_step * std::max(1.0, std::floor(1 / depth / model.disparity_step + 0.5)));
}

/// Depth two levels nearer or farther, at random.
double two_levels_off(const SensorModel& model, double depth, SplitMix64& random) {
    const double off = 2 * model.disparity_step;
    return 1 / (1 / depth + (random.unit() < 0.5 ? off : -off));
}

/// The least depth within the reach of what bleeds, where that is a silhouette.
double bled(const SensorModel& model, const DepthMap& truth, int x, int y, double depth) {
    double nearest = depth;
    for (int dy = -model.bleed_px; dy <= model.bleed_px; ++dy)
        for (int dx = -model.bleed_px; dx <= model.bleed_px; ++dx)
            nearest = std::min(nearest, truth.at(x + dx, y + dy));
    return is_silhouette(nearest, depth) ? nearest : depth;
}

/// Means over `across` pixels, twice across and twice down, of numbers that are new for each `seed`, scaled
/// to variance 1.
std::vector<double> smooth_noise(int width, int height, int across, std::uint64_t seed) {
    SplitMix64 random(mix64(seed));
    std::vector<double> numbers(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (double& number : numbers) number = random.unit() - 0.5;
    const auto blur = [&](int lines, int length, std::size_t line_pitch, std::size_t pitch) {
        std::vector<double> line(static_cast<std::size_t>(length));
        for (int n = 0; n < lines; ++n) {
            double* const first = numbers.data() + static_cast<std::size_t>(n) * line_pitch;
            const auto at = [&](int k) {
                return first[static_cast<std::size_t>((k + length) % length) * pitch];
            };
            double sum = 0;
            for (int k = 0; k < across; ++k) sum += at(k);
            for (int k = 0; k < length; ++k) {
                line[static_cast<std::size_t>(k)] = sum;
                sum += at(k + across) - at(k);
            }
            for (int k = 0; k < length; ++k)
                first[static_cast<std::size_t>(k) * pitch] = line[static_cast<std::size_t>(k)];
        }
    };
    for (int twice = 0; twice < 2; ++twice) {
        blur(height, width, static_cast<std::size_t>(width), 1);
        blur(width, height, 1, static_cast<std::size_t>(width));
    }
    double squares = 0;
    for (const double number : numbers) squares += number * number;
    const double rms = std::sqrt(squares / static_cast<double>(numbers.size()));
    for (double& number : numbers) number /= rms;
    return numbers;
}

/// Noise to add before depths are rounded to levels: the published noise is that of stored depths, rounding
/// included.
double added_sigma(const SensorModel& model, double depth) {
    const double sigma = model.sigma(depth), level = model.level(depth);
    return std::sqrt(std::max(0.0, sigma * sigma - level * level / 12));
}

}  // namespace

double SensorModel::sigma(double depth) const {
    const double beyond = depth - axial_from;
    return axial_constant + axial_quadratic * beyond * beyond;
}

double SensorModel::level(double depth) const {
    return std::max(code_mm, disparity_step * depth * depth);
}

double SensorModel::least_step(double depth) const {
    const double rough = std::sqrt(12.0) * sigma(depth), one = level(depth);
    return one >= 0.75 * rough ? one : rough;
}

namespace {

/// Some of the faults of stereo, time of flight and structured light.
void add_faults(SensorModel& model, SplitMix64& random) {
    const auto sometimes = [&](double share) { return random.unit() < share; };
    if (sometimes(0.4)) model.correlated_px = static_cast<int>(random.within(3, 8));
    if (sometimes(0.3)) model.blotch = random.within(0.2, 0.6);
    if (sometimes(0.3)) model.multipath_mm = random.within(2, 8);
    if (sometimes(0.3)) model.bleed_px = static_cast<int>(random.within(1, 4));
    if (sometimes(0.5)) model.dropout_share = random.within(0.0002, 0.005);
    if (sometimes(0.3)) model.gain = random.within(0.001, 0.006);
    if (model.disparity_step == 0 && sometimes(0.3)) model.half_floats = true;
}

}  // namespace

SensorModel drawn_model(int number) {
    SplitMix64 random(mix64(0x5eed + static_cast<std::uint64_t>(number)));
    // Uniform on a logarithmic scale.
    const auto factor = [&](double least, double most) {
        double drawn = least;
        for (int n = 0; n < 6; ++n)
            if (const double wider = std::sqrt(most / least); random.unit() < 0.5) {
                drawn *= wider;
                least *= wider;
            } else {
                most = least * wider;
            }
        return drawn;
    };
    constexpr double codes[] = {0.1, 0.125, 0.2, 0.25, 0.5, 1, 1, 1};
    SensorModel model;
    model.name = "drawn" + std::to_string(number);
    model.far_mm = 20700;
    model.code_mm = codes[static_cast<std::size_t>(8 * random.unit())];
    if (model.code_mm * 65535 < model.far_mm) model.far_mm = model.code_mm * 65535;
    if (number % 2 == 0) model.disparity_step = factor(8e-7, 5e-6);
    model.axial_constant = factor(0.2, 2.5);
    model.axial_quadratic = factor(2e-7, 3e-6);
    model.lateral_px = random.unit();
    if (number % 3 == 0) model.mixed_share = 0.3;
    model.stray_share = 1e-5;
    model.stray_mm = std::min(19700.0, model.far_mm);
    if (number > 8) add_faults(model, random);
    model.stated_noise = {model.axial_constant, model.axial_quadratic};
    return model;
}

SensorModel depth_network(double code_mm) {
    SensorModel model;
    model.name = code_mm < 1 ? "network" : "coarse network";
    model.far_mm = 8000;
    model.code_mm = code_mm;
    model.wobble_mm = 3;
    return model;
}

SensorModel phone(double noise_mm) {
    SensorModel model = half_float_render();
    model.name = noise_mm > 0 ? "noisy phone" : "phone";
    model.axial_constant = noise_mm;
    model.every_px = 2;
    model.stated_noise = {noise_mm, 0};
    return model;
}

SensorModel kinect_v1() {
    SensorModel model;
    model.name = "kinect";
    model.far_mm = 4500;
    model.disparity_step = 2.95e-6;
    model.axial_constant = 1.2;
    model.axial_quadratic = 1.9e-6;
    model.axial_from = 400;
    model.lateral_px = 0.8;
    model.stated_noise = {0.6, 1.4e-6};  // fits to 0.5 mm from 0.5 to 3 m
    return model;
}

SensorModel kinect_with_lone_pixels() {
    SensorModel model = kinect_v1();
    model.name = "lone";
    model.lone_share = 0.003;
    return model;
}

SensorModel coarse_light() {
    SensorModel model;
    model.name = "coarse";
    model.far_mm = 4500;
    model.disparity_step = 20 / (1500.0 * 1500);
    model.axial_quadratic = 6 / (1500.0 * 1500);
    model.lateral_px = 0.8;
    model.stated_noise = {0, model.axial_quadratic};
    return model;
}

SensorModel azure_kinect() {
    SensorModel model;
    model.name = "azure";
    model.far_mm = 5000;
    model.axial_constant = 0.9;
    model.axial_quadratic = 3e-7;
    model.mixed_share = 0.3;
    model.stated_noise = {0.9, 3e-7};
    return model;
}

SensorModel half_float_render() {
    SensorModel model;
    model.name = "half";
    model.far_mm = 15900;
    model.code_mm = 1000.0 / 4096;  // step of a half float from 0.25 to 0.5 m
    model.half_floats = true;
    return model;
}

SensorModel d435(double focal_length) {
    constexpr double base = 50;
    SensorModel model;
    model.name = "d435";
    model.far_mm = 4000;
    model.disparity_step = 1 / (32 * base * focal_length);
    model.axial_quadratic = 0.08 / (base * focal_length);
    model.is_stereo = true;
    model.stated_noise = {0, model.axial_quadratic};
    return model;
}

SensorModel d435_by_windows(double focal_length, int pixels) {
    SensorModel model = d435(focal_length);
    model.name = "windows" + std::to_string(pixels);
    model.correlated_px = pixels;
    return model;
}

SensorModel sr300() {
    SensorModel model;
    model.name = "sr300";
    model.far_mm = 2000;
    model.code_mm = 0.125;
    model.axial_constant = 1;
    model.axial_quadratic = 1e-6;
    model.mixed_share = 0.3;
    model.stated_noise = {1, 1e-6};
    return model;
}

SensorModel without_noise(SensorModel model) {
    model.axial_constant = model.axial_quadratic = model.lateral_px = model.mixed_share = 0;
    model.stray_share = model.lone_share = model.dropout_share = model.gain = 0;
    model.blotch = model.multipath_mm = model.wobble_mm = 0;
    model.bleed_px = 0;
    return model;
}

Scene scene_of(const SensorModel& model, int width, int height, const Camera& camera) {
    Scene scene;
    scene.name = model.name;
    scene.width = width;
    scene.height = height;
    scene.camera = camera;
    scene.depth_bits = 16;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = model.code_mm;
    scene.depth.far = model.far_mm;
    scene.depth.code_max = 65535;
    derive_valid_range(scene.depth);
    scene.default_properties = {600, 0, 0};
    scene.filter.temporal_noise = model.stated_noise;
    scene.device_metres_per_unit = 0.001;
    return scene;
}

RawFrame stored_frame(const SensorModel& model, const Scene& scene, const DepthMap& truth,
                      std::int64_t number) {
    RawFrame raw;
    raw.number = number;
    raw.time_ns = scene.rate.time_ns(number);
    SplitMix64 random(mix64(static_cast<std::uint64_t>(number) + 1));
    const auto smooth = [&](double amount, int across, std::uint64_t seed) {
        return amount > 0 ? smooth_noise(scene.width, scene.height, across, seed) : std::vector<double>();
    };
    const auto frame = static_cast<std::uint64_t>(number);
    const std::vector<double> noise = model.correlated_px > 0
                                          ? smooth_noise(scene.width, scene.height,
                                                         (model.correlated_px + 1) / 2, 100 + frame)
                                          : shared_noise(scene.width, scene.height, random),
                              blotches = smooth(model.blotch, 8, 1),
                              multipath = smooth(model.multipath_mm, 48, 2),
                              wobble = smooth(model.wobble_mm, 32, 1000 + frame);
    const double gain = 1 + (model.gain > 0 ? random.within(-model.gain, model.gain) : 0);
    auto codes = std::make_shared<std::vector<std::uint16_t>>();
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            double depth = model.lateral_px > 0 ? seen_aside(model, truth, x, y, random) : truth.at(x, y);
            if (model.bleed_px > 0) depth = bled(model, truth, x, y, depth);
            const std::size_t place = codes->size();
            if (model.multipath_mm > 0) depth += model.multipath_mm * multipath[place];
            if (model.wobble_mm > 0) depth += model.wobble_mm * wobble[place];
            const double off = noise[place] + (model.blotch > 0 ? model.blotch * blotches[place] : 0);
            depth = gain * (depth + added_sigma(model, depth) * off);
            if (model.mixed_share > 0) depth = mixed(model, truth, x, y, depth, random);
            depth = levelled(model, std::max(depth, 1.0));
            if (model.lone_share > 0 && random.unit() < model.lone_share)
                depth = two_levels_off(model, depth, random);
            if (model.stray_share > 0 && random.unit() < model.stray_share) depth = model.stray_mm;
            if (model.dropout_share > 0 && random.unit() < model.dropout_share) depth = 0;
            codes->push_back(
                static_cast<std::uint16_t>(std::floor(std::min(depth / model.code_mm, 65534.0) + 0.5)));
        }
    // PlaneView holds bytes.
    raw.depth = {reinterpret_cast<const std::uint8_t*>(codes->data()),
                 std::ptrdiff_t{2} * scene.width,
                 scene.width,
                 scene.height,
                 2,
                 1};
    raw.storage = std::move(codes);
    return raw;
}

}  // namespace touchable
