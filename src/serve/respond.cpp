// The functions that reach the banks (MODBUS Application Protocol V1.1b3, sections 6.1..6.6, 6.11, 6.12,
// 6.16, 6.17).
#include <array>

#include "pdu_bytes.hpp"
#include "takt/base/assert.hpp"
#include "takt/serve/server.hpp"

namespace takt::serve {
namespace {

using wire::Area;
using wire::ExceptionCode;
using wire::Function;

/// Returns nothing if the access is allowed.
using Refusal = std::optional<ExceptionCode>;

constexpr std::uint16_t kMostBitsRead = 2000;
constexpr std::uint16_t kMostBitsWritten = 1968;
constexpr std::uint16_t kMostRegistersRead = 125;
constexpr std::uint16_t kMostRegistersWritten = 123;
constexpr std::uint16_t kMostRegistersWrittenAndRead = 121;
constexpr std::uint16_t kOn = 0xFF00;

bool between_1_and(std::uint16_t most, std::uint16_t quantity) {
    return quantity >= 1 && quantity <= most;
}

/// Whether the byte at `at` equals the number of bytes behind it and `count`.
bool counted(Bytes request, std::size_t at, std::size_t count) {
    return request.size() > at && request[at] == count && request.size() == at + 1 + count;
}

/// Executes one request on one unit.
class Execution {
public:
    Execution(Unit& unit, const Context& context, Bytes request, wire::Pdu& out)
        : unit_(unit),
          context_(context),
          request_(request),
          function_(static_cast<Function>(request[0])),
          out_(out) {}

    /// @param known  set to false for any other function
    Refusal run(bool& known) {
        switch (function_) {
            case Function::read_coils: return read_bits(Area::coil);
            case Function::read_discrete_inputs: return read_bits(Area::discrete_input);
            case Function::read_holding_registers: return read_registers(Area::holding_register);
            case Function::read_input_registers: return read_registers(Area::input_register);
            case Function::write_single_coil: return write_coil();
            case Function::write_single_register: return write_register();
            case Function::write_multiple_coils: return write_coils();
            case Function::write_multiple_registers: return write_registers();
            case Function::mask_write_register: return mask_register();
            case Function::read_write_multiple_registers: return write_and_read();
            default: known = false; return {};
        }
    }

private:
    Refusal read_bits(Area area) {
        if (request_.size() != 5 || !between_1_and(kMostBitsRead, word(request_, 3)))
            return ExceptionCode::illegal_data_value;
        const Access access = at(1, area, word(request_, 3), false);
        if (const Refusal refusal = admit(access)) return refusal;
        begin_read((access.count + 7U) / 8);
        for (std::uint32_t i = 0; i < access.count; i += 8) out_.push_back(bits_from(access, i));
        return {};
    }

    Refusal read_registers(Area area) {
        if (request_.size() != 5 || !between_1_and(kMostRegistersRead, word(request_, 3)))
            return ExceptionCode::illegal_data_value;
        const Access access = at(1, area, word(request_, 3), false);
        if (const Refusal refusal = admit(access)) return refusal;
        load(access);
        return {};
    }

    Refusal write_coil() {
        if (request_.size() != 5 || (word(request_, 3) != kOn && word(request_, 3) != 0))
            return ExceptionCode::illegal_data_value;
        const std::uint8_t on = request_[3] != 0;
        Access access = at(1, Area::coil, 1, true);
        access.values = Bytes(&on, 1);
        if (const Refusal refusal = write(access)) return refusal;
        out_.assign(request_);
        return {};
    }

    Refusal write_register() {
        if (request_.size() != 5) return ExceptionCode::illegal_data_value;
        Access access = at(1, Area::holding_register, 1, true);
        access.values = request_.subspan(3);
        if (const Refusal refusal = write(access)) return refusal;
        out_.assign(request_);
        return {};
    }

    Refusal write_coils() { return write_many(Area::coil, kMostBitsWritten); }
    Refusal write_registers() { return write_many(Area::holding_register, kMostRegistersWritten); }

    Refusal write_many(Area area, std::uint16_t most) {
        constexpr std::size_t kCountAt = 5;
        if (request_.size() <= kCountAt) return ExceptionCode::illegal_data_value;
        const std::uint16_t quantity = word(request_, 3);
        const unsigned bytes = wire::is_bit_area(area) ? (quantity + 7U) / 8 : 2U * quantity;
        if (!between_1_and(most, quantity) || !counted(request_, kCountAt, bytes))
            return ExceptionCode::illegal_data_value;
        Access access = at(1, area, quantity, true);
        access.values = request_.subspan(kCountAt + 1);
        if (const Refusal refusal = write(access)) return refusal;
        out_.assign(request_.first(kCountAt));
        return {};
    }

    Refusal mask_register() {
        if (request_.size() != 7) return ExceptionCode::illegal_data_value;
        Access access = at(1, Area::holding_register, 1, true);
        if (!unit_.banks.writable(access.area, access.start, 1)) return ExceptionCode::illegal_data_address;
        std::array<std::uint8_t, 2> result = masked(access.start);
        access.values = result;
        if (!unit_.banks.admits(access.area, access.start, 1, result))
            return ExceptionCode::illegal_data_value;
        if (const Refusal refusal = ask(access)) return refusal;
        result = masked(access.start);  // the hook may have updated the register
        store(access);
        out_.assign(request_);
        return {};
    }

