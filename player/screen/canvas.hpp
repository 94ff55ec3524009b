#pragma once

#include <filesystem>
#include <memory>

#include "engine/new_file.hpp"
#include "engine/picture/image_file.hpp"
#include "engine/result.hpp"
#include "player/view/gpu_image.hpp"

namespace touchable {

/// What `canvas` shows, which is in VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, as a picture in the CPU's memory.
Result<Image> read_back(std::shared_ptr<GpuDevice> device, const GpuImage& canvas);

}  // namespace touchable
