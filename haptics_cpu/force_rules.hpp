#pragma once

namespace touchable {

/// The rules by which forces come about, by number. A change that is meant to give other forces for the same
/// frames and goals gives a new number and says here what it was; forces made under different numbers are not
/// compared. (Between two releases the number is raised once.)
///
/// 1: until 0.1 was in the making, and recordings that do not say. Haptic properties of the frame nearer in
///    time, friction where a facet is entered, velocities over one tick whatever time had passed.
/// 2: properties blended in time as depth is, friction of the place where a slide ends, velocities over the
///    time that has passed, no force on a goal that is buried when its surface is new, ramps that resume,
///    normals made of the sides that meet at a face's nearest corner, what is sudden by the hand's own time, a jump's fade that rests while a goal is missing.
inline constexpr int force_rules = 2;

}  // namespace touchable
