#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace touchable::test {

/// How a clip is written again, not as this project would: for clips that must be refused.
struct Remux {
    std::map<std::string, std::string> file_tags{};  ///< set; an empty value removes the tag
    std::map<std::string, std::string>
        roles{};  ///< role -> new tag T3D_ROLE; an empty value removes the track
    std::map<std::string, std::string> transcoded{};  ///< role -> codec, "mjpeg" or "mpeg4"; both 4:2:0
    int transcoded_scale = 1;                         ///< size of transcoded pictures over the original's
    std::string attachment_name{};                    ///< if not empty, the scene's new name
    bool checksums = true;                            ///< whether headers and tags carry CRC-32 elements
    /// Packets to leave out.
    std::function<bool(const std::string& role, int number)> drop = [](const std::string&, int) {
        return false;
    };
};

void remux(const std::filesystem::path& from, const std::filesystem::path& to, const Remux& changes);

/// The bytes of every packet, track after track.
std::vector<std::string> packets(const std::filesystem::path& clip);

}  // namespace touchable::test
