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

/// A device that is connected and known.
struct ConnectedDevice {
    std::string place;  ///< "usb 1-2.3", "bluetooth", "other" (HID of no bus that is known)
    std::uint16_t vendor = 0, product = 0;
    std::string name;                  ///< the device's own words, from outside
    std::string what;                  ///< for people
    std::string driven;                ///< what to write behind --device; empty: it cannot be driven
    std::string why_not;               ///< it cannot be driven; empty: it can
    std::string firmware;              ///< what shows of it; empty: nothing
    std::vector<std::string> nodes{};  ///< its nodes in /dev
    std::string node;                  ///< the one that it would be driven by; empty: none, or there is none
    bool may_use = false;              ///< that node, by this user
    std::vector<std::string>
        rules{};  ///< of udev, that would let whoever sits at the machine use it; empty: it may be
    std::vector<std::string> held_by{};  ///< programs that have one of its nodes open, as far as it shows
    bool ready = false;
    std::string next;  ///< the one line that makes it ready, or helps where it cannot be driven; empty: ready
};

/// All that are connected and known, by USB and Bluetooth; opens none of them.
std::vector<ConnectedDevice> connected_devices(const ConnectedSystem& system);

/// For a person: lines; with none connected one, which says what to do.
std::string devices_in_words(const std::vector<ConnectedDevice>& devices, const std::string& naming = "");
/// Every word that --device takes, a line each, and how to begin; `with_simulated`: the command that does
/// with a simulated one.
std::string device_words_in_words(const std::string& with_simulated = "");
/// The same as JSON, with members named as above, ids as "046d:c626", and `words`.
std::string devices_in_json(const std::vector<ConnectedDevice>& devices);

}  // namespace touchable
