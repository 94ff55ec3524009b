#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace touchable {

/// What Linux shows of devices and processes, /sys, /proc and /dev, below a folder that stands for "/". Paths
/// begin with "/". What cannot be read is not there.
class ConnectedSystem {
public:
    explicit ConnectedSystem(std::filesystem::path root = "/") : root_(std::move(root)) {}
    virtual ~ConnectedSystem() = default;
    ConnectedSystem(const ConnectedSystem&) = delete;
    ConnectedSystem& operator=(const ConnectedSystem&) = delete;

    const std::filesystem::path& root() const { return root_; }
    /// What is in a folder, sorted.
    std::vector<std::string> names(const std::string& folder) const;
    bool has(const std::string& path) const;
    /// Of a file, at most `most` bytes, without a line's end behind it; empty: not there.
    std::string text(const std::string& path, std::size_t most = 4096) const;
    /// What a link says; empty: it is none.
    std::string link(const std::string& path) const;
    /// A path with all its links followed, from the root; empty: not there.
    std::string resolved(const std::string& path) const;

    /// Whether this user may read and write a node.
    virtual bool may_use(const std::string& node) const;

private:
    std::filesystem::path below(const std::string& path) const;
    const std::filesystem::path root_;
};

/// Who has a node open, such as "spacenavd (process 812)", as far as this user may see; not this process.
std::vector<std::string> holders_of(const ConnectedSystem& system, const std::string& node);
/// Whether a program listens at a TCP port of this machine.
bool somebody_listens(const ConnectedSystem& system, std::uint16_t port);

}  // namespace touchable
