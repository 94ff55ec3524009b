// SPDX-License-Identifier: Apache-2.0
#include "bench/paper/scratch_run.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "bench/clocks.hpp"
#include "bench/touch/force_spectrum.hpp"
#include "bench/touch/solver_ticks.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {
namespace {

constexpr int segments = 10, segment_ticks = 10'000, settling_ticks = 1000;  // the paper's: 100 s at 1 kHz
constexpr double rate_hz = 1000;
constexpr int points_per_octave = 12;

/// One finger on a playing clip, through a device held by a hand: like bench/loop/closed_loop.hpp, but with a
/// moving hand and a noisy surface.
class Scratching {
public:
    Scratching(PlayedClip& played, const TouchSolver& solver, const ScratchHand& hand)
        : played_(played),
          solver_(solver),
          workspace_{solver.settings().metres_per_scene_unit, {0, 0, 0}},
          path_(hand.path),
          handle_(hand.dynamics, 1 / rate_hz),
          // Depth at which the springs of surface and hand balance the force.
          under_(hand.press_n / played.scene().default_properties.stiffness +
                 hand.press_n / hand.dynamics.hand_stiffness) {
        handle_.put(meant(0), glm::dvec3(0.0));
    }

    /// Lateral distance from the proxy to the hand's goal, device metres.
    double held_back(int k, const Contact& contact) const {
        const glm::dvec3 off = workspace_.to_device(contact.proxy) - meant(k);
        return std::sqrt(off.x * off.x + off.y * off.y);
    }

    /// Degrees by which a force lies outside the friction cone of the true surface under the proxy.
    double beyond_friction(const Contact& contact) const {
        const PaperClip& clip = played_.clip();
        const Camera& camera = clip.scene.camera;
        const auto seen = project(camera, contact.proxy);
        if (!seen) return 180;
        const auto point = [&](double right, double down) {
            const double x = seen->x + right, y = seen->y + down;
            return unproject(camera, x, y,
                             planar_depth(camera, clip.scene.depth.semantics, x, y, clip.depth(x, y)));
        };
        constexpr double step = 0.01;  // pixels
        const glm::dvec3 normal =
            glm::cross(point(0, step) - point(0, -step), point(step, 0) - point(-step, 0));
        const double cone = 180 / pi * arctangent(clip.scene.default_properties.static_friction);
        return std::max(0.0, degrees_between(contact.force, normal) - cone);
    }

    std::string hash() const { return hash_.hex(); }

    /// The contact of tick k, or an error that states its fault.
    Result<Contact> tick(int k) {
        played_.play_to(k * tick_length_ns);
        const HeightField field(played_.scene(), played_.pair_at(k * tick_length_ns));
        const glm::dvec3 goal = workspace_.to_scene(handle_.reading());
        Contact contact;
        solver_.tick(field, {&goal, 1}, {&finger_, 1}, {&contact, 1});
        if (const char* fault = fault_of(contact, field, workspace_.metres_per_scene_unit,
                                         behind_tolerance(solver_.settings().metric)))
            return Error{ErrorKind::check, "tick " + std::to_string(k) + ": " + fault};
        hash_.add(contact.force);
        handle_.intend(meant(k));
        handle_.advance(contact.force);
        return contact;
    }

private:
    /// The hand's goal under the true surface: the user sees a chest, not noise.
    glm::dvec3 meant(int k) const {
        const glm::dvec3 surface = played_.clip().surface_at(path_.at(k / rate_hz));
        return workspace_.to_device(surface) - glm::dvec3(0, 0, under_);
    }

    PlayedClip& played_;
    const TouchSolver& solver_;
    Workspace workspace_;
    ScriptedPath path_;
    HeldHandle handle_;
    double under_;  // device metres along the optical axis
    FingerState finger_;
    ForceHash hash_;  // of all ticks
};

/// The recording: the force's magnitude, tick by tick.
struct Scratched {
    std::vector<double> newtons;
    int touching = 0;
    double held_back_squares = 0;  // device metres squared
    double angle_squares = 0;      // degrees squared, beyond friction
};

Result<Scratched> scratched(Scratching& hand) {
    Scratched recorded;
    for (int k = 0; k < settling_ticks + segments * segment_ticks; ++k) {
        TRY_ASSIGN(const Contact contact, hand.tick(k));
        if (k < settling_ticks) continue;
        recorded.newtons.push_back(glm::length(contact.force));
        recorded.touching += contact.touching;
        const double off = hand.held_back(k, contact);
        recorded.held_back_squares += off * off;
        if (!contact.touching) continue;
        const double angle = hand.beyond_friction(contact);
        recorded.angle_squares += angle * angle;
    }
    if (2 * recorded.touching < segments * segment_ticks)
        return Error{ErrorKind::check, "less than half of the ticks are in contact"};
    return recorded;
}

void add_bands(const Spectrum& spectrum, Figures& figures) {
    const auto rms_mn = [&](double from, double to) { return 1000 * std::sqrt(spectrum.between(from, to)); };
    figures.push_back({"force_band_mn", rms_mn(20, rate_hz / 2), "mN"});
    double from = first_octave_hz;
    for (int octave = 0; octave < octaves; ++octave, from *= 2)
        figures.push_back(
            {formatted("force_band_mn_%.0f_%.0f", from, 2 * from), rms_mn(from, 2 * from), "mN"});
}

/// Appends the density from 1 Hz on, the mean over each twelfth of an octave that contains a wave.
void add_curve(const Spectrum& spectrum, Figures& figures) {
    const double ratio = std::pow(2, 1.0 / points_per_octave), half = rate_hz / 2;
    for (double from = 1; from < half; from *= ratio) {
        double sum = 0, waves = 0;
        for (std::size_t k = 0; k < spectrum.power.size(); ++k) {
            const double hz = static_cast<double>(k) * spectrum.hz_step;
            if (hz < from || hz >= from * ratio) continue;
            sum += spectrum.power[k];
            ++waves;
        }
        if (waves == 0) continue;
        figures.push_back({formatted("force_psd_%.4ghz", from * std::sqrt(ratio)),
                           sum / (waves * spectrum.hz_step), "N^2/Hz", false});
    }
}

}  // namespace

Result<void> measure_scratch(std::shared_ptr<const PaperClip> clip, const ScratchRun& run, Figures& figures) {
    TRY_ASSIGN(const auto played, PlayedClip::make(std::move(clip), run.filter));
    TRY_ASSIGN(const TouchSolver solver, played->solver(run.setup.metric));
    Scratching hand(*played, solver, run.hand);
    TRY_ASSIGN(const Scratched recorded, scratched(hand));

    const Spectrum spectrum = welch_spectrum(recorded.newtons, rate_hz, segments);
    add_bands(spectrum, figures);
    const auto count = static_cast<double>(recorded.newtons.size());
    double sum = 0;
    for (const double newtons : recorded.newtons) sum += newtons;
    figures.push_back({"force_n_mean", sum / count, "N"});
    figures.push_back(
        {"force_n_max", *std::max_element(recorded.newtons.begin(), recorded.newtons.end()), "N"});
    figures.push_back({"held_back_mm", 1000 * std::sqrt(recorded.held_back_squares / count), "mm"});
    figures.push_back({"force_angle_deg_rms", std::sqrt(recorded.angle_squares / recorded.touching), "deg"});
    figures.push_back({"contact_pct", 100 * recorded.touching / count, "%"});
    figures.push_back(named("force_hash", hand.hash()));
    add_curve(spectrum, figures);
    return {};
}

}  // namespace touchable
