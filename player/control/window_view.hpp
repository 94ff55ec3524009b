#pragma once

#include <glm/vec3.hpp>

#include "engine/scene/scene.hpp"
#include "player/view/view_camera.hpp"

namespace touchable {

/// From where the window looks: the clip's own camera until somebody turns, moves or nears it.
class WindowView {
public:
    /// `middle`: of what there is to see, world.
    WindowView(const Scene& scene, const glm::dvec3& middle);

    ViewCamera camera(int width, int height) const;
    bool own() const { return own_; }
    const Viewpoint& orbit() const { return orbit_; }

    /// By so many degrees to the right and up.
    void turn(double azimuth, double elevation);
    /// So many pixels of a picture of that size, along with the pointer.
    void pan(double x, double y, int width, int height);
    /// So many times as near.
    void near_by(double factor);
    /// Round this place from now on, which is the picture's middle then.
    void look_at(const glm::dvec3& place);
    void go_home();

private:
    void leave_own();
    void set_centre(const glm::dvec3& place);

    const Scene& scene_;
    glm::dvec3 home_, centre_;
    bool own_ = true;
    Viewpoint orbit_{};
};

}  // namespace touchable
