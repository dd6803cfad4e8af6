#include "takt/source/bound_server.hpp"

#include <utility>

#include "takt/value/text.hpp"

namespace takt::source {
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
        case Code::timed_out: return ExceptionCode::gateway_target_failed_to_respond;
        default: return ExceptionCode::server_device_failure;
    }
}

/// What a device said stands for itself; what it did not say, or not clearly, is "no answer".
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

}  // namespace

/// A request that writes, until everything it passed on is done.
struct BoundServer::Write {
    std::size_t left = 0;
    Refusal refusal;
    std::optional<serve::Token> token;  // its answer is pending
    wire::Pdu pdu;                      // of the answer, when all is well
    std::uint8_t function = 0;
};

BoundServer::BoundServer(serve::Responder& inner, const model::Server& settings, std::span<serve::Unit> units,
                         serve::AnswerSink& answers, serve::Tokens& tokens)
    : inner_(inner),
      settings_(settings),
      answers_(answers),
      tokens_(tokens),
      pass_([this](const model::Sink& sink, const value::Value& value, const Passed& passed) {
          pass_on(sink, value, passed);
      }),
      alive_(std::make_shared<BoundServer*>(this)) {
    for (std::size_t i = 0; i < settings.units.size(); ++i) {
        units_.push_back(std::make_unique<BoundUnit>(settings.units[i], units[i], pass_));
        units_.back()->set_begin([this] { return begin(); });
    }
}

BoundServer::~BoundServer() = default;

Result<void> BoundServer::connect(Feeds& feeds, ProjectValues& project) {
    feeds_ = &feeds;
    project_ = &project;
    for (std::size_t i = 0; i < settings_.units.size(); ++i)
        for (const auto& binding : settings_.units[i].bindings) {
            const auto& variable = settings_.units[i].variables[binding.variable];
            if (!binding.source || !variable.used) continue;
            TAKT_TRY(auto feed, feeds.feed(variable, *binding.source));
            units_[i]->connect(binding, std::move(feed));
        }
    return {};
}

void BoundServer::disconnect() {
    for (std::size_t i = 0; i < settings_.units.size(); ++i)
        for (const auto& binding : settings_.units[i].bindings) units_[i]->connect(binding, nullptr);
    feeds_ = nullptr;
    project_ = nullptr;
}

serve::Answer BoundServer::handle(const serve::Context& context, Bytes pdu) {
    using Kind = serve::Answer::Kind;
    current_ = nullptr;
    auto answer = inner_.handle(context, pdu);
    const auto write = std::exchange(current_, nullptr);
    if (!write || answer.kind == Kind::silence) return answer;
    write->function = pdu[0];
    if (answer.kind == Kind::pending) {
        ++write->left;
        write->token = answer.token;
        unanswered_.emplace(answer.token, write);
        return answer;
    }
    if (write->left > 0) {
        write->pdu = answer.pdu;
        write->token = tokens_.next();
        return serve::Answer::pending(*write->token);
    }
    if (write->refusal) answer.pdu = serve::exception_to(write->function, *write->refusal);
    return answer;
}

bool BoundServer::complete(serve::Token token, Bytes pdu) {
    const auto found = unanswered_.extract(token);
    if (found.empty()) return answers_.complete(token, pdu);
    found.mapped()->pdu.assign(pdu);
    settle(*found.mapped());
    return true;
}

/// One more value of the request at hand is passed on.
Passed BoundServer::begin() {
    if (!current_) current_ = std::make_shared<Write>();
    ++current_->left;
    return [write = current_, alive = std::weak_ptr(alive_)](const Refusal& refusal) {
        if (!write->refusal) write->refusal = refusal;
        if (const auto server = alive.lock()) (*server)->settle(*write);
    };
}

/// One of the things that a write waits for is done.
void BoundServer::settle(Write& write) {
    if (--write.left > 0 || !write.token) return;
    const auto pdu = write.refusal ? serve::exception_to(write.function, *write.refusal) : write.pdu;
    (void)answers_.complete(*write.token, pdu.span());
}

void BoundServer::pass_on(const model::Sink& sink, const value::Value& value, const Passed& passed) {
    if (project_ == nullptr) return passed(ExceptionCode::gateway_target_failed_to_respond);
    if (const auto* const variable = std::get_if<model::VariableSource>(&sink))
        return pass_to_variable(variable->name, value, passed);
    if (const auto* const local = std::get_if<model::LocalSource>(&sink))
        return pass_to_local(local->name, value, passed);
    pass_to_command(std::get<model::Command>(sink), value, passed);
}

void BoundServer::pass_to_variable(const std::string& name, const value::Value& value, const Passed& passed) {
    const auto& store = project_->store();
    const auto slot = store.find(name);
    if (!slot) return passed(ExceptionCode::gateway_target_failed_to_respond);
    const auto& info = store.info(*slot);
    const auto converted = value::convert(info.type, info.scaled, value);
    if (!converted) return passed(exception_of(converted.error().code));
    const auto accepted = project_->write(
        *slot, *converted, [passed](const value::CommandOutcome& outcome) { passed(refusal_of(outcome)); });
    if (!accepted) passed(exception_of(accepted.error().code));
}

void BoundServer::pass_to_local(const std::string& name, const value::Value& value, const Passed& passed) {
    const auto& store = project_->store();
    const auto slot = store.find(name);
    if (!slot) return passed(ExceptionCode::server_device_failure);
    const auto& info = store.info(*slot);
    const auto converted = value::convert(info.type, info.scaled, value);
    const auto done =
        converted ? project_->set(*slot, *converted) : Result<bool>(std::unexpected(converted.error()));
    passed(done ? Refusal{} : Refusal(exception_of(done.error().code)));
}

void BoundServer::pass_to_command(const model::Command& command, const value::Value& value,
                                  const Passed& passed) {
    const auto type = std::holds_alternative<bool>(value)            ? DataType::boolean
                      : std::holds_alternative<std::int64_t>(value)  ? DataType::int64
                      : std::holds_alternative<std::uint64_t>(value) ? DataType::uint64
                      : std::holds_alternative<double>(value)        ? DataType::float64
                                                                     : DataType::string;
    const bool room =
        feeds_->run(command, value::format(type, false, value), [passed](const std::optional<Error>& error) {
            passed(error ? Refusal(exception_of(error->code)) : Refusal{});
        });
    if (!room) passed(ExceptionCode::server_device_busy);
}

}  // namespace takt::source
