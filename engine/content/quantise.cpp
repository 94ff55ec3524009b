#include "engine/content/quantise.hpp"

namespace touchable {
namespace {

PlaneView plane(const void* data, bool present, const Scene& scene, int bytes_per_sample, int channels) {
    if (!present) return {};
    PlaneView view;
    view.data = static_cast<const std::uint8_t*>(data);
    view.width = scene.width;
    view.height = scene.height;
    view.bytes_per_sample = bytes_per_sample;
    view.channels = channels;
    view.stride = static_cast<std::ptrdiff_t>(scene.width) * bytes_per_sample * channels;
    return view;
}

}  // namespace

std::vector<double> sample_depths(const AnalyticScene& scene, double t) {
    const int width = scene.scene().width, height = scene.scene().height;
    std::vector<double> depths;
    depths.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) depths.push_back(scene.depth(x, y, t));
    return depths;
}

void quantise(const Scene& scene, const std::vector<double>& depths, FramePlanes& planes) {
    if (scene.depth_bits == 8) {
        planes.depth8.reserve(depths.size());
        for (const double depth : depths)
            planes.depth8.push_back(static_cast<std::uint8_t>(scene.depth.code(depth)));
    } else {
        planes.depth16.reserve(depths.size());
        for (const double depth : depths) planes.depth16.push_back(scene.depth.code(depth));
    }
}

RawFrame view_of(std::shared_ptr<const FramePlanes> planes, const Scene& scene, std::int64_t number) {
    RawFrame frame;
    frame.number = number;
    frame.time_ns = scene.rate.time_ns(number);
    frame.depth = planes->depth8.empty()
                      ? plane(planes->depth16.data(), !planes->depth16.empty(), scene, 2, 1)
                      : plane(planes->depth8.data(), true, scene, 1, 1);
    frame.colour = plane(planes->colour.data(), !planes->colour.empty(), scene, 1, 3);
    frame.haptic = plane(planes->haptic.data(), !planes->haptic.empty(), scene, 1, 3);
    frame.height = plane(planes->height.data(), !planes->height.empty(), scene, 1, 1);
    frame.storage = std::move(planes);
    return frame;
}

}  // namespace touchable
