#pragma once

#include <functional>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What is wrong, with the options of the settings that the error hints at. An option stands in for its bare
/// name where the message begins with that, "damping must be ..."; others follow in brackets. `knows`:
/// whether the command that failed has an option; one that it has not is not spoken of.
using KnowsOption = std::function<bool(const std::string& option)>;
std::string message_with_options(const Error& error, const KnowsOption& knows = {});
/// A remark as a person reads it who can type options: of a guess, which of them say otherwise.
std::string remark_with_options(const Remark& remark);
std::vector<std::string> remarks_with_options(const std::vector<Remark>& remarks);

/// " --intrinsics 525,525 --depth-unit 0.001", to go behind a command.
std::string typed_options(const Hints& hints);

}  // namespace touchable
