// SPDX-License-Identifier: Apache-2.0
#include "tests/window/scripted_window.hpp"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <utility>

namespace touchable::test {

Outcome run_scripted(const std::vector<std::string>& words, const std::string& script,
                     const std::filesystem::path& folder, const std::string& size) {
    std::ofstream(folder / "script") << script;
    std::vector<std::string> all{"play"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"--headless", "--size", size, "--script", "script"});
    return run_in_folder(all, folder);
}

int run_on_display(const std::filesystem::path& folder, const std::string& display, const std::string& words,
                   const std::string& actions) {
    std::ofstream(folder / "run.sh") << "cd '" << folder.string() << "'\n"
                                     << display << R"(
"$PROGRAM" )" << words << R"( >out 2>err & program=$!
timeout 60 xdotool search --sync --onlyvisible --name touchable >window || { kill $program; exit 98; }
xdotool windowmove $(head -1 window) 0 0
for k in $(seq 600); do  # until the clip is open
    title=$(xdotool getwindowname $(head -1 window))
    [[ $title == *' - touchable' && $title != *...* ]] && break
    sleep 0.1
done
)" << actions << "\nwait $program\n";
    const std::string run = "PROGRAM='" TOUCHABLE_PROGRAM "' bash '" + (folder / "run.sh").string() + "'";
    const int status = std::system(run.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void expect_refused(const std::vector<std::string>& words, int code, const std::string& part) {
    const Outcome refused = run_touchable(words);
    EXPECT_EQ(refused.code, code) << refused.err;
    EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
    EXPECT_TRUE(contains(refused.err, part));
}

namespace {

/// Replaces a missing picture, so that a test of its pixels fails and does not crash.
Image black_picture(const std::string& size) {
    int width = 0, height = 0;
    std::sscanf(size.c_str(), "%dx%d", &width, &height);
    const auto samples = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3;
    return {width, height, 1, 3, std::vector<std::uint8_t>(samples)};
}

}  // namespace

Played played_by(const std::vector<std::string>& words, const std::string& script, const std::string& seconds,
                 const std::string& size) {
    const TemporaryFolder folder;
    std::vector<std::string> all = words;
    all.insert(all.end(), {"--screenshot", "end.png", "--at", seconds});
    Played played{.outcome = run_scripted(all, script, folder.path(), size)};
    EXPECT_EQ(played.outcome.code, 0) << played.outcome.err;
    played.files = names_in(folder.path());
    const auto image = read_image(folder / "end.png");
    EXPECT_TRUE(image);
    played.image = image ? *image : black_picture(size);
    return played;
}

Played shot_of(const std::filesystem::path& clip, const std::string& script, const std::string& seconds,
               std::vector<std::string> more) {
    more.insert(more.begin(), clip.string());
    return played_by(more, script, seconds);
}

int differences(const Image& a, const Image& b, const PicturePart& part, int most) {
    if (a.width != b.width || a.height != b.height) return -1;
    int count = 0;
    for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x) {
            const auto at = static_cast<std::size_t>((y * a.width + x) * 3);
            bool is_other = false;
            for (std::size_t c = 0; c < 3; ++c)
                is_other = is_other || std::abs(a.samples[at + c] - b.samples[at + c]) > most;
            count += is_other;
        }
    return count;
}

std::vector<int> colour_at(const Image& image, int x, int y) {
    const auto at = static_cast<std::size_t>((y * image.width + x) * 3);
    return {image.samples[at], image.samples[at + 1], image.samples[at + 2]};
}

int bar_height(const Image& image) {
    int rows = 0;
    for (int y = image.height / 2; y < image.height; ++y) {
        const auto colour = colour_at(image, image.width / 2, y);
        rows += colour[0] < 90 && colour[1] < 90;
    }
    return rows;
}

void make_clip(const std::filesystem::path& file, const std::string& scene, int frames,
               const std::string& size) {
    const auto made =
        run_touchable({"make", scene, file.string(), "--size", size, "--frames", std::to_string(frames)});
    EXPECT_EQ(made.code, 0) << made.err;
}

const std::filesystem::path& made_clip(const std::string& scene, int frames) {
    static const TemporaryFolder folder;
    static std::map<std::pair<std::string, int>, std::filesystem::path> clips;
    auto& clip = clips[{scene, frames}];
    if (!clip.empty()) return clip;
    clip = folder / (scene + std::to_string(frames) + ".mkv");
    make_clip(clip, scene, frames, "160x120");
    return clip;
}

std::string replayed(const std::filesystem::path& folder, const std::string& recording) {
    const auto again = run_in_folder({"touch", "--replay", recording, "--json", "-"}, folder);
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_TRUE(contains(again.err, "as recorded, to the bit"));
    const std::string of_all_parts = again.out.substr(0, again.out.find("\"parts\""));
    EXPECT_FALSE(contains(of_all_parts, "\"contact_ticks\": 0,")) << "nothing was touched";
    return again.out;
}

Outcome ScriptedClipTest::run(const std::string& script, const std::vector<std::string>& more) {
    std::vector<std::string> words{clip_.string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_scripted(words, script, folder_.path(), size_);
}

Image ScriptedClipTest::shot(const std::string& script, const std::vector<std::string>& more) {
    std::vector<std::string> words{"--screenshot", "shot.png", "--at", shot_s_, "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome done = run(script, words);
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    const auto image = read_image(folder_ / "shot.png");
    EXPECT_TRUE(image);
    return image ? *image : black_picture(size_);
}

}  // namespace touchable::test
