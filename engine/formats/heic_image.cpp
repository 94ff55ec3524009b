// SPDX-License-Identifier: Apache-2.0
// HEIC, HEIF and AVIF photographs: libheif decodes them (HeicImage); what it hides or mishandles is read from
// the file's boxes here.

#include <libheif/heif.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iterator>
#include <new>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/mpeg4/boxes.hpp"

namespace touchable {
namespace {

/// Limits for disparities to be reciprocal metres: a phone sees no nearer and no farther.
constexpr double nearest_of_phones = 0.02, farthest_of_phones = 500;  // metres

/// Reads big-endian numbers; once there are too few bytes, numbers are 0 and `at_end` is true.
class HeifBytes {
public:
    explicit HeifBytes(std::string_view bytes) : rest_(bytes) {}
    bool at_end() const { return rest_.empty(); }
    std::uint64_t number(std::size_t length) { return number_in_bytes(take(length)); }
    std::string_view take(std::size_t length) {
        if (length > rest_.size()) {
            rest_ = {};
            return {};
        }
        const auto taken = rest_.substr(0, length);
        rest_.remove_prefix(length);
        return taken;
    }

private:
    friend struct HeifBox;
    std::string_view rest_;
};

struct HeifBox {
    std::string_view type, content;

    static std::optional<HeifBox> next(HeifBytes& bytes) {
        const std::size_t available = bytes.rest_.size();
        if (available < 8) return std::nullopt;
        std::uint64_t length = bytes.number(4), header = 8;
        HeifBox box;
        box.type = bytes.take(4);
        if (length == 1) {
            length = bytes.number(8);
            header = 16;
        }
        if (length == 0) length = available;  // to the end of its container
        if (length < header || length > available) return std::nullopt;
        box.content = bytes.take(static_cast<std::size_t>(length - header));
        return box;
    }
};

/// Content of the first box of a type; empty if there is none.
std::string_view find_box(std::string_view within, std::string_view type) {
    HeifBytes bytes(within);
    while (const auto box = HeifBox::next(bytes))
        if (box->type == type) return box->content;
    return {};
}

std::string_view without_version(std::string_view full_box) {
    return full_box.size() < 4 ? std::string_view() : full_box.substr(4);
}

/// The orientation of a property that turns (irot: quarter turns left) or mirrors (imir); otherwise nothing.
std::optional<Orientation> turn_of(const HeifBox& property) {
    const int value = property.content.empty() ? 0 : property.content[0] & 3;
    constexpr int exif_of_left_turns[] = {1, 8, 3, 6};
    if (property.type == "irot") return exif_orientation(exif_of_left_turns[value]);
    if (property.type == "imir") return exif_orientation((value & 1) != 0 ? 2 : 4);
    return std::nullopt;
}

/// An H.265 unit without the bytes that prevent start codes in it.
std::vector<std::uint8_t> unescaped(std::string_view unit) {
    std::vector<std::uint8_t> bytes;
    int zeros = 0;
    for (const char byte : unit) {
        const bool is_inserted = byte == 3 && zeros >= 2;
        zeros = byte == 0 ? zeros + 1 : 0;
        if (!is_inserted) bytes.push_back(static_cast<std::uint8_t>(byte));
    }
    return bytes;
}

/// The size in a sequence parameter set (H.265, 7.3.2.2).
CodedSize size_of_sequence(std::string_view unit) {
    constexpr int unit_header = 16, profile = 88, level = 8;  // bits
    const std::vector<std::uint8_t> bytes = unescaped(unit);
    mpeg4::BitReader bits(bytes);
    bits.get(unit_header + 4);
    const int layers = static_cast<int>(bits.get(3));  // above the first
    bits.get(1 + profile + level);
    int of_layers = 0;
    for (int k = 0; k < layers; ++k) {
        if (bits.flag()) of_layers += profile;
        if (bits.flag()) of_layers += level;
    }
    if (layers > 0) bits.get(2 * (8 - layers));
    bits.get(of_layers);
    bits.golomb();                        // number of the set
    if (bits.golomb() == 3) bits.get(1);  // 4:4:4: whether its planes are separate
    const auto side = [&] { return static_cast<std::uint32_t>(std::min<std::uint64_t>(bits.golomb(), ~0U)); };
    const std::uint32_t width = side();
    return {width, side()};
}

bool is_range(double least, double most) {
    return std::isfinite(least) && std::isfinite(most) && least < most;
}

void set_depths(DepthPhoto& photo, DepthCodingKind kind, bool near_is_high, double near, double far) {
    photo.has_scale = true;
    photo.coding.kind = kind;
    photo.coding.near_is_high = near_is_high;
    photo.coding.near = near;
    photo.coding.far = far;
}

/// Takes the disparities of code 0 and of the largest code as reciprocal metres; false if they cannot be.
bool take_disparities(DepthPhoto& photo, double least, double most) {
    if (!is_range(least, most) || least <= 0) return false;
    const double near = 1 / most, far = 1 / least;
    if (near < nearest_of_phones || far > farthest_of_phones) return false;
    set_depths(photo, DepthCodingKind::inverse, true, near, far);
    return true;
}

/// The nine numbers of Apple's matrix, column by column: fx 0 0, 0 fy 0, cx cy 1.
std::optional<Intrinsics> apple_camera(const XmpEntries& xmp) {
    std::vector<double> matrix;
    bool inside = false;
    for (const XmpEntry& entry : xmp) {
        if (!entry.value && entry.name.starts_with("depthData:"))
            inside = entry.name == "depthData:IntrinsicMatrix";
        if (inside && entry.name == "rdf:li" && entry.value)
            matrix.push_back(parsed_number(*entry.value).value_or(0));
    }
    const auto width = xmp_number(xmp, "depthData:IntrinsicMatrixReferenceWidth"),
               height = xmp_number(xmp, "depthData:IntrinsicMatrixReferenceHeight");
    if (matrix.size() != 9 || !(matrix[0] > 0) || !(matrix[4] > 0) || !is_xmp_side(width) ||
        !is_xmp_side(height))
        return std::nullopt;
    return Intrinsics{
        matrix[0], matrix[4], matrix[6], matrix[7], static_cast<int>(*width), static_cast<int>(*height)};
}

/// Sets the coding from Apple's metadata; false if they do not tell the depths.
bool describe_by_apple(const XmpEntries& xmp, DepthPhoto& photo) {
    const auto least = xmp_number(xmp, "apdi:FloatMinValue"), most = xmp_number(xmp, "apdi:FloatMaxValue");
    const std::string* const type = xmp_value(xmp, "apdi:AuxiliaryImageType");
    photo.camera = apple_camera(xmp);
    if (!least || !most || !type) return false;
    if (*type == "depth" && *least > 0 && is_range(*least, *most)) {
        set_depths(photo, DepthCodingKind::linear, false, *least, *most);
        return true;
    }
    if (*type != "disparity" || !take_disparities(photo, *least, *most)) return false;
    const std::string* const accuracy = xmp_value(xmp, "depthData:Accuracy");
    if (accuracy && *accuracy == "relative")
        add_remark(photo.remarks, {"its depths are right among each other, says the camera; in metres they "
                                   "may be larger or smaller all together"});
    return true;
}

/// The codec's representation of depth; nothing for a number without a meaning in H.265. libheif passes any
/// number on: until it is checked, only its bytes may be read, not the enumerator.
std::optional<heif_depth_representation_type> representation(const heif_depth_representation_info& info) {
    std::underlying_type_t<heif_depth_representation_type> number;
    std::memcpy(&number, &info.depth_representation_type, sizeof number);
    if (number > heif_depth_representation_type_nonuniform_disparity) return std::nullopt;
    return info.depth_representation_type;
}

/// Sets the coding from the codec's metadata; false if they do not tell the depths.
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
                    true,
                    {},
                    {},
                    RemarkKind::unit});
        return true;
    }
    if (!info.has_d_min || !info.has_d_max || !take_disparities(photo, info.d_min, info.d_max)) return false;
    add_remark(photo.remarks,
               {"its disparities are 1/metres, as Apple writes them", true, {}, {}, RemarkKind::unit});
    return true;
}

