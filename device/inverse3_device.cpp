#include "device/inverse3_device.hpp"

#include <array>

#include "device/hand_options.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

const Inverse3Choice standard_arm;
constexpr std::string_view of_inverse3 = "device 'inverse3'";
const std::array<HandKey, 8> inverse3_keys{{
    {"id", "what the service calls the arm, such as 049D", 0, 0, 0, HandKey::Kind::words},
    {"port", "", 1, 65535, 10001, HandKey::Kind::whole},
    {"service", "the version of the service, such as 3.4", 0, 0, 0, HandKey::Kind::words},
    {"right", "m", -1, 1, standard_arm.centre.x},
    {"up", "m", -1, 1, standard_arm.centre.y},
    {"towards", "m", -1, 1, standard_arm.centre.z},
    {"force", "N", 0.1, 20, standard_arm.limits.max_force},
    {"stiffness", "N/mm", 0.01, 10, standard_arm.limits.max_stiffness / 1000},
}};

}  // namespace

Result<Inverse3Choice> read_inverse3_choice(std::string_view keys) {
    const auto given = HandOptions::parse(of_inverse3, keys, inverse3_keys);
    if (!given.ok()) return given.error();
    Inverse3Choice choice;
    choice.id = given->words("id");
    choice.port = static_cast<std::uint16_t>(given->number("port"));
    if (given->given("service")) {
        const auto version = parse_inverse3_version(given->words("service"));
        if (!version.ok()) return usage_error(std::string(of_inverse3) + ": " + version.error().message);
        if (const auto known = inverse3_dialect(*version); !known.ok())
            return usage_error(std::string(of_inverse3) + ": " + known.error().message);
        choice.version = *version;
    }
    choice.centre = {given->number("right"), given->number("up"), given->number("towards")};
    choice.limits = {given->number("force"), given->number("stiffness") * 1000};
    return choice;
}

Result<std::unique_ptr<HapticDevice>> make_inverse3_device(std::string_view keys,
                                                           const DrivenSettings& driven) {
    TRY_ASSIGN(auto choice, read_inverse3_choice(keys));
    auto service = std::make_unique<LocalHaplyService>(choice.port);
    return std::unique_ptr<HapticDevice>(std::make_unique<DrivenDevice>(
        std::make_unique<Inverse3Driver>(std::move(choice), std::move(service)), driven));
}

}  // namespace touchable
