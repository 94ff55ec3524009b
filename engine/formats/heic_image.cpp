#include "engine/formats/heic_image.hpp"

#include <libheif/heif.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/base/unless_stopped.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/formats/exif.hpp"
#include "engine/formats/heif_depth_meaning.hpp"
#include "engine/formats/heif_properties.hpp"

namespace touchable {
namespace {

template <auto release>
struct HeifRelease {
    template <class T>
    void operator()(T* object) const {
        release(object);
    }
};
using HeifContextPtr = std::unique_ptr<heif_context, HeifRelease<heif_context_free>>;
using HeifHandlePtr = std::unique_ptr<heif_image_handle, HeifRelease<heif_image_handle_release>>;
using HeifImagePtr = std::unique_ptr<heif_image, HeifRelease<heif_image_release>>;
using HeifOptionsPtr = std::unique_ptr<heif_decoding_options, HeifRelease<heif_decoding_options_free>>;
using HeifDepthInfoPtr =
    std::unique_ptr<const heif_depth_representation_info, HeifRelease<heif_depth_representation_info_free>>;

/// Nothing where the picture has no such channel.
std::optional<Image> packed_channel(const heif_image* image, heif_channel channel, int bytes, int samples) {
    int stride = 0;
    const std::uint8_t* from = heif_image_get_plane_readonly(image, channel, &stride);
    if (from == nullptr) return std::nullopt;
    Image packed{
        heif_image_get_width(image, channel), heif_image_get_height(image, channel), bytes, samples, {}};
    const auto row = static_cast<std::size_t>(packed.width) * static_cast<std::size_t>(bytes * samples);
    packed.samples.resize(row * static_cast<std::size_t>(packed.height));
    for (int y = 0; y < packed.height; ++y)
        std::memcpy(packed.samples.data() + row * static_cast<std::size_t>(y),
                    from + static_cast<std::ptrdiff_t>(stride) * y, row);
    return packed;
}

/// Of a picture that is grey: its chroma may be off by what an encoder loses.
bool is_neutral(const heif_image* image) {
    for (const heif_channel channel : {heif_channel_Cb, heif_channel_Cr}) {
        const int bits = heif_image_get_bits_per_pixel_range(image, channel);
        const auto chroma = packed_channel(image, channel, bits > 8 ? 2 : 1, 1);
        if (!chroma) continue;
        for (int y = 0; y < chroma->height; ++y)
            for (int x = 0; x < chroma->width; ++x)
                if (std::abs(chroma->view().sample(x, y) - (1 << (bits - 1))) > 1 << (bits - 4)) return false;
    }
    return true;
}

bool has_its_size(const Image& image, const heif_image_handle* handle) {
    return image.width == heif_image_handle_get_width(handle) &&
           image.height == heif_image_handle_get_height(handle);
}

class HeicImage {
public:
    HeicImage(std::string bytes, std::string where) : bytes_(std::move(bytes)), where_(std::move(where)) {}
    Result<DepthPhoto> read();

private:
    Error refuse(const std::string& what) const { return input_error(where_ + ": " + what); }
    Error damaged(const std::string& what, const Image& image) const {
        return refuse("is damaged: " + what + " is " + std::to_string(image.width) + "x" +
                      std::to_string(image.height) + ", not as it says");
    }
    Error refuse(const std::string& what, const heif_error& why) const {
        return refuse(what + ": " + printable(why.message));
    }
    Result<void> open();
    Result<void> limit_sizes();
    /// libheif refuses a picture of tiles whose side is the limit itself.
    void refuse_sides_beyond(int side) {
        heif_context_set_maximum_image_size_limit(context_.get(), side + 1);
    }
    Result<void> check_parts() const;
    Result<void> check_size(std::int64_t width, std::int64_t height, const std::string& what) const;
    Result<void> read_depth();
    Result<void> read_colour();
    void orient();
    std::string metadata(const heif_image_handle* handle, const char* type) const;
    std::string codec() const;

