// The identification of a unit: functions 17 and 43/14 (MODBUS Application Protocol V1.1b3,
// sections 6.13, 6.21).
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "takt/serve/server.hpp"

namespace takt::serve {

/// An object of 43/14: 0 vendor name, 1 product code, 2 revision (these three make the basic part), 3 vendor
/// URL, 4 product name, 5 model name, 6 user application name (up to 127: the regular part), from 128 on the
/// owner's own (the extended part).
struct IdentificationObject {
    static constexpr std::size_t kMostText = 244;  ///< what fits into an answer alone

    std::uint8_t id = 0;
    std::string_view text;  ///< at most kMostText bytes
};

/// Answers 17 with the server id, the run indicator "on" and what follows it; 43/14 from the objects, the
/// basic, regular and extended stream (in pieces, where they do not fit into one answer) and single objects.
///
/// Without a server id function 17 is exception 1, without objects 43/14 is; so is any other MEI type (13,
/// CANopen). A stream of a higher level than the objects have is answered with the highest they have; one
/// that begins at an unknown object begins at 0. A single unknown object is exception 2, an unknown code
/// exception 3.
class Identification final : public Extension {
public:
    /// All of it lives as long as the extension.
    /// @param objects     sorted by id, each once
    /// @param server_id   at most 249 bytes with `additional`
    explicit Identification(std::span<const IdentificationObject> objects, Bytes server_id = {},
                            Bytes additional = {});

    bool handle(Unit& unit, const Context& context, const wire::RequestView& request,
                Answer& answer) override;

private:
    using Refusal = std::optional<wire::ExceptionCode>;

    void report_server_id(Answer& answer) const;
    Refusal identify(const wire::RequestView& request, Answer& answer) const;
    [[nodiscard]] std::uint8_t level() const;
    void stream(std::uint8_t code, std::uint8_t from, Answer& answer) const;

    std::span<const IdentificationObject> objects_;
    Bytes server_id_;
    Bytes additional_;
};

}  // namespace takt::serve
