#include "engine/formats/heif_depth_meaning.hpp"

#include <cmath>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/formats/xmp.hpp"

namespace touchable {
namespace {

/// Ends of a range of disparities that can be reciprocal metres: a phone sees no nearer and no farther.
constexpr double nearest_of_phones = 0.02, farthest_of_phones = 500;  // metres

struct Range {
    double least = 0, most = 0;  // of code 0 and the largest code
};

bool is_range(double least, double most) {
    return std::isfinite(least) && std::isfinite(most) && least < most;
}

std::optional<double> property_number(const XmpProperties& xmp, const char* name) {
    const auto found = xmp.find(name);
    return found == xmp.end() ? std::nullopt : parsed_number(found->second);
}

void set_depths(DepthPhoto& photo, DepthCodingKind kind, bool near_is_high, double near, double far) {
    photo.has_scale = true;
    photo.coding.kind = kind;
    photo.coding.near_is_high = near_is_high;
    photo.coding.near = near;
    photo.coding.far = far;
}

/// Whether they can be reciprocal metres; then they are taken for them.
bool take_disparities(DepthPhoto& photo, const Range& disparity) {
    if (!is_range(disparity.least, disparity.most) || disparity.least <= 0) return false;
    const double near = 1 / disparity.most, far = 1 / disparity.least;
    if (near < nearest_of_phones || far > farthest_of_phones) return false;
    set_depths(photo, DepthCodingKind::inverse, true, near, far);
    return true;
}

/// The nine numbers of Apple's matrix, column by column: fx 0 0, 0 fy 0, cx cy 1.
std::optional<Intrinsics> apple_camera(const XmpEntries& entries) {
    std::vector<double> matrix;
    bool inside = false;
    for (const XmpEntry& entry : entries) {
        if (!entry.value && entry.name.starts_with("depthData:"))
            inside = entry.name == "depthData:IntrinsicMatrix";
        if (inside && entry.name == "rdf:li" && entry.value)
            matrix.push_back(parsed_number(*entry.value).value_or(0));
    }
    const XmpProperties xmp = properties_of(entries);
    const auto width = property_number(xmp, "depthData:IntrinsicMatrixReferenceWidth"),
               height = property_number(xmp, "depthData:IntrinsicMatrixReferenceHeight");
    const auto is_side = [](const std::optional<double>& side) { return side && *side >= 1 && *side < 1e6; };
    if (matrix.size() != 9 || !(matrix[0] > 0) || !(matrix[4] > 0) || !is_side(width) || !is_side(height))
        return std::nullopt;
    return Intrinsics{
        matrix[0], matrix[4], matrix[6], matrix[7], static_cast<int>(*width), static_cast<int>(*height)};
}

/// Whether Apple's metadata tell the depths.
bool describe_by_apple(const XmpEntries& entries, DepthPhoto& photo) {
    const XmpProperties xmp = properties_of(entries);
    const auto least = property_number(xmp, "apdi:FloatMinValue"),
               most = property_number(xmp, "apdi:FloatMaxValue");
    const auto type = xmp.find("apdi:AuxiliaryImageType");
    photo.camera = apple_camera(entries);
    if (!least || !most || type == xmp.end()) return false;
    if (type->second == "depth" && *least > 0 && is_range(*least, *most)) {
        set_depths(photo, DepthCodingKind::linear, false, *least, *most);
        return true;
    }
    if (type->second != "disparity" || !take_disparities(photo, {*least, *most})) return false;
    const auto accuracy = xmp.find("depthData:Accuracy");
    if (accuracy != xmp.end() && accuracy->second == "relative")
        add_remark(photo.remarks,
                   {"its depths are right among each other, says the camera; in metres they may be "
                    "larger or smaller all together"});
    return true;
}

/// How the codec says that depth is represented; nothing where it says a number that H.265 has no meaning
/// for. libheif hands any number on: only its bytes may be looked at before that is known.
std::optional<heif_depth_representation_type> representation(const heif_depth_representation_info& info) {
    std::underlying_type_t<heif_depth_representation_type> number;
    std::memcpy(&number, &info.depth_representation_type, sizeof number);
    if (number > heif_depth_representation_type_nonuniform_disparity) return std::nullopt;
    return info.depth_representation_type;
}

/// Whether the codec's metadata tell the depths.
bool describe_by_codec(const heif_depth_representation_info& info, heif_depth_representation_type type,
                       DepthPhoto& photo) {
    if (type == heif_depth_representation_type_nonuniform_disparity) {
        add_remark(
            photo.remarks,
            {"its disparities are spaced unevenly, by a table that is not read: they are taken as even"});
        return false;
    }
    if (info.has_z_near && info.has_z_far && info.z_near > 0 && is_range(info.z_near, info.z_far)) {
        const bool is_linear = type == heif_depth_representation_type_uniform_Z;
        set_depths(photo, is_linear ? DepthCodingKind::linear : DepthCodingKind::inverse, !is_linear,
                   info.z_near, info.z_far);
        add_remark(photo.remarks,
                   {std::string("lengths are metres") +
                        (is_linear ? " and small values are near, as values grow evenly with depth" : ""),
                    true});
        return true;
    }
    if (!info.has_d_min || !info.has_d_max || !take_disparities(photo, {info.d_min, info.d_max}))
        return false;
    add_remark(photo.remarks, {"its disparities are 1/metres, as Apple writes them", true});
    return true;
}

}  // namespace

void describe_heif_depth(const heif_depth_representation_info* info, const std::string& xmp,
                         DepthPhoto& photo) {
    photo.coding.semantics = DepthSemantics::planar;
    photo.coding.code_max = static_cast<std::uint16_t>((1 << photo.depth.bits) - 1);
    const auto entries = parse_xmp_entries(xmp);
    if (entries && describe_by_apple(*entries, photo)) return;
    const auto type = info != nullptr ? representation(*info) : std::nullopt;
    if (type && describe_by_codec(*info, *type, photo)) return;
    photo.has_scale = false;
    photo.coding.kind = DepthCodingKind::inverse;
    photo.coding.near_is_high = type != heif_depth_representation_type_uniform_Z;
    if (!photo.coding.near_is_high) photo.coding.kind = DepthCodingKind::linear;
}

}  // namespace touchable
