// SPDX-License-Identifier: Apache-2.0
#include "engine/authoring/materials.hpp"

#include <nlohmann/json.hpp>
#include <set>

#include "engine/authoring/segment_parts.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {

namespace {

using HistoryJson = nlohmann::ordered_json;

constexpr std::size_t most_edits_read = 10000;

/// All that was done with a brush, for another run of the program.
struct BrushHistory {
    std::string segments{};  ///< SegmentStore::fingerprint of the uncut ones
    SegmentNames begin{};    ///< before the first edit
    std::vector<MaterialBrush::Edit> edits{};
    std::size_t done = 0;  ///< number of edits in effect; later ones were undone
};

HistoryJson write_edit(const MaterialBrush::Edit& edit) {
    HistoryJson json = HistoryJson::object();
    if (const auto* const paint = std::get_if<MaterialBrush::Paint>(&edit)) {
        json["paint"] = write_place(paint->at);
        json["material"] = paint->material;
    } else if (const auto* const join = std::get_if<MaterialBrush::Join>(&edit)) {
        json["join"] = HistoryJson::array({write_place(join->a), write_place(join->b)});
    } else if (const auto* const cut = std::get_if<SegmentCut>(&edit)) {
        json["cut"] = write_cut(*cut);
    } else {
        json["otherwise"] = std::get<MaterialBrush::Otherwise>(edit).material;
    }
    return json;
}

MaterialBrush::Edit read_edit(const checked_json::Node& node) {
    node.allow_only({"paint", "material", "join", "cut", "otherwise"});
    if (node.has("paint")) return MaterialBrush::Paint{read_place(node["paint"]), node["material"].text()};
    if (node.has("join")) {
        const auto places = node["join"].elements(2, 2, "two places");
        return MaterialBrush::Join{read_place(places[0]), read_place(places[1])};
    }
    if (node.has("cut")) return read_cut(node["cut"]);
    if (node.has("otherwise")) return MaterialBrush::Otherwise{node["otherwise"].text()};
    node.refuse("paint, join, cut or otherwise");
}

BrushHistory read_history(const checked_json::Node& node, const std::string& where) {
    node.allow_only({"touchable_brush", "segments", "done", "begin", "edits"});
    node.check_version("touchable_brush");
    BrushHistory history;
    history.segments = node["segments"].text();
    auto begin = parse_segment_names(node["begin"].json(), where + ": begin");
    if (!begin) throw checked_json::Refusal{begin.error().message};
    history.begin = std::move(*begin);
    for (const checked_json::Node& edit :
         node["edits"].elements(0, most_edits_read, "a list of up to 10000 changes"))
        history.edits.push_back(read_edit(edit));
    history.done =
        static_cast<std::size_t>(node["done"].integer(0, static_cast<std::int64_t>(history.edits.size())));
    return history;
}

/// An error (ErrorKind::input, beginning with `where`) if the text is no history.
Result<BrushHistory> parse_brush_history(std::string_view text, const std::string& where) {
    return checked_json::read_checked(
        text, largest_segment_names, where,
        [&](const checked_json::Node& node) { return read_history(node, where); });
}

std::string brush_history_to_json(const BrushHistory& history) {
    // A line for each edit, so that a person finds it.
    std::string text = "{\"touchable_brush\": 1, \"segments\": \"" + history.segments +
                       "\", \"done\": " + std::to_string(history.done) +
                       ",\n\"begin\": " + segment_names_to_json(history.begin) + ",\"edits\": [";
    for (const MaterialBrush::Edit& edit : history.edits)
        text += (&edit == &history.edits.front() ? "\n " : ",\n ") +
                write_edit(edit).dump(-1, ' ', true, HistoryJson::error_handler_t::replace);
    return text + "\n]}\n";
}

constexpr std::size_t most_kept_bytes = std::size_t{1} << 30;  // of segments that were cut, for undo

std::string segment_in_words(std::uint16_t label) {
    return "segment " + std::to_string(label);
}

/// Names the segment's frames unless they are all: others have other segments there, not painted.
std::string frames_in_words(const SegmentStore& segments, std::uint16_t label) {
    const std::int64_t first = segments.find(label)->frame, last = segments.last_frame_of(label);
    if (first == 0 && last == segments.frames() - 1) return {};
    if (first == last) return "; only frame " + std::to_string(first) + " has it";
    return "; only frames " + std::to_string(first) + " to " + std::to_string(last) + " have it";
}

Result<std::uint16_t> label_of(const SegmentStore& segments, const PixelOfFrame& at) {
    const std::string place = "pixel " + std::to_string(at.x) + ',' + std::to_string(at.y) + " of frame " +
                              std::to_string(at.frame);
    if (at.x < 0 || at.y < 0 || at.frame < 0 || at.x >= segments.width() || at.y >= segments.height() ||
        at.frame >= segments.frames())
        return usage_error(place + " is beyond the clip, which has " + std::to_string(segments.frames()) +
                           " frames of " + size_text(segments.width(), segments.height()));
    const std::uint16_t label = segments.label_at(at.frame, at.x, at.y);
    if (label == 0) return usage_error("there is no surface at " + place);
    return label;
}

std::set<std::uint16_t> labels_of(const SegmentStore& segments, const NamedSegment& name) {
    std::set<std::uint16_t> labels;
    for (const PixelOfFrame& at : name.at) labels.insert(segments.label_at(at.frame, at.x, at.y));
    return labels;
}

/// The name entry of a segment; null: none.
NamedSegment* find_name(const SegmentStore& segments, SegmentNames& names, std::uint16_t label) {
    const auto found = std::ranges::find_if(
        names.segments, [&](const NamedSegment& name) { return labels_of(segments, name).contains(label); });
    return found == names.segments.end() ? nullptr : &*found;
}

/// Gives each segment one name: merges names that share one into the first, guesses last.
SegmentNames with_one_name_each(const SegmentStore& segments, const SegmentNames& names) {
    SegmentNames merged = names;
    merged.segments.clear();
    std::vector<NamedSegment> said = names.segments;
    std::stable_partition(said.begin(), said.end(), [](const NamedSegment& name) { return !name.is_guess; });
    for (NamedSegment& name : said) {
        const auto labels = labels_of(segments, name);
        const auto shares = [&](const NamedSegment& other) {
            const auto others = labels_of(segments, other);
            return std::ranges::any_of(labels, [&](std::uint16_t label) { return others.contains(label); });
        };
        const auto same = std::ranges::find_if(merged.segments, shares);
        if (same == merged.segments.end())
            merged.segments.push_back(std::move(name));
        else
            same->at.insert(same->at.end(), name.at.begin(), name.at.end());
    }
    return merged;
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

/// Applies a segment's name entry to both of its parts; the larger one keeps its name.
void name_parts(const SegmentStore& segments, SegmentNames& names, std::uint16_t whole, std::uint16_t part,
                const NamedSegment& said) {
    NamedSegment* const of_part = find_name(segments, names, part);
    const bool has_whole = find_name(segments, names, whole) != nullptr;
    if (of_part != nullptr && has_whole) return;
    if (of_part != nullptr) of_part->name = segment_in_words(part);
    const SegmentStore::FirstLook* const look = segments.find(has_whole ? part : whole);
    NamedSegment name = said;
    if (has_whole) name.name = segment_in_words(part);
    name.at = {{look->segment.x, look->segment.y, look->frame}};
    names.segments.push_back(std::move(name));
}

}  // namespace

Result<MaterialBrush::State> MaterialBrush::state_of(std::shared_ptr<const SegmentStore> segments,
                                                     SegmentNames names) {
    TRY_ASSIGN(const auto named, find_named_segments(*segments, names, std::nullopt));
    const PaletteMaterial* const otherwise = find_material(names.otherwise);
    const std::int32_t of_pixels = segments->width() * segments->height();
    auto painted = std::make_shared<PaintedSegments>();
    for (const SegmentStore::FirstLook& look : segments->seen())
        painted->by_label[look.segment.label] = paint_of(look.segment, of_pixels, named, otherwise);
    painted->segments = std::move(segments);
    return State{std::move(names), std::move(painted)};
}

Result<MaterialBrush> MaterialBrush::begin(SegmentStore segments, const SegmentNames& names) {
    MaterialBrush brush;
    brush.uncut_ = std::make_shared<const SegmentStore>(std::move(segments));
    TRY_ASSIGN(auto cut, with_cuts(*brush.uncut_, names));
    // First with the names as they are, so that invalid ones are refused.
    TRY_ASSIGN(auto state, state_of(std::make_shared<const SegmentStore>(std::move(cut)), names));
    state.names = with_one_name_each(*state.painted->segments, state.names);
    brush.states_.push_back(std::move(state));
    return brush;
}

/// Applies an edit to names and segments; returns what was done, in words.
class MaterialBrush::Draft {
public:
    explicit Draft(const State& now)
        : now_(*now.painted), segments_(now.painted->segments), names_(now.names) {}

