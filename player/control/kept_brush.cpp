#include "player/control/kept_brush.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine/byte_hash.hpp"
#include "engine/given_file.hpp"

namespace touchable {
namespace {

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

/// Nothing where there is none.
Result<std::optional<std::string>> read_saved(const std::filesystem::path& file) {
    if (!is_there(file)) return std::optional<std::string>();
    auto text = read_given_file(file, file.string(), "a file of segments (JSON, docs/content.md)",
                                largest_segment_names);
    if (!text.ok()) return text.error();
    return std::optional(std::move(*text));
}

}  // namespace

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
    return history_folder / ("brush-" + hash_of_text(whole.string()) + ".json");
}

void KeptBrush::say(const std::string& words) {
    words_ += (words_.empty() ? "" : "; ") + words;
}

/// Names of segments, in place of guesses.
Result<void> KeptBrush::take_saved(const std::optional<std::string>& text) {
    if (!text) return {};
    const auto names = parse_segment_names(*text, files_.saved().string());
    if (!names.ok()) return names.error();
    auto begun = MaterialBrush::begin(*brush_.painted()->segments, *names);
    if (!begun.ok()) return begun.error();
    brush_ = std::move(*begun);
    saved_ = {hash_of_text(*text)};
    return {};
}

/// Refused where it is none, or of other materials than are saved now; then nothing is changed.
Result<void> KeptBrush::take_history(const std::filesystem::path& file,
                                     const std::optional<std::string>& saved) {
    const auto text =
        read_given_file(file, file.string(), "what a brush did in an earlier window", largest_history);
    if (!text.ok()) return text.error();
    std::vector<std::string> hashes;
    std::string changes;
    try {
        const HistoryFile json = HistoryFile::parse(*text);
        json.at("saved").get_to(hashes);
        json.at("changes").get_to(changes);
    } catch (const HistoryFile::exception&) {
        return input_error(file.string() + ": is no history of a brush");
    }
    if (saved && std::find(hashes.begin(), hashes.end(), hash_of_text(*saved)) == hashes.end())
        return input_error(file.string() + ": is of other materials than " + files_.saved().string() +
                           " has now");
    if (auto repeated = brush_.repeat(changes, file.string()); !repeated.ok()) return repeated;
    saved_ = std::move(hashes);
    return {};
}

Result<KeptBrush> KeptBrush::begin(SegmentStore segments, BrushFiles files) {
    const auto saved = read_saved(files.saved());
    if (!saved.ok()) return saved.error();
    auto guessed = MaterialBrush::begin(std::move(segments));
    if (!guessed.ok()) return guessed.error();
    KeptBrush brush(std::move(*guessed), std::move(files));
    const std::filesystem::path file = brush.files_.history();
    std::string refused;
    if (!file.empty() && is_there(file)) {
        const auto taken = brush.take_history(file, *saved);
        if (taken.ok()) {
            if (const std::size_t count = brush.brush_.done(); count > 0)
                brush.say((count == 1 ? "1 change" : std::to_string(count) + " changes") + " of last time " +
                          (count == 1 ? "is" : "are") + " here again; undo goes back over " +
                          (count == 1 ? "it" : "them"));
            return brush;
        }
        std::filesystem::path aside = file;
        aside += ".broken";
        std::error_code failed;
        std::filesystem::rename(file, aside, failed);
        refused = taken.error().message +
                  (failed ? "; it stays there" : "; set aside as " + aside.filename().string());
    }
    if (auto taken = brush.take_saved(*saved); !taken.ok()) return taken.error();
    if (*saved) brush.say("segments are as " + brush.files_.saved().filename().string() + " has them");
    if (!refused.empty()) brush.say(refused);
    return brush;
}

std::string KeptBrush::save() {
    std::string text = segment_names_to_json(brush_.names());
    const std::string hash = hash_of_text(text);
    if (std::find(saved_.begin(), saved_.end(), hash) == saved_.end()) saved_.push_back(hash);
    return text;
}

std::string KeptBrush::history() const {
    const HistoryFile json{{"clip", files_.clip.string()}, {"saved", saved_}, {"changes", brush_.history()}};
    return json.dump(2, ' ', false, HistoryFile::error_handler_t::replace) + "\n";
}

}  // namespace touchable
