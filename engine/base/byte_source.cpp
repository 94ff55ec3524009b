#include "engine/base/byte_source.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

class MemoryBytes final : public ByteSource {
public:
    explicit MemoryBytes(std::string_view bytes) : bytes_(bytes) {}
    std::uint64_t size() const override { return bytes_.size(); }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (at > bytes_.size() || count > bytes_.size() - at) return input_error("is cut short");
        std::memcpy(to, bytes_.data() + at, count);
        return {};
    }

private:
    std::string_view bytes_;
};

class FileBytes final : public ByteSource {
public:
    explicit FileBytes(GivenFile file) : file_(std::move(file)) {}
    std::uint64_t size() const override { return file_.size(); }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        return file_.read(at, to, count);
    }

private:
    GivenFile file_;
};

}  // namespace

std::unique_ptr<ByteSource> bytes_in_memory(std::string_view bytes) {
    return std::make_unique<MemoryBytes>(bytes);
}

Result<std::unique_ptr<ByteSource>> bytes_of_file(const SourceFile& file) {
    TRY_ASSIGN(auto given, file.open("an ordinary file"));
    return std::unique_ptr<ByteSource>(std::make_unique<FileBytes>(std::move(given)));
}

std::string first_bytes(ByteSource& bytes, std::size_t count) {
    std::string begin(static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), count)), '\0');
    if (!bytes.read(0, begin.data(), begin.size())) begin.clear();
    return begin;
}

std::string first_bytes(const SourceFile& file, std::size_t count) {
    const auto bytes = bytes_of_file(file);
    return bytes ? first_bytes(**bytes, count) : std::string();
}

}  // namespace touchable
