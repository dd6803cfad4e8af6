// The version of the product. It is stated once, by project() in the CMakeLists.txt of the root.
#pragma once

#include <string_view>

namespace takt::app {

extern const std::string_view kProgramVersion;  ///< three numbers with points

}  // namespace takt::app
