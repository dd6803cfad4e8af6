#include "takt/serve/fifos.hpp"

#include <algorithm>

#include "pdu_bytes.hpp"

namespace takt::serve {

bool Fifos::handle(Unit& /*unit*/, const Context& context, const wire::RequestView& request, Answer& answer) {
    using wire::ExceptionCode;
    if (request.function() != wire::Function::read_fifo_queue || context.broadcast) return false;
    if (!request.well_formed()) {
        refuse(answer, request, ExceptionCode::illegal_data_value);
        return true;
    }
    const auto found = std::ranges::find(fifos_, request.accesses().front().start, &Fifo::address);
    if (found == fifos_.end()) {
        refuse(answer, request, ExceptionCode::illegal_data_address);
    } else if (found->values.size() > kMostValues) {
        refuse(answer, request, ExceptionCode::illegal_data_value);
    } else {
        const auto count = static_cast<unsigned>(found->values.size());
        answer.pdu.assign(request.pdu().first(1));
        put_word(answer.pdu, 2 + 2 * count);
        put_word(answer.pdu, count);
        for (const std::uint16_t value : found->values) put_word(answer.pdu, value);
    }
    return true;
}

}  // namespace takt::serve
