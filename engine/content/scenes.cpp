// SPDX-License-Identifier: Apache-2.0
// Scenes by name, what their families share, and their frames.
#include "engine/content/scenes.hpp"

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/content/families.hpp"

namespace touchable {
namespace {

struct Family {
    std::string_view name;
    MadeScene (*make)(std::string_view, const SceneOptions&);
};

constexpr std::array families{
    Family{"globe", make_globe},        Family{"bumps", make_height_field},
    Family{"rough", make_height_field}, Family{"moving", make_height_field},
    Family{"plane", make_primitive},    Family{"spheres", make_primitive},
    Family{"step", make_primitive},     Family{"noise", make_noise},
    Family{"cliffs", make_noise},       Family{"grain", make_noise},
};

Error unknown(std::string_view name) {
    return usage_error("scene '" + std::string(name) + "' is not known; known are " +
                       listed(families, &Family::name));
}

Result<void> check(std::string_view name, const SceneOptions& options) {
    const auto refuse = [&](const std::string& what) { return refuse_scene(name, what); };
    if (options.width < 2 || options.width > 16384 || options.height < 2 || options.height > 16384)
        return refuse("size " + size_text(options.width, options.height) +
                      " is impossible; each side must be 2 to 16384 pixels");
    if (options.bits < 8 || options.bits > 16)
        return refuse("depth of " + std::to_string(options.bits) + " bits is impossible; it must be 8 to 16");
    if (options.properties && name != "globe")
        return refuse("only 'globe' has haptic properties and heights");
    if (options.maps && !options.properties) return refuse("maps are for a globe with properties");
    if (!(options.seconds_per_turn > 0)) return refuse("a turn must take longer than 0 seconds");
    const double tilt = options.axial_tilt_degrees.value_or(0);
    if (!(tilt >= -90 && tilt <= 90)) return refuse("the axis can tilt by -90 to 90 degrees");
    return {};
}

struct Preset {
    double focal_length, pixel_width;  // at 720 pixels
    double near, far;
    double globe_distance;
};

/// For CameraPreset a, a_prime and b.
constexpr Preset presets[] = {
    {6.983, 0.00123, 10, 200, 105}, {6.983, 0.0123, 10, 200, 105}, {4.7, 0.0112, 40, 180, 110}};

double pixel_width(const Preset& preset, int width) {
    return preset.pixel_width * 720.0 / width;
}

template <class Sample>
PlaneView plane(const std::vector<Sample>& samples, const Scene& scene, int channels) {
    if (samples.empty()) return {};
    return packed_plane(reinterpret_cast<const std::uint8_t*>(samples.data()), scene.width, scene.height,
                        sizeof(Sample), channels);
}

/// Analytic depths of a whole picture at time t, row-major, scene units.
std::vector<double> sample_depths(const AnalyticScene& scene, double t, RowBands& rows) {
    const int width = scene.scene().width, height = scene.scene().height;
    std::vector<double> depths(pixel_count(width, height));
    rows.for_each_band(height, 1, [&](const RowBand& band) {
        double* out = &depths[pixel_place(0, band.first, width)];
        for (int y = band.first; y < band.last; ++y, out += width) scene.row_depths(y, t, out);
    });
    return depths;
}

}  // namespace

std::shared_ptr<const AnalyticScene::Planes> AnalyticScene::planes(double t) const {
    auto made = std::make_shared<AnalyticScene::Planes>();
    RowBands rows(threads_for_pixels(threads_, std::int64_t{scene_.width} * scene_.height));
    const std::vector<double> depths = sample_depths(*this, t, rows);
    quantise(scene_, depths, rows, *made);
    paint(t, depths, rows, *made);
    return made;
}

RawFrame AnalyticScene::frame(std::int64_t n) const {
    if (moves()) return view_of(planes(time_of(n)), scene_, n);
    std::call_once(still_once_, [this] { still_ = planes(0); });
    return view_of(still_, scene_, n);
}

Error refuse_scene(std::string_view name, const std::string& what) {
    return usage_error("scene '" + std::string(name) + "': " + what);
}

int threads_for_pixels(int threads, std::int64_t pixels) {
    constexpr long least_pixels = 1 << 14;  // fewest that pay for starting a thread
    if (threads > 0) return threads;
    return threads_for(static_cast<long>(pixels), least_pixels, std::numeric_limits<int>::max());
}

Scene blank_scene(std::string_view name, const SceneOptions& options) {
    Scene scene;
    scene.name = name;
    scene.rate = options.rate;
    scene.width = options.width;
    scene.height = options.height;
    scene.depth_bits = options.bits;
    scene.depth.code_max = static_cast<std::uint16_t>((1 << options.bits) - 1);
    return scene;
}

Scene tabletop_scene(std::string_view name, const SceneOptions& options, double near, double far) {
    Scene scene = blank_scene(name, options);
    const double focal = (options.width - 1) * tabletop_distance / tabletop_width;
    scene.camera = {focal, focal, (options.width - 1) / 2.0, (options.height - 1) / 2.0};
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.near = near;
    scene.depth.far = far;
    derive_valid_range(scene.depth);
    scene.metres_per_unit = 0.001;
    scene.device_metres_per_unit = 0.001;
    scene.default_properties = {600, 0.6, 0.4};
    return scene;
}

std::vector<std::string_view> scene_names() {
    std::vector<std::string_view> names;
    for (const Family& family : families) names.push_back(family.name);
    return names;
}

Result<std::unique_ptr<AnalyticScene>> make_scene(std::string_view name, const SceneOptions& options) {
    const auto family = std::ranges::find(families, name, &Family::name);
    if (family == families.end()) return unknown(name);
    TRY(check(name, options));
    auto made = family->make(name, options);
    if (!made) return made;
    TRY(validate((*made)->scene()));
    (*made)->threads_ = options.threads;
    return made;
}

void apply_preset(CameraPreset preset, Scene& scene) {
    const Preset& p = presets[static_cast<std::size_t>(preset)];
    scene.camera =
        camera_from_focal_length(p.focal_length, pixel_width(p, scene.width), scene.width, scene.height);
    scene.depth.kind = DepthCodingKind::linear;
    scene.depth.semantics = DepthSemantics::range;
    scene.depth.near_is_high = true;
    scene.depth.near = p.near;
    scene.depth.far = p.far;
    derive_valid_range(scene.depth);
}

GlobeSphere globe_sphere(CameraPreset preset, int width, int height) {
    const Preset& p = presets[static_cast<std::size_t>(preset)];
    // R = D sin(atan(h)), h = 0.8 tan(VFOV/2) = 0.8 (H/2) / fy; sin(atan(h)) = h / sqrt(1 + h^2).
    const double h = 0.8 * (0.5 * height) * pixel_width(p, width) / p.focal_length;
    return {{0, 0, -p.globe_distance}, p.globe_distance * (h / std::sqrt(1.0 + h * h))};
}

void quantise(const Scene& scene, const std::vector<double>& depths, RowBands& rows,
              AnalyticScene::Planes& planes) {
    const auto fill = [&](auto& codes) {
        codes.resize(depths.size());
        const auto width = static_cast<std::size_t>(scene.width);
        rows.for_each_band(scene.height, 1, [&](const RowBand& band) {
            const std::size_t end = static_cast<std::size_t>(band.last) * width;
            for (std::size_t n = static_cast<std::size_t>(band.first) * width; n < end; ++n)
                codes[n] =
                    static_cast<std::remove_reference_t<decltype(codes[n])>>(scene.depth.code(depths[n]));
        });
    };
    if (scene.depth_bits == 8)
        fill(planes.depth8);
    else
        fill(planes.depth16);
}

RawFrame view_of(std::shared_ptr<const AnalyticScene::Planes> planes, const Scene& scene,
                 std::int64_t number) {
    RawFrame frame;
    frame.number = number;
    frame.time_ns = scene.rate.time_ns(number);
    frame.depth = planes->depth8.empty() ? plane(planes->depth16, scene, 1) : plane(planes->depth8, scene, 1);
    frame.colour = plane(planes->colour, scene, 3);
    frame.haptic = plane(planes->haptic, scene, 3);
    frame.height = plane(planes->height, scene, 1);
    frame.storage = std::move(planes);
    return frame;
}

}  // namespace touchable
