#include "takt/app/reporter.hpp"

#include <fmt/format.h>

#include "takt/report/formatting.hpp"
#include "takt/value/text.hpp"

namespace takt::app {
namespace {

const model::Device* device_of(const Scene& scene, value::SlotId slot) {
    const auto owner = scene.master.slots().owner(slot);
    const auto* variable = std::get_if<poll::VariableIndex>(&owner);
    return variable ? &scene.project.lines[variable->line].devices[variable->device] : nullptr;
}

}  // namespace

std::string shown_value(const Scene& scene, value::SlotId slot, const value::Value& value) {
    const auto& info = scene.master.store().info(slot);
    std::string text = value::is_empty(value) ? "–" : value::format(info.type, info.scaled, value);
    const auto owner = scene.master.slots().owner(slot);
    if (const auto* index = std::get_if<poll::VariableIndex>(&owner)) {
        const auto& unit =
            scene.project.lines[index->line].devices[index->device].variables[index->variable].unit;
        if (!unit.empty()) text += ' ' + unit;
    }
    return text;
}

std::string device_name(const Scene& scene, value::SlotId slot) {
    const auto* device = device_of(scene, slot);
    return device ? device->name : std::string();
}

std::string line_name(const Scene& scene, value::SlotId slot) {
    const auto owner = scene.master.slots().owner(slot);
    const auto* variable = std::get_if<poll::VariableIndex>(&owner);
    return variable ? scene.project.lines[variable->line].name : std::string();
}

std::string reason_text(value::Reason reason) {
    if (reason == value::Reason::ok) return {};
    if (!value::is_exception(reason)) return std::string(value::name(reason));
    const auto code = value::status_code(reason);
    return fmt::format("exception {}", code >= 256 ? code - 256 : code);
}

std::string overrun_text(const Scene& scene, const Texts& texts, std::size_t line,
                         const plan::Request& planned, const Overrun& overrun) {
    return texts(overrun.overrun ? "app.overrun" : "app.overrun_over",
                 {{"device", scene.project.lines[line].devices[planned.device].name},
                  {"request", report::request_text(planned)},
                  {"period", report::milliseconds_text(overrun.period)},
                  {"real", report::milliseconds_text(overrun.real)}});
}

std::string write_waiting_text(const Scene& scene, const Texts& texts, std::size_t line,
                               const plan::Request& planned, std::size_t variable) {
    const auto& device = scene.project.lines[line].devices[planned.device];
    return texts("app.write_waiting", {{"device", device.name},
                                       {"request", report::request_text(planned)},
                                       {"name", device.variables[variable].name}});
}

std::string verify_failed_text(const Scene& scene, const Texts& texts, value::SlotId slot,
                               const value::Value& written, const value::Value& read) {
    return texts("app.verify_failed", {{"device", device_name(scene, slot)},
                                       {"name", scene.master.store().info(slot).name},
                                       {"written", shown_value(scene, slot, written)},
                                       {"read", shown_value(scene, slot, read)}});
}

std::string unwritten_text(const Scene& scene, const Texts& texts, const Unwritten& what) {
    const auto code = value::status_code(what.reason);
    const std::string why = what.reason == value::Reason::ok
                                ? std::string()
                                : " (" +
                                      texts("app.reason." + std::string(value::name(what.reason)),
                                            {{"code", std::to_string(code >= 256 ? code - 256 : code)}}) +
                                      ")";
    return texts("app.write." + std::string(value::name(what.result)),
                 {{"device", device_name(scene, what.slot)},
                  {"name", scene.master.store().info(what.slot).name},
                  {"wanted", what.wanted},
                  {"why", why}});
}

std::string link_text(const Scene& scene, const Texts& texts, std::size_t line, bool up,
                      const std::optional<Error>& why) {
    return texts(up ? "app.link_up" : "app.link_down", {{"line", scene.project.lines[line].name},
                                                        {"why", why ? texts.describe(*why) : std::string()}});
}

}  // namespace takt::app
