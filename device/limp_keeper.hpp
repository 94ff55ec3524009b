#pragma once

#include <sys/types.h>
#include <memory>
#include <mutex>

#include "device/device_driver.hpp"
#include "engine/result.hpp"

namespace touchable {

/// A small process beside this one that leaves devices without force when this one is gone, however it went:
/// by a signal, by abort, killed. It holds their descriptors and the bytes that leave them limp, and sleeps
/// until the last end of a socket to it is closed. What it cannot help against: a machine that stops.
class LimpKeeper {
public:
    static constexpr int most_devices = 8;
    static constexpr std::size_t most_bytes = 512;

    /// Forks. Best done early: it keeps a copy of what this process has in memory by then, as long as neither
    /// writes to it. Error (internal): no process can be had.
    static Result<std::shared_ptr<LimpKeeper>> start();
    ~LimpKeeper();  ///< it ends; what it still keeps gets its last word
    LimpKeeper(const LimpKeeper&) = delete;
    LimpKeeper& operator=(const LimpKeeper&) = delete;

    /// A device in its care, until this is gone.
    class Kept {
    public:
        Kept(Kept&& other) noexcept : keeper_(std::move(other.keeper_)), place_(other.place_) {}
        Kept& operator=(Kept&& other) noexcept;
        ~Kept();
        /// Another word, or another descriptor, in place of the last. Said anew of hardware that came back:
        /// its descriptor may have the number that the lost one had.
        Result<void> say(const LastWord& word);

    private:
        friend class LimpKeeper;
        Kept(std::shared_ptr<LimpKeeper> keeper, int place) : keeper_(std::move(keeper)), place_(place) {}
        std::shared_ptr<LimpKeeper> keeper_;
        int place_ = 0;
    };
    /// Error (device): `most_devices` are kept already.
    static Result<Kept> keep(std::shared_ptr<LimpKeeper> keeper);

private:
    LimpKeeper(int socket, pid_t process) : socket_(socket), process_(process) {}
    Result<void> tell(int place, const LastWord* word);

    int socket_;
    pid_t process_;
    std::mutex mutex_;  // threads of several devices
    bool taken_[most_devices] = {};
};

}  // namespace touchable
