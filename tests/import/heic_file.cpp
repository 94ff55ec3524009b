// SPDX-License-Identifier: Apache-2.0
#include "tests/import/heic_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/picture/picture_bytes.hpp"

namespace touchable::test {
namespace {

std::uint64_t number_at(const std::string& bytes, std::size_t at, std::size_t length) {
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < length; ++k)
        value = value << 8 | static_cast<unsigned char>(bytes.at(at + k));
    return value;
}

void check(const heif_error& error) {
    ASSERT_EQ(error.code, heif_error_Ok) << error.message;
}

heif_image* picture_of(const Image& from, int bits) {
    heif_image* image = nullptr;
    const bool grey = from.channels == 1;
    check(heif_image_create(from.width, from.height, grey ? heif_colorspace_monochrome : heif_colorspace_RGB,
                            grey ? heif_chroma_monochrome : heif_chroma_interleaved_RGB, &image));
    const heif_channel channel = grey ? heif_channel_Y : heif_channel_interleaved;
    check(heif_image_add_plane(image, channel, from.width, from.height, bits));
    int stride = 0;
    std::uint8_t* to = heif_image_get_plane(image, channel, &stride);
    const auto row = static_cast<std::size_t>(from.width * from.channels * from.bytes_per_sample);
    for (int y = 0; y < from.height; ++y)
        std::memcpy(to + static_cast<std::ptrdiff_t>(stride) * y, from.view().row(y), row);
    return image;
}

heif_error append(heif_context*, const void* data, std::size_t size, void* user) {
    static_cast<std::string*>(user)->append(static_cast<const char*>(data), size);
    return {heif_error_Ok, heif_suberror_Unspecified, "ok"};
}

/// Their ids, in the order they were written in.
std::vector<heif_item_id> pictures_of(const std::string& file) {
    heif_context* context = heif_context_alloc();
    check(heif_context_read_from_memory_without_copy(context, file.data(), file.size(), nullptr));
    std::vector<heif_item_id> ids(
        static_cast<std::size_t>(heif_context_get_number_of_top_level_images(context)));
    heif_context_get_list_of_top_level_image_IDs(context, ids.data(), static_cast<int>(ids.size()));
    heif_context_free(context);
    return ids;
}

std::string box(const std::string& type, const std::string& content) {
    return big_endian(content.size() + 8, 4) + type + content;
}

/// Calls work(type, content) for each box and puts together what it makes of their contents.
template <class Work>
std::string mapped_boxes(const std::string& boxes, Work&& work) {
    std::string made;
    for (std::size_t at = 0; at < boxes.size();) {
        const std::size_t length = number_at(boxes, at, 4);
        const std::string type = boxes.substr(at + 4, 4);
        made += box(type, work(type, boxes.substr(at + 8, length - 8)));
        at += length;
    }
    return made;
}

/// Adds an association of an item, one byte each as libheif writes them.
std::string associated(std::string ipma, std::uint64_t item, int property) {
    EXPECT_EQ(number_at(ipma, 0, 4), 0U) << "version and flags";
    std::size_t at = 8;
    while (number_at(ipma, at, 2) != item) at += 3 + number_at(ipma, at + 2, 1);
    const std::size_t count = number_at(ipma, at + 2, 1);
    ipma[at + 2] = static_cast<char>(count + 1);
    return ipma.insert(at + 3 + count, 1, static_cast<char>(0x80 | property));
}

/// Places in the file that moved.
std::string moved(std::string iloc, std::uint64_t by) {
    const std::uint64_t version = number_at(iloc, 0, 1), sizes = number_at(iloc, 4, 2);
    const std::size_t offset = sizes >> 12 & 15, length = sizes >> 8 & 15, base = sizes >> 4 & 15;
    EXPECT_LT(version, 2U);
    std::size_t at = 8;
    for (auto items = number_at(iloc, 6, 2); items > 0; --items) {
        const bool in_file = version == 0 || number_at(iloc, at + 2, 2) == 0;
        at += (version == 0 ? 4 : 6) + base;
        const auto extents = number_at(iloc, at, 2);
        at += 2;
        for (std::uint64_t k = 0; k < extents; ++k, at += offset + length)
            if (in_file)
                iloc.replace(at, offset,
                             big_endian(number_at(iloc, at, offset) + by, static_cast<int>(offset)));
    }
    return iloc;
}

std::string with_auxiliary(const std::string& file, std::uint64_t primary, std::uint64_t depth,
                           const std::string& subtypes, bool is_av1) {
    const std::string type =
        is_av1 ? "urn:mpeg:mpegB:cicp:systems:auxiliary:depth" : "urn:mpeg:hevc:2015:auxid:2";
    const std::string property = box("auxC", std::string(4, '\0') + type + '\0' + subtypes);
    const std::string reference =
        box("auxl", big_endian(depth, 2) + big_endian(1, 2) + big_endian(primary, 2));
    const auto changed_meta = [&](const std::string& meta, std::uint64_t by) {
        bool has_references = false;
        int properties = 0;
        std::string made = mapped_boxes(meta.substr(4), [&](const std::string& kind, std::string content) {
            if (kind == "iref") {
                has_references = true;
                return content + reference;
            }
            if (kind == "iloc") return moved(content, by);
            if (kind != "iprp") return content;
            return mapped_boxes(content, [&](const std::string& inner, const std::string& listed) {
                if (inner == "ipma") return associated(listed, depth, properties + 1);
                mapped_boxes(listed, [&](const std::string&, const std::string&) {
                    ++properties;
                    return std::string();
                });
                return listed + property;
            });
        });
        return meta.substr(0, 4) + made +
               (has_references ? std::string() : box("iref", std::string(4, '\0') + reference));
    };
    return mapped_boxes(file, [&](const std::string& kind, const std::string& content) {
        if (kind != "meta") return content;
        return changed_meta(content, changed_meta(content, 0).size() - content.size());
    });
}

/// The part of a picture from a place on; beyond its edges they are repeated.
Image tile_of(const Image& image, int left, int top, int side) {
    Image tile{side, side, 1, image.channels, {}};
    for (int y = top; y < top + side; ++y)
        for (int x = left; x < left + side; ++x)
            for (int channel = 0; channel < image.channels; ++channel)
                tile.samples.push_back(static_cast<std::uint8_t>(image.view().sample(
                    std::min(x, image.width - 1), std::min(y, image.height - 1), channel)));
    return tile;
}

/// Of pictures 1 to columns x rows, by rows, which are no pictures of their own from now on. Its data lies in
/// `idat`, as a phone has it; libheif has the like there for a picture of an odd size.
struct Grid {
    std::uint64_t item = 0;
    int columns = 0, rows = 0, width = 0, height = 0;

