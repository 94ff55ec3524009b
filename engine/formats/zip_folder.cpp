// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/zip_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/picture/zip_archive.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t most_members = 100'000, gibibyte = std::uint64_t{1} << 30;
constexpr std::uint64_t largest_unpacked = 16 * gibibyte, left_on_disk = gibibyte;
/// Bytes of a member that is no picture or video by its name: a camera's file, a list, a scene.
constexpr std::uint64_t largest_sidecar = std::uint64_t{16} << 20;
constexpr std::ptrdiff_t most_folders_deep = 64, most_folders = 10'000;
/// Bytes of disk that a folder takes, a file's entry, and by which a file grows.
constexpr std::uint64_t disk_block = 4096;

bool is_named_zip(const fs::path& file) {
    const std::string name = small_letters(file.filename().string());
    return name.ends_with(".zip") && !name.ends_with(".zarr.zip");
}

/// Whether a member is hidden or added by macOS, and so belongs to no clip.
bool is_hidden_below(const fs::path& name) {
    return std::ranges::any_of(name, [](const fs::path& part) {
        const std::string word = part.string();
        return word == "__MACOSX" || (word.starts_with('.') && word != "." && word != "..");
    });
}

/// Why a member cannot be unpacked under its name; empty: it can.
std::string unsafe_name(const std::string& name) {
    if (name.find('\\') != std::string::npos) return "has a backslash in its name";
    if (std::ranges::any_of(name, [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        return "has a control character in its name";
    const fs::path path(name);
    const bool leads_out =
        path.empty() || path.is_absolute() ||
        std::ranges::any_of(path, [](const fs::path& part) { return part == ".." || part == "."; });
    if (std::distance(path.begin(), path.end()) > most_folders_deep + 1)
        return "lies more than " + std::to_string(most_folders_deep) + " folders deep";
    return leads_out ? "has a name that leads out of the archive" : "";
}

std::string unzip_words(const fs::path& archive) {
    const std::string stem = shell_word(archive.stem().string());
    return "unzip " + shell_word(archive.string()) + " -d " + stem + ", then: touchable play " + stem;
}

bool is_below(const fs::path& file, const fs::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

struct OpenedZip {
    ZipArchive archive;
    std::vector<ZipMember> wanted{};  ///< that a clip may need
    bool has_pictures = false;        ///< other than arrays, which a .npz has
};

Result<OpenedZip> open_archive(const fs::path& file) {
    TRY_ASSIGN(auto bytes, bytes_of_file(SourceFile(file)));
    TRY_ASSIGN(auto archive, open_zip(std::move(bytes), most_members, file.string()));
    OpenedZip opened{std::move(archive)};
    for (ZipMember& member : zip_members(opened.archive)) {
        if (stop_requested()) break;
        const fs::path name = fs::path(member.name).lexically_normal();
        member.name = name.string();
        const bool is_array = name.extension() == ".npy" || name.extension() == ".npz";
        const bool is_big = is_array || is_named_as_picture(name) || is_named_as_clip(name);
        if (!member.is_file || is_hidden_below(name) || (!is_big && member.size > largest_sidecar)) continue;
        opened.has_pictures = opened.has_pictures || (is_named_as_picture(name) && !is_array);
        opened.wanted.push_back(std::move(member));
    }
    if (stop_requested()) return error_at(file.string(), interrupted_error());
    return opened;
}

/// The members' folder to open: that of a scene file; the only one with folders of pictures named depth, or
/// of pictures; or else the deepest with all members in it.
fs::path folder_of_clip(const std::vector<ZipMember>& members) {
    std::set<fs::path> of_depth, of_pictures;
    fs::path common = fs::path(members.front().name).parent_path();
    for (const ZipMember& member : members) {
        if (stop_requested()) break;
        const fs::path name(member.name), folder = name.parent_path();
        if (name.filename() == "scene.json") return folder;
        while (!is_below(folder, common)) common = common.parent_path();
        if (!is_named_as_picture(name)) continue;
        of_pictures.insert(folder.parent_path());
        if (has_word((folder.filename() / name.filename()).string(), {"depth"}))
            of_depth.insert(folder.parent_path());
    }
    const auto& telling = of_depth.size() == 1 ? of_depth : of_pictures;
    if (telling.size() != 1 || !is_below(common, *telling.begin()))
        return telling.size() == 1 ? *telling.begin() : common;
    return has_word(common.filename().string(), {"depth"}) ? *telling.begin() : common;
}

/// Bytes of a folder's disk that may be taken.
std::uint64_t disk_room(const fs::path& folder) {
    std::error_code failure;
    const std::uint64_t free = fs::space(folder, failure).available;
    return failure || free < left_on_disk ? 0 : free - left_on_disk;
}

/// Refuses members that would take too much of the disk, or cannot be unpacked safely.
Result<void> check_sizes(const std::vector<ZipMember>& members, const fs::path& archive,
                         const fs::path& folder) {
    std::uint64_t size = 0, on_disk = 0;
    std::set<std::string> folders;
    for (const ZipMember& member : members) {
        if (stop_requested()) return error_at(archive.string(), interrupted_error());
        const std::string where = archive.string() + '/' + printable(member.name, 200);
        if (member.is_encrypted)
            return input_error(where + ": is encrypted: unpack it with its password, then open the folder");
        if (const std::string why = unsafe_name(member.name); !why.empty())
            return input_error(archive.string() + ": its member " + in_quotes(member.name) + ' ' + why +
                               ": it is not unpacked");
        if (!member.is_possible())
            return input_error(where + ": is damaged: " + std::to_string(member.packed) +
                               " bytes are said to unpack to " + std::to_string(member.size));
        size += std::min(member.size, 2 * largest_unpacked);
        on_disk += (std::min(member.size, 2 * largest_unpacked) / disk_block + 2) * disk_block;
        fs::path above = fs::path(member.name).parent_path();
        for (; !above.empty() && folders.insert(above.string()).second; above = above.parent_path())
            on_disk += disk_block;
        if (std::ssize(folders) > most_folders)
            return input_error(archive.string() + ": has more than " + std::to_string(most_folders) +
                               " folders: " + unzip_words(archive));
    }
    std::error_code failure;
    const std::uint64_t room = disk_room(folder);
    const std::uint64_t packed = fs::file_size(archive, failure);
    constexpr std::uint64_t most_for_a_byte = 1032, few = std::uint64_t{64} << 20;
    if (!failure && size > few && size / most_for_a_byte > packed)
        return input_error(archive.string() + ": is damaged: its " + std::to_string(packed) +
                           " bytes are said to unpack to " + std::to_string(size));
    if (on_disk <= std::min(largest_unpacked, room)) return {};
    const auto in_gib = [](std::uint64_t bytes) {
        return short_number(static_cast<double>(bytes) / static_cast<double>(gibibyte), 3) + " GiB";
    };
    const std::string most = room < largest_unpacked
                                 ? in_gib(room) + " of the disk may be taken in " +
                                       folder.parent_path().string() + " (TMPDIR names another place)"
                                 : "at most " + in_gib(largest_unpacked) + " are unpacked";
    return input_error(archive.string() + ": unpacks to " + in_gib(on_disk) + ", and " + most + ": " +
                       unzip_words(archive));
}

/// Unpacks a member into a new file.
Result<void> unpack_member(const ZipArchive& archive, const ZipMember& member, const fs::path& file,
                           const std::string& where) {
    const auto failed = [&](int why) {
        return input_error(where +
                           ": cannot be unpacked into the folder of temporary files: " + std::strerror(why));
    };
    std::error_code failure;
    fs::create_directories(file.parent_path(), failure);
    if (failure) return failed(failure.value());
    constexpr mode_t private_file = 0600;
    const Descriptor made(
        open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, private_file));
    if (made.get() < 0) return errno == EEXIST ? input_error(where + ": is there twice") : failed(errno);
    const auto bytes = unpacked_member(archive, member);
    std::vector<char> block(std::min<std::uint64_t>(member.size, std::uint64_t{1} << 20));
    for (std::uint64_t at = 0; at < member.size || at == 0;) {
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), member.size - at));
        TRY(error_at(where, bytes->read(at, block.data(), count)));
        for (std::size_t written = 0; written < count;) {
            const ssize_t some = write(made.get(), block.data() + written, count - written);
            if (some < 0 && errno == EINTR) continue;
            if (some <= 0) return failed(some < 0 ? errno : ENOSPC);
            written += static_cast<std::size_t>(some);
        }
        at += count;
        if (count == 0) break;
    }
    return {};
}

