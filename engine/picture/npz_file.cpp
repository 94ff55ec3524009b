#include "engine/picture/npz_file.hpp"

#include <zip.h>

#include <algorithm>
#include <cerrno>
#include <utility>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/picture/npy_header.hpp"

namespace touchable {
namespace {

using ZipArchive = std::shared_ptr<zip_t>;
constexpr zip_int64_t most_members = 4096;
/// As much as a byte can stand for at most where it is packed by deflate.
constexpr zip_uint64_t largest_expansion = 1032;

struct CloseMember {
    void operator()(zip_file_t* member) const { zip_fclose(member); }
};

/// An archive's own bytes, as libzip calls for them.
class ArchiveBytes {
public:
    explicit ArchiveBytes(std::unique_ptr<ByteSource> bytes) : bytes_(std::move(bytes)) {
        zip_error_init(&error_);
    }
    ~ArchiveBytes() { zip_error_fini(&error_); }
    ArchiveBytes(const ArchiveBytes&) = delete;
    ArchiveBytes& operator=(const ArchiveBytes&) = delete;

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
        if (!bytes_->read(at_, to, static_cast<std::size_t>(count))) {
            zip_error_set(&error_, ZIP_ER_READ, EIO);
            return -1;
        }
        at_ += count;
        return static_cast<zip_int64_t>(count);
    }

    std::unique_ptr<ByteSource> bytes_;
    zip_uint64_t at_ = 0;
    zip_error_t error_;
};

Error interrupted_unpacking() {
    return {ErrorKind::interrupted, "interrupted while it was unpacked"};
}

/// What an archive's member unpacks to. A step back begins again.
class UnpackedBytes final : public ByteSource {
public:
    UnpackedBytes(ZipArchive archive, zip_uint64_t index, std::uint64_t size)
        : archive_(std::move(archive)), index_(index), size_(size) {}
    std::uint64_t size() const override { return size_; }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (!member_ || at < position_) {
            member_.reset(zip_fopen_index(archive_.get(), index_, 0));
            position_ = 0;
            if (!member_)
                return input_error(std::string("cannot be unpacked: ") + zip_strerror(archive_.get()));
        }
        char passed[16384];
        while (position_ < at)
            if (auto got = take(passed, std::min<std::uint64_t>(at - position_, sizeof passed)); !got)
                return got;
        if (auto got = take(to, count); !got) return got;
        // Only behind its last byte is a member's sum compared.
        return position_ == size_ && zip_fread(member_.get(), passed, 1) < 0 ? damage() : Result<void>{};
    }

private:
    Result<void> take(char* to, std::uint64_t count) {
        if (stop_requested()) return interrupted_unpacking();
        const zip_int64_t got = zip_fread(member_.get(), to, count);
        if (got < 0) return damage();
        position_ += static_cast<std::uint64_t>(got);
        return static_cast<std::uint64_t>(got) == count ? Result<void>{} : input_error("is cut short");
    }
    Result<void> damage() {
        if (stop_requested()) return interrupted_unpacking();  // which is why its bytes did not come
        return input_error(std::string("is damaged: ") + zip_file_strerror(member_.get()));
    }

    ZipArchive archive_;
    zip_uint64_t index_;
    std::uint64_t size_, position_ = 0;
    std::unique_ptr<zip_file_t, CloseMember> member_;
};

/// One member that is an array.
struct NpzArray {
    std::string name;  // without ".npy"
    zip_uint64_t index;
    std::uint64_t size;
    bool pictures = false;
    bool is_possible = true;  // that so many bytes are packed in those of the file
};

std::unique_ptr<UnpackedBytes> unpacked(const ZipArchive& archive, const NpzArray& array) {
    return std::make_unique<UnpackedBytes>(archive, array.index, array.size);
}

