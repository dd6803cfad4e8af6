// examples/demo.yaml, compiled in.
#pragma once

#include <string_view>

namespace takt::app {

extern const std::string_view kDemoProject;

}  // namespace takt::app
