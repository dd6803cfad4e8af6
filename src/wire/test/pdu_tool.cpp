// Encodes and decodes PDUs given as lines of text, so that another implementation can be held against this
// one (tests/interop/pymodbus_pdus.py). One answer line for each line read:
//
//   encode request|response NUMBERS     the PDU in hex
//   decode request HEX                  NUMBERS
//   decode response REQUEST_HEX HEX     NUMBERS
//   frame rtu|ascii|tcp UNIT TRANSACTION HEX   the frame in hex
//
// NUMBERS are the function code (of an exception with 0x80) and the message's fields in the order of pdu.hpp,
// all decimal; a sequence is preceded by its length. A refused line is answered with "error CODE".
#include <iostream>
#include <sstream>
#include <string>

#include "bytes.hpp"
#include "encode_response.hpp"
#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

// Both take a message's fields one after the other: one reads the numbers into them, the other writes them.
class NumbersIn {
public:
    explicit NumbersIn(std::istream& in) : in_(in) {}

    template <class T>
    void value(T& field) {
        unsigned number = 0;
        in_ >> number;
        field = static_cast<T>(number);
    }
    std::size_t length(std::size_t /*known*/) {
        std::size_t length = 0;
        in_ >> length;
        return length;
    }

private:
    std::istream& in_;
};

class NumbersOut {
public:
    template <class T>
    void value(T& field) {
        text_ += (text_.empty() ? "" : " ") + std::to_string(static_cast<unsigned>(field));
    }
    std::size_t length(std::size_t known) {
        value(known);
        return known;
    }
    [[nodiscard]] const std::string& text() const { return text_; }

private:
    std::string text_;
};

template <class N, class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T>
void fields(N& numbers, T& field) {
    numbers.value(field);
}
template <class N>
void fields(N& numbers, DataAddress& address) {
    numbers.value(address.value);
}
template <class N>
void fields(N& numbers, FileRange& range) {
    numbers.value(range.file);
    numbers.value(range.record);
    numbers.value(range.length);
}
template <class N>
void fields(N& numbers, DeviceIdObject& object) {
    numbers.value(object.id);
    numbers.value(object.length);
}
template <class N, class T, std::size_t Capacity>
void fields(N& numbers, InplaceVector<T, Capacity>& values) {
    values.resize(numbers.length(values.size()));
    for (auto& value : values) fields(numbers, value);
}
template <class N>
void fields(N& numbers, Bits& bits) {
    const std::size_t size = numbers.length(bits.size());
    if (bits.size() != size) bits = Bits(size);
    for (std::size_t i = 0; i < size; ++i) {
        bool on = bits[i];
        numbers.value(on);
        bits.set(i, on);
    }
}

template <class N, class... T>
void all(N& numbers, T&... message_fields) {
    (fields(numbers, message_fields), ...);
}

// The fields of every message behind its function.
template <class N>
struct Fields {
    N& n;

    void operator()(ReadRequest& m) const { all(n, m.start, m.quantity); }
    void operator()(WriteSingleCoilRequest& m) const { all(n, m.address, m.on); }
    void operator()(WriteSingleRegisterRequest& m) const { all(n, m.address, m.value); }
    void operator()(ReadExceptionStatusRequest&) const {}
    void operator()(DiagnosticsRequest& m) const { all(n, m.sub_function, m.data); }
    void operator()(GetCommEventCounterRequest&) const {}
    void operator()(GetCommEventLogRequest&) const {}
    void operator()(WriteMultipleCoilsRequest& m) const { all(n, m.start, m.values); }
    void operator()(WriteMultipleRegistersRequest& m) const { all(n, m.start, m.values); }
    void operator()(ReportServerIdRequest&) const {}
    void operator()(ReadFileRecordRequest& m) const { all(n, m.ranges); }
    void operator()(WriteFileRecordRequest& m) const { all(n, m.ranges, m.values); }
    void operator()(MaskWriteRegisterRequest& m) const { all(n, m.address, m.and_mask, m.or_mask); }
    void operator()(ReadWriteMultipleRegistersRequest& m) const {
        all(n, m.read_start, m.read_quantity, m.write_start, m.values);
    }
    void operator()(ReadFifoQueueRequest& m) const { all(n, m.address); }
    void operator()(ReadDeviceIdRequest& m) const { all(n, m.code, m.object); }
    void operator()(EncapsulatedRequest& m) const { all(n, m.mei_type, m.data); }

