// Arbitrary bytes as a request and as a response. Every decoded PDU can be encoded again, and every view of
// the same bytes (typed, in words) handles them. Input: length of the request, request, response.
#include "encode_response.hpp"
#include "input.hpp"
#include "takt/wire/frame_words.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::fuzz {
namespace {

// Padding bits are arbitrary in the input and written as zeros. So only the number of bytes must be equal.
template <class Message>
void same_again(const Message& message, std::size_t size) {
    const auto encoded = wire::encode(message);
    require(encoded.has_value() && encoded->size() == size);
}

void as_response(const wire::Request* request, Bytes pdu) {
    const auto response = request ? wire::decode_response(*request, pdu) : wire::decode_response(pdu);
    if (response) same_again(*response, pdu.size());
    require(!wire::describe_response(UnitId{1}, pdu, request).empty());
}

void try_pair(Bytes request_bytes, Bytes response_bytes) {
    const Exact request_pdu(request_bytes);
    const Exact response_pdu(response_bytes);
    if (!request_bytes.empty()) {
        const auto request = wire::decode_request(request_pdu.span());
        require(!wire::describe_request(UnitId{1}, request_pdu.span()).empty());
        if (request) {
            same_again(*request, request_pdu.span().size());
            if (!response_bytes.empty()) as_response(&*request, response_pdu.span());
        }
    }
    if (!response_bytes.empty()) as_response(nullptr, response_pdu.span());
}

}  // namespace
}  // namespace takt::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace takt;
    fuzz::Input input({data, size});
    const Bytes request = input.bytes(input.byte());
    const Bytes response = input.bytes(wire::kMaxPdu);
    if (request.size() > wire::kMaxPdu) return 0;
    fuzz::try_pair(request, response);
    return 0;
}
