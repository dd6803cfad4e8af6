// The encapsulated interface 0x2B: device identification (MEI type 14) and everything else unread
// (MODBUS Application Protocol V1.1b3, sections 6.19..6.21).
#include "codec.hpp"

namespace takt::wire::codec {
namespace {

Result<void> check_code(std::uint8_t code) {
    return check_range(code, 1, 4);
}

EncapsulatedRequest decode_other(std::uint8_t mei_type, Reader& in) {
    EncapsulatedRequest message{.mei_type = mei_type, .data = {}};
    message.data.append(in.take(in.left()));
    return message;
}

Result<Response> decode_device_id(Reader& in) {
    ReadDeviceIdResponse response;
    response.code = in.u8();
    response.conformity = in.u8();
    const std::uint8_t more = in.u8();
    response.next_object = in.u8();
    const std::size_t count = in.u8();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_code(response.code));
    if (more != 0 && more != kMoreFollows) return fail(Code::malformed, more);
    response.more_follows = more == kMoreFollows;
    TAKT_CHECK(check_range(count, 0, response.objects.capacity()));
    for (std::size_t i = 0; i < count; ++i) {
        const DeviceIdObject object{in.u8(), in.u8()};
        const Bytes text = in.take(object.length);
        TAKT_CHECK(in.check());
        response.objects.push_back(object);
        response.text.append(text);
    }
    TAKT_CHECK(in.finish());
    return response;
}

}  // namespace

Result<Pdu> encode(const ReadDeviceIdRequest& request) {
    TAKT_CHECK(check_code(request.code));
    Writer out(Function::encapsulated_interface);
    return out.u8(kReadDeviceId).u8(request.code).u8(request.object).pdu();
}

// Device identification has a message type of its own and must not be encoded as raw data.
Result<Pdu> encode(const EncapsulatedRequest& request) {
    if (request.mei_type == kReadDeviceId) return fail(Code::malformed, kReadDeviceId);
    return Writer(request.function).u8(request.mei_type).bytes(request.data.span()).pdu();
}
Result<Request> decode_encapsulated_request(Reader in) {
    const std::uint8_t mei_type = in.u8();
    TAKT_CHECK(in.check());
    if (mei_type != kReadDeviceId) return decode_other(mei_type, in);
    const ReadDeviceIdRequest request{in.u8(), in.u8()};
    TAKT_CHECK(in.finish());
    TAKT_CHECK(check_code(request.code));
    return request;
}

Result<Response> decode_encapsulated_response(Reader in) {
    const std::uint8_t mei_type = in.u8();
    TAKT_CHECK(in.check());
    if (mei_type != kReadDeviceId) return decode_other(mei_type, in);
    return decode_device_id(in);
}

}  // namespace takt::wire::codec
