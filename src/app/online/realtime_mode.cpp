#include "online/realtime_mode.hpp"

#include <string>
#include <system_error>

#include "output.hpp"
#include "takt/file/json.hpp"
#include "takt/model/scalar.hpp"

namespace takt::app {
namespace {

std::string system_text(int error) {
    return std::system_category().message(error);
}

std::string step_text(const Texts& texts, const RealtimeMode& mode, const os::RealtimeResult& result) {
    const auto code = "app.realtime." + std::string(os::name(result.step));
    const auto what = texts(
        code, {{"priority", std::to_string(mode.priority)}, {"cpu", std::to_string(mode.cpu.value_or(0))}});
    if (result.error == 0) return texts("app.realtime.done", {{"step", what}});
    return texts("app.realtime.failed", {{"step", what}, {"error", system_text(result.error)}}) + "\n    " +
           texts(code + ".advice");
}

std::string spin_text(const Texts& texts, const RealtimeMode& mode) {
    const auto what = texts("app.realtime.spin", {{"time", model::to_text(mode.spin)}});
    return texts("app.realtime.done", {{"step", what}});
}

std::string json_text(const RealtimeMode& mode, const std::vector<os::RealtimeResult>& results) {
    auto steps = file::Json::array();
    for (const auto& result : results) {
        auto step = file::Json::object();
        step.set("step", std::string(os::name(result.step)));
        step.set("done", result.error == 0);
        if (result.error != 0) step.set("error", system_text(result.error));
        steps.push_back(std::move(step));
    }
    if (mode.spin > Duration::zero()) {
        auto step = file::Json::object();
        step.set("step", "spin");
        step.set("done", true);
        steps.push_back(std::move(step));
    }
    auto event = file::Json::object();
    event.set("event", "realtime");
    event.set("steps", std::move(steps));
    return event.dump();
}

}  // namespace

std::vector<os::RealtimeResult> begin_realtime(const RealtimeMode& mode, line::Loop& loop) {
    loop.set_spin(mode.spin);
    os::RealtimeOptions options;
    if (mode.priority > 0) options.priority = mode.priority;
    if (mode.cpu) options.cpu = static_cast<int>(*mode.cpu);
    return os::become_realtime(options);
}

void print_realtime(const Texts& texts, const RealtimeMode& mode,
                    const std::vector<os::RealtimeResult>& results, bool json) {
    const bool spins = mode.spin > Duration::zero();
    if (results.empty() && !spins) return;
    print_status(texts("app.realtime.mode") + '\n');
    for (const auto& result : results) print_status("  " + step_text(texts, mode, result) + '\n');
    if (spins) print_status("  " + spin_text(texts, mode) + '\n');
    if (json) print(json_text(mode, results) + '\n');
}

}  // namespace takt::app
