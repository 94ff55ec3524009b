#pragma once

#include <filesystem>

namespace touchable {

/// Whether a screen is there that is touched: an input of Linux's that lies on a display and tells where
/// several fingers are. `inputs`: the kernel's folder of them.
bool has_touch_screen(const std::filesystem::path& inputs = "/sys/class/input");

}  // namespace touchable
