#include "relay/requests.hpp"

#include "takt/wire/broadcast.hpp"

namespace takt::serve {
namespace {

using wire::ExceptionCode;
using wire::Function;

constexpr std::size_t kAnswerToSeveral =
    5;  // length of the response to a write of several items: function, start, quantity

}  // namespace

std::optional<ExceptionCode> refusal(const wire::PreparedRequest& request, bool broadcast) {
    const Function function{request.function()};
    if (request.function() == 0 || wire::is_exception(request.function()))
        return ExceptionCode::illegal_function;
    if (broadcast && !wire::may_be_broadcast(function)) return ExceptionCode::illegal_function;
    if (wire::is_known(function) && !request.shape().decoded) return ExceptionCode::illegal_data_value;
    return std::nullopt;
}

wire::Pdu answer_to_broadcast(Bytes request) {
    const Function function{request[0]};
    const bool several = wire::properties(function).response == wire::ResponseForm::head;
    wire::Pdu answer;
    answer.assign(several ? request.first(kAnswerToSeveral) : request);
    return answer;
}

}  // namespace takt::serve
