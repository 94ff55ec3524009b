#include "device/catalog/udev_rules.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>

namespace touchable {

std::vector<std::string> udev_rules_of(std::uint16_t vendor) {
    std::array<char, 5> lower{}, upper{};
    std::snprintf(lower.data(), lower.size(), "%04x", vendor);
    std::snprintf(upper.data(), upper.size(), "%04X", vendor);
    const std::array marks{"idVendor}==\"" + std::string(lower.data()) + "\"",
                           ":" + std::string(upper.data()) + ":"};
    std::vector<std::string> rules;
    std::istringstream file(udev_rules());
    for (std::string line; std::getline(file, line);)
        if (!line.starts_with("#") && std::any_of(marks.begin(), marks.end(), [&](const std::string& mark) {
                return line.find(mark) != std::string::npos;
            }))
            rules.push_back(line);
    return rules;
}

}  // namespace touchable
