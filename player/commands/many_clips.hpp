#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace touchable {

/// CLIP OUT, or CLIP CLIP ... FOLDER/ as cp has it: what several clips become lies in the folder, as
/// NAME.mkv. One that is there already is left out, so that work goes on where it was stopped, and several
/// programs may work on the same clips.
struct ManyClips {
    std::vector<std::filesystem::path> rest;  ///< further clips, then OUT

    /// Adds the words after CLIP, and gives them back. `out`: what OUT is.
    CLI::Option* add_option(CLI::App& sub, const std::string& out);

    /// Whether OUT is to be a folder. `rest` is not empty.
    bool is_for_several() const;

    /// Names `out` last: what fails before that leaves none.
    using One =
        std::function<Result<void>(const std::filesystem::path& clip, const std::filesystem::path& out)>;
    /// Does `one` for each of them. Of several, one that fails is told of at once, and the others are done;
    /// then the error is the first one's, with their number.
    Result<void> for_each(const std::filesystem::path& first, Existing existing, const One& one) const;
};

/// What a clip of this name is called in a folder: "a/b.bag" is "b.mkv", and so is "a/b/scene.json".
std::filesystem::path name_in_folder(const std::filesystem::path& clip);

}  // namespace touchable
