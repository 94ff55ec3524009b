#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {

/// Runs `play` without a window (--headless) in `folder`, by its script: `words` are the clips and the
/// options besides. `size`: of the window, as --size has it.
Outcome run_scripted(const std::vector<std::string>& words, const std::string& script,
                     const std::filesystem::path& folder, const std::string& size = "320x240");

/// What became of a window that was run so.
struct Played {
    Outcome outcome;
    Image image{};                     ///< of the window in the end
    std::vector<std::string> files{};  ///< that it left in its folder
};

/// What it shows `seconds` after it opened, in a folder of its own. It has to end well.
Played played_by(const std::vector<std::string>& words, const std::string& script, const std::string& seconds,
                 const std::string& size = "320x240");

/// Likewise of one clip, by the options `more`.
Played shot_of(const std::filesystem::path& clip, const std::string& script, const std::string& seconds,
               std::vector<std::string> more = {});

/// A part of a picture: pixels, without those at the ends.
struct PicturePart {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// How many pixels of a part are unlike, by more than 24 of 255 in a channel; -1: pictures of two sizes.
int differences(const Image& a, const Image& b, const PicturePart& part);

/// The clip that `touchable make SCENE` makes, 160x120, once for all tests of this program.
const std::filesystem::path& made_clip(const std::string& scene, int frames);

}  // namespace touchable::test