std::vector<NpzArray> npz_arrays(const ZipArchive& archive) {
    std::vector<NpzArray> arrays;
    const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
    for (zip_int64_t k = 0; k < count; ++k) {
        const auto index = static_cast<zip_uint64_t>(k);
        zip_stat_t about;
        if (zip_stat_index(archive.get(), index, 0, &about) != 0 || !(about.valid & ZIP_STAT_NAME) ||
            !(about.valid & ZIP_STAT_SIZE))
            continue;
        NpzArray array{about.name, index, about.size};
        if (!array.name.ends_with(".npy")) continue;
        constexpr auto needed = ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
        const bool is_deflated = (about.valid & needed) == needed && about.comp_method == ZIP_CM_DEFLATE;
        array.is_possible = !is_deflated || about.size / largest_expansion <= about.comp_size;
        array.name.resize(array.name.size() - 4);
        const auto header = read_npy_header(*unpacked(archive, array), "");
        array.pictures = header.ok() && npy_pictures(*header, "").ok();
        arrays.push_back(std::move(array));
    }
    return arrays;
}

/// The only one that fits, if it is.
template <class Fits>
const NpzArray* only(const std::vector<NpzArray>& arrays, Fits&& fits) {
    const auto first = std::find_if(arrays.begin(), arrays.end(), fits);
    if (first == arrays.end() || std::find_if(first + 1, arrays.end(), fits) != arrays.end()) return nullptr;
    return &*first;
}

const NpzArray* depth_array(const std::vector<NpzArray>& arrays) {
    if (arrays.size() == 1) return &arrays.front();
    const auto named = [](const NpzArray& a) { return a.pictures && a.name == "depth"; };
    const auto begins = [](const NpzArray& a) { return a.pictures && a.name.starts_with("depth"); };
    if (const NpzArray* found = only(arrays, named)) return found;
    if (const NpzArray* found = only(arrays, begins)) return found;
    return only(arrays, [](const NpzArray& a) { return a.pictures; });
}

std::string names_of(const std::vector<NpzArray>& arrays) {
    std::string names;
    for (const NpzArray& array : arrays) names += (names.empty() ? "" : ", ") + array.name;
    return printable(names, 300);
}

Result<NpzMember> depth_member_of(ZipArchive archive, const std::string& where) {
    if (zip_get_num_entries(archive.get(), 0) > most_members)
        return input_error(where + ": has more than " + std::to_string(most_members) + " members");
    const auto arrays = npz_arrays(archive);
    if (arrays.empty())
        return input_error(where +
                           ": is a zip archive without arrays (.npy): unpack it, or give what is inside");
    const NpzArray* array = depth_array(arrays);
    if (!array)
        return input_error(where +
                           ": has several arrays, and none is the only one named depth or of height x "
                           "width: " +
                           names_of(arrays));
    const std::string name = where + ": " + printable(array->name);
    if (!array->is_possible)
        return input_error(name + ": is damaged: is said to unpack to " + std::to_string(array->size) +
                           " bytes");
    const NpzArray* const trust = only(arrays, [&](const NpzArray& a) {
        return &a != array && a.pictures && a.is_possible && (a.name == "conf" || a.name == "confidence");
    });
    return NpzMember{unpacked(archive, *array), name, trust ? unpacked(archive, *trust) : nullptr};
}

Result<NpzMember> open_archive(zip_source_t* source, zip_error_t& error, const std::string& where) {
    zip_t* archive = source ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr;
    if (archive) return depth_member_of(ZipArchive(archive, zip_discard), where);
    if (source) zip_source_free(source);
    if (stop_requested()) return error_at(where, interrupted_unpacking());
    return input_error(where + ": is damaged: " + zip_error_strerror(&error));
}

/// The error that an archive's opening fills in.
struct ZipError {
    ZipError() { zip_error_init(&error); }
    ~ZipError() { zip_error_fini(&error); }
    ZipError(const ZipError&) = delete;
    ZipError& operator=(const ZipError&) = delete;
    zip_error_t error;
};

}  // namespace

bool is_npz(std::string_view begin) {
    return begin.starts_with("PK\x03\x04");
}

Result<NpzMember> open_npz(std::unique_ptr<ByteSource> archive, const std::string& where) {
    ZipError failure;
    auto bytes = std::make_unique<ArchiveBytes>(std::move(archive));
    zip_source_t* source = zip_source_function_create(ArchiveBytes::answer, bytes.get(), &failure.error);
    if (source) (void)bytes.release();
    return open_archive(source, failure.error, where);
}

Result<NpzMember> depth_member(std::string_view archive, const std::string& where) {
    ZipError failure;
    zip_source_t* source = zip_source_buffer_create(archive.data(), archive.size(), 0, &failure.error);
    return open_archive(source, failure.error, where);
}

}  // namespace touchable
