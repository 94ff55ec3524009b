// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/start_up.hpp"

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "bench/clocks.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/gpu/vulkan_builder.hpp"

namespace touchable {
namespace {

/// A fresh folder for compiled shaders of this engine and Mesa, as long as this exists. No other thread may
/// read the environment while it is constructed or destroyed.
class ShaderCache {
public:
    ShaderCache() {
        if (const char* before = std::getenv(variable)) before_ = before;
        std::string name = (std::filesystem::temp_directory_path() / "touchable-bench-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) return;
        folder_ = name;
        setenv(variable, name.c_str(), 1);
    }
    ~ShaderCache() {
        if (folder_.empty()) return;
        before_ ? setenv(variable, before_->c_str(), 1) : unsetenv(variable);
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    ShaderCache(const ShaderCache&) = delete;
    ShaderCache& operator=(const ShaderCache&) = delete;
    const std::filesystem::path& folder() const { return folder_; }

private:
    static constexpr const char* variable = "MESA_SHADER_CACHE_DIR";
    std::optional<std::string> before_;
    std::filesystem::path folder_;
};

struct StartUp {
    double surface_ms = 0, frame_ms = 0;  // with and without the opening of the device
};

Result<StartUp> first_surface(const Picture& picture, const std::filesystem::path& cache) {
    SurfaceFrame frame;
    const auto ms_since = [](std::int64_t begin) {
        return 1e-6 * static_cast<double>(monotonic_ns() - begin);
    };
    const std::int64_t begin = monotonic_ns();
    GpuOptions options;
    options.cache_folder = cache;
    auto device = GpuDevice::open(options);
    if (!device) return device.error();
    const std::int64_t opened = monotonic_ns();
    auto builder = make_vulkan_builder(picture.scene, *device);
    if (!builder) return builder.error();
    if (auto built = (*builder)->build(picture.raw, frame); !built) return built.error();
    return StartUp{ms_since(begin), ms_since(opened)};
}

}  // namespace

Result<void> measure_start_up(Figures& figures) {
    Picture picture({1920, 1080, 16});
    const ShaderCache cache;
    if (cache.folder().empty())
        return input_error("no folder for compiled shaders can be made; $TMPDIR says where");
    double cold_ms = 0;
    for (const char* state : {"_cold", ""})
        for (const int median : {3, 5}) {
            picture.scene.filter.median = median;
            const auto took = first_surface(picture, cache.folder());
            if (!took) return took.error();
            const std::string which = std::string(median == 5 ? "5" : "") + state + "_ms";
            figures.push_back({"first_surface" + which, took->surface_ms, "ms"});
            figures.push_back({"first_frame" + which, took->frame_ms, "ms"});
            if (median != 3) continue;
            if (cold_ms > 0) figures.push_back({"first_surface_vs_cold", took->surface_ms / cold_ms, ""});
            cold_ms = took->surface_ms;
        }
    return {};
}

}  // namespace touchable