    std::array<std::uint8_t, 2> masked(std::uint16_t address) const {
        const unsigned old = unit_.banks.holding_registers.get(address);
        const unsigned and_mask = word(request_, 3);
        const unsigned value = (old & and_mask) | (word(request_, 5) & ~and_mask);
        return {static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
    }

    Refusal write_and_read() {
        constexpr std::size_t kCountAt = 9;
        if (request_.size() <= kCountAt) return ExceptionCode::illegal_data_value;
        const std::uint16_t written = word(request_, 7);
        if (!between_1_and(kMostRegistersRead, word(request_, 3)) ||
            !between_1_and(kMostRegistersWrittenAndRead, written) ||
            !counted(request_, kCountAt, 2U * written))
            return ExceptionCode::illegal_data_value;
        const Access read = at(1, Area::holding_register, word(request_, 3), false);
        Access write = at(5, Area::holding_register, written, true);
        write.values = request_.subspan(kCountAt + 1);
        const Banks& banks = unit_.banks;
        if (!banks.writable(write.area, write.start, write.count) ||
            !banks.readable(read.area, read.start, read.count))
            return ExceptionCode::illegal_data_address;
        if (!banks.admits(write.area, write.start, write.count, write.values))
            return ExceptionCode::illegal_data_value;
        if (const Refusal refusal = ask(write)) return refusal;
        if (const Refusal refusal = ask(read)) return refusal;
        store(write);
        load(read);
        return {};
    }

    Access at(std::size_t start_at, Area area, std::uint16_t count, bool write) const {
        return {function_, area, word(request_, start_at), count, write, {}};
    }

    Refusal ask(const Access& access) {
        return unit_.hooks ? unit_.hooks->before(context_, access) : Refusal{};
    }

    Refusal admit(const Access& access) {
        const Banks& banks = unit_.banks;
        const bool possible = access.write ? banks.writable(access.area, access.start, access.count)
                                           : banks.readable(access.area, access.start, access.count);
        if (!possible) return ExceptionCode::illegal_data_address;
        if (access.write && !banks.admits(access.area, access.start, access.count, access.values))
            return ExceptionCode::illegal_data_value;
        return ask(access);
    }

    Refusal write(const Access& access) {
        if (const Refusal refusal = admit(access)) return refusal;
        store(access);
        return {};
    }

    void store(const Access& access) {
        for (std::uint16_t i = 0; i < access.count; ++i) {
            const auto address = static_cast<std::uint16_t>(access.start + i);
            if (wire::is_bit_area(access.area))
                unit_.banks.set_bit(access.area, address, (access.values[i / 8U] >> (i % 8U) & 1) != 0);
            else
                unit_.banks.holding_registers.set(address, word(access.values, 2U * i));
        }
        if (unit_.hooks) unit_.hooks->written(context_, access);
    }

    void begin_read(std::size_t bytes) {
        out_.push_back(request_[0]);
        out_.push_back(static_cast<std::uint8_t>(bytes));
    }

    void load(const Access& access) {
        begin_read(2U * access.count);
        const RegisterBank& bank = unit_.banks.registers(access.area);
        for (std::uint16_t i = 0; i < access.count; ++i)
            put_word(out_, bank.get(static_cast<std::uint16_t>(access.start + i)));
    }

    std::uint8_t bits_from(const Access& access, std::uint32_t first) const {
        unsigned byte = 0;
        for (std::uint32_t i = first; i < first + 8 && i < access.count; ++i)
            if (unit_.banks.bit(access.area, static_cast<std::uint16_t>(access.start + i)))
                byte |= 1U << (i - first);
        return static_cast<std::uint8_t>(byte);
    }

    Unit& unit_;
    const Context& context_;
    Bytes request_;
    Function function_;
    wire::Pdu& out_;
};

bool writes_only(std::uint8_t function) {
    switch (static_cast<Function>(function)) {
        case Function::write_single_coil:
        case Function::write_single_register:
        case Function::write_multiple_coils:
        case Function::write_multiple_registers:
        case Function::mask_write_register: return true;
        default: return false;
    }
}

bool extended(Unit& unit, const Context& context, Bytes pdu, Answer& answer) {
    for (Extension* extension : unit.extensions)
        if (extension->handle(unit, context, pdu, answer)) return true;
    return false;
}

void execute(Unit& unit, const Context& context, Bytes pdu, Answer& answer) {
    bool known = true;
    Refusal refusal;
    if (!context.broadcast || writes_only(pdu[0]))
        refusal = Execution(unit, context, pdu, answer.pdu).run(known);
    else
        known = false;
    if (!known && ((pdu[0] & 0x80) != 0 || !extended(unit, context, pdu, answer)))
        refusal = ExceptionCode::illegal_function;
    if (refusal) refuse(answer, pdu[0], *refusal);
}

}  // namespace

wire::Pdu exception_to(std::uint8_t function, ExceptionCode code) {
    return {static_cast<std::uint8_t>(function | 0x80), static_cast<std::uint8_t>(code)};
}

Answer respond(Unit& unit, const Context& context, Bytes pdu) {
    Answer answer;
    respond(unit, context, pdu, answer);
    return answer;
}

void respond(Unit& unit, const Context& context, Bytes pdu, Answer& answer) {
    TAKT_ASSERT(!pdu.empty() && pdu.size() <= wire::kMaxPdu);
    answer.kind = Answer::Kind::silence;
    answer.delay = {};
    answer.pdu.clear();
    bool admitted = true;
    for (Extension* extension : unit.extensions) admitted = extension->admit(context, pdu) && admitted;
    if (admitted) {
        answer.kind = Answer::Kind::response;
        execute(unit, context, pdu, answer);
    }
    for (Extension* extension : unit.extensions) extension->done(context, pdu, answer);
}

}  // namespace takt::serve