    Result<std::string> operator()(const Paint& paint) {
        TRY_ASSIGN(const auto label, label_of(*segments_, paint.at));
        const PaletteMaterial* const material = find_material(paint.material);
        if (material == nullptr) return usage_error(no_such_material(paint.material));
        NamedSegment* name = find_name(*segments_, names_, label);
        if (name == nullptr) name = &names_.segments.emplace_back(new_name(label, paint.at, {}));
        name->material = paint.material;
        name->feel = material->feel();
        name->is_guess = false;
        return printable(name->name) + " is " + paint.material + frames_in_words(*segments_, label);
    }

    /// A person's choice takes precedence over a guess, and the first segment over the second.
    Result<std::string> operator()(const Join& join) {
        TRY_ASSIGN(auto a, label_of(*segments_, join.a));
        TRY_ASSIGN(auto b, label_of(*segments_, join.b));
        const NamedSegment *of_a = find_name(*segments_, names_, a), *of_b = find_name(*segments_, names_, b);
        if (a == b) return usage_error("both places are on " + segment_in_words(a));
        const std::string both = segment_in_words(a) + " and " + segment_in_words(b);
        if (of_a != nullptr && of_a == of_b) return usage_error(both + " are one already");
        PixelOfFrame at_a = join.a, at_b = join.b;
        if (of_b != nullptr && !of_b->is_guess && (of_a == nullptr || of_a->is_guess)) {
            std::swap(of_a, of_b);
            std::swap(at_a, at_b);
            std::swap(a, b);
        }
        NamedSegment joined = of_a != nullptr ? *of_a : new_name(a, at_a, now_.by_label.at(a));
        const std::vector<PixelOfFrame> places = of_b != nullptr ? of_b->at : std::vector{at_b};
        joined.at.insert(joined.at.end(), places.begin(), places.end());
        std::erase_if(names_.segments, [&](const NamedSegment& name) {
            const auto labels = labels_of(*segments_, name);
            return labels.contains(a) || labels.contains(b);
        });
        names_.segments.push_back(std::move(joined));
        return both + " are one";
    }

