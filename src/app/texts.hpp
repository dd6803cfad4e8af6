// The messages of the command line.
#pragma once

#include "takt/report/drawing/texts.hpp"

namespace takt::app {

using report::Texts;
using report::without_stop;

}  // namespace takt::app
