// SPDX-License-Identifier: Apache-2.0
// Pictures of every kind, in memory.

#include <libheif/heif.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <set>

#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/formats/depth_values.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/organised_cloud.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"
#include "engine/scene/checked_json.hpp"
#include "engine/scene/scene.hpp"
#include "tests/fuzz/fuzz_target.hpp"
#include "tests/picture/picture_bytes.hpp"

namespace touchable::fuzz {
namespace {

template <Result<StoredImage> (*decode)(std::string_view, const std::string&)>
bool parse_picture(std::string_view bytes) {
    return is_picture(decode(bytes, "picture"));
}

std::uint32_t big_endian_at(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
    return value;
}

/// PNG's, of zlib's polynomial.
std::uint32_t png_crc(std::string_view bytes) {
    std::uint32_t crc = ~std::uint32_t{0};
    for (const char byte : bytes) {
        crc ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1U ? 0xedb88320U : 0U);
    }
    return ~crc;
}

/// The same with checksums that are right, so that damage is not found by them alone.
std::string with_right_checksums(std::string png) {
    constexpr std::size_t first_chunk = 8, around = 12;  // length, type and checksum
    for (std::size_t at = first_chunk; at + around <= png.size();) {
        const std::size_t size = big_endian_at(png, at);
        if (size > png.size() - at - around) break;
        const std::uint32_t crc = png_crc(std::string_view(png).substr(at + 4, size + 4));
        for (std::size_t k = 0; k < 4; ++k) png[at + 8 + size + k] = static_cast<char>(crc >> (24 - 8 * k));
        at += size + around;
    }
    return png;
}

bool parse_png(std::string_view bytes) {
    (void)is_picture(decode_coded_image(with_right_checksums(std::string(bytes)), "picture"));
    return is_picture(decode_coded_image(bytes, "picture"));
}

bool parse_exr(std::string_view bytes) {
    return is_picture(decode_exr(bytes, "picture"));
}

const Registered netpbm_target{
    {.name = "netpbm", .parse = parse_picture<decode_netpbm>, .cuts_are_refused = true}};
const Registered pfm_target{{.name = "pfm", .parse = parse_picture<decode_pfm>, .cuts_are_refused = true}};
const Registered npy_target{{.name = "npy", .parse = parse_picture<decode_npy>, .cuts_are_refused = true}};
const Registered npz_target{{.name = "npz", .parse = parse_picture<decode_npz>, .cuts_are_refused = true}};
const Registered tiff_target{
    {.name = "tiff", .parse = parse_picture<decode_tiff>, .cuts_are_refused = true, .needless_bytes = 4}};
const Registered exr_target{{.name = "exr", .parse = parse_exr, .cuts_are_refused = true}};
/// Tiles stand in any order, and what is cut off may be one that is not needed.
const Registered exr_tiled_target{{.name = "exr_tiled", .parse = parse_exr}};
/// All of a rendering together, and each by itself.
bool parse_exr_layers(std::string_view bytes) {
    const auto whole = decode_exr(bytes, "picture", {true, true});
    if (whole && whole->beside)
        for (const auto* beside : {&whole->beside->colour, &whole->beside->materials})
            if (*beside) (void)is_picture(Result<StoredImage>(**beside));
    const bool has_colour = is_picture(decode_exr_colour(bytes, "picture"));
    const bool has_materials = is_picture(decode_exr_materials(bytes, "picture"));
    return is_picture(whole) && (has_colour || has_materials);
}
const Registered exr_layers_target{
    {.name = "exr_layers", .parse = parse_exr_layers, .cuts_are_refused = true}};
const Registered png_target{{.name = "png", .parse = parse_png, .cuts_are_refused = true}};
const Registered jpeg_target{
    {.name = "jpeg", .parse = parse_picture<decode_coded_image>, .cuts_are_refused = true}};

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
    scene.stored.packed = is_metric && (coding & 0x10U) != 0 ? Packing::rgb24 : Packing::none;
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

// Messages about files that are not opened.

/// Under a name that says nothing, and under names of which only some say what the file is.
bool parse_foreign_file(std::string_view bytes) {
    bool is_known = false;
    for (const char* name : {"foreign", "foreign.bin", "foreign.zip"}) {
        const SourceFile file(file_of(bytes, name));
        const auto misleading = misleading_file(file, bytes.substr(0, 16)), what = foreign_file(file);
        require(!misleading || what == misleading, "two things are said of a file");
        if (what) require_readable({ErrorKind::input, name + (": " + *what)});
        is_known = is_known || what;
    }
    return is_known;
}

const Registered foreign_file_target{{.name = "foreign_file", .parse = parse_foreign_file}};

// The listing of h5ls of an HDF5 file, whose names and filters are the file's own.

bool parse_hdf5_listing(std::string_view bytes) {
    const auto sets = hdf5_data_sets(bytes);
    if (!is_taken(sets)) return false;
    std::set<std::string> paths;
    for (const Hdf5DataSet& set : *sets) {
        require(set.path.starts_with('/') && paths.insert(set.path).second, "a path is none, or there twice");
        require(set.shape.size() <= 32, "a data set has too many extents");
        for (const std::int64_t extent : set.shape)
            require(extent >= 0 && extent <= std::int64_t{1} << 31, "an extent is none");
        require(!set.format || (set.format->bytes >= 1 && set.format->bytes <= 8), "a number has no size");
    }
    return !sets->empty();
}

const Registered hdf5_listing_target{{.name = "hdf5_listing", .parse = parse_hdf5_listing}};

// HEIC: its boxes as we read them ourselves, what its depth stands for, and the whole.

bool parse_heif_boxes(std::string_view bytes) {
    const auto turns = read_heif_turns(bytes);
    const auto sizes = read_heif_coded_sizes(bytes);
    const auto parts = read_heif_parts(bytes);
    require(
        turns.size() <= bytes.size() && sizes.size() <= bytes.size() && parts.tiles.size() <= bytes.size(),
        "more pictures than bytes");
    return !turns.empty() || !sizes.empty() || !parts.tiles.empty();
}

/// Planes as the codec has them, then XMP.
bool parse_heif_depth(std::string_view bytes) {
    Taken taken(bytes);
    heif_depth_representation_info info{};
    const unsigned said = taken.byte();
    info.has_z_near = said & 1U;
    info.has_z_far = said >> 1 & 1U;
    info.has_d_min = said >> 2 & 1U;
    info.has_d_max = said >> 3 & 1U;
    info.depth_representation_type = static_cast<heif_depth_representation_type>(said >> 4 & 3U);
    for (double* number : {&info.z_near, &info.z_far, &info.d_min, &info.d_max}) *number = taken.number();
    DepthPhoto photo;
    photo.depth.image = {2, 2, 1, 1, {1, 2, 3, 4}};
    describe_heif_depth(said & 0x80U ? nullptr : &info,
                        parse_xmp_entries(taken.rest()).value_or(XmpEntries()), photo);
    require(!photo.has_scale || (std::isfinite(photo.coding.near) && photo.coding.near > 0 &&
                                 photo.coding.far > photo.coding.near),
            "depth has impossible planes");
    return photo.has_scale;
}

bool parse_heic(std::string_view bytes) {
    const Candidate file{file_of(bytes, "photo.heic")};
    return is_heif(file) && is_clip(open_heic_image(file));
}

const Registered heif_boxes_target{{.name = "heif_boxes", .parse = parse_heif_boxes}};
const Registered heif_depth_target{{.name = "heif_depth", .parse = parse_heif_depth}};
const Registered heic_target{{.name = "heic", .parse = parse_heic, .cuts_are_refused = true, .changes = 60}};

// Files beside pictures: descriptions of cameras, lists, and names.

void require_lens(const Intrinsics& lens) {
    require(std::isfinite(lens.fx) && std::isfinite(lens.fy), "a focal length is not finite");
    require(std::isfinite(lens.cx.value_or(0)) && std::isfinite(lens.cy.value_or(0)),
            "a principal point is not finite");
    require(lens.width >= 0 && lens.height >= 0, "a picture has a size below 0");
}

bool parse_camera_file(std::string_view bytes) {
    if (const auto found = intrinsics_in_json(std::string(bytes))) require_lens(*found);
    const auto camera = read_camera_file(file_of(bytes, "camera.txt"));
    if (!is_taken(camera)) return false;
    require_lens(camera->intrinsics);
    const Camera scaled = scaled_camera(camera->intrinsics, 64, 48);
    require(scaled.fx > 0 && scaled.fy > 0, "a focal length is not above 0");
    require(std::isfinite(camera->baseline) && std::isfinite(camera->offset) &&
                std::isfinite(camera->codes_per_metre) && camera->codes_per_metre >= 0,
            "a camera's number is not finite");
    return true;
}

bool parse_depthkit(std::string_view bytes) {
    const auto scene = read_depthkit_metadata(file_of(bytes, "clip.Metadata.asset"));
    if (!is_taken(scene)) return false;
    require(bool(validate(*scene)), "a scene cannot be");
    return true;
}

/// The video beside a description that is right.
bool parse_depthkit_video(std::string_view bytes) {
    static const std::filesystem::path description = [] {
        Target seeds{.name = "depthkit", .parse = nullptr};
        return file_of(seeds_of(seeds).front().bytes, "depthkit.Metadata.asset");
    }();
    const auto video = file_of(bytes, "depthkit.mov");
    require(depthkit_metadata_of(video) == description, "the description is not beside the video");
    return is_clip(open_depthkit_clip({video}));
}

/// A folder with a few pictures to be found.
const std::filesystem::path& folder_of_pictures() {
    static const std::filesystem::path folder = [] {
        const auto made = file_of("", "here").parent_path() / "pictures";
        std::filesystem::create_directories(made / "depth");
        for (const char* name : {"a1.png", "a2.png", "a10.png", "depth/1.500.png", "depth/2.png"})
            std::ofstream(made / name) << 'x';
        return made;
    }();
    return folder;
}

void require_places(const PictureFiles& pictures) {
    require(pictures.keys.empty() || pictures.keys.size() == pictures.files.size(),
            "keys are not the files'");
    for (const double key : pictures.keys) require(std::isfinite(key), "a time is not finite");
    const auto rate = rate_of(pictures);
    require(!rate || (rate->num > 0 && rate->den > 0), "a rate is not above 0");
}

bool parse_list(std::string_view bytes) {
    std::ofstream(folder_of_pictures() / "depth.txt", std::ios::binary) << bytes;
    FolderSource source;
    source.depth = "depth.txt";
    source.colour = "a*.png";
    const auto pictures = depth_files(folder_of_pictures(), source);
    if (!is_taken(pictures)) return false;
    require_places(*pictures);
    const auto beside = files_beside(folder_of_pictures(), PlaneRole::colour, source, *pictures);
    if (is_taken(beside)) require(beside->count() == pictures->count(), "not a file for each");
    return true;
}

/// The pattern of depth, that of colour, and the first number.
bool parse_pattern(std::string_view bytes) {
    Taken taken(bytes);
    FolderSource source;
    source.first = static_cast<int>(taken.byte());
    source.count = static_cast<int>(taken.byte());
    source.depth = taken.line();
    source.colour = taken.line();
    Scene scene = parse_scene(R"({"touchable_scene": 1, "width": 8, "height": 6,
        "camera": {"fx": 9, "fy": 9, "cx": 3, "cy": 2}, "depth": {"coding": "linear", "near": 1, "far": 2}})",
                              "scene.json")
                      ->scene;
    scene.folder = source;
    if (!is_taken(validate(scene))) return false;
    // Folders of others may be large, or their names devices.
    if (source.depth.find('/') != std::string::npos || source.colour.find('/') != std::string::npos)
        return false;
    const auto pictures = depth_files(folder_of_pictures(), source);
    if (!is_taken(pictures)) return false;
    require_places(*pictures);
    if (!source.colour.empty())
        (void)is_taken(files_beside(folder_of_pictures(), PlaneRole::colour, source, *pictures));
    return true;
}

