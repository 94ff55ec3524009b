#include "engine/import/gdepth_image.hpp"

#include <charconv>
#include <cmath>
#include <string>
#include <utility>

#include "engine/import/xmp.hpp"
#include "engine/media/codecs.hpp"
#include "engine/media/coded_image.hpp"
#include "engine/media/far_plane.hpp"
#include "engine/media/plane_role.hpp"
#include "engine/media/stored_image.hpp"
#include "engine/printable.hpp"

namespace touchable {
namespace {

class GdepthImage final : public ClipReader {
public:
    explicit GdepthImage(const std::filesystem::path& file) : path_(file), file_(file.string()) {
        add_input(file);
    }
    Result<void> open(const std::optional<Scene>& replacement);

    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return 1; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override {
        if (std::exchange(given_, true)) return std::optional<RawFrame>{};
        return std::optional(frame_);
    }
    Result<void> rewind() override {
        given_ = false;
        return {};
    }

private:
    Error refuse(const std::string& what) const { return input_error(file_ + ": " + what); }
    Result<std::string> property(std::string_view name) const;
    Result<double> number(std::string_view name) const;
    Result<Image> read_depth();
    Result<void> describe(const Image& depth);
    Result<void> describe_depth(const Image& depth);
    Result<void> add(PlaneRole role, Image image);

