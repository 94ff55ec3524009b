#pragma once

// A film as any player sees it: by FFmpeg itself.

#include <filesystem>
#include <vector>

namespace touchable::test {

struct SeenPicture {
    double seconds = 0;
    int width = 0, height = 0;
    std::vector<int> luma;  ///< 16 is black, rows one after the other
    int at(int x, int y) const { return luma[static_cast<std::size_t>(y * width + x)]; }
};

/// Empty where it cannot be opened or decoded.
std::vector<SeenPicture> seen_in_film(const std::filesystem::path& file);

}  // namespace touchable::test
