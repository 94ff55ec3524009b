#include "engine/scene/folder_json.hpp"

#include <string>

namespace touchable {
namespace {

using FolderNode = checked_json::Node;
using FolderJson = nlohmann::ordered_json;

std::string read_pictures(const FolderNode& node, PictureNumbers& numbers) {
    if (!node.is_object()) return node.text();
    node.allow_only({"files", "first", "step"});
    if (node.has("first")) numbers.first = node["first"].whole();
    if (node.has("step")) numbers.step = node["step"].whole();
    return node["files"].text();
}

FolderJson write_pictures(const std::string& pattern, const PictureNumbers& numbers) {
    if (!numbers.any()) return pattern;
    FolderJson json = {{"files", pattern}};
    if (numbers.first) json["first"] = *numbers.first;
    if (numbers.step) json["step"] = *numbers.step;
    return json;
}

}  // namespace

FolderSource read_folder(const FolderNode& node) {
    node.allow_only({"depth", "colour", "haptic", "height", "cameras", "first", "count"});
    FolderSource folder;
    PictureNumbers of_depth;
    folder.depth = read_pictures(node["depth"], of_depth);
    if (of_depth.first && node.has("first"))
        node["first"].refuse("left out where folder.depth.first is given");
    folder.first = of_depth.first.value_or(0);
    folder.step = of_depth.step.value_or(1);
    if (node.has("colour")) folder.colour = read_pictures(node["colour"], folder.colour_numbers);
    if (node.has("haptic")) folder.haptic = read_pictures(node["haptic"], folder.haptic_numbers);
    if (node.has("height")) folder.height = read_pictures(node["height"], folder.height_numbers);
    if (node.has("cameras")) folder.cameras = read_pictures(node["cameras"], folder.camera_numbers);
    if (node.has("first")) folder.first = node["first"].whole();
    if (node.has("count")) folder.count = node["count"].whole();
    return folder;
}

FolderJson write_folder(const FolderSource& folder) {
    PictureNumbers of_depth;
    if (folder.step != 1) of_depth.step = folder.step;
    FolderJson json = {{"depth", write_pictures(folder.depth, of_depth)}};
    if (!folder.colour.empty()) json["colour"] = write_pictures(folder.colour, folder.colour_numbers);
    if (!folder.haptic.empty()) json["haptic"] = write_pictures(folder.haptic, folder.haptic_numbers);
    if (!folder.height.empty()) json["height"] = write_pictures(folder.height, folder.height_numbers);
    if (!folder.cameras.empty()) json["cameras"] = write_pictures(folder.cameras, folder.camera_numbers);
    json["first"] = folder.first;
    json["count"] = folder.count;
    return json;
}

}  // namespace touchable
