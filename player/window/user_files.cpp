// SPDX-License-Identifier: Apache-2.0
#include "player/window/user_files.hpp"

#include <cerrno>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/view/pointer.hpp"
#include "player/window/play_window.hpp"
#include "player/window/window_files.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool looks_like_clip(const fs::directory_entry& entry) {
    std::error_code failed;
    if (entry.is_directory(failed)) return fs::exists(entry.path() / "scene.json", failed);
    return is_named_as_clip(entry.path());
}

bool by_name(const fs::path& a, const fs::path& b) {
    const std::string x = a.filename().string(), y = b.filename().string();
    const int order = strverscmp(x.c_str(), y.c_str());
    return order != 0 ? order < 0 : x < y;
}

constexpr std::size_t most_settings_bytes = 1 << 20;

Json to_json(const SessionSettings& settings) {
    Json json = Json::object();
    for (const auto& [name, value] : settings.values())
        if (session_setting(name)->of != SettingOf::brush)
            json[name] = parsed_number(value) ? Json::parse(value) : Json(value);
    return json;
}

Json to_json(const KeptSettings& kept) {
    Json json{{"panel", kept.panel},
              {"dent", kept.dent},
              {"light", light_names[static_cast<std::size_t>(kept.light)]},
              {"fingers", kept.fingers},
              {"volume", kept.volume}};
    if (kept.width > 0) json["window"] = {kept.width, kept.height};
    json["a"] = to_json(kept.a);
    if (kept.b) json["b"] = to_json(*kept.b);
    if (!kept.recent.empty()) json["recent"] = kept.recent;
    return json;
}

std::optional<int> whole_in(const Json& json, int least, int most) {
    if (!json.is_number_integer()) return std::nullopt;
    const auto value = json.get<std::int64_t>();
    if (value < least || value > most) return std::nullopt;
    return static_cast<int>(value);
}

/// Reads the valid values of a set; returns the faults of the rest.
std::string read_settings(const std::string& set_name, const Json& json, SessionSettings& settings) {
    if (!json.is_object()) return "'" + set_name + "' must be an object";
    std::string wrong;
    const auto complain = [&](const std::string& what) {
        wrong += (wrong.empty() ? "" : "; ") + ("'" + set_name + "': ") + what;
    };
    // "filters" precedes the settings that override it.
    for (const SessionSetting& setting : session_settings()) {
        const auto member = json.find(setting.name);
        if (setting.of == SettingOf::brush || member == json.end()) continue;
        std::string value = member->is_string() ? member->get<std::string>() : "";
        if (member->is_number()) value = member->dump();
        if (const auto set = settings.set(setting.name, value); !set) complain(set.error().message);
    }
    for (const auto& [name, value] : json.items())
        if (const auto* const known = session_setting(name); !known || known->of == SettingOf::brush)
            complain("'" + printable(name) + "' is unknown");
    return wrong;
}

/// Members of every settings file that a window writes.
constexpr const char* always_written[] = {"panel", "fingers", "a"};

/// Reads a member; returns its fault, or an empty string.
std::string read_member(const std::string& name, const Json& value, KeptSettings& kept) {
    const std::string quoted = "'" + printable(name) + "' ";
    if (name == "panel" || name == "dent") {
        if (!value.is_boolean()) return quoted + "must be true or false";
        (name == "panel" ? kept.panel : kept.dent) = value.get<bool>();
        return "";
    }
    for (const auto& [number, member, least, most] :
         {std::tuple{"fingers", &KeptSettings::fingers, 1, PointerFingers::most},
          {"volume", &KeptSettings::volume, 0, 100}}) {
        if (name != number) continue;
        const auto whole = whole_in(value, least, most);
        if (!whole) return quoted + formatted("must be %d to %d", least, most);
        kept.*member = *whole;
        return "";
    }
    if (name == "light") {
        const auto light = light_after(kept.light, value.is_string() ? value.get<std::string>() : "?");
        if (!light) return quoted + "must be one of " + listed(light_names);
        kept.light = *light;
        return "";
    }
    if (name == "recent") {
        if (!value.is_array() || value.size() > SettingsFile::most_recent ||
            !std::ranges::all_of(value, &Json::is_string))
            return quoted + formatted("must be up to %zu files", SettingsFile::most_recent);
        kept.recent = value.get<std::vector<std::string>>();
        return "";
    }
    if (name == "overlay") return "";  // kept by earlier versions
    if (name == "window") {
        const bool two = value.is_array() && value.size() == 2;
        const auto width =
            two ? whole_in(value[0], SettingsFile::least_width, SettingsFile::most_pixels) : std::nullopt;
        const auto height =
            two ? whole_in(value[1], SettingsFile::least_height, SettingsFile::most_pixels) : std::nullopt;
        if (!width || !height)
            return quoted + "must be width and height in pixels, [320, 200] to [8192, 8192]";
        kept.width = *width;
        kept.height = *height;
        return "";
    }
    if (name == "a") return read_settings(name, value, kept.a);
    if (name == "b") return read_settings(name, value, kept.b.emplace());
    return quoted + "is unknown";
}

