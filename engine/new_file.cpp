#include "engine/new_file.hpp"

#include <unistd.h>

#include <atomic>
#include <string>
#include <system_error>
#include <utility>

namespace touchable {
namespace {

std::filesystem::path unfinished_name(const std::filesystem::path& target) {
    static std::atomic<unsigned> serial{0};  // two writers of one target in one process do not meet
    std::filesystem::path name = target;
    name += ".unfinished-" + std::to_string(getpid()) + "-" + std::to_string(serial++);
    return name;
}

}  // namespace

NewFile::NewFile(std::filesystem::path target)
    : target_(std::move(target)), path_(unfinished_name(target_)) {}

NewFile::~NewFile() {
    std::error_code ignored;
    if (!committed_) std::filesystem::remove(path_, ignored);
}

Result<void> NewFile::check_target() const {
    std::error_code failure;
    const auto status = std::filesystem::status(target_, failure);
    if (target_.has_filename() && (!std::filesystem::exists(status) || is_regular_file(status))) return {};
    return input_error(target_.string() + ": is not the name of a file; must be one, new or to be replaced");
}

Result<void> NewFile::commit() {
    if (auto usable = check_target(); !usable.ok()) return usable;
    std::error_code failure;
    std::filesystem::rename(path_, target_, failure);
    if (failure) return input_error(target_.string() + ": cannot be written: " + failure.message());
    committed_ = true;
    return {};
}

}  // namespace touchable
