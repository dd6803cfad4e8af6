#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "generators.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::wire {
namespace pdu_property_test {

template <class T>
bool holds(const Result<T>& result, const T& value) {
    return result.has_value() && *result == value;
}

RC_GTEST_PROP(PduProperty, RequestsComeBack, ()) {
    for (int kind = 0; kind < kRequestKinds; ++kind) {
        const Request request = any_request(kind);
        const auto pdu = encode(request);
        RC_ASSERT(pdu.has_value());
        RC_ASSERT((*pdu)[0] == static_cast<std::uint8_t>(function_of(request)));
        RC_ASSERT(holds(decode_request(ExactBytes(pdu->span())), request));
    }
}

RC_GTEST_PROP(PduProperty, AnswersComeBackAndAreNotLongerThanForetold, ()) {
    for (int kind = 0; kind < kRequestKinds; ++kind) {
        const Request request = any_request(kind);
        const Response response = any_answer(request);
        const auto pdu = encode(response);
        RC_ASSERT(pdu.has_value());
        RC_ASSERT((*pdu)[0] == static_cast<std::uint8_t>(function_of(request)));
        RC_ASSERT(pdu->size() <= prepare(request)->shape().response_length);
        RC_ASSERT(holds(decode_response(request, ExactBytes(pdu->span())), response));
    }
}

void expect_same(const DeviceIdView& view, const ReadDeviceIdResponse& value) {
    RC_ASSERT(view.conformity() == value.conformity);
    RC_ASSERT(view.more_follows() == value.more_follows);
    RC_ASSERT(view.next_object() == value.next_object);
    DeviceIdTexts texts = view.objects();
    std::size_t first = 0;
    for (const DeviceIdObject& object : value.objects) {
        RC_ASSERT(!texts.empty());
        const DeviceIdText text = texts.take();
        RC_ASSERT(text.id == object.id);
        RC_ASSERT(to_hex(text.text) == to_hex(value.text.span().subspan(first, object.length)));
        first += object.length;
    }
    RC_ASSERT(texts.empty());
}

// The response as a master sees it, without a copy, against the response as a value of its own.
RC_GTEST_PROP(PduProperty, AViewAcceptsWhatCanBeDecodedAndShowsTheSame, ()) {
    for (int kind = 0; kind < kRequestKinds; ++kind) {
        const Request request = any_request(kind);
        const auto prepared = prepare(request);
        RC_ASSERT(prepared.has_value());
        RC_ASSERT(PreparedRequest(prepared->pdu()).shape() == prepared->shape());
        const auto good = encode(any_answer(request));
        const ExactBytes bytes = damaged(*good);
        const auto view = decode_response(prepared->shape(), prepared->pdu(), bytes);
        const auto value = decode_response(request, bytes);
        RC_ASSERT(view.has_value() == value.has_value());
        if (!view) continue;
        if (const auto* exception = std::get_if<ExceptionResponse>(&*value))
            RC_ASSERT(view->exception() == static_cast<std::uint8_t>(exception->code));
        if (const auto* registers = std::get_if<ReadRegistersResponse>(&*value)) {
            RC_ASSERT(view->registers().size() == registers->values.size());
            for (std::size_t i = 0; i < registers->values.size(); ++i)
                RC_ASSERT(view->registers()[i] == registers->values[i]);
        }
        if (const auto* bits = std::get_if<ReadBitsResponse>(&*value)) {
            RC_ASSERT(view->bits().size() == bits->values.size());
            for (std::size_t i = 0; i < bits->values.size(); ++i)
                RC_ASSERT(view->bits()[i] == bits->values[i]);
        }
        if (const auto* queue = std::get_if<ReadFifoQueueResponse>(&*value))
            RC_ASSERT(view->registers().size() == queue->values.size());
        const auto* id = std::get_if<ReadDeviceIdResponse>(&*value);
        RC_ASSERT(view->device_id().has_value() == (id != nullptr));
        if (id) expect_same(*view->device_id(), *id);
    }
}

RC_GTEST_PROP(PduProperty, LengthsOfReadsAndWritesAreTheFormulas, ()) {
    for (int kind = 0; kind < kRequestKinds; ++kind) {
        const Request request = any_request(kind);
        const Function function = function_of(request);
        if (max_items(Framing::rtu, function) == 0) continue;
        std::size_t quantity = 1;
        std::size_t written = 0;
        if (const auto* read = std::get_if<ReadRequest>(&request)) quantity = read->quantity;
        if (const auto* coils = std::get_if<WriteMultipleCoilsRequest>(&request))
            quantity = coils->values.size();
        if (const auto* registers = std::get_if<WriteMultipleRegistersRequest>(&request))
            quantity = registers->values.size();
        if (const auto* both = std::get_if<ReadWriteMultipleRegistersRequest>(&request)) {
            quantity = both->read_quantity;
            written = both->values.size();
        }
        RC_ASSERT(encode(request)->size() == request_pdu_length(function, quantity, written));
        RC_ASSERT(encode(any_answer(request))->size() == response_pdu_length(function, quantity));
        RC_ASSERT(prepare(request)->shape().response_length == response_pdu_length(function, quantity));
    }
}

// Nothing is guessed or passed over: what was read is written as the same bytes, but for the unused bits of
// the last byte of coils.
RC_GTEST_PROP(PduProperty, WhatIsReadFromAnyBytesIsAllOfTheirMeaning, ()) {
    for (int kind = 0; kind < kRequestKinds; ++kind) {
        const ExactBytes bytes = damaged(*encode(any_request(kind)));
        const auto request = decode_request(bytes);
        if (!request) continue;
        const auto again = encode(*request);
        RC_ASSERT(again.has_value());
        RC_ASSERT(holds(decode_request(again->span()), *request));
        if (!std::holds_alternative<WriteMultipleCoilsRequest>(*request))
            RC_ASSERT(to_hex(again->span()) == to_hex(bytes));
    }
}

RC_GTEST_PROP(PduProperty, WhatIsReadFromAnyAnswerIsAllOfItsMeaning, ()) {
    for (int kind = 0; kind < kRequestKinds; ++kind) {
        const Request request = any_request(kind);
        const ExactBytes bytes = damaged(*encode(any_answer(request)));
        (void)decode_response(request, bytes);
        const auto response = decode_response(bytes);
        // the quantity of a multiple write is not judged without its request
        if (!response || std::holds_alternative<WriteMultipleResponse>(*response)) continue;
        RC_ASSERT(to_hex(encode(*response)->span()) == to_hex(bytes));
    }
}

}  // namespace pdu_property_test
}  // namespace takt::wire
