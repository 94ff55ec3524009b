#pragma once

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

namespace touchable::test {

/// How often files that lie in a folder were opened since this is here, by whatever process.
class OpenedFiles {
public:
    explicit OpenedFiles(const std::filesystem::path& folder)
        : number_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
        // The system joins events that are the same and follow each other: reading and closing lie between.
        if (number_ < 0 || inotify_add_watch(number_, folder.c_str(), IN_OPEN | IN_ACCESS | IN_CLOSE) < 0)
            throw std::runtime_error("no watch over " + folder.string() + ": " + std::strerror(errno));
    }
    ~OpenedFiles() { ::close(number_); }
    OpenedFiles(const OpenedFiles&) = delete;
    OpenedFiles& operator=(const OpenedFiles&) = delete;

    /// By name, and those never opened not at all.
    const std::map<std::string, int>& counts() {
        alignas(inotify_event) std::array<char, 1 << 16> events{};
        for (ssize_t got; (got = ::read(number_, events.data(), events.size())) > 0;)
            for (const char* at = events.data(); at < events.data() + got;) {
                const auto* event = reinterpret_cast<const inotify_event*>(at);
                at += sizeof(inotify_event) + event->len;
                if ((event->mask & IN_Q_OVERFLOW) != 0) throw std::runtime_error("more events than are kept");
                if ((event->mask & IN_OPEN) != 0 && event->len > 0 && (event->mask & IN_ISDIR) == 0)
                    ++counts_[event->name];
            }
        return counts_;
    }

private:
    int number_;
    std::map<std::string, int> counts_;
};

}  // namespace touchable::test
