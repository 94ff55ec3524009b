// SPDX-License-Identifier: Apache-2.0
#include "engine/picture/zip_archive.hpp"

#include <sys/stat.h>
#include <zip.h>

#include <algorithm>
#include <cerrno>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// Serves an archive's bytes to libzip.
class ArchiveBytes : NonCopyable {
public:
    /// `most_read`: bytes that may be read before `allow_all`.
    ArchiveBytes(std::unique_ptr<ByteSource> bytes, zip_uint64_t most_read)
        : bytes_(std::move(bytes)), left_(most_read) {
        zip_error_init(&error_);
    }
    ~ArchiveBytes() { zip_error_fini(&error_); }
    void allow_all() { all_allowed_ = true; }
    bool has_refused() const { return is_refused_; }

    static zip_int64_t answer(void* own, void* data, zip_uint64_t length, zip_source_cmd_t command) {
        auto* const archive = static_cast<ArchiveBytes*>(own);
        if (command != ZIP_SOURCE_FREE) return archive->answer(data, length, command);
        delete archive;
        return 0;
    }

private:
    zip_int64_t answer(void* data, zip_uint64_t length, zip_source_cmd_t command) {
        switch (command) {
            case ZIP_SOURCE_OPEN:
                at_ = 0;
                return 0;
            case ZIP_SOURCE_READ:
                return read(static_cast<char*>(data), length);
            case ZIP_SOURCE_CLOSE:
                return 0;
            case ZIP_SOURCE_STAT: {
                auto* const about = static_cast<zip_stat_t*>(data);
                zip_stat_init(about);
                about->valid = ZIP_STAT_SIZE;
                about->size = bytes_->size();
                return sizeof *about;
            }
            case ZIP_SOURCE_ERROR:
                return zip_error_to_data(&error_, data, length);
            case ZIP_SOURCE_SEEK: {
                const zip_int64_t to =
                    zip_source_seek_compute_offset(at_, bytes_->size(), data, length, &error_);
                if (to < 0) return -1;
                at_ = static_cast<zip_uint64_t>(to);
                return 0;
            }
            case ZIP_SOURCE_TELL:
                return static_cast<zip_int64_t>(at_);
            case ZIP_SOURCE_SUPPORTS:
                return ZIP_SOURCE_SUPPORTS_SEEKABLE;
            default:
                zip_error_set(&error_, ZIP_ER_OPNOTSUPP, 0);
                return -1;
        }
    }
    zip_int64_t read(char* to, zip_uint64_t length) {
        const zip_uint64_t count = std::min<zip_uint64_t>(length, bytes_->size() - at_);
        is_refused_ = is_refused_ || (!all_allowed_ && count > left_);
        if (!all_allowed_) left_ -= std::min(count, left_);
        if (is_refused_ || !bytes_->read(at_, to, static_cast<std::size_t>(count))) {
            zip_error_set(&error_, ZIP_ER_READ, EIO);
            return -1;
        }
        at_ += count;
        return static_cast<zip_int64_t>(count);
    }

    std::unique_ptr<ByteSource> bytes_;
    zip_uint64_t at_ = 0;
    zip_uint64_t left_;
    bool all_allowed_ = false, is_refused_ = false;
    zip_error_t error_;
};

/// A member's unpacked bytes. Reading backward unpacks from the beginning again.
class UnpackedBytes final : public ByteSource {
public:
    UnpackedBytes(ZipArchive archive, const ZipMember& member)
        : archive_(std::move(archive)), index_(member.index), size_(member.size) {}
    std::uint64_t size() const override { return size_; }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (!member_ || at < position_) {
            member_.reset(zip_fopen_index(archive_.get(), index_, 0));
            position_ = 0;
            if (!member_)
                return input_error(std::string("cannot be unpacked: ") + zip_strerror(archive_.get()));
        }
        char passed[16384];
        while (position_ < at) TRY(take(passed, std::min<std::uint64_t>(at - position_, sizeof passed)));
        TRY(take(to, count));
        if (position_ < size_) return {};
        // libzip checks a member's checksum only after its last byte.
        const zip_int64_t more = zip_fread(member_.get(), passed, 1);
        if (more < 0) return damage();
        return more == 0 ? Result<void>{} : input_error("is damaged: unpacks to more than it states");
    }

