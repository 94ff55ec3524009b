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

/// A fresh folder that Mesa keeps compiled shaders in while this lives. No other thread may read the
/// environment when it begins and ends.
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
    bool is_there() const { return !folder_.empty(); }

private:
    static constexpr const char* variable = "MESA_SHADER_CACHE_DIR";
    std::optional<std::string> before_;
    std::filesystem::path folder_;
};

Result<double> first_surface_ms(const Picture& picture) {
    SurfaceFrame frame;
    const std::int64_t begin = monotonic_ns();
    auto device = GpuDevice::open();
    if (!device) return device.error();
    auto builder = make_vulkan_builder(picture.scene, *device);
    if (!builder) return builder.error();
    if (auto built = (*builder)->build(picture.raw, frame); !built) return built.error();
    return static_cast<double>(monotonic_ns() - begin) * 1e-6;
}

}  // namespace

Result<void> measure_start_up(Figures& figures) {
    Picture picture({1920, 1080, 16});
    const ShaderCache cache;
    if (!cache.is_there())
        return input_error("no folder for compiled shaders can be made; $TMPDIR says where");
    for (const char* state : {"_cold", ""})
        for (const int median : {3, 5}) {
            picture.scene.filter.median = median;
            const auto ms = first_surface_ms(picture);
            if (!ms) return ms.error();
            figures.push_back(
                {std::string("first_surface") + (median == 5 ? "5" : "") + state + "_ms", *ms, "ms"});
        }
    return {};
}

}  // namespace touchable
