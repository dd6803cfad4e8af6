#include "engine/line_guests.hpp"

#include <utility>

#include "takt/bus/transaction.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::host {
namespace {

using value::CommandResult;
using value::Reason;

Reason reason_of(const bus::Outcome& outcome) {
    switch (outcome.status) {
        case bus::Status::ok: return Reason::ok;
        case bus::Status::exception: return value::exception_reason(outcome.exception);
        case bus::Status::bad_checksum: return Reason::bad_checksum;
        case bus::Status::unexpected_reply: return Reason::unexpected_reply;
        case bus::Status::ambiguous: return Reason::ambiguous;
        case bus::Status::link_lost: return Reason::link_lost;
        case bus::Status::closed: return Reason::closed;
        case bus::Status::timeout:
        case bus::Status::line_busy:
        case bus::Status::cancelled: return Reason::timeout;
    }
    return Reason::timeout;
}

}  // namespace

bool LineGuests::in_slot(std::size_t line) const {
    const auto found = waiting_.find(line);
    return found != waiting_.end() && found->second.submitted;
}

void LineGuests::execute(Instant t, std::unique_ptr<CommandRequest> command) {
    auto& outcome = command->outcome;
    outcome.t = t;
    const auto& exchange = command->command.exchange;
    const auto refuse = [&](const Error& error) {
        outcome.error = error;
        finished_(std::move(command));
    };
    if (!exchange || exchange->line >= master_.line_count())
        return refuse(fail(Code::not_found, "line").error());
    const auto line = exchange->line;
    if (waits(line)) return refuse(fail(Code::queue_full, 1).error());
    if (exchange->pdu.empty() || exchange->pdu.size() > wire::kMaxPdu)
        return refuse(fail(Code::out_of_range, static_cast<std::int64_t>(exchange->pdu.size()), 1,
                           static_cast<std::int64_t>(wire::kMaxPdu))
                          .error());
    if (!master_.line(line).link_up()) return refuse(fail(Code::connection_lost).error());
    master_.line(line).admit_guests();
    const auto [waiting, added] = waiting_.emplace(line, Waiting{std::move(command)});
    submit(t, line, waiting->second);
}

// Not while the slot is a gateway's, nor while the response could be mistaken for a late one.
void LineGuests::submit(Instant t, std::size_t line, Waiting& waiting) {
    auto& poller = master_.line(line);
    const auto& exchange = *waiting.command->command.exchange;
    bus::Transaction transaction{.id = waiting.command->outcome.id,
                                 .unit = exchange.unit,
                                 .request = wire::PreparedRequest(Bytes(exchange.pdu)),
                                 .wait = exchange.wait};
    if (!poller.can_relay() ||
        !poller.may_start_relayed(t, exchange.unit, bus::answer_shape(transaction.request.shape())))
        return;
    waiting.submitted = poller.relay(t, transaction, exchange.spare).has_value();
    if (waiting.submitted) poke_(line);
}

void LineGuests::settle(Instant t) {
    for (auto next = waiting_.begin(); next != waiting_.end();) {
        const auto waiting = next++;
        const auto line = waiting->first;
        auto& [command, submitted] = waiting->second;
        auto& poller = master_.line(line);
        if (submitted) {
            if (const auto result = poller.take_relayed()) {
                const auto pdu = result->response.pdu();
                command->outcome.response.assign(pdu.begin(), pdu.end());
                const bool answered = !pdu.empty();
                end(waiting, result->ended_at, answered ? CommandResult::done : CommandResult::unknown,
                    reason_of(*result));
                continue;
            }
            const auto& expires = command->command.expires;
            if (expires && *expires <= t && poller.withdraw_relayed())
                end(waiting, t, CommandResult::expired, Reason::ok);
            continue;
        }
        if (!poller.link_up())
            end(waiting, t, CommandResult::expired, Reason::link_lost);
        else if (command->command.expires && *command->command.expires <= t)
            end(waiting, t, CommandResult::expired, Reason::ok);
        else
            submit(t, line, waiting->second);
    }
}

void LineGuests::end(std::map<std::size_t, Waiting>::iterator waiting, Instant t, value::CommandResult result,
                     value::Reason reason) {
    auto command = std::move(waiting->second.command);
    waiting_.erase(waiting);
    command->outcome.t = t;
    command->outcome.result = result;
    command->outcome.reason = reason;
    finished_(std::move(command));
}

void LineGuests::finish(Instant t) {
    settle(t);
    while (!waiting_.empty()) {
        const auto waiting = waiting_.begin();
        auto& poller = master_.line(waiting->first);
        const bool unsent = !waiting->second.submitted || poller.withdraw_relayed();
        end(waiting, t, unsent ? CommandResult::expired : CommandResult::unknown, Reason::ok);
    }
}

}  // namespace takt::host
