#include "player/draw/light_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

namespace touchable {
namespace {

// The sRGB curve, IEC 61966-2-1.
float light_of_share(float share) {
    return share <= 0.04045F ? share / 12.92F : std::pow((share + 0.055F) / 1.055F, 2.4F);
}
float share_of_light(float light) {
    return light <= 0.0031308F ? light * 12.92F : 1.055F * std::pow(light, 1.0F / 2.4F) - 0.055F;
}

const std::array<float, 256>& light_of_bytes() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> light;
        for (std::size_t k = 0; k < light.size(); ++k)
            light[k] = light_of_share(static_cast<float>(k) / 255.0F);
        return light;
    }();
    return table;
}

/// Fine enough that every byte is hit as by the curve itself.
constexpr std::size_t curve_steps = 1 << 14;
const std::vector<std::uint8_t>& bytes_of_light() {
    static const std::vector<std::uint8_t> table = [] {
        std::vector<std::uint8_t> bytes(curve_steps + 1);
        for (std::size_t k = 0; k <= curve_steps; ++k)
            bytes[k] = static_cast<std::uint8_t>(
                255.0F * share_of_light(static_cast<float>(k) / static_cast<float>(curve_steps)) + 0.5F);
        return bytes;
    }();
    return table;
}
std::uint8_t byte_of(float light) {
    const float step = std::clamp(light, 0.0F, 1.0F) * static_cast<float>(curve_steps);
    return bytes_of_light()[static_cast<std::size_t>(step + 0.5F)];
}

}  // namespace

glm::vec3 light_of(PackedColour colour) {
    const auto& light = light_of_bytes();
    return {light[colour & 255U], light[colour >> 8 & 255U], light[colour >> 16 & 255U]};
}

glm::vec3 light_of_brightness(const glm::vec3& brightness) {
    const glm::vec3 share = glm::clamp(brightness, 0.0F, 1.0F);
    return {light_of_share(share.r), light_of_share(share.g), light_of_share(share.b)};
}

glm::vec3 brightness_of(const glm::vec3& light) {
    return {share_of_light(light.r), share_of_light(light.g), share_of_light(light.b)};
}

namespace {

glm::vec3 background_light(int row, int height) {
    const glm::vec3 above = light_of(pack_colour(22, 25, 31)), below = light_of(pack_colour(36, 39, 45));
    const float share = static_cast<float>(row) / static_cast<float>(height);
    return glm::mix(above, below, share * share);
}

}  // namespace

PackedColour background_colour(int row, int height) {
    const glm::vec3 light = background_light(row, height);
    return pack_colour(byte_of(light.r), byte_of(light.g), byte_of(light.b));
}

LightPicture on_background(PicturePlanes planes) {
    LightPicture picture{planes.width, planes.height, std::move(planes.z), {}};
    picture.light.resize(picture.z.size());
    for (int y = 0; y < picture.height; ++y) {
        const glm::vec3 background = background_light(y, picture.height);
        for (int x = 0; x < picture.width; ++x) {
            const std::size_t at = picture.index(x, y);
            picture.light[at] = picture.z[at] > 0 ? light_of(planes.colours[at]) : background;
        }
    }
    return picture;
}

Image developed(const LightPicture& picture, int samples) {
    Image image{picture.width / samples, picture.height / samples, 1, 3, {}};
    image.samples.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
    const float share = 1.0F / static_cast<float>(samples * samples);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            glm::vec3 sum(0.0F);
            for (int sy = 0; sy < samples; ++sy)
                for (int sx = 0; sx < samples; ++sx)
                    sum += glm::min(picture.light[picture.index(x * samples + sx, y * samples + sy)],
                                    glm::vec3(1.0F));
            for (int channel = 0; channel < 3; ++channel)
                image.samples.push_back(byte_of(sum[channel] * share));
        }
    return image;
}

}  // namespace touchable