using HeifContextPtr = std::unique_ptr<heif_context, ReleasedBy<heif_context_free>>;
using HeifHandlePtr = std::unique_ptr<heif_image_handle, ReleasedBy<heif_image_handle_release>>;
using HeifImagePtr = std::unique_ptr<heif_image, ReleasedBy<heif_image_release>>;
using HeifOptionsPtr = std::unique_ptr<heif_decoding_options, ReleasedBy<heif_decoding_options_free>>;
using HeifDepthInfoPtr =
    std::unique_ptr<const heif_depth_representation_info, ReleasedBy<heif_depth_representation_info_free>>;

/// Copies a channel without padding; nothing if the picture has no such channel.
std::optional<Image> packed_channel(const heif_image* image, heif_channel channel, int bytes, int samples) {
    int stride = 0;
    const std::uint8_t* from = heif_image_get_plane_readonly(image, channel, &stride);
    if (from == nullptr) return std::nullopt;
    return packed_image({from, stride, heif_image_get_width(image, channel),
                         heif_image_get_height(image, channel), bytes, samples});
}

/// Whether a picture is grey: its chroma may be off by what an encoder loses.
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

    Result<DepthPhoto> read() {
        TRY(open());
        TRY(read_depth());
        TRY(read_colour());
        const heif_depth_representation_info* info = nullptr;
        heif_image_handle_get_depth_image_representation_info(primary_.get(), depth_id_, &info);
        const HeifDepthInfoPtr owned(info);
        describe_heif_depth(info, parse_xmp_entries(metadata(depth_.get(), "mime")).value_or(XmpEntries()),
                            photo_);
        orient();
        return std::move(photo_);
    }

