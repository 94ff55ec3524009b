// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/depth_photo.hpp"

#include <pugixml.hpp>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/stored_clip.hpp"

namespace touchable {
namespace {

using namespace std::string_view_literals;

constexpr double film_diagonal = 43.2666;  // mm, of 36 x 24
constexpr std::uint32_t orientation_tag = 0x0112, exif_directory_tag = 0x8769, film_focal_length_tag = 0xa405;
constexpr std::uint32_t of_16_bits = 3, of_32_bits = 4;  // types of a value
constexpr std::size_t entry_bytes = 12;

class Tiff {
public:
    explicit Tiff(std::string_view bytes) : bytes_(bytes), big_endian_(bytes.starts_with("MM\0*"sv)) {}
    bool is_tiff() const { return big_endian_ || bytes_.starts_with("II*\0"sv); }
    std::uint32_t first_directory() const { return number(4, 4); }

    /// The single number of an entry of a directory; 0 if there is none.
    std::uint32_t find(std::size_t directory, std::uint32_t tag) const {
        const std::size_t count = number(directory, 2);
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t entry = directory + 2 + entry_bytes * k;
            if (entry + entry_bytes > bytes_.size()) return 0;
            if (number(entry, 2) != tag) continue;
            const std::uint32_t type = number(entry + 2, 2);
            return type == of_16_bits ? number(entry + 8, 2) : type == of_32_bits ? number(entry + 8, 4) : 0;
        }
        return 0;
    }

private:
    std::uint32_t number(std::size_t at, std::size_t length) const {
        if (at > bytes_.size() || length > bytes_.size() - at) return 0;
        return static_cast<std::uint32_t>(number_in_bytes(bytes_.substr(at, length), big_endian_));
    }

    std::string_view bytes_;
    bool big_endian_;
};

/// Lists each element with its attributes, and its text if it holds nothing else.
struct EntryLister : pugi::xml_tree_walker {
    XmpEntries entries;
    bool for_each(pugi::xml_node& node) override {
        if (node.type() != pugi::node_element) return true;
        entries.push_back({node.name(), std::nullopt});
        for (const pugi::xml_attribute& attribute : node.attributes())
            entries.push_back({attribute.name(), attribute.value()});
        const pugi::xml_node text = node.first_child();
        if (text.type() == pugi::node_pcdata && !text.next_sibling())
            entries.push_back({node.name(), text.value()});
        return true;
    }
};

/// Both pictures, each of which can be read once.
class PhotoPictures final : public FrameSource {
public:
    PhotoPictures(std::string file, DepthPhoto photo) : file_(std::move(file)), photo_(std::move(photo)) {}
    std::string where(PlaneRole role, std::int64_t) const override {
        return file_ + ": " + std::string(role_name(role));
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t) override {
        return TrackPicture{std::move(role == PlaneRole::depth ? photo_.depth : photo_.colour)};
    }

private:
    std::string file_;
    DepthPhoto photo_;
};

void add_guess(Scene& scene, std::string what, Hints otherwise, RemarkKind kind) {
    add_remark(scene.remarks, {std::move(what), true, {}, std::move(otherwise), kind});
}

/// Sets the camera: as stated, the file's, from its focal length, or a guess.
void find_camera(const DepthPhoto& photo, const SourceDescription& known, Scene& scene) {
    const Hints otherwise{{Setting::field_of_view}, {Setting::intrinsics}};
    const int width = scene.width, height = scene.height;
    const Image& colour = photo.colour.image;
    if (known.intrinsics) {
        std::string doubt;
        const Intrinsics camera =
            (known.file.empty() ? in_pixels : trusted_intrinsics)(*known.intrinsics, width, height, doubt);
        if (!doubt.empty())
            add_remark(scene.remarks, {"the camera is that of " +
                                       (known.file.empty() ? "the numbers said"
                                                           : printable(known.file.filename().string())) +
                                       ", " + doubt});
        scene.camera = scaled_camera(camera, width, height);
    } else if (known.fov) {
        scene.camera = scaled_camera({.fov_x = *known.fov}, width, height);
    } else if (photo.camera) {
        scene.camera = scaled_camera(*photo.camera, width, height);
    } else if (photo.film_focal_length > 0) {
        const double w = colour.width, h = colour.height;
        const double focal_length = photo.film_focal_length / film_diagonal * std::sqrt(w * w + h * h);
        scene.camera = scaled_camera(
            {focal_length, focal_length, std::nullopt, std::nullopt, colour.width, colour.height}, width,
            height);
        add_guess(scene,
                  "the camera sees " + short_number(360 / pi * arctangent(0.5 * width / scene.camera.fx)) +
                      " degrees from left to right, by its focal length, " +
                      short_number(photo.film_focal_length) + " mm in terms of 35 mm film",
                  otherwise, RemarkKind::camera);
    } else {
        scene.camera = scaled_camera({.fov_x = usual_fov}, width, height);
        add_guess(scene, guessed_field_of_view(usual_fov), otherwise, RemarkKind::camera);
    }
}

/// The scene that a photograph's file states, with guesses for the rest.
Result<SceneDescription> described_photo(const std::filesystem::path& file, const DepthPhoto& photo,
                                         const SourceDescription& known) {
    SceneDescription described;
    Scene& scene = described.scene;
    scene.remarks = joined_remarks({}, photo.remarks);
    scene.name = file.stem().string();
    described.unstated.filters = all_unstated;
    scene.width = photo.depth.image.width;
    scene.height = photo.depth.image.height;
    scene.depth_bits = photo.depth.bits;
    scene.metres_per_unit = photo.metres_per_unit;
    scene.depth = photo.coding;
    if (!photo.has_scale) {
        scene.stored.kind = StoredDepth::Kind::relative;
        scene.metres_per_unit = 1;
        scene.depth.near = assumed_near;
        scene.depth.far = assumed_far;
        add_guess(scene,
                  "depth has no scale: its nearest is taken for " + short_number(assumed_near) +
                      " m and its farthest for " + short_number(assumed_far) + " m",
                  {}, RemarkKind::scale);
    }
    find_camera(photo, known, scene);
    derive_valid_range(scene.depth);
    const auto valid = validate(scene);
    if (valid) return described;
    if (!known.intrinsics && !known.fov) return error_at(file.string(), valid.error());
    return usage_error(file.string() + ": with the camera that was said: " + valid.error().message,
                       {{Setting::intrinsics}, {Setting::field_of_view}});
}

}  // namespace

