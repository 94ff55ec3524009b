#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// The folder from which a web server delivers a stream. It holds nothing but files of ours, which are known
/// by their names, playlists also by a line in them (hls_text.hpp):
///   master.m3u8, colour.m3u8, touch.m3u8, colour-low.m3u8, touch-low.m3u8
///   colour-RUN-init.mp4, colour-RUN-NUMBER.m4s, and the same of the others; RUN: 8 hexadecimal digits.
/// So no file of another run, which a cache may have, ever has the name of one of this run.
class HlsFolder {
public:
    /// Makes it where it is not there. Refused (ErrorKind::input): a folder with anything else in it, and one
    /// in which another program is at work. `lasts`: its files are to be safe on the disk.
    static Result<HlsFolder> open(const std::filesystem::path& folder, bool lasts);
    ~HlsFolder();
    HlsFolder(HlsFolder&& other) noexcept;
    HlsFolder& operator=(HlsFolder&&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// "touch-3f2a91bc-init.mp4".
    std::string header_name(std::string_view rendition) const;
    /// "touch-3f2a91bc-12.m4s".
    std::string segment_name(std::string_view rendition, std::int64_t number) const;
    /// The number from which segments count, so that those who watched the run before go on.
    std::int64_t first_segment() const { return first_segment_; }

    /// The whole file at once, in place of any other of that name.
    Result<void> put(const std::string& name, std::string_view bytes) const;
    /// No playlist names it any more from `time_ns` of the stream on.
    void retire(std::string name, std::int64_t time_ns) { retired_.push_back({std::move(name), time_ns}); }
    /// The same of all files of runs before.
    void retire_old(std::int64_t time_ns);
    /// Deletes what no playlist has named since then.
    void remove_retired(std::int64_t before_ns);

private:
    HlsFolder() = default;
    Result<void> look();

    struct Retired {
        std::string name;
        std::int64_t time_ns;
    };
    std::filesystem::path path_;
    int opened_ = -1;  // and locked
    bool lasts_ = true;
    std::string run_;
    std::int64_t first_segment_ = 0;
    std::vector<std::string> old_;  // segments and headers of runs before
    std::deque<Retired> retired_;
};

}  // namespace touchable