    // Of responses that do not repeat their request.
    void operator()(ExceptionResponse& m) const { all(n, m.code); }
    void operator()(ReadBitsResponse& m) const { all(n, m.values); }
    void operator()(ReadRegistersResponse& m) const { all(n, m.values); }
    void operator()(ReadExceptionStatusResponse& m) const { all(n, m.status); }
    void operator()(GetCommEventCounterResponse& m) const { all(n, m.status, m.event_count); }
    void operator()(GetCommEventLogResponse& m) const {
        all(n, m.status, m.event_count, m.message_count, m.events);
    }
    void operator()(WriteMultipleResponse& m) const { all(n, m.start, m.quantity); }
    void operator()(ReportServerIdResponse& m) const { all(n, m.data); }
    void operator()(ReadFileRecordResponse& m) const { all(n, m.lengths, m.values); }
    void operator()(ReadFifoQueueResponse& m) const { all(n, m.values); }
    void operator()(ReadDeviceIdResponse& m) const {
        all(n, m.code, m.conformity, m.more_follows, m.next_object, m.objects, m.text);
    }
};

// The first message type of the variant that carries the function; where several functions share a type, with
// it.
template <class Message, std::size_t I = 0>
Message blank(Function function) {
    if constexpr (I == std::variant_size_v<Message>) {
        return {};
    } else {
        using T = std::variant_alternative_t<I, Message>;
        Message message{std::in_place_index<I>};
        if constexpr (std::is_same_v<T, ReadRequest>) {
            if (function <= Function::read_input_registers) return T{.function = function};
        } else if constexpr (std::is_same_v<T, ReadBitsResponse>) {
            if (function <= Function::read_discrete_inputs) return T{.function = function, .values = {}};
        } else if constexpr (std::is_same_v<T, ReadRegistersResponse>) {
            if (function <= Function::read_input_registers ||
                function == Function::read_write_multiple_registers)
                return T{.function = function, .values = {}};
        } else if constexpr (std::is_same_v<T, WriteMultipleResponse>) {
            if (function == Function::write_multiple_coils || function == Function::write_multiple_registers)
                return T{.function = function};
        } else if constexpr (std::is_same_v<T, ExceptionResponse>) {
            if (static_cast<int>(function) >= 0x80)
                return T{.function = static_cast<Function>(static_cast<int>(function) & 0x7F)};
        } else {
            if (function == T::function) return message;
        }
        return blank<Message, I + 1>(function);
    }
}

template <class Message>
std::string encoded(std::istream& in) {
    int function = 0;
    in >> function;
    auto message = blank<Message>(static_cast<Function>(function));
    NumbersIn numbers(in);
    std::visit(Fields<NumbersIn>{numbers}, message);
    if (!in) return "error numbers";
    const auto pdu = encode(message);
    return pdu ? to_hex(pdu->span()) : "error " + std::string(name(pdu.error().code));
}

template <class Message>
std::string decoded(Result<Message> message) {
    if (!message) return "error " + std::string(name(message.error().code));
    NumbersOut numbers;
    unsigned function = static_cast<unsigned>(function_of(*message));
    if constexpr (std::is_same_v<Message, Response>)
        if (std::holds_alternative<ExceptionResponse>(*message)) function |= 0x80;
    numbers.value(function);
    std::visit(Fields<NumbersOut>{numbers}, *message);
    return numbers.text();
}

ByteVector hex_word(std::istream& in) {
    std::string word;
    in >> word;
    return from_hex(word);
}

std::string framed(std::istream& in) {
    std::string framing;
    int unit = 0;
    std::uint16_t transaction = 0;
    in >> framing >> unit >> transaction;
    for (const Framing known : {Framing::rtu, Framing::ascii, Framing::tcp}) {
        if (name(known) != framing) continue;
        const UnitId id{static_cast<std::uint8_t>(unit)};
        return to_hex(encode_frame(known, id, transaction, hex_word(in)).span());
    }
    return "error framing";
}

std::string answer(const std::string& line) {
    std::istringstream in(line);
    std::string verb;
    in >> verb;
    if (verb == "frame") return framed(in);
    std::string kind;
    in >> kind;
    if (verb == "encode") return kind == "request" ? encoded<Request>(in) : encoded<Response>(in);
    if (verb != "decode") return "error verb";
    const ByteVector request_pdu = hex_word(in);
    const auto request = decode_request(ExactBytes(request_pdu));
    if (kind == "request" || !request) return decoded(request);
    return decoded(decode_response(*request, ExactBytes(hex_word(in))));
}

}  // namespace
}  // namespace takt::wire

int main() {
    std::string line;
    while (std::getline(std::cin, line)) std::cout << takt::wire::answer(line) << std::endl;
    return 0;
}
