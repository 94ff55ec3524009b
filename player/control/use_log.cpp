#include "player/control/use_log.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <utility>

#include "engine/printable.hpp"
#include "engine/start_thread.hpp"
#include "player/control/universal_time.hpp"

namespace touchable {
namespace {

/// As CSV has text with commas in it.
std::string as_field(const std::string& words) {
    std::string field = "\"";
    for (const char c : printable(words, 500)) field += c == '"' ? std::string("\"\"") : std::string(1, c);
    return field + "\"";
}

int write_bytes(int out, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(out, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return errno;
        if (count == 0) return ENOSPC;
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return 0;
}

/// What of an open file is in the way; nothing where rows may follow.
std::optional<std::string> why_no_log(int out) {
    struct stat facts {};
    if (fstat(out, &facts) != 0) return std::strerror(errno);
    if (!S_ISREG(facts.st_mode)) return "is no ordinary file";
    if (flock(out, LOCK_EX | LOCK_NB) != 0) return "another program is writing it";
    const std::string_view header = UseLog::header;
    if (facts.st_size == 0) {
        if (const int why = write_bytes(out, header)) return std::strerror(why);
        return std::nullopt;
    }
    std::string begin(header.size(), '\0');
    if (pread(out, begin.data(), begin.size(), 0) != static_cast<ssize_t>(begin.size()) || begin != header)
        return "is there, and is no log of use";
    char last = '\n';
    // A machine that was switched off in the middle of a row.
    if (pread(out, &last, 1, facts.st_size - 1) == 1 && last != '\n')
        if (const int why = write_bytes(out, "\n")) return std::strerror(why);
    return std::nullopt;
}

}  // namespace

Result<std::unique_ptr<UseLog>> UseLog::open(const std::filesystem::path& file) {
    const int out = ::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644);
    if (out < 0) return input_error(file.string() + ": cannot be written: " + std::strerror(errno));
    std::unique_ptr<UseLog> log(new UseLog(file, out));
    if (const auto why = why_no_log(out))
        return input_error(file.string() + ": " + *why +
                           "; right would be a new file, or a log of use to go on with");
    auto begun = start_thread(log->thread_, "use-log", "that writes the log of use",
                              [made = log.get()] { made->write_all(); });
    if (!begun.ok()) return begun.error();
    return log;
}

UseLog::~UseLog() {
    {
        const std::lock_guard lock(mutex_);
        is_ending_ = true;
    }
    changed_.notify_one();
    if (thread_.joinable()) thread_.join();
    close(out_);
}

void UseLog::visit(Time came, double seconds) {
    char words[64];
    std::snprintf(words, sizeof words, "visit,%lld,%.1f,", static_cast<long long>(++visitors_), seconds);
    add(came, words);
}

void UseLog::fault(Time now, const std::string& words) {
    add(now, "fault,,," + as_field(words));
}

std::optional<Error> UseLog::missing() const {
    const std::lock_guard lock(mutex_);
    return missing_;
}

void UseLog::add(Time time, const std::string& rest) {
    {
        const std::lock_guard lock(mutex_);
        if (waiting_.size() < most_waiting)
            waiting_.push_back(in_universal_time(time) + ',' + rest + '\n');
        else if (!missing_)
            missing_ =
                input_error(file_.string() + ": its disk does not answer; rows of the log of use are lost");
    }
    changed_.notify_one();
}

/// A row whole, or nothing of it: 0, or why not (errno).
int UseLog::write(const std::string& row) const {
    const off_t before = lseek(out_, 0, SEEK_END);
    const int why = write_bytes(out_, row);
    if (why != 0 && before >= 0) (void)!ftruncate(out_, before);
    return why != 0 ? why : (fdatasync(out_) == 0 ? 0 : errno);
}

void UseLog::write_all() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return is_ending_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        const std::string row = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        const int why = write(row);
        lock.lock();
        if (why != 0 && !missing_)
            missing_ =
                input_error(file_.string() + ": rows of the log of use are lost: " + std::strerror(why));
    }
}

}  // namespace touchable