private:
    Result<void> take(char* to, std::uint64_t count) {
        if (stop_requested()) return interrupted_error();
        const zip_int64_t got = zip_fread(member_.get(), to, count);
        if (got < 0) return damage();
        position_ += static_cast<std::uint64_t>(got);
        return static_cast<std::uint64_t>(got) == count ? Result<void>{} : input_error("is cut short");
    }
    Result<void> damage() {
        if (stop_requested()) return interrupted_error();  // which is why its bytes did not come
        return input_error(std::string("is damaged: ") + zip_file_strerror(member_.get()));
    }

    ZipArchive archive_;
    zip_uint64_t index_;
    std::uint64_t size_, position_ = 0;
    std::unique_ptr<zip_file_t, ReleasedBy<zip_fclose>> member_;
};

/// Whether a member's attributes say that it is an ordinary file; true if they do not tell.
bool is_ordinary(zip_t* archive, zip_uint64_t index) {
    zip_uint8_t system = 0;
    zip_uint32_t attributes = 0;
    const bool is_told = zip_file_get_external_attributes(archive, index, 0, &system, &attributes) == 0 &&
                         (system == ZIP_OPSYS_UNIX || system == ZIP_OPSYS_OS_X);
    const mode_t kind = is_told ? attributes >> 16 & S_IFMT : 0;
    return kind == 0 || kind == S_IFREG;
}

}  // namespace

Result<ZipArchive> open_zip(std::unique_ptr<ByteSource> bytes, std::uint64_t most_members,
                            const std::string& where) {
    // A member takes 46 bytes of the directory, and its name; the directory ends in the last bytes.
    constexpr std::uint64_t usual_member = 512, for_the_end = std::uint64_t{1} << 20;
    zip_error_t failure;
    zip_error_init(&failure);
    auto own = std::make_unique<ArchiveBytes>(std::move(bytes), most_members * usual_member + for_the_end);
    zip_source_t* const source = zip_source_function_create(ArchiveBytes::answer, own.get(), &failure);
    ArchiveBytes* const held = source ? own.release() : nullptr;
    zip_t* const archive = source ? zip_open_from_source(source, ZIP_RDONLY, &failure) : nullptr;
    const std::string why = zip_error_strerror(&failure);
    zip_error_fini(&failure);
    if (archive) held->allow_all();
    const ZipArchive opened(archive, [](zip_t* each) {
        if (each) zip_discard(each);
    });
    const auto too_many = [&] {
        return input_error(where + ": has more than " + std::to_string(most_members) + " members");
    };
    const bool is_too_large = held && !archive && held->has_refused();
    if (source && !archive) zip_source_free(source);
    if (stop_requested()) return error_at(where, interrupted_error());
    if (is_too_large) return too_many();
    if (!archive) return input_error(where + ": is damaged: " + why);
    if (static_cast<std::uint64_t>(zip_get_num_entries(archive, 0)) > most_members) return too_many();
    return opened;
}

std::vector<ZipMember> zip_members(const ZipArchive& archive) {
    std::vector<ZipMember> members;
    const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
    for (zip_int64_t k = 0; k < count && !stop_requested(); ++k) {
        const auto index = static_cast<zip_uint64_t>(k);
        zip_stat_t about;
        if (zip_stat_index(archive.get(), index, 0, &about) != 0 || !(about.valid & ZIP_STAT_NAME) ||
            !(about.valid & ZIP_STAT_SIZE))
            continue;
        ZipMember member{about.name, index, about.size};
        const bool is_deflated = (about.valid & ZIP_STAT_COMP_METHOD) && about.comp_method == ZIP_CM_DEFLATE;
        const bool is_stated = about.valid & ZIP_STAT_COMP_SIZE;
        member.packed = is_stated && is_deflated ? about.comp_size : about.size;
        member.is_file = !member.name.ends_with('/') && is_ordinary(archive.get(), index);
        member.is_encrypted =
            (about.valid & ZIP_STAT_ENCRYPTION_METHOD) && about.encryption_method != ZIP_EM_NONE;
        members.push_back(std::move(member));
    }
    return members;
}

std::unique_ptr<ByteSource> unpacked_member(const ZipArchive& archive, const ZipMember& member) {
    return std::make_unique<UnpackedBytes>(archive, member);
}

}  // namespace touchable
