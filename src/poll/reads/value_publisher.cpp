#include "reads/value_publisher.hpp"

#include <algorithm>

#include "line/transfer.hpp"
#include "takt/value/codec.hpp"

namespace takt::poll {

using value::Quality;
using value::Reason;

// ---- values that are longer than a request

void ValuePublisher::set_requests() {
    splits_.clear();
    for (std::size_t r = 0; r < tables_.requests.size(); ++r)
        if (tables_.requests[r].read) add_parts(r);
}

void ValuePublisher::add_parts(std::size_t index) {
    const auto& run = tables_.requests[index];
    const auto& read = run.read->request;
    const std::uint32_t start = read.start().value;
    const std::uint32_t end = start + read.quantity();
    if (wire::counts_bits(read.function())) return;
    for (const auto v : run.variables) {
        const auto& model = *variable(v).model;
        const std::uint32_t first = model.start();
        const std::uint32_t last = first + model.items();
        const bool whole = first >= start && last <= end;
        if (whole || first >= end || last <= start) continue;
        const std::uint32_t from = std::max(first, start);
        splits_.add_part(v, model.items(), index, from - first, std::min(last, end) - from);
    }
}

void ValuePublisher::forget_parts(std::span<const std::size_t> variables) {
    for (const auto v : variables) splits_.forget(v);
}

// ---- responses

void ValuePublisher::take(const bus::Outcome& outcome, std::size_t request, const wire::RequestShape& sent,
                          const ReadRound& round, Quality quality) {
    begin(outcome.sent_at, quality);
    round_ = round;
    for (const auto v : tables_.requests[request].variables) take_value(request, sent, outcome.response, v);
    publish(outcome.ended_at);
}

// Of 0x17 only variables in the range that it reads. A read that is shorter than the planned one has no
// parts.
void ValuePublisher::take_value(std::size_t request, const wire::RequestShape& sent,
                                const wire::ResponseView& response, std::size_t v) {
    const auto& model = *variable(v).model;
    const std::uint32_t first = model.start();
    const std::uint32_t start = sent.start.value;
    const bool inside = first >= start && first + model.items() <= start + sent.quantity;
    if (model.read != wire::Function{sent.function} || (!inside && !splits_.has(v))) return;
    if (inside)
        note_value(v, value_in(response, sent.start, model), sampled_at_);
    else if (sent.quantity >= tables_.requests[request].read->request.quantity())
        take_part(request, sent.start, response, v);
}

void ValuePublisher::take_part(std::size_t request, DataAddress start, const wire::ResponseView& response,
                               std::size_t v) {
    const auto& model = *variable(v).model;
    auto& split = *splits_.find(v);
    if (quality_ != Quality::good) return split.forget();
    const auto* part = split.part_of(request);
    if (!part) return;
    const auto first = static_cast<std::uint16_t>(model.start() + part->first);
    const auto registers = registers_in(response, start, first, part->count);
    if (!registers) return note_value(v, std::unexpected(registers.error()), sampled_at_);
    split.take(request, reads_.number_of(round_, request, model.period), registers->span(), sampled_at_);
    const auto whole = split.whole();
    if (!whole) return;
    note_value(v, value::decode(value::layout_of(model), *whole), split.sampled_at());
    split.forget();
}

void ValuePublisher::note_value(std::size_t v, const Result<value::Value>& value, Instant sampled_at) {
    if (quality_ != Quality::good) {
        updates_.push_back({.slot = variable(v).slot,
                            .value = value ? std::optional(*value) : std::nullopt,
                            .quality = quality_,
                            .reason = Reason::ambiguous});
    } else if (value) {
        written_.note_read(v, *value);
        updates_.push_back({.slot = variable(v).slot, .value = *value, .sampled_at = sampled_at});
    } else {
        updates_.push_back({variable(v).slot, std::nullopt, Quality::bad, Reason::unexpected_reply});
    }
}

// ---- writes

// The values read back are published like those of any other read.
void ValuePublisher::read_back(std::size_t v, wire::Function function, const Result<value::Value>& value) {
    const auto& model = *variable(v).model;
    if (!model.read)
        updates_.push_back({.slot = variable(v).slot,
                            .value = value ? std::optional(*value) : std::nullopt,
                            .quality = quality_,
                            .reason = quality_ == Quality::good ? Reason::ok : Reason::ambiguous,
                            .sampled_at = sampled_at_});
    else if (model.read == function && !splits_.has(v))
        note_value(v, value, sampled_at_);
}

void ValuePublisher::show_written(Instant t, std::span<const std::size_t> variables) {
    begin(t);
    for (const auto v : variables)
        if (!variable(v).model->read) updates_.push_back({variable(v).slot, written_.sent(v)});
    publish(t);
}

// ---- values that were not read

void ValuePublisher::degrade(Instant t, std::span<const std::size_t> variables, Quality quality,
                             Reason reason, Shown shown) {
    begin(t);
    for (const auto v : variables) {
        const auto& model = *variable(v).model;
        const auto& slot = store_[variable(v).slot];
        if (!model.read || !model.used) continue;
        value::Update update{variable(v).slot, std::nullopt, quality, reason};
        if (quality == Quality::uncertain && slot.quality != Quality::good) update.quality = slot.quality;
        if (const auto& initial = store_.info(variable(v).slot).initial;
            shown == Shown::initial && !model.hold_last && !value::is_empty(initial))
            update.value = initial;
        updates_.push_back(update);
    }
    publish(t);
}

}  // namespace takt::poll
