// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files of one test alone, and who opens them.

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>

namespace touchable::test {

/// A folder of its own for one test, gone with it.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "touchable-test-XXXXXX").string();
        if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder " + name);
        path_ = name;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    std::size_t file_count() const {
        return static_cast<std::size_t>(
            std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator{}));
    }

private:
    std::filesystem::path path_;
};

/// A file in a folder of its own, there as long as this is.
class TemporaryFile {
public:
    TemporaryFile(const std::string& name, const std::string& text) : path_(folder_ / name) {
        std::ofstream(path_, std::ios::binary) << text;
    }
    const std::string& path() const { return path_; }

private:
    const TemporaryFolder folder_;
    const std::string path_;
};

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