const Registered camera_file_target{{.name = "camera_file", .parse = parse_camera_file}};
const Registered depthkit_target{{.name = "depthkit", .parse = parse_depthkit}};
const Registered depthkit_video_target{{.name = "depthkit_video",
                                        .parse = parse_depthkit_video,
                                        .cuts_are_refused = true,
                                        .changes = 60,
                                        .decodes_video = true}};
const Registered list_target{{.name = "picture_list", .parse = parse_list, .most_bytes = 1024}};
const Registered pattern_target{{.name = "picture_pattern", .parse = parse_pattern, .most_bytes = 128}};

// Parts of a JPEG beside its picture: segments, EXIF, XMP, a depth map.

bool parse_segments(std::string_view bytes) {
    const auto segments = app1_segments(bytes);
    std::size_t held = 0;
    for (const std::string_view segment : segments.value_or(std::vector<std::string_view>())) {
        require(
            segment.data() >= bytes.data() && segment.data() + segment.size() <= bytes.data() + bytes.size(),
            "a segment lies outside its file");
        held += segment.size();
    }
    require(held <= bytes.size(), "segments hold more than their file");
    const auto length = jpeg_length(bytes);
    require(!length || *length <= bytes.size(), "a picture is longer than its file");
    const auto xmp = read_jpeg_xmp(bytes, "photo.jpg");
    if (is_taken(xmp)) (void)is_taken(dynamic_depth_map(bytes, *xmp, "photo.jpg"));
    return segments && length;
}

