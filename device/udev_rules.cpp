#include "device/udev_rules.hpp"

#include <algorithm>
#include <array>
#include <sstream>

#include "engine/base/number_words.hpp"

namespace touchable {

std::vector<std::string> udev_rules_of(std::uint16_t vendor) {
    const std::array marks{formatted("idVendor}==\"%04x\"", vendor), formatted(":%04X:", vendor)};
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
