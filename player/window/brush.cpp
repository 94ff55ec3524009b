// SPDX-License-Identifier: Apache-2.0
#include "player/window/brush.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/window/user_files.hpp"

namespace touchable {
namespace {

using Rgb = std::array<std::uint8_t, 3>;
constexpr std::pair<std::string_view, Rgb> colours_of_materials[] = {
    {"wood", {186, 128, 66}},       {"metal", {132, 152, 186}},  {"glass", {112, 222, 226}},
    {"ceramic", {238, 232, 226}},   {"plastic", {238, 84, 130}}, {"paper", {250, 244, 160}},
    {"cardboard", {206, 176, 130}}, {"cloth", {128, 108, 214}},  {"felt", {40, 130, 112}},
    {"leather", {118, 58, 32}},     {"rubber", {66, 66, 78}},    {"foam", {255, 204, 84}},
    {"cork", {232, 140, 46}},       {"skin", {250, 184, 164}},   {"stone", {140, 140, 128}},
    {"brick", {198, 62, 44}},       {"carpet", {166, 52, 156}},  {"fur", {222, 198, 232}},
    {"grass", {96, 186, 52}},       {"water", {38, 110, 232}}};

using HistoryFile = nlohmann::ordered_json;

constexpr std::size_t largest_history = std::size_t{64} << 20;

std::string hash_of_text(const std::string& text) {
    ByteHash hash;
    hash.add(text.data(), text.size());
    return hash.hex();
}

/// A folder's name may end in a slash.
std::filesystem::path without_slash(const std::filesystem::path& file) {
    return file.has_filename() ? file : file.parent_path();
}

bool is_there(const std::filesystem::path& file) {
    std::error_code failed;
    return std::filesystem::exists(file, failed) || failed;
}

/// The saved text; nullopt if there is no such file.
Result<std::optional<std::string>> read_saved(const std::filesystem::path& file) {
    if (!is_there(file)) return std::optional<std::string>();
    TRY_ASSIGN(auto text, read_given_file(file, file.string(), "a file of segments (JSON, docs/content.md)",
                                          largest_segment_names));
    return std::optional(std::move(text));
}

/// A lock file beside the history, held while a window uses the history.
class HistoryLock : NonCopyable {
public:
    /// Returns whether no other window holds it. A lock file that cannot be made counts as free: then no
    /// history can be written either.
    static bool take(const std::filesystem::path& history, std::shared_ptr<void>& held) {
        auto lock = std::make_shared<HistoryLock>();
        lock->file_ = history;
        lock->file_ += ".lock";
        std::error_code ignored;
        std::filesystem::create_directories(history.parent_path(), ignored);
        for (int tries = 0; tries < 100; ++tries) {
            lock->descriptor_ =
                Descriptor(::open(lock->file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0600));
            const int descriptor = lock->descriptor_.get();
            if (descriptor < 0) return true;
            const bool is_locked = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
            const bool is_of_another = !is_locked && errno == EWOULDBLOCK;
            struct stat now {};
            lock->is_held_ = is_locked && ::fstat(descriptor, &now) == 0 && now.st_nlink > 0;
            if (lock->is_held_) held = lock;
            if (lock->is_held_ || !is_locked) return !is_of_another;
            // Otherwise another window removed it meanwhile.
        }
        return true;
    }
    HistoryLock() = default;
    ~HistoryLock() {
        if (is_held_) ::unlink(file_.c_str());
    }

private:
    std::filesystem::path file_;
    Descriptor descriptor_;
    bool is_held_ = false;
};

}  // namespace

std::optional<BrushTool> brush_tool_of(std::string_view name) {
    for (std::size_t k = 0; k < std::size(brush_tools); ++k)
        if (name == brush_tools[k]) return static_cast<BrushTool>(k);
    return std::nullopt;
}

void HeldBrush::take(BrushTool tool) {
    let_go();
    tool_ = tool;
    if (tool != BrushTool::touch) last_ = tool;
}

void HeldBrush::let_go() {
    is_drawing_ = false;
    places_.clear();
    line_.clear();
}

std::optional<WindowCommand> HeldBrush::press(const Place& place) {
    if (tool_ == BrushTool::cut) {
        let_go();
        is_drawing_ = true;
        move(place);
        return std::nullopt;
    }
    if (!place.pixel) {
        let_go();
        return std::nullopt;
    }
    if (tool_ == BrushTool::paint) return WindowCommand{.verb = WindowVerb::paint, .places = {*place.pixel}};
    if (tool_ != BrushTool::join) return std::nullopt;
    if (!places_.empty()) {
        WindowCommand join{.verb = WindowVerb::join, .places = {places_[0], *place.pixel}};
        let_go();
        return join;
    }
    line_ = {place.at, place.at};
    places_ = {*place.pixel};
    return std::nullopt;
}

void HeldBrush::move(const Place& place) {
    if (tool_ == BrushTool::join && !line_.empty()) line_.back() = place.at;
    if (!is_drawing_ || !place.pixel || places_.size() == most_points) return;
    PixelOfFrame pixel = *place.pixel;
    if (!places_.empty()) pixel.frame = places_[0].frame;  // while it is drawn the clip waits
    if (!places_.empty() && pixel == places_.back()) return;
    places_.push_back(pixel);
    line_.push_back(place.at);
}

std::optional<WindowCommand> HeldBrush::release() {
    if (!is_drawing_) return std::nullopt;
    WindowCommand cut{.verb = WindowVerb::cut, .places = std::move(places_)};
    let_go();
    return cut.places.size() > 1 ? std::optional(std::move(cut)) : std::nullopt;
}
std::array<std::uint8_t, 3> material_colour(std::string_view name) {
    for (const auto& [material, colour] : colours_of_materials)
        if (name == material) return colour;
    return {170, 170, 170};
}

std::filesystem::path BrushFiles::saved() const {
    if (segments) return *segments;
    std::filesystem::path file = without_slash(clip);
    file += ".materials.json";
    return file;
}

std::filesystem::path BrushFiles::history() const {
    if (history_folder.empty()) return {};
    std::error_code failed;
    auto whole = std::filesystem::weakly_canonical(without_slash(clip), failed);
    if (failed) whole = std::filesystem::absolute(clip, failed);
    std::string key = whole.string();
    if (!opened_as.empty()) key += '\n' + opened_as;
    return history_folder / ("brush-" + hash_of_text(key) + ".json");
}

/// Replaces guesses by the saved names of segments.
Result<void> KeptBrush::take_saved(const std::optional<std::string>& text) {
    if (!text) return {};
    TRY_ASSIGN(const auto names, parse_segment_names(*text, files_.saved().string()));
    TRY_ASSIGN(brush_, MaterialBrush::begin(*brush_.painted()->segments, names));
    saved_ = {hash_of_text(*text)};
    return {};
}

/// Fails, changing nothing, if it is no history, or belongs to materials other than the saved ones.
Result<void> KeptBrush::take_history(const std::string& text, const std::optional<std::string>& saved) {
    const std::string where = files_.history().string();
    std::vector<std::string> hashes;
    std::string changes;
    try {
        const HistoryFile json = HistoryFile::parse(text);
        json.at("saved").get_to(hashes);
        json.at("changes").get_to(changes);
    } catch (const HistoryFile::exception&) {
        return input_error(where + ": is no history of a brush");
    }
    if (saved && std::ranges::find(hashes, hash_of_text(*saved)) == hashes.end())
        return input_error(where + ": is of other materials than " + files_.saved().string() + " has now");
    TRY(brush_.repeat(changes, where));
    saved_ = std::move(hashes);
    return {};
}

void KeptBrush::set_history_aside(const Error& why) {
    const auto aside = set_aside(files_.history());
    if (aside) return say(why.message + "; set aside as " + aside->filename().string());
    go_without_history(why.message + "; it stays there, for " + aside.error().message);
}

/// Returns whether a history was loaded.
Result<bool> KeptBrush::find_history(const std::optional<std::string>& saved) {
    const std::filesystem::path file = files_.history();
    if (file.empty()) return false;
    if (!HistoryLock::take(file, held_)) {
        go_without_history("another window has a brush on this clip");
        return false;
    }
    if (!is_there(file)) return false;
    const auto text =
        read_given_file(file, file.string(), "what a brush did in an earlier window", largest_history);
    if (!text) {
        if (text.error().kind == ErrorKind::interrupted) return text.error();
        go_without_history(text.error().message);
        return false;
    }
    const auto taken = take_history(*text, saved);
    if (!taken) {
        if (taken.error().kind == ErrorKind::interrupted) return taken.error();
        set_history_aside(taken.error());
        return false;
    }
    if (const std::size_t count = brush_.done(); count > 0)
        say(counted(count, "change of last time is", "changes of last time are") +
            " here again; undo goes back over " + (count == 1 ? "it" : "them"));
    return true;
}

Result<KeptBrush> KeptBrush::begin(SegmentStore segments, BrushFiles files) {
    TRY_ASSIGN(const auto saved, read_saved(files.saved()));
    TRY_ASSIGN(auto guessed, MaterialBrush::begin(std::move(segments)));
    KeptBrush brush(std::move(guessed), std::move(files));
    TRY_ASSIGN(const auto found, brush.find_history(saved));
    if (found) return brush;
    TRY(brush.take_saved(saved));
    if (saved) brush.say("segments are as " + brush.files_.saved().filename().string() + " has them");
    return brush;
}

bool KeptBrush::is_saved() const {
    if (brush_.done() == 0 && !saved_.empty()) return true;
    const std::string hash = hash_of_text(segment_names_to_json(brush_.names()));
    return std::ranges::find(saved_, hash) != saved_.end();
}

std::string KeptBrush::save() {
    std::string text = segment_names_to_json(brush_.names());
    const std::string hash = hash_of_text(text);
    if (std::ranges::find(saved_, hash) == saved_.end()) saved_.push_back(hash);
    return text;
}

std::string KeptBrush::history() const {
    const HistoryFile json{{"clip", files_.clip.string()}, {"saved", saved_}, {"changes", brush_.history()}};
    return json.dump(2, ' ', false, HistoryFile::error_handler_t::replace) + "\n";
}

}  // namespace touchable
