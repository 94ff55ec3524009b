#include "player/commands/verdict.hpp"

#include <algorithm>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/formats/known_camera.hpp"

namespace touchable {
namespace {

/// Smooth places that lean farther to and fro feel rough.
constexpr double rough_deg = 10;
/// Filters that leave so much less than those that are on are worth a line.
constexpr double worth_while = 0.67;
constexpr double many_holes_pct = 60;

/// The guess about the camera; null: somebody told what it sees.
const Remark* guess_of_the_camera(const ClipFacts& facts) {
    for (const Remark& remark : facts.scene.remarks)
        if (guesses_camera(remark)) return &remark;
    return nullptr;
}

std::string degrees(double value) {
    return short_number(value, 2) + " degrees";
}

}  // namespace

std::string verdict_on(const ClipFacts& facts, const std::vector<NamedFinding>* findings) {
    const std::string clip = shell_word(facts.clip);
    if (facts.nearest == 0 && facts.farthest == 0) return "nothing to touch: the first frame has no depth";
    if (!facts.unit_doubt.empty()) return facts.unit_doubt;
    const auto* const measured = facts.measured ? &*facts.measured : nullptr;
    const TriedFilters* const now = measured ? found_among(measured->tried, facts.scene.filter) : nullptr;
    const TriedFilters* const best =
        measured ? mildest_of_the_best(measured->tried, measured->is_noisy(facts.scene.width)) : nullptr;
    if (now && best && now->left_deg > rough_deg && best->left_deg < worth_while * now->left_deg)
        return "rough: smooth places lean " + degrees(now->left_deg) + " to and fro, and " +
               degrees(best->left_deg) + " with other filters: touchable play " + clip + " --filters auto";
    if (findings != nullptr && !findings->empty())
        return findings->front().name + ", see above: " + findings->front().mend;
    if (const Remark* const guess = guess_of_the_camera(facts))
        return "good to touch if the camera is right (" + guess->what +
               "): say what it sees, touchable play " + clip + " --fov DEGREES";
    if (facts.invalid_pct > many_holes_pct)
        return "little to touch: " + short_number(facts.invalid_pct, 2) +
               " % of the first frame has no depth";
    if (now && now->left_deg > rough_deg)
        return "rough: smooth places lean " + degrees(now->left_deg) +
               " to and fro, whatever the filters: record from nearer, or with more light";
    return "good to touch: touchable play " + clip;
}

}  // namespace touchable