/// First base of ZipReader: the folder is removed after the other base has closed its files.
struct KeptFolder {
    std::shared_ptr<ZipFolder> folder;
};

class ZipReader final : private KeptFolder, public ChangedClip {
public:
    ZipReader(std::unique_ptr<ClipReader> clip, std::shared_ptr<ZipFolder> of)
        : KeptFolder{std::move(of)}, ChangedClip(std::move(clip)) {
        for (std::string& note : notes_) note = folder->named(std::move(note));
        for (Remark& remark : scene_.remarks) remark.what = folder->named(std::move(remark.what));
        const auto inputs_before = inputs();
        forget_inputs();
        add_input(folder->archive());
        for (const fs::path& input : inputs_before)
            if (!folder->has(input)) add_input(input);
    }
    Result<std::optional<RawFrame>> next() override { return named(inner().next()); }
    Result<void> seek(std::int64_t frame) override { return named(inner().seek(frame)); }

private:
    template <class T>
    Result<T> named(Result<T> result) const {
        return result ? std::move(result) : Result<T>(folder->named(result.error()));
    }
};

}  // namespace

std::optional<ZipPlace> zip_of_pictures(const fs::path& path) {
    std::error_code ignored;
    fs::path archive = path, inner;
    // The rest of the path behind an archive's name is in the archive.
    while (!archive.empty() && !fs::exists(archive, ignored) && archive != archive.parent_path()) {
        inner = inner.empty() ? archive.filename() : archive.filename() / inner;
        archive = archive.parent_path();
    }
    if (!is_named_zip(archive) || !is_file(archive)) return {};
    if (first_bytes(SourceFile(archive), 4) != std::string_view("PK\x03\x04", 4)) return {};
    const auto opened = open_archive(archive);
    // A damaged archive is reported when it is opened as an archive of arrays.
    return opened && opened->has_pictures ? std::optional(ZipPlace{archive, inner}) : std::nullopt;
}

