#include "player/window/use_log.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>
#include <string_view>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "player/window/universal_time.hpp"

namespace touchable {
namespace {

/// As CSV has text with commas in it.
std::string as_field(const std::string& words) {
    std::string field = "\"";
    for (const char c : printable(words, 500)) field += c == '"' ? std::string("\"\"") : std::string(1, c);
    return field + "\"";
}

/// What of an open file is in the way; nothing where rows may follow.
std::optional<std::string> why_no_log(int out) {
    struct stat facts {};
    if (fstat(out, &facts) != 0) return std::strerror(errno);
    if (!S_ISREG(facts.st_mode)) return "is no ordinary file";
    if (flock(out, LOCK_EX | LOCK_NB) != 0) return "another program is writing it";
    const std::string_view header = UseLog::header;
    if (facts.st_size == 0) {
        if (const int why = append_durably(out, header)) return std::strerror(why);
        return std::nullopt;
    }
    std::string begin(header.size(), '\0');
    if (pread(out, begin.data(), begin.size(), 0) != static_cast<ssize_t>(begin.size()) || begin != header)
        return "is there, and is no log of use";
    char last = '\n';
    // A machine that was switched off in the middle of a row.
    if (pread(out, &last, 1, facts.st_size - 1) == 1 && last != '\n')
        if (const int why = append_durably(out, "\n")) return std::strerror(why);
    return std::nullopt;
}

}  // namespace

struct UseLog::Rows {
    Rows(std::filesystem::path named, int to, WriteRow by)
        : file(std::move(named)), out(to), write(std::move(by)) {}
    ~Rows() { close(out); }
    Rows(const Rows&) = delete;
    Rows& operator=(const Rows&) = delete;

    void add(const std::string& row) {
        if (const int why = write(out, row))
            miss(std::string("rows of the log of use are lost: ") + std::strerror(why));
    }
    void miss(const std::string& why) {
        const std::lock_guard lock(mutex);
        if (!missing) missing = input_error(file.string() + ": " + why);
    }

    const std::filesystem::path file;
    const int out;
    const WriteRow write;
    std::mutex mutex;
    std::optional<Error> missing;  // guarded by it
};

Result<std::unique_ptr<UseLog>> UseLog::open(const std::filesystem::path& file, WriteRow write) {
    const int out = ::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644);
    if (out < 0) return input_error(file.string() + ": cannot be written: " + std::strerror(errno));
    const auto rows = std::make_shared<Rows>(file, out, std::move(write));
    if (const auto why = why_no_log(out))
        return input_error(file.string() + ": " + *why +
                           "; right would be a new file, or a log of use to go on with");
    TRY_ASSIGN(auto disk, DiskWork::start("use-log", "that writes the log of use"));
    return std::unique_ptr<UseLog>(new UseLog(rows, std::move(disk)));
}

Result<void> UseLog::finish(std::chrono::milliseconds longest) {
    if (!disk_->finish(longest))
        return input_error(rows_->file.string() +
                           ": its disk does not answer; the last rows of the log of use may be lost");
    const auto lost = missing();
    return lost ? Result<void>(*lost) : Result<void>();
}

void UseLog::visit(Time came, double seconds) {
    add(came, formatted("visit,%lld,%.1f,", static_cast<long long>(++visitors_), seconds));
}

void UseLog::fault(Time now, const std::string& words) {
    add(now, "fault,,," + as_field(words));
}

std::optional<Error> UseLog::missing() const {
    const std::lock_guard lock(rows_->mutex);
    return rows_->missing;
}

void UseLog::add(Time time, const std::string& rest) {
    constexpr std::size_t most_waiting = 1000;
    if (disk_->waiting() >= most_waiting)
        return rows_->miss("its disk does not answer; rows of the log of use are lost");
    disk_->give([rows = rows_, row = in_universal_time(time) + ',' + rest + '\n'] { rows->add(row); });
}

}  // namespace touchable
