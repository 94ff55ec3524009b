#include "engine/content/materials/material_brush.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "engine/content/materials/material_guess.hpp"
#include "engine/content/materials/segment_json.hpp"
#include "engine/content/materials/segment_search.hpp"
#include "engine/printable.hpp"

namespace touchable {
namespace {

using HistoryNode = checked_json::Node;
using HistoryJson = nlohmann::ordered_json;

constexpr int history_version = 1;
constexpr std::size_t most_edits = 1000;
constexpr std::size_t most_kept_bytes = std::size_t{1} << 30;  // of segments that were cut, for undo

std::string segment_in_words(std::uint16_t label) {
    return "segment " + std::to_string(label);
}

Result<std::uint16_t> label_of(const SegmentStore& segments, const PixelOfFrame& at) {
    const std::string place = "pixel " + std::to_string(at.x) + ',' + std::to_string(at.y) + " of frame " +
                              std::to_string(at.frame);
    if (at.x < 0 || at.y < 0 || at.frame < 0 || at.x >= segments.width() || at.y >= segments.height() ||
        at.frame >= segments.frames())
        return usage_error(place + " is beyond the clip, which has " + std::to_string(segments.frames()) +
                           " frames of " + std::to_string(segments.width()) + 'x' +
                           std::to_string(segments.height()));
    const std::uint16_t label = segments.label_at(at.frame, at.x, at.y);
    if (label == 0) return usage_error("there is no surface at " + place);
    return label;
}

std::set<std::uint16_t> labels_of(const SegmentStore& segments, const NamedSegment& name) {
    std::set<std::uint16_t> labels;
    for (const PixelOfFrame& at : name.at) labels.insert(segments.label_at(at.frame, at.x, at.y));
    return labels;
}

/// What is said of a segment, by a person before a guess; null: nothing.
NamedSegment* find_name(const SegmentStore& segments, SegmentNames& names, std::uint16_t label) {
    NamedSegment* guess = nullptr;
    for (NamedSegment& name : names.segments) {
        if (!labels_of(segments, name).contains(label)) continue;
        if (!name.is_guess) return &name;
        if (guess == nullptr) guess = &name;
    }
    return guess;
}

NamedSegment new_name(std::uint16_t label, const PixelOfFrame& at, const PaintedSegments::Paint& paint) {
    NamedSegment name;
    name.name = paint.name.empty() ? segment_in_words(label) : paint.name;
    name.material = paint.material;
    name.feel = paint.feel;
    name.is_guess = paint.is_guess;
    name.at = {at};
    name.said_by = name.name;
    return name;
}

/// What was said of a segment goes for both of its parts.
void name_part(const SegmentStore& segments, SegmentNames& names, std::uint16_t part,
               const NamedSegment& whole) {
    if (find_name(segments, names, part) != nullptr) return;
    const SegmentStore::FirstLook* const look = segments.find(part);
    NamedSegment name = whole;
    name.name = segment_in_words(part);
    name.at = {{look->segment.x, look->segment.y, look->frame}};
    names.segments.push_back(std::move(name));
}

}  // namespace

Result<MaterialBrush::State> MaterialBrush::state_of(std::shared_ptr<const SegmentStore> segments,
                                                     SegmentNames names) {
    const auto named = find_named_segments(*segments, names, std::nullopt);
    if (!named) return named.error();
    const PaletteMaterial* const otherwise = find_material(names.otherwise);
    auto painted = std::make_shared<PaintedSegments>();
    for (const SegmentStore::FirstLook& look : segments->seen()) {
        PaintedSegments::Paint& paint = painted->by_label[look.segment.label];
        if (const auto known = named->find(look.segment.label); known != named->end()) {
            const NamedSegment& name = known->second;
            paint = {name.name, name.material, name.feel, name.is_guess};
            continue;
        }
        const PaletteMaterial& material =
            otherwise != nullptr
                ? *otherwise
                : guess_material(look_of(look.segment, segments->width() * segments->height()));
        paint = {"", std::string(material.name), material.feel(), otherwise == nullptr};
    }
    painted->segments = std::move(segments);
    return State{std::move(names), std::move(painted)};
}

Result<MaterialBrush> MaterialBrush::begin(SegmentStore segments, const SegmentNames& names) {
    MaterialBrush brush;
    brush.uncut_ = std::make_shared<const SegmentStore>(std::move(segments));
    auto cut = with_cuts(*brush.uncut_, names);
    if (!cut) return cut.error();
    auto state = state_of(std::make_shared<const SegmentStore>(std::move(*cut)), names);
    if (!state) return state.error();
    brush.states_.push_back(std::move(*state));
    return brush;
}

/// Changes names and segments as an edit says; what was done, in words.
class MaterialBrush::Draft {
public:
    explicit Draft(const State& now)
        : now_(*now.painted), segments_(now.painted->segments), names_(now.names) {}

