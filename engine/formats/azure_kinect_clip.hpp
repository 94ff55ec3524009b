#pragma once

#include "engine/formats/guessed_scene.hpp"

namespace touchable {

/// Whether a file is Matroska as the Azure Kinect's recorder writes it: tracks of the names DEPTH and perhaps
/// COLOR, tags K4A_*.
bool is_k4a_recording(const SourceFile& file);

/// Its scene: depth in millimetres, cameras and lenses as its calibration.json has them.
Result<GuessedScene> guess_k4a(const SourceFile& file, const SourceDescription& known);

}  // namespace touchable
