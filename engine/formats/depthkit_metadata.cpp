#include "engine/formats/depthkit_metadata.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "engine/base/given_file.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// A colour means a depth where R + G + B > 0.3, of bytes as 0 to 1.
constexpr int least_sum = 77;
/// Hue is a circle: what lies at the near plane, red, slips past it to the far end when it is compressed. So
/// the last 1/32 of the circle means no depth.
constexpr int deepest_code = DepthCoding::hue_circle - DepthCoding::hue_circle / 32;
/// Textures are compressed in blocks of 4x4 pixels; a median of 5x5 sees beyond one. Holes are specks and the
/// blocks' dark rims.
constexpr FilterSettings usual_filter{5, 2};

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
    return first == std::string_view::npos ? std::string_view() : text.substr(first, last - first + 1);
}

/// The few fields that matter, of a YAML text that Unity wrote.
class Metadata {
public:
    static Result<Metadata> read(const std::filesystem::path& file);

    /// The value of the one line "field: value", wherever it stands.
    Result<std::string_view> text(std::string_view field) const;
    Result<double> number(std::string_view field) const;
    /// A component of a value such as {x: 512, y: 424}.
    Result<double> component(std::string_view field, std::string_view name) const;
    Error refuse(std::string_view field, std::string_view value, const std::string& right) const {
        return input_error(file_ + ": " + std::string(field) + " is " + printable(value) + ": must be " +
                           right);
    }
    const std::string& file() const { return file_; }

private:
    std::string file_, text_;
};

Result<Metadata> Metadata::read(const std::filesystem::path& file) {
    constexpr std::size_t largest = 1 << 20;
    Metadata metadata;
    metadata.file_ = file.string();
    TRY_ASSIGN(auto text, read_given_file(file, metadata.file_, "the metadata of a Depthkit video", largest));
    metadata.text_ = std::move(text);
    return metadata;
}

Result<std::string_view> Metadata::text(std::string_view field) const {
    std::optional<std::string_view> found;
    std::string_view rest = text_;
    while (!rest.empty()) {
        const auto end = std::min(rest.find('\n'), rest.size());
        std::string_view line = trimmed(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
        if (line.starts_with("- ")) line = trimmed(line.substr(2));
        if (!line.starts_with(field) || line.substr(field.size(), 1) != ":") continue;
        if (found)
            return input_error(file_ + ": has " + std::string(field) +
                               " more than once: only videos of one perspective are read");
        found = trimmed(line.substr(field.size() + 1));
    }
    if (found) return *found;
    return input_error(file_ + ": " + std::string(field) +
                       " is missing: must be there, as Depthkit's Unity plugins write it");
}

Result<double> Metadata::number(std::string_view field) const {
    TRY_ASSIGN(const auto value, text(field));
    double number = 0;
    const auto [end, failure] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (failure == std::errc() && end == value.data() + value.size() && std::isfinite(number)) return number;
    return refuse(field, value, "a number");
}

Result<double> Metadata::component(std::string_view field, std::string_view name) const {
    TRY_ASSIGN(const auto value, text(field));
    std::string_view rest = value;
    while (!rest.empty()) {  // up to each comma or brace
        const auto end = std::min(rest.find_first_of("{,}"), rest.size());
        const std::string_view part = trimmed(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
        if (!part.starts_with(name) || part.substr(name.size(), 1) != ":") continue;
        const std::string_view digits = trimmed(part.substr(name.size() + 1));
        double number = 0;
        const auto [last, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
        if (failure == std::errc() && last == digits.data() + digits.size() && std::isfinite(number))
            return number;
        break;
    }
    return refuse(field, value, "such as {x: 512, y: 424}, with a number " + std::string(name));
}

Result<int> whole(const Metadata& metadata, std::string_view field, const Result<double>& number) {
    if (!number) return number.error();
    if (*number >= 1 && *number <= 32768 && *number == std::floor(*number)) return static_cast<int>(*number);
    return metadata.refuse(field, std::to_string(*number), "a whole number of pixels, 1 to 32768");
}

/// Pictures laid out otherwise are refused: what they mean cannot be told from these fields.
Result<void> check_layout(const Metadata& metadata, int width, int height) {
    TRY_ASSIGN(const auto format, metadata.text("format"));
    if (format != "perpixel") return metadata.refuse("format", format, "perpixel");
    for (const auto& [field, size] : {std::pair{"textureWidth", width}, {"textureHeight", 2 * height}}) {
        TRY_ASSIGN(const auto texture, whole(metadata, field, metadata.number(field)));
        if (texture != size)
            return metadata.refuse(field, std::to_string(texture),
                                   std::to_string(size) + ", of two pictures of depthImageSize");
    }
    for (const auto& [name, whole_picture] : {std::pair{"x", 0.0}, {"y", 0.0}, {"z", 1.0}, {"w", 1.0}}) {
        TRY_ASSIGN(const auto edge, metadata.component("crop", name));
        if (edge != whole_picture)
            return metadata.refuse("crop", *metadata.text("crop"), "{x: 0, y: 0, z: 1, w: 1}, all of it");
    }
    return {};
}

Result<SceneDescription> scene_from(const Metadata& metadata) {
    SceneDescription described;
    described.unstated.rate = true;
    described.unstated.filters = {
        .terraces = true, .temporal = true, .flying_pixels = true, .terrace_reach = true};
    Scene& scene = described.scene;
    scene.metres_per_unit = 1;
    scene.filter = usual_filter;
    TRY_ASSIGN(const auto width,
               whole(metadata, "depthImageSize", metadata.component("depthImageSize", "x")));
    TRY_ASSIGN(const auto height,
               whole(metadata, "depthImageSize", metadata.component("depthImageSize", "y")));
    TRY(check_layout(metadata, width, height));
    scene.width = width;
    scene.height = height;
    const std::pair<double*, Result<double>> numbers[] = {
        {&scene.camera.fx, metadata.component("depthFocalLength", "x")},
        {&scene.camera.fy, metadata.component("depthFocalLength", "y")},
        {&scene.camera.cx, metadata.component("depthPrincipalPoint", "x")},
        {&scene.camera.cy, metadata.component("depthPrincipalPoint", "y")},
        {&scene.depth.near, metadata.number("nearClip")},
        {&scene.depth.far, metadata.number("farClip")}};
    for (const auto& [member, number] : numbers) {
        if (!number) return number.error();
        *member = *number;
    }
    scene.depth.kind = DepthCodingKind::hue;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.near_is_high = false;
    scene.depth.code_max = deepest_code;
    scene.depth.far = scene.depth.near + (scene.depth.far - scene.depth.near) * deepest_code /
                                             static_cast<double>(DepthCoding::hue_circle);
    scene.depth.least_sum = least_sum;
    derive_valid_range(scene.depth);
    if (auto valid = validate(scene); !valid)
        return input_error(metadata.file() + ": " + valid.error().message);
    return described;
}

}  // namespace

Result<SceneDescription> read_depthkit_metadata(const std::filesystem::path& file) {
    TRY_ASSIGN(const auto metadata, Metadata::read(file));
    return scene_from(metadata);
}

}  // namespace touchable
