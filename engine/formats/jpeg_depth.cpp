#include "engine/formats/jpeg_depth.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/formats/dynamic_depth.hpp"
#include "engine/formats/exif.hpp"
#include "engine/formats/xmp.hpp"
#include "engine/picture/base64.hpp"
#include "engine/picture/coded_image.hpp"

namespace touchable {
namespace {

/// Properties of a depth map that lies in the XMP, and of one that lies after the picture: they have other
/// prefixes and mean the same.
constexpr const char* in_xmp = "GDepth:";
constexpr const char* after_picture = "DepthMap:";

bool has_dynamic_depth(const XmpProperties& xmp) {
    return xmp.contains("DepthMap:Format") || xmp.contains("DepthMap:DepthURI");
}

std::string lower_case(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}

class JpegDepth {
public:
    JpegDepth(std::string bytes, std::string where) : bytes_(std::move(bytes)), where_(std::move(where)) {}
    Result<DepthPhoto> read(bool is_described);

private:
    Error refuse(const std::string& what) const { return input_error(where_ + ": " + what); }
    Result<std::string> property(const std::string& name) const;
    Result<double> number(const std::string& name) const;
    Result<void> read_depth();
    Result<void> describe();
    Result<void> describe_unit();
    void orient();

    std::string bytes_, where_;
    XmpEntries entries_;
    XmpProperties xmp_;
    const char* prefix_ = in_xmp;
    DepthPhoto photo_;
};

Result<DepthPhoto> JpegDepth::read(bool is_described) {
    TRY_ASSIGN(auto entries, read_jpeg_xmp_entries(bytes_, where_));
    entries_ = std::move(entries);
    xmp_ = properties_of(entries_);
    if (!xmp_.contains("GDepth:Data") && has_dynamic_depth(xmp_)) prefix_ = after_picture;
    TRY(read_depth());
    if (is_described) TRY(describe());
    TRY_ASSIGN(auto colour, decode_coded_image(bytes_, where_));
    photo_.colour = std::move(colour);
    orient();
    return std::move(photo_);
}

Result<std::string> JpegDepth::property(const std::string& name) const {
    const auto found = xmp_.find(prefix_ + name);
    if (found != xmp_.end()) return found->second;
    return refuse("has no " + (prefix_ + name) +
                  " in its XMP: a JPEG needs a depth map (GDepth, Dynamic Depth) to be touched");
}

Result<double> JpegDepth::number(const std::string& name) const {
    TRY_ASSIGN(const auto text, property(name));
    if (const auto value = parsed_number(text)) return *value;
    return refuse("its " + (prefix_ + name) + " is " + in_quotes(text) + ": must be a number");
}

/// The depth map as grey, however it was stored.
Result<void> JpegDepth::read_depth() {
    std::string bytes;
    if (prefix_ == after_picture) {
        TRY_ASSIGN(const auto found, dynamic_depth_map(bytes_, entries_, where_));
        bytes = found;
    } else {
        TRY_ASSIGN(const auto text, property("Data"));
        auto decoded = decode_base64(text);
        if (!decoded) return refuse("its GDepth:Data is not base64");
        bytes = std::move(*decoded);
    }
    TRY_ASSIGN(auto stored, decode_coded_image(bytes, where_ + ": depth"));
    if (stored.interlaced) return refuse("its depth map is an interlaced PNG: must be a plain one");
    if (stored.bits < 8)
        return refuse("its depth map is of " + std::to_string(stored.bits) + " bits: must be of 8 or 16");
    if (stored.image.channels != 1) {
        auto grey = as_grey(stored.image);
        if (stop_requested()) return interrupted_error();
        if (!grey) return refuse("its depth map is coloured: must be grey, or red, green and blue alike");
        stored.image = std::move(*grey);
    }
    photo_.depth = std::move(stored);
    photo_.depth.bits = 8 * photo_.depth.image.bytes_per_sample;
    return {};
}

/// With v = code / code_max, RangeLinear is near + (far - near) v, and RangeInverse
/// far near / (far - (far - near) v): the codings of scenes, code 0 at the near plane.
Result<void> JpegDepth::describe() {
    TRY_ASSIGN(const auto format, property("Format"));
    const bool is_inverse = lower_case(format) == "rangeinverse";
    if (!is_inverse && lower_case(format) != "rangelinear")
        return refuse("its " + std::string(prefix_) + "Format is " + in_quotes(format) +
                      ": must be RangeInverse or RangeLinear");
    const auto near = number("Near"), far = number("Far");
    if (!near) return near.error();
    if (!far) return far.error();
    const auto measured = property("MeasureType");
    const bool along_ray = measured && *measured == "OpticRay";
    if (measured && !along_ray && *measured != "OpticalAxis")
        return refuse("its " + std::string(prefix_) + "MeasureType is " + in_quotes(*measured) +
                      ": must be OpticalAxis or OpticRay");
    DepthCoding& coding = photo_.coding;
    coding.kind = is_inverse ? DepthCodingKind::inverse : DepthCodingKind::linear;
    coding.semantics = along_ray ? DepthSemantics::range : DepthSemantics::planar;
    coding.near_is_high = false;
    coding.near = *near;
    coding.far = *far;
    coding.code_max = photo_.depth.bits == 8 ? 255 : 65535;
    return describe_unit();
}

Result<void> JpegDepth::describe_unit() {
    const auto written = property("Units");
    const std::string unit = written ? lower_case(*written) : "none";
    if (unit == "mm" || unit == "millimeters") {
        photo_.metres_per_unit = 0.001;
    } else if (unit == "none") {
        add_remark(photo_.remarks, {"lengths are metres", true});
    } else if (unit != "m" && unit != "meters") {
        return refuse("its " + std::string(prefix_) + "Units is " + in_quotes(*written) +
                      ": must be m (Meters) or mm");
    }
    return {};
}

/// EXIF's orientation is of the picture as stored, which its depth map shares, but for programs that turned
/// the map already.
void JpegDepth::orient() {
    const ExifFacts exif = read_jpeg_exif(bytes_);
    photo_.film_focal_length = exif.film_focal_length;
    photo_.colour_turn = exif_orientation(exif.orientation);
    const auto is_wide = [](const Image& image) { return image.width >= image.height; };
    const bool is_turned =
        photo_.colour_turn.transposed && is_wide(photo_.depth.image) != is_wide(photo_.colour.image);
    if (!is_turned) photo_.depth_turn = photo_.colour_turn;
    if (const auto camera = dynamic_depth_camera(xmp_)) photo_.camera = upright(*camera, photo_.colour_turn);
}

}  // namespace

bool has_jpeg_depth(const SourceFile& file) {
    const auto bytes = read_picture_bytes(file);
    if (!bytes) return false;
    const auto xmp = read_jpeg_xmp(*bytes, file.string());
    return xmp && (xmp->contains("GDepth:Data") || has_dynamic_depth(*xmp));
}

Result<std::unique_ptr<ClipReader>> open_jpeg_depth(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    const SourceDescription& known) {
    TRY_ASSIGN(auto bytes, read_picture_bytes(file));
    TRY_ASSIGN(auto photo, JpegDepth(std::move(bytes), file.string()).read(!described));
    return open_depth_photo(file.path(), std::move(photo), described, known);
}

}  // namespace touchable
