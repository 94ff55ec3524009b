// SPDX-License-Identifier: Apache-2.0
// JPEG photographs with a depth map: their segments, their XMP, the map in it or behind the picture
// (JpegDepth).

#include <iterator>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"

namespace touchable {
namespace {

using namespace std::string_view_literals;

constexpr char app1 = '\xe1', start_of_scan = '\xda', end_of_image = '\xd9';

/// Goes from segment to segment; skips coded data, in which only restart markers occur.
class SegmentReader {
public:
    explicit SegmentReader(std::string_view jpeg) : all_(jpeg) {
        if (all_.starts_with("\xff\xd8"sv)) at_ = 2;
    }
    /// Returns the marker of the next segment and sets `content`; nothing if the segment is cut.
    std::optional<char> next() {
        if (at_ == 0) return std::nullopt;
        if (in_scan_) skip_coded();
        while (at_ + 1 < all_.size() && all_[at_] == '\xff' && all_[at_ + 1] == '\xff') ++at_;  // fill
        if (at_ + 2 > all_.size() || all_[at_] != '\xff') return std::nullopt;
        const char marker = all_[at_ + 1];
        at_ += 2;
        content = {};
        if (marker == end_of_image) return marker;
        if (at_ + 2 > all_.size()) return std::nullopt;
        std::size_t length = number_in_bytes(all_.substr(at_, 2));  // of itself and the content
        if (marker == start_of_scan) length = std::min(length, all_.size() - at_);  // its picture is cut
        if (length < 2 || length > all_.size() - at_) return std::nullopt;
        content = all_.substr(at_ + 2, length - 2);
        at_ += length;
        in_scan_ = marker == start_of_scan;
        return marker;
    }
    std::size_t position() const { return at_; }

    std::string_view content;

private:
    void skip_coded() {
        in_scan_ = false;
        for (at_ = all_.find('\xff', at_); at_ < all_.size(); at_ = all_.find('\xff', at_ + 1)) {
            const auto marker = static_cast<unsigned char>(at_ + 1 < all_.size() ? all_[at_ + 1] : 0);
            if (marker != 0 && marker != 0xff && (marker < 0xd0 || marker > 0xd7)) return;
        }
        at_ = all_.size();
    }