    std::uint64_t tiles() const { return static_cast<std::uint64_t>(columns * rows); }
    std::string data() const {
        return big_endian(0, 2) + big_endian(rows - 1, 1) + big_endian(columns - 1, 1) +
               big_endian(width, 2) + big_endian(height, 2);
    }
    std::string kinds(const std::string& iinf) const {
        EXPECT_EQ(number_at(iinf, 0, 1), 0U) << "version";
        std::uint64_t number = 0;
        const std::string listed = mapped_boxes(iinf.substr(6), [&](const std::string&, std::string kind) {
            if (++number <= tiles()) kind[3] = 1;  // hidden
            return kind;
        });
        return iinf.substr(0, 4) + big_endian(number_at(iinf, 4, 2) + 1, 2) + listed +
               box("infe", big_endian(2, 1) + big_endian(0, 3) + big_endian(item, 2) + big_endian(0, 2) +
                               "grid" + std::string(1, '\0'));
    }
    /// In version 1, which can say that it lies in `idat`.
    std::string places(const std::string& iloc, std::uint64_t begin) const {
        const std::uint64_t version = number_at(iloc, 0, 1), sizes = number_at(iloc, 4, 2);
        const std::size_t offset = sizes >> 12 & 15, length = sizes >> 8 & 15, base = sizes >> 4 & 15;
        EXPECT_EQ(sizes & 15, 0U) << "sizes of indices";
        std::string items = iloc.substr(8);
        if (version == 0)
            for (std::size_t at = 0; at < items.size();) {
                items.insert(at + 2, 2, '\0');
                at += 6 + base + 2 + number_at(items, at + 6 + base, 2) * (offset + length);
            }
        return big_endian(1, 1) + iloc.substr(1, 5) + big_endian(number_at(iloc, 6, 2) + 1, 2) + items +
               big_endian(item, 2) + big_endian(1, 2) + big_endian(0, 2) +
               big_endian(0, static_cast<int>(base)) + big_endian(1, 2) +
               big_endian(begin, static_cast<int>(offset)) +
               big_endian(data().size(), static_cast<int>(length));
    }
    std::string properties(const std::string& iprp) const {
        std::uint64_t known = 0;
        return mapped_boxes(iprp, [&](const std::string& kind, const std::string& content) {
            if (kind == "ipma")
                return content.substr(0, 4) + big_endian(number_at(content, 4, 4) + 1, 4) +
                       content.substr(8) + big_endian(item, 2) + big_endian(1, 1) + big_endian(known + 1, 1);
            mapped_boxes(content, [&](const std::string&, const std::string&) {
                ++known;
                return std::string();
            });
            return content + box("ispe", big_endian(0, 4) + big_endian(width, 4) + big_endian(height, 4));
        });
    }
    std::string references() const {
        std::string of_tiles;
        for (std::uint64_t tile = 1; tile <= tiles(); ++tile) of_tiles += big_endian(tile, 2);
        return box("dimg", big_endian(item, 2) + big_endian(tiles(), 2) + of_tiles);
    }
    std::string meta(const std::string& before, std::uint64_t moved_by) const {
        bool has_references = false;
        std::string in_meta;  // what has its data there already
        mapped_boxes(before.substr(4), [&](const std::string& kind, const std::string& content) {
            if (kind == "idat") in_meta = content;
            return std::string();
        });
        std::string made = mapped_boxes(before.substr(4), [&](const std::string& kind, std::string content) {
            if (kind == "idat") return content + data();
            if (kind == "pitm") return content.substr(0, 4) + big_endian(item, 2);
            if (kind == "iinf") return kinds(content);
            if (kind == "iloc") return places(moved(content, moved_by), in_meta.size());
            if (kind == "iprp") return properties(content);
            if (kind != "iref") return content;
            has_references = true;
            return content + references();
        });
        if (!has_references) made += box("iref", big_endian(0, 4) + references());
        return before.substr(0, 4) + made + (in_meta.empty() ? box("idat", data()) : std::string());
    }
    std::string in(const std::string& file) const {
        return mapped_boxes(file, [&](const std::string& kind, const std::string& content) {
            return kind == "meta" ? meta(content, meta(content, 0).size() - content.size()) : content;
        });
    }
};

class BitWriter {
public:
    void put(std::uint64_t value, int count) {
        for (int k = count - 1; k >= 0; --k) bits_.push_back((value >> k & 1) != 0);
    }
    /// Exp-Golomb.
    void put_unsigned(unsigned value) {
        int length = 0;
        while (value + 1 >= 2U << length) ++length;
        put(0, length);
        put(value + 1, length + 1);
    }
    /// Sign, exponent, and a mantissa of 24 bits.
    void put_real(double value) {
        int exponent = 0;
        const double fraction = std::frexp(std::abs(value), &exponent);  // 0.5 to 1
        put(value < 0 ? 1 : 0, 1);
        put(static_cast<std::uint64_t>(exponent - 1 + 31), 7);
        put(23, 5);
        put(static_cast<std::uint64_t>(std::lround((2 * fraction - 1) * 16777216)), 24);
    }
    std::string bytes() const {
        std::string bytes((bits_.size() + 7) / 8, '\0');
        for (std::size_t k = 0; k < bits_.size(); ++k)
            if (bits_[k]) bytes[k / 8] = static_cast<char>(bytes[k / 8] | 128 >> k % 8);
        return bytes;
    }

private:
    std::vector<bool> bits_;
};

}  // namespace

