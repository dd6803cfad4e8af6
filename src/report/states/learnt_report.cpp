#include "takt/report/states/learnt_report.hpp"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "takt/plan/learning.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kMostRanges = 12;  // of a kind, as text
constexpr std::array kReadFunctions{wire::Function::read_coils, wire::Function::read_discrete_inputs,
                                    wire::Function::read_holding_registers,
                                    wire::Function::read_input_registers};

/// The items of one function of one device.
struct KnownItems {
    std::size_t device = 0;
    wire::Function read{};
    std::vector<model::ItemRange> confirmed;
    std::vector<model::RefusedItems> refused;
    std::vector<model::ItemRange> untried;
    std::uint16_t most_items = 0;

    [[nodiscard]] bool nothing() const {
        return confirmed.empty() && refused.empty() && untried.empty() && most_items == 0;
    }
};

std::vector<KnownItems> known_of(const model::Project& project, std::size_t line) {
    std::vector<KnownItems> all;
    if (!plan::learns(project.lines[line])) return all;
    const auto trials = plan::learning_plan(project, line).trials;
    const auto& devices = project.lines[line].devices;
    for (std::size_t d = 0; d < devices.size(); ++d) {
        if (!plan::learns(devices[d])) continue;
        for (const auto read : kReadFunctions) {
            const auto area = static_cast<std::size_t>(wire::area_of(read));
            const auto& learnt = devices[d].learnt;
            KnownItems known{
                d, read, learnt.confirmed[area], learnt.refused[area], {}, learnt.most_items[area]};
            for (const auto& trial : trials)
                if (trial.device == d && trial.read == read && !trial.refused)
                    for (const auto& gap : trial.gaps) known.untried.push_back(gap.items);
            if (!known.nothing()) all.push_back(std::move(known));
        }
    }
    return all;
}

template <class Ranges>
std::string range_list_text(const Ranges& ranges, auto text) {
    std::string all;
    for (std::size_t i = 0; i < std::min(ranges.size(), kMostRanges); ++i)
        all += (i == 0 ? "" : ", ") + text(ranges[i]);
    return ranges.size() > kMostRanges ? fmt::format("{}, … ({})", all, ranges.size()) : all;
}

std::string known_text(const Texts& texts, const KnownItems& known) {
    std::string text;
    const auto append = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
    if (!known.confirmed.empty())
        append(
            texts("app.learnt.confirmed_items", {{"items", range_list_text(known.confirmed, range_text)}}));
    if (!known.refused.empty())
        append(texts("app.learnt.refused_items",
                     {{"items", range_list_text(known.refused, [&](const auto& refused) {
                           return texts("app.learnt.refused_range",
                                        {{"items", range_text(refused.items)},
                                         {"exception", std::to_string(refused.exception)},
                                         {"age", texts.duration(refused.checked)}});
                       })}}));
    if (!known.untried.empty())
        append(texts("app.learnt.untried_items", {{"items", range_list_text(known.untried, range_text)}}));
    if (known.most_items > 0)
        append(texts("app.learnt.most_items", {{"count", std::to_string(known.most_items)}}));
    return text;
}

std::int64_t whole_seconds_of(Duration age) {
    return std::chrono::floor<std::chrono::seconds>(age).count();
}

file::Json range_objects_json(const std::vector<model::ItemRange>& ranges) {
    auto list = file::Json::array();
    for (const auto& range : ranges) {
        auto entry = file::Json::object();
        entry.set("first", range.first);
        entry.set("last", range.last);
        list.push_back(std::move(entry));
    }
    return list;
}

}  // namespace

std::string learnt_text(const Texts& texts, const model::Project& project, std::size_t line) {
    std::string text;
    for (const auto& known : known_of(project, line))
        text += "  " +
                texts("app.learnt", {{"device", project.lines[line].devices[known.device].name},
                                     {"function", function_text(known.read)},
                                     {"what", known_text(texts, known)}}) +
                '\n';
    return text;
}

file::Json learnt_json(const model::Project& project, std::size_t line) {
    auto list = file::Json::array();
    for (const auto& known : known_of(project, line)) {
        const auto& device = project.lines[line].devices[known.device];
        auto refused = file::Json::array();
        for (const auto& range : known.refused) {
            auto entry = file::Json::object();
            entry.set("first", range.items.first);
            entry.set("last", range.items.last);
            entry.set("exception", range.exception);
            entry.set("since_s", whole_seconds_of(range.since));
            entry.set("checked_s", whole_seconds_of(range.checked));
            refused.push_back(std::move(entry));
        }
        auto object = file::Json::object();
        object.set("device", device.name);
        object.set("unit", device.address.value);
        object.set("function", static_cast<int>(known.read));
        object.set("confirmed", range_objects_json(known.confirmed));
        object.set("refused", std::move(refused));
        object.set("untried", range_objects_json(known.untried));
        object.set("most_items", known.most_items > 0 ? file::Json(known.most_items) : file::Json());
        list.push_back(std::move(object));
    }
    return list;
}

}  // namespace takt::report