    std::string_view all_;
    std::size_t at_ = 0;
    bool in_scan_ = false;
};

constexpr std::string_view packet_header = "http://ns.adobe.com/xap/1.0/\0"sv;
constexpr std::string_view extension_header = "http://ns.adobe.com/xmp/extension/\0"sv;
constexpr std::size_t guid_length = 32;

struct Piece {
    std::size_t whole = 0, offset = 0;
    std::string_view bytes;
};

/// Pieces of the extended packet named `guid`, by offset.
std::vector<Piece> pieces_of(const std::vector<std::string_view>& segments, std::string_view guid) {
    std::vector<Piece> pieces;
    for (std::string_view segment : segments) {
        if (!segment.starts_with(extension_header)) continue;
        segment.remove_prefix(extension_header.size());
        if (segment.size() < guid_length + 8 || segment.substr(0, guid_length) != guid) continue;
        pieces.push_back({number_in_bytes(segment.substr(guid_length, 4)),
                          number_in_bytes(segment.substr(guid_length + 4, 4)),
                          segment.substr(guid_length + 8)});
    }
    std::ranges::sort(pieces, {}, &Piece::offset);
    return pieces;
}

/// The packet; an error unless the pieces have every byte of it once.
Result<std::string> joined(const std::vector<Piece>& pieces, const std::string& where) {
    if (pieces.empty())
        return input_error(where + ": its XMP names an extended packet that is not in the file");
    std::string packet;
    for (const Piece& piece : pieces) {
        if (piece.whole != pieces.front().whole)
            return input_error(where + ": pieces of its extended XMP disagree on its length");
        if (piece.offset != packet.size())
            return input_error(where + ": its extended XMP has " +
                               (piece.offset > packet.size() ? "a gap" : "pieces that overlap") +
                               " at byte " + std::to_string(std::min(piece.offset, packet.size())));
        packet += piece.bytes;
    }
    if (packet.size() == pieces.front().whole) return packet;
    return input_error(where + ": its extended XMP is " + std::to_string(packet.size()) + " bytes, not " +
                       std::to_string(pieces.front().whole) + " as it says");
}

/// A picture of the directory. The first is the JPEG itself.
struct Item {
    std::string uri, semantic;
    std::size_t length = 0, padding = 0;
};

std::size_t byte_count(const std::string& text) {
    const auto value = parsed_number(text);
    return value && *value >= 0 && *value < 1e12 ? static_cast<std::size_t>(*value) : 0;
}

std::vector<Item> directory(const XmpEntries& xmp) {
    std::vector<Item> items;
    bool in_list = false;
    for (const XmpEntry& entry : xmp) {
        if (!entry.value) {
            if (entry.name == "Container:Directory") in_list = true;
            if (in_list && entry.name == "rdf:li") items.emplace_back();
        } else if (!items.empty()) {
            Item& item = items.back();
            if (entry.name == "Item:DataURI") item.uri = *entry.value;
            if (entry.name == "Item:Semantic") item.semantic = *entry.value;
            if (entry.name == "Item:Length") item.length = byte_count(*entry.value);
            if (entry.name == "Item:Padding") item.padding = byte_count(*entry.value);
        }
    }
    return items;
}

bool begins_picture(std::string_view bytes) {
    return bytes.starts_with("\xff\xd8\xff") || bytes.starts_with("\x89PNG");
}

/// Prefixes of a depth map's properties, for a map in the XMP and for one after the picture. The properties
/// mean the same.
constexpr const char* in_xmp = "GDepth:";
constexpr const char* after_picture = "DepthMap:";

bool has_dynamic_depth(const XmpEntries& xmp) {
    return xmp_value(xmp, "DepthMap:Format") || xmp_value(xmp, "DepthMap:DepthURI");
}

/// A picture after the first whose own XMP is that of Apple's disparities or depths, and all that follows it;
/// empty: there is none.
std::string_view apples_map(std::string_view jpeg) {
    while (const auto length = jpeg_length(jpeg)) {
        jpeg.remove_prefix(std::min(jpeg.find("\xff\xd8\xff", *length), jpeg.size()));
        const auto xmp = read_jpeg_xmp(jpeg, "");
        const std::string* const type = xmp ? xmp_value(*xmp, "apdi:AuxiliaryImageType") : nullptr;
        if (type && (*type == "disparity" || *type == "depth")) return jpeg;
    }
    return {};
}

/// How to take depth out of Samsung's trailer, which ends in SEFT; nothing: the JPEG has none.
std::optional<std::string> samsungs_depth(std::string_view jpeg, const std::string& where) {
    if (!jpeg.ends_with("SEFT")) return {};
    const bool is_of_two = jpeg.rfind("DualShot_DepthMap") != std::string_view::npos;
    if (!is_of_two && jpeg.rfind("SingleShot_DepthMap") == std::string_view::npos) return {};
    const std::string map =
        shell_word(std::filesystem::path(where).replace_extension().string() + "_depth.tif");
    return std::string("has its depth in Samsung's trailer (SEFT): exiftool -b -") +
           (is_of_two ? "" : "SingleShot") + "DepthMapTiff " + shell_word(where) + " > " + map +
           ", then: touchable play " + map;
}

class JpegDepth {
public:
    JpegDepth(std::string bytes, std::string where) : bytes_(std::move(bytes)), where_(std::move(where)) {}

    Result<DepthPhoto> read(bool is_described) {
        TRY_ASSIGN(xmp_, read_jpeg_xmp(bytes_, where_));
        if (!xmp_value(xmp_, "GDepth:Data")) {
            if (has_dynamic_depth(xmp_))
                prefix_ = after_picture;
            else
                apples_ = apples_map(bytes_);
            const auto samsungs = samsungs_depth(bytes_, where_);
            if (samsungs && prefix_ == in_xmp && apples_.empty()) return refuse(*samsungs);
        }
        TRY(read_depth());
        if (is_described) TRY(describe());
        TRY_ASSIGN(photo_.colour, decode_coded_image(bytes_, where_));
        orient();
        return std::move(photo_);
    }

private:
    Error refuse(const std::string& what) const { return input_error(where_ + ": " + what); }

    Result<std::string> property(const std::string& name) const {
        if (const std::string* const found = xmp_value(xmp_, prefix_ + name)) return *found;
        return refuse("has no " + (prefix_ + name) +
                      " in its XMP: a JPEG needs a depth map (GDepth, Dynamic Depth) to be touched");
    }

    Result<double> number(const std::string& name) const {
        TRY_ASSIGN(const auto text, property(name));
        if (const auto value = parsed_number(text)) return *value;
        return refuse("its " + (prefix_ + name) + " is " + in_quotes(text) + ": must be a number");
    }

