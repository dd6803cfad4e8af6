#include "takt/publish/output_status.hpp"

namespace takt::publish {

std::string_view name(OutputState state) {
    switch (state) {
        case OutputState::starting: return "starting";
        case OutputState::connecting: return "connecting";
        case OutputState::delivering: return "delivering";
        case OutputState::falls_behind: return "falls_behind";
        case OutputState::waiting: return "waiting";
        case OutputState::stopped: return "stopped";
        case OutputState::ended: return "ended";
        case OutputState::removed: return "removed";
    }
    return "";
}

}  // namespace takt::publish
