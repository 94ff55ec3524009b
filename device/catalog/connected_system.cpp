#include "device/catalog/connected_system.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <system_error>

namespace touchable {
namespace {

namespace fs = std::filesystem;

bool is_number(const std::string& name) {
    return !name.empty() &&
           std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// Of a line of /proc/net/tcp: "  0: 0100007F:2711 00000000:0000 0A ..." listens at 0x2711.
bool line_listens(const std::string& line, std::uint16_t port) {
    constexpr const char* listening = "0A";
    std::istringstream words(line);
    std::string slot, here, there, state;
    if (!(words >> slot >> here >> there >> state) || state != listening) return false;
    const std::size_t colon = here.rfind(':');
    if (colon == std::string::npos) return false;
    unsigned number = 0;
    std::from_chars(here.data() + colon + 1, here.data() + here.size(), number, 16);
    return number == port;
}

}  // namespace

fs::path ConnectedSystem::below(const std::string& path) const {
    return root_ / fs::path(path).relative_path();
}

std::vector<std::string> ConnectedSystem::names(const std::string& folder) const {
    std::vector<std::string> names;
    std::error_code failure;
    for (fs::directory_iterator each(below(folder), failure), end; !failure && each != end;
         each.increment(failure))
        names.push_back(each->path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

bool ConnectedSystem::has(const std::string& path) const {
    std::error_code ignored;
    return fs::exists(below(path), ignored);
}

std::string ConnectedSystem::text(const std::string& path, std::size_t most) const {
    std::ifstream in(below(path), std::ios::binary);
    std::string text(most, '\0');
    if (in) in.read(text.data(), static_cast<std::streamsize>(most));
    text.resize(in.gcount() > 0 ? static_cast<std::size_t>(in.gcount()) : 0);
    while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.pop_back();
    return text;
}

std::string ConnectedSystem::link(const std::string& path) const {
    std::error_code failure;
    const fs::path target = fs::read_symlink(below(path), failure);
    return failure ? std::string() : target.string();
}

std::string ConnectedSystem::resolved(const std::string& path) const {
    std::error_code failure;
    const fs::path whole = fs::canonical(below(path), failure);
    if (failure) return {};
    const fs::path top = fs::canonical(root_, failure);
    if (failure) return {};
    return "/" + whole.lexically_relative(top).string();
}

bool ConnectedSystem::may_use(const std::string& node) const {
    return access(below(node).c_str(), R_OK | W_OK) == 0;
}

std::vector<std::string> holders_of(const ConnectedSystem& system, const std::string& node) {
    std::vector<std::string> holders;
    const std::string own = std::to_string(getpid());
    for (const std::string& process : system.names("/proc")) {
        if (!is_number(process) || process == own) continue;
        const std::string open = "/proc/" + process + "/fd";
        const auto descriptors = system.names(open);
        if (std::any_of(descriptors.begin(), descriptors.end(),
                        [&](const std::string& each) { return system.link(open + "/" + each) == node; }))
            holders.push_back(system.text("/proc/" + process + "/comm") + " (process " + process + ")");
    }
    return holders;
}

bool somebody_listens(const ConnectedSystem& system, std::uint16_t port) {
    constexpr std::size_t many_sockets = 1 << 20;
    for (const char* table : {"/proc/net/tcp", "/proc/net/tcp6"}) {
        std::istringstream lines(system.text(table, many_sockets));
        for (std::string line; std::getline(lines, line);)
            if (line_listens(line, port)) return true;
    }
    return false;
}

}  // namespace touchable
