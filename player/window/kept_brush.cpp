#include "player/window/kept_brush.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine/base/byte_hash.hpp"
#include "engine/base/given_file.hpp"
#include "engine/base/try.hpp"
#include "player/window/set_aside.hpp"

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
    TRY_ASSIGN(auto text, read_given_file(file, file.string(), "a file of segments (JSON, docs/content.md)",
                                          largest_segment_names));
    return std::optional(std::move(text));
}

/// A file beside the history, there as long as somebody holds it.
class HistoryLock {
public:
    /// Whether it is free. One that cannot be made holds nobody up: then no history can be written either.
    static bool take(const std::filesystem::path& history, std::shared_ptr<void>& held) {
        auto lock = std::make_shared<HistoryLock>();
        lock->file_ = history;
        lock->file_ += ".lock";
        std::error_code ignored;
        std::filesystem::create_directories(history.parent_path(), ignored);
        for (int tries = 0; tries < 100; ++tries) {
            lock->descriptor_ = ::open(lock->file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0600);
            if (lock->descriptor_ < 0) return true;
            const bool is_locked = ::flock(lock->descriptor_, LOCK_EX | LOCK_NB) == 0;
            const bool is_of_another = !is_locked && errno == EWOULDBLOCK;
            struct stat now {};
            lock->is_held_ = is_locked && ::fstat(lock->descriptor_, &now) == 0 && now.st_nlink > 0;
            if (lock->is_held_) held = lock;
            if (lock->is_held_ || !is_locked) return !is_of_another;
            ::close(std::exchange(lock->descriptor_, -1));  // somebody removed it meanwhile
        }
        return true;
    }
    HistoryLock() = default;
    HistoryLock(const HistoryLock&) = delete;
    HistoryLock& operator=(const HistoryLock&) = delete;
    ~HistoryLock() {
        if (is_held_) ::unlink(file_.c_str());
        if (descriptor_ >= 0) ::close(descriptor_);
    }

private:
    std::filesystem::path file_;
    int descriptor_ = -1;
    bool is_held_ = false;
};

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
    std::string key = whole.string();
    if (!opened_as.empty()) key += '\n' + opened_as;
    return history_folder / ("brush-" + hash_of_text(key) + ".json");
}

void KeptBrush::say(const std::string& words) {
    words_ += (words_.empty() ? "" : "; ") + words;
}

/// Names of segments, in place of guesses.
Result<void> KeptBrush::take_saved(const std::optional<std::string>& text) {
    if (!text) return {};
    TRY_ASSIGN(const auto names, parse_segment_names(*text, files_.saved().string()));
    TRY_ASSIGN(auto begun, MaterialBrush::begin(*brush_.painted()->segments, names));
    brush_ = std::move(begun);
    saved_ = {hash_of_text(*text)};
    return {};
}

/// Refused where it is none, or of other materials than are saved now; then nothing is changed.
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
    if (saved && std::find(hashes.begin(), hashes.end(), hash_of_text(*saved)) == hashes.end())
        return input_error(where + ": is of other materials than " + files_.saved().string() + " has now");
    if (auto repeated = brush_.repeat(changes, where); !repeated.ok()) return repeated;
    saved_ = std::move(hashes);
    return {};
}

std::filesystem::path KeptBrush::history_file() const {
    return keeps_history_ ? files_.history() : std::filesystem::path();
}

void KeptBrush::go_without_history(const std::string& why) {
    keeps_history_ = false;
    say(why + "; what is done now is not kept beyond this window, unless it is saved");
}

void KeptBrush::set_history_aside(const Error& why) {
    const auto aside = set_aside(files_.history());
    if (aside.ok()) return say(why.message + "; set aside as " + aside->filename().string());
    go_without_history(why.message + "; it stays there, for " + aside.error().message);
}

/// Whether it goes on with one.
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
    if (!text.ok() && text.error().kind == ErrorKind::interrupted) return text.error();
    if (!text.ok()) {
        go_without_history(text.error().message);
        return false;
    }
    const auto taken = take_history(*text, saved);
    if (!taken.ok() && taken.error().kind == ErrorKind::interrupted) return taken.error();
    if (!taken.ok()) {
        set_history_aside(taken.error());
        return false;
    }
    if (const std::size_t count = brush_.done(); count > 0)
        say((count == 1 ? "1 change" : std::to_string(count) + " changes") + " of last time " +
            (count == 1 ? "is" : "are") + " here again; undo goes back over " + (count == 1 ? "it" : "them"));
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
    return std::find(saved_.begin(), saved_.end(), hash) != saved_.end();
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