private:
    Error refuse(const std::string& what) const { return input_error(where_ + ": " + what); }
    Error damaged(const std::string& what, const Image& image) const {
        return refuse("is damaged: " + what + " is " + size_text(image.width, image.height) +
                      ", not as it says");
    }
    Result<void> done(const heif_error& made, const std::string& what) const {
        return made.code == heif_error_Ok ? Result<void>{} : refuse(what + ": " + printable(made.message));
    }

    Result<void> open() {
        context_.reset(heif_context_alloc());
        refuse_sides_beyond(largest_picture_side);
        TRY(done(
            heif_context_read_from_memory_without_copy(context_.get(), bytes_.data(), bytes_.size(), nullptr),
            "is damaged or cut short"));
        heif_image_handle* handle = nullptr;
        TRY(done(heif_context_get_primary_image_handle(context_.get(), &handle), "has no picture"));
        primary_.reset(handle);
        if (heif_image_handle_get_list_of_depth_image_IDs(primary_.get(), &depth_id_, 1) != 1)
            return refuse(
                "has no depth beside its picture: must be a photo that was taken with depth (a portrait), "
                "the phone's own file and not one that was sent on or edited");
        TRY(done(heif_image_handle_get_depth_image_handle(primary_.get(), depth_id_, &handle),
                 "has depth that cannot be read"));
        depth_.reset(handle);
        TRY(check_parts());
        return limit_sizes();
    }

    /// Checks all sizes and limits libheif to the largest: a picture of tiles has one more size, in its own
    /// data, which only libheif checks.
    Result<void> limit_sizes() {
        std::int64_t largest = 0;
        const auto admit = [&](std::int64_t width, std::int64_t height, const std::string& what) {
            largest = std::max({largest, width, height});
            return check_size(width, height, what);
        };
        for (const CodedSize& size : read_heif_coded_sizes(bytes_))
            TRY(admit(size.width, size.height, "a picture in it"));
        for (const auto& [picture, what] :
             {std::pair{primary_.get(), "its picture"}, {depth_.get(), "its depth"}})
            TRY(admit(heif_image_handle_get_width(picture), heif_image_handle_get_height(picture), what));
        refuse_sides_beyond(static_cast<int>(largest));
        return {};
    }

    /// libheif refuses a picture of tiles whose side is the limit itself.
    void refuse_sides_beyond(int side) {
        heif_context_set_maximum_image_size_limit(context_.get(), side + 1);
    }

    /// libheif assumes that layers exist and that no picture is a tile of itself, and decodes a tile as often
    /// as it is named: refuses such files.
    Result<void> check_parts() const {
        constexpr int most_nested = 4, most_decoded = 1 << 14;
        const HeifParts parts = read_heif_parts(bytes_);
        if (parts.has_layers)
            return refuse("has a picture of layers, which is not read: must be a photo as a phone stores it");
        int decoded = 0;
        const std::function<bool(heif_item_id, int)> ends = [&](heif_item_id id, int nested) {
            if (nested > most_nested || ++decoded > most_decoded) return false;
            const auto found = parts.tiles.find(id);
            return found == parts.tiles.end() || std::ranges::all_of(found->second, [&](heif_item_id tile) {
                       return ends(tile, nested + 1);
                   });
        };
        for (const auto& [id, tiles] : parts.tiles)
            if (!ends(id, 0))
                return refuse("is damaged: a picture in it has too many tiles, or itself as one");
        return {};
    }

    Result<void> check_size(std::int64_t width, std::int64_t height, const std::string& what) const {
        TRY(check_picture_size(width, height, where_ + ": " + what));
        return check_expansion(3 * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height),
                               bytes_.size(), where_ + ": " + what);
    }

    /// Reads depth's luma as stored; or green, where libheif makes RGB of colour, if red and blue are the
    /// same.
    Result<void> read_depth() {
        heif_image* decoded = nullptr;
        TRY(done(heif_decode_image(depth_.get(), &decoded, heif_colorspace_undefined, heif_chroma_undefined,
                                   nullptr),
                 "its depth cannot be decoded"));
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

    Result<void> read_colour() {
        const HeifOptionsPtr options(heif_decoding_options_alloc());
        options->convert_hdr_to_8bit = 1;
        heif_image* decoded = nullptr;
        TRY(done(heif_decode_image(primary_.get(), &decoded, heif_colorspace_RGB, heif_chroma_interleaved_RGB,
                                   options.get()),
                 "its picture cannot be decoded"));
        const HeifImagePtr image(decoded);
        auto rgb = packed_channel(image.get(), heif_channel_interleaved, 1, 3);
        if (!rgb) return refuse("its picture cannot be decoded");
        if (!has_its_size(*rgb, primary_.get())) return damaged("its picture", *rgb);
        photo_.colour.codec = codec();
        photo_.colour.pixel_format = "rgb24";
        photo_.colour.image = std::move(*rgb);
        return {};
    }

    /// libheif turned both as the file says. Depth without turns of its own gets those of the picture.
    void orient() {
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
        const std::uint64_t offset = HeifBytes(exif).number(4);  // from behind this number to the TIFF header
        if (offset < exif.size() - 4)
            photo_.film_focal_length =
                parse_exif(std::string_view(exif).substr(4 + static_cast<std::size_t>(offset)))
                    .film_focal_length;
    }

    /// The first metadata block of a type; empty if there is none.
    std::string metadata(const heif_image_handle* handle, const char* type) const {
        heif_item_id id = 0;
        if (heif_image_handle_get_list_of_metadata_block_IDs(handle, type, &id, 1) != 1) return {};
        std::string bytes(heif_image_handle_get_metadata_size(handle, id), '\0');
        if (bytes.empty()) return {};
        return heif_image_handle_get_metadata(handle, id, bytes.data()).code == heif_error_Ok ? bytes
                                                                                              : std::string();
    }

    std::string codec() const {
        return bytes_.find("av1C") != std::string::npos && bytes_.find("hvcC") == std::string::npos ? "av1"
                                                                                                    : "hevc";
    }

    std::string bytes_, where_;
    HeifContextPtr context_;
    HeifHandlePtr primary_, depth_;
    heif_item_id depth_id_ = 0;
    DepthPhoto photo_;
};

}  // namespace

