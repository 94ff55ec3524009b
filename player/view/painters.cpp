#include "player/view/surface_painter.hpp"

namespace touchable {

Result<std::unique_ptr<SurfacePainter>> make_painter(std::string_view name) {
    if (name == "cpu" || name == "auto") return make_cpu_painter();
    return usage_error("--painter " + std::string(name) + " is not known; there are cpu and auto");
}

}  // namespace touchable