    std::filesystem::path path_;
    std::string file_;
    XmpProperties xmp_;
    Scene scene_;
    std::vector<TrackInfo> infos_;
    std::vector<std::string> notes_;
    RawFrame frame_;
    bool given_ = false;
};

Result<void> GdepthImage::open(const std::optional<Scene>& replacement) {
    const auto bytes = read_picture_bytes(path_);
    if (!bytes) return bytes.error();
    auto xmp = read_jpeg_xmp(*bytes, file_);
    if (!xmp) return xmp.error();
    xmp_ = std::move(*xmp);
    auto depth = read_depth();
    if (!depth) return depth.error();
    if (replacement)
        scene_ = *replacement;
    else if (auto described = describe(*depth); !described)
        return described;
    auto colour = decode_coded_image(*bytes, file_);
    if (!colour) return colour.error();
    infos_.push_back(
        {"colour", colour->codec, colour->pixel_format, colour->image.width, colour->image.height});
    if (auto added = add(PlaneRole::depth, std::move(*depth)); !added) return added;
    if (auto added = add(PlaneRole::colour, std::move(colour->image)); !added) return added;
    if (auto note = default_touch_note(false, scene_)) notes_.push_back(std::move(*note));
    if (auto note = no_depth_note(frame_, scene_.depth)) notes_.push_back(std::move(*note));
    if (!scene_.far_from_frames) return {};
    FarPlaneSearch search(scene_.depth);
    if (auto added = search.add(frame_.depth); !added) return added;
    auto note = search.settle(scene_);
    if (!note) return refuse(note.error().message);
    notes_.push_back(std::move(*note));
    return {};
}

Result<std::string> GdepthImage::property(std::string_view name) const {
    const auto found = xmp_.find(name);
    if (found != xmp_.end()) return found->second;
    return refuse("has no " + std::string(name) +
                  " in its XMP: a JPEG needs a depth map (GDepth) to be touched");
}

Result<double> GdepthImage::number(std::string_view name) const {
    const auto text = property(name);
    if (!text) return text.error();
    double value = 0;
    const char* end = text->data() + text->size();
    const auto [last, failure] = std::from_chars(text->data(), end, value);
    if (failure == std::errc() && last == end && std::isfinite(value)) return value;
    return refuse("its " + std::string(name) + " is " + in_quotes(*text) + ": must be a number");
}

/// The depth map as grey, however it was stored.
Result<Image> GdepthImage::read_depth() {
    const auto text = property("GDepth:Data");
    if (!text) return text.error();
    const auto bytes = decode_base64(*text);
    if (!bytes) return refuse("its GDepth:Data is not base64");
    auto stored = decode_coded_image(*bytes, file_ + ": depth");
    if (!stored) return stored.error();
    Image& image = stored->image;
    infos_.push_back({"depth", stored->codec, stored->pixel_format, image.width, image.height});
    if (stored->interlaced) return refuse("its depth map is an interlaced PNG: must be a plain one");
    if (stored->bits < 8)
        return refuse("its depth map is of " + std::to_string(stored->bits) + " bits: must be of 8 or 16");
    if (auto note = lossy_note(PlaneRole::depth, stored->codec)) notes_.push_back(std::move(*note));
    if (auto grey = as_grey(image)) return std::move(*grey);
    return refuse("its depth map is coloured: must be grey, or red, green and blue alike");
}

/// A scene of what the file says, and of what it does not.
Result<void> GdepthImage::describe(const Image& depth) {
    scene_.name = path_.stem().string();
    scene_.unstated = all_unstated;
    scene_.width = depth.width;
    scene_.height = depth.height;
    scene_.depth_bits = 8 * depth.bytes_per_sample;
    if (auto described = describe_depth(depth); !described) return described;
    const auto unit = xmp_.find("GDepth:Units");
    if (unit != xmp_.end() && unit->second != "m" && unit->second != "mm")
        return refuse("its GDepth:Units is " + in_quotes(unit->second) + ": must be m or mm");
    scene_.metres_per_unit = unit != xmp_.end() && unit->second == "mm" ? 0.001 : 1.0;
    if (unit == xmp_.end()) notes_.push_back("the file names no unit of length: metres are assumed");
    constexpr double half_angle_cotangent = 1.7320508075688772;  // of 30 degrees
    const double focal_length = 0.5 * depth.width * half_angle_cotangent;
    scene_.camera = {focal_length, focal_length, 0.5 * (depth.width - 1), 0.5 * (depth.height - 1)};
    notes_.push_back(
        "the file describes no camera: 60 degrees across are assumed, the axis through the middle");
    derive_valid_range(scene_.depth);
    if (auto valid = validate(scene_); !valid) return refuse(valid.error().message);
    return {};
}

/// With v = code / code_max, RangeLinear is near + (far - near) v, and RangeInverse
/// far near / (far - (far - near) v): the codings of scenes, code 0 at the near plane.
Result<void> GdepthImage::describe_depth(const Image& depth) {
    const auto format = property("GDepth:Format");
    if (!format) return format.error();
    if (*format != "RangeInverse" && *format != "RangeLinear")
        return refuse("its GDepth:Format is " + in_quotes(*format) + ": must be RangeInverse or RangeLinear");
    const auto near = number("GDepth:Near"), far = number("GDepth:Far");
    if (!near) return near.error();
    if (!far) return far.error();
    const auto measured = xmp_.find("GDepth:MeasureType");
    const bool along_ray = measured != xmp_.end() && measured->second == "OpticRay";
    if (measured != xmp_.end() && !along_ray && measured->second != "OpticalAxis")
        return refuse("its GDepth:MeasureType is " + in_quotes(measured->second) +
                      ": must be OpticalAxis or OpticRay");
    scene_.depth.kind = *format == "RangeInverse" ? DepthCodingKind::inverse : DepthCodingKind::linear;
    scene_.depth.semantics = along_ray ? DepthSemantics::range : DepthSemantics::planar;
    scene_.depth.near_is_high = false;
    scene_.depth.near = *near;
    scene_.depth.far = *far;
    scene_.depth.code_max = depth.bytes_per_sample == 1 ? 255 : 65535;
    return {};
}

Result<void> GdepthImage::add(PlaneRole role, Image image) {
    if (role != PlaneRole::depth && (image.width != scene_.width || image.height != scene_.height))
        notes_.push_back(resampling_note(role, image.width, image.height, scene_));
    auto plane =
        fit_plane(role, plane_from(std::move(image)), scene_, file_ + ": " + std::string(role_name(role)));
    if (!plane) return plane.error();
    add_plane(frame_, role, std::move(*plane));
    return {};
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_gdepth_image(const std::filesystem::path& file,
                                                      const std::optional<Scene>& scene) {
    auto reader = std::make_unique<GdepthImage>(file);
    if (auto opened = reader->open(scene); !opened) return opened.error();
    return std::unique_ptr<ClipReader>(std::move(reader));
}

}  // namespace touchable