    std::string bytes_, where_;
    HeifContextPtr context_;
    HeifHandlePtr primary_, depth_;
    heif_item_id depth_id_ = 0;
    DepthPhoto photo_;
};

Result<DepthPhoto> HeicImage::read() {
    TRY(open());
    if (auto read = read_depth(); !read) return read.error();
    TRY(read_colour());
    const heif_depth_representation_info* info = nullptr;
    heif_image_handle_get_depth_image_representation_info(primary_.get(), depth_id_, &info);
    const HeifDepthInfoPtr owned(info);
    describe_heif_depth(info, metadata(depth_.get(), "mime"), photo_);
    orient();
    return std::move(photo_);
}

Result<void> HeicImage::open() {
    context_.reset(heif_context_alloc());
    refuse_sides_beyond(largest_picture_side);
    if (const auto error =
            heif_context_read_from_memory_without_copy(context_.get(), bytes_.data(), bytes_.size(), nullptr);
        error.code != heif_error_Ok)
        return refuse("is damaged or cut short", error);
    heif_image_handle* handle = nullptr;
    if (const auto error = heif_context_get_primary_image_handle(context_.get(), &handle);
        error.code != heif_error_Ok)
        return refuse("has no picture", error);
    primary_.reset(handle);
    if (heif_image_handle_get_list_of_depth_image_IDs(primary_.get(), &depth_id_, 1) != 1)
        return refuse(
            "has no depth beside its picture: must be a photo that was taken with depth (a portrait), the "
            "phone's own file and not one that was sent on or edited");
    if (const auto error = heif_image_handle_get_depth_image_handle(primary_.get(), depth_id_, &handle);
        error.code != heif_error_Ok)
        return refuse("has depth that cannot be read", error);
    depth_.reset(handle);
    if (auto checked = check_parts(); !checked) return checked;
    return limit_sizes();
}

/// libheif takes for granted that layers are there, and that no picture is a tile of itself; it decodes a
/// tile as often as it is named.
Result<void> HeicImage::check_parts() const {
    constexpr int most_nested = 4, most_decoded = 1 << 14;
    const HeifParts parts = read_heif_parts(bytes_);
    if (parts.has_layers)
        return refuse("has a picture of layers, which is not read: must be a photo as a phone stores it");
    int decoded = 0;
    const std::function<bool(heif_item_id, int)> ends = [&](heif_item_id id, int nested) {
        if (nested > most_nested || ++decoded > most_decoded) return false;
        const auto found = parts.tiles.find(id);
        return found == parts.tiles.end() ||
               std::all_of(found->second.begin(), found->second.end(),
                           [&](heif_item_id tile) { return ends(tile, nested + 1); });
    };
    for (const auto& [id, tiles] : parts.tiles)
        if (!ends(id, 0)) return refuse("is damaged: a picture in it has too many tiles, or itself as one");
    return {};
}

/// Pictures put together of tiles have one more size, in their own data: libheif holds that against a limit.
Result<void> HeicImage::limit_sizes() {
    std::int64_t largest = 0;
    const auto admit = [&](std::int64_t width, std::int64_t height, const std::string& what) {
        largest = std::max({largest, width, height});
        return check_size(width, height, what);
    };
    for (const CodedSize& size : read_heif_coded_sizes(bytes_))
        if (auto checked = admit(size.width, size.height, "a picture in it"); !checked) return checked;
    for (const auto& [picture, what] :
         {std::pair{primary_.get(), "its picture"}, {depth_.get(), "its depth"}})
        if (auto checked =
                admit(heif_image_handle_get_width(picture), heif_image_handle_get_height(picture), what);
            !checked)
            return checked;
    refuse_sides_beyond(static_cast<int>(largest));
    return {};
}

Result<void> HeicImage::check_size(std::int64_t width, std::int64_t height, const std::string& what) const {
    if (auto checked = check_picture_size(width, height, where_ + ": " + what); !checked) return checked;
    return check_expansion(3 * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height),
                           bytes_.size(), where_ + ": " + what);
}

/// Its luma as stored: never through a conversion of colours. Or green, where red and blue are the same.
Result<void> HeicImage::read_depth() {
    heif_image* decoded = nullptr;
    if (const auto error = heif_decode_image(depth_.get(), &decoded, heif_colorspace_undefined,
                                             heif_chroma_undefined, nullptr);
        error.code != heif_error_Ok)
        return refuse("its depth cannot be decoded", error);
    const HeifImagePtr image(decoded);
    const bool is_rgb = heif_image_get_colorspace(image.get()) == heif_colorspace_RGB;
    const heif_channel channel = is_rgb ? heif_channel_G : heif_channel_Y;
    StoredImage& depth = photo_.depth;
    depth.bits = heif_image_get_bits_per_pixel_range(image.get(), channel);
    if (depth.bits < 8 || depth.bits > 16)
        return refuse("its depth is of " + std::to_string(depth.bits) + " bits: must be of 8 to 16");
    depth.codec = codec();
    depth.pixel_format = depth.bits == 8 ? "gray" : "gray" + std::to_string(depth.bits) + "le";
    auto grey = packed_channel(image.get(), channel, depth.bits == 8 ? 1 : 2, 1);
    if (!grey) return refuse("its depth cannot be decoded");
    bool is_grey = is_neutral(image.get());
    for (const heif_channel other : {heif_channel_R, heif_channel_B}) {
        const auto colour = packed_channel(image.get(), other, grey->bytes_per_sample, 1);
        is_grey = is_grey && (!is_rgb || (colour && colour->samples == grey->samples));
    }
    if (!is_grey) return refuse("its depth is coloured: must be grey, or red, green and blue alike");
    if (!has_its_size(*grey, depth_.get())) return damaged("its depth", *grey);
    depth.image = std::move(*grey);
    return {};
}

Result<void> HeicImage::read_colour() {
    const HeifOptionsPtr options(heif_decoding_options_alloc());
    options->convert_hdr_to_8bit = 1;
    heif_image* decoded = nullptr;
    if (const auto error = heif_decode_image(primary_.get(), &decoded, heif_colorspace_RGB,
                                             heif_chroma_interleaved_RGB, options.get());
        error.code != heif_error_Ok)
        return refuse("its picture cannot be decoded", error);
    const HeifImagePtr image(decoded);
    auto rgb = packed_channel(image.get(), heif_channel_interleaved, 1, 3);
    if (!rgb) return refuse("its picture cannot be decoded");
    if (!has_its_size(*rgb, primary_.get())) return damaged("its picture", *rgb);
    photo_.colour.codec = codec();
    photo_.colour.pixel_format = "rgb24";
    photo_.colour.image = std::move(*rgb);
    return {};
}

/// libheif turned both as the file says of each. Depth of which it says nothing goes with the picture.
void HeicImage::orient() {
    heif_item_id primary_id = 0;
    heif_context_get_primary_image_ID(context_.get(), &primary_id);
    const auto turns = read_heif_turns(bytes_);
    const auto turn = turns.find(primary_id);
    if (turn != turns.end()) {
        if (!turns.contains(depth_id_)) photo_.depth_turn = turn->second;
        if (photo_.camera) photo_.camera = upright(*photo_.camera, turn->second);
    }
    const std::string exif = metadata(primary_.get(), "Exif");
    if (exif.size() < 4) return;
    std::size_t offset = 0;  // from after itself to the TIFF header
    for (std::size_t k = 0; k < 4; ++k) offset = offset << 8 | static_cast<unsigned char>(exif[k]);
    if (offset < exif.size() - 4)
        photo_.film_focal_length = parse_exif(std::string_view(exif).substr(4 + offset)).film_focal_length;
}

/// The first block of a type; empty where there is none.
std::string HeicImage::metadata(const heif_image_handle* handle, const char* type) const {
    heif_item_id id = 0;
    if (heif_image_handle_get_list_of_metadata_block_IDs(handle, type, &id, 1) != 1) return {};
    std::string bytes(heif_image_handle_get_metadata_size(handle, id), '\0');
    if (bytes.empty()) return {};
    return heif_image_handle_get_metadata(handle, id, bytes.data()).code == heif_error_Ok ? bytes
                                                                                          : std::string();
}

std::string HeicImage::codec() const {
    return bytes_.find("av1C") != std::string::npos && bytes_.find("hvcC") == std::string::npos ? "av1"
                                                                                                : "hevc";
}

}  // namespace

bool is_heif(std::string_view begin) {
    constexpr std::string_view brands[] = {"heic", "heix", "heim", "heis", "hevc", "hevx",
                                           "mif1", "mif2", "msf1", "avif", "avis"};
    return begin.size() >= 12 && begin.substr(4, 4) == "ftyp" &&
           std::find(std::begin(brands), std::end(brands), begin.substr(8, 4)) != std::end(brands);
}

Result<std::unique_ptr<ClipReader>> open_heic_image(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    const SourceDescription& known) {
    auto bytes = read_picture_bytes(file);
    if (!bytes) return bytes.error();
    auto read = unless_stopped([bytes = std::move(*bytes), where = file.string()]() mutable {
        try {  // libheif's own containers
            return HeicImage(std::move(bytes), where).read();
        } catch (const std::bad_alloc&) {
            return Result<DepthPhoto>(
                input_error(where + ": is damaged, or needs more memory than there is"));
        }
    });
    if (!read) return Error{ErrorKind::interrupted, "interrupted while " + file.string() + " was read"};
    if (!*read) return read->error();
    return open_depth_photo(file.path(), std::move(**read), described, known);
}

}  // namespace touchable