    /// The depth map as grey, however it was stored.
    Result<void> read_depth() {
        std::string bytes(apples_);
        if (prefix_ == after_picture) {
            TRY_ASSIGN(bytes, dynamic_depth_map(bytes_, xmp_, where_));
        } else if (bytes.empty()) {
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
    Result<void> describe() {
        if (!apples_.empty()) {
            TRY_ASSIGN(const auto xmp, read_jpeg_xmp(apples_, where_));
            describe_heif_depth(nullptr, xmp, photo_);
            return {};
        }
        TRY_ASSIGN(const auto format, property("Format"));
        const bool is_inverse = small_letters(format) == "rangeinverse";
        if (!is_inverse && small_letters(format) != "rangelinear")
            return refuse("its " + std::string(prefix_) + "Format is " + in_quotes(format) +
                          ": must be RangeInverse or RangeLinear");
        TRY_ASSIGN(const double near, number("Near"));
        TRY_ASSIGN(const double far, number("Far"));
        const auto measured = property("MeasureType");
        const bool along_ray = measured && *measured == "OpticRay";
        if (measured && !along_ray && *measured != "OpticalAxis")
            return refuse("its " + std::string(prefix_) + "MeasureType is " + in_quotes(*measured) +
                          ": must be OpticalAxis or OpticRay");
        DepthCoding& coding = photo_.coding;
        coding.kind = is_inverse ? DepthCodingKind::inverse : DepthCodingKind::linear;
        coding.semantics = along_ray ? DepthSemantics::range : DepthSemantics::planar;
        coding.near_is_high = false;
        coding.near = near;
        coding.far = far;
        coding.code_max = photo_.depth.bits == 8 ? 255 : 65535;
        return describe_unit();
    }

    Result<void> describe_unit() {
        const auto written = property("Units");
        const std::string unit = written ? small_letters(*written) : "none";
        DepthCoding& coding = photo_.coding;
        if (unit == "mm" || unit == "millimeters") {
            photo_.metres_per_unit = 0.001;
        } else if (unit == "diopters" || unit == "dioptres") {  // of the planes; 0 is infinitely far
            constexpr double least = 1e-3;
            coding.near_is_high = coding.near < coding.far;
            coding.near = 1 / std::max(coding.near, least);
            coding.far = 1 / std::max(coding.far, least);
            if (coding.near_is_high) std::swap(coding.near, coding.far);
        } else if (unit == "none") {
            add_remark(photo_.remarks, {"lengths are metres", true, {}, {}, RemarkKind::unit});
        } else if (unit != "m" && unit != "meters") {
            return refuse("its " + std::string(prefix_) + "Units is " + in_quotes(*written) +
                          ": must be m (Meters), mm or Diopters");
        }
        return {};
    }

    /// EXIF's orientation is that of the stored picture and of its depth map, unless a program has turned the
    /// map already.
    void orient() {
        const ExifFacts exif = read_jpeg_exif(bytes_);
        photo_.film_focal_length = exif.film_focal_length;
        photo_.colour_turn = exif_orientation(exif.orientation);
        const auto is_wide = [](const Image& image) { return image.width >= image.height; };
        const bool is_turned =
            photo_.colour_turn.transposed && is_wide(photo_.depth.image) != is_wide(photo_.colour.image);
        if (!is_turned) photo_.depth_turn = photo_.colour_turn;
        if (const auto camera = apples_.empty() ? dynamic_depth_camera(xmp_) : photo_.camera)
            photo_.camera = upright(*camera, photo_.colour_turn);
    }

    std::string bytes_, where_;
    XmpEntries xmp_;
    const char* prefix_ = in_xmp;
    std::string_view apples_;  // in bytes_; empty: depth is described by xmp_
    DepthPhoto photo_;
};

}  // namespace

bool has_jpeg_depth(const SourceFile& file) {
    const auto bytes = read_picture_bytes(file);
    if (!bytes) return false;
    const auto xmp = read_jpeg_xmp(*bytes, file.string());
    return (xmp && (xmp_value(*xmp, "GDepth:Data") || has_dynamic_depth(*xmp))) ||
           !apples_map(*bytes).empty();
}

Opened open_jpeg_depth(const Candidate& file) {
    TRY_ASSIGN(auto bytes, read_picture_bytes(file.source));
    TRY_ASSIGN(auto photo, JpegDepth(std::move(bytes), file.source.string()).read(!file.scene));
    return open_depth_photo(file, std::move(photo));
}

std::optional<std::vector<std::string_view>> app1_segments(std::string_view jpeg) {
    std::vector<std::string_view> segments;
    SegmentReader reader(jpeg);
    while (const auto marker = reader.next()) {
        if (*marker == start_of_scan) return segments;
        if (*marker == app1) segments.push_back(reader.content);
    }
    return std::nullopt;
}

std::optional<std::size_t> jpeg_length(std::string_view file) {
    SegmentReader reader(file);
    while (const auto marker = reader.next())
        if (*marker == end_of_image) return reader.position();
    return std::nullopt;
}

ExifFacts read_jpeg_exif(std::string_view jpeg) {
    constexpr auto header = "Exif\0\0"sv;
    if (const auto segments = app1_segments(jpeg))
        for (const std::string_view segment : *segments)
            if (segment.starts_with(header)) return parse_exif(segment.substr(header.size()));
    return {};
}

Result<XmpEntries> read_jpeg_xmp(std::string_view jpeg, const std::string& where) {
    const auto segments = app1_segments(jpeg);
    if (!segments) return input_error(where + ": is not a whole JPEG: a segment before its picture is cut");
    const auto packet = std::ranges::find_if(
        *segments, [](std::string_view segment) { return segment.starts_with(packet_header); });
    if (packet == segments->end()) return XmpEntries{};
    auto entries = parse_xmp_entries(packet->substr(packet_header.size()));
    if (!entries) return input_error(where + ": its XMP is not well-formed");
    const std::string* const guid = xmp_value(*entries, "xmpNote:HasExtendedXMP");
    if (!guid) return std::move(*entries);
    TRY_ASSIGN(auto text, joined(pieces_of(*segments, *guid), where));
    auto extended = parse_xmp_entries(text);
    if (!extended) return input_error(where + ": its extended XMP is not well-formed");
    std::move(entries->begin(), entries->end(), std::back_inserter(*extended));
    return std::move(*extended);
}

Result<std::string_view> dynamic_depth_map(std::string_view jpeg, const XmpEntries& xmp,
                                           const std::string& where) {
    const std::vector<Item> items = directory(xmp);
    const std::string* const uri = xmp_value(xmp, "DepthMap:DepthURI");
    const auto found = std::find_if(items.begin(), items.end(), [&](const Item& item) {
        return uri && !uri->empty() ? item.uri == *uri : item.semantic.starts_with("Depth");
    });
    if (found == items.end() || found == items.begin())
        return input_error(where +
                           ": its XMP has a depth map, but its Container:Directory does not say where: an "
                           "item after the first must have the name of DepthMap:DepthURI" +
                           (uri ? ", " + in_quotes(*uri) : std::string()));
    const std::size_t length = found->length;
    if (length == 0) return input_error(where + ": its depth map has no Item:Length in its XMP");
    // The pictures follow each other; something may stand after the last.
    std::size_t before = 0, to_end = 0;
    for (auto item = items.begin() + 1; item != items.end(); ++item)
        (item < found ? before : to_end) += item->length + (item < found ? item->padding : 0);
    const std::size_t begin = jpeg_length(jpeg).value_or(jpeg.size()) + items.front().padding + before;
    for (const std::size_t at : {begin, to_end <= jpeg.size() ? jpeg.size() - to_end : jpeg.size()})
        if (at < jpeg.size() && length <= jpeg.size() - at && begins_picture(jpeg.substr(at)))
            return jpeg.substr(at, length);
    return input_error(where + ": has no depth map of " + std::to_string(length) +
                       " bytes after its picture, though its XMP says so: it was cut, or saved anew by a "
                       "program that drops it; must be the camera's own file");
}

std::optional<Intrinsics> dynamic_depth_camera(const XmpEntries& xmp) {
    const auto number = [&](const char* name) {
        return xmp_number(xmp, std::string("ImagingModel:") + name);
    };
    const auto fx = number("FocalLengthX"), fy = number("FocalLengthY"), width = number("ImageWidth"),
               height = number("ImageHeight");
    if (!fx || !(*fx > 0) || !is_xmp_side(width) || !is_xmp_side(height)) return std::nullopt;
    // Focal lengths are pixels; the principal point is a share of the picture, or pixels, too.
    const auto centre = [](std::optional<double> at, double size) -> std::optional<double> {
        if (!at) return std::nullopt;
        return *at >= 0 && *at <= 1 ? *at * size - 0.5 : *at;
    };
    return Intrinsics{*fx,
                      fy && *fy > 0 ? *fy : *fx,
                      centre(number("PrincipalPointX"), *width),
                      centre(number("PrincipalPointY"), *height),
                      static_cast<int>(*width),
                      static_cast<int>(*height)};
}

}  // namespace touchable
