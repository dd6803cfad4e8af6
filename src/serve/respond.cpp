#include <expected>
#include <variant>

#include "takt/base/assert.hpp"
#include "takt/serve/server.hpp"

namespace takt::serve {
namespace {

using wire::Area;
using wire::ExceptionCode;
using wire::Function;

using Outcome = std::expected<wire::Response, ExceptionCode>;
using Allowed = std::expected<void, ExceptionCode>;

bool is_served(Function function) {
    switch (function) {
        case Function::read_coils:
        case Function::read_discrete_inputs:
        case Function::read_holding_registers:
        case Function::read_input_registers:
        case Function::write_single_coil:
        case Function::write_single_register:
        case Function::write_multiple_coils:
        case Function::write_multiple_registers:
        case Function::mask_write_register:
        case Function::read_write_multiple_registers: return true;
        default: return false;
    }
}

template <class Values>
std::uint16_t count_of(const Values& values) {
    return static_cast<std::uint16_t>(values.size());
}

/// Runs one decoded request on one unit.
class Execution {
public:
    Execution(Unit& unit, const Context& context) : unit_(unit), context_(context) {}

    Outcome operator()(const wire::ReadRequest& request) {
        switch (request.function) {
            case Function::read_coils: return read_bits(request, Area::coil, unit_.banks.coils);
            case Function::read_discrete_inputs:
                return read_bits(request, Area::discrete_input, unit_.banks.discrete_inputs);
            case Function::read_input_registers:
                return read_registers(request, Area::input_register, unit_.banks.input_registers);
            default: return read_registers(request, Area::holding_register, unit_.banks.holding_registers);
        }
    }

    Outcome operator()(const wire::WriteSingleCoilRequest& request) {
        const Access access{Function::write_single_coil, Area::coil, request.address.value, 1, true};
        if (auto allowed = admit(unit_.banks.coils, access); !allowed)
            return std::unexpected(allowed.error());
        unit_.banks.coils.set(access.start, request.on);
        tell(access);
        return wire::WriteSingleCoilResponse{request.address, request.on};
    }

    Outcome operator()(const wire::WriteSingleRegisterRequest& request) {
        const Access access{Function::write_single_register, Area::holding_register, request.address.value, 1,
                            true};
        if (auto allowed = admit(holding(), access); !allowed) return std::unexpected(allowed.error());
        holding().set(access.start, request.value);
        tell(access);
        return wire::WriteSingleRegisterResponse{request.address, request.value};
    }

    Outcome operator()(const wire::WriteMultipleCoilsRequest& request) {
        const Access access{Function::write_multiple_coils, Area::coil, request.start.value,
                            count_of(request.values), true};
        if (auto allowed = admit(unit_.banks.coils, access); !allowed)
            return std::unexpected(allowed.error());
        for (std::uint16_t i = 0; i < access.count; ++i)
            unit_.banks.coils.set(static_cast<std::uint16_t>(access.start + i), request.values[i]);
        tell(access);
        return wire::WriteMultipleResponse{access.function, request.start, access.count};
    }

    Outcome operator()(const wire::WriteMultipleRegistersRequest& request) {
        const Access access{Function::write_multiple_registers, Area::holding_register, request.start.value,
                            count_of(request.values), true};
        if (auto allowed = admit(holding(), access); !allowed) return std::unexpected(allowed.error());
        store(access, request.values);
        return wire::WriteMultipleResponse{access.function, request.start, access.count};
    }

    Outcome operator()(const wire::MaskWriteRegisterRequest& request) {
        const Access access{Function::mask_write_register, Area::holding_register, request.address.value, 1,
                            true};
        if (auto allowed = admit(holding(), access); !allowed) return std::unexpected(allowed.error());
        const unsigned kept = holding().get(access.start) & request.and_mask;
        const unsigned added = request.or_mask & ~unsigned{request.and_mask};
        holding().set(access.start, static_cast<std::uint16_t>(kept | added));
        tell(access);
        return wire::MaskWriteRegisterResponse{request.address, request.and_mask, request.or_mask};
    }

