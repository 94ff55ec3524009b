#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/byte_source.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// What whoever opens a clip wants of it.
struct OpenSettings {
    Colour colour = Colour::wanted;
    DepthAlignment alignment = DepthAlignment::automatic;
    std::optional<double> least_confidence{};  ///< of a .npz, whoever describes it
};

using Opened = Result<std::unique_ptr<ClipReader>>;

/// First bytes of a file that tell of which kind it is.
constexpr std::size_t telling_bytes = 16;

/// Kinds of files, in the order in which they are tried.
std::vector<ClipFormat> file_formats();

/// By the first of these that recognises it. `described`: replaces the file's own description.
Opened open_file(const SourceFile& source, const std::optional<SceneDescription>& described,
                 const SourceDescription& known, const OpenSettings& wanted);

/// The scene of a file that has none, or of a clip of ours that which is in it.
Result<GuessedScene> guess_file(const SourceFile& source, const SourceDescription& known);

/// As a scene in `folder` describes it, whose depth is in this file.
Opened open_described_video(const std::filesystem::path& folder, const SourceFile& depth,
                            const SceneDescription& described, const OpenSettings& wanted);

/// What was read to guess is not to be written over.
Opened with_inputs(Opened reader, const std::vector<std::filesystem::path>& inputs);

/// What describes pictures that do not describe themselves.
Hints of_bare_pictures();

}  // namespace touchable
