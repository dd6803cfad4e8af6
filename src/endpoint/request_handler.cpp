#include "takt/endpoint/request_handler.hpp"

#include <utility>

#include "takt/line/loop.hpp"

namespace takt::endpoint {

using Decision = serve::AccessControl::Decision;

RequestHandler::RequestHandler(serve::Responder* own, std::vector<UnitId> units,
                               std::shared_ptr<sim::AnswerFaults> faults)
    : own_(own), units_(std::move(units)), faults_(std::move(faults)), audit_(units_) {
    pending_.set_observer(
        [this](serve::Token token, Bytes pdu) { audit_.on_answer(line::now(), token, pdu); });
}

serve::Answer RequestHandler::handle(const serve::Context& context, Bytes pdu) {
    if (!faults_) return admit(context, pdu);
    return sim::with_faults(*faults_, context, pdu, [&] { return admit(context, pdu); });
}

serve::Answer RequestHandler::admit(const serve::Context& context, Bytes pdu) {
    if (access_.empty() && !audit_.active()) return dispatch(context, pdu);
    const serve::RequestScope scope = serve::scope_of(pdu);
    const Decision decision = access_.admit(context, units_, serves(context.unit), scope);
    const serve::Answer answer =
        decision == Decision::allowed ? dispatch(context, pdu) : serve::rejection(context, pdu, decision);
    audit_.on_request(context, pdu, scope, decision, answer);
    return answer;
}

serve::Answer RequestHandler::dispatch(const serve::Context& context, Bytes pdu) {
    pending_.begin(pdu);
    return pending_.end(route(context, pdu));
}

serve::Answer RequestHandler::route(const serve::Context& context, Bytes pdu) {
    if (context.broadcast) {
        if (own_) (void)own_->handle(context, pdu);
        if (routes_.has(context.unit)) (void)relay(context, pdu);
        return {};
    }
    const bool is_own = own_ && own_->serves(context.unit);
    if (!is_own && routes_.has(context.unit)) return relay(context, pdu);
    if (own_) return own_->handle(context, pdu);
    return serve::Answer::response(
        serve::exception_to(pdu[0], wire::ExceptionCode::gateway_path_unavailable));
}

serve::Answer RequestHandler::relay(const serve::Context& context, Bytes pdu) {
    const serve::Token token = pending_.put_off();
    const auto answer = routes_.ask(context, pdu, token);
    if (!answer) return serve::Answer::pending(token);
    pending_.done(token);
    return serve::Answer::response(*answer);
}

void RequestHandler::forget(serve::Token token) {
    audit_.on_forget(line::now(), token);
    routes_.forget(token);
    pending_.forget(token);
}

}  // namespace takt::endpoint
