#pragma once

#include "player/window/clip_picture.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/panel_contents.hpp"

namespace touchable {

/// What there is to show of a clip at a moment, but for what the window itself knows (messages, loop).
PanelFacts panel_facts(const OpenedClip& clip, const ClipPicture& picture, const WatchedMoment& moment,
                       const HeightField& field, const ViewCamera& camera);

}  // namespace touchable