std::string depth_info_sei(const DepthInfo& info) {
    BitWriter writer;
    const double values[] = {info.z_near, info.z_far, info.d_min, info.d_max};
    for (const double value : values) writer.put(std::isnan(value) ? 0 : 1, 1);
    writer.put_unsigned(static_cast<unsigned>(info.type));
    if (!std::isnan(info.d_min) || !std::isnan(info.d_max)) writer.put_unsigned(0);
    for (const double value : values)
        if (!std::isnan(value)) writer.put_real(value);
    writer.put(1, 1);
    const std::string payload = writer.bytes();
    const std::string unit = std::string("\x4e\x01\xb1", 3) + static_cast<char>(payload.size()) + payload;
    const std::string sized = big_endian(unit.size(), 4) + unit;
    return big_endian(sized.size(), 4) + sized;
}

std::string HeicFile::bytes() const {
    heif_context* context = heif_context_alloc();
    heif_encoder* encoder = nullptr;
    check(heif_context_get_encoder_for_format(context, format, &encoder));
    heif_encoder_set_lossless(encoder, 1);
    heif_encoding_options* options = heif_encoding_options_alloc();
    heif_color_profile_nclx* luma = heif_nclx_color_profile_alloc();  // otherwise grey is made colour
    heif_nclx_color_profile_set_matrix_coefficients(luma, 1);
    const auto write = [&](const Image& picture, bool is_depth) {
        heif_image* image = picture_of(picture, is_depth ? depth_bits : 8);
        heif_image_handle* handle = nullptr;
        options->output_nclx_profile = is_depth && depth.channels == 1 ? luma : nullptr;
        options->image_orientation = is_depth ? depth_turn : colour_turn;
        check(heif_context_encode_image(context, image, encoder, options, &handle));
        const std::string& xmp = is_depth ? depth_xmp : std::string();
        if (!xmp.empty())
            check(heif_context_add_XMP_metadata(context, handle, xmp.data(), static_cast<int>(xmp.size())));
        if (!is_depth && !exif.empty())
            check(
                heif_context_add_exif_metadata(context, handle, exif.data(), static_cast<int>(exif.size())));
        heif_image_handle_release(handle);
        heif_image_release(image);
    };
    Grid grid;
    if (tile_side == 0) {
        write(colour, false);
    } else {
        const auto tiles = [&](int side) { return (side + tile_side - 1) / tile_side; };
        grid = {0, tiles(colour.width), tiles(colour.height), colour.width, colour.height};
        for (int row = 0; row < grid.rows; ++row)
            for (int column = 0; column < grid.columns; ++column)
                write(tile_of(colour, column * tile_side, row * tile_side, tile_side), false);
    }
    if (has_depth) write(depth, true);
    std::string file;
    heif_writer writer{1, append};
    check(heif_context_write(context, &writer, &file));
    heif_encoding_options_free(options);
    heif_nclx_color_profile_free(luma);
    heif_encoder_release(encoder);
    heif_context_free(context);
    const std::vector<heif_item_id> ids = pictures_of(file);
    heif_item_id primary = ids.front();
    if (tile_side > 0) {
        grid.item = 100;  // which no other has
        primary = 100;
        file = grid.in(file);
    }
    if (!has_depth) return file;
    return with_auxiliary(file, primary, ids.back(), depth_sei, format == heif_compression_AV1);
}

}  // namespace touchable::test