    Result<std::string> operator()(const Paint& paint);
    Result<std::string> operator()(const Join& join);
    Result<std::string> operator()(const SegmentCut& cut);
    Result<std::string> operator()(const Otherwise& otherwise);
    Result<State> finish() { return state_of(std::move(segments_), std::move(names_)); }

private:
    const PaintedSegments& now_;
    std::shared_ptr<const SegmentStore> segments_;
    SegmentNames names_;
};

Result<std::string> MaterialBrush::Draft::operator()(const Paint& paint) {
    const auto label = label_of(*segments_, paint.at);
    if (!label) return label.error();
    const PaletteMaterial* const material = find_material(paint.material);
    if (material == nullptr) return usage_error(no_such_material(paint.material));
    NamedSegment* name = find_name(*segments_, names_, *label);
    if (name == nullptr) name = &names_.segments.emplace_back(new_name(*label, paint.at, {}));
    name->material = paint.material;
    name->feel = material->feel();
    name->is_guess = false;
    return printable(name->name) + " is " + paint.material;
}

/// What a person said counts before a guess, and the first before the second.
Result<std::string> MaterialBrush::Draft::operator()(const Join& join) {
    auto a = label_of(*segments_, join.a), b = label_of(*segments_, join.b);
    if (!a) return a.error();
    if (!b) return b.error();
    const NamedSegment *of_a = find_name(*segments_, names_, *a), *of_b = find_name(*segments_, names_, *b);
    if (*a == *b) return usage_error("both places are on " + segment_in_words(*a));
    const std::string both = segment_in_words(*a) + " and " + segment_in_words(*b);
    if (of_a != nullptr && of_a == of_b) return usage_error(both + " are one already");
    PixelOfFrame at_a = join.a, at_b = join.b;
    if (of_b != nullptr && !of_b->is_guess && (of_a == nullptr || of_a->is_guess)) {
        std::swap(of_a, of_b);
        std::swap(at_a, at_b);
        std::swap(*a, *b);
    }
    NamedSegment joined = of_a != nullptr ? *of_a : new_name(*a, at_a, now_.by_label.at(*a));
    const std::vector<PixelOfFrame> places = of_b != nullptr ? of_b->at : std::vector{at_b};
    joined.at.insert(joined.at.end(), places.begin(), places.end());
    std::erase_if(names_.segments, [&](const NamedSegment& name) {
        const auto labels = labels_of(*segments_, name);
        return labels.contains(*a) || labels.contains(*b);
    });
    names_.segments.push_back(std::move(joined));
    return both + " are one";
}

Result<std::string> MaterialBrush::Draft::operator()(const SegmentCut& cut) {
    auto made = segments_->with_cut(cut);
    if (!made) return made.error();
    std::vector<std::uint16_t> labels;
    segments_->read_labels(cut.frame, labels);
    const std::uint16_t whole = label_under(cut, labels, segments_->width());
    const std::uint16_t part = made->seen().back().segment.label;
    const NamedSegment* const name = find_name(*segments_, names_, whole);
    segments_ = std::make_shared<const SegmentStore>(std::move(*made));
    names_.cuts.push_back(cut);
    if (name != nullptr) {
        const NamedSegment said = *name;
        name_part(*segments_, names_, whole, said);
        name_part(*segments_, names_, part, said);
    }
    return segment_in_words(whole) + " is cut; " + segment_in_words(part) + " is its smaller part";
}

Result<std::string> MaterialBrush::Draft::operator()(const Otherwise& otherwise) {
    if (!otherwise.material.empty() && find_material(otherwise.material) == nullptr)
        return usage_error(no_such_material(otherwise.material));
    names_.otherwise = otherwise.material;
    return "what nobody named is " +
           (otherwise.material.empty() ? std::string("guessed") : otherwise.material);
}

Result<void> MaterialBrush::check_room(const Edit& edit) const {
    if (done_ == most_edits)
        return usage_error("no more than " + std::to_string(most_edits) +
                           " changes are kept for undo; save them, and begin anew with what is saved");
    if (!std::holds_alternative<SegmentCut>(edit)) return {};
    std::size_t bytes = states_[done_].painted->segments->bytes();
    for (std::size_t k = 0; k < done_; ++k)
        if (std::holds_alternative<SegmentCut>(edits_[k].edit))
            bytes += states_[k + 1].painted->segments->bytes();
    if (bytes > most_kept_bytes)
        return usage_error(
            "what is cut takes 1 GiB, as much as is kept for undo; save it, and begin anew with what is "
            "saved");
    return {};
}

Result<std::string> MaterialBrush::edit(const Edit& edit) {
    if (auto fits = check_room(edit); !fits) return fits.error();
    Draft draft(states_[done_]);
    auto words = std::visit(draft, edit);
    if (!words) return words;
    auto state = draft.finish();
    if (!state) return state.error();
    states_.resize(done_ + 1);
    edits_.resize(done_);
    states_.push_back(std::move(*state));
    edits_.push_back({edit, *words});
    ++done_;
    return words;
}

Result<std::string> MaterialBrush::undo() {
    if (done_ == 0) return usage_error("there is nothing to undo");
    --done_;
    return "undone: " + edits_[done_].words;
}

Result<std::string> MaterialBrush::redo() {
    if (done_ == edits_.size()) return usage_error("there is nothing to do again");
    ++done_;
    return "done again: " + edits_[done_ - 1].words;
}

namespace {

HistoryJson write_edit(const MaterialBrush::Edit& edit) {
    HistoryJson json = HistoryJson::object();
    if (const auto* const paint = std::get_if<MaterialBrush::Paint>(&edit)) {
        json["paint"] = segment_json::write_place(paint->at);
        json["material"] = paint->material;
    } else if (const auto* const join = std::get_if<MaterialBrush::Join>(&edit)) {
        json["join"] =
            HistoryJson::array({segment_json::write_place(join->a), segment_json::write_place(join->b)});
    } else if (const auto* const cut = std::get_if<SegmentCut>(&edit)) {
        json["cut"] = segment_json::write_cut(*cut);
    } else {
        json["otherwise"] = std::get<MaterialBrush::Otherwise>(edit).material;
    }
    return json;
}

MaterialBrush::Edit read_edit(const HistoryNode& node) {
    if (node.has("paint")) {
        node.allow_only({"paint", "material"});
        return MaterialBrush::Paint{segment_json::read_place(node["paint"]), node["material"].text()};
    }
    if (node.has("join")) {
        const auto places = node["join"].elements(2, 2, "two places");
        return MaterialBrush::Join{segment_json::read_place(places[0]), segment_json::read_place(places[1])};
    }
    if (node.has("cut")) return segment_json::read_cut(node["cut"]);
    if (node.has("otherwise")) return MaterialBrush::Otherwise{node["otherwise"].text()};
    node.refuse("paint, join, cut or otherwise");
}

/// A history as it stands in a file.
struct ReadHistory {
    SegmentNames begin;
    std::vector<MaterialBrush::Edit> edits;
    std::size_t done = 0;
};

ReadHistory read_history(const HistoryNode& node, const SegmentStore& segments, const std::string& where) {
    node.allow_only({"touchable_brush", "width", "height", "frames", "done", "begin", "edits"});
    if (node["touchable_brush"].integer(1, 1'000'000) != history_version)
        node["touchable_brush"].refuse("1, the version that is read here");
    const auto same = [&](const char* member, std::int64_t value) {
        if (node[member].integer(0, segment_json::last_frame) != value)
            node[member].refuse(std::to_string(value) + ", as the clip has it");
    };
    same("width", segments.width());
    same("height", segments.height());
    same("frames", segments.frames());
    ReadHistory history;
    auto begin = parse_segment_names(node["begin"].json(), where + ": begin");
    if (!begin) throw checked_json::Refusal{begin.error().message};
    history.begin = std::move(*begin);
    for (const HistoryNode& edit : node["edits"].elements(0, most_edits, "a list of up to 1000 changes"))
        history.edits.push_back(read_edit(edit));
    history.done =
        static_cast<std::size_t>(node["done"].integer(0, static_cast<std::int64_t>(history.edits.size())));
    return history;
}

}  // namespace

std::string MaterialBrush::history() const {
    HistoryJson json;
    json["touchable_brush"] = history_version;
    json["width"] = uncut_->width();
    json["height"] = uncut_->height();
    json["frames"] = uncut_->frames();
    json["done"] = done_;
    json["begin"] = HistoryJson::parse(segment_names_to_json(states_.front().names));
    json["edits"] = HistoryJson::array();
    for (const Done& done : edits_) json["edits"].push_back(write_edit(done.edit));
    return json.dump(-1, ' ', true, HistoryJson::error_handler_t::replace) + '\n';
}

Result<void> MaterialBrush::repeat(std::string_view text, std::string_view from) {
    const std::string where(from);
    const auto refuse = [&](const std::string& why) { return input_error(where + ": " + why); };
    try {
        const checked_json::Json json = checked_json::parse(text, largest_segment_names);
        ReadHistory history = read_history(HistoryNode(json, ""), *uncut_, where);
        auto again = begin(*uncut_, history.begin);
        if (!again) return again.error();
        for (std::size_t k = 0; k < history.edits.size(); ++k)
            if (auto done = again->edit(history.edits[k]); !done)
                return refuse("edits[" + std::to_string(k) + "]: " + done.error().message);
        again->done_ = history.done;
        *this = std::move(*again);
        return {};
    } catch (const checked_json::Refusal& reason) {
        return refuse(reason.message);
    } catch (const checked_json::Json::exception& fault) {
        return refuse(fault.what());
    }
}

}  // namespace touchable
