#include <array>
#include <cmath>
#include <cstring>

#include "engine/formats/depth_values.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

SceneDescription scene_of(Taken& taken) {
    constexpr std::array kinds{StoredDepth::Kind::codes, StoredDepth::Kind::disparity,
                               StoredDepth::Kind::relative};
    constexpr std::array codings{DepthCodingKind::metric, DepthCodingKind::linear, DepthCodingKind::inverse};
    const unsigned choice = taken.byte();
    SceneDescription described;
    Scene& scene = described.scene;
    scene.camera = {50, 50, 4, 4};
    scene.stored.kind = kinds[choice % kinds.size()];
    scene.stored.baseline = 100;
    scene.stored.scale = choice & 0x40U ? -0.5 : 0.25;
    scene.stored.offset = choice & 0x40U ? 1000 : 1;
    scene.stored.bytes_swapped = choice & 0x80U;
    scene.stored.rotated = static_cast<int>(choice >> 2 & 15U);
    const unsigned coding = taken.byte();
    scene.depth.kind = codings[coding % codings.size()];
    const bool is_metric = scene.depth.kind == DepthCodingKind::metric;
    described.unstated.far = is_metric && (coding & 0x80U) != 0;
    if ((coding & 0x20U) != 0) scene.stored.used_bits = 13;
    scene.stored.packed = is_metric && (coding & 0x10U) != 0;
    scene.depth.near = is_metric && (coding & 0x40U) != 0 ? 0 : 10;
    scene.depth.far = 5000;
    scene.depth.scale = 1;
    scene.depth_bits = 8;
    scene.depth.code_max = 255;  // all codes are looked at wherever a coding is checked
    derive_valid_range(scene.depth);
    return described;
}

/// Words or floats, any of them, as the picture of a scene.
bool parse_depth_values(std::string_view bytes) {
    Taken taken(bytes);
    SceneDescription described = scene_of(taken);
    Scene& scene = described.scene;
    const bool are_floats = taken.byte() & 1U;
    StoredImage picture;
    const std::string_view samples = taken.rest();
    picture.image = {static_cast<int>(samples.size() / (are_floats ? 4 : 2)), 1, 2, 1, {}};
    if (picture.image.width == 0) return false;
    scene.width = picture.image.width;
    scene.height = 1;
    if (are_floats) {
        picture.values.resize(samples.size() / 4);
        std::memcpy(picture.values.data(), samples.data(), 4 * picture.values.size());
    } else {
        picture.image.samples.resize(samples.size() / 2 * 2);
        std::memcpy(picture.image.samples.data(), samples.data(), picture.image.samples.size());
    }
    DepthValues values(described);
    if (values.needs_looks(picture)) {
        values.look(picture);
        if (!is_taken(values.settle(scene))) return false;
        require(bool(validate(scene)), "a settled scene cannot be");
    }
    const Image codes = values.codes(picture);
    require(codes.width == picture.image.width && codes.channels == 1, "codes are not the picture's");
    for (int x = 0; values.makes_codes() && x < codes.width; ++x) {
        const std::uint16_t code = codes.view().sample(x, 0);
        const double depth = scene.depth.is_valid(code) ? scene.depth.depth(code) : 1;
        require(std::isfinite(depth) && depth > 0, "a valid code has no depth");
    }
    return true;
}

const Registered depth_values_target{
    {.name = "depth_values", .parse = parse_depth_values, .changes = 100, .most_bytes = 512}};

}  // namespace
}  // namespace touchable::fuzz
