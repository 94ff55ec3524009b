#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <optional>
#include <span>

#include "device/pointer_device.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "haptics_cpu/workspace.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// The pointer over the picture, as fingers of a device: over what is seen there, or pressed into it. Or the
/// fingers on a touch screen, each of which presses where it is; while one is down the pointer leads none.
class PointerFingers {
public:
    static constexpr int most = 5;
    static constexpr double hover_m = -0.004;  ///< device metres: above the surface where nobody presses
    static constexpr double press_m = 0.004;   ///< what holding the button presses to
    static constexpr double deepest_m = 0.012, highest_m = -0.008;

    /// `device` has `most` fingers and outlives this.
    PointerFingers(PointerDevice& device, const Workspace& workspace)
        : device_(device), workspace_(workspace) {}

    void set_count(int fingers) { count_ = fingers; }
    int count() const { return count_; }
    /// Of them, those that are meant somewhere: none before the pointer was over something for the first
    /// time.
    int shown() const;
    /// How many there are, away or not: of a touch screen up to the last that is down.
    int present() const { return is_touched() ? touched() : count_; }
    /// Fingers of a touch screen lead all of them.
    bool is_touched() const { return touched() > 0; }
    /// The pointer is there, pixels of the picture; nothing: nowhere, and no finger touches.
    void set_pointer(std::optional<glm::dvec2> at);
    const std::optional<glm::dvec2>& pointer() const { return pointer_; }
    /// The place that a person looks at: the pointer's, or that of the first finger on a touch screen.
    std::optional<glm::dvec2> looked_at() const;

    // Fingers on a touch screen, which count from 0.
    /// One comes down there, pixels of the picture, and presses; which it is. Nothing: there are no more.
    std::optional<std::size_t> put_down(const glm::dvec2& at);
    bool has_free() const;
    void move(std::size_t finger, const glm::dvec2& at) { touches_[finger] = at; }
    /// It touches nothing any more, from now on.
    void lift(std::size_t finger);

    void press(bool held) {
        held_ = held;
        was_pressed_ = was_pressed_ || held;
    }
    bool was_pressed() const { return was_pressed_; }  ///< ever
    /// Device metres, into the surface; stays when the button is let go.
    void deepen(double metres);
    /// Takes the depth back to `hover_m`: fingers are above the surface again, until somebody presses.
    void lift() { rest_m_ = hover_m; }
    /// How deep fingers are meant to be in the surface, device metres; below 0 above it.
    double depth_m() const;

    /// Once a picture: tells the device where the fingers are meant to be over what `camera` shows of
    /// `field`. `felt`: what they met last. A finger is not pressed into a hole, where no surface is seen. A
    /// finger that an obstacle holds back goes over it: first towards the clip's camera, where nothing can be
    /// in its way, then across, then down again.
    void intend(const HeightField& field, const ViewCamera& camera, std::span<const Contact> felt = {});

private:
    int touched() const;
    void lead(std::size_t finger, const glm::dvec2& at, const HeightField& field, const ViewCamera& camera,
              const Contact* felt);
    /// Where a finger is meant to be, and what of the surface is seen there; nothing: a hole. World.
    struct Meant {
        glm::dvec3 place;
        std::optional<glm::dvec3> ground;
    };
    std::optional<Meant> meant_at(std::size_t finger, const glm::dvec2& at, const HeightField& field,
                                  const ViewCamera& camera, const Contact* felt);
    std::optional<glm::dvec3> way_over(std::size_t finger, const HeightField& field, const glm::dvec3& ground,
                                       double deep_m, const Contact& felt);
    bool is_caught(const Contact& felt, double deep_m) const;

    PointerDevice& device_;
    Workspace workspace_;
    std::optional<glm::dvec2> pointer_;
    std::array<std::optional<glm::dvec2>, most> touches_{};
    int count_ = 1;
    bool held_ = false, was_pressed_ = false;
    double rest_m_ = hover_m;
    std::array<bool, most> goes_over_{};
    std::array<glm::dvec3, most> lifted_to_{};  // world: what was meant when it was last lifted
    std::optional<double> distance_;            // scene units, from the eye to what was met last
};

}  // namespace touchable