Result<std::shared_ptr<ZipFolder>> ZipFolder::unpack(const fs::path& archive, const fs::path& inner) {
    std::shared_ptr<ZipFolder> folder(new ZipFolder(archive));
    TRY_ASSIGN(folder->temporary_,
               error_at(archive.string() + ": cannot be unpacked", ScratchFolder::create("zip")));
    const fs::path stem = archive.stem();
    folder->root_ = folder->temporary_->path() /
                    (stem == "." || stem == ".." || stem == ScratchFolder::mark ? "archive" : stem);
    TRY(folder->fill(inner));
    return folder;
}

Result<void> ZipFolder::fill(const fs::path& inner) {
    TRY_ASSIGN(auto opened, open_archive(archive_));
    if (!inner.empty())
        std::erase_if(opened.wanted, [&](const ZipMember& member) { return !is_below(member.name, inner); });
    if (opened.wanted.empty())
        return input_error(archive_.string() + ": has no folder " + in_quotes(inner.string()) +
                           " with pictures");
    TRY(check_sizes(opened.wanted, archive_, temporary_->path()));
    for (const ZipMember& member : opened.wanted) {
        if (stop_requested()) return error_at(archive_.string(), interrupted_error());
        if (disk_room(temporary_->path()) == 0)
            return input_error(archive_.string() + ": less than 1 GiB of the disk would stay free in " +
                               temporary_->path().parent_path().string() + " (TMPDIR names another place)");
        TRY(unpack_member(opened.archive, member, root_ / member.name,
                          archive_.string() + '/' + printable(member.name, 200)));
    }
    opened_ = root_ / (inner.empty() ? folder_of_clip(opened.wanted) : inner);
    if (!opened_.has_filename()) opened_ = opened_.parent_path();
    return {};
}

bool ZipFolder::has(const fs::path& file) const {
    return is_below(file, temporary_->path());
}

std::string ZipFolder::named(std::string message) const {
    return shown_as(shown_as(std::move(message), root_, archive_), temporary_->path(), archive_);
}

std::unique_ptr<ClipReader> with_zip_folder(std::unique_ptr<ClipReader> clip,
                                            std::shared_ptr<ZipFolder> folder) {
    return std::make_unique<ZipReader>(std::move(clip), std::move(folder));
}

}  // namespace touchable
