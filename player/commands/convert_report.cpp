#include "player/commands/convert_report.hpp"

#include <algorithm>

#include "engine/base/number_words.hpp"
#include "engine/formats/image_folder_writer.hpp"
#include "engine/formats/lerobot_writer.hpp"

namespace touchable {

namespace {

std::string how_stored(const TrackInfo& track, bool is_still) {
    return track.codec + (is_still ? ", one picture for all frames" : "");
}

/// `may_be_exact`: the command has an option for that.
std::string loss_in_words(PlaneRole role, const PlaneLoss& loss, bool resized, bool may_be_exact) {
    if (loss.changed == 0 && !resized) return "every value kept";
    const std::string share =
        formatted("%.3g %% of the values differ, by %d at most, RMS %.3g",
                  100.0 * static_cast<double>(loss.changed) / static_cast<double>(loss.samples), loss.largest,
                  loss.rms());
    if (role == PlaneRole::colour)
        return (resized ? "averaged: " : "as good as the eye can tell: ") + share +
               (resized || !may_be_exact ? "" : " (--exact-colour keeps every value)");
    std::string words = "LOST: of the pixels before, " + share + "; ";
    if (role != PlaneRole::depth) return words.substr(0, words.size() - 2);
    if (loss.is_recoded) words = "LOST: stored as other codes; ";
    words += formatted("depths by %.3g mm at most, RMS %.3g mm", 1000 * loss.largest_metres,
                       1000 * loss.rms_metres());
    if (loss.appeared + loss.disappeared > 0)
        words += formatted("; %lld pixels lost their depth, %lld without one have one now",
                           static_cast<long long>(loss.disappeared), static_cast<long long>(loss.appeared));
    return words;
}

std::string forces_in_words(const ForceComparison& forces) {
    if (forces.both == 0) return "a standard stroke never touches both: what it feels cannot be compared";
    return formatted(
        "on a standard stroke %.2g degrees off on average, 95 %% at most %.2g; %.2g N, at most %.2g "
        "of %.2g N (mean)",
        forces.direction_degrees.mean, forces.direction_degrees.p95, forces.difference_n.mean,
        forces.difference_n.max, forces.mean_a_n);
}

std::string line(const std::string& name, const std::string& words) {
    return "  " + name + std::string(name.size() < 8 ? 8 - name.size() : 1, ' ') + words + "\n";
}

/// A still's files beside the one that was named.
std::string files_beside(const ConvertOptions& options, const Converted& done) {
    const bool is_text = options.form == ClipForm::scene_text;
    const auto opens_it = is_text ? options.out : still_files(options.out)[1];
    std::string words = opens_it.string() + " describes it, and is what opens it";
    for (const TrackInfo& track : done.tracks)
        if (is_text || track.role != "depth")
            words += "; " + options.out.stem().string() + "_" + track.role + ".png is its " + track.role;
    return words;
}

/// Those that a glTF scene names.
std::string files_of_scene(const ConvertOptions& options, const Converted& done) {
    const std::string stem = options.out.stem().string();
    const bool has_colour = std::any_of(done.tracks.begin(), done.tracks.end(),
                                        [](const TrackInfo& track) { return track.role == "colour"; });
    std::string words = stem + ".bin";
    if (done.frames > 1) words += ", " + stem + ".mp4";
    if (done.frames > 1 || !has_colour) words += ", " + stem + ".png";
    if (done.frames == 1)
        for (const TrackInfo& track : done.tracks) words += ", " + stem + "_" + track.role + ".png";
    return words + " lie beside it and belong to it";
}

std::string beside_lerobot_video(const ConvertOptions& options) {
    return lerobot_info_file(options.out).string() +
           " says what its codes are, for the features of a data set's meta/info.json; colour, haptic, "
           "height "
           "and sound are not in it";
}

}  // namespace

std::string report_to_text(const ConvertOptions& options, const Converted& done) {
    const Scene& scene = done.scene;
    const bool resized = options.size.has_value();
    std::string text = options.out.string() + ": " + std::to_string(done.frames) +
                       (done.frames == 1 ? " frame, " : " frames, ") + std::to_string(scene.width) + "x" +
                       std::to_string(scene.height);
    if (!is_one_frame(options.form))
        text += formatted(
            scene.rate.own_times ? ", each at its own time, %.6g frames/s on average" : ", %.6g frames/s",
            scene.rate.per_second());
    text += "\n";
    for (const TrackInfo& track : done.tracks) {
        const auto role = role_named(track.role);
        if (!role) continue;
        const bool is_still = done.frames > 1 && scene.folder && options.form == ClipForm::folder &&
                              ((*role == PlaneRole::colour && touchable::is_still(scene.folder->colour)) ||
                               (*role == PlaneRole::haptic && touchable::is_still(scene.folder->haptic)) ||
                               (*role == PlaneRole::height && touchable::is_still(scene.folder->height)));
        text += line(track.role, loss_in_words(*role, done.losses[static_cast<std::size_t>(*role)], resized,
                                               !options.content) +
                                     " (" + how_stored(track, is_still) + ")");
    }
    if (!done.sound.empty()) text += line("sound", done.sound);
    if (done.forces) text += line("force", forces_in_words(*done.forces));
    if (is_one_frame(options.form) && options.form != ClipForm::mp4_still)
        text += line("scene", files_beside(options, done));
    if (options.form == ClipForm::lerobot) text += line("scene", beside_lerobot_video(options));
    if (options.form == ClipForm::gltf) text += line("scene", files_of_scene(options, done));
    for (const std::string& note : done.notes) text += line("note", note);
    return text;
}

}  // namespace touchable
