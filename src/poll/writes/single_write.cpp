#include "writes/single_write.hpp"

#include "takt/plan/request_job.hpp"

namespace takt::poll {

Result<SingleWrite> single_write_of(const model::Device& device, const model::Variable& variable,
                                    const Written& written) {
    SingleWrite write{.function = plan::command_function(device, variable)};
    wire::Request request;
    if (!is_register_bit(variable)) {
        WrittenItems items(write.function);
        TAKT_CHECK(items.add(variable, written.words));
        TAKT_TRY(request, items.request());
    } else if (device.fc22) {
        write.bits.add(variable, written.words);
        request = mask_request(DataAddress{variable.start()}, write.bits);
    } else if (device.read_modify_write) {
        write.modifies = true;
        write.bits.add(variable, written.words);
        request = plan::read_before_write(variable.start(), 1);
    } else {
        return fail(Code::unsupported, variable.name);
    }
    TAKT_TRY(write.request, wire::prepare(request));
    if (variable.verify) write.verify = std::make_unique<ReadBack>(read_back_of(variable));
    return write;
}

wire::Request second_step(const SingleWrite& write, const model::Variable& variable, std::uint16_t old) {
    return register_request(write.function, DataAddress{variable.start()}, write.bits.in(old));
}

}  // namespace takt::poll
