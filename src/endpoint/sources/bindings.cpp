#include "takt/endpoint/bindings.hpp"

#include <utility>

#include "takt/value/text.hpp"

namespace takt::endpoint {
namespace {

using wire::ExceptionCode;

constexpr ExceptionCode exception_of(Code code) {
    switch (code) {
        case Code::overflow:
        case Code::out_of_range:
        case Code::unsupported:
        case Code::not_writable: return ExceptionCode::illegal_data_value;
        case Code::queue_full: return ExceptionCode::server_device_busy;
        case Code::connection_lost:
        case Code::closed_by_peer:
        case Code::timed_out: return ExceptionCode::gateway_target_failed_to_respond;
        default: return ExceptionCode::server_device_failure;
    }
}

/// The exception for a failed write: the device's own one, or 0x0B if its answer is missing or unclear.
Refusal refusal_of(const value::CommandOutcome& outcome) {
    using Result = value::CommandResult;
    constexpr std::uint16_t kLastException = 11;
    const auto code = value::status_code(outcome.reason);
    switch (outcome.result) {
        case Result::done: return {};
        case Result::queue_full: return ExceptionCode::server_device_busy;
        case Result::refused:
            if (value::is_exception(outcome.reason) && code <= kLastException)
                return static_cast<ExceptionCode>(code);
            if (outcome.reason == value::Reason::differs) return ExceptionCode::server_device_failure;
            if (outcome.reason == value::Reason::superseded) return ExceptionCode::server_device_busy;
            break;
        case Result::unknown:
        case Result::expired: break;
    }
    return ExceptionCode::gateway_target_failed_to_respond;
}

Refusal refusal_of(WriteResult result) {
    switch (result) {
        case WriteResult::done: return {};
        case WriteResult::refused:
        case WriteResult::differs: return ExceptionCode::server_device_failure;
        case WriteResult::no_answer:
        case WriteResult::expired: break;
    }
    return ExceptionCode::gateway_target_failed_to_respond;
}

}  // namespace

Bindings::Bindings(std::span<const model::ServerUnit> settings, std::span<serve::Unit> units,
                   PutOffAnswer put_off)
    : settings_(settings),
      put_off_(std::move(put_off)),
      check_([this](const Destination& to, const value::Value& value) { return check(to, value); }),
      pass_([this](const Destination& to, const value::Value& value, const Passed& passed) {
          pass_on(to, value, passed);
      }) {
    for (std::size_t i = 0; i < settings.size(); ++i)
        units_.push_back(std::make_unique<BoundUnit>(settings[i], units[i], check_, pass_, put_off_));
}

Bindings::~Bindings() = default;

Result<void> Bindings::connect(Feeds& feeds, ProjectValues& project) {
    return connect_if([](const model::Source&) { return true; }, feeds, project);
}

Result<void> Bindings::reconnect(Feeds& feeds, ProjectValues& project) {
    const auto is_stored = [](const model::Source& source) {
        return std::holds_alternative<model::VariableSource>(source) ||
               std::holds_alternative<model::LocalSource>(source);
    };
    return connect_if(is_stored, feeds, project);
}

template <class Condition>
Result<void> Bindings::connect_if(const Condition& condition, Feeds& feeds, ProjectValues& project) {
    feeds_ = &feeds;
    project_ = &project;
    for (const auto& unit : units_) unit->find_sinks(project.store());
    for (std::size_t i = 0; i < settings_.size(); ++i)
        for (const auto& binding : settings_[i].bindings) {
            const auto& variable = settings_[i].variables[binding.variable];
            if (!binding.source || !variable.used || !condition(*binding.source)) continue;
            TAKT_TRY(auto feed, feeds.feed(variable, *binding.source));
            units_[i]->connect(binding, std::move(feed));
        }
    return {};
}

void Bindings::disconnect() {
    for (std::size_t i = 0; i < settings_.size(); ++i)
        for (const auto& binding : settings_[i].bindings) units_[i]->connect(binding, nullptr);
    feeds_ = nullptr;
    project_ = nullptr;
}

Refusal Bindings::check(const Destination& to, const value::Value& value) const {
    if (project_ == nullptr) return {};  // pass_on() refuses
    if (const auto* const instrument = std::get_if<model::InstrumentSink>(&to.sink)) {
        const auto checked = feeds_->check(instrument->instrument, instrument->command, value);
        return checked ? Refusal{} : Refusal(exception_of(checked.error().code));
    }
    if (!to.slot) return {};
    const auto& info = project_->store().info(*to.slot);
    const auto converted = value::convert(info.type, info.scaled, value);
    return converted ? Refusal{} : Refusal(exception_of(converted.error().code));
}

void Bindings::pass_on(const Destination& to, const value::Value& value, const Passed& passed) {
    if (project_ == nullptr) return passed(ExceptionCode::gateway_target_failed_to_respond);
    if (const auto* const command = std::get_if<model::Command>(&to.sink))
        return pass_to_command(*command, value, passed);
    if (const auto* const instrument = std::get_if<model::InstrumentSink>(&to.sink))
        return pass_to_instrument(*instrument, value, passed);
    const bool local = std::holds_alternative<model::LocalSource>(to.sink);
    if (!to.slot)
        return passed(local ? ExceptionCode::server_device_failure
                            : ExceptionCode::gateway_target_failed_to_respond);
    if (local) return pass_to_local(*to.slot, value, passed);
    pass_to_variable(*to.slot, value, passed);
}

void Bindings::pass_to_variable(value::SlotId slot, const value::Value& value, const Passed& passed) {
    const auto& info = project_->store().info(slot);
    const auto converted = value::convert(info.type, info.scaled, value);
    if (!converted) return passed(exception_of(converted.error().code));
    const auto accepted = project_->write(
        slot, *converted, [passed](const value::CommandOutcome& outcome) { passed(refusal_of(outcome)); });
    if (!accepted) passed(exception_of(accepted.error().code));
}

void Bindings::pass_to_local(value::SlotId slot, const value::Value& value, const Passed& passed) {
    const auto& info = project_->store().info(slot);
    const auto converted = value::convert(info.type, info.scaled, value);
    const auto done =
        converted ? project_->set(slot, *converted) : Result<bool>(std::unexpected(converted.error()));
    passed(done ? Refusal{} : Refusal(exception_of(done.error().code)));
}

void Bindings::pass_to_instrument(const model::InstrumentSink& sink, const value::Value& value,
                                  const Passed& passed) {
    const auto accepted = feeds_->write(sink.instrument, sink.command, value,
                                        [passed](WriteResult result) { passed(refusal_of(result)); });
    if (!accepted) passed(exception_of(accepted.error().code));
}

void Bindings::pass_to_command(const model::Command& command, const value::Value& value,
                               const Passed& passed) {
    const auto type = std::holds_alternative<bool>(value)            ? DataType::boolean
                      : std::holds_alternative<std::int64_t>(value)  ? DataType::int64
                      : std::holds_alternative<std::uint64_t>(value) ? DataType::uint64
                      : std::holds_alternative<double>(value)        ? DataType::float64
                                                                     : DataType::string;
    const bool accepted =
        feeds_->run(command, value::format(type, false, value), [passed](const std::optional<Error>& error) {
            passed(error ? Refusal(exception_of(error->code)) : Refusal{});
        });
    if (!accepted) passed(ExceptionCode::server_device_busy);
}

}  // namespace takt::endpoint
