// Whether a response, good in itself, is an answer to the request that was sent.
#include "codec.hpp"

namespace takt::wire::codec {
namespace {

Result<void> check_echo(bool same) {
    if (same) return {};
    return fail(Code::unexpected_reply);
}

// Sub-functions whose answer repeats the data of the request: loopback, restart, delimiter and the two
// clears.
bool is_echoed(std::uint16_t sub_function) {
    return sub_function == 0 || sub_function == 1 || sub_function == 3 || sub_function == 10 ||
           sub_function == 20;
}

// One overload for each request whose answer is bound to it by more than the function code.
struct Fit {
    Response& response;

    template <class T>
    [[nodiscard]] T* as() const {
        return std::get_if<T>(&response);
    }

    Result<void> operator()(const ReadRequest& request) const {
        if (auto* bits = as<ReadBitsResponse>()) {
            TAKT_CHECK(check_count(bits->values.byte_count(), (request.quantity + 7U) / 8));
            bits->values = Bits::from_bytes(bits->values.bytes(), request.quantity);
            return {};
        }
        const auto* registers = as<ReadRegistersResponse>();
        TAKT_CHECK(check_echo(registers != nullptr));
        return check_count(2 * registers->values.size(), 2 * std::size_t{request.quantity});
    }
    Result<void> operator()(const ReadWriteMultipleRegistersRequest& request) const {
        const auto* registers = as<ReadRegistersResponse>();
        TAKT_CHECK(check_echo(registers != nullptr));
        return check_count(2 * registers->values.size(), 2 * std::size_t{request.read_quantity});
    }
    Result<void> operator()(const WriteSingleCoilRequest& request) const {
        const auto* echo = as<WriteSingleCoilResponse>();
        return check_echo(echo && echo->address == request.address && echo->on == request.on);
    }
    Result<void> operator()(const WriteSingleRegisterRequest& request) const {
        const auto* echo = as<WriteSingleRegisterResponse>();
        return check_echo(echo && echo->address == request.address && echo->value == request.value);
    }
    Result<void> operator()(const WriteMultipleCoilsRequest& request) const {
        return check_written(request.start, request.values.size());
    }
    Result<void> operator()(const WriteMultipleRegistersRequest& request) const {
        return check_written(request.start, request.values.size());
    }
    Result<void> operator()(const MaskWriteRegisterRequest& request) const {
        const auto* echo = as<MaskWriteRegisterResponse>();
        return check_echo(echo && echo->address == request.address && echo->and_mask == request.and_mask &&
                          echo->or_mask == request.or_mask);
    }
    Result<void> operator()(const DiagnosticsRequest& request) const {
        const auto* answer = as<DiagnosticsResponse>();
        return check_echo(answer && answer->sub_function == request.sub_function &&
                          (!is_echoed(request.sub_function) || answer->data == request.data));
    }
    Result<void> operator()(const ReadFileRecordRequest& request) const {
        const auto* answer = as<ReadFileRecordResponse>();
        TAKT_CHECK(check_echo(answer != nullptr));
        TAKT_CHECK(check_count(answer->lengths.size(), request.ranges.size()));
        for (std::size_t i = 0; i < request.ranges.size(); ++i)
            TAKT_CHECK(check_count(answer->lengths[i], request.ranges[i].length));
        return {};
    }
    Result<void> operator()(const WriteFileRecordRequest& request) const {
        const auto* echo = as<WriteFileRecordResponse>();
        return check_echo(echo && echo->ranges == request.ranges && echo->values == request.values);
    }
    Result<void> operator()(const ReadDeviceIdRequest& request) const {
        const auto* answer = as<ReadDeviceIdResponse>();
        return check_echo(answer && answer->code == request.code);
    }
    Result<void> operator()(const EncapsulatedRequest& request) const {
        const auto* answer = as<EncapsulatedResponse>();
        return check_echo(answer && answer->mei_type == request.mei_type);
    }
    template <class Other>
    Result<void> operator()(const Other& /*request*/) const {
        return {};
    }

    [[nodiscard]] Result<void> check_written(DataAddress start, std::size_t quantity) const {
        const auto* echo = as<WriteMultipleResponse>();
        return check_echo(echo && echo->start == start && echo->quantity == quantity);
    }
};

}  // namespace

Result<void> fit(const Request& request, Response& response) {
    return std::visit(Fit{response}, request);
}

}  // namespace takt::wire::codec
