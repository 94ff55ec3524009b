#include "player/screen/canvas.hpp"

#include <cstddef>
#include <utility>

#include "engine/gpu/gpu_commands.hpp"

namespace touchable {

Result<Image> read_back(std::shared_ptr<GpuDevice> device, const GpuImage& canvas) {
    const VkExtent2D extent = canvas.extent();
    const std::size_t pixels = std::size_t{extent.width} * extent.height;
    auto buffer = GpuBuffer::create(*device, "picture read back", pixels * 4, GpuMemory::readback);
    if (!buffer.ok()) return buffer.error();
    auto commands = GpuCommands::begin(device, "read back");
    if (!commands.ok()) return commands.error();
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {extent.width, extent.height, 1};
    vkCmdCopyImageToBuffer(commands->handle(), canvas.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           buffer->handle(), 1, &region);
    commands->keep(canvas.keep_alive());
    commands->keep(buffer->keep_alive());
    if (auto done = std::move(*commands).run(); !done.ok()) return done.error();
    Image image{static_cast<int>(extent.width), static_cast<int>(extent.height), 1, 3, {}};
    image.samples.resize(pixels * 3);
    const auto bytes = buffer->mapped<std::uint8_t>();
    for (std::size_t k = 0; k < pixels; ++k)
        for (std::size_t channel = 0; channel < 3; ++channel)
            image.samples[3 * k + channel] = bytes[4 * k + channel];
    return image;
}

}  // namespace touchable
