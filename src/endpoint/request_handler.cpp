#include "takt/endpoint/request_handler.hpp"

#include <utility>

#include "takt/line/loop.hpp"

namespace takt::endpoint {
namespace {

using Decision = serve::AccessControl::Decision;

constexpr serve::UnitRange kEveryUnitOfALine{1, 255};

serve::UnitRange only(UnitId unit) {
    return {unit.value, unit.value};
}

}  // namespace

RequestHandler::RequestHandler(serve::Responder* own, std::vector<UnitId> units,
                               std::shared_ptr<sim::AnswerFaults> faults, std::string line)
    : own_(own), units_(std::move(units)), faults_(std::move(faults)), site_{std::move(line), units_} {
    pending_.set_observer(
        [this](serve::Token token, Bytes pdu) { audit_.on_answer(line::now(), token, pdu); });
}

serve::Answer RequestHandler::handle(const serve::Context& context, const wire::RequestView& request) {
    if (!faults_) return admit(context, request);
    return sim::with_faults(*faults_, site_, context, request, [&] { return admit(context, request); });
}

RequestPath RequestHandler::path_of(const serve::Context& context) const {
    RequestPath path;
    const bool own_unit = own_ && own_->serves(context.unit);
    if (routes_.has(context.unit) && (context.broadcast || !own_unit))
        path.target = routes_.target(context.unit);
    path.own = own_ && (context.broadcast || !path.target);
    return path;
}

// Without a path the request is decided as if the unit existed: a client learns nothing of denied units.
std::span<const serve::UnitRange> RequestHandler::executors(const serve::Context& context,
                                                            const RequestPath& path) {
    executors_.clear();
    const bool to_default = context.unit.value == 0 || context.unit.value == 255;
    if (context.broadcast) {
        for (const UnitId unit : units_)
            if (path.own && own_->serves(unit)) executors_.push_back(only(unit));
    } else if (!path.target) {
        const bool first = path.own && to_default && !own_->serves(context.unit) && !units_.empty();
        executors_.push_back(only(first ? units_.front() : context.unit));
    }
    if (path.target)
        executors_.push_back(path.target->broadcast ? kEveryUnitOfALine : only(path.target->unit));
    return executors_;
}

serve::Answer RequestHandler::admit(const serve::Context& context, const wire::RequestView& request) {
    RequestPath path = path_of(context);
    if (access_.empty() && !audit_.active()) return dispatch(context, request, path);
    const Decision decision = access_.decide(context, executors(context, path), request);
    const serve::Answer answer = decision == Decision::allowed ? dispatch(context, request, path)
                                                               : serve::rejection(context, request, decision);
    audit_.on_request({context, request, path}, decision, answer);
    return answer;
}

serve::Answer RequestHandler::dispatch(const serve::Context& context, const wire::RequestView& request,
                                       RequestPath& path) {
    pending_.begin(request.pdu());
    return pending_.end(route(context, request, path));
}

serve::Answer RequestHandler::route(const serve::Context& context, const wire::RequestView& request,
                                    RequestPath& path) {
    if (context.broadcast) {
        if (path.own) (void)own_->handle(context, request);
        if (path.target) (void)relay(context, request, path);
        return {};
    }
    if (path.target) return relay(context, request, path);
    if (path.own) return own_->handle(context, request);
    return serve::Answer::response(
        serve::exception_to(request.pdu()[0], wire::ExceptionCode::gateway_path_unavailable));
}

serve::Answer RequestHandler::relay(const serve::Context& context, const wire::RequestView& request,
                                    RequestPath& path) {
    const serve::Token token = pending_.put_off();
    path.rejection = routes_.ask(context, request, token);
    if (path.rejection) {
        pending_.done(token);
        return serve::Answer::response(*path.rejection);
    }
    path.relayed = token;
    Waiting& waiting = relayed_[token];
    waiting.peer.assign(context.peer);
    waiting.role.assign(context.role);
    waiting.unit = context.unit;
    waiting.broadcast = context.broadcast;
    waiting.bytes.assign(request.pdu());
    waiting.request = request.moved_to(waiting.bytes.span());
    return serve::Answer::pending(token);
}

void RequestHandler::set_access(const std::vector<model::AccessRule>& rules) {
    access_.set(rules);
    for (auto& [token, waiting] : relayed_) {
        const serve::Context context{line::now(), waiting.unit, waiting.broadcast, waiting.peer.view(),
                                     waiting.role.view()};
        const RequestPath path = path_of(context);
        const auto decision = access_.decide_again(context, executors(context, path), waiting.request);
        if (decision == Decision::allowed || !routes_.refuse(token, wire::ExceptionCode::illegal_function))
            continue;
        waiting.decision = decision;
        audit_.on_refused_waiting({context, waiting.request, path}, decision);
    }
}

void RequestHandler::on_relayed(const serve::Gateway::Reply& reply) {
    if (const auto waiting = relayed_.extract(reply.token))
        audit_.on_relayed(line::now(), reply, waiting.mapped().decision);
    pending_.complete(reply.token, reply.pdu.span());
}

// An answer that the gateway has already made comes to on_relayed() nevertheless.
void RequestHandler::forget(serve::Token token) {
    if (const auto fate = relayed_.contains(token) ? routes_.forget(token) : std::nullopt) {
        relayed_.erase(token);
        audit_.on_relay_forgotten(line::now(), token, *fate);
    }
    audit_.on_forget(line::now(), token);
    pending_.forget(token);
}

void RequestHandler::forget_relayed() {
    while (!relayed_.empty()) {
        const serve::Token token = relayed_.begin()->first;
        forget(token);
        relayed_.erase(token);
    }
}

}  // namespace takt::endpoint
