#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/clip/aligned_clip.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/formats/read_pictures.hpp"

namespace touchable {

/// Pictures in `folder`, found by the patterns of the scene's FolderSource. `notes`: what a person should
/// know of how the scene came about, before what the reader has to say; `pictures`: those of them that were
/// read before.
Result<std::unique_ptr<ClipReader>> open_image_folder(const std::filesystem::path& folder,
                                                      const SceneDescription& described,
                                                      std::vector<std::string> notes = {},
                                                      Colour colour = Colour::wanted,
                                                      std::shared_ptr<ReadPictures> pictures = nullptr,
                                                      DepthAlignment alignment = DepthAlignment::automatic);

}  // namespace touchable
