#include "player/window/participant_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/base/new_file.hpp"
#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "player/window/durable_append.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view stem = "participant-";
constexpr const char *partial = ".partial.csv", *finished = ".csv", *left = ".left.csv";
constexpr std::size_t largest_number = 999'999;

/// Of a file of results; 0: it is none.
std::size_t number_of(const std::string& name) {
    if (!name.starts_with(stem)) return 0;
    std::size_t number = 0;
    const char* const end = name.data() + name.size();
    const auto [rest, fault] = std::from_chars(name.data() + stem.size(), end, number);
    const bool is_one = fault == std::errc() && rest != end && *rest == '.' && number <= largest_number;
    return is_one ? number : 0;
}

Result<std::size_t> largest_in(const fs::path& folder) {
    std::error_code failed;
    std::size_t largest = 0;
    for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed))
        largest = std::max(largest, number_of(at->path().filename().string()));
    if (failed) return input_error(folder.string() + ": cannot be read: " + failed.message());
    return largest;
}

}  // namespace

ParticipantFile::ParticipantFile(fs::path folder, std::size_t number, int out)
    : folder_(std::move(folder)), number_(number), out_(out) {}

ParticipantFile::ParticipantFile(ParticipantFile&& other) noexcept
    : folder_(std::move(other.folder_)),
      number_(other.number_),
      out_(std::exchange(other.out_, -1)),
      waiting_(std::move(other.waiting_)),
      fault_(std::move(other.fault_)) {}

ParticipantFile::~ParticipantFile() {
    if (out_ >= 0) close(out_);
}

fs::path ParticipantFile::named(const char* ending) const {
    return folder_ / (std::string(stem) + formatted("%03zu", number_) + ending);
}

Error ParticipantFile::failed(int why) const {
    return input_error(named(partial).string() + ": answers are not kept: " + std::strerror(why));
}

/// A number that another program takes at the same moment is left to that one.
Result<ParticipantFile> ParticipantFile::create(const fs::path& folder, const std::string& header) {
    constexpr int most_tries = 100;
    TRY_ASSIGN(const auto largest, largest_in(folder));
    for (std::size_t number = largest + 1; number <= largest + most_tries; ++number) {
        if (number > largest_number) break;
        ParticipantFile file(folder, number, -1);
        const fs::path name = file.named(partial);
        file.out_ = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
        if (file.out_ < 0 && errno == EEXIST) continue;
        if (file.out_ < 0) return file.failed(errno);
        std::error_code ignored;
        const bool is_taken =
            fs::exists(file.named(finished), ignored) || fs::exists(file.named(left), ignored);
        file.waiting_ = header;
        file.write();
        if (!is_taken && !file.fault_) return file;
        const auto fault = file.fault_;
        (void)unlink(name.c_str());
        if (fault) return *fault;
    }
    return input_error(folder.string() + ": there is no number for another participant; right would be an " +
                       "empty folder");
}

void ParticipantFile::add(const std::string& row) {
    waiting_ += row;
    write();
}

void ParticipantFile::secure() {
    sync_folder(folder_);
}

/// All that waits, or nothing of it.
void ParticipantFile::write() {
    fault_.reset();
    if (const int why = append_durably(out_, waiting_))
        fault_ = failed(why);
    else
        waiting_.clear();
}

Result<void> ParticipantFile::finish(End end) {
    write();
    if (fault_) return *fault_;
    const fs::path last = named(end == End::finished ? finished : left);
    if (const int why = move_to_free_name(named(partial), last); why != 0)
        return *(fault_ = input_error(named(partial).string() + ": stays partial: " +
                                      last.filename().string() + ": " + std::strerror(why)));
    sync_folder(folder_);
    return {};
}

}  // namespace touchable
