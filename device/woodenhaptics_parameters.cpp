#include "device/woodenhaptics_parameters.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/given_file.hpp"
#include "engine/base/try.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using checked_json::Node;

double within(const Node& node, double least, double most, const char* right) {
    const double number = node.number();
    if (!(number >= least && number <= most)) node.refuse(right);
    return number;
}

/// Of either sign, but not of none.
double signed_within(const Node& node, double least, double most, const char* right) {
    const double number = node.number();
    if (!(std::abs(number) >= least && std::abs(number) <= most)) node.refuse(right);
    return number;
}

bool yes_or_no(const Node& node) {
    const std::pair<const char*, bool> choices[] = {{"yes", true}, {"no", false}};
    return node.one_of(choices);
}

WoodenJoint read_joint(const Node& node) {
    node.allow_only({"counts_per_turn", "capstan_diameter", "drum_diameter", "torque_constant",
                     "most_amperes", "home_counts"});
    const double capstan =
        within(node["capstan_diameter"], 0.001, 0.1, "the diameter on the motor's axle, 0.001 to 0.1 m");
    const double drum =
        within(node["drum_diameter"], 0.01, 1, "the diameter that the cable turns, 0.01 to 1 m");
    if (!(capstan < drum)) node["capstan_diameter"].refuse("less than drum_diameter");
    WoodenJoint joint;
    joint.counts_per_turn =
        signed_within(node["counts_per_turn"], 16, 1e6, "16 to 1000000, quadrupled, either sign");
    joint.cable_ratio = capstan / drum;
    joint.torque_constant =
        signed_within(node["torque_constant"], 0.001, 10, "0.001 to 10 N m/A, either sign");
    joint.most_amperes = within(node["most_amperes"], 0.01, 30, "0.01 to 30 A");
    joint.home_counts = static_cast<std::int16_t>(node["home_counts"].integer(
        std::numeric_limits<std::int16_t>::min(), std::numeric_limits<std::int16_t>::max()));
    return joint;
}

WoodenParameters read_build(const Node& node) {
    node.allow_only({"touchable_woodenhaptics", "notes", "name", "drive", "homing", "joints", "links",
                     "origin", "reach", "most_force", "most_stiffness"});
    node["touchable_woodenhaptics"].integer(1, 1);
    WoodenParameters build;
    build.name = node["name"].text();
    build.drive = yes_or_no(node["drive"]);
    const std::pair<const char*, WoodenParameters::Homing> homings[] = {
        {"start", WoodenParameters::Homing::start}, {"button", WoodenParameters::Homing::button}};
    build.homing = node["homing"].one_of(homings);
    const auto joints = node["joints"].elements(3, 3, "a list of the three joints");
    const auto links = node["links"].elements(3, 3, "a list of three lengths");
    const auto origin = node["origin"].elements(3, 3, "a list of three lengths");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        build.joints[axis] = read_joint(joints[axis]);
        build.links[axis] = within(links[axis], axis == 0 ? 0 : 0.02, 1, "at most 1 m; a moving link 0.02");
        build.origin[static_cast<int>(axis)] = within(origin[axis], -2, 2, "-2 to 2 m");
    }
    build.reach = within(node["reach"], 0.01, 1, "0.01 to 1 m");
    build.limits.max_force = within(node["most_force"], 0.1, 50, "0.1 to 50 N");
    build.limits.max_stiffness = within(node["most_stiffness"], 10, 1e5, "10 to 100000 N/m");
    return build;
}

}  // namespace

Result<WoodenParameters> parse_wooden_parameters(std::string_view json, std::string_view where) {
    const auto refused = [&](const std::string& why) { return input_error(std::string(where) + ": " + why); };
    try {
        const checked_json::Json text = checked_json::parse(json);
        return read_build(Node(text, ""));
    } catch (const checked_json::Refusal& reason) {
        return refused(reason.message);
    } catch (const checked_json::Json::exception& fault) {
        return refused(fault.what());
    }
}

Result<WoodenParameters> read_wooden_parameters(const std::filesystem::path& file) {
    const std::string right = "a parameter file such as " + std::string(wooden_example);
    TRY_ASSIGN(const auto text, read_given_file(file, file.string(), right, checked_json::largest_text));
    return parse_wooden_parameters(text, file.string());
}

}  // namespace touchable
