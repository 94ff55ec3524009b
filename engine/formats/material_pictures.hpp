#pragma once

#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/stored_image.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// The whole numbers in a picture of material indices: the first 12 met, sorted.
std::vector<int> indices_in(const StoredImage& picture);

/// Makes haptic pictures of pictures of material indices: each pixel gets its material's properties, by the
/// scene's haptic ranges. An index without an entry, and what is no whole number from 0 to 65535, gets the
/// scene's default properties.
class MaterialPictures {
public:
    explicit MaterialPictures(const SceneDescription& described);
    /// `indices` has one channel. An error does not name the file.
    Result<StoredImage> haptic(const StoredImage& indices) const;

private:
    std::vector<std::uint8_t> samples_;  // red, green, blue of each index, and of all others
};

}  // namespace touchable