/// Resolves a symbolic link, so that the link itself is kept.
fs::path followed(const fs::path& file) {
    std::error_code failed;
    if (!fs::is_symlink(file, failed)) return file;
    const auto target = fs::canonical(file, failed);
    return failed ? file : target;
}

Result<FileList> read_list(const fs::path& folder, const std::vector<std::string>& recent) {
    FileList list;
    std::error_code failed, unknown;
    for (const fs::path file : recent)
        if (fs::exists(file, unknown))
            list.rows.push_back({file.filename().string() + ", in " + file.parent_path().string(), file});
    list.recent = list.rows.size();
    if (folder.empty()) return list;
    list.folder = fs::canonical(folder, failed);
    std::vector<fs::path> folders, clips;
    for (fs::directory_iterator entry(list.folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
        const bool is_clip = looks_like_clip(*entry);
        if (entry->path().filename().string().front() != '.' && (is_clip || entry->is_directory(unknown)))
            (is_clip ? clips : folders).push_back(entry->path());
    }
    if (failed) return input_error(folder.string() + ": cannot be listed: " + failed.message());
    std::ranges::sort(folders, by_name);
    std::ranges::sort(clips, by_name);
    list.rows.push_back({"../", list.folder.parent_path(), true});
    for (const fs::path& one : folders) list.rows.push_back({one.filename().string() + "/", one, true});
    for (const fs::path& one : clips) list.rows.push_back({one.filename().string(), one});
    list.rows.push_back({"open this folder", list.folder});
    return list;
}

}  // namespace

std::vector<fs::path> clips_of(const fs::path& named) {
    std::error_code failed;
    if (!fs::is_directory(named, failed)) return {named};
    std::vector<fs::path> clips;
    for (fs::directory_iterator entry(named, failed), end; !failed && entry != end; entry.increment(failed))
        if (entry->path().filename().string().front() != '.' && looks_like_clip(*entry))
            clips.push_back(entry->path());
    // A folder of pictures may also contain videos.
    if (clips.empty() || fs::exists(named / "scene.json", failed) || guess_clip(named, {})) return {named};
    std::ranges::sort(clips, by_name);
    return clips;
}

Result<FileList> list_files(const fs::path& folder, const std::vector<std::string>& recent) {
    auto list = unless_stopped([folder, recent] { return read_list(folder, recent); });
    return list ? std::move(*list) : Result<FileList>(interrupted_error());
}

const ClipChoice* Playlist::go(int by) {
    const bool is_end = by > 0 ? place_ + 1 >= clips_.size() : place_ == 0;
    if (is_end && !(wraps_ && clips_.size() > 1)) return nullptr;
    place_ = (place_ + (by > 0 ? 1 : clips_.size() - 1)) % clips_.size();
    return &clips_[place_];
}

Result<fs::path> own_settings_file() {
    TRY_ASSIGN(const auto folder, own_folder("XDG_CONFIG_HOME", ".config"));
    return folder / "play.json";
}

SettingsFile::SettingsFile(fs::path file) : file_(std::move(file)) {
    std::error_code failed;
    if (!fs::exists(file_, failed) && !failed) return;
    const auto text = read_given_file(file_, file_.string(), "a file of settings", most_settings_bytes);
    if (text) {
        take(*text);
        return;
    }
    is_foreign_ = true;
    message_ = text.error().message + "; it is left alone";
}

void SettingsFile::take(const std::string& text) {
    const Json json = Json::parse(text, nullptr, false);
    if (!json.is_object()) {
        const auto aside = set_aside(file_);
        is_foreign_ = !aside;
        const std::string where = aside ? "set aside as " + aside->filename().string()
                                        : "it stays there, and nothing is kept: " + aside.error().message;
        message_ = file_.string() + ": is no JSON object; " + where;
        return;
    }
    // Another program's file, named by mistake, may share a member or two with ours.
    const bool was_written_here =
        std::ranges::all_of(always_written, [&](const char* name) { return json.contains(name); });
    std::string wrong_members;
    for (const auto& [name, value] : json.items())
        if (const std::string wrong = read_member(name, value, read_); !wrong.empty())
            wrong_members += (wrong_members.empty() ? "" : "; ") + wrong;
    if (wrong_members.empty()) return;
    is_foreign_ = !was_written_here;
    message_ = is_foreign_
                   ? file_.string() +
                         ": is no file of settings, or another program's: " + printable(wrong_members, 200) +
                         "; it is left alone, and nothing is kept in it"
                   : file_.filename().string() + ": " + wrong_members + "; ignored";
}

Result<void> SettingsFile::write(const KeptSettings& settings) const {
    if (file_.empty() || is_foreign_ || (settings == read_ && message_.empty())) return {};
    // Names of recent files may be of any bytes.
    return write_text(followed(file_),
                      to_json(settings).dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
}

Result<fs::path> set_aside(const fs::path& file) {
    constexpr int most_set_aside = 100;
    int failed = EEXIST;
    for (int k = 1; k <= most_set_aside && failed == EEXIST; ++k) {
        fs::path aside = file;
        aside += k == 1 ? ".broken" : ".broken" + std::to_string(k);
        failed = move_to_free_name(file, aside);
        if (failed == 0) return aside;
    }
    return input_error("it cannot be set aside (" + failure_words(failed) + ")");
}

}  // namespace touchable
