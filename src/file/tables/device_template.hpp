// Device templates: the settings and variables of a type of device, with parameters
// (docs/device-templates.md).
//
// A template is a YAML file with the keys of a device. A scalar may contain `$(NAME)`, `$(NAME + 10)` or
// `$(NAME - 10)`, where NAME is a parameter, `device` or `address`. Templates do not contain templates.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "takt/model/document.hpp"
#include "yaml/reporter.hpp"

namespace takt::file {

inline constexpr std::size_t kMostParameterBytes = 250;  ///< of the value of a parameter

/// What a project may still take up.
struct Budget {
    std::size_t nodes = 0;
    std::size_t bytes = 0;
};

/// A checked template.
class DeviceTemplate {
public:
    /// @param root  of its file; `variables` may be the rows of a table
    /// @returns nothing, after reports, if it cannot be used
    static std::optional<DeviceTemplate> create(model::Node root, Reporter& reporter);

    /// Completes a device: its own keys go before those of the template, its variables follow those of the
    /// template. The names of the template's variables get the name of the device and a point in front.
    /// Copied nodes have the locations of the template.
    /// @param path  of the device
    void apply(model::Node& device, const std::string& path, Budget& budget, Reporter& reporter) const;

private:
    explicit DeviceTemplate(model::Node root);

    model::Node root_;
    model::Node defaults_;  // of the parameters; without a value: must be given
    std::size_t nodes_ = 0;
    std::size_t bytes_ = 0;
};

/// Removes the keys `device_template` and `parameters`.
void drop_template_keys(model::Node& device);

}  // namespace takt::file