bool is_heif(const Candidate& file) {
    const std::string_view begin = file.begin;
    constexpr std::string_view brands[] = {"heic", "heix", "heim", "heis", "hevc", "hevx",
                                           "mif1", "mif2", "msf1", "avif", "avis"};
    return begin.size() >= 12 && begin.substr(4, 4) == "ftyp" &&
           std::ranges::count(brands, begin.substr(8, 4)) > 0;
}

Opened open_heic_image(const Candidate& file) {
    TRY_ASSIGN(auto whole, read_picture_bytes(file.source));
    auto read = unless_stopped([bytes = std::move(whole), where = file.source.string()]() mutable {
        try {  // libheif's own containers may throw
            return HeicImage(std::move(bytes), where).read();
        } catch (const std::bad_alloc&) {
            return Result<DepthPhoto>(
                input_error(where + ": is damaged, or needs more memory than there is"));
        }
    });
    if (!read) return interrupted_error();
    TRY_ASSIGN(auto photo, std::move(*read));
    return open_depth_photo(file, std::move(photo));
}

std::map<std::uint32_t, Orientation> read_heif_turns(std::string_view file) {
    const std::string_view properties = find_box(without_version(find_box(file, "meta")), "iprp");
    std::vector<HeifBox> all;
    HeifBytes listed(find_box(properties, "ipco"));
    while (const auto box = HeifBox::next(listed)) all.push_back(*box);
    std::map<std::uint32_t, Orientation> turns;
    HeifBytes links(find_box(properties, "ipma"));
    const auto version = links.number(1), flags = links.number(3), items = links.number(4);
    for (std::uint64_t k = 0; k < items && !links.at_end(); ++k) {
        const auto item = static_cast<std::uint32_t>(links.number(version < 1 ? 2 : 4));
        for (auto left = links.number(1); left > 0; --left) {
            const bool is_long = (flags & 1) != 0;
            const std::uint64_t index = links.number(is_long ? 2 : 1) & (is_long ? 0x7fffU : 0x7fU);
            if (index < 1 || index > all.size()) continue;
            if (const auto turn = turn_of(all[static_cast<std::size_t>(index - 1)]))
                turns[item] = turns[item].then(*turn);
        }
    }
    return turns;
}

