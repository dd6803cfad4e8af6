#include "trace.hpp"

#include <cstdio>
#include <string>

#include "judge/values.hpp"

namespace takt::simtest {
namespace {

double ms(Instant t) {
    return static_cast<double>(t.time_since_epoch().count()) / 1e6;
}

unsigned long long printable(std::uint64_t id) {
    return id;
}

}  // namespace

void Trace::action(Instant t, const Action& action, std::string_view slot, std::uint64_t command) const {
    if (!on_) return;
    const bool is_command = action.kind == Action::Kind::command;
    std::fprintf(stderr, "%12.3f ms  user %s %s = %s", ms(t), is_command ? "writes" : "sets",
                 std::string(slot).c_str(), judge::text(action.value).c_str());
    if (is_command) std::fprintf(stderr, ", command %llu", printable(command));
    if (is_command && action.expires < kNever)
        std::fprintf(stderr, ", expires at %.3f ms", ms(action.expires));
    std::fputc('\n', stderr);
}

void Trace::outcome(Instant t, std::size_t line, const value::CommandOutcome& outcome) const {
    if (!on_) return;
    std::fprintf(stderr, "%12.3f ms  line %zu  command %llu: %s\n", ms(t), line, printable(outcome.id),
                 std::string(name(outcome.result)).c_str());
}

void Trace::frame(Instant t, std::size_t line, bool sent, Bytes bytes) const {
    if (!on_) return;
    std::fprintf(stderr, "%12.3f ms  line %zu  %s ", ms(t), line, sent ? "Tx" : "Rx");
    for (const auto byte : bytes) std::fprintf(stderr, " %02X", byte);
    std::fputc('\n', stderr);
}

void Trace::sending(Instant t, std::size_t line, const poll::Sending& sending) const {
    if (!on_) return;
    std::fprintf(stderr, "%12.3f ms  line %zu  %s", ms(t), line, std::string(name(sending.purpose)).c_str());
    if (sending.early) std::fprintf(stderr, " (early)");
    if (sending.request) std::fprintf(stderr, ", request %zu", *sending.request);
    if (sending.command) std::fprintf(stderr, ", command %llu", printable(*sending.command));
    std::fputc('\n', stderr);
}

void Trace::link(Instant t, std::size_t line, std::string_view state) const {
    if (!on_) return;
    std::fprintf(stderr, "%12.3f ms  line %zu  link %s\n", ms(t), line, std::string(state).c_str());
}

void Trace::fault(std::size_t line, const sim::FaultEvent& event) const {
    if (!on_) return;
    std::fprintf(stderr, "%12.3f ms  line %zu  fault %s", ms(event.time), line,
                 std::string(name(event.kind)).c_str());
    if (event.device) std::fprintf(stderr, " of device %zu", *event.device);
    if (event.until) std::fprintf(stderr, " until %.3f ms", ms(*event.until));
    std::fputc('\n', stderr);
}

}  // namespace takt::simtest
