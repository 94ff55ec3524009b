#pragma once

#include <functional>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The error's message with the options of its hinted settings. If the message begins with a setting's bare
/// name ("damping must be ..."), the option replaces it; others follow in brackets. `knows`: whether the
/// failed command has an option; unknown options are omitted.
using KnowsOption = std::function<bool(const std::string& option)>;
std::string message_with_options(const Error& error, const KnowsOption& knows = {});
/// A remark with the options that correct it, if it is a guess.
std::string remark_with_options(const Remark& remark);
std::vector<std::string> remarks_with_options(const std::vector<Remark>& remarks);

/// " --intrinsics 525,525 --depth-unit 0.001", to append to a command.
std::string typed_options(const Hints& hints);

}  // namespace touchable
