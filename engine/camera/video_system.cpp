#include "engine/camera/video_system.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "engine/base/printable.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

class LinuxVideo final : public VideoSystem {
public:
    std::vector<std::string> nodes() override;
    int open(const char* node) override { return ::open(node, O_RDWR | O_NONBLOCK | O_CLOEXEC); }
    int close(int descriptor) override { return ::close(descriptor); }
    int ioctl(int descriptor, unsigned long request, void* argument) override {
        return ::ioctl(descriptor, request, argument);
    }
    void* mmap(int descriptor, std::size_t length, std::int64_t offset) override {
        return ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, offset);
    }
    int munmap(void* memory, std::size_t length) override { return ::munmap(memory, length); }
    int poll(std::span<pollfd> descriptors, int timeout_ms) override {
        return ::poll(descriptors.data(), descriptors.size(), timeout_ms);
    }
};

std::vector<std::string> LinuxVideo::nodes() {
    constexpr std::string_view begin = "video";
    std::vector<std::pair<int, std::string>> found;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator("/dev", ignored)) {
        const std::string name = entry.path().filename().string();
        const std::string digits = name.substr(std::min(name.size(), begin.size()));
        if (!name.starts_with(begin) || digits.empty() || digits.size() > 4 ||
            digits.find_first_not_of("0123456789") != std::string::npos)
            continue;
        found.emplace_back(std::stoi(digits), entry.path().string());
    }
    std::sort(found.begin(), found.end());
    std::vector<std::string> nodes;
    for (auto& [number, node] : found) nodes.push_back(std::move(node));
    return nodes;
}

/// What lets this user open a node.
std::string permission_words(const std::string& node) {
    struct stat file = {};
    std::string group = "video";
    constexpr unsigned group_may = S_IRGRP | S_IWGRP;
    if (::stat(node.c_str(), &file) == 0) {
        const struct group* entry = file.st_gid == 0 ? nullptr : getgrgid(file.st_gid);
        group = entry != nullptr && (file.st_mode & group_may) == group_may ? entry->gr_name : "";
    }
    if (!group.empty()) return "sudo usermod -aG " + group + " $USER, then log in again";
    return "a udev rule that gives it to who sits at the machine: echo 'SUBSYSTEM==\"video4linux\", "
           "GROUP=\"video\", MODE=\"0660\", TAG+=\"uaccess\"' | sudo tee /etc/udev/rules.d/70-cameras.rules "
           "&& sudo udevadm control --reload && sudo udevadm trigger";
}

}  // namespace

std::shared_ptr<VideoSystem> system_video() {
    return std::make_shared<LinuxVideo>();
}

int call(VideoSystem& system, int descriptor, unsigned long request, void* argument) {
    int result = 0;
    do result = system.ioctl(descriptor, request, argument);
    while (result < 0 && errno == EINTR);
    return result;
}

std::string node_trouble(const std::string& node, int failure) {
    const std::string name = printable(node);
    switch (failure) {
        case ENOENT:
            return name + ": does not exist; touchable cameras lists the cameras that are there";
        case EACCES:
        case EPERM:
            return name + ": may not be opened by this user; right would be " + permission_words(node);
        case EBUSY: {
            const std::string users = users_of_node(node);
            return name + ": another program has the camera" + (users.empty() ? "" : ": " + users) +
                   "; end that first";
        }
        case ENODEV:
        case ENXIO:
            return name + ": the camera behind it is gone; is it plugged in?";
        case ENOSPC:
            return name +
                   ": the USB bus has no room for a stream of this size and rate; smaller ones (size=WxH, "
                   "fps=N), another port or another cable would do";
        case EINVAL:
        case ENOTTY:
            return name + ": is no camera's node; touchable cameras lists those that are";
        default:
            return name + ": cannot be used: " + std::generic_category().message(failure);
    }
}

std::string users_of_node(const std::string& node) {
    struct stat device = {};
    if (::stat(node.c_str(), &device) != 0 || !S_ISCHR(device.st_mode)) return {};
    std::string users;
    std::error_code ignored;
    for (const auto& process : fs::directory_iterator("/proc", ignored)) {
        const std::string number = process.path().filename().string();
        if (number.find_first_not_of("0123456789") != std::string::npos) continue;
        std::error_code hidden;
        for (const auto& file : fs::directory_iterator(process.path() / "fd", hidden)) {
            struct stat open = {};
            if (::stat(file.path().c_str(), &open) != 0 || !S_ISCHR(open.st_mode) ||
                open.st_rdev != device.st_rdev)
                continue;
            std::string name;
            std::ifstream comm(process.path() / "comm");
            std::getline(comm, name);
            users += (users.empty() ? "" : ", ") + printable(name) + " (process " + number + ")";
            break;
        }
    }
    return users;
}

}  // namespace touchable