    Outcome operator()(const wire::ReadWriteMultipleRegistersRequest& request) {
        const Function function = Function::read_write_multiple_registers;
        const Access write{function, Area::holding_register, request.write_start.value,
                           count_of(request.values), true};
        const Access read{function, Area::holding_register, request.read_start.value, request.read_quantity,
                          false};
        if (!writable(holding(), write.start, write.count) || !readable(holding(), read.start, read.count))
            return std::unexpected(ExceptionCode::illegal_data_address);
        for (const Access& access : {write, read})
            if (auto allowed = ask(access); !allowed) return std::unexpected(allowed.error());
        store(write, request.values);
        return load(read, holding());
    }

    template <class Other>
    Outcome operator()(const Other&) {
        return std::unexpected(ExceptionCode::illegal_function);
    }

private:
    RegisterBank& holding() { return unit_.banks.holding_registers; }

    Allowed ask(const Access& access) {
        if (!unit_.hooks) return {};
        if (const auto refused = unit_.hooks->before(context_, access)) return std::unexpected(*refused);
        return {};
    }

    template <class Bank>
    Allowed admit(const Bank& bank, const Access& access) {
        const bool possible = access.write ? writable(bank, access.start, access.count)
                                           : readable(bank, access.start, access.count);
        if (!possible) return std::unexpected(ExceptionCode::illegal_data_address);
        return ask(access);
    }

    void tell(const Access& access) {
        if (unit_.hooks) unit_.hooks->written(context_, access);
    }

    void store(const Access& access, const wire::Registers& values) {
        for (std::uint16_t i = 0; i < access.count; ++i)
            holding().set(static_cast<std::uint16_t>(access.start + i), values[i]);
        tell(access);
    }

    static wire::Response load(const Access& access, const RegisterBank& bank) {
        wire::ReadRegistersResponse response{access.function, {}};
        for (std::uint16_t i = 0; i < access.count; ++i)
            response.values.push_back(bank.get(static_cast<std::uint16_t>(access.start + i)));
        return response;
    }

    Outcome read_registers(const wire::ReadRequest& request, Area area, const RegisterBank& bank) {
        const Access access{request.function, area, request.start.value, request.quantity, false};
        if (auto allowed = admit(bank, access); !allowed) return std::unexpected(allowed.error());
        return load(access, bank);
    }

    Outcome read_bits(const wire::ReadRequest& request, Area area, const BitBank& bank) {
        const Access access{request.function, area, request.start.value, request.quantity, false};
        if (auto allowed = admit(bank, access); !allowed) return std::unexpected(allowed.error());
        wire::ReadBitsResponse response{request.function, {}};
        for (std::uint16_t i = 0; i < access.count; ++i)
            response.values.push_back(bank.get(static_cast<std::uint16_t>(access.start + i)));
        return response;
    }

    Unit& unit_;
    const Context& context_;
};

}  // namespace

wire::Pdu exception_to(std::uint8_t function, ExceptionCode code) {
    return {static_cast<std::uint8_t>(function | 0x80), static_cast<std::uint8_t>(code)};
}

wire::Pdu respond(Unit& unit, const Context& context, Bytes pdu) {
    TAKT_ASSERT(!pdu.empty());
    if (!is_served(static_cast<Function>(pdu[0])))
        return exception_to(pdu[0], ExceptionCode::illegal_function);
    const auto request = wire::decode_request(pdu);
    if (!request) return exception_to(pdu[0], ExceptionCode::illegal_data_value);
    const Outcome outcome = std::visit(Execution(unit, context), *request);
    if (!outcome) return exception_to(pdu[0], outcome.error());
    const auto encoded = wire::encode(*outcome);
    TAKT_ASSERT(encoded.has_value());
    return *encoded;
}

}  // namespace takt::serve
