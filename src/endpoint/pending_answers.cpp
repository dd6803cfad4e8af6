#include "takt/endpoint/pending_answers.hpp"

#include <algorithm>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::endpoint {

void PendingAnswers::begin(Bytes request) {
    TAKT_ASSERT(!handling_);
    handling_ = true;
    function_ = request[0];
    current_.reset();
}

serve::Token PendingAnswers::put_off() {
    TAKT_ASSERT(handling_);
    if (!current_) {
        current_ = tokens_.next();
        waiting_.emplace(*current_, Entry{.function = function_});
    }
    ++waiting_.at(*current_).parts;
    return *current_;
}

PendingAnswers::Done PendingAnswers::put_off_until_called() {
    return [token = put_off(), alive = std::weak_ptr(alive_)](const Refusal& refusal) {
        if (const auto self = alive.lock()) (*self)->done(token, refusal);
    };
}

serve::Answer PendingAnswers::end(const serve::Answer& answer) {
    using Kind = serve::Answer::Kind;
    handling_ = false;
    if (!current_) return answer;
    const auto found = waiting_.find(*current_);
    Entry& entry = found->second;
    if (answer.kind == Kind::silence || entry.parts == 0) {
        serve::Answer now = answer;
        if (entry.refusal && answer.kind != Kind::silence)
            now.pdu = serve::exception_to(entry.function, *entry.refusal);
        waiting_.erase(found);
        return now;
    }
    entry.handled = true;
    entry.pdu = answer.pdu;
    return serve::Answer::pending(*current_);
}

// The entry is removed before its answer is delivered: the client may send its next request from inside the
// delivery, and that one may be put off anew.
void PendingAnswers::done(serve::Token token, const Refusal& refusal) {
    const auto found = waiting_.find(token);
    if (found == waiting_.end()) return;
    if (!found->second.refusal) found->second.refusal = refusal;
    if (--found->second.parts > 0 || !found->second.handled) return;
    const auto node = waiting_.extract(found);
    const Entry& entry = node.mapped();
    const wire::Pdu pdu = entry.refusal ? serve::exception_to(entry.function, *entry.refusal) : entry.pdu;
    if (observer_) observer_(token, pdu.span());
    (void)std::ranges::any_of(sinks_,
                              [&](serve::AnswerSink* sink) { return sink->complete(token, pdu.span()); });
}

void PendingAnswers::complete(serve::Token token, Bytes pdu) {
    const auto found = waiting_.find(token);
    if (found == waiting_.end()) return;
    found->second.pdu.assign(pdu);
    done(token);
}

}  // namespace takt::endpoint
