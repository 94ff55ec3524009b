#include "engine/formats/dynamic_depth.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/formats/jpeg_segments.hpp"

namespace touchable {
namespace {

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

}  // namespace

Result<std::string_view> dynamic_depth_map(std::string_view jpeg, const XmpEntries& xmp,
                                           const std::string& where) {
    const std::vector<Item> items = directory(xmp);
    const XmpProperties properties = properties_of(xmp);
    const auto uri = properties.find("DepthMap:DepthURI");
    const auto found = std::find_if(items.begin(), items.end(), [&](const Item& item) {
        return uri != properties.end() && !uri->second.empty() ? item.uri == uri->second
                                                               : item.semantic.starts_with("Depth");
    });
    if (found == items.end() || found == items.begin())
        return input_error(where +
                           ": its XMP has a depth map, but its Container:Directory does not say where: an "
                           "item after the first must have the name of DepthMap:DepthURI" +
                           (uri != properties.end() ? ", " + in_quotes(uri->second) : std::string()));
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

std::optional<Intrinsics> dynamic_depth_camera(const XmpProperties& xmp) {
    const auto number = [&](const char* name) {
        const auto found = xmp.find(std::string("ImagingModel:") + name);
        return found == xmp.end() ? std::nullopt : parsed_number(found->second);
    };
    const auto fx = number("FocalLengthX"), fy = number("FocalLengthY"), width = number("ImageWidth"),
               height = number("ImageHeight");
    const auto is_side = [](const std::optional<double>& side) { return side && *side >= 1 && *side < 1e6; };
    if (!fx || !(*fx > 0) || !is_side(width) || !is_side(height)) return std::nullopt;
    // Focal lengths are of pixels; the principal point is a share of the picture, or of pixels likewise.
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
