#include "player/commands/verify_run.hpp"

#include <algorithm>
#include <utility>

#include "engine/authoring/clip_quality.hpp"
#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "engine/picture/image_file.hpp"
#include "player/commands/clip_findings.hpp"
#include "player/commands/outputs.hpp"
#include "player/run/progress.hpp"

namespace touchable {
namespace {

Result<void> draw(const std::vector<Finding>& findings, const ClipQuality& quality, NewFile& file) {
    const Image image = picture_of(findings, quality.where.picture);
    if (auto written = write_png(file, image.view()); !written) return written;
    return file.commit();
}

nlohmann::ordered_json measures_json(const ClipQuality& quality) {
    const FrameTimes& times = quality.times;
    nlohmann::ordered_json json{{"frames", times.frames},
                                {"repeated", times.repeated},
                                {"missing", times.missing},
                                {"jumps", times.jumps},
                                {"longest_ms", times.longest_ms}};
    if (quality.pumping) json["pumping"] = *quality.pumping;
    if (quality.colour) {
        const ColourEdges::Fit& fit = *quality.colour;
        const auto known = [](const std::optional<double>& value) {
            return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
        };
        json["colour_edges"] = {{"edges", fit.edges},
                                {"agreement", fit.agreement},
                                {"right", known(fit.right)},
                                {"below", known(fit.below)},
                                {"rim", fit.rim}};
    }
    if (quality.haptic)
        json["haptic"] = {{"stiffest_n_per_mm", quality.haptic->stiffest},
                          {"too_stiff", quality.haptic->too_stiff},
                          {"more_dynamic", quality.haptic->more_dynamic},
                          {"mixed", quality.haptic->mixed}};
    return json;
}

std::string measures_in_words(const ClipQuality& quality, bool has_colour) {
    const auto number = [](double value) { return short_number(value, 3); };
    std::string words =
        std::to_string(quality.times.frames) + (quality.times.frames == 1 ? " frame" : " frames");
    if (quality.pumping) words += "; depth goes to and fro by " + number(100 * *quality.pumping) + " %";
    if (!has_colour) return words + "; no colour, which could be beside depth";
    if (!quality.colour) return words + "; too few edges to tell whether colour is where depth is";
    const ColourEdges::Fit& fit = *quality.colour;
    words += "; colour against depth at " + std::to_string(fit.edges) + " edges (" +
             number(100 * fit.agreement) + " % agree):";
    if (fit.right) words += ' ' + number(*fit.right) + " pixels to the right,";
    if (fit.below) words += ' ' + number(*fit.below) + " below,";
    return words + " rims " + number(fit.rim) + " wide";
}

}  // namespace

Result<Verified> verify_clip(const ClipChoice& choice, const ClipFacts& facts, const VerifyPicture& picture) {
    TRY_ASSIGN(auto clip, open_chosen(choice, Colour::wanted));
    std::optional<NewFile> file;
    if (picture.file) {
        std::vector<NamedFile> inputs;
        add_inputs(inputs, choice.file, *clip.reader);
        TRY(check_outputs({{{"--picture", *picture.file}}, picture.existing}, inputs));
        file.emplace(*picture.file, picture.existing);
        TRY(file->check());
    }
    Scene scene = facts.scene;
    if (facts.measured) scene.filter.levels = facts.measured->levels;
    Progress progress("looking at frame", facts.frames.value_or(0));
    TRY_ASSIGN(const auto quality,
               measure_quality(*clip.reader, scene, [&](std::int64_t frames) { progress.at(frames); }));
    const auto findings = findings_of(facts, quality);
    if (file) TRY(draw(findings, quality, *file));
    Verified verified;
    for (std::size_t k = 0; k < findings.size(); ++k)
        verified.findings.push_back({findings[k].name, findings[k].what, findings[k].mend,
                                     file ? colour_of(findings, k) : std::string()});
    verified.drawn = file.has_value();
    verified.measures = measures_json(quality);
    verified.measures_in_words = measures_in_words(quality, facts.has_track("colour"));
    return verified;
}

std::string verified_in_words(const Verified& verified) {
    std::string words = "  verified     " + verified.measures_in_words + '\n';
    if (verified.findings.empty()) words += "  fine         nothing was found that would feel wrong\n";
    for (const NamedFinding& finding : verified.findings) {
        words += "  wrong        " + finding.name + ": " + finding.what +
                 (finding.colour.empty() ? std::string() : " (" + finding.colour + " in the picture)") + '\n';
        words += "  mended by    " + finding.mend + '\n';
    }
    const bool is_marked = std::any_of(verified.findings.begin(), verified.findings.end(),
                                       [](const NamedFinding& finding) { return !finding.colour.empty(); });
    if (verified.drawn && !is_marked)
        words += "  picture      has no marks: nothing of this has a place in the first frame\n";
    return words;
}

void add_verified(const Verified& verified, nlohmann::ordered_json& json) {
    json["measures"] = verified.measures;
    json["findings"] = nlohmann::ordered_json::array();
    for (const NamedFinding& finding : verified.findings) {
        json["findings"].push_back({{"name", finding.name}, {"what", finding.what}, {"mend", finding.mend}});
        if (!finding.colour.empty()) json["findings"].back()["colour"] = finding.colour;
    }
}

}  // namespace touchable