/// Finds boxes by name, not by the boxes around them: libheif also reads boxes with wrong lengths.
std::vector<CodedSize> read_heif_coded_sizes(std::string_view file) {
    constexpr std::string_view name = "hvcC", version = "\x01";
    constexpr std::size_t most_boxes = 4096, most_bytes = 4096, fixed_bytes = 22;
    constexpr std::uint64_t sequence_unit = 33;
    std::vector<CodedSize> sizes;
    std::size_t boxes = 0;
    for (auto at = file.find(name); at < file.size() && boxes < most_boxes; at = file.find(name, at + 1)) {
        const std::string_view content = file.substr(at + name.size(), most_bytes);
        if (!content.starts_with(version)) continue;
        ++boxes;
        HeifBytes bytes(content);
        bytes.take(fixed_bytes);
        for (auto kinds = bytes.number(1); kinds > 0 && !bytes.at_end(); --kinds) {
            const std::uint64_t kind = bytes.number(1) & 63U;
            for (auto units = bytes.number(2); units > 0 && !bytes.at_end(); --units) {
                const std::string_view unit = bytes.take(static_cast<std::size_t>(bytes.number(2)));
                if (kind == sequence_unit) sizes.push_back(size_of_sequence(unit));
            }
        }
    }
    return sizes;
}

/// Finds boxes by name within their containers' lengths, as picture data may have such names by chance. A
/// container with an invalid length goes to the end of the file.
HeifParts read_heif_parts(std::string_view file) {
    constexpr std::size_t name_bytes = 4, most_parts = 1 << 15;
    HeifParts parts;
    std::size_t end_of_kinds = 0, end_of_references = 0, id_bytes = 2, found = 0;
    const auto end_of = [&](std::size_t at) {
        const std::size_t begin = at - name_bytes, left = file.size() - begin;
        const auto length = HeifBytes(file.substr(begin, name_bytes)).number(name_bytes);
        return begin + (length > 2 * name_bytes && length <= left ? static_cast<std::size_t>(length) : left);
    };
    for (std::size_t at = name_bytes; at + name_bytes <= file.size() && found < most_parts; ++at) {
        const std::string_view name = file.substr(at, name_bytes);
        if (name == "iinf") {
            end_of_kinds = std::max(end_of_kinds, end_of(at));
        } else if (name == "iden" || name == "iovl") {
            parts.has_layers = parts.has_layers || at < end_of_kinds;
        } else if (name == "iref") {
            end_of_references = std::max(end_of_references, end_of(at));
            id_bytes = at + name_bytes < file.size() && file[at + name_bytes] != 0 ? 4 : 2;
        } else if (name == "dimg" && at < end_of_references) {
            HeifBytes bytes(file.substr(at + name_bytes));
            auto& made_of = parts.tiles[static_cast<std::uint32_t>(bytes.number(id_bytes))];
            ++found;
            for (auto count = bytes.number(2); count > 0 && !bytes.at_end() && found < most_parts;
                 --count, ++found)
                made_of.push_back(static_cast<std::uint32_t>(bytes.number(id_bytes)));
        }
    }
    return parts;
}

void describe_heif_depth(const heif_depth_representation_info* info, const XmpEntries& xmp,
                         DepthPhoto& photo) {
    photo.coding.semantics = DepthSemantics::planar;
    photo.coding.code_max = static_cast<std::uint16_t>((1 << photo.depth.bits) - 1);
    if (describe_by_apple(xmp, photo)) return;
    const auto type = info != nullptr ? representation(*info) : std::nullopt;
    if (type && describe_by_codec(*info, *type, photo)) return;
    photo.has_scale = false;
    photo.coding.near_is_high = type.value_or(heif_depth_representation_type_uniform_disparity) !=
                                heif_depth_representation_type_uniform_Z;
    photo.coding.kind = photo.coding.near_is_high ? DepthCodingKind::inverse : DepthCodingKind::linear;
}

}  // namespace touchable