    Result<std::string> operator()(const SegmentCut& cut) {
        if (names_.cuts.size() == most_cuts)
            return usage_error("a clip's segments are cut " + std::to_string(most_cuts) + " times at most");
        TRY_ASSIGN(auto made, segments_->with_cut(cut));
        std::vector<std::uint16_t> labels;
        segments_->read_labels(cut.frame, labels);
        const std::uint16_t whole = label_under(cut, labels, segments_->width());
        const std::uint16_t part = made.seen().back().segment.label;
        const NamedSegment* const name = find_name(*segments_, names_, whole);
        segments_ = std::make_shared<const SegmentStore>(std::move(made));
        names_.cuts.push_back(cut);
        if (name != nullptr) {
            const NamedSegment said = *name;
            name_parts(*segments_, names_, whole, part, said);
        }
        return segment_in_words(whole) + " is cut; " + segment_in_words(part) + " is its smaller part" +
               frames_in_words(*segments_, whole);
    }

    Result<std::string> operator()(const Otherwise& otherwise) {
        if (!otherwise.material.empty() && find_material(otherwise.material) == nullptr)
            return usage_error(no_such_material(otherwise.material));
        names_.otherwise = otherwise.material;
        return "unnamed segments are " +
               (otherwise.material.empty() ? std::string("guessed") : otherwise.material);
    }

    Result<State> finish() { return state_of(std::move(segments_), std::move(names_)); }

private:
    const PaintedSegments& now_;
    std::shared_ptr<const SegmentStore> segments_;
    SegmentNames names_;
};

/// Drops the oldest edits beyond what is kept; they cannot be undone any more.
void MaterialBrush::forget_oldest() {
    const auto bytes = [this] {
        std::size_t sum = 0;
        const SegmentStore* before = nullptr;
        for (const State& state : states_) {
            if (state.painted->segments.get() != before) sum += state.painted->segments->bytes();
            before = state.painted->segments.get();
        }
        return sum;
    };
    while (edits_.size() > most_edits || (edits_.size() > 1 && bytes() > most_kept_bytes)) {
        states_.erase(states_.begin());
        edits_.erase(edits_.begin());
        --done_;
    }
}

Result<std::string> MaterialBrush::edit(const Edit& edit) {
    Draft draft(states_[done_]);
    auto words = std::visit(draft, edit);
    if (!words) return words;
    TRY_ASSIGN(auto state, draft.finish());
    states_.resize(done_ + 1);
    edits_.resize(done_);
    states_.push_back(std::move(state));
    edits_.push_back({edit, *words});
    ++done_;
    forget_oldest();
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

std::string MaterialBrush::history() const {
    BrushHistory history{uncut_->fingerprint(), states_.front().names, {}, done_};
    for (const Done& done : edits_) history.edits.push_back(done.edit);
    return brush_history_to_json(history);
}

Result<void> MaterialBrush::repeat(std::string_view text, const std::string& where) {
    TRY_ASSIGN(const auto history, parse_brush_history(text, where));
    if (history.segments != uncut_->fingerprint())
        return input_error(where + ": is of other segments than the clip has now");
    TRY_ASSIGN(auto again, begin(*uncut_, history.begin));
    for (std::size_t k = 0; k < history.edits.size(); ++k) {
        if (stop_requested()) return interrupted_error();
        const auto done = again.edit(history.edits[k]);
        if (done) continue;
        if (done.error().kind == ErrorKind::interrupted) return done.error();
        return input_error(where + ": edits[" + std::to_string(k) + "]: " + done.error().message);
    }
    const std::size_t undone = history.edits.size() - history.done;
    again.done_ -= std::min(undone, again.done_);
    *this = std::move(again);
    return {};
}

}  // namespace touchable