Orientation Orientation::then(const Orientation& next) const {
    Orientation both = *this;
    if (next.transposed) {
        both.transposed = !both.transposed;
        std::swap(both.flipped_x, both.flipped_y);
    }
    both.flipped_x = both.flipped_x != next.flipped_x;
    both.flipped_y = both.flipped_y != next.flipped_y;
    return both;
}

Orientation exif_orientation(int number) {
    constexpr Orientation numbered[] = {{false, false, false}, {false, true, false}, {false, true, true},
                                        {false, false, true},  {true, false, false}, {true, true, false},
                                        {true, true, true},    {true, false, true}};
    return number >= 1 && number <= 8 ? numbered[number - 1] : Orientation{};
}

Image upright(const Image& stored, const Orientation& orientation) {
    Image image = stored;
    if (orientation == Orientation{}) return image;
    if (orientation.transposed) std::swap(image.width, image.height);
    const PlaneView from = stored.view();
    const std::ptrdiff_t pixel = static_cast<std::ptrdiff_t>(stored.channels) * stored.bytes_per_sample;
    std::uint8_t* to = image.samples.data();
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x, to += pixel) {
            int column = orientation.flipped_x ? image.width - 1 - x : x;
            int row = orientation.flipped_y ? image.height - 1 - y : y;
            if (orientation.transposed) std::swap(column, row);
            std::memcpy(to, from.row(row) + pixel * column, static_cast<std::size_t>(pixel));
        }
    }
    return image;
}

Intrinsics upright(const Intrinsics& stored, const Orientation& orientation) {
    Intrinsics turned = stored;
    if (orientation.transposed) {
        std::swap(turned.fx, turned.fy);
        std::swap(turned.cx, turned.cy);
        std::swap(turned.width, turned.height);
    }
    if (orientation.flipped_x && turned.cx) turned.cx = turned.width - 1 - *turned.cx;
    if (orientation.flipped_y && turned.cy) turned.cy = turned.height - 1 - *turned.cy;
    return turned;
}

ExifFacts parse_exif(std::string_view bytes) {
    ExifFacts facts;
    const Tiff tiff(bytes);
    if (!tiff.is_tiff()) return facts;
    const std::uint32_t first = tiff.first_directory();
    const std::uint32_t orientation = tiff.find(first, orientation_tag);
    if (orientation >= 1 && orientation <= 8) facts.orientation = static_cast<int>(orientation);
    if (const std::uint32_t exif = tiff.find(first, exif_directory_tag); exif > 0)
        facts.film_focal_length = tiff.find(exif, film_focal_length_tag);
    return facts;
}

std::optional<XmpEntries> parse_xmp_entries(std::string_view packet) {
    // Minimal: values are kept as written. A fragment: a packet may be empty.
    pugi::xml_document document;
    constexpr unsigned as_written = pugi::parse_minimal | pugi::parse_fragment;
    if (!document.load_buffer(packet.data(), packet.size(), as_written, pugi::encoding_utf8))
        return std::nullopt;
    EntryLister lister;
    document.traverse(lister);
    return std::move(lister.entries);
}

const std::string* xmp_value(const XmpEntries& xmp, std::string_view name) {
    const auto found = std::find_if(xmp.rbegin(), xmp.rend(),
                                    [&](const XmpEntry& entry) { return entry.value && entry.name == name; });
    return found == xmp.rend() ? nullptr : &*found->value;
}

std::optional<double> xmp_number(const XmpEntries& xmp, std::string_view name) {
    const std::string* const value = xmp_value(xmp, name);
    return value ? parsed_number(*value) : std::nullopt;
}

Opened open_depth_photo(const Candidate& candidate, DepthPhoto photo) {
    const std::filesystem::path& file = candidate.source.path();
    const SourceDescription& known = candidate.wanted.known;
    if (known.metres_per_code || !known.preset.empty() || known.semantics)
        return usage_error(file.string() +
                               ": says itself what its depths are, so a unit, a preset, range or planar say "
                               "nothing of it: leave them out",
                           {{Setting::depth_unit}, {Setting::preset}, {Setting::depth_kind}});
    photo.depth.image = upright(photo.depth.image, photo.depth_turn);
    photo.colour.image = upright(photo.colour.image, photo.colour_turn);
    TRY_ASSIGN(auto scene, candidate.scene ? Result<SceneDescription>(*candidate.scene)
                                           : described_photo(file, photo, known));
    StoredClip clip{file.string(), std::move(scene)};
    if (photo.colour_turn != Orientation{})
        clip.notes.emplace_back("the picture is turned upright, as its orientation says");
    clip.count = 1;
    clip.roles = {PlaneRole::depth, PlaneRole::colour};
    clip.inputs = {file};
    clip.pictures = std::make_unique<PhotoPictures>(file.string(), std::move(photo));
    return open_stored_clip(std::move(clip));
}

}  // namespace touchable
