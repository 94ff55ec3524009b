// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "engine/mpeg4/clip_scene.hpp"
#include "tests/must.hpp"

namespace touchable::mpeg4 {

/// A touchable clip by prototypes, whose binary form GPAC's encoder gives as well (`prototype_bytes`).
inline constexpr std::string_view prototype_scene = R"(
PROTO HapticTextureSurface [ exposedField SFVec2f stiffnessRange 0 1  exposedField SFVec2f staticFrictionRange 0 1
  exposedField SFVec2f dynamicFrictionRange 0 1  exposedField SFFloat maxHeight 0
  exposedField SFNode hapticTexture NULL  exposedField SFNode heightTexture NULL ] { WorldInfo {} }
PROTO HapticAppearance [ exposedField SFNode material NULL exposedField SFNode texture NULL exposedField SFNode textureTransform NULL
  exposedField SFNode hapticSurface NULL ] { Appearance { material IS material texture IS texture textureTransform IS textureTransform } }
PROTO Depth [ exposedField SFFloat focalLength 1 exposedField SFFloat pixelWidth 0.001 exposedField SFFloat nearPlane 1
  exposedField SFFloat farPlane 10 exposedField SFNode texture NULL ] { Rectangle { size 64 48 } }
Group { children [ Shape { appearance HapticAppearance { texture MovieTexture { url [10] loop TRUE }
   hapticSurface HapticTextureSurface { stiffnessRange 0.1 10 staticFrictionRange 0 0.5 dynamicFrictionRange 0 0.4 maxHeight 1.0
     hapticTexture MovieTexture { url [12] loop TRUE } heightTexture MovieTexture { url [13] loop TRUE } } }
  geometry Depth { focalLength 6.983 pixelWidth 0.00123 nearPlane 10 farPlane 200 texture MovieTexture { url [11] loop TRUE } } } ]}
)";
inline constexpr std::string_view prototype_bytes =
    "c0d486170746963546578747572655375726661636500a339ba34b3333732b9b9a930b733b280000000001fc00000519"
    "cdd185d1a58d19c9a58dd1a5bdb94985b99d940000000000fe0000028cc8f2dcc2dad2c68ce4d2c6e8d2dedca4c2dcce"
    "ca00000000007f000001416d61784865696768740000000000a53430b83a34b1aa32bc3a3ab9328074a6865696768745"
    "465787475726500c3210c90c2e0e8d2c682e0e0cac2e4c2dcc6ca014a6d6174657269616c00e94e8caf0e8eae4ca01d2"
    "9d195e1d1d5c99551c985b9cd99bdc9b403a53430b83a34b1a9bab93330b1b280600dcde0e88cae0e8d00141666f6361"
    "6c4c656e677468003f800000a0b834bc32b62bb4b23a34001d418937d05b99585c941b185b99400fe00000282ccc2e4a"
    "0d8c2dcca00824000014a7465787475726500c2732140000021200000005a4ccca7ae2a054400567b99999a824000010"
    "00000003f000000800000001f666666cfe0000027ae2a0649eb8a81b203b40df74bc9d509bfa504800002869000013d7"
    "1502e4";

/// The same as pictures, by prototypes that are the same, with and without names.
inline const std::string still_scene =
    std::string(prototype_scene.substr(0, prototype_scene.find("Group"))) + R"(
Group { children [ Shape { appearance HapticAppearance { texture ImageTexture { url [10] }
   hapticSurface HapticTextureSurface { stiffnessRange 0.1 2 staticFrictionRange 0 1 dynamicFrictionRange 0 1 maxHeight 1.0
     hapticTexture ImageTexture { url [12] } heightTexture ImageTexture { url [13] } } }
  geometry Depth { focalLength 4.7 pixelWidth 0.0112 nearPlane 40 farPlane 180 texture ImageTexture { url [11] } } } ]}
)";
inline constexpr std::string_view still_bytes =
    "c0d486170746963546578747572655375726661636500a339ba34b3333732b9b9a930b733b280000000001fc00000519"
    "cdd185d1a58d19c9a58dd1a5bdb94985b99d940000000000fe0000028cc8f2dcc2dad2c68ce4d2c6e8d2dedca4c2dcce"
    "ca00000000007f000001416d61784865696768740000000000a53430b83a34b1aa32bc3a3ab9328074a6865696768745"
    "465787475726500c3210c90c2e0e8d2c682e0e0cac2e4c2dcc6ca014a6d6174657269616c00e94e8caf0e8eae4ca01d2"
    "9d195e1d1d5c99551c985b9cd99bdc9b403a53430b83a34b1a9bab93330b1b280600dcde0e88cae0e8d00141666f6361"
    "6c4c656e677468003f800000a0b834bc32b62bb4b23a34001d418937d05b99585c941b185b99400fe00000282ccc2e4a"
    "0d8c2dcca00824000014a7465787475726500c2732140000021200000005a4ccca5ed40a8800acf7333335000000009f"
    "c000004bda81925ed40d901da04b33334f0de00d2844000014334000097b502e40";
inline constexpr std::string_view nameless_still_bytes =
    "c05a3000000001fc0000051800000000fe0000028c000000007f0000014100000000a574ac3210d4ae95d2ba5600dcde"
    "0f413f800000a09d418937d04fe00000282824000014ac2732140000021200000005a4ccca5ed40a8800acf733333500"
    "0000009fc000004bda81925ed40d901da04b33334f0de00d2844000014334000097b502e40";

/// MPEG-4's own node of depth images, and its binary form by GPAC's encoder.
inline constexpr std::string_view depth_image_scene = R"(
Group { children [ DepthImage { nearPlane 10 farPlane 200 fieldOfView 0.9 0.7 orthographic FALSE
  diTexture SimpleTexture { texture MovieTexture { url [10] loop TRUE } depth MovieTexture { url [11] loop TRUE } } } ] }
)";
inline constexpr std::string_view depth_image_bytes =
    "c085a0000364d1c540b9471502a50d2000027ecccccc7e66666648";
inline constexpr std::string_view depth_image_still_scene = R"(
Group { children [ DepthImage { nearPlane 10 farPlane 200 fieldOfView 0.9 0.7 orthographic FALSE
  diTexture SimpleTexture { texture ImageTexture { url [10] } depth ImageTexture { url [11] } } } ] }
)";
inline constexpr std::string_view depth_image_still_bytes =
    "c085a0000364cda81726d40a9434800009fb333331f999999920";
inline constexpr std::string_view nameless_depth_image_still_bytes =
    "c005a0000364cda81726d40a9434800009fb333331f999999920";

/// "": it is no error.
template <class T>
std::string message(const Result<T>& result) {
    return result ? "" : result.error().message;
}

inline SceneTree scene_from(std::string_view text) {
    return test::must(parse_scene_text(text));
}

inline std::string hex(std::span<const std::uint8_t> bytes) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const std::uint8_t byte : bytes) {
        text += digits[byte >> 4];
        text += digits[byte & 15];
    }
    return text;
}

inline std::vector<std::uint8_t> bytes_of_hex(std::string_view text) {
    std::vector<std::uint8_t> bytes;
    for (std::size_t k = 0; k + 1 < text.size(); k += 2)
        bytes.push_back(static_cast<std::uint8_t>(std::stoi(std::string(text.substr(k, 2)), nullptr, 16)));
    return bytes;
}

}  // namespace touchable::mpeg4
