// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/picture/image.hpp"
#include "player/window/play_window.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {

/// Whether a text has this part. A failure shows both.
inline testing::AssertionResult contains(const std::string& text, const std::string& part) {
    const bool is_there = text.find(part) != std::string::npos;
    return testing::AssertionResult(is_there) << "'" << part << "' and '" << text << "'";
}

/// Waits until the condition holds, far longer than any machine takes; false: it never did.
template <class Condition>
bool comes_true(const Condition& condition, int most_ms = 20'000) {
    for (int k = 0; k < most_ms; ++k) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
}

/// A window of 320x240 in this process, without a display, that the CPU builds and draws.
inline PlayOptions headless_by_cpu(const std::filesystem::path& clip) {
    PlayOptions options;
    options.session.clip.file = clip;
    options.session.builder.name = options.painter = "cpu";
    options.headless = true;
    options.screen.width = 320;
    options.screen.height = 240;
    return options;
}

/// The inputs that these lines of a script say.
inline std::vector<ScriptedInput> inputs_of(const std::string& script) {
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << script;
    auto inputs = read_window_script(folder / "script");
    EXPECT_TRUE(inputs) << inputs.error().message;
    return inputs ? std::move(*inputs) : std::vector<ScriptedInput>();
}

/// Runs `play` without a window (--headless) in `folder`, by its script: `words` are the clips and the
/// options besides. `size`: of the window, as --size has it.
Outcome run_scripted(const std::vector<std::string>& words, const std::string& script,
                     const std::filesystem::path& folder, const std::string& size = "320x240");

/// Runs `actions` (of bash, with xdotool) in `folder` while the program with `words` has a window, and gives
/// the program's exit code. `display`: bash that starts a display as $server and exports its name.
int run_on_display(const std::filesystem::path& folder, const std::string& display, const std::string& words,
                   const std::string& actions);

/// Runs the program, which has to end with this exit code and one line that has the part.
void expect_refused(const std::vector<std::string>& words, int code, const std::string& part = "");

/// The results of a window that was run so.
struct Played {
    Outcome outcome;
    Image image{};                     ///< of the window in the end
    std::vector<std::string> files{};  ///< that it left in its folder
};

/// Runs it for so many seconds in a folder of its own. It has to end well.
Played played_by(const std::vector<std::string>& words, const std::string& script, const std::string& seconds,
                 const std::string& size = "320x240");

/// The same of one clip, by the options `more`.
Played shot_of(const std::filesystem::path& clip, const std::string& script, const std::string& seconds,
               std::vector<std::string> more = {});

/// A part of a picture: pixels, without those at the ends.
struct PicturePart {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// How many pixels of a part are unlike, by more than `most` of 255 in a channel; -1: pictures of two sizes.
int differences(const Image& a, const Image& b, const PicturePart& part, int most = 24);

/// Red, green and blue of a pixel.
std::vector<int> colour_at(const Image& image, int x, int y);

/// Rows of the bar's dark ground in the middle column, over bright bumps.
int bar_height(const Image& image);

/// `touchable make`. It has to end well.
void make_clip(const std::filesystem::path& file, const std::string& scene, int frames,
               const std::string& size = "64x48");
/// The clip that it makes of 160x120, once for all tests of this program.
const std::filesystem::path& made_clip(const std::string& scene, int frames);

/// What `touchable touch --replay --json -` tells of a recording in `folder`: it repeats to the bit, and
/// something was touched.
std::string replayed(const std::filesystem::path& folder, const std::string& recording);

/// A clip that a test writes, in windows by scripts in the clip's folder.
class ScriptedClipTest : public ::testing::Test {
protected:
    ScriptedClipTest(std::string size, std::string shot_s)
        : size_(std::move(size)), shot_s_(std::move(shot_s)) {}
    Outcome run(const std::string& script, const std::vector<std::string>& more = {});
    /// The window's picture `shot_s` seconds after it opened.
    Image shot(const std::string& script, const std::vector<std::string>& more = {});

    const TemporaryFolder folder_;
    const std::filesystem::path clip_ = folder_ / "wall.mkv";

private:
    const std::string size_, shot_s_;
};

}  // namespace touchable::test
