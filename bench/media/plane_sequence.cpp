#include "bench/media/plane_sequence.hpp"

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

#include "engine/base/same_bits.hpp"
#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"

namespace touchable {
namespace {

using Frames = Result<std::vector<RawFrame>>;

Frames frames_of_scene(const char* scene, const SceneOptions& options) {
    const auto made = make_scene(scene, options);
    if (!made) return made.error();
    std::vector<RawFrame> frames;
    for (int n = 0; n < frames_of_source; ++n) frames.push_back((*made)->frame(n));
    return frames;
}

/// A slope from the picture's upper left to its lower right, and noise of a triangular distribution.
template <class Sample>
RawFrame noisy_slope(int width, int height, int amplitude, std::uint64_t seed) {
    auto samples = std::make_shared<std::vector<Sample>>(static_cast<std::size_t>(width) *
                                                         static_cast<std::size_t>(height));
    SplitMix64 random(seed);
    const int span = (1 << 8 * sizeof(Sample)) - 1 - 2 * amplitude;
    auto sample = samples->begin();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double noise = random.within(-0.5, 0.5) + random.within(-0.5, 0.5);
            const double slope = static_cast<double>(span) * (x + y) / (width + height);
            *sample++ = static_cast<Sample>(amplitude + slope + amplitude * noise + 0.5);
        }
    RawFrame frame;
    constexpr int bytes = sizeof(Sample);
    frame.depth = {reinterpret_cast<const std::uint8_t*>(samples->data()),
                   std::ptrdiff_t{width} * bytes,
                   width,
                   height,
                   bytes,
                   1};
    frame.storage = std::move(samples);
    return frame;
}

Frames noisy_slopes(int width, int height, int bits) {
    std::vector<RawFrame> frames;
    for (std::uint64_t n = 0; n < frames_of_source; ++n)
        frames.push_back(bits > 8 ? noisy_slope<std::uint16_t>(width, height, 16, n)
                                  : noisy_slope<std::uint8_t>(width, height, 1, n));
    return frames;
}

Frames frames_of_recording(const std::filesystem::path& folder, const std::filesystem::path& scene_file) {
    const auto reader = open_clip(folder, scene_file);
    if (!reader) return reader.error();
    (*reader)->leave_out_colour();
    std::vector<RawFrame> frames;
    while (std::ssize(frames) < frames_of_source) {
        auto raw = (*reader)->next();
        if (!raw) return raw.error();
        if (!*raw) break;
        frames.push_back(std::move(**raw));
    }
    if (frames.empty()) return input_error(folder.string() + ": holds no frame");
    return frames;
}

/// Cameras' depth: in units of 0.125 mm (castel), in millimetres (cube), and in millimetres with only a few
/// distinct values (redwood).
void add_recordings(std::vector<PictureSource>& sources) {
    struct Recording {
        const char *name, *folder, *scene;
    };
    for (const auto& [name, folder, scene] : {Recording{"castel", "castel_sr300", "castel_sr300"},
                                              Recording{"cube", "visp_cube_realsense", "visp_cube_realsense"},
                                              Recording{"redwood", "stills/redwood5", "redwood5"}}) {
        const std::filesystem::path pictures = std::filesystem::path(TOUCHABLE_TEST_DATA) / folder;
        const std::filesystem::path scene_file =
            std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes" / (std::string(scene) + ".json");
        if (std::filesystem::exists(pictures))
            sources.push_back({std::string(name) + "-640x480-16", {PlaneRole::depth}, [=] {
                                   return frames_of_recording(pictures, scene_file);
                               }});
        else
            std::fprintf(stderr, "cases %s-... are left out: no recording at %s\n", name, pictures.c_str());
    }
}

}  // namespace

std::vector<PictureSource> picture_sources(bool quick) {
    const int width = quick ? 720 : 1920, height = quick ? 480 : 1080;
    const std::string size = "-" + std::to_string(width) + "x" + std::to_string(height);
    std::vector<PictureSource> sources;
    for (const int bits : {16, 8}) {
        const std::string what = size + "-" + std::to_string(bits);
        const auto scene = [=](const char* name, bool properties) {
            return [=] {
                return frames_of_scene(
                    name, {.width = width, .height = height, .bits = bits, .properties = properties});
            };
        };
        std::vector<PlaneRole> planes{PlaneRole::depth};
        if (bits == 16) planes.assign(all_roles.begin(), all_roles.end());
        sources.push_back({"globe" + what, std::move(planes), scene("globe", true)});
        sources.push_back({"moving" + what, {PlaneRole::depth}, scene("moving", false)});
        sources.push_back(
            {"noise" + what, {PlaneRole::depth}, [=] { return noisy_slopes(width, height, bits); }});
    }
    add_recordings(sources);
    return sources;
}

std::vector<PlaneView> planes_of(const std::vector<RawFrame>& frames, PlaneRole role) {
    std::vector<PlaneView> planes;
    for (const RawFrame& frame : frames) planes.push_back(plane_of(frame, role));
    return planes;
}

}  // namespace touchable
