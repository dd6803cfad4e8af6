#include "takt/report/times/response_times_report.hpp"

#include "takt/bus/outstanding_responses.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report {
namespace {

bool is_enough(const model::MeasuredTimes& measured) {
    return measured.exchanges >= model::MeasuredTimes::kEnough;
}

/// Some responses came after their time-out. A turnaround that is long enough for them is no turnaround.
bool has_late(const model::MeasuredTimes& measured) {
    return measured.lateness > measured.longest;
}

/// "8ms"; empty if the project writes or learns the turnaround, too little was measured, or responses are
/// late.
std::string advised_turnaround(const model::Device& device, const model::MeasuredTimes& measured) {
    if (device.turnaround || device.learn_turnaround || !is_enough(measured) || has_late(measured)) return {};
    const auto advised = bus::advised_timeout(measured.longest);
    return std::to_string(std::chrono::ceil<std::chrono::milliseconds>(advised).count()) + "ms";
}

void add_learnt_times(file::Json& list, const model::Line& line, bool with_line) {
    for (const auto& device : line.devices) {
        const auto& measured = device.times.measured;
        if (measured.exchanges == 0 && measured.late == 0) continue;
        auto object = file::Json::object();
        if (with_line) object.set("line", line.name);
        object.set("device", device.name);
        object.set("unit", device.address.value);
        object.set("turnaround", turnaround_json(device, measured));
        object.set("late_responses", late_responses_json(measured));
        list.push_back(std::move(object));
    }
}

}  // namespace

file::Json turnaround_json(const model::Device& device, const model::MeasuredTimes& measured) {
    if (measured.exchanges == 0) return {};
    auto object = file::Json::object();
    object.set("exchanges", measured.exchanges);
    object.set("longest_ms", milliseconds(measured.longest));
    object.set("p999_ms", measured.has_p999() ? file::Json(milliseconds(measured.p999)) : file::Json());
    object.set("learnt", device.learn_turnaround);
    const auto advised = advised_turnaround(device, measured);
    object.set("advised", advised.empty() ? file::Json() : file::Json(advised));
    return object;
}

file::Json late_responses_json(const model::MeasuredTimes& measured) {
    if (measured.late == 0) return {};
    auto object = file::Json::object();
    object.set("count", measured.late);
    object.set("requests", measured.attempts);
    object.set("longest_ms", milliseconds(measured.lateness));
    return object;
}

std::string turnaround_text(const Texts& texts, const model::Device& device,
                            const model::MeasuredTimes& measured) {
    if (device.turnaround || measured.exchanges == 0) return {};
    const char* const code = !is_enough(measured)      ? "app.turnaround.few"
                             : has_late(measured)      ? "app.turnaround.late"
                             : device.learn_turnaround ? "app.turnaround.learnt"
                                                       : "app.turnaround.measured";
    const std::string p999 =
        measured.has_p999() ? texts("app.turnaround.p999", {{"p999", texts.duration(measured.p999)}}) : "";
    return texts(code, {{"device", device.name},
                        {"longest", texts.duration(measured.longest)},
                        {"p999", p999},
                        {"count", std::to_string(measured.exchanges)},
                        {"advised", advised_turnaround(device, measured)}});
}

std::string late_responses_text(const Texts& texts, const model::Device& device,
                                const model::MeasuredTimes& measured) {
    if (measured.late == 0) return {};
    return texts("app.late_responses", {{"device", device.name},
                                        {"late", std::to_string(measured.late)},
                                        {"attempts", std::to_string(measured.attempts)},
                                        {"lateness", texts.duration(measured.lateness)}});
}

std::string response_times_text(const Texts& texts, const model::Device& device,
                                const model::MeasuredTimes& measured) {
    std::string text;
    for (const auto& line :
         {turnaround_text(texts, device, measured), late_responses_text(texts, device, measured)})
        if (!line.empty()) text += "  " + line + '\n';
    return text;
}

std::string learnt_times_text(const Texts& texts, const model::Line& line) {
    std::string text;
    for (const auto& device : line.devices) text += response_times_text(texts, device, device.times.measured);
    return text;
}

file::Json learnt_times_json(const model::Line& line) {
    auto list = file::Json::array();
    add_learnt_times(list, line, false);
    return list;
}

file::Json learnt_times_json(const model::Project& project) {
    auto list = file::Json::array();
    for (const auto& line : project.lines) add_learnt_times(list, line, true);
    return list;
}

}  // namespace takt::report
