#include "player/window/universal_time.hpp"

#include <ctime>

namespace touchable {

std::string in_universal_time(std::chrono::system_clock::time_point time) {
    const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    char words[32];
    return {words, std::strftime(words, sizeof words, "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

}  // namespace touchable
