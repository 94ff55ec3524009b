#pragma once

#include <glm/vec3.hpp>

#include "engine/scene/scene.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// From where the window looks: the clip's own camera until somebody turns, moves or nears it.
class WindowView {
public:
    /// `middle`: of what there is to see, world.
    WindowView(const Scene& scene, const glm::dvec3& middle);

    ViewCamera camera(int width, int height) const;
    /// From now on it looks from the upper part of the picture: below is so large a share of the height for
    /// something else.
    void leave_below(double share) { below_ = share; }
    /// As seen by whoever looks at `other`, of another clip: turned likewise, and as near.
    void look_as(const WindowView& other);
    /// Whether it is the clip's own camera.
    bool own() const { return own_; }
    const Viewpoint& orbit() const { return orbit_; }
    /// How far apart neighbouring vertices lie in the middle of a picture of that size, as long as the view
    /// is not turned; a turned one has some of them closer.
    double pixels_per_vertex(int width, int height) const;

    /// By which a drag as long as the picture is high turns it.
    static constexpr double degrees_per_height = 216;
    /// Turns the view by so many degrees to the right and up.
    void turn(double azimuth, double elevation);
    /// Moves the view so that the picture, of that size, follows the pointer by so many pixels.
    void pan(double x, double y, int width, int height);
    /// Brings the view nearer by this factor; below 1 farther away.
    void near_by(double factor);
    /// From now on the view turns round this place, which is seen then where the clip's camera has its axis.
    void look_at(const glm::dvec3& place);
    void go_home();

private:
    void leave_own();
    void set_centre(const glm::dvec3& place);

    const Scene& scene_;
    glm::dvec3 home_, centre_;
    bool own_ = true;
    double below_ = 0;
    Viewpoint orbit_{};
};

}  // namespace touchable