void require_camera(const ExifFacts& facts) {
    require(facts.orientation >= 1 && facts.orientation <= 8, "an orientation that there is none");
    require(std::isfinite(facts.film_focal_length) && facts.film_focal_length >= 0, "no focal length");
}

bool parse_exif_facts(std::string_view bytes) {
    const ExifFacts facts = parse_exif(bytes);
    require_camera(facts);
    require_camera(read_jpeg_exif(bytes));
    return facts.orientation > 1 || facts.film_focal_length > 0;
}

bool parse_xmp_packet(std::string_view bytes) {
    const auto entries = parse_xmp_entries(bytes);
    if (entries) (void)dynamic_depth_camera(*entries);
    (void)decode_base64(bytes);
    require(decode_base64(test::encode_base64(bytes)) == bytes, "bytes in base64 come back others");
    return entries.has_value();
}

bool parse_jpeg_depth(std::string_view bytes) {
    const auto file = file_of(bytes, "photo.jpg");
    return has_jpeg_depth(file) && is_clip(open_jpeg_depth({file}));
}

const Registered segments_target{{.name = "jpeg_segments", .parse = parse_segments}};
const Registered exif_target{{.name = "exif", .parse = parse_exif_facts, .most_bytes = 512}};
const Registered xmp_target{{.name = "xmp", .parse = parse_xmp_packet}};
const Registered jpeg_depth_target{
    {.name = "jpeg_depth", .parse = parse_jpeg_depth, .cuts_are_refused = true, .changes = 120}};

