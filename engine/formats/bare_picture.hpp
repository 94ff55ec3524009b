#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/aligned_clip.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// One picture of depth, which `scene` describes; `notes` and `pictures` as for
/// open_image_folder.
Result<std::unique_ptr<ClipReader>> open_bare_picture(const std::filesystem::path& file,
                                                      SceneDescription described,
                                                      std::vector<std::string> notes = {},
                                                      Colour colour = Colour::wanted,
                                                      std::shared_ptr<ReadPictures> pictures = nullptr,
                                                      DepthAlignment alignment = DepthAlignment::automatic);

}  // namespace touchable
