#include "writes/write_job.hpp"

#include <algorithm>

#include "writes/single_write.hpp"

namespace takt::poll {

const WriteProgress& WriteJob::progress() const {
    return of_group() ? group().progress : command().progress;
}

bool WriteJob::modifies() const {
    return of_group() ? group().kind == WriteKind::modify : command().alone.modifies;
}

wire::Function WriteJob::function() const {
    return of_group() ? group().function : command().alone.function;
}

std::span<const std::size_t> WriteJob::members() const {
    if (of_group()) return group().members;
    return {&command().variable, 1};
}

std::span<const std::size_t> WriteJob::written() const {
    return of_group() ? group().written() : members();
}

bool WriteJob::repeatable(std::span<const std::size_t> variables) const {
    return std::ranges::all_of(variables, [this](auto v) { return owners_.values.model(v).safe_to_repeat; });
}

const ReadBack* WriteJob::read_back() const {
    return of_group() ? group().read_back.get() : command().alone.verify.get();
}

bool* WriteJob::line_token() const {
    if (of_group()) return owners_.groups.line_token(index());
    return command().alone.bucket_of ? nullptr : &command().alone.admitted;
}

// ---- its steps

Result<wire::PreparedRequest> WriteJob::begin() {
    if (of_group()) return owners_.groups.begin(index());
    command().progress.begin(modifies());
    owners_.values.note_sent(command().variable, command().command.value);
    return command().alone.request;
}

Result<wire::PreparedRequest> WriteJob::second_step(Instant t, std::uint16_t old) {
    if (of_group()) return owners_.groups.modify(t, index(), old);
    return wire::prepare(poll::second_step(command().alone, owners_.values.model(command().variable), old));
}

void WriteJob::second_step_submitted() {
    if (of_group())
        owners_.groups.second_step_submitted(index());
    else
        command().progress.write();
}

void WriteJob::transaction_ended() {
    if (of_group())
        owners_.groups.transaction_ended(index());
    else
        command().progress.transaction_ended();
}

void WriteJob::note_attempt(Execution execution) {
    if (of_group()) return owners_.commands.note_attempt(index(), execution);
    command().execution = std::max(command().execution, execution);
}

void WriteJob::await_read_back() {
    if (of_group()) return owners_.groups.await_read_back(index());
    command().progress.verify();
    command().alone.verify->begin(command().order);
}

void WriteJob::read_back_submitted() {
    if (of_group())
        owners_.groups.read_back_submitted(index());
    else
        command().progress.read_back();
}

bool WriteJob::read_back_again(Instant t, const OutcomeClass& outcome_class, std::uint16_t attempts) {
    if (of_group()) return owners_.groups.read_back_again(t, index(), outcome_class, attempts);
    return command().alone.verify->again(t, outcome_class, attempts);
}

void WriteJob::note_differs() {
    if (of_group())
        owners_.commands.note_differs(index());
    else
        command().execution = Execution::possible;
}

// ---- its end

bool WriteJob::retry(Instant t, const OutcomeClass& outcome_class, std::uint16_t attempts) {
    return of_group() ? owners_.groups.retry(t, index(), outcome_class, attempts)
                      : owners_.commands.retry(t, index(), outcome_class, attempts);
}

void WriteJob::requeue(Instant t) {
    if (of_group())
        owners_.groups.requeue(t, index());
    else
        command().progress.end();
}

WriteGroups::Settled WriteJob::finish(Instant t, value::CommandResult result, value::Reason reason) {
    if (of_group()) return owners_.groups.finish(t, index(), result, reason);
    owners_.commands.finish(t, index(), result, reason);
    return {};
}

}  // namespace takt::poll