/// The first picture, one of the middle and the last.
bool is_stack(ImageStack& stack) {
    require(stack.count() > 0, "a stack has no picture");
    for (const std::int64_t number : {std::int64_t{0}, stack.count() / 2, stack.count() - 1}) {
        const auto picture = stack.image(number);
        if (!is_picture(picture)) return false;
        require(picture->image.width == stack.width() && picture->image.height == stack.height(),
                "a picture is not of the stack's size");
    }
    return true;
}

/// `.npz` where it begins as one.
bool parse_npy_stack(std::string_view bytes) {
    auto stack = open_npy_stack(file_of(bytes, "stack.npy"));
    return is_taken(stack) && is_stack(**stack);
}

/// A TIFF with a single page is no stack, and not taken.
bool parse_tiff_stack(std::string_view bytes) {
    auto stack = open_tiff_stack(file_of(bytes, "stack.tif"));
    return is_taken(stack) && *stack && is_stack(**stack);
}

const Registered npy_stack_target{{.name = "npy_stack", .parse = parse_npy_stack, .cuts_are_refused = true}};
const Registered tiff_stack_target{
    {.name = "tiff_stack", .parse = parse_tiff_stack, .cuts_are_refused = true}};

// Organised clouds of points (PCD, PLY).

bool parse_cloud(std::string_view bytes) {
    (void)begins_organised_cloud(bytes);
    const auto cloud = decode_organised_cloud(bytes, "cloud");
    if (!is_taken(cloud)) return false;
    (void)is_picture(Result<StoredImage>(cloud->depth));
    if (cloud->depth.beside) (void)is_picture(Result<StoredImage>(*cloud->depth.beside->colour));
    for (const float depth : cloud->depth.values)
        require(std::isnan(depth) || depth > 0, "a depth is not ahead");
    if (!cloud->camera) return true;
    const Intrinsics& camera = *cloud->camera;
    require(camera.fx > 0 && camera.fy > 0 && std::isfinite(camera.fx + camera.fy + *camera.cx + *camera.cy),
            "a cloud's camera is none");
    return true;
}

const Registered organised_cloud_target{{.name = "organised_cloud", .parse = parse_cloud}};

/// A scene survives a round trip through text.
bool parse_scene_file(std::string_view bytes) {
    const auto scene = parse_scene(bytes, "scene.json");
    if (!is_taken(scene)) {
        require(scene.error().message.starts_with("scene.json"), "a scene is refused without its name");
        return false;
    }
    require(bool(validate(*scene)), "a scene that was read cannot be");
    const std::string text = scene_to_json(*scene);
    const auto again = parse_scene(text, "again");
    require(bool(again), again ? "" : "a scene that was written is refused: " + again.error().message);
    require(scene_to_json(*again) == text, "a scene is another one when it is read again");
    return true;
}

bool parse_json(std::string_view bytes) {
    try {
        const auto value = checked_json::parse(bytes);
        require(nlohmann::json::accept(bytes), "what is taken is no JSON");
        require(checked_json::parse(value.dump()) == value, "JSON is another when it is read again");
        return true;
    } catch (const checked_json::Refusal& refusal) {
        require_readable(input_error(refusal.message));
        require(refusal.message.find("line ") != std::string::npos, "JSON is refused without the line");
        return false;
    }
}

const Registered scene_target{{.name = "scene",
                               .parse = parse_scene_file,
                               .cuts_are_refused = true,
                               .changes = 600,
                               .most_bytes = 8192}};
const Registered json_target{{.name = "json", .parse = parse_json}};

}  // namespace
}  // namespace touchable::fuzz
