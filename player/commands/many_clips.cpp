#include "player/commands/many_clips.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <map>
#include <optional>
#include <system_error>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {
namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
    std::error_code ignored;
    return fs::exists(fs::symlink_status(path, ignored));
}

Result<void> make_folder(const fs::path& folder) {
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (fs::is_directory(folder, failure)) return {};
    if (is_there(folder.parent_path()))
        return usage_error("'" + printable(folder.parent_path().string()) + "' is a file, and no folder");
    return usage_error("'" + printable(folder.string()) + "' cannot be made: " + failure.message());
}

/// Where each clip goes.
Result<std::vector<fs::path>> places(const std::vector<fs::path>& clips, const fs::path& folder) {
    std::map<fs::path, fs::path> taken;
    std::vector<fs::path> outs;
    for (const fs::path& clip : clips) {
        outs.push_back(folder / name_in_folder(clip));
        const auto [place, is_new] = taken.emplace(outs.back(), clip);
        if (!is_new)
            return usage_error("'" + printable(place->second.string()) + "' and '" +
                               printable(clip.string()) + "' would both be '" +
                               printable(outs.back().string()) +
                               "'; right would be two folders, one after the other");
    }
    return outs;
}

}  // namespace

fs::path name_in_folder(const fs::path& clip) {
    std::error_code ignored;
    fs::path whole = fs::absolute(clip, ignored).lexically_normal();
    if (!whole.has_filename() || whole.filename() == "scene.json") whole = whole.parent_path();
    std::string name = fs::is_directory(whole, ignored) ? whole.filename().string() : whole.stem().string();
    return (name.empty() ? std::string("clip") : name) + ".mkv";
}

CLI::Option* ManyClips::add_option(CLI::App& sub, const std::string& out) {
    return add_file_option(sub, "OUT", rest,
                           out + "; or further clips, and the folder that all of them go into (FOLDER/)")
        ->expected(1, -1);
}

bool ManyClips::is_for_several() const {
    return rest.size() > 1 || !rest.back().has_filename();
}

Result<void> ManyClips::for_each(const fs::path& first, Existing existing, const One& one) const {
    const fs::path& out = rest.back();
    if (!is_for_several()) return one(first, out);
    // A folder that is there may be a clip, of pictures: that it is meant as a place its name says.
    if (out.has_filename())
        return usage_error("'" + printable(out.string()) +
                           "' is no folder, and several clips go into one; right would be FOLDER/");
    std::vector<fs::path> clips{first};
    clips.insert(clips.end(), rest.begin(), rest.end() - 1);
    TRY_ASSIGN(const auto outs, places(clips, out));
    for (std::size_t k = 0; k < clips.size(); ++k)
        for (const fs::path& clip : clips)
            if (std::error_code ignored; fs::equivalent(clip, outs[k], ignored))
                return usage_error(
                    "'" + printable(outs[k].string()) +
                    "' is one of the clips, and would be written; right would be another folder");
    if (auto made = make_folder(out); !made) return made;
    std::optional<Error> failed;
    std::size_t failures = 0;
    for (std::size_t k = 0; k < clips.size(); ++k) {
        const fs::path& place = outs[k];
        if (existing == Existing::keep && is_there(place)) {
            std::cout << printable(place.string()) << ": is there already\n";
            continue;
        }
        auto done = one(clips[k], place);
        if (done) continue;
        if (done.error().kind == ErrorKind::interrupted) return done;
        if (existing == Existing::keep && is_there(place)) {
            std::cout << printable(place.string()) << ": another program has made it meanwhile\n";
            continue;
        }
        std::cout.flush();
        std::cerr << "touchable: " << done.error().message << '\n';
        if (!failed) failed = done.error();
        ++failures;
    }
    if (!failed) return {};
    failed->message =
        std::to_string(failures) + " of " + std::to_string(clips.size()) + " clips were not made";
    return *failed;
}

}  // namespace touchable
