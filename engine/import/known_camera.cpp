#include "engine/import/known_camera.hpp"

#include <cmath>

namespace touchable {

Camera scaled_camera(const Intrinsics& intrinsics, int width, int height) {
    const bool has_size = intrinsics.width > 0 && intrinsics.height > 0;
    const double x = has_size ? static_cast<double>(width) / intrinsics.width : 1,
                 y = has_size ? static_cast<double>(height) / intrinsics.height : 1;
    const auto centre = [](double at, double scale) { return (at + 0.5) * scale - 0.5; };
    return {intrinsics.fx * x, intrinsics.fy * y,
            intrinsics.cx ? centre(*intrinsics.cx, x) : 0.5 * (width - 1),
            intrinsics.cy ? centre(*intrinsics.cy, y) : 0.5 * (height - 1)};
}

Camera camera_of_fov(double degrees, int width, int height) {
    const double f = 0.5 * width / std::tan(degrees * 3.14159265358979323846 / 360);
    return {f, f, 0.5 * (width - 1), 0.5 * (height - 1)};
}

}  // namespace touchable
