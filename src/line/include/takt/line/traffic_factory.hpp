// Makes observers for the frames of lines.
#pragma once

#include <functional>
#include <memory>

#include "takt/model/line.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::line {

/// Makes the observer of the frames of one line or listener; nullptr: there is none.
using TrafficFactory = std::function<std::shared_ptr<wire::TrafficObserver>(const model::Line& line)>;

}  // namespace takt::line
