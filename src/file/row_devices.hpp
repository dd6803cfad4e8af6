// The devices of a table whose rows belong to several of them.
#pragma once

#include <string>
#include <vector>

#include "reporter.hpp"
#include "takt/model/document.hpp"

namespace takt::file {

/// Names the devices of rows that have several unit addresses but no names of devices: `Meters 1`, `Meters 2`
/// for the base `Meters`. Other rows stay.
void name_devices(std::vector<model::Node>& rows, const std::string& base);

/// Names of variables are unique in a project. A name that several devices have becomes `Device.Name` in each
/// of them, with one warning.
/// @param devices  the name and the variables of each
struct NamedVariables {
    std::string device;
    model::Node* variables = nullptr;
};
void qualify_names(const std::vector<NamedVariables>& devices, Reporter& reporter);

}  // namespace takt::file
