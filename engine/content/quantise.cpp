#include "engine/content/quantise.hpp"

#include <type_traits>

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

std::vector<double> sample_depths(const AnalyticScene& scene, double t, RowBands& rows) {
    const int width = scene.scene().width, height = scene.scene().height;
    std::vector<double> depths(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    rows.for_each_band(height, 1, [&](const RowBand& band) {
        double* out = &depths[static_cast<std::size_t>(band.first) * static_cast<std::size_t>(width)];
        for (int y = band.first; y < band.last; ++y, out += width) scene.row_depths(y, t, out);
    });
    return depths;
}

void quantise(const Scene& scene, const std::vector<double>& depths, RowBands& rows, FramePlanes& planes) {
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
