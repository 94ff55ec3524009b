#include "engine/authoring/brush_history.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "engine/authoring/segment_json.hpp"

namespace touchable {
namespace {

using HistoryNode = checked_json::Node;
using HistoryJson = nlohmann::ordered_json;

constexpr int history_version = 1;
constexpr std::size_t most_edits_read = 10000;

HistoryJson write_edit(const BrushEdit& edit) {
    HistoryJson json = HistoryJson::object();
    if (const auto* const paint = std::get_if<PaintEdit>(&edit)) {
        json["paint"] = segment_json::write_place(paint->at);
        json["material"] = paint->material;
    } else if (const auto* const join = std::get_if<JoinEdit>(&edit)) {
        json["join"] =
            HistoryJson::array({segment_json::write_place(join->a), segment_json::write_place(join->b)});
    } else if (const auto* const cut = std::get_if<SegmentCut>(&edit)) {
        json["cut"] = segment_json::write_cut(*cut);
    } else {
        json["otherwise"] = std::get<OtherwiseEdit>(edit).material;
    }
    return json;
}

BrushEdit read_edit(const HistoryNode& node) {
    node.allow_only({"paint", "material", "join", "cut", "otherwise"});
    if (node.has("paint")) return PaintEdit{segment_json::read_place(node["paint"]), node["material"].text()};
    if (node.has("join")) {
        const auto places = node["join"].elements(2, 2, "two places");
        return JoinEdit{segment_json::read_place(places[0]), segment_json::read_place(places[1])};
    }
    if (node.has("cut")) return segment_json::read_cut(node["cut"]);
    if (node.has("otherwise")) return OtherwiseEdit{node["otherwise"].text()};
    node.refuse("paint, join, cut or otherwise");
}

BrushHistory read_history(const HistoryNode& node, const std::string& where) {
    node.allow_only({"touchable_brush", "segments", "done", "begin", "edits"});
    if (node["touchable_brush"].integer(1, 1'000'000) != history_version)
        node["touchable_brush"].refuse("1, the version that is read here");
    BrushHistory history;
    history.segments = node["segments"].text();
    auto begin = parse_segment_names(node["begin"].json(), where + ": begin");
    if (!begin) throw checked_json::Refusal{begin.error().message};
    history.begin = std::move(*begin);
    for (const HistoryNode& edit :
         node["edits"].elements(0, most_edits_read, "a list of up to 10000 changes"))
        history.edits.push_back(read_edit(edit));
    history.done =
        static_cast<std::size_t>(node["done"].integer(0, static_cast<std::int64_t>(history.edits.size())));
    return history;
}

}  // namespace

Result<BrushHistory> parse_brush_history(std::string_view text, const std::string& where) {
    const auto refuse = [&](const std::string& why) { return input_error(where + ": " + why); };
    try {
        const checked_json::Json json = checked_json::parse(text, largest_segment_names);
        return read_history(HistoryNode(json, ""), where);
    } catch (const checked_json::Refusal& reason) {
        return refuse(reason.message);
    } catch (const checked_json::Json::exception& fault) {
        return refuse(fault.what());
    }
}

std::string brush_history_to_json(const BrushHistory& history) {
    // A line for each edit, so that a person finds it.
    std::string text = "{\"touchable_brush\": " + std::to_string(history_version) + ", \"segments\": \"" +
                       history.segments + "\", \"done\": " + std::to_string(history.done) +
                       ",\n\"begin\": " + segment_names_to_json(history.begin) + ",\"edits\": [";
    const char* between = "\n ";
    for (const BrushEdit& edit : history.edits) {
        text += between + write_edit(edit).dump(-1, ' ', true, HistoryJson::error_handler_t::replace);
        between = ",\n ";
    }
    return text + "\n]}\n";
}

}  // namespace touchable
