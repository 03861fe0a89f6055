#pragma once

#include <functional>
#include <string_view>

namespace afptraj {

/// Takes the content of a file part by part, in order.
using TextSink = std::function<void(std::string_view part)>;

}  // namespace afptraj
