#include "takt/report/plans/outlook_report.hpp"

#include "takt/plan/shares.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report {
namespace {

/// The oldest value so far.
struct Oldest {
    bool proved = true;  // no polled value is without a bound
    std::optional<Duration> age;
    std::string name;

    void add(const model::Device& device, const plan::Request& request,
             const std::vector<std::optional<Duration>>& ages) {
        for (const std::size_t v : request.variables) {
            if (!ages[v]) proved = false;
            if (!ages[v] || (age && *ages[v] <= *age)) continue;
            age = ages[v];
            name = device.variables[v].name;
        }
    }
};

bool is_periodic(const plan::Request& request) {
    return request.read && request.period > Duration::zero();
}

}  // namespace

Outlook outlook(const model::Project& project, const plan::Proof& proof) {
    Outlook made;
    Oldest oldest;
    for (std::size_t i = 0; i < proof.plan.lines.size(); ++i) {
        const plan::LinePlan& planned = proof.plan.lines[i];
        if (planned.requests.empty()) continue;
        ++made.lines;
        made.requests += planned.request_count;
        if (made.lines == 1 || planned.cycle > made.cycle) {
            made.cycle = planned.cycle;
            made.slowest = planned.line;
        }
        if (const double load = plan::busy(planned); made.lines == 1 || load > made.utilization) {
            made.utilization = load;
            made.busiest = planned.line;
        }
        const auto& devices = project.lines[planned.line].devices;
        for (const plan::Request& request : planned.requests)
            if (is_periodic(request))
                oldest.add(devices[request.device], request, proof.lines[i].ages[request.device]);
    }
    if (!oldest.proved) return made;
    made.oldest = oldest.age;
    made.oldest_name = std::move(oldest.name);
    return made;
}

std::string outlook_text(const Texts& texts, const model::Project& project, const Outlook& outlook) {
    if (outlook.lines == 0) return {};
    const auto of_line = [&](const std::string& figure, std::size_t line) {
        return outlook.lines == 1 ? figure : figure + " (" + project.lines[line].name + ")";
    };
    const auto oldest = outlook.oldest ? texts.bound(*outlook.oldest) + " (" + outlook.oldest_name + ")"
                                       : texts("app.outlook.not_proved");
    return texts("app.outlook", {{"requests", std::to_string(outlook.requests)},
                                 {"cycle", of_line(texts.duration(outlook.cycle), outlook.slowest)},
                                 {"utilization", of_line(percent_text(outlook.utilization), outlook.busiest)},
                                 {"oldest", oldest}}) +
           '\n';
}

file::Json outlook_json(const Outlook& outlook) {
    const auto microseconds = [](Duration time) {
        return std::chrono::ceil<std::chrono::microseconds>(time).count();
    };
    auto object = file::Json::object();
    object.set("lines", outlook.lines);
    object.set("requests", outlook.requests);
    object.set("cycle_us", microseconds(outlook.cycle));
    object.set("utilization", outlook.utilization);
    object.set("oldest_us", outlook.oldest ? file::Json(microseconds(*outlook.oldest)) : file::Json());
    object.set("oldest", outlook.oldest_name);
    return object;
}

}  // namespace takt::report
