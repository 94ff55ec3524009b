#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "engine/picture/image_file.hpp"
#include "player/draw/picture_planes.hpp"

namespace touchable {

/// A picture while it is put together: light, 0 to 1 a channel, not yet brightness as eyes see it (sRGB), so
/// that mixing and averaging are right; and z as painters have it.
struct LightPicture {
    int width = 0, height = 0;
    std::vector<float> z;
    std::vector<glm::vec3> light;

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

/// Light of a colour of three bytes.
glm::vec3 light_of(PackedColour colour);
/// Of brightness as eyes see it, 0 to 1 a channel, beyond which it is cut off; and the other way round.
glm::vec3 light_of_brightness(const glm::vec3& brightness);
glm::vec3 brightness_of(const glm::vec3& light);

/// What a picture of a height has where nothing is drawn: a quiet dark grey, a little lighter below.
PackedColour background_colour(int row, int height);

/// The drawn surface before the background.
LightPicture on_background(PicturePlanes planes);

/// Averages blocks of samples x samples; `picture`'s sides are multiples of that. RGB of 8 bits.
Image developed(const LightPicture& picture, int samples);

}  // namespace touchable
