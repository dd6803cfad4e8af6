// Functions 0x11 and 0x2B/0x0E (MODBUS Application Protocol V1.1b3, sections 6.13 and 6.21).
//
// Response of 0x2B/0x0E: function, 0x0E, read device id code, conformity level, more follows, next object id,
// number of objects, then each object as id, length, text. Codes 1, 2 and 3 stream the objects of a category
// from an id on; an object that does not fit is the first of the next response. Code 4 reads one object.
// Objects are in ascending order.
#include "takt/serve/identification.hpp"

#include <algorithm>
#include <array>

#include "pdu_bytes.hpp"
#include "takt/base/assert.hpp"

namespace takt::serve {
namespace {

using wire::ExceptionCode;
using wire::Function;
using wire::kReadDeviceId;

constexpr std::uint8_t kSingle = 4;
constexpr std::uint8_t kSingleAccess = 0x80;  // conformity level flag: individual access is supported
constexpr std::uint8_t kMore = 0xFF;
constexpr std::uint8_t kRunning = 0xFF;
constexpr std::size_t kMostServerId = 249;
constexpr std::array<std::uint8_t, 4> kLastOfLevel{0, 2, 0x7F, 0xFF};

void put_object(wire::Pdu& pdu, const IdentificationObject& object) {
    pdu.push_back(object.id);
    pdu.push_back(static_cast<std::uint8_t>(object.text.size()));
    for (const char character : object.text) pdu.push_back(static_cast<std::uint8_t>(character));
}

}  // namespace

Identification::Identification(std::span<const IdentificationObject> objects, Bytes server_id,
                               Bytes additional)
    : objects_(objects), server_id_(server_id), additional_(additional) {
    TAKT_ASSERT(server_id.size() + additional.size() <= kMostServerId);
    TAKT_ASSERT(std::ranges::all_of(
        objects, [](const auto& object) { return object.text.size() <= IdentificationObject::kMostText; }));
}

bool Identification::handle(Unit& /*unit*/, const Context& context, const wire::RequestView& request,
                            Answer& answer) {
    if (context.broadcast) return false;
    Refusal refusal;
    switch (request.function()) {
        case Function::report_server_id:
            if (server_id_.empty()) return false;
            if (request.well_formed())
                report_server_id(answer);
            else
                refusal = ExceptionCode::illegal_data_value;
            break;
        case Function::encapsulated_interface:
            if (objects_.empty() || request.sub_function().value_or(kReadDeviceId) != kReadDeviceId)
                return false;
            refusal = identify(request, answer);
            break;
        default: return false;
    }
    if (refusal) refuse(answer, request, *refusal);
    return true;
}

void Identification::report_server_id(Answer& answer) const {
    answer.pdu.push_back(static_cast<std::uint8_t>(Function::report_server_id));
    answer.pdu.push_back(static_cast<std::uint8_t>(server_id_.size() + 1 + additional_.size()));
    answer.pdu.append(server_id_);
    answer.pdu.push_back(kRunning);
    answer.pdu.append(additional_);
}

// 1 basic (objects 0..2), 2 regular (..0x7F), 3 extended (..0xFF): that of the last object.
std::uint8_t Identification::level() const {
    for (std::size_t level = 1; level < kLastOfLevel.size(); ++level)
        if (objects_.back().id <= kLastOfLevel[level]) return static_cast<std::uint8_t>(level);
    return kLastOfLevel.size() - 1;
}

Identification::Refusal Identification::identify(const wire::RequestView& request, Answer& answer) const {
    if (!request.well_formed()) return ExceptionCode::illegal_data_value;
    const std::uint8_t code = request.data()[0];
    const std::uint8_t object = request.data()[1];
    if (code != kSingle) {
        stream(code, object, answer);
        return {};
    }
    const auto found = std::ranges::find(objects_, object, &IdentificationObject::id);
    if (found == objects_.end()) return ExceptionCode::illegal_data_address;
    answer.pdu.assign(request.pdu().first(3));
    answer.pdu.push_back(kSingleAccess | level());
    put_word(answer.pdu, 0);  // more follows: no; next object: none
    answer.pdu.push_back(1);
    put_object(answer.pdu, *found);
    return {};
}

void Identification::stream(std::uint8_t code, std::uint8_t from, Answer& answer) const {
    constexpr std::size_t kMoreAt = 4;
    // An unknown id restarts at the first object; a code above the conformity level gets what there is
    // (section 6.21).
    const std::uint8_t last = kLastOfLevel[std::min(code, level())];
    auto object = std::ranges::find(objects_, from, &IdentificationObject::id);
    if (object == objects_.end() || from > last) object = objects_.begin();
    wire::Pdu& pdu = answer.pdu;
    pdu.push_back(static_cast<std::uint8_t>(Function::encapsulated_interface));
    pdu.push_back(kReadDeviceId);
    pdu.push_back(code);
    pdu.push_back(kSingleAccess | level());
    for (int i = 0; i < 3; ++i) pdu.push_back(0);
    std::uint8_t count = 0;
    for (; object != objects_.end() && object->id <= last; ++object, ++count) {
        if (pdu.size() + 2 + object->text.size() > wire::kMaxPdu) {
            pdu[kMoreAt] = kMore;
            pdu[kMoreAt + 1] = object->id;
            break;
        }
        put_object(pdu, *object);
    }
    pdu[kMoreAt + 2] = count;
}

}  // namespace takt::serve
