#include <iterator>

#include "player/draw/overlays.hpp"

namespace touchable {
namespace {

constexpr struct {
    Overlay overlay;
    const char* name;
} overlay_names[] = {{Overlay::colour, "colour"},
                     {Overlay::depth, "depth"},
                     {Overlay::depth_linear, "depth-linear"},
                     {Overlay::stiffness, "stiffness"},
                     {Overlay::static_friction, "friction"},
                     {Overlay::dynamic_friction, "dynamic-friction"},
                     {Overlay::height, "height"},
                     {Overlay::normals, "normals"},
                     {Overlay::tiles, "tiles"},
                     {Overlay::validity, "validity"}};

}  // namespace

std::string name_of(Overlay overlay) {
    for (const auto& named : overlay_names)
        if (named.overlay == overlay) return named.name;
    return "";
}

Result<Overlay> overlay_after(Overlay now, const std::string& name) {
    std::string known;
    for (std::size_t k = 0; k < std::size(overlay_names); ++k) {
        if (name.empty() && overlay_names[k].overlay == now)
            return overlay_names[(k + 1) % std::size(overlay_names)].overlay;
        if (name == overlay_names[k].name) return overlay_names[k].overlay;
        known += (known.empty() ? "" : ", ") + std::string(overlay_names[k].name);
    }
    return usage_error("there is no overlay '" + name + "'; there are " + known);
}

}  // namespace touchable
