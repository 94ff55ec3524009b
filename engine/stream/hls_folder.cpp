#include "engine/stream/hls_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "engine/base/new_file.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/stream/hls_text.hpp"

namespace touchable {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t run_digits = 8, largest_playlist = std::size_t{1} << 22;

bool is_of(std::string_view text, std::string_view letters) {
    return text.find_first_not_of(letters) == std::string_view::npos;
}

/// A segment or a header, of any run.
bool is_segment_name(std::string_view name) {
    for (const std::string_view rendition : {"colour-low-", "touch-low-", "colour-", "touch-"}) {
        if (!name.starts_with(rendition)) continue;
        name.remove_prefix(rendition.size());
        if (name.size() < run_digits + 2 || !is_of(name.substr(0, run_digits), "0123456789abcdef") ||
            name[run_digits] != '-')
            return false;
        name.remove_prefix(run_digits + 1);
        return name == "init.mp4" || (name.ends_with(".m4s") && name.size() > 4 &&
                                      is_of(name.substr(0, name.size() - 4), "0123456789"));
    }
    return false;
}

bool is_playlist_name(std::string_view name) {
    return name == hls_master_name || name == hls_colour_name || name == hls_touch_name ||
           name == hls_low_colour_name || name == hls_low_touch_name;
}

std::string text_of_playlist(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string text(largest_playlist, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
}

/// What a program leaves that was killed while it gave a file its name (NewFile).
bool is_unfinished(std::string_view name) {
    return name.starts_with(".unfinished-");
}

}  // namespace

HlsFolder::HlsFolder(HlsFolder&& other) noexcept
    : path_(std::move(other.path_)),
      opened_(std::exchange(other.opened_, -1)),
      lasts_(other.lasts_),
      run_(std::move(other.run_)),
      first_segment_(other.first_segment_),
      old_(std::move(other.old_)),
      retired_(std::move(other.retired_)) {}

HlsFolder::~HlsFolder() {
    if (opened_ >= 0) close(opened_);
}

Result<HlsFolder> HlsFolder::open(const fs::path& path, bool lasts) {
    HlsFolder folder;
    folder.path_ = path;
    folder.lasts_ = lasts;
    // of a random name its last digits
    const std::string random = hidden_name(path).filename().string();
    folder.run_ = random.substr(random.size() - run_digits);
    std::error_code failure;
    fs::create_directories(path, failure);
    folder.opened_ = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder.opened_ < 0)
        return input_error(path.string() + ": is no folder that can be made or read: " +
                           std::generic_category().message(errno));
    if (flock(folder.opened_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return input_error(path.string() + ": another program writes a stream there now");
    TRY(folder.look());
    return folder;
}

Result<void> HlsFolder::look() {
    std::error_code failure;
    for (fs::directory_iterator at(path_, failure), end; !failure && at != end; at.increment(failure)) {
        const std::string name = at->path().filename().string();
        const bool is_file = at->symlink_status().type() == fs::file_type::regular;
        if (is_file && is_unfinished(name)) continue;
        bool is_ours = is_file && is_segment_name(name);
        if (is_ours) old_.push_back(name);
        if (is_file && is_playlist_name(name)) {
            const std::string text = text_of_playlist(at->path());
            is_ours = text.find(std::string(hls_mark) + "\n") != std::string::npos;
            first_segment_ = std::max(first_segment_, next_segment_of(text));
        }
        if (!is_ours)
            return input_error(path_.string() + ": has " + in_quotes(name) +
                               ", which is not of a stream that this program wrote; must be a folder that is "
                               "new or empty, or has such a stream alone");
    }
    if (failure) return input_error(path_.string() + ": cannot be read: " + failure.message());
    return {};
}

std::string HlsFolder::header_name(std::string_view rendition) const {
    return std::string(rendition) + "-" + run_ + "-init.mp4";
}

std::string HlsFolder::segment_name(std::string_view rendition, std::int64_t number) const {
    return std::string(rendition) + "-" + run_ + "-" + std::to_string(number) + ".m4s";
}

Result<void> HlsFolder::put(const std::string& name, std::string_view bytes) const {
    NewFile file(path_ / name);
    if (!lasts_) file.need_not_last();
    if (auto written = file.write(bytes); !written) return written;
    return file.commit();
}

void HlsFolder::retire_old(std::int64_t time_ns) {
    for (std::string& name : old_) retire(std::move(name), time_ns);
    old_.clear();
}

void HlsFolder::remove_retired(std::int64_t before_ns) {
    while (!retired_.empty() && retired_.front().time_ns <= before_ns) {
        unlink((path_ / retired_.front().name).c_str());
        retired_.pop_front();
    }
}

}  // namespace touchable
