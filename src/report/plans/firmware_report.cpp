#include "takt/report/plans/firmware_report.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "takt/report/drawing/text_table.hpp"

// A report has one row for each check of the estimate: the value that the hardware gives, its greatest
// deviation, and the allowed one. Text and JSON have the same rows.
namespace takt::report {
namespace {

using plan::Deviation;
using plan::FirmwareEstimate;

constexpr double kPercent = 100;
constexpr double kMicro = 1e6;

std::string share_text(double share) {
    return fmt::format("{:.2f} %", share * kPercent);
}

Duration of_seconds(double seconds) {
    return Duration(std::llround(seconds * 1e9));
}

std::string rows_text(const Texts& texts, const FirmwareEstimate& estimate) {
    using enum TextTable::Align;
    TextTable table({whole, whole, right, right, whole});
    table.add({"", "", texts("app.firmware.at_most"), texts("app.firmware.allowed"), ""});
    const auto add = [&](const char* subject, std::string value, std::string at_most, std::string allowed,
                         bool holds) {
        table.add({texts(subject), std::move(value), std::move(at_most), std::move(allowed),
                   texts(holds ? "app.firmware.holds" : "app.firmware.fails")});
    };
    const auto add_times = [&](const char* subject, std::string value, const Deviation& deviation) {
        add(subject, std::move(value), texts.duration(of_seconds(deviation.greatest)),
            texts.duration(of_seconds(deviation.allowed)), deviation.holds());
    };
    const auto ticks = [&](const plan::MeasuredSilence& silence) {
        return texts("app.firmware.ticks",
                     {{"time", texts.duration(silence.time)}, {"ticks", std::to_string(silence.ticks)}});
    };
    add("app.firmware.rate",
        texts("app.firmware.divided", {{"rate", fmt::format("{:.1f}", estimate.bit_rate)},
                                       {"divider", fmt::format("{:.5g}", estimate.divider)}}),
        share_text(estimate.rate.greatest), share_text(estimate.rate.allowed), estimate.rate.holds());
    add_times("app.firmware.t1_5", ticks(estimate.t1_5), estimate.t1_5.deviation);
    add_times("app.firmware.t3_5", ticks(estimate.t3_5), estimate.t3_5.deviation);
    add("app.firmware.timer", {}, std::to_string(estimate.t3_5.ticks), std::to_string(estimate.most_ticks),
        estimate.timer_holds());
    add_times("app.firmware.character", {}, estimate.character);
    add_times("app.firmware.line", {}, estimate.line);
    return table.render("  ");
}

file::Json json_of(const Deviation& deviation, std::string_view unit, double scale) {
    auto object = file::Json::object();
    object.set(fmt::format("at_most_{}", unit), deviation.greatest * scale);
    object.set(fmt::format("allowed_{}", unit), deviation.allowed * scale);
    object.set("holds", deviation.holds());
    return object;
}

file::Json json_of(const plan::MeasuredSilence& silence) {
    auto object = json_of(silence.deviation, "us", kMicro);
    object.set("time_us", std::chrono::duration<double, std::micro>(silence.time).count());
    object.set("ticks", silence.ticks);
    return object;
}

file::Json json_of(const plan::ExchangeCost& cost) {
    auto object = file::Json::object();
    object.set("wakeups", cost.interrupts);
    object.set("instructions", cost.instructions);
    return object;
}

}  // namespace

std::string firmware_text(const Texts& texts, const model::Firmware& firmware,
                          const FirmwareEstimate& estimate) {
    const auto microamperes = [](double value) { return fmt::format("{:.2f}", value); };
    std::string text = texts("app.firmware", {{"baud", std::to_string(firmware.format.baud)},
                                              {"bits", std::to_string(firmware.format.bits())}}) +
                       '\n' + rows_text(texts, estimate);
    text += texts("app.firmware.exchanges", {{"registers", std::to_string(firmware.registers)},
                                             {"own_wakeups", std::to_string(estimate.own.interrupts)},
                                             {"own", std::to_string(estimate.own.instructions)},
                                             {"foreign_wakeups", std::to_string(estimate.foreign.interrupts)},
                                             {"foreign", std::to_string(estimate.foreign.instructions)}}) +
            '\n';
    text += texts("app.firmware.load", {{"wakeups", fmt::format("{:.1f}", estimate.wakeups)},
                                        {"active", share_text(estimate.active)},
                                        {"sending", share_text(estimate.sending)}}) +
            '\n';
    text += texts("app.firmware.current", {{"current", microamperes(estimate.current_ua())},
                                           {"asleep", microamperes(estimate.asleep_ua)},
                                           {"active", microamperes(estimate.active_ua)},
                                           {"uart", microamperes(estimate.uart_ua)},
                                           {"transceiver", microamperes(estimate.transceiver_ua)}}) +
            '\n';
    if (estimate.battery_days)
        text += texts("app.firmware.battery", {{"days", fmt::format("{:.0f}", *estimate.battery_days)},
                                               {"capacity", std::to_string(*firmware.battery_mah)}}) +
                '\n';
    return text +
           texts("app.firmware.assumptions", {{"entry", std::to_string(plan::kInterruptCycles)},
                                              {"cycles", std::to_string(firmware.cycles_per_instruction)}}) +
           '\n';
}

file::Json firmware_json(const FirmwareEstimate& estimate) {
    auto rate = json_of(estimate.rate, "percent", kPercent);
    rate.set("value", estimate.bit_rate);
    rate.set("divider", estimate.divider);
    rate.set("divider_error_percent", estimate.divider_error * kPercent);
    auto timer = file::Json::object();
    timer.set("ticks", estimate.t3_5.ticks);
    timer.set("allowed_ticks", estimate.most_ticks);
    timer.set("holds", estimate.timer_holds());
    auto current = file::Json::object();
    current.set("total", estimate.current_ua());
    current.set("asleep", estimate.asleep_ua);
    current.set("active", estimate.active_ua);
    current.set("uart", estimate.uart_ua);
    current.set("transceiver", estimate.transceiver_ua);
    auto object = file::Json::object();
    object.set("holds", estimate.holds());
    object.set("bit_rate", std::move(rate));
    object.set("t1_5", json_of(estimate.t1_5));
    object.set("t3_5", json_of(estimate.t3_5));
    object.set("timer", std::move(timer));
    object.set("character", json_of(estimate.character, "us", kMicro));
    object.set("line", json_of(estimate.line, "us", kMicro));
    object.set("own", json_of(estimate.own));
    object.set("foreign", json_of(estimate.foreign));
    object.set("wakeups_per_second", estimate.wakeups);
    object.set("active", estimate.active);
    object.set("sending", estimate.sending);
    object.set("current_ua", std::move(current));
    object.set("battery_days", estimate.battery_days ? file::Json(*estimate.battery_days) : file::Json());
    return object;
}

}  // namespace takt::report
