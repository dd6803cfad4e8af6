// The devices of a table whose rows belong to several of them.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "takt/model/document.hpp"
#include "yaml/reporter.hpp"

namespace takt::file {

/// Names the devices of rows that have several unit addresses but no names of devices: `Meters 1`, `Meters 2`
/// for the base `Meters`. Other rows stay.
void name_devices(std::vector<model::Node>& rows, const std::string& base);

/// Names of variables are unique in a project. A name that several devices have becomes `Device.Name` in each
/// of them, with one warning, and `Device Address.Name` where devices have one name.
/// @param devices  the name, the address and the variables of each
/// @param taken    names of other devices of the project
struct NamedVariables {
    std::string device;
    std::string address;
    model::Node* variables = nullptr;
};
void qualify_names(std::vector<NamedVariables> devices, const std::set<std::string>& taken,
                   Reporter& reporter);

}  // namespace takt::file
