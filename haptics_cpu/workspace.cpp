#include "haptics_cpu/workspace.hpp"

namespace touchable {

Workspace default_workspace(int width, double fx, double median_depth) {
    constexpr double picture_width = 0.16;  // of device space, metres
    const double scene_width = width / fx * median_depth;
    return {picture_width / scene_width, {0, 0, -median_depth}};
}

}  // namespace touchable
