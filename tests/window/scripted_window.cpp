#include "tests/window/scripted_window.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <utility>

namespace touchable::test {

Outcome run_scripted(const std::vector<std::string>& words, const std::string& script,
                     const std::filesystem::path& folder, const std::string& size) {
    std::ofstream(folder / "script") << script;
    std::vector<std::string> all{"play"};
    all.insert(all.end(), words.begin(), words.end());
    for (const std::string& word : {std::string("--headless"), std::string("--size"), size,
                                    std::string("--script"), std::string("script")})
        all.push_back(word);
    return run_in_folder(all, folder);
}

namespace {

/// In place of one that is missing, so that a test that looks at pixels fails and does not break off.
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

int differences(const Image& a, const Image& b, const PicturePart& part) {
    if (a.width != b.width || a.height != b.height) return -1;
    int count = 0;
    for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x) {
            const auto at = static_cast<std::size_t>((y * a.width + x) * 3);
            bool is_other = false;
            for (std::size_t c = 0; c < 3; ++c)
                is_other = is_other || std::abs(a.samples[at + c] - b.samples[at + c]) > 24;
            count += is_other;
        }
    return count;
}

const std::filesystem::path& made_clip(const std::string& scene, int frames) {
    static const TemporaryFolder folder;
    static std::map<std::pair<std::string, int>, std::filesystem::path> clips;
    auto& clip = clips[{scene, frames}];
    if (!clip.empty()) return clip;
    clip = folder / (scene + std::to_string(frames) + ".mkv");
    const auto made = run_touchable(
        {"make", scene, clip.string(), "--size", "160x120", "--frames", std::to_string(frames)});
    EXPECT_EQ(made.code, 0) << made.err;
    return clip;
}

}  // namespace touchable::test
