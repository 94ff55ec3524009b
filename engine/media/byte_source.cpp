#include "engine/media/byte_source.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

namespace touchable {
namespace {

Error ended_early() {
    return input_error("is cut short");
}

class MemoryBytes final : public ByteSource {
public:
    explicit MemoryBytes(std::string_view bytes) : bytes_(bytes) {}
    std::uint64_t size() const override { return bytes_.size(); }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (at > bytes_.size() || count > bytes_.size() - at) return ended_early();
        std::memcpy(to, bytes_.data() + at, count);
        return {};
    }

private:
    std::string_view bytes_;
};

class FileBytes final : public ByteSource {
public:
    FileBytes(std::ifstream file, std::uint64_t size) : file_(std::move(file)), size_(size) {}
    std::uint64_t size() const override { return size_; }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (at > size_ || count > size_ - at) return ended_early();
        file_.clear();
        errno = 0;
        if (file_.seekg(static_cast<std::streamoff>(at)) &&
            file_.read(to, static_cast<std::streamsize>(count)))
            return {};
        return errno == 0 ? ended_early()
                          : input_error(std::string("cannot be read: ") + std::strerror(errno));
    }

private:
    std::ifstream file_;
    std::uint64_t size_;
};

}  // namespace

std::unique_ptr<ByteSource> bytes_in_memory(std::string_view bytes) {
    return std::make_unique<MemoryBytes>(bytes);
}

Result<std::unique_ptr<ByteSource>> bytes_of_file(const std::filesystem::path& file) {
    std::error_code failure;
    const auto size = std::filesystem::file_size(file, failure);
    if (failure) return input_error(file.string() + ": cannot be read: " + failure.message());
    std::ifstream in(file, std::ios::binary);
    if (!in) return input_error(file.string() + ": cannot be read: " + std::strerror(errno));
    return std::unique_ptr<ByteSource>(std::make_unique<FileBytes>(std::move(in), size));
}

}  // namespace touchable
